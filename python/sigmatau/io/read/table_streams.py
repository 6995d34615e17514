"""The streams of a record from one table, with conversions and findings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau import units
from sigmatau.errors import DataError, OptionError, RecordTooShortError
from sigmatau.findings.columns import GravityOnGyro
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import NeverWritten
from sigmatau.findings.wording import sentence
from sigmatau.frozen import frozen
from sigmatau.hints import TIME_COLUMN, Hint
from sigmatau.io.read.columns import ColumnChoice, Thermometer
from sigmatau.io.read.gravity import gravity_on_gyro
from sigmatau.io.read.names import split_unit
from sigmatau.io.read.options import Options
from sigmatau.io.read.resolve import SI, Resolved, resolve
from sigmatau.io.read.table import Loaded, Table, all_without_absurd, load_stamped
from sigmatau.io.read.time import rows
from sigmatau.io.read.time.dates import is_date
from sigmatau.io.read.time.plausible import RateContradiction, refuse_implausible, slow_rate
from sigmatau.io.read.time.split_stamps import join
from sigmatau.io.read.time.stamps import Timing, later
from sigmatau.io.read.time.timing import (
    find_timing,
    jitter_findings,
    missing_in,
    separate_rows_by_stream,
    with_missing,
)
from sigmatau.io.read.turn_tables import refuse_interleaved, refuse_shared_times
from sigmatau.record.record import MIN_SAMPLES, make_stream, make_temperature, stream_name
from sigmatau.record.sampling import RateSource
from sigmatau.record.streams import RATES, Stream
from sigmatau.record.thermometers import CELSIUS, PLAUSIBLE, typical


@frozen
class Part:
    """Streams, conversions and findings of one table."""

    topic: str
    streams: tuple[Stream, ...]
    rows: int
    conversions: tuple[str, ...]
    ignored: tuple[str, ...]
    units_stated: tuple[str, ...]  # channels with a unit from the file that no option overrules
    findings: tuple[Finding, ...]
    rates: Mapping[str, float]  # Rates by stream, from time stamps or stated by the file. [Hz]
    # Contradictions, by stream, between the given rate and that of the log
    contradictions: Mapping[str, RateContradiction]
    places: Mapping[str, int]  # Column of each channel and of the time, counted from 0
    begun: float | None = None  # Time of the first sample from 1970; None if the stamps have no dates [s]


def part(table: Table, options: Options) -> Part:
    """Read the streams of one table, with conversions and findings. Raises as `assemble` does."""
    resolved, loaded = _resolved(table, options)
    choice = resolved[0]
    raw, unwritten = without_unwritten(loaded.columns, choice.time, [table.label(i) for i in range(len(table.columns))])
    loaded = replace(loaded, columns=raw, findings=(*loaded.findings, *unwritten))
    try:
        return _make_part(table, options, (choice, *resolved[1:]), loaded)
    except (OptionError, RecordTooShortError):
        raise
    except DataError as error:
        # In a file with known damage the record ends where time goes backwards, if that is before the damage was detected.
        shorter = rows.cut(loaded, choice, table, error, min_rows=MIN_SAMPLES + 1)
        try:
            return _make_part(table, options, (choice, *resolved[1:]), shorter)
        except DataError:
            raise rows.with_damage(error, table, loaded.findings) from None


def _make_part(table: Table, options: Options, resolved: Resolved, loaded: Loaded) -> Part:
    """Build the streams from loaded columns."""
    choice, unit, overruled = resolved
    notes: list[str] = []
    raw = loaded.columns
    indices = list(choice.channels.values())
    rows = len(raw[indices[0]])
    need = MIN_SAMPLES + (options.input == "accumulated")
    if rows < need:
        broken = "".join(f" ({sentence(finding)})" for finding in (*table.findings, *loaded.findings))
        rows_text = f"has {rows} row{'s' if rows != 1 else ''} of data{f' in {table.topic}' if table.topic else ''}"
        raise RecordTooShortError(f"{rows_text}; at least {need} are needed{broken}", need=need, got=rows)
    by_stream: dict[str, dict[str, int]] = {}
    for channel, index in choice.channels.items():
        by_stream.setdefault(stream_name(channel), {})[channel] = index
    sensors = {name: list(columns.values()) for name, columns in by_stream.items()}
    warmth = () if choice.temperature is None else (choice.temperature.index,)
    missing = with_missing(raw, [*indices, *warmth])
    exclusive_rows = separate_rows_by_stream(raw, sensors, missing) if missing else {}
    if exclusive_rows and choice.time is None and not all(sensor in options.rates for sensor in exclusive_rows):
        raise DataError(
            f"has separate rows for {next(iter(exclusive_rows))}, without time stamps; name them with {TIME_COLUMN}, or"
            f" give the rate of each sensor, {Hint('rate', value=dict.fromkeys(by_stream, 'HZ'))}"
        )
    if not exclusive_rows and options.input != "accumulated" and options.interleaved != 1:
        refuse_interleaved(table, choice, raw, options.interleaved)
        if choice.time is None and choice.other_times:
            refuse_shared_times(table, choice.other_times[0])
    mostly = {
        channel: index
        for channel, index in choice.channels.items()
        if index in missing
        and np.isnan(raw[index][exclusive_rows.get(stream_name(channel), slice(None))]).mean() > _MAX_EMPTY
    }
    if 0 < len(mostly) < len(choice.channels):  # one bad channel must not make the log unusable
        choice = replace(choice, channels={c: i for c, i in choice.channels.items() if c not in mostly})
        by_stream = {
            name: {c: i for c, i in columns_of_name.items() if c not in mostly}
            for name, columns_of_name in by_stream.items()
        }
        by_stream = {name: columns_of_name for name, columns_of_name in by_stream.items() if columns_of_name}
    else:
        mostly = {}
    rows_by_column: dict[int, NDArray[np.int64]] = {}
    streams: list[Stream] = []
    rates: dict[str, float] = {}
    contradictions: dict[str, RateContradiction] = {}
    shared: Timing | None = None
    in_all_rows = options.for_streams([name for name in by_stream if name not in exclusive_rows])
    times: list[Timing] = []
    for name, columns in by_stream.items():
        if name in exclusive_rows:
            timing = find_timing(
                table, choice, raw, unit.get("time"), options.for_streams([name]), name, exclusive_rows[name]
            )
        else:
            shared = shared or find_timing(table, choice, raw, unit.get("time"), in_all_rows)
            timing = shared
        rate = (options.for_streams([name]) if name in exclusive_rows else in_all_rows).rate
        slow = () if rate is not None else _check_rate(name, table, choice, timing, rows)
        if slow and slow[0] not in overruled:
            overruled = [*overruled, *slow]
        if not RATES[0] <= timing.rate <= RATES[1]:
            raise DataError(
                f"its sampling rate is {timing.rate:g} Hz by {timing.source}, outside {RATES[0]:g} to {RATES[1]:g} Hz;"
                f" give {Hint('rate')}, or the unit of the time stamps by {Hint('unit', 'time', '…')}"
            )
        if not any(timing is each for each in times):
            times.append(timing)
        if timing.measured is not None:
            rates[name] = timing.measured
        if timing.contradiction is not None:
            contradictions[name] = timing.contradiction
        if timing.rows is not None:
            rows_by_column |= dict.fromkeys(columns.values(), timing.rows)
        streams.append(
            make_stream(
                name,
                {channel: timing.put_on_grid(raw[index]) for channel, index in columns.items()},
                rate=timing.rate,
                unit=unit,
                kind=options.input,
                scale=options.scale,
                offset=options.offset,
                grid_source=timing.source,
                start=timing.start,
                epoch=timing.epoch,
                jitter=timing.jitter,
                finite=timing.places is None and not missing.intersection(columns.values()),
            )
        )
    sensed = [[raw[index] for index in by_stream.get(name, {}).values()] for name in SI]
    if all(len(columns) == 3 for columns in sensed) and (sizes := gravity_on_gyro(*sensed)):
        exchanged = GravityOnGyro(gyro=sizes[0], accel=sizes[1])
        overruled = [*overruled, Finding(details=exchanged, severity="warning")]
    tau0 = streams[0].grid.tau0
    row_findings = (
        *missing_in(raw, mostly, missing, {}, table.where, tau0, dropped=True),
        *missing_in(raw, choice.channels, missing, rows_by_column, table.where, tau0),
        *jitter_findings(streams, times),
    )
    if choice.temperature is not None:
        index = choice.temperature.index
        shared = shared or find_timing(table, choice, raw, unit.get("time"), in_all_rows)
        warm, noted = temperature_stream(table.label(index), choice.temperature, raw, shared, missing=index in missing)
        streams += warm
        notes = [*notes, noted]
    begins = min(stream.grid.start for stream in streams)
    used = {*choice.columns, *(warmth if streams[-1].quantity == "temperature" else ())}
    return Part(
        topic=table.topic,
        streams=tuple(streams),
        rows=rows,
        conversions=(
            *table.notes,
            *choice.notes,
            *(
                f"{channel} from column {table.label(index)}"
                for channel, index in choice.channels.items()
                if split_unit(table.columns[index])[0] != channel
            ),
            *notes,
            *_conversions(unit, options),
            *dict.fromkeys(note for timing in times for note in timing.notes),
        ),
        ignored=tuple(c.name or f"column {i + 1}" for i, c in enumerate(table.columns) if i not in used),
        units_stated=tuple(c for c in choice.channels if not {c, stream_name(c)} & options.unit.keys()),
        findings=(
            *table.findings,
            *loaded.findings,
            *overruled,
            *(later(finding, timing.start - begins) for timing in times for finding in timing.findings),
            *row_findings,
        ),
        rates=rates,
        contradictions=contradictions,
        places=choice.places,
        begun=min((timing.begun for timing in times if timing.begun is not None), default=None),
    )


def _check_rate(name: str, table: Table, choice: ColumnChoice, timing: Timing, rows: int) -> tuple[Finding, ...]:
    """A finding about a slow rate of a gyro or accelerometer by its stamps; raises `OptionError` for an impossible one."""
    if name not in SI or choice.time is None or timing.second is None:
        return ()
    n = timing.n or rows
    is_dated = is_date(table.columns[choice.time].first)
    refuse_implausible(name, table.label(choice.time), timing.rate, n, None if is_dated else timing.second)
    return () if is_dated else slow_rate(timing.rate, n, timing.second, timing.stride)


def _resolved(table: Table, options: Options) -> tuple[Resolved, Loaded]:
    """Resolve columns and units. If the first choice of a time column has no time stamps, another one is used."""
    resolved = resolve(table, options)
    loaded, choice = _loaded(table, resolved[0])
    if choice.split is not None:
        split = choice.split
        joined = join(split, loaded.columns)
        if joined is None:  # two clocks
            whole = np.all(np.mod(loaded.columns[split.seconds][:_MIN_ROWS], 1) == 0)
            resolved = resolve(table, options, without_times={split.seconds if whole else split.part})
            loaded, choice = _loaded(table, resolved[0])
        else:
            loaded = replace(loaded, columns={**loaded.columns, split.seconds: joined})
    if choice.time is not None and len(choice.other_times) == 1 and _is_constant(loaded.columns[choice.time]):
        loaded_first = loaded.columns[choice.time]
        idle = {choice.time, *(choice.split.columns if choice.split else ())}
        resolved = resolve(table, options, without_times=idle)
        loaded, second = _loaded(table, resolved[0])
        if second.time is not None:
            first, value = table.label(choice.time), loaded_first[0]
            choice = replace(
                second,
                notes=(*second.notes, f"time from {table.label(second.time)}: all stamps in {first} are {value}"),
            )
        else:
            choice = second
    return (choice, *resolved[1:]), loaded


def _is_constant(array: NDArray[Any]) -> bool:
    return len(array) > 1 and array[0] == array[-1] and bool(np.all(array == array[0]))


def _loaded(table: Table, choice: ColumnChoice) -> tuple[Loaded, ColumnChoice]:
    """Load the columns. Infinite values become missing ones; the temperature is included if it can be read."""
    wanted = set(choice.columns)
    loaded: Loaded | None = None
    warm = choice.temperature
    if warm is not None and warm.index not in wanted:
        try:
            loaded = load_stamped(table, sorted({*wanted, warm.index}), choice.time)
        except DataError:  # an unreadable temperature must not make the log unusable
            choice = replace(choice, notes=(*choice.notes, f"column {table.label(warm.index)} cannot be read"))
    if loaded is None:
        loaded, choice = load_stamped(table, sorted(wanted), choice.time), replace(choice, temperature=None)
    return replace(loaded, columns=all_without_absurd(loaded.columns)), choice


def find_rate(
    table: Table, choice: ColumnChoice, stamps_raw: NDArray[np.float64], spelled: str | None, options: Options
) -> tuple[float, RateSource, bool]:
    """Sampling rate from the option or the first stamps, its source, and whether lost samples were counted."""
    raw = {} if choice.time is None else {choice.time: stamps_raw}
    options = options.for_streams(tuple(dict.fromkeys(map(stream_name, choice.channels))))
    timing = find_timing(table, replace(choice, channels={}), raw, spelled, options)
    return timing.rate, timing.source, timing.on_grid


def _conversions(unit: Mapping[str, str], options: Options) -> list[str]:
    done = []
    for channel, spelled in unit.items():
        if channel == "time":
            continue
        stream = stream_name(channel)
        scale = options.scale.get(channel, options.scale.get(stream, 1.0))
        offset = options.offset.get(channel, options.offset.get(stream, 0.0))
        if scale != 1 or offset != 0:
            done.append(f"{channel}: (raw - {offset:g}) * {scale:g} {spelled}".replace("- -", "+ "))
        si = SI.get(stream)
        if si is not None and units.find(spelled).symbol not in (si, units.integral(si)):
            done.append(f"{channel}: {spelled} to {units.find(spelled).si}")
    if options.input == "increments":
        done.append("increments divided by the sample interval")
    if options.input == "accumulated":
        done.append("accumulated values differenced and divided by the sample interval")
    return done


def temperature_stream(
    label: str, thermometer: Thermometer, raw: Mapping[int, NDArray[Any]], timing: Timing, *, missing: bool
) -> tuple[tuple[Stream, ...], str]:
    """The temperature stream and a note; no stream if the numbers are not temperatures. Never raises `DataError`.

    A thermometer with a lower rate than the sensors leaves its column empty in between; these samples are missing.
    """
    column = raw[thermometer.index]
    values = column[~np.isnan(column)] if missing else column
    if len(values) < MIN_SAMPLES:
        return (), f"temperature: column {label} has {len(values)} numbers, too few"
    median = typical(values, thermometer.unit or CELSIUS)
    if not PLAUSIBLE[0] <= median <= PLAUSIBLE[1]:
        unit = thermometer.unit or "degC, which was assumed"
        return (), f"temperature: column {label} is not a temperature in {unit} (median {median:.4g} °C)"
    try:
        stream = make_temperature(
            timing.put_on_grid(column),
            thermometer.unit or CELSIUS,
            rate=timing.rate,
            grid_source=timing.source,
            start=timing.start,
            epoch=timing.epoch,
            jitter=timing.jitter,
            finite=timing.places is None and not missing,
        )
    except DataError as error:
        return (), f"temperature: column {label} is not used: {error}"
    how = "degC assumed" if thermometer.unit is None else thermometer.unit
    return (stream,), f"temperature from column {label}, {how}"


_MAX_EMPTY = 0.5  # share of empty rows above which a channel is not read, if there are other channels
_MIN_ROWS = 8  # shortest run of rows that are 0 in all columns
# smallest ratio of its length to that of the longest earlier run: coarse counts at rest are sometimes 0
_RUN_RATIO = 4
_CHUNK = 1 << 16  # rows that are read at a time


def without_unwritten(
    columns: Mapping[int, NDArray[Any]], time: int | None, labels: Sequence[str]
) -> tuple[dict[int, NDArray[Any]], tuple[Finding, ...]]:
    """The columns up to their last written row, and a finding if rows are removed.

    Two kinds of rows at the end are removed: rows in which all columns (at least two) are 0, and rows in which the time
    is 0. The row before them is removed too, because it may be half written. `labels`: names of all columns.
    """
    trimmed = dict(columns)
    n = min(map(len, trimmed.values()), default=0)
    if n <= 1 or len(trimmed) < 2:
        return trimmed, ()
    zeros = {index: _zeros_at_end(array[:n]) for index, array in trimmed.items()}
    together = min(zeros.values())
    if together >= n:  # other checks report a log of zeros
        return trimmed, ()
    if time is not None and 0 < zeros[time] < n and trimmed[time][n - zeros[time] - 1] > 0:
        return _cut(trimmed, n - zeros[time], labels[time])
    if together >= _MIN_ROWS and together > _RUN_RATIO * _longest(trimmed, n - together):
        return _cut(trimmed, n - together)
    return trimmed, ()


def _cut(
    columns: Mapping[int, NDArray[Any]], rows: int, column: str = ""
) -> tuple[dict[int, NDArray[Any]], tuple[Finding, ...]]:
    n = min(map(len, columns.values()))
    details = NeverWritten(rows=n, zeros=n - rows, kept=rows - 1, column=column)
    trimmed = {index: array[: rows - 1] for index, array in columns.items()}
    return trimmed, (Finding(details=details, severity="error"),)


def _longest(columns: Mapping[int, NDArray[Any]], rows: int) -> int:
    """Longest run of rows that are 0 in all columns, among the first `rows`."""
    zero = np.ones(rows, dtype=bool)
    for array in columns.values():
        zero &= array[:rows] == 0
    ends = np.flatnonzero(~zero)
    return int(np.diff(ends, prepend=-1, append=rows).max(initial=1)) - 1


def _zeros_at_end(array: NDArray[Any]) -> int:
    """Number of zeros at the end; a column on disk is read backwards, in chunks."""
    end, step = len(array), _MIN_ROWS
    while end > 0:
        start = max(0, end - step)
        nonzero = np.flatnonzero(array[start:end])
        if len(nonzero):
            return len(array) - (start + int(nonzero[-1]) + 1)
        end, step = start, _CHUNK
    return len(array)
