"""The likelihood of a channel: one pass over its samples, and the analysis of what it keeps."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau import _core
from sigmatau.frozen import frozen

Floats = NDArray[np.float64]

TERMS = ("quantization", "random_walk", "bias_instability", "rate_random_walk")
"""The terms of the likelihood, in their order."""

LEAST_SAMPLES = 256

_LEAST_TAPER = 0.2  # samples; with less the weights of a run are all 1


@frozen(kw_only=False)
class Bounds:
    """A parameter (a squared coefficient, a time, a frequency) with its interval."""

    value: float
    low: float  # 0 if the record does not show the part
    high: float  # upper end or limit; infinite if there is none
    observed: bool
    loss: float  # rise of the deviance without the part


@frozen(kw_only=False)
class Process:
    """A Gauss-Markov process, whose shape is its time, or a resonance, whose shape is its centre and half width."""

    kind: Literal["gauss_markov", "resonance"]
    variance: Bounds
    shape: tuple[Bounds, ...]


@frozen(kw_only=False)
class Line:
    """A line of the spectrum that was left out."""

    low: float  # ends of what was left out [Hz]
    high: float
    frequency: float  # [Hz]
    amplitude: float  # of a sinusoid of the same power [rate unit]
    error: float  # standard error if the line is noise of a narrow band


@frozen(eq=False, kw_only=False)
class Outcome:
    """Result of `Summary.analyse`; parameters are squares of coefficients."""

    terms: dict[str, Bounds]  # those that were fitted
    reduced: dict[str, float]  # the model without the terms that were not observed
    processes: tuple[Process, ...]
    filter: tuple[float, ...]  # ln |H|² = Σ aₖ (cos 2πk f Δ − 1), on all but quantization noise
    filter_interval: float  # Δ: the sample interval, or a multiple where the top of the band was left out [s]
    lines: tuple[Line, ...]
    highest: float | None  # frequency from which the band was left out [Hz]
    # where a rate random walk was observed: a Gauss-Markov process of this or a longer time [s] explains the record as well;
    # and the variance of that of this time
    alike_from: tuple[float, float] | None
    ramp: tuple[float, float]  # value and standard error [rate unit / s]
    ramp_observed: bool
    warm_up: tuple[float, float, float, float] | None  # time constant [s], amplitude, its standard error, gain
    regressors: tuple[tuple[float, float], ...]  # value and standard error of each
    p_value: float
    widened: bool
    bands: tuple[tuple[float, float], ...]  # frequency [Hz], normal deviate of the record from the model
    discrepancy: tuple[tuple[float, float], ...]  # frequency [Hz], standard deviation of the logarithm of the density
    unsteadiness: tuple[float, float]  # of the white level over eighths of the record, relative, and p-value
    kurtosis: float
    # Of the rows of `covariance`. Coefficients of the filter follow, then the shapes of the processes in their order:
    # logarithms of times and widths; frequencies, in widths
    parameters: tuple[str, ...]
    covariance: Floats
    bins: Floats  # a row a bin: frequency [Hz], measured and expected density, degrees of freedom


class Summary:
    """What one pass keeps of a channel."""

    __slots__ = ("_native",)

    def __init__(self, native: _core.LikelihoodSummary) -> None:
        self._native = native

    @property
    def centres(self) -> Floats:
        """Times of the blocks whose means are used, from the first sample, where regressors are given. [s]"""
        return self._native.centres

    @property
    def floor(self) -> float:
        """Least density of the periodogram, two-sided. [unit of the rate squared per Hz]"""
        return float(self._native.periodogram[1][1:].min())

    @property
    def weighting(self) -> tuple[float, float | None]:
        """How a second pass over a record with missing samples should weight them.

        Samples over which the weights fall to 0 at the ends of runs; and the same for runs of differences, if these should
        take the place of the samples at high frequencies, else None.
        """
        return self._native.weighting()

    def analyse(
        self,
        *,
        terms: Iterable[str] = TERMS,
        filter: bool = True,  # noqa: A002  the name of the option everywhere
        processes: bool = True,
        resonances: bool = True,
        lines: bool = True,
        drifts: bool = True,
        times: Sequence[float] = (),
        regressors: Sequence[ArrayLike] = (),
        level: float = 0.95,
    ) -> Outcome:
        """Select, fit and test a model.

        Parameters
        ----------
        terms : iterable of str
            Of `TERMS`, that may be present.
        filter, processes, resonances : bool
            Whether they may be added.
        lines, drifts : bool
            Whether lines are left out; whether a rate ramp and a warm-up are tested.
        times : sequence of float
            Correlation times of Gauss-Markov processes that are in the model from the start. [s]
        regressors : sequence of array_like, each of the shape of `centres`
            Curves that the mean may follow.
        level : float
            Of the intervals.
        """
        wanted = set(terms)
        found = self._native.analyse(
            terms=[name in wanted for name in TERMS],
            filter=filter,
            processes=processes,
            resonances=resonances,
            lines=lines,
            drifts=drifts,
            times=[float(time) for time in times],
            regressors=[np.ascontiguousarray(curve, dtype=np.float64) for curve in regressors],
            level=level,
        )
        pairs = zip(TERMS, found.pop("terms"), strict=True)
        known = {key: found.pop(key) for key in ("reduced", "processes", "lines", "covariance", "bins")}
        rest: dict[str, Any] = {key: tuple(x) if isinstance(x, list) else x for key, x in found.items()}
        return Outcome(
            terms={name: Bounds(*bounds) for name, bounds in pairs if bounds is not None},
            reduced=dict(zip(TERMS, known["reduced"], strict=True)),
            processes=tuple(
                Process(kind, Bounds(*variance), tuple(Bounds(*one) for one in shape))
                for kind, variance, shape in known["processes"]
            ),
            lines=tuple(Line(*line) for line in known["lines"]),
            covariance=known["covariance"],
            bins=known["bins"],
            **rest,
        )


def summarize(pieces: Iterable[Floats], *, samples: int, tau0: float) -> Summary:
    """One pass over the samples of a channel, given in consecutive pieces of any length.

    Parameters
    ----------
    pieces : iterable of ndarray, shape (n,)
    samples : int
        Samples of all pieces together.
    tau0 : float
        Sample interval. [s]

    Raises
    ------
    ValueError
        For fewer than `LEAST_SAMPLES`, for a sample that is not finite or larger than 1e130.
    """
    return _walked(_core.LikelihoodPass(samples, tau0), pieces)


def summarize_masked(pieces: Callable[[], Iterable[Floats]], *, present: NDArray[np.bool_], tau0: float) -> Summary:
    """The same for a record with missing samples: one pass, or two for quantization noise or strong slow noise.

    Parameters
    ----------
    pieces : callable
        Gives the consecutive pieces, each time it is called; missing samples may have any value.
    present : ndarray of bool, shape (n,)
        False where a sample is missing.
    tau0 : float
        Sample interval. [s]

    Raises
    ------
    ValueError
        As `summarize`; and if the samples that are there are in a few places only, see `enough`.
    """
    there = np.ascontiguousarray(present, dtype=np.bool_)
    summary = _walked(_core.LikelihoodPass.masked(there, tau0), pieces())
    taper, differences = summary.weighting
    if taper < _LEAST_TAPER and differences is None:
        return summary
    return _walked(_core.LikelihoodPass.masked(there, tau0, taper, differences), pieces())


def enough(present: NDArray[np.bool_]) -> bool:
    """Whether a record with missing samples has so many, and in so many places, that it can be summarised."""
    try:
        _core.LikelihoodPass.masked(np.ascontiguousarray(present, dtype=np.bool_), 1.0)
    except ValueError:
        return False
    return True


def _walked(walk: _core.LikelihoodPass, pieces: Iterable[Floats]) -> Summary:
    for piece in pieces:
        walk.push(np.ascontiguousarray(piece, dtype=np.float64))
    return Summary(walk.finish())
