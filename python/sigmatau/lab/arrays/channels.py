"""Channels of an array on one grid: selects them, aligns several logs, and refuses channels that are not an array."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from sigmatau import Record, Stream
from sigmatau.arrays import Bools, Floats, runs
from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.hints import Hint

_SAME_RATE = 0.25  # largest distance of the grids of two logs, at their starts and at their ends [samples]
_LARGEST_ARRAY = 32  # number of channels; Judgement: a fit of more takes minutes
# Largest share of incomplete rows that are filled. [1] Derived: the likelihood then counts this share of the samples
# twice.
_FILLED = 0.02
_LEAST_SAMPLES = 1024  # smallest number of samples; Judgement: 512 for each half
_LEAST_MEANS = 32  # number of samples on each side of a gap from which its mean is computed, at least
_OPPOSITE_GRAVITY = 3.0  # mean acceleration of both signs above which sensors point in opposite directions [m/s²]


@frozen(eq=False)
class ArrayRecord:
    """Synchronous samples of several sensors.

    Attributes
    ----------
    names : tuple of str
    sources : tuple of str
        File of each channel; empty if all are from one log.
    record : Record
        These channels, and the thermometers of the log.
    """

    names: tuple[str, ...]
    sources: tuple[str, ...]
    record: Record

    @property
    def samples(self) -> Floats:
        """Rates in SI, shape (n, N); NaN where samples are missing."""
        return np.stack([self.record.stream_of(name).column(name) for name in self.names])


def collect_channels(
    record: Record | Sequence[Record], channels: Sequence[str] | None, invert: Sequence[str]
) -> ArrayRecord:
    """Select the channels of an array, and reverse the sign of those in `invert`.

    Raises `OptionError` for a wrong name, and `DataError` for channels that are not synchronous.
    """
    records = [record] if isinstance(record, Record) else list(record)
    if not records or not all(isinstance(each, Record) for each in records):
        raise TypeError("`record` must be a Record, or several, such as [sigmatau.read(log) for log in logs]")
    columns, sources, streams = _chosen(records, channels)
    _check_synchronous(streams, sources or list(columns))
    unknown = [name for name in invert if name not in columns]
    if unknown:
        raise OptionError(f"{{option}} names {unknown[0]!r}; channels: {', '.join(columns)}", option="invert")
    if len(columns) > _LARGEST_ARRAY:
        raise OptionError(f"{{option}}: at most {_LARGEST_ARRAY}, not {len(columns)}", option="axes")
    first = streams[0]
    starts = [round(_offset(stream, first)) for stream in streams]
    begin = max(starts)
    length = min(stream.grid.n + start for stream, start in zip(streams, starts, strict=True)) - begin
    if length < _LEAST_SAMPLES:
        raise DataError(f"the channels have {max(length, 0)} common samples; at least {_LEAST_SAMPLES} are needed")
    arrays: dict[str, Any] = {
        name: (-1.0 if name in invert else 1.0) * values[begin - start : begin - start + length]
        for (name, values), start in zip(columns.items(), starts, strict=True)
    }
    combined = make_record(arrays, first)
    thermometers = tuple(s for s in records[0].streams if s.quantity == "temperature") if len(records) == 1 else ()
    return ArrayRecord(
        names=tuple(columns),
        sources=tuple(sources),
        record=replace(combined, streams=(*combined.streams, *thermometers), provenance=records[0].provenance),
    )


def make_record(arrays: Mapping[str, Floats], like: Stream) -> Record:
    """A record of rates in SI by channel, with the quantity, rate and source of rate of a stream."""
    unit = dict.fromkeys(arrays, like.unit) if like.quantity == "signal" else {}
    columns: dict[str, Any] = dict(arrays)
    record = Record.from_arrays(rate=like.grid.rate, unit=unit, **columns)
    streams = (replace(s, grid=replace(s.grid, source=like.grid.source)) for s in record.streams)
    return replace(record, streams=tuple(streams))


def _chosen(
    records: Sequence[Record], channels: Sequence[str] | None
) -> tuple[dict[str, Floats], list[str], list[Stream]]:
    """Chosen columns by name, their files, and their streams."""
    if len(records) == 1:
        record = records[0]
        names = list(channels) if channels else _only_sensor(record)
        _check_names(record, names)
        if len({*names}) < len(names):
            raise OptionError(f"{{option}} names a channel twice: {', '.join(names)}", option="axes")
        streams = [record.stream_of(name) for name in names]
        return {name: s.column(name) for name, s in zip(names, streams, strict=True)}, [], list(streams)
    columns, sources, streams_of_logs = {}, [], []
    for number, record in enumerate(records, 1):
        names = list(channels) if channels else _only_sensor(record)
        _check_names(record, names)
        if len(names) > 1:
            raise OptionError(
                f"{{option}}: several logs have one channel each, e.g. {names[0]}, not {', '.join(names)}",
                option="axes",
            )
        columns[f"{names[0]}_{number}"] = record.stream_of(names[0]).column(names[0])
        sources.append(record.provenance.path or f"log {number}")
        streams_of_logs.append(record.stream_of(names[0]))
    return columns, sources, streams_of_logs


def _only_sensor(record: Record) -> list[str]:
    """Channels of the only sensor of a log; raises `OptionError` if there are several."""
    streams = [stream for stream in record.streams if stream.quantity != "temperature"]
    quantities = {stream.quantity for stream in streams}
    if len(quantities) != 1:
        names = ", ".join(name for stream in streams for name in stream.channels)
        raise OptionError(f"{{option}} are missing: name the sensors of one axis; the log has {names}", option="axes")
    channels = [name for stream in streams for name in stream.channels]
    if len(channels) > 1 and {name.rpartition("_")[2] for name in channels} <= {"x", "y", "z"}:
        names = ", ".join(channels)
        raise OptionError(
            f"{{option}} are missing: {names} are the axes of one sensor. Name the sensors of one axis", option="axes"
        )
    return channels


def _check_names(record: Record, names: Sequence[str]) -> None:
    unknown = [name for name in names if name not in record.channels]
    if unknown:
        raise OptionError(f"{{option}} names {unknown[0]!r}; the log has {', '.join(record.channels)}", option="axes")


def _check_synchronous(streams: Sequence[Stream], names: Sequence[str]) -> None:
    """Raise `DataError` for channels with different quantities, rates or clocks."""
    first = streams[0]
    for name, stream in zip(names, streams, strict=True):
        if (stream.quantity, stream.unit) != (first.quantity, first.unit):
            raise DataError(f"{names[0]} is in {first.unit} and {name} in {stream.unit}: an array has one quantity")
        drift = abs(stream.grid.tau0 / first.grid.tau0 - 1) * min(stream.grid.n, first.grid.n)
        if drift > _SAME_RATE:
            raise DataError(
                f"{names[0]} and {name} have different rates, {first.grid.rate:.8g} and {stream.grid.rate:.8g} Hz. An array"
                " needs synchronous samples: one clock, or resampled logs"
            )
        offset = _offset(stream, first)
        if abs(offset - round(offset)) > _SAME_RATE:
            raise DataError(
                f"{names[0]} and {name} are not synchronous: they are {abs(offset - round(offset)):.2f} samples apart."
                " Sample all sensors by one clock"
            )


def _offset(stream: Stream, first: Stream) -> float:
    """Start of a stream after that of the first. [samples]"""
    grid, reference = stream.grid, first.grid
    return ((grid.epoch - reference.epoch) + (grid.start - reference.start)) / reference.tau0


def refuse_unusable(names: Sequence[str], samples: Floats, quantity: str) -> None:
    """Raise `DataError` for a dead sensor, a duplicated column, or accelerometers in opposite directions."""
    with np.errstate(invalid="ignore"):
        spread = np.nanmax(samples, axis=1) - np.nanmin(samples, axis=1)
    for name, size in zip(names, spread, strict=True):
        if not size > 0:
            raise DataError(
                f"{name} never changes: a dead sensor has no noise to weigh. Leave it out of {Hint('axes')}"
            )
    for i, name in enumerate(names):
        for j in range(i):
            if np.array_equal(samples[i], samples[j], equal_nan=True):
                raise DataError(f"{names[j]} and {name} are identical: one sensor, written twice. Leave one out")
    if quantity == "acceleration":
        means = np.nanmean(samples, axis=1)
        for name, mean in zip(names, means, strict=True):
            if mean * means[0] < 0 and min(abs(mean), abs(means[0])) > _OPPOSITE_GRAVITY:
                raise DataError(
                    f"{names[0]} and {name} measure gravity with opposite signs, {means[0]:.2f} and {mean:.2f} m/s². Invert"
                    f" one: {Hint('invert', value=name)}"
                )


def complete_rows(samples: Floats, excluded: Bools) -> tuple[Floats, int]:
    """Samples without gaps: with filled gaps if few samples are missing, otherwise the longest stretch without a gap.

    Returns the samples and the number of filled rows. A gap is filled with a straight line between the means on both
    sides, plus the noise of the rows before it (or after it). Rows are copied whole, so that white noise has the same
    covariance.
    """
    incomplete = excluded | ~np.isfinite(samples).all(axis=0)
    n = len(incomplete)
    gaps = runs(incomplete)
    if not gaps:
        return samples, 0
    begin = gaps[0][1] if gaps[0][0] == 0 else 0
    end = gaps[-1][0] if gaps[-1][1] == n else n
    inner = [(a, b) for a, b in gaps if a >= begin and b <= end]
    count = sum(b - a for a, b in inner)
    longest = max((b - a for a, b in inner), default=0)
    if count > _FILLED * (end - begin) or longest > (end - begin) // 8:
        begin, end = max(runs(~incomplete), key=lambda run: run[1] - run[0], default=(0, 0))
        inner, count = [], 0
    if end - begin < _LEAST_SAMPLES:
        raise DataError(
            f"the longest stretch with samples of all channels has {end - begin} rows; at least {_LEAST_SAMPLES} are needed"
        )
    filled = samples[:, begin:end].copy()
    missing = incomplete[begin:end]
    for a, b in inner:
        _fill(filled, missing, a - begin, b - begin)
        missing[a - begin : b - begin] = False
    return filled, count


def _fill(samples: Floats, missing: Bools, start: int, stop: int) -> None:
    """Fill the rows from `start` to `stop` in place."""
    width = max(stop - start, _LEAST_MEANS)
    before = np.flatnonzero(~missing[:start])[-width:]
    after = stop + np.flatnonzero(~missing[stop:])[:width]
    ends = [rows for rows in (before, after) if len(rows)]
    means = [samples[:, rows].mean(axis=1, keepdims=True) for rows in (ends[0], ends[-1])]
    ramp = (np.arange(stop - start) + 0.5) / (stop - start)
    source = before if len(before) >= stop - start else after
    rows = np.resize(source, stop - start)
    noise = samples[:, rows] - samples[:, source].mean(axis=1, keepdims=True)
    samples[:, start:stop] = means[0] + (means[1] - means[0]) * ramp + noise
