"""The numbers that the charts of a report draw: plain values for JSON, few enough for a page that is sent by mail.

Curves and densities have five digits. Long series are `packed` as sixteen-bit integers.
"""

from __future__ import annotations

import base64
import math
import threading
from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau._native import kernels
from sigmatau.analysis import Analysis
from sigmatau.arrays import Floats
from sigmatau.errors import RecordTooShortError
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.estimators.stability import dynamic_allan
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.noise import terms
from sigmatau.noise.terms import TERMS, asked_rate_unit
from sigmatau.plot.stability import chance_limits
from sigmatau.quality.facts import in_threads
from sigmatau.record.mask import ChannelMask
from sigmatau.record.record import Record, stream_name
from sigmatau.record.streams import Stream
from sigmatau.reporting.envelope import envelope
from sigmatau.spectrum.estimate import psd
from sigmatau.units import FIGURE_UNITS, find

_DIGITS = 5
_MAX_TAUS = 240  # largest number of averaging times of a curve
_PER_OCTAVE, _PER_LOW_OCTAVE = 24, 8  # densities per octave, from many segments and from a few tapers
# largest and smallest number of intervals of a time series; number of channels up to which each has the largest
_BINS, _MIN_BINS, _FULL_CHANNELS = 2000, 300, 12
_WINDOWS = 20  # windows of a map in the length of the record
_STEPS_PER_WINDOW = 4
_NAN_CODE = 0xFFFF  # code of NaN in packed numbers

LONGEST = 1 << 24
"""Largest number of samples of a stream for its densities and its map; later samples are ignored."""

TITLES = {"angular_rate": "Gyroscope", "acceleration": "Accelerometer"}


def collect_charts(analysis: Analysis, record: Record | None, used: Record | None) -> dict[str, Any]:
    """Collect the sensors with their units and channels, and the charts of each channel.

    Parameters
    ----------
    analysis : Analysis
    record : Record or None
        The record as it was given to the analysis, for the time series.
    used : Record or None
        The part of it that was analysed, for densities and maps.
    """
    kinds: Mapping[str, Kind] = analysis.curves if record is None else _kinds(analysis, record)
    names = tuple(kinds)
    bins = max(_MIN_BINS, min(_BINS, _BINS * _FULL_CHANNELS // len(names)))
    channels: dict[str, dict[str, Any]] = {name: {} for name in names}
    for name, curve in analysis.curves.items():
        channels[name]["deviation"] = _deviation(curve, analysis.fits.get(name))
    if record is not None and used is not None:
        lock = threading.Lock()
        samples = in_threads(lambda name: _sample_charts(analysis, record, used, name, bins, lock), names)
        for name in names:
            channels[name] |= samples[name]
    return {"sensors": collect_sensors(kinds), "channels": channels}


def collect_sensors(kinds: Mapping[str, Kind]) -> list[dict[str, Any]]:
    """The sensors of some channels, with the units that their charts offer."""
    sensors: dict[str, dict[str, Any]] = {}
    for channel, kind in kinds.items():
        name = stream_name(channel)
        if name not in sensors:
            units = [(unit.text, unit.factor) for unit in map(find, FIGURE_UNITS.get(kind.quantity, ()))] or [
                (kind.unit, 1.0)
            ]
            asked = asked_rate_unit(kind.quantity, kind.unit)
            units = units if asked is None else [asked, *(unit for unit in units if unit[0] != asked[0])]
            sensors[name] = {
                "name": name,
                "title": TITLES.get(kind.quantity, name),
                "units": [{"text": text, "factor": factor} for text, factor in units],
                "channels": [],
            }
        sensors[name]["channels"].append(channel)
    return list(sensors.values())


class Kind(Protocol):
    """Quantity and unit of a channel."""

    @property
    def quantity(self) -> str: ...
    @property
    def unit(self) -> str: ...


def _kinds(analysis: Analysis, record: Record) -> dict[str, Kind]:
    """Channels of a record, including those that were not analysed: a reader may look for a dead axis or a thermometer."""
    streams: dict[str, Kind] = {channel: stream for stream in record.streams for channel in stream.channels}
    return {channel: analysis.curves.get(channel, stream) for channel, stream in streams.items()}


def _sample_charts(
    analysis: Analysis, record: Record, used: Record, channel: str, bins: int, lock: threading.Lock
) -> dict[str, Any]:
    """Density, time series and map of a channel. A chart is left out if the channel is too short for it or was not
    analysed. Densities are computed one after the other: each needs six times the memory of its samples.
    """
    whole = record.stream_of(channel)
    mask = analysis.masks.get(channel) if channel in analysis.curves else None
    charts: dict[str, Any] = {"series": _series(whole, channel, mask, bins)}
    if mask is None:
        return charts
    part = used.stream_of(channel).only(channel)
    if part.grid.n > LONGEST:
        part = part.cut(0, LONGEST)
    with lock:
        density = _density(part, channel, analysis.fits.get(channel))
    if density is not None:
        charts["density"] = density
    if (map_ := _map(part, channel)) is not None:
        charts["map"] = map_
    return charts


def _deviation(curve: DeviationCurve, fitted: NoiseFit | None) -> dict[str, Any]:
    """A curve with its interval, its model and the parts of the model."""
    shown = _thinned(curve.tau)
    shown = shown[curve.adev[shown] > 0]
    low, high = curve.interval()
    chart: dict[str, Any] = {
        "tau": digits(curve.tau[shown]),
        "adev": digits(curve.adev[shown]),
        "low": digits(low[shown]),
        "high": digits(high[shown]),
        "interval": curve.interval_text,
        "missing": float(f"{curve.missing / curve.n:.3g}"),
    }
    if fitted is None or not (fitted.model or fitted.gauss_markov) or fitted.tau_min is None:
        return chart
    m = curve.m[shown]
    with np.errstate(invalid="ignore"):
        chart["model"] = digits(np.sqrt(fitted.avar(m=m)))
        chart["parts"] = {name: digits(np.sqrt(part)) for name, part in _parts(fitted, m).items()}
    chart["from"], chart["to"] = fitted.tau_min, fitted.tau_max
    return chart


def _parts(fitted: NoiseFit, m: NDArray[np.int64]) -> dict[str, Floats]:
    """Allan variances of the parts of a model, by label."""
    tau0 = fitted.tau0
    parts = {
        f"{TERMS[name].label(fitted.quantity)} {TERMS[name].symbols[0]}": terms.avar(name, value, m=m, tau0=tau0)
        for name, value in fitted.model.items()
    }
    for process in fitted.gauss_markov:
        sigma, time = process.sigma.value, process.time.value
        parts[f"Gauss-Markov process, {time:.3g} s"] = kernels.gauss_markov_avar(sigma, time, m, tau0)
    for band in fitted.resonance:
        centre, width = band.frequency.value, band.width.value
        avar = kernels.resonance_avar(band.sigma.value, centre, width, m, tau0, folded=False)
        parts[f"resonance, {centre:.3g} Hz"] = avar
    return parts


def _thinned(tau: Floats) -> NDArray[np.intp]:
    """Indices of at most `_MAX_TAUS` averaging times, evenly spaced on a logarithmic scale."""
    if len(tau) <= _MAX_TAUS:
        return np.arange(len(tau))
    wanted = np.geomspace(tau[0], tau[-1], _MAX_TAUS)
    return np.unique(np.searchsorted(tau, wanted * (1 - 1e-9)).clip(0, len(tau) - 1))


def _density(stream: Stream, channel: str, fitted: NoiseFit | None) -> dict[str, Any] | None:
    """Densities from sine tapers at low frequencies, and from segments above; None for a record that is too short."""
    try:
        (short,) = psd(stream).values()
        (long,) = psd(stream, method="multitaper", f_max=max(short.trusted, 5.0 / stream.grid.duration)).values()
    except RecordTooShortError:
        return None
    parts_shown = []
    parts = ((long, _PER_LOW_OCTAVE, long.trusted, short.trusted), (short, _PER_OCTAVE, short.trusted, math.inf))
    for spectrum, per_octave, first, last in parts:
        binned = spectrum.binned(per_octave=per_octave)
        chosen = (binned.frequency >= first) & (binned.frequency < last) & (binned.density > 0)
        parts_shown.append([column[chosen] for column in (binned.frequency, binned.density, *binned.interval())])
    frequency, density, low, high = (np.concatenate(columns) for columns in zip(*parts_shown, strict=True))
    chart: dict[str, Any] = {
        "frequency": digits(frequency),
        "density": digits(density),
        "low": digits(low),
        "high": digits(high),
    }
    if fitted is not None and fitted.quantified:
        chart["model"] = digits(fitted.psd(frequency))
        chart["lines"] = [line.frequency.value for line in fitted.sinusoid]
        if fitted.highest is not None:
            chart["highest"] = fitted.highest
    return chart


def _series(stream: Stream, channel: str, mask: ChannelMask | None, bins: int) -> dict[str, Any]:
    """Smallest and largest sample of each interval of the whole record, and the spans that were not analysed.

    Without a mask the whole record was not analysed. A thermometer is never marked: it is there to explain the others.
    """
    n, grid = stream.grid.n, stream.grid
    low, high, edges = envelope(stream, channel, bins)
    outside = [] if stream.quantity == "temperature" else [(0, n)]
    if mask is not None:
        outside = [(span.start, span.stop) for span in mask.spans]
    # Spans closer than one interval look like one.
    joined: list[list[int]] = []
    for start, stop in outside:
        if joined and start - joined[-1][1] < n / bins:
            joined[-1][1] = stop
        else:
            joined.append([start, stop])
    return {
        "from": grid.lead,
        "duration": grid.duration,
        "bins": len(edges) - 1,
        "low": packed(low),
        "high": packed(high),
        "outside": [[float(f"{grid.time(x):.9g}") for x in span] for span in joined],
    }


def _map(stream: Stream, channel: str) -> dict[str, Any] | None:
    """The dynamic Allan deviation; None for a record that is too short for a window."""
    window = stream.grid.duration / _WINDOWS
    try:
        dynamic = dynamic_allan(stream, channel, window=window, step=window / _STEPS_PER_WINDOW, threads=1)
    except (RecordTooShortError, ValueError):
        return None
    with np.errstate(divide="ignore", invalid="ignore"):
        logarithm = np.log10(np.where(dynamic.adev > 0, dynamic.adev, np.nan))
    if not np.isfinite(logarithm).any():
        return None
    low, high = chance_limits(len(dynamic.times), dynamic)
    return {
        "least": digits(low),
        "most": digits(high),
        "times": digits(dynamic.times),
        "tau": digits(dynamic.tau),
        "window": dynamic.window,
        "log10": packed(logarithm.ravel()),
    }


def digits(values: ArrayLike) -> list[float | None]:
    """Round numbers to five digits; None for a number that is not finite."""
    return [
        float(f"{x:.{_DIGITS}g}") if math.isfinite(x) else None for x in np.asarray(values, dtype=np.float64).tolist()
    ]


def packed(values: Floats) -> dict[str, Any]:
    """Encode numbers as base64 of unsigned sixteen-bit integers: 0 to 65534 from the smallest to the largest, 65535 for
    NaN.
    """
    finite = np.isfinite(values)
    low, high = (float(values[finite].min()), float(values[finite].max())) if finite.any() else (0.0, 0.0)
    span = high / 2 - low / 2  # halved, because the difference of two doubles may overflow
    scaled = np.full(len(values), _NAN_CODE, dtype="<u2")
    if span > 0:
        scaled[finite] = np.round((values[finite] / 2 - low / 2) / span * (_NAN_CODE - 1)).astype("<u2")
    else:
        scaled[finite] = 0
    return {"low": low, "high": high, "data": base64.b64encode(scaled.tobytes()).decode("ascii")}


def unpacked(values: Mapping[str, Any]) -> Floats:
    """Decode what `packed` encoded."""
    scaled = np.frombuffer(base64.b64decode(values["data"]), dtype="<u2")
    low, high = values["low"], values["high"]
    numbers = low + (high / 2 - low / 2) * (scaled / (_NAN_CODE - 1)) * 2
    return np.where(scaled == _NAN_CODE, np.nan, numbers)
