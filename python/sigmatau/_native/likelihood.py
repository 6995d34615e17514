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
    def spacing(self) -> float:
        """Distance of the densities of the periodogram. [Hz]"""
        return float(self._native.periodogram[0][1])

    @property
    def duration(self) -> float:
        """Length from the first sample to the last one. [s]"""
        return self._native.duration

    def same_as(self, other: Summary) -> bool:
        """Whether both are of the same samples."""
        (_, own), (_, others) = self._native.periodogram, other._native.periodogram
        return self._native.samples == other._native.samples and np.array_equal(own, others)

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
        return _outcome(found)


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


@frozen(eq=False, kw_only=False)
class Level:
    """Squared coefficients of a term that differs from run to run."""

    spread: float  # standard deviation of their logarithms over runs
    p_value: float  # of no spread
    runs: tuple[tuple[float, float], ...]  # squared coefficient of each run, standard error of its logarithm


@frozen(eq=False, kw_only=False)
class Other:
    """What one run says for itself."""

    # of each common term: squared coefficient of this run alone, its standard error, that of the other runs, fall of the
    # deviance
    terms: dict[str, tuple[float, float, float, float]]
    all: tuple[float, int]  # fall of the deviance if all that is common is of this run alone, number of parameters


@frozen(eq=False, kw_only=True)
class Joint:
    """Result of `analyse_jointly`."""

    outcome: Outcome
    ramps: bool  # whether the mean of every run may follow a ramp
    ramps_of: tuple[tuple[float, float], ...]  # value and standard error of the ramp of each run [rate unit / s]
    levels: dict[str, Level]
    homogeneity: dict[
        str, tuple[float, int]
    ]  # of each common term: fall of the deviance if each run has its own, freedom
    others: tuple[Other, ...]
    bin_counts: tuple[int, ...]


def analyse_jointly(
    summaries: Sequence[Summary],
    *,
    regressors: Sequence[Sequence[ArrayLike]],
    terms: Iterable[str] = TERMS,
    common: Iterable[str],
    processes: bool = True,
    drifts: bool = True,
    times: Sequence[float] = (),
    level: float = 0.95,
) -> Joint:
    """Select, fit and test one model of several runs; see `Summary.analyse`.

    Parameters
    ----------
    summaries : sequence of Summary
        Of records with the same sample interval.
    regressors : sequence of sequences of array_like
        Curves that the mean may follow, of each run.
    common : iterable of str
        Terms that are the same in all runs; the others differ from run to run.
    """
    wanted, shared = set(terms), set(common)
    found = _core.likelihood_jointly(
        [summary._native for summary in summaries],
        [[np.ascontiguousarray(curve, dtype=np.float64) for curve in curves] for curves in regressors],
        terms=[name in wanted for name in TERMS],
        common=[name in shared for name in TERMS],
        processes=processes,
        drifts=drifts,
        times=[float(time) for time in times],
        level=level,
    )
    levels, homogeneity, others = (found.pop(key) for key in ("levels", "homogeneity", "others"))
    ramps, ramps_of, bin_counts = (found.pop(key) for key in ("ramps", "ramps_of", "bin_counts"))
    return Joint(
        outcome=_outcome(found),
        ramps=ramps,
        ramps_of=tuple(ramps_of),
        levels={TERMS[k]: Level(spread, p_value, tuple(runs)) for k, spread, p_value, runs in levels},
        homogeneity=_named(homogeneity),
        others=tuple(Other(_named(own), everything) for own, everything in others),
        bin_counts=tuple(bin_counts),
    )


def _named(values: Sequence[Any]) -> dict[str, Any]:
    return {name: value for name, value in zip(TERMS, values, strict=True) if value is not None}


def _outcome(found: dict[str, Any]) -> Outcome:
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


def _walked(walk: _core.LikelihoodPass, pieces: Iterable[Floats]) -> Summary:
    for piece in pieces:
        walk.push(np.ascontiguousarray(piece, dtype=np.float64))
    return Summary(walk.finish())
