"""Fit of one channel by the likelihood of its spectrum; see `fit_samples`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from sigmatau._native.likelihood import ChannelFit, FilterEstimate, MaternEstimate
from sigmatau.arrays import Floats
from sigmatau.errors import DataError, OptionError
from sigmatau.findings.reasons import BandsOff, Reason, UnmodelledBand
from sigmatau.fitting.adjust import adjusted
from sigmatau.fitting.arguments import check_level, wanted_terms
from sigmatau.fitting.beside_vibration import crowded_lines
from sigmatau.fitting.changing_level import changing_level, unsteadiness
from sigmatau.fitting.disturbance import hidden_by_vibration
from sigmatau.fitting.fitted_matern import FittedMatern
from sigmatau.fitting.fitted_values import SecondModel
from sigmatau.fitting.from_native import fitted_covariance, fitted_terms, interval_with_unit, typed
from sigmatau.fitting.misfit import misfit
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.pass_over import never_changes, summarized
from sigmatau.fitting.response import FittedFilter
from sigmatau.model.processes import LowPass
from sigmatau.noise.terms import NOISE
from sigmatau.record.streams import Grid, Stream

_SHORTEST_TIME = 20.0  # shortest correlation time of a fit, as in crates/core/src/likelihood/fit.rs [samples]
_LONGEST_TIME = 0.25  # longest one [record]
_AT_LIMIT = 0.01  # relative distance of an end of the time from its limit below which the record does not limit it
_MAX_PROCESSES = 8  # largest number of given Gauss-Markov processes
_MAX_REGRESSORS = 20  # largest number of given curves
_MIN_CURVE = 1e-150  # smallest regressor whose square stays in range
_LARGEST_CURVE = 1e150  # largest regressor whose square stays in range


def fit_samples(
    stream: Stream,
    channel: str,
    *,
    terms: Iterable[str] | None = None,
    processes: Sequence[float] | Literal["matern"] | None = None,
    regressors: Mapping[str, ArrayLike] | None = None,
    level: float = 0.95,
    step: float | None = None,
) -> NoiseFit:
    """Fit the noise of a channel to its samples.

    The model contains the terms and further parts that the spectrum shows: a filter, lines, Gauss-Markov processes,
    resonances, a warm-up, a ramp. A part is added if it raises the likelihood by more than its price. If the model is not
    exact, the intervals are widened for the misfit.

    Parameters
    ----------
    stream, channel : Stream, str
        The channel must be `usable`; samples may be missing.
    terms : iterable of str, optional
        Terms that may be present, keys of `sigmatau.noise.terms.TERMS`. Default: all.
    processes : sequence of float or "matern", optional
        Correlation times at which to start Gauss-Markov processes; no other process or resonance is then added. [s] With
        "matern", a model with one Matérn process is fitted too.
    regressors : mapping of str to array_like, shape (n,), optional
        Curves at the samples that the mean may follow, by name.
    level : float
        Level of intervals and limits.
    step : float, optional
        Step of the samples, 0 for none; it bounds the quantization noise, because quantized angles give quantized
        rates. Default: not known. [unit of the stream]

    Raises
    ------
    OptionError
        For an unknown term or no noise term, a correlation time that is not positive, a regressor that has another
        length, is not finite or never changes, or a level outside 0.5 … 0.999.
    DataError
        For a channel that never changes.
    """
    given_terms = wanted_terms(terms)
    times = None if isinstance(processes, str) and processes == "matern" else processes
    _refuse(times, regressors, stream.grid.n, level)
    if never_changes(stream, channel):
        raise DataError(f"channel {channel!r} never changes in {stream.grid.n} samples: it has no noise to fit")
    summary, start = summarized(stream, channel)
    curves = (regressors or {}).values()

    def fitted_with(*, lines: bool) -> ChannelFit:
        return summary.fit(
            samples=stream.grid.n,
            terms=[name for name in NOISE if name in given_terms],
            processes=times is None,
            resonances=times is None,
            lines=lines,
            drifts="rate_ramp" in given_terms,
            times=[float(time) for time in times or ()],
            matern=times is not processes,
            regressors=[at_blocks(summary.centres + start, curve, stream.grid.tau0) for curve in curves],
            level=level,
            most_quantization=math.inf if step is None else step * stream.grid.tau0 / math.sqrt(12),
        )

    channel_fit = fitted_with(lines=True)
    unsteady = unsteadiness(channel_fit.levels)
    return adjusted(
        as_noise_fit(stream, channel, channel_fit, regressors=tuple(regressors or ()), level=level),
        partial(hidden_by_vibration, stream=stream, unsteady=unsteady),
        partial(
            crowded_lines,
            native=channel_fit,
            without_lines=partial(fitted_with, lines=False),
            spacing=summary.spacing,
        ),
        partial(changing_level, levels=channel_fit.levels, p_value=unsteady),
        misfit,
    )


def _refuse(
    processes: Sequence[float] | None,
    regressors: Mapping[str, ArrayLike] | None,
    n: int,
    level: float,
) -> None:
    check_level(level)
    times = _numbers(() if processes is None else processes)
    if times is None or times.ndim != 1 or len(times) > _MAX_PROCESSES or not ((times > 0) & (times < math.inf)).all():
        raise OptionError(
            f"{{option}} must be 'matern' or up to {_MAX_PROCESSES} positive times in s, not {processes!r:.80}",
            option="processes",
        )
    if len(regressors or {}) > _MAX_REGRESSORS:
        raise OptionError(
            f"{{option}} must be at most {_MAX_REGRESSORS} curves, not {len(regressors or {})}", option="regressors"
        )
    for name, curve in (regressors or {}).items():
        values = _numbers(curve)
        if (
            values is None
            or values.shape != (n,)
            or not (np.ptp(values) > _MIN_CURVE and np.abs(values).max() < _LARGEST_CURVE)
        ):
            raise OptionError(f"{{option}} {name!r} must be {n} finite real numbers that change", option="regressors")


def _numbers(values: object) -> Floats | None:
    """Convert to real numbers; None if they are not."""
    try:
        numbers = np.asarray(values)
        return None if numbers.dtype.kind not in "biuf" else numbers.astype(np.float64)
    except (TypeError, ValueError):
        return None


def at_blocks(centres: Floats, curve: ArrayLike, tau0: float) -> Floats:
    """Interpolate a curve from the samples to other times."""
    values = np.asarray(curve, dtype=float)
    return np.asarray(np.interp(centres, (np.arange(len(values)) + 0.5) * tau0, values))


def as_noise_fit(
    stream: Stream, channel: str, fit: ChannelFit, *, regressors: tuple[str, ...] = (), level: float
) -> NoiseFit:
    """Convert the fit of a channel, with names and units."""
    unit = stream.unit
    reasons: tuple[Reason, ...] = () if fit.highest is None else (UnmodelledBand(highest=fit.highest),)
    if fit.worst_band is not None:
        frequency, ratio = fit.worst_band
        reasons = (*reasons, BandsOff(frequency=frequency, ratio=ratio))
    coefficients = (interval_with_unit(coefficient, unit) for coefficient in fit.regressors)
    return typed(
        NoiseFit,
        fit,
        unit,
        rate_unit=unit,
        channel=channel,
        quantity=stream.quantity,
        n=stream.grid.n,
        tau0=stream.grid.tau0,
        terms=fitted_terms(fit.terms, quantity=stream.quantity, rate_unit=unit, level=level),
        model=dict(fit.model),
        response=None if fit.response is None else _response(fit.response, unit),
        regressors=dict(zip(regressors, coefficients, strict=True)),
        matern=None if fit.matern is None else _matern(fit.matern, unit, stream.grid),
        second=tuple(typed(SecondModel, model, unit, terms=dict(model.terms)) for model in fit.second),
        discrepancy=tuple(fit.discrepancy) if fit.verdict == "widened" else (),
        reasons=reasons,
        covariance=fitted_covariance(fit),
        level=level,
        method="likelihood",
    )


def _matern(estimate: MaternEstimate, unit: str, grid: Grid) -> FittedMatern:
    """Convert the model with a Matérn process. Beyond a limit of the time the other parameters have no interval."""
    fitted = typed(FittedMatern, estimate, unit, terms=dict(estimate.terms), gauss_markov_p_value=estimate.gauss_markov)
    shortest, longest = _SHORTEST_TIME * grid.tau0, _LONGEST_TIME * grid.n * grid.tau0
    low, high = fitted.time.low, fitted.time.high
    low = None if low is None or low <= (1 + _AT_LIMIT) * shortest else low
    high = None if high is None or high >= (1 - _AT_LIMIT) * longest else high
    sigma, smoothness = fitted.sigma, fitted.smoothness
    return replace(
        fitted,
        sigma=replace(sigma, high=None) if low is None or high is None else sigma,
        time=replace(fitted.time, low=low, high=high),
        smoothness=replace(smoothness, low=None, high=None) if low is None else smoothness,
    )


def _response(fitted: FilterEstimate, unit: str) -> FittedFilter:
    """Convert the filter. Its equivalent in a model acts on samples at the rate of the record."""
    low_pass = None
    if fitted.low_pass is not None:
        order, before = fitted.low_pass
        low_pass = LowPass(order=order, corner=before, rate=1 / fitted.tau0)
    return typed(FittedFilter, fitted, unit, low_pass=low_pass)
