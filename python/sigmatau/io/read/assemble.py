"""The last step of every reader: columns and options into a record."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeGuard, cast, get_args

import numpy as np
from numpy.typing import NDArray

from sigmatau import units
from sigmatau.errors import DataError, OptionError, RecordTooShortError
from sigmatau.io.read import stamps
from sigmatau.io.read.columns import Choice, choose, holds_increments, recognise, unit_of
from sigmatau.io.read.table import REST_MISSING, Table
from sigmatau.io.read.unwritten import without_unwritten
from sigmatau.record import MIN_SAMPLES, QUANTITIES, Checksum, Provenance, Record, make_stream, stream_name
from sigmatau.results import Finding
from sigmatau.streams import InputKind, Stream

__all__ = ["Options", "Part", "assemble", "find_rate", "of_table", "part", "resolve"]

_SI = {"gyro": QUANTITIES["angular_rate"], "accel": QUANTITIES["acceleration"]}


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """What the user said, checked; see `sigmatau.io.read.read`."""

    rate: float | None
    unit: Mapping[str, str]
    channels: Mapping[str, str | int]
    input: InputKind
    scale: Mapping[str, float]
    offset: Mapping[str, float]
    topic: tuple[str, ...] = ()

    @classmethod
    def check(
        cls,
        *,
        rate: object,
        unit: object,
        channels: object,
        input: object,  # noqa: A002  as in `read`
        scale: object,
        offset: object,
        topic: object = None,
    ) -> Options:
        """Options of the right types; raises `OptionError`."""
        if rate is not None and not (_is_number(rate) and rate > 0):
            raise OptionError(f"`rate` must be a positive number of hertz, not {rate!r}", option="rate")
        if input not in get_args(InputKind):
            raise OptionError(f"`input` must be one of {', '.join(get_args(InputKind))}, not {input!r}", option="input")
        return cls(
            rate=None if rate is None else float(rate),
            unit={c: _spelled(c, v) for c, v in _mapping("unit", unit).items()},
            channels={c: _column(c, v) for c, v in _mapping("channels", channels).items()},
            input=cast("InputKind", input),
            scale={c: _factor("scale", c, v) for c, v in _mapping("scale", scale).items()},
            offset={c: _factor("offset", c, v) for c, v in _mapping("offset", offset).items()},
            topic=_topics(topic),
        )


_EXAMPLES = {
    "unit": '{"gyro": "deg/s"}',
    "channels": '{"gyro_x": 2}',
    "scale": '{"gyro": 0.01}',
    "offset": '{"gyro": 512}',
}


def assemble(tables: Sequence[Table], file: Path | None, options: Options) -> Record:
    """A record from the tables of a file that are wanted.

    Parameters
    ----------
    tables : sequence of Table
    file : Path or None
        For its name and checksum; None if there is no file.
    options : Options

    Raises
    ------
    OptionError, DataError
        Without the name of the file, which the caller puts before the message.
    """
    checksum = None if file is None else Checksum(file)
    if len(tables) > 1 and options.channels:
        topics = " and ".join(table.topic for table in tables)
        raise OptionError(
            f"--channels is about one topic, and {topics} are read: choose one by --topic", option="channels"
        )
    parts = [part(table, of_table(table, tables, options)) for table in tables]
    streams = [stream for each in parts for stream in each.streams]
    for stream in streams:
        if sum(other.name == stream.name for other in streams) > 1:
            topics = " and ".join(table.topic for table in tables)
            raise OptionError(f"{topics} both hold {stream.name}: choose one by --topic", option="topic")
    several = len(tables) > 1
    return Record(
        streams=tuple(streams),
        provenance=Provenance(
            path=None if file is None else str(file),
            format=tables[0].format,
            topics=tuple(table.topic for table in tables if table.topic),
            rows=max(each.rows for each in parts),
            conversions=tuple(f"{each.topic}: {c}" if several else c for each in parts for c in each.conversions),
            ignored=tuple(f"{each.topic}: {c}" if several else c for each in parts for c in each.ignored),
            checksum=checksum,
        ),
        findings=tuple(dict.fromkeys(finding for each in parts for finding in each.findings)),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """What one table gives to a record."""

    topic: str
    streams: tuple[Stream, ...]
    rows: int
    conversions: tuple[str, ...]
    ignored: tuple[str, ...]
    findings: tuple[Finding, ...]


def of_table(table: Table, tables: Sequence[Table], options: Options) -> Options:
    """Without what is said of the sensors of the other tables, which is no slip of the pen."""
    if len(tables) == 1:
        return options
    own, others = _sensors(table), {s for other in tables if other is not table for s in _sensors(other)}

    def kept(values: Mapping[str, Any]) -> dict[str, Any]:
        return {
            key: value for key, value in values.items() if stream_name(key) in own or stream_name(key) not in others
        }

    return replace(options, unit=kept(options.unit), scale=kept(options.scale), offset=kept(options.offset))


def _sensors(table: Table) -> set[str]:
    return {stream_name(match[0]) for match in recognise(table.columns) if match is not None and match[0] != "time"}


def part(table: Table, options: Options) -> Part:
    """What one table gives; raises as `assemble` does."""
    choice, unit, notes, overruled = resolve(table, options)
    wanted = sorted({*choice.channels.values(), *(() if choice.time is None else (choice.time,))})
    loaded = table.load(wanted, choice.time)
    raw, unwritten = without_unwritten(loaded.columns, choice.time, [table.label(i) for i in range(len(table.columns))])
    loaded = replace(loaded, columns=raw, findings=(*loaded.findings, *unwritten))
    rows = len(raw[wanted[0]])
    need = MIN_SAMPLES + (options.input == "accumulated")
    if rows < need:
        broken = "".join(f" ({finding.message})" for finding in (*table.findings, *loaded.findings))
        raise RecordTooShortError(
            f"has {rows} row{'s' if rows != 1 else ''} of data; at least {need} are needed{broken}", need=need, got=rows
        )

    try:
        rate, start, source, found, findings = _rate(table, choice, raw, unit.get("time"), options)
    except OptionError:
        raise
    except DataError as error:
        # Damage that is known of began where the stamps say so, if that is before it was found out.
        known = (*table.findings, *loaded.findings)
        order = _in_order(raw, choice.time) if any(f.severity == "error" for f in known) else rows
        if not need <= order < rows:
            raise _of_damaged(error, table, known) from None
        raw = {index: array[:order] for index, array in raw.items()}
        try:
            rate, start, source, found, findings = _rate(table, choice, raw, unit.get("time"), options)
        except DataError:
            raise _of_damaged(error, table, known) from None
        findings = (_cut_there(order, rows), *findings)
        rows = order
    by_stream: dict[str, dict[str, NDArray[Any]]] = {}
    for channel, index in choice.channels.items():
        by_stream.setdefault(stream_name(channel), {})[channel] = raw[index]
    streams = tuple(
        make_stream(
            name,
            columns,
            rate=rate,
            unit=unit,
            kind=options.input,
            scale=options.scale,
            offset=options.offset,
            grid_source=source,
            start=start,
            finite=True,  # of every table
        )
        for name, columns in by_stream.items()
    )
    used = {*choice.channels.values(), choice.time}
    return Part(
        topic=table.topic,
        streams=streams,
        rows=rows,
        conversions=(
            *table.notes,
            *choice.notes,
            *_named(table, choice),
            *notes,
            *_conversions(unit, options),
            *found,
        ),
        ignored=tuple(c.name or f"column {i + 1}" for i, c in enumerate(table.columns) if i not in used),
        findings=(*table.findings, *loaded.findings, *overruled, *findings),
    )


def _in_order(raw: Mapping[int, NDArray[Any]], time: int | None) -> int:
    """Rows before time goes backwards, without the last of them: that or the next one has a stamp that is wrong."""
    stamps_raw = np.empty(0) if time is None else raw[time]
    back = np.flatnonzero(stamps_raw[1:] < stamps_raw[:-1])
    return int(back[0]) if len(back) else len(stamps_raw)


def _cut_there(order: int, rows: int) -> Finding:
    return Finding(
        code="damaged",
        severity="error",
        message=f"time goes backwards after row {order} (counted from 0) in a log that is damaged: {order} of the {rows}"
        " rows that were found are used",
        effect=REST_MISSING,
    )


def _of_damaged(error: DataError, table: Table, findings: Sequence[Finding]) -> DataError:
    """An error about stamps with the damage that may be its cause: what is known of it, or that nothing would show it."""
    lost = [finding.message for finding in findings if finding.severity == "error"]
    if lost:
        error.args = (f"{error}. The log is damaged: {lost[0]}",)
    elif any("without checksum" in note for note in table.notes):
        error.args = (f"{error}. Or the log is damaged there, which it has no checksums to show",)
    return error


def resolve(table: Table, options: Options) -> tuple[Choice, dict[str, str], list[str], list[Finding]]:
    """Which column is what, the unit of each channel as spelled, notes and findings; raises as `assemble` does."""
    choice = choose(table.columns, options.channels)
    _check_keys(choice, options)
    _check_kind(table, choice, options)
    choice = _without_text_stamps(table, choice, options)
    return choice, *_units(table, choice, options)


def find_rate(
    table: Table, choice: Choice, stamps_raw: NDArray[np.float64], spelled: str | None, options: Options
) -> tuple[float, str]:
    """Sampling rate from the option or the first stamps, and how it was found."""
    raw = {} if choice.time is None else {choice.time: stamps_raw}
    rate, _, source, _, _ = _rate(table, choice, raw, spelled, options)
    return rate, source


def _topics(value: object) -> tuple[str, ...]:
    named = (value,) if isinstance(value, str) else () if value is None else value
    if not isinstance(named, Sequence) or not all(isinstance(name, str) for name in named):
        raise OptionError(f"`topic` must be a name, or several, not {value!r}", option="topic")
    return tuple(named)


def _mapping(name: str, value: object) -> Mapping[str, object]:
    if value is None:
        return {}
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise OptionError(f"`{name}` must be a mapping of names, e.g. {_EXAMPLES[name]}, not {value!r}", option=name)
    return value


def _spelled(channel: str, value: object) -> str:
    if not isinstance(value, str) or not value.strip():
        raise OptionError(f"the unit of {channel} must be a word, not {value!r}", option="unit")
    return value


def _column(channel: str, value: object) -> str | int:
    if isinstance(value, str | int | np.integer) and not isinstance(value, bool):
        return value if isinstance(value, str) else int(value)
    raise OptionError(f"the column of {channel} must be a name or a number, not {value!r}", option="channels")


def _factor(name: str, channel: str, value: object) -> float:
    if not _is_number(value) or (name == "scale" and value == 0):
        but = " but 0" if name == "scale" else ""
        raise OptionError(f"the {name} of {channel} must be a finite number{but}, not {value!r}", option=name)
    return float(value)


def _is_number(value: object) -> TypeGuard[float]:
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:
        return False


def _check_keys(choice: Choice, options: Options) -> None:
    """An option for a channel that is not read is a slip of the pen, and would go unseen."""
    known = {*choice.channels, *map(stream_name, choice.channels)}
    for name, keys in (("unit", options.unit), ("scale", options.scale), ("offset", options.offset)):
        for key in keys:
            if key in known or (key == "time" and name != "offset" and choice.time is not None):
                continue
            if key == "time" and choice.time is None:
                raise OptionError(
                    f"has no time column, for which a {name} is given; name it by --channels time=…", option=name
                )
            channels = ", ".join(choice.channels)
            raise OptionError(f"--{name} {key}=…: no such channel is read; channels: {channels}", option=name)


def _check_kind(table: Table, choice: Choice, options: Options) -> None:
    if options.input == "rate":
        for channel, index in choice.channels.items():
            if stream_name(channel) in _SI and holds_increments(table.columns[index]):
                raise OptionError(
                    f"column {table.label(index)} holds increments by its name: say --input increments", option="input"
                )


def _without_text_stamps(table: Table, choice: Choice, options: Options) -> Choice:
    """Without a time column that holds dates or words, if a rate is given and nobody asked for that column."""
    if choice.time is None or options.rate is None or "time" in options.channels:
        return choice
    try:
        float(table.columns[choice.time].first or 0)
    except ValueError:
        note = f"time stamps in column {table.label(choice.time)} are no numbers and not used"
        return replace(choice, time=None, notes=(*choice.notes, note))
    return choice


def _units(table: Table, choice: Choice, options: Options) -> tuple[dict[str, str], list[str], list[Finding]]:
    """Unit of each channel, as spelled by the user or the file, and what there is to say about it."""
    recognised = recognise(table.columns)
    unit: dict[str, str] = {}
    notes: list[str] = []
    overruled: list[Finding] = []
    missing: list[str] = []
    indices = choice.channels if choice.time is None else {**choice.channels, "time": choice.time}
    for channel, index in indices.items():
        match = recognised[index]
        stated = unit_of(table.columns[index])[1]
        stream = "time" if channel == "time" else stream_name(channel)
        if stated is None and match is not None and stream in (match[0], match[0].split("_")[0]):
            stated = match[1]
        said = options.unit.get(channel, options.unit.get(stream))
        if said is not None and stated is not None and not _same(said, stated):
            notes.append(f"{channel}: in {said} as given, though the file says {stated}")
            overruled.append(
                Finding(
                    code="unit_overruled",
                    severity="warning",
                    channel=channel,
                    message=f"the unit given is {said}, the file says {stated}",
                    effect="the given unit is used",
                )
            )
        spelled = said or stated
        if spelled is None:
            if channel != "time":
                missing.append(channel)
            continue
        if stream in _SI or channel == "time":
            _check_unit(channel, spelled, stream)
        unit[channel] = spelled
    if missing:
        raise _ask_for_units(missing, options.input, no_rate=_lacks_rate(table, choice, unit, options))
    return unit, notes, overruled


def _lacks_rate(table: Table, choice: Choice, unit: Mapping[str, str], options: Options) -> str:
    """What has to be said for the rate, beside the units."""
    known = table.rate is not None if choice.time is None else "time" in unit
    if options.rate is not None or known:
        return ""
    return " --rate HZ" if choice.time is None else " --unit time=s (or ms, us, ns)"


def _check_unit(channel: str, spelled: str, stream: str) -> None:
    kinds = ("s",) if stream == "time" else (_SI[stream], units.integral(_SI[stream]))
    try:
        units.find(spelled, si=kinds)
    except OptionError as error:
        raise OptionError(f"{channel}: {error}", option="unit") from None


def _same(one: str, other: str) -> bool:
    try:
        return units.find(one) == units.find(other)
    except OptionError:
        return one == other


def _ask_for_units(missing: list[str], kind: InputKind, *, no_rate: str) -> OptionError:
    streams = list(dict.fromkeys(map(stream_name, missing)))
    examples = {"gyro": "deg/s", "accel": "g"} if kind == "rate" else {"gyro": "rad", "accel": "m/s"}
    example = " ".join(f"--unit {s}={examples.get(s, '1')}" for s in streams)
    known = [si if kind == "rate" else units.integral(si) for s, si in _SI.items() if s in streams]
    table = "; ".join(f"{', '.join(units.known(si))}" for si in known)
    listed = f" (known: {table})" if table else " (any word; 1 for none)"
    return OptionError(
        f"does not state the unit of {', '.join(missing)}; say e.g. {example}{no_rate}{listed}", option="unit"
    )


def _rate(
    table: Table, choice: Choice, raw: Mapping[int, NDArray[Any]], spelled: str | None, options: Options
) -> tuple[float, float, str, tuple[str, ...], tuple[Finding, ...]]:
    """Rate, start, how it was found, notes and findings."""
    if choice.time is None:
        if options.rate is None and table.rate is None:
            raise OptionError("has no time column that is recognised: give --rate HZ", option="rate")
        if options.rate is None and table.rate is not None:
            source = table.rate_source or "the file"
            return table.rate, 0.0, source, (f"sampling rate {table.rate:.6g} Hz from {source}",), ()
        rate = cast("float", options.rate)
        return rate, 0.0, "given", (), _rate_overruled(rate, table)
    name = table.label(choice.time)
    intervals = stamps.check_order(raw[choice.time], table.where, name)
    if spelled is None:
        if options.rate is None:
            raise stamps.without_unit(raw[choice.time], intervals, name)
        return options.rate, 0.0, "given", (f"time stamps in column {name} checked for order only",), ()
    second = units.find(spelled).factor * float(options.scale.get("time", 1.0))
    if second < 0:
        raise OptionError("the scale of time must be positive", option="scale")
    found = stamps.fit(raw[choice.time], intervals, second, table.where, name)
    if options.rate is not None:
        findings = (*stamps.mismatch(options.rate, found), *found.findings)
        return options.rate, found.start, "given", found.notes, findings
    notes = (*found.notes, f"sampling rate {found.rate:.6g} Hz from {found.source}")
    return found.rate, found.start, found.source, notes, found.findings


def _rate_overruled(rate: float, table: Table) -> tuple[Finding, ...]:
    if table.rate is None or math.isclose(rate, table.rate, rel_tol=1e-3):
        return ()
    message = f"the rate given is {rate:g} Hz, the file says {table.rate:g} Hz"
    return (Finding(code="rate_overruled", severity="warning", message=message, effect="the given rate is used"),)


def _named(table: Table, choice: Choice) -> list[str]:
    """Channels that bear another name in the file."""
    return [
        f"{channel} from column {table.label(index)}"
        for channel, index in choice.channels.items()
        if unit_of(table.columns[index])[0] != channel
    ]


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
        si = _SI.get(stream)
        if si is not None and units.find(spelled).symbol not in (si, units.integral(si)):
            done.append(f"{channel}: {spelled} to {units.find(spelled).si}")
    if options.input == "increments":
        done.append("increments divided by the sample interval")
    if options.input == "accumulated":
        done.append("accumulated values differenced and divided by the sample interval")
    return done
