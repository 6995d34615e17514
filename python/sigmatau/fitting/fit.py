"""Fit of the noise terms to a curve; see `fit`."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.gls import CurveFit, fit_curve
from sigmatau.arrays import median
from sigmatau.errors import OptionError
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.findings.reasons import (
    IncompleteRecord,
    Misfit,
    NoCovariance,
    Reason,
    ShortTimesDeviate,
    TooFewTimes,
    ZeroVariance,
)
from sigmatau.fitting.arguments import check_level, wanted_terms
from sigmatau.fitting.components import LONGEST_SHARE, MIN_TIMES, half_octaves
from sigmatau.fitting.fitted_values import FittedTerm
from sigmatau.fitting.from_native import fitted_covariance, fitted_terms, typed
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.model.processes import real
from sigmatau.noise.terms import TERMS, coefficient_unit

_PER_OCTAVE = 8  # largest number of averaging times per octave


def fit(
    curve: DeviationCurve,
    *,
    method: Literal["gls"] = "gls",
    terms: Iterable[str] | None = None,
    tau_min: float | None = None,
    level: float = 0.95,
) -> NoiseFit:
    """Fit the five noise terms to an overlapped Allan deviation curve.

    Generalised least squares with the exact covariance of the Allan variances. The ramp is tested for given noise and
    removed if it is significant. A Gauss-Markov process replaces a term if it fits much better. Short averaging
    times are left out until the goodness of fit is acceptable. Each term is then tested with all others free and gets an
    interval or an upper limit; the coefficients are those of the significant terms.

    Parameters
    ----------
    curve : DeviationCurve
        Curve of a record without missing samples; for missing samples use `sigmatau.analyze`. It has half octaves, or up
        to eight averaging times per octave; a denser curve is reduced to half octaves if it has them, otherwise to eight
        per octave.
    method : {"gls"}
        Least squares; the likelihood needs the samples, see `sigmatau.fit_channel`.
    terms : iterable of str, optional
        Terms to fit, keys of `sigmatau.noise.terms.TERMS`. Default: all five. A term that is left out is assumed to be
        absent; if it is present, the others are wrong.
    tau_min : float, optional
        Shortest averaging time to use. Default: found from the goodness of fit. [s]
    level : float
        Confidence level of the intervals and limits; a term is observed if its p-value is below 1 − level.

    Returns
    -------
    NoiseFit

    Raises
    ------
    TypeError
        If `curve` is not a curve, but for example the curves of a record.
    OptionError
        For a curve without overlapping clusters, for a level outside 0.5 … 0.999, for an unknown term or no noise term, for
        a `tau_min` that leaves fewer than eight averaging times.

    See Also
    --------
    fit_channel : the fit of the samples, which uses more of the record.
    allan : makes the curve.

    References
    ----------
    S. Guerrier, J. Skaloud, Y. Stebler, M.-P. Victoria-Feser, "Wavelet-variance-based estimation for composite stochastic
    processes", J. Am. Stat. Assoc. 108 (2013), :doi:`10.1080/01621459.2013.799920`, for least squares on variances; the
    covariance is exact here, see `sigmatau.noise.uncertainty.avar_covariance`.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> curve = st.allan(st.simulate(model, duration=600, rate=10, rng=1))["gyro_x"]
    >>> walk = st.fit(curve)["random_walk"]
    >>> walk.low < 1e-4 < walk.high
    True
    """
    if not isinstance(curve, DeviationCurve):
        raise TypeError(
            f"`curve` must be a DeviationCurve, e.g. sigmatau.allan(record)['gyro_x'], not a {type(curve).__name__};"
            " sigmatau.analyze(record) fits every channel of a record"
        )
    if curve.overlap != "full":
        raise OptionError("a fit needs overlapping clusters, overlap='full'", option="overlap")
    if method != "gls":
        raise OptionError(
            f"{{option}} is gls for a curve, not {method!r}: sigmatau.analyze and sigmatau.fit_channel fit the samples",
            option="method",
        )
    check_level(level)
    wanted = wanted_terms(terms)
    if curve.missing:
        return _no_fit(curve, level, IncompleteRecord(missing=curve.missing, samples=curve.n))
    n = curve.n if curve.counting == "standard" else curve.n - 1
    chosen = _thinned(curve, n)
    if len(chosen) < MIN_TIMES:
        return _no_fit(curve, level, TooFewTimes(times=len(chosen), needed=MIN_TIMES, samples=curve.n))
    first = None
    if tau_min is not None:
        first = int(np.searchsorted(curve.tau[chosen], real(tau_min) * (1 - 1e-9)))
        if not math.isfinite(real(tau_min)) or len(chosen) - first < MIN_TIMES:
            last = curve.tau[chosen][-MIN_TIMES]
            raise OptionError(f"{{option}} may be at most {last:.6g} s here, not {tau_min!r}", option="tau_min")
    scale = median(curve.avar[chosen])
    if not (math.isfinite(scale) and curve.avar[chosen].min() > 0):
        return _no_fit(curve, level, ZeroVariance())
    sizes = curve.m[chosen]
    fitted = fit_curve(
        n,
        sizes,
        curve.avar[chosen],
        curve.ramp[chosen],
        tau0=curve.tau0,
        scale=scale,
        terms=list(wanted),
        first=first,
        level=level,
        digitising=None if curve.digitising is None else 4 * curve.digitising[np.ix_(chosen, chosen)].ravel(),
    )
    return _stated(curve, fitted, sizes, wanted, level)


def _thinned(curve: DeviationCurve, n: int) -> NDArray[np.int64]:
    """Indices of at most eight cluster sizes per octave, up to a third of the record; a denser curve is reduced to half
    octaves if possible.
    """
    chosen: list[int] = []
    longest = n // LONGEST_SHARE
    usable = curve.m[curve.m <= longest]
    smallest = 0.0
    for k, size in enumerate(usable.tolist()):
        if size >= smallest:
            chosen.append(k)
            smallest = size * 2 ** (0.6 / _PER_OCTAVE)
    if len(chosen) < len(usable):
        # More sizes add no information, and on half octaves the components are shared with other curves of this length.
        chain = np.array(half_octaves(int(usable[0]), longest))
        if np.isin(chain, usable).all():
            return np.searchsorted(usable, chain)
    return np.array(chosen, dtype=np.int64)


def _stated(
    curve: DeviationCurve, fit: CurveFit, m: NDArray[np.int64], terms: Collection[str], level: float
) -> NoiseFit:
    """Build the result of a fit: intervals of the observed terms and upper limits of the others, or coefficients that only
    describe the curve.

    `terms`: the terms that were fitted.
    """
    tau_min = int(m[fit.first]) * curve.tau0

    values = dict(fit.model)
    described = {
        name: FittedTerm(
            term=name,
            unit=coefficient_unit(name, curve.quantity, curve.unit),
            observed=None,
            level=level,
            value=values.get(name),
        )
        for name in TERMS
        if name in terms
    }
    return typed(
        NoiseFit,
        fit,
        curve.unit,
        rate_unit=curve.unit,
        channel=curve.channel,
        quantity=curve.quantity,
        n=curve.n,
        tau0=curve.tau0,
        terms=fitted_terms(fit.terms, quantity=curve.quantity, rate_unit=curve.unit, level=level) or described,
        model=values,
        verdict="adequate" if fit.adequate else "descriptive",
        reasons=_reasons(curve, fit, m, tau_min),
        tau_min=tau_min,
        tau_max=int(m[-1]) * curve.tau0,
        p_value=fit.p_value if fit.adequate else None,
        covariance=fitted_covariance(fit),
        level=level,
    )


def _reasons(curve: DeviationCurve, fit: CurveFit, m: NDArray[np.int64], tau_min: float) -> tuple[Reason, ...]:
    """Why short averaging times were left out, or why no model is adequate."""
    if fit.no_covariance:
        return (NoCovariance(),)
    if fit.worst is None:
        return ()
    k, ratio = fit.worst
    if fit.adequate:
        return (ShortTimesDeviate(cluster_size=int(m[k]), ratio=ratio),)
    return (Misfit(p_value=fit.p_value, tau_min=tau_min, tau=float(m[k]) * curve.tau0, ratio=ratio),)


def _no_fit(curve: DeviationCurve, level: float, reason: Reason) -> NoiseFit:
    """Build the result for a curve that cannot be fitted."""
    return NoiseFit(
        channel=curve.channel,
        quantity=curve.quantity,
        rate_unit=curve.unit,
        n=curve.n,
        tau0=curve.tau0,
        terms={},
        model={},
        verdict="too_short",
        reasons=(reason,),
        level=level,
    )
