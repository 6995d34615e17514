"""From a curve to a fit; see `fit`."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import OptionError
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.estimators.gaps import Gaps
from sigmatau.fitting.components import LINEAR
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.statement import descriptive, half_octaves, no_fit, stated
from sigmatau.fitting.tau_min import LEAST_TIMES, LONGEST_SHARE, Data, best_attempt
from sigmatau.noise.terms import TERMS

__all__ = ["fit"]

_PER_OCTAVE = 8
_LEAST_IN_A_ROW = 1e-3
_ALONE = (
    "no two samples in a row are there: quantization noise cannot be told from a random walk, and is part of what is"
    " stated as one"
)
_LEAST_PAIRS = 0.5
"""Times the cluster size, where samples are missing; a third of a whole record has one pair for each sample of it."""


def fit(
    curve: DeviationCurve,
    *,
    terms: Iterable[str] | None = None,
    tau_min: float | None = None,
    level: float = 0.95,
) -> NoiseFit:
    """Fit the five noise terms to an overlapped Allan deviation curve.

    Generalised least squares with the exact covariance of the variances; the ramp, tested with all noise terms given, is
    taken out of them if it is there; averaging times are left out from the shortest on until the misfit is what chance
    would make; a Gauss-Markov process or a sinusoid is tried where the five terms do not fit; then come test, interval or
    limit of each term, all others given, and the coefficients of those that were found.

    Parameters
    ----------
    curve : DeviationCurve
        Where samples are missing, as `sigmatau.allan` makes it: it knows which, and with them what each term is expected
        to show, see `sigmatau.estimators.gaps`; the covariance is then an approximation. On half octaves, or up to
        eight averaging times an octave; of more, half octaves are used if they are among them, or else eight an octave.
    terms : iterable of str, optional
        Terms that may be there, keys of `sigmatau.noise.terms.TERMS`. Default: all five. A term left out is taken to be
        absent; what it does to the curve is then laid upon the others.
    tau_min : float, optional
        Shortest averaging time to use. Default: found by the misfit. [s]
    level : float
        Probability of the intervals and limits; a term counts as observed if chance alone makes as much in fewer than
        1 − level of all records.

    Returns
    -------
    NoiseFit

    Raises
    ------
    OptionError
        For a curve whose clusters do not overlap: its covariance is not known here; for a level outside 0.5 … 0.999; for
        an unknown term, or no noise term; for a tau_min that leaves fewer than eight averaging times.

    References
    ----------
    S. Guerrier, J. Skaloud, Y. Stebler, M.-P. Victoria-Feser, "Wavelet-variance-based estimation for composite stochastic
    processes", J. Am. Stat. Assoc. 108 (2013), :doi:`10.1080/01621459.2013.799920`, for least squares on variances; the
    covariance is exact here, see `sigmatau.noise.uncertainty.avar_covariance`.
    """
    if curve.overlap != "full":
        raise OptionError("a fit needs overlapping clusters, overlap='full'", option="overlap")
    if not 0.5 <= level <= 0.999:
        raise OptionError(f"{{option}} must lie in 0.5 … 0.999, not {level!r}", option="level")
    wanted = set(TERMS) if terms is None else set(terms)
    if wanted - set(TERMS) or not wanted & set(LINEAR):
        raise OptionError(
            f"{{option}} must be of {', '.join(TERMS)}, one of them a noise, not {sorted(wanted)}", option="terms"
        )
    alone = curve.gaps is not None and wanted & set(LINEAR) != {"quantization"} and _all_alone(curve.gaps)
    if alone:
        wanted.discard("quantization")
    n = curve.n if curve.counting == "standard" else curve.n - 1
    chosen = _thinned(curve, n)
    if len(chosen) < LEAST_TIMES:
        times = f"{len(chosen)} averaging times up to a third of the record's {curve.n} samples"
        return no_fit(curve, level, f"{times}; at least {LEAST_TIMES} are needed")
    first = None
    if tau_min is not None:
        first = int(np.searchsorted(curve.tau[chosen], tau_min * (1 - 1e-9)))
        if not math.isfinite(tau_min) or len(chosen) - first < LEAST_TIMES:
            last = curve.tau[chosen][-LEAST_TIMES]
            raise OptionError(f"{{option}} may be at most {last:.6g} s here, not {tau_min!r}", option="tau_min")
    scale = float(np.median(curve.avar[chosen]))
    if not (math.isfinite(scale) and curve.avar[chosen].min() > 0):
        return no_fit(curve, level, "a variance is 0: no noise makes that")
    data = Data(
        n=n,
        m=tuple(int(m) for m in curve.m[chosen]),
        avar=curve.avar[chosen] / scale,
        ramps=curve.ramp[chosen] * curve.tau0 / math.sqrt(scale),
        candidates=tuple(p for p, name in enumerate(LINEAR) if name in wanted),
        with_ramp="rate_ramp" in wanted,
        first=first,
        gaps=curve.gaps,
    )
    # A division by nothing is a failed attempt like any other, and not a warning.
    with np.errstate(divide="raise", invalid="raise"):
        found, nearest = best_attempt(data, level=level)
        if found is None:
            return descriptive(curve, data, nearest, scale, level)
        try:
            result = stated(curve, data, found, scale, level)
            return replace(result, reason="; ".join(filter(None, [result.reason, _ALONE]))) if alone else result
        except (FloatingPointError, np.linalg.LinAlgError):
            # Trial values far from the fit may have no covariance, to rounding.
            why = "the model fits, but values beside it have no covariance: too few averaging times for its terms"
            return descriptive(curve, data, found, scale, level, reason=why)


def _all_alone(gaps: Gaps) -> bool:
    """Whether next to no sample has the one before it: quantization noise is then white, and no other than a random walk."""
    there = gaps.there
    return int(np.count_nonzero(there[1:] & there[:-1])) < _LEAST_IN_A_ROW * int(np.count_nonzero(there))


def _thinned(curve: DeviationCurve, n: int) -> NDArray[np.int64]:
    """Indices of at most eight cluster sizes an octave, up to a third of the record; of more, half octaves if there.

    Where samples are missing, up to the size from which on too few pairs are left.
    """
    chosen: list[int] = []
    longest = n // LONGEST_SHARE
    if curve.gaps is not None:
        few = curve.m[curve.n_pairs < curve.m * _LEAST_PAIRS]
        longest = min(longest, int(few[0]) - 1) if len(few) else longest
    usable = curve.m[curve.m <= longest]
    for k, size in enumerate(usable):
        if not chosen or size >= usable[chosen[-1]] * 2 ** (0.6 / _PER_OCTAVE):
            chosen.append(k)
    if len(chosen) < len(usable):
        # More sizes tell nothing more, and half octaves share their work with all the other curves of that length.
        chain = np.array(half_octaves(int(usable[0]), longest))
        if np.isin(chain, usable).all():
            return np.searchsorted(usable, chain)
    return np.array(chosen, dtype=np.int64)
