"""Sampling times of a table, from its stamps, from the rate that the file states, or from the rate that the user gives."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from sigmatau import units
from sigmatau._native import kernels
from sigmatau.arrays import median
from sigmatau.errors import OptionError, RecordTooShortError
from sigmatau.findings.finding import Finding
from sigmatau.findings.stamps import Jitter
from sigmatau.hints import RATE, TIME_COLUMN
from sigmatau.io.read.columns import ColumnChoice, no_time
from sigmatau.io.read.options import Options
from sigmatau.io.read.resolve import SI
from sigmatau.io.read.table import Table
from sigmatau.io.read.time import stamps
from sigmatau.io.read.time.overflows import read_clock_digits
from sigmatau.io.read.time.plausible import (
    RateContradiction,
    ask_for_sample_numbers,
    ask_for_unit,
    find_stride,
    is_confirmed,
    is_one_nominal_rate,
    unit_by_rate,
    unit_by_size,
    unit_for,
)
from sigmatau.io.read.time.rows import in_order
from sigmatau.io.read.time.stamps import Timing
from sigmatau.record.missing import missing_values
from sigmatau.record.record import MIN_SAMPLES, stream_name
from sigmatau.record.sampling import GIVEN_RATE
from sigmatau.record.streams import CHUNK, Stream


def find_timing(
    table: Table,
    choice: ColumnChoice,
    raw: Mapping[int, NDArray[Any]],
    spelled: str | None,
    options: Options,
    stream: str = "",
    stream_rows: NDArray[np.int64] | None = None,
) -> Timing:
    """Sampling times of all rows, or of the rows `stream_rows` if only one stream fills these."""
    if choice.time is None:
        if options.rate is None and table.rate is None:
            raise OptionError(f"has no time column: give {RATE}, or name the column with {TIME_COLUMN}", option="rate")
        if options.rate is None and table.rate is not None:
            note = f"sampling rate {table.rate:.6g} Hz from {table.rate_source}"
            return Timing(rate=table.rate, measured=table.rate, source=table.rate_source, notes=(note,))
        return _by_statement(table, options, stream_rows)
    name = table.label(choice.time)
    stamps_raw = raw[choice.time]
    clock = read_clock_digits(stamps_raw) if spelled in {None, "s"} else None
    if clock is not None:
        stamps_raw, spelled = clock, "s"
    members = [i for channel, i in choice.channels.items() if not stream or stream_name(channel) == stream]
    if stream_rows is None:
        used = in_order(stamps_raw, [raw[i] for i in members], table.where, name)
    else:
        if len(stream_rows) < MIN_SAMPLES:
            raise RecordTooShortError(
                f"has {len(stream_rows)} rows with {stream}; at least {MIN_SAMPLES} are needed",
                need=MIN_SAMPLES,
                got=len(stream_rows),
            )
        used = in_order(stamps_raw[stream_rows], [raw[i][stream_rows] for i in members], table.where, name, stream_rows)
    if len(used.stamps) < 2:
        raise RecordTooShortError(
            f"has {len(used.stamps)} rows with a time stamp", need=MIN_SAMPLES, got=len(used.stamps)
        )
    stride = find_stride(used.stamps, used.intervals) if _may_count_samples(spelled, choice, options) else 0
    if stride == 1 and options.rate is None:
        raise ask_for_sample_numbers(name, used.stamps)
    if stride == 1 and options.rate is not None and not is_one_nominal_rate(options.rate, 1.0):
        spelled = None
    second, by_size, by_rate = None, "", ""
    if spelled is None:
        ends, mean = used.stamps[[0, -1]].astype(np.float64), float(used.intervals.sum()) / len(used.intervals)
        spelled = by_size = unit_by_size(float(ends[0]), float(ends[1]), mean, len(used.stamps)) or ""
        if not by_size and options.rate is not None and mean > 0:
            spelled = by_rate = unit_by_rate(mean, median(used.intervals), options.rate) or ""
    if spelled:
        second = units.find(spelled).factor * float(options.scale.get("time", 1.0))
        if second < 0:
            raise OptionError("the scale of time must be positive", option="scale")
    elif options.rate is None:
        raise ask_for_unit(used.stamps, used.intervals, name)
    fitted = stamps.fit(used, second, table.where, name, rate=options.rate)
    findings = fitted.findings
    notes = fitted.notes
    if clock is not None:
        notes = (*notes, f"time stamps in column {name} are the digits of hours, minutes and seconds")
    epoch = "as day numbers" if by_size == "d" else "counted from 1970"
    notes = (*notes, f"time stamps in {by_size} by their size, {epoch}") if by_size else notes
    contradiction = None
    if options.rate is None:
        notes = (*notes, f"sampling rate {fitted.rate:.6g} Hz from {fitted.source}")
    elif second is None:
        notes = (f"time stamps in column {name} checked for order and gaps only",)
    else:
        notes = (*notes, f"time stamps in {by_rate} by the given rate") if by_rate else notes
        findings = (*stamps.mismatch(options.rate, fitted.rate, options.input), *findings)
        contradiction = _contradiction(fitted, second, choice, options, name, by_rate or by_size)
    if stream_rows is not None:
        findings = tuple(f if f.channels else replace(f, channels=(stream,)) for f in findings)
        notes = (*notes, f"{stream} in {len(stream_rows)} of {len(stamps_raw)} rows, with the stamps of these")
    source, stated = fitted.source, options.rate
    if stated is not None:  # "given" alone means that the log does not confirm the rate
        confirmed = second is not None and not stamps.mismatch(stated, fitted.rate)
        source = replace(source, kind="given", confirmed=True) if confirmed else GIVEN_RATE
    start = 0.0 if second is None else fitted.start
    measured = None if second is None else fitted.rate
    return replace(
        fitted,
        rate=stated or fitted.rate,
        measured=measured,
        start=start,
        source=source,
        notes=notes,
        findings=findings,
        contradiction=contradiction,
        stride=stride,
    )


def _may_count_samples(spelled: str | None, choice: ColumnChoice, options: Options) -> bool:
    """Whether only the file states that the stamps of an inertial sensor are in seconds."""
    if spelled is None or "time" in options.unit or "time" in options.scale or units.find(spelled).factor != 1:
        return False
    return any(stream_name(channel) in SI for channel in choice.channels)


def _by_statement(table: Table, options: Options, rows: NDArray[np.int64] | None) -> Timing:
    """Sampling times from the given rate alone: the log has no time stamps, or `channels` ignores them."""
    rate = cast("float", options.rate)
    if table.rate is None:
        return Timing(rate=rate, rows=rows)
    findings = stamps.mismatch(rate, table.rate, options.input, stated=True)
    contradiction = find_stated_contradiction(table, options)
    return Timing(rate=rate, measured=table.rate, rows=rows, findings=findings, contradiction=contradiction)


def find_stated_contradiction(table: Table, options: Options) -> RateContradiction | None:
    """The contradiction between the given rate and that of the file, unless the options ignore the times of the file."""
    rate, stated = options.rate, table.rate
    if rate is None or stated is None or no_time(table.columns, options.channels) or is_one_nominal_rate(rate, stated):
        return None
    return RateContradiction(stated=rate, logged=stated, source=table.rate_source)


def _contradiction(
    timing: Timing, second: float, choice: ColumnChoice, options: Options, name: str, assumed: str
) -> RateContradiction | None:
    """The contradiction between the given rate and the stamps, if these show a rate.

    `assumed`: the unit of the stamps, if neither the file nor the user states it.
    """
    rate = cast("float", options.rate)
    if not timing.is_regular or is_one_nominal_rate(rate, timing.rate):
        return None
    other_unit = "" if assumed else unit_for(second, timing.rate, rate)
    if is_confirmed(
        by_stamps=timing.rate,
        length=(timing.n or 0) / timing.rate,
        other_unit=other_unit,
        has_stated_unit="time" in options.unit or "time" in options.scale,
        is_inertial=any(stream_name(channel) in SI for channel in choice.channels),
    ):
        return None
    return RateContradiction(
        stated=rate,
        logged=timing.rate,
        source=timing.source,
        unit=assumed,
        other_unit=other_unit,
        names_time="time" in options.channels,
    )


_MIN_OTHER_ROWS = 0.15  # share of empty rows from which a stream may have separate rows
_SHARE_FILLED = 0.95  # smallest share of these empty rows that other streams must fill


def with_missing(raw: Mapping[int, NDArray[Any]], indices: Sequence[int]) -> set[int]:
    """The columns that contain a NaN."""
    held = [i for i in indices if isinstance(raw[i], np.ndarray) and raw[i].dtype == np.float64]
    doubles = [i for i in held if raw[i].flags.c_contiguous]
    all_finite = dict(zip(doubles, kernels.all_finite([raw[i] for i in doubles]), strict=True)) if doubles else {}
    doubted = {i for i in indices if not all_finite.get(i, False) and raw[i].dtype.kind == "f"}
    missing: set[int] = set()
    for start in range(0, max((len(raw[i]) for i in doubted), default=0), CHUNK):
        for i in doubted - missing:  # checked together, because columns of one file share its rows
            with np.errstate(over="ignore", invalid="ignore"):
                if np.isnan(np.sum(np.asarray(raw[i][start : start + CHUNK]), dtype=np.float64)):
                    missing.add(i)
    return missing


def separate_rows_by_stream(
    raw: Mapping[int, NDArray[Any]], by_stream: Mapping[str, Sequence[int]], missing: set[int]
) -> dict[str, NDArray[np.int64]]:
    """Rows of each stream that fills only part of the rows, where other streams fill the rest. Logging programs that
    write a row for each sample of any sensor make such tables. Streams that fill (nearly) all rows are not in the
    result.
    """
    empty: dict[str, NDArray[np.bool_]] = {}
    for name, indices in by_stream.items():
        if indices and all(i in missing for i in indices):
            nothing = np.isnan(raw[indices[0]])
            for i in indices[1:]:
                nothing &= np.isnan(raw[i])
            empty[name] = nothing
    rows_of_stream: dict[str, NDArray[np.int64]] = {}
    for name, nothing in empty.items():
        share = np.count_nonzero(nothing) / len(nothing)
        if share < _MIN_OTHER_ROWS or share == 1:
            continue
        filled = np.zeros(len(nothing), dtype=bool)
        for each in by_stream:
            if each != name:
                filled |= ~empty[each] if each in empty else True
        if np.count_nonzero(filled & nothing) >= _SHARE_FILLED * np.count_nonzero(nothing):
            rows_of_stream[name] = np.flatnonzero(~nothing)
    return rows_of_stream


def missing_in(
    raw: Mapping[int, NDArray[Any]],
    channels: Mapping[str, int],
    missing: set[int],
    used: Mapping[int, NDArray[np.int64]],
    where: Callable[[int], str],
    tau0: float,
    *,
    dropped: bool = False,
) -> tuple[Finding, ...]:
    """A finding about missing numbers in the rows in use; `tau0` is the time from row to row."""
    missing_by_channel: dict[str, NDArray[np.bool_]] = {}
    for channel, index in channels.items():
        if index not in missing:
            continue
        bad = np.isnan(raw[index])
        if index in used:
            inside = np.zeros(len(bad), dtype=bool)
            inside[used[index]] = True
            bad &= inside
        missing_by_channel[channel] = bad
    counts = {channel: len(used[channels[channel]]) for channel in missing_by_channel if channels[channel] in used}
    return missing_values(missing_by_channel, where, tau0, totals=counts, dropped=dropped)


_MIN_JITTER = 0.03  # smallest jitter that is reported, over the sample interval
# jitter up to this multiple of the scatter by the resolution of the clock counts as rounding
_ROUNDING_FACTOR = 1.3
_INTEGRALS = {"m/s^2": "m/s", "rad/s": "rad"}


def jitter_findings(streams: Sequence[Stream], times: Sequence[Timing]) -> tuple[Finding, ...]:
    """Findings about jitter of more than 3 % of the interval that the resolution does not explain. In an integrating
    sensor whose intervals scatter in this way, the mean times the scatter becomes quantization noise. The mean of a
    rate does not depend on the instant of sampling.
    """
    findings: list[Finding] = []
    for timing in times:
        jitter = timing.jitter or 0.0
        rounding = timing.step / math.sqrt(12)
        if not timing.on_grid or jitter * timing.rate <= _MIN_JITTER or jitter <= _ROUNDING_FACTOR * rounding:
            continue
        jittered = [s for s in streams if s.grid.jitter == timing.jitter]
        integrating = [s for s in jittered if s.samples.transforms[0].kind != "rate"]
        for stream in integrating or jittered[:1]:
            details = Jitter(sigma=jitter, interval=1 / timing.rate)
            if integrating:
                means = np.abs(sum(np.nansum(chunk, axis=0) for chunk in stream.chunks())) / stream.grid.n
                unit = _INTEGRALS.get(stream.unit, f"{stream.unit} s")
                details = replace(details, added=float(np.max(means)) * jitter, unit=unit)
            channels = stream.channels if integrating else ()
            findings.append(Finding(details=details, severity="info", channels=channels, size=jitter, unit="s"))
    return tuple(findings)
