"""The fit of one channel of a record, by the likelihood of its samples or by least squares on its curve."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau._native.distributions import normal_quantile
from sigmatau.errors import OptionError
from sigmatau.estimators.allan import DeviationCurve, channel_curve
from sigmatau.estimators.deviation_kinds import cluster_sizes
from sigmatau.findings.reasons import IncompleteRecord
from sigmatau.fitting import likelihood
from sigmatau.fitting.block_temperature import mean_temperatures
from sigmatau.fitting.fit import fit
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.pass_over import usable
from sigmatau.noise.terms import avar
from sigmatau.record.record import Record, need_record
from sigmatau.record.streams import Stream

FitMethod = Literal["likelihood", "gls"]

TEMPERATURE = "temperature"
"""Name of the regressor that is the temperature of the log's thermometer."""

# A drift that the model lacks becomes a rate random walk. For 24 axes that warmed up, the interval contained K in 18
# cases if the drift was modelled above a ratio of 3.3, and in all cases if it was modelled above 1.
_MIN_RATIO = 1.0  # ratio of the temperature coefficient to its standard error above which it stays in the model
_REPORTED_RATIO = 3.3  # ratio of the temperature coefficient to its standard error above which it is a finding
_MAX_TEMPERATURES = 1 << 14  # largest number of times at which the temperature is computed; the model uses no more
_MAX_UNKNOWN = 0.1  # largest share of the record without a temperature

# Eighths of an octave are used if quantization noise dominates and at least one other term is observed.
_QUANTIZATION_SIZE = 8  # cluster size at which the share of quantization noise is computed [samples]
_QUANTIZATION_SHARE = 0.9  # smallest share of quantization noise in the Allan variance
_MIN_TERMS = 2


def fit_channel(
    record: Record,
    channel: str,
    *,
    method: FitMethod = "likelihood",
    curve: DeviationCurve | None = None,
    tau_min: float | None = None,
    terms: Sequence[str] | None = None,
    processes: Sequence[float] | Literal["matern"] | None = None,
    regressors: Mapping[str, ArrayLike] | None = None,
    level: float = 0.95,
    step: float | None = None,
    threads: int | None = None,
) -> NoiseFit:
    """Fit the noise of a channel with a model that you choose.

    Parameters
    ----------
    record : Record
        Record at rest and without disturbances: nothing is left out here. A thermometer in the record is a regressor of
        the likelihood if the channel follows it.
    channel : str
        Name of the channel.
    method : {"likelihood", "gls"}
        A channel with very few samples is fitted by least squares.
    curve : DeviationCurve, optional
        Overlapped Allan deviations for least squares, if already computed.
    tau_min : float, optional
        Shortest averaging time of least squares, see `sigmatau.fit`. [s]
    terms : sequence of str, optional
        Terms that may be present, keys of `sigmatau.noise.terms.TERMS`. Default: all.
    processes : sequence of float or "matern", optional
        Correlation times at which to start Gauss-Markov processes, at most 8; no other process or resonance is then
        added. [s] With "matern", a model with one Matérn process in place of all slow noise is fitted too, with a test of
        the Gauss-Markov process: `NoiseFit.matern`.
    regressors : mapping of str to array_like, shape (n,), optional
        Regressors for the mean, one value per sample, at most 20, by name: a supply voltage, another thermometer. [any
        unit]
    level : float
        Confidence level of intervals and limits.
    step : float, optional
        Step of the samples, 0 for none. If angles are quantized, rates have steps too, which bound the quantization
        noise; with a small bound, the random walk is determined better. Default: not known. [unit of the channel]
    threads : int, optional
        Default: all cores. Results do not depend on it.

    Returns
    -------
    NoiseFit

    Raises
    ------
    OptionError
        For an unknown method or term, processes or regressors with least squares, a correlation time that is not
        positive, a regressor that has another length, is not finite or never changes, or a level outside 0.5 … 0.999.
    DataError
        For a channel that never changes.
    KeyError
        For an unknown channel.

    See Also
    --------
    analyze : fits all channels, without their disturbances.

    References
    ----------
    docs/theory/likelihood.md derives the likelihood; IEEE Std 952 names the terms.

    Examples
    --------
    >>> from sigmatau import NoiseModel, fit_channel, simulate
    >>> model = NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> record = simulate(model, duration=100, rate=100, rng=1)
    >>> fit_channel(record, "gyro_x", terms=["random_walk", "rate_random_walk"], processes=[])["random_walk"].observed
    True
    """
    need_record(record)
    if method not in get_args(FitMethod):
        raise OptionError(
            f"{{option}} must be one of {', '.join(get_args(FitMethod))}, not {method!r}", option="method"
        )
    if method == "gls":
        for option, argument in (("processes", processes), ("regressors", regressors)):
            if argument:
                raise OptionError("{option} need the likelihood: least squares has none", option=option)
    if regressors is not None and not isinstance(regressors, Mapping):
        raise OptionError(
            f"{{option}} must be a mapping of names to curves, not {regressors!r:.80}", option="regressors"
        )
    stream = record.stream_of(channel)
    if method == "likelihood" and usable(stream, channel):
        return by_likelihood(
            record, channel, terms=terms, processes=processes, regressors=regressors, level=level, step=step
        )
    return _by_curve(record, channel, curve, threads=threads, tau_min=tau_min, terms=terms, level=level)


def by_likelihood(
    record: Record,
    channel: str,
    *,
    terms: Sequence[str] | None = None,
    processes: Sequence[float] | Literal["matern"] | None = None,
    regressors: Mapping[str, ArrayLike] | None = None,
    level: float = 0.95,
    step: float | None = None,
) -> NoiseFit:
    """Fit the samples of a channel, with the temperature of the log if the channel follows it."""
    stream, curves = record.stream_of(channel), dict(regressors or {})
    degrees = None if TEMPERATURE in curves else sample_temperatures(record, stream)
    if degrees is not None:
        with_temperature = likelihood.fit_samples(
            stream,
            channel,
            terms=terms,
            processes=processes,
            regressors={**curves, TEMPERATURE: degrees},
            level=level,
            step=step,
        )
        if _ratio(with_temperature) > _MIN_RATIO:
            return with_temperature
    return likelihood.fit_samples(
        stream, channel, terms=terms, processes=processes, regressors=curves, level=level, step=step
    )


def follows_temperature(fitted: NoiseFit) -> bool:
    """Whether the channel follows the temperature of the log significantly."""
    return TEMPERATURE in fitted.regressors and _ratio(fitted) > _REPORTED_RATIO


def _ratio(fitted: NoiseFit) -> float:
    """Ratio of the temperature coefficient to its standard error."""
    coefficient = fitted.regressors[TEMPERATURE]
    assert coefficient.high is not None
    return float(
        abs(coefficient.value) / (coefficient.high - coefficient.value) * normal_quantile(0.5 + 0.5 * fitted.level)
    )


def sample_temperatures(record: Record, stream: Stream) -> NDArray[np.float64] | None:
    """Temperature at the samples, from the thermometer of the log; None if there is none, or if it contains no
    information.
    """
    thermometer = next((candidate for candidate in record.streams if candidate.quantity == "temperature"), None)
    if thermometer is None or thermometer is stream:
        return None
    count = min(stream.grid.n, _MAX_TEMPERATURES)
    edges = np.linspace(0.0, stream.grid.duration, count + 1)
    means = mean_temperatures(edges + stream.grid.start, thermometer)
    finite = np.isfinite(means)
    if finite.mean() < 1 - _MAX_UNKNOWN or not np.ptp(means[finite]) > 0:
        return None
    times = (np.arange(stream.grid.n) + 0.5) * stream.grid.tau0
    middle = (edges[1:] + edges[:-1]) / 2
    return np.asarray(np.interp(times, middle[finite], means[finite] - means[finite].mean()))


def _by_curve(
    record: Record,
    channel: str,
    curve: DeviationCurve | None,
    *,
    threads: int | None,
    tau_min: float | None,
    terms: Sequence[str] | None,
    level: float,
) -> NoiseFit:
    """Fit on half octaves with overlap, or on eighths of an octave if quantization noise dominates."""
    counting = "standard" if curve is None else curve.counting
    if curve is None or curve.overlap != "full" or not _on_half_octaves(curve):
        curve = channel_curve(record, channel, taus="half", counting=counting, threads=threads)
    fitted = fit(curve, tau_min=tau_min, terms=terms, level=level)
    reason = fitted.reasons[0] if fitted.reasons else None
    if isinstance(reason, IncompleteRecord) and not usable(record.stream_of(channel), channel):
        return replace(fitted, reasons=(replace(reason, suits_likelihood=False),))
    noise = fitted.observed.get("quantization")
    if noise is None or len(fitted.observed) < _MIN_TERMS:
        return fitted
    share = avar("quantization", noise, m=_QUANTIZATION_SIZE, tau0=curve.tau0) / fitted.avar(m=_QUANTIZATION_SIZE)
    if float(share[0]) < _QUANTIZATION_SHARE:
        return fitted
    eighths = channel_curve(record, channel, taus="eighth", counting=counting, threads=threads)
    return fit(eighths, tau_min=tau_min, terms=terms, level=level)


def _on_half_octaves(curve: DeviationCurve) -> bool:
    half = cluster_sizes("half", n=curve.n - (curve.counting == "paper"), tau0=curve.tau0)
    return np.array_equal(half, curve.m)
