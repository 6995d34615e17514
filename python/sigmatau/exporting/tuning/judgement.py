"""Find the wrong noise of a filter from the spectrum of its innovations, and the part of these that motion explains."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from sigmatau._native.distributions import chi2_above, chi2_quantile_above
from sigmatau.arrays import Floats, Ints
from sigmatau.exporting.tuning.filters import Filter, FilterMatrices
from sigmatau.exporting.tuning.innovations import Innovations
from sigmatau.exporting.tuning.likelihood import FactorInterval, Matrices, Periodogram, Shares, coarse
from sigmatau.exporting.tuning.motion import MotionEffect, fit_motion, respond_to_motion
from sigmatau.exporting.tuning.reconstruction import reconstruct_run
from sigmatau.exporting.tuning.result import NoiseFactor, NoiseVerdict
from sigmatau.exporting.tuning.run import FilterRun
from sigmatau.frozen import frozen

CHANCE = 0.04
"""Largest probability that a correct filter is judged wrong."""

_REJECTION = 0.01  # probability that the true single cause is rejected
_MISFIT = 0.003  # probability of the verdict "not explained" for a filter with wrong factors only
_IMMATERIAL = 1.05  # factor on a standard deviation below which an error does not matter in practice
_EVIDENCE = 6.0  # smallest rise of the deviance from the best to the second best single cause: a likelihood ratio of 20
_ROUNDS = 3  # number of rounds in which motion and noises are estimated alternately


@frozen(eq=False)
class RunSpectra:
    """Run of a filter, and the shares of its noises in the bins of the periodogram.

    Attributes
    ----------
    run : FilterRun
    fine, wide : ndarray, shape (n_noises, n_bins, n_measurements, n_measurements)
        Shares in the bins of the likelihood, and in those of the misfit test.
    counts : ndarray, shape (n_measurements,)
        Number of innovations of each measurement.
    """

    run: FilterRun
    fine: Matrices
    wide: Matrices
    counts: Ints


class Runs:
    """Runs of filters. Each is reconstructed once for all channels with the same times and S."""

    def __init__(self) -> None:
        self._runs: dict[object, RunSpectra] = {}

    def reconstruct(self, filter_: Filter, data: Innovations, first: int) -> RunSpectra:
        """Reconstruct the run of a filter whose matrices may begin before the innovations."""
        arrays = (data.time, data.variance, data.is_present)
        key = (id(filter_), first, *(values.tobytes() for values in arrays))
        if key not in self._runs:
            run = reconstruct_run(filter_.after(first) if isinstance(filter_, FilterMatrices) else filter_, data)
            blank = np.zeros(data.columns.shape)
            bins = [periodogram.frequency for periodogram in (Periodogram.compute(blank), coarse(blank))]
            shares = run.shares(np.concatenate(bins))
            self._runs[key] = RunSpectra(
                run=run,
                fine=shares[:, : len(bins[0])],
                wide=shares[:, len(bins[0]) :],
                counts=data.is_present.sum(axis=0),
            )
        return self._runs[key]


@frozen(eq=False)
class Judgement:
    """Verdict on the noises, from the spectrum of the innovations.

    Attributes
    ----------
    explained : ndarray, shape (n, n_measurements)
        Whitened innovations due to motion.
    factors, causes, verdict, p_value, p_misfit
        See `Tuning`.
    lowest_density : ndarray, shape (n_measurements, n_measurements), or None
        Density at the lowest frequency, if the factors explain the innovations.
    """

    explained: Floats
    factors: tuple[NoiseFactor, ...] = ()
    causes: tuple[NoiseFactor, ...] = ()
    verdict: NoiseVerdict = "consistent"
    p_value: float = 1.0
    p_misfit: float | None = None
    lowest_density: Matrices | None = None


class _NoiseFit:
    """Factors on all noises, fitted to whitened innovations.

    Attributes
    ----------
    shares : Shares
    best : Fit
    p_misfit : float
    density : ndarray, shape (n_bins, n_measurements, n_measurements)
        Fitted density, or the measured one if factors do not explain it.
    process : ndarray, of the same shape
        Part of the density that is process noise; as stated by the filter if factors do not explain the density.
    """

    def __init__(self, series: Floats, spectra: RunSpectra) -> None:
        whole, wide = Periodogram.compute(series, counts=spectra.counts), coarse(series, spectra.counts)
        self.shares = Shares(whole, spectra.fine)
        count = len(spectra.fine)
        self.best = self.shares.fit(range(count))
        self.p_misfit = wide.misfit(Shares(wide, spectra.wide).density(self.best.logs), count)
        self.density, logs = self.shares.density(self.best.logs), self.best.logs
        if self.p_misfit < _MISFIT:
            nearest = np.abs(np.log(whole.frequency[:, None] / wide.frequency)).argmin(axis=1)
            self.density, logs = wide.power[nearest] * np.eye(series.shape[1]), np.zeros(count)
        measurements = series.shape[1]
        self.process: Matrices = np.tensordot(np.exp(logs[measurements:]), self.shares.shares[measurements:], 1)


def judge(
    data: Innovations, series: Floats, spectra: RunSpectra, assumed: Mapping[str, float], level: float
) -> tuple[tuple[MotionEffect, ...], Judgement]:
    """Estimate delay and scale if the rate is known, subtract their effect, and judge the noises.

    Parameters
    ----------
    data : Innovations
    series : ndarray, shape (n, n_measurements)
        Whitened, 0 where a measurement is absent.
    spectra : RunSpectra
    assumed : mapping of str to float
        Assumed size, by noise.
    level : float

    Returns
    -------
    tuple of MotionEffect, Judgement
    """
    nothing = np.zeros_like(series)
    if data.rate is None:
        return (), _judge_noises(nothing, _NoiseFit(series, spectra), spectra, assumed, level)
    responses = respond_to_motion(data, spectra.run)
    periodogram = Periodogram.compute(nothing, counts=spectra.counts)
    density = periodogram.restrict(spectra.fine.sum(axis=0))  # density as stated by the filter
    whole_fit = _NoiseFit(series, spectra)  # fitted first: the measured rate contains the process noise too
    for _ in range(_ROUNDS):
        motion, explained = fit_motion(data, responses, series, periodogram, density, whole_fit.process, level)
        fit = _NoiseFit(series - explained, spectra)
        density = fit.density
    if not any(effect.has_error for effect in motion):
        explained, fit = nothing, whole_fit
    return motion, _judge_noises(explained, fit, spectra, assumed, level)


def _judge_noises(
    explained: Floats, fit: _NoiseFit, spectra: RunSpectra, assumed: Mapping[str, float], level: float
) -> Judgement:
    """Select the noises that are wrong."""
    names, shares, best = spectra.run.noises, fit.shares, fit.best
    alone = np.array([shares.fit((k,)).deviance for k in range(len(names))])
    p_value = _significance(shares.fit(()).deviance, alone, best.deviance)
    intervals = [shares.interval(best, k, level) for k in range(len(names))]
    factors = tuple(
        NoiseFactor(noise=name, value=part.value, low=part.low, high=part.high, assumed=assumed.get(name))
        for name, part in zip(names, intervals, strict=True)
    )
    causes: tuple[NoiseFactor, ...] = ()
    verdict: NoiseVerdict = "consistent" if p_value >= CHANCE else "wrong"
    if fit.p_misfit < _MISFIT:
        verdict = "not explained"
    elif verdict == "wrong" and all(_is_immaterial(part) for part in intervals):
        verdict = "consistent"
    elif verdict == "wrong":
        chosen = _single_causes(alone, best.deviance)
        causes = tuple(factors[k] for k in chosen) or tuple(factor for factor in factors if factor.has_error)
        if len(chosen) > 1 or not causes:
            verdict, causes = "ambiguous", causes or factors
    return Judgement(
        explained=explained,
        factors=factors,
        causes=causes,
        verdict=verdict,
        p_value=p_value,
        p_misfit=fit.p_misfit,
        lowest_density=fit.density[0] if fit.p_misfit >= _MISFIT else None,
    )


def _is_immaterial(part: FactorInterval) -> bool:
    """Whether a factor is too close to 1 to matter, or is not determined."""
    differs = part.low > 1 or (part.high is not None and part.high < 1)
    return not differs or (part.low > 1 / _IMMATERIAL and (part.high or math.inf) < _IMMATERIAL)


def _significance(unchanged: float, alone: Floats, best: float) -> float:
    """p-value of the hypothesis that the filter is correct, from the largest rise of the likelihood by one factor or by all
    (Bonferroni).
    """
    count = len(alone)
    single = count * float(chi2_above(1, max(unchanged - float(alone.min()), 0.0)))
    joint = float(chi2_above(count, max(unchanged - best, 0.0)))
    return min(2 * min(single, joint), 1.0)


def _single_causes(alone: Floats, best: float) -> list[int]:
    """Noises that each explain the innovations alone; only the best if the others are much worse."""
    rise = float(chi2_quantile_above(len(alone) - 1, _REJECTION)) if len(alone) > 1 else math.inf
    accepted = [k for k, deviance in enumerate(alone) if deviance - best < rise]
    if len(accepted) > 1:
        first, second = sorted(alone[accepted])[:2]
        if second - first > _EVIDENCE:
            accepted = [int(np.argmin(alone))]
    return accepted
