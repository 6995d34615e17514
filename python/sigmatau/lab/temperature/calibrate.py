"""`calibrate_temperature`: noise and bias of a sensor over temperature from one log."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sigmatau import Analysis, Record, Stream, allan, analyze
from sigmatau._native.distributions import normal_quantile
from sigmatau.arrays import Floats
from sigmatau.errors import NotAtRestError, OptionError
from sigmatau.lab.temperature.bias_fit import MAX_DEGREE, BiasFit, fit_bias
from sigmatau.lab.temperature.branches import Blocks, Span, find_spans, find_thermometer, split_blocks
from sigmatau.lab.temperature.noise_by_window import noise_terms, window_terms
from sigmatau.lab.temperature.polynomial import BiasPolynomial, from_scaled
from sigmatau.lab.temperature.result import ChannelCalibration, TemperatureCalibration, TemperatureWindow

ROOM = 25.0
"""Reference temperature of polynomials, if it was observed; otherwise the middle of the range. [°C]"""

_BRANCHES = {1: "rising", -1: "falling", 0: ""}
_QUANTITIES = ("angular_rate", "acceleration", "signal")


def calibrate_temperature(
    record: Record,
    *,
    channels: Sequence[str] | None = None,
    degree: int | None = None,
    reference: float | None = None,
    level: float = 0.95,
    unit_name: str = "",
    threads: int | None = None,
) -> TemperatureCalibration:
    """Noise and bias over temperature from a log with a thermometer: a ramp, or a soak in steps.

    Each soak, or window of a ramp, gets its mean and the coefficients of its noise. The bias is fitted by a polynomial of
    temperature and, if the temperature rose and fell, a hysteresis, the difference of the two branches.

    Parameters
    ----------
    record : Record
        Record at rest, with a thermometer that varies by 5 K or more.
    channels : sequence of str, optional
        Names of channels or sensors (``"gyro"``). Default: all.
    degree : int, optional
        Degree of the polynomial, 1 to 5. Default: at most 3, without the highest coefficients that are smaller than
        their standard errors.
    reference : float, optional
        Temperature about which the polynomial is written. [°C] Default: 25 °C if observed, or the middle of the range.
    level : float
        Confidence level of intervals.
    unit_name : str
        Serial number of the sensor.
    threads : int, optional
        Default: all cores. The result does not depend on it.

    Returns
    -------
    TemperatureCalibration

    Raises
    ------
    DataError
        If the log has no thermometer, its temperature does not vary, it is too short, or the sensor moved
        (`NotAtRestError`).
    OptionError
        For an unknown channel, a degree outside 1 … 5, a reference outside the observed range, or a level outside
        0.5 … 0.999.

    See Also
    --------
    calibrate_over_runs : from runs at several temperatures.
    TemperatureCalibration.export : files of autopilots.

    Notes
    -----
    Intervals of means, of coefficients of the polynomial and of the hysteresis account for random walk, bias instability
    and rate random walk, and for their uncertainty; see ``docs/theory/temperature.md``.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> rate = st.simulate(model, duration=3600, rate=10, rng=1).streams[0].column("gyro_x")
    >>> temperature = np.concatenate([np.linspace(-10, 50, 18000), np.linspace(50, -10, 18000)])
    >>> log = st.Record.from_arrays(rate=10, gyro_x=rate + 2e-6 * (temperature - 25), temperature=temperature)
    >>> result = st.calibrate_temperature(log, degree=1)
    >>> slope, error = result["gyro_x"].polynomial.coefficients[1], result["gyro_x"].polynomial.errors[1]
    >>> bool(abs(slope - 2e-6) < error)
    True
    """
    _check(degree, level)
    thermometer = find_thermometer(record)
    chosen = _chosen(record, channels)
    parts = {}
    by_stream: dict[str, Blocks] = {}
    firsts: dict[str, str] = {}
    for channel in chosen:
        stream = record.stream_of(channel)
        if firsts.setdefault(stream.name, channel) == channel:
            by_stream[stream.name] = split_blocks(stream, thermometer)
        blocks = by_stream[stream.name]
        parts[channel] = _fit(stream, channel, blocks, degree=degree, reference=reference, level=level)
    temperatures = {
        name: _sample_temperatures(record.stream_of(first), by_stream[name]) for name, first in firsts.items()
    }
    compensated = _compensated(
        record, {channel: polynomial for channel, (_, polynomial) in parts.items()}, temperatures
    )
    analysis = analyze(compensated, threads=threads)
    _refuse_motion(analysis)
    raw = allan(_select_channels(record, chosen), threads=threads)
    results = {}
    for channel in parts:
        stream = compensated.stream_of(channel)
        blocks = by_stream[stream.name]
        clean = _without_disturbances(stream, channel, analysis)
        # The disturbances that the analysis has found are left out of the means too.
        original = _without_disturbances(record.stream_of(channel), channel, analysis)
        overall = noise_terms(clean, parts[channel][0].columns(blocks, temperatures[stream.name]), level=level)
        walk = overall["random_walk"].value if "random_walk" in overall else None
        fitted, polynomial = _fit(original, channel, blocks, degree=degree, reference=reference, level=level, walk=walk)
        means = blocks.means(original, channel)
        results[channel] = ChannelCalibration(
            channel=channel,
            quantity=stream.quantity,
            unit=stream.unit,
            windows=tuple(
                _window(span, blocks, means, fitted, clean, temperatures[stream.name], level=level)
                for span in find_spans(blocks)
            ),
            polynomial=polynomial,
            overall=overall,
            hysteresis=fitted.hysteresis(level=level, unit=stream.unit),
            raw=raw.get(channel),
            compensated=analysis.curves.get(channel),
        )
    return TemperatureCalibration(
        channels=results,
        source=record.provenance.path or "",
        low=min(blocks.low for blocks in by_stream.values()),
        high=max(blocks.high for blocks in by_stream.values()),
        level=level,
        unit_name=unit_name,
        remarks=_remarks(results, by_stream),
    )


def _check(degree: int | None, level: float) -> None:
    if degree is not None and (isinstance(degree, bool) or degree not in range(1, MAX_DEGREE + 1)):
        raise OptionError(f"{{option}} must be 1 to {MAX_DEGREE}, not {degree!r}", option="degree")
    if not 0.5 <= level <= 0.999:
        raise OptionError(f"{{option}} must be 0.5 to 0.999, not {level!r}", option="level")


def _chosen(record: Record, channels: Sequence[str] | None) -> list[str]:
    names = [name for stream in record.streams if stream.quantity in _QUANTITIES for name in stream.channels]
    if channels is None:
        return names
    chosen = []
    for word in channels:
        matching = [name for name in names if word in (name, record.stream_of(name).name)]
        if not matching:
            raise OptionError(f"{{option}} names {word!r}; channels: {', '.join(names)}", option="channels")
        chosen += matching
    return list(dict.fromkeys(chosen))


def _select_channels(record: Record, channels: Sequence[str]) -> Record:
    streams = [
        stream.of([name for name in stream.channels if name in channels])
        for stream in record.streams
        if any(name in channels for name in stream.channels)
    ]
    return replace(record, streams=tuple(streams))


def _fit(
    stream: Stream,
    channel: str,
    blocks: Blocks,
    *,
    degree: int | None,
    reference: float | None,
    level: float,
    walk: float | None = None,
) -> tuple[BiasFit, BiasPolynomial]:
    """Fit the block means of a channel; return the fit and its polynomial.

    `walk`: random walk of the channel, if it is known.
    """
    white = None if walk is None else walk**2 / blocks.length
    fitted = fit_bias(blocks, blocks.means(stream, channel), degree=degree, white=white)
    origin = reference
    if origin is None:
        origin = ROOM if blocks.low <= ROOM <= blocks.high else (blocks.low + blocks.high) / 2
    elif not blocks.low <= origin <= blocks.high:
        raise OptionError(
            f"{{option}} {origin:g} °C is outside the observed {blocks.low:.4g} to {blocks.high:.4g} °C",
            option="reference",
        )
    p = fitted.degree + 1
    polynomial = from_scaled(
        fitted.fitted.coefficients[:p],
        fitted.fitted.covariance[:p, :p],
        scaled=(blocks.low, blocks.high),
        low=blocks.low,
        high=blocks.high,
        reference=origin,
        level=level,
        unit=stream.unit,
    )
    return fitted, polynomial


def _sample_temperatures(stream: Stream, blocks: Blocks) -> Floats:
    """Temperature at each sample of a stream, interpolated between block means, which removes its noise; shape (n,). [°C]"""
    finite = np.isfinite(blocks.temperature)
    middle = (np.flatnonzero(finite) + 0.5) * blocks.samples
    return np.asarray(np.interp(np.arange(stream.grid.n) + 0.5, middle, blocks.temperature[finite]))


def _compensated(record: Record, polynomials: dict[str, BiasPolynomial], temperatures: dict[str, Floats]) -> Record:
    """Subtract the polynomials, except for their constants, from the channels; the thermometer is omitted."""
    streams = []
    for stream in _select_channels(record, [*polynomials]).streams:
        t = temperatures[stream.name]
        columns = []
        for channel in stream.channels:
            polynomial = polynomials[channel]
            powers = (t - polynomial.reference)[:, None] ** np.arange(1, polynomial.degree + 1)
            columns.append(stream.column(channel) - powers @ polynomial.coefficients[1:])
        streams.append(stream.with_rates(columns))
    return replace(record, streams=tuple(streams))


def _refuse_motion(analysis: Analysis) -> None:
    if analysis.rest is not None and analysis.rest.verdict != "at_rest":
        raise NotAtRestError(
            f"the sensor is {analysis.rest.verdict.replace('_', ' ')} over the temperature cycle. Keep it still, or leave"
            " out the motion"
        )


def _without_disturbances(stream: Stream, channel: str, analysis: Analysis) -> Stream:
    """The channel alone, NaN where the analysis left samples out."""
    values = stream.column(channel).copy()
    if channel in analysis.masks:
        values[analysis.mask(channel).excluded] = np.nan
    mask = ~np.isfinite(values)[:, None]
    return replace(stream.only(channel).with_rates([values]), mask=mask if mask.any() else None)


def _window(
    span: Span,
    blocks: Blocks,
    means: Floats,
    fitted: BiasFit,
    stream: Stream,
    temperature: Floats,
    *,
    level: float,
) -> TemperatureWindow:
    """Mean and noise of a channel in a window."""
    inside = np.zeros(len(means))
    inside[span.first : span.stop] = 1.0
    inside *= fitted.present
    t = blocks.temperature[span.first : span.stop]
    weights = inside[fitted.present] / max(inside.sum(), 1.0)
    mean = float(weights @ means[fitted.present])
    half = float(normal_quantile((1 + level) / 2) * np.sqrt(max(weights @ fitted.fitted.noise @ weights, 0.0)))
    start, stop = span.first * blocks.samples, min(span.stop * blocks.samples, stream.grid.n)
    return TemperatureWindow(
        name="",
        start=blocks.start + span.first * blocks.length,
        stop=blocks.start + span.stop * blocks.length,
        temperature=float(np.nanmean(t)),
        span=float(np.nanmax(t) - np.nanmin(t)),
        branch=_BRANCHES[span.direction],
        held=span.held,
        mean=mean,
        low=mean - half,
        high=mean + half,
        terms=window_terms(stream, temperature, start, stop, level=level),
    )


def _remarks(results: dict[str, ChannelCalibration], by_stream: dict[str, Blocks]) -> tuple[str, ...]:
    remarks = []
    if any(result.hysteresis is None for result in results.values()):
        directions = {int(d) for blocks in by_stream.values() for d in blocks.direction}
        word = "rises" if 1 in directions else "falls"
        remarks.append(f"hysteresis is not observable: the temperature only {word}")
    if all(not window.terms for result in results.values() for window in result.windows):
        remarks.append("the windows are too short for coefficients of noise; ramp more slowly or soak longer")
    return tuple(remarks)
