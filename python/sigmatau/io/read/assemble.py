"""The last step of every reader: columns and options into a record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau import units
from sigmatau.errors import DataError, OptionError, RecordTooShortError
from sigmatau.io.read.columns import Choice, choose, holds_increments, recognise, stated_unit, unit_of
from sigmatau.io.read.jitter import scattered
from sigmatau.io.read.lay import missing_values, own_rows, with_missing
from sigmatau.io.read.options import Options
from sigmatau.io.read.table import Loaded, Table, is_date
from sigmatau.io.read.temperature import temperature_stream
from sigmatau.io.read.timing import Timing, timed
from sigmatau.record import MIN_SAMPLES, QUANTITIES, Checksum, Provenance, Record, make_stream, stream_name
from sigmatau.results import Finding
from sigmatau.streams import InputKind, Stream

__all__ = ["Options", "Part", "assemble", "find_rate", "joined", "of_table", "part", "resolve"]

_SI = {"gyro": QUANTITIES["angular_rate"], "accel": QUANTITIES["acceleration"]}


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
    if len(tables) > 1 and options.channels:
        topics = " and ".join(table.topic for table in tables)
        raise OptionError(
            f"--channels is about one topic, and {topics} are read: choose one by --topic", option="channels"
        )
    return joined([part(table, of_table(table, tables, options)) for table in tables], tables, file)


def joined(parts: Sequence[Part], tables: Sequence[Table], file: Path | None) -> Record:
    """A record from what its tables give; raises `OptionError` if two of them hold the same sensor."""
    checksum = None if file is None else Checksum(file)
    streams = _one_temperature([stream for each in parts for stream in each.streams])
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


def _one_temperature(streams: list[Stream]) -> list[Stream]:
    """With the first of the temperatures that several tables hold; nobody asked for the others."""
    first = next((stream for stream in streams if stream.quantity == "temperature"), None)
    return [stream for stream in streams if stream.quantity != "temperature" or stream is first]


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
    loaded, choice = _loaded(table, choice)
    raw = loaded.columns
    indices = list(choice.channels.values())
    rows = len(raw[indices[0]])
    need = MIN_SAMPLES + (options.input == "accumulated")
    if rows < need:
        broken = "".join(f" ({finding.message})" for finding in (*table.findings, *loaded.findings))
        raise RecordTooShortError(
            f"has {rows} row{'s' if rows != 1 else ''} of data; at least {need} are needed{broken}", need=need, got=rows
        )
    by_stream: dict[str, dict[str, int]] = {}
    for channel, index in choice.channels.items():
        by_stream.setdefault(stream_name(channel), {})[channel] = index
    sensors = {name: list(columns.values()) for name, columns in by_stream.items()}
    warmth = () if choice.temperature is None else (choice.temperature.index,)
    missing = with_missing(raw, [*indices, *warmth])
    own = {} if choice.time is None or not missing else own_rows(raw, sensors, missing)
    rows_of: dict[int, NDArray[np.int64]] = {}
    streams: list[Stream] = []
    shared: Timing | None = None
    times: list[Timing] = []
    for name, columns in by_stream.items():
        if name in own:
            timing = timed(table, choice, raw, unit.get("time"), options, name, own[name])
        else:
            shared = shared or timed(table, choice, raw, unit.get("time"), options)
            timing = shared
        if not any(timing is other for other in times):
            times.append(timing)
        if timing.rows is not None:
            rows_of |= dict.fromkeys(columns.values(), timing.rows)
        streams.append(
            make_stream(
                name,
                {channel: timing.laid(raw[index]) for channel, index in columns.items()},
                rate=timing.rate,
                unit=unit,
                kind=options.input,
                scale=options.scale,
                offset=options.offset,
                grid_source=timing.source,
                start=timing.start,
                jitter=timing.jitter,
                finite=timing.places is None and not missing.intersection(columns.values()),
            )
        )
    said = missing_values(raw, choice.channels, missing, rows_of, table.where, table.label)
    said = (*said, *scattered(streams, times))
    if choice.temperature is not None:
        index = choice.temperature.index
        shared = shared or timed(table, choice, raw, unit.get("time"), options)
        warm, noted = temperature_stream(table.label(index), choice.temperature, raw, shared, missing=index in missing)
        streams += warm
        notes = [*notes, noted]
    used = {*indices, choice.time, *(warmth if streams[-1].quantity == "temperature" else ())}
    return Part(
        topic=table.topic,
        streams=tuple(streams),
        rows=rows,
        conversions=(
            *table.notes,
            *choice.notes,
            *_named(table, choice),
            *notes,
            *_conversions(unit, options),
            *dict.fromkeys(note for timing in times for note in timing.notes),
        ),
        ignored=tuple(c.name or f"column {i + 1}" for i, c in enumerate(table.columns) if i not in used),
        findings=(
            *table.findings,
            *loaded.findings,
            *overruled,
            *(finding for timing in times for finding in timing.findings),
            *said,
        ),
    )


def _loaded(table: Table, choice: Choice) -> tuple[Loaded, Choice]:
    """The columns, with that of the temperature if it can be read."""
    wanted = {*choice.channels.values(), *(() if choice.time is None else (choice.time,))}
    if choice.temperature is not None and choice.temperature.index not in wanted:
        try:
            return table.load(sorted({*wanted, choice.temperature.index}), choice.time), choice
        except DataError:  # it must not cost the log
            name = table.label(choice.temperature.index)
            choice = replace(choice, temperature=None, notes=(*choice.notes, f"column {name} cannot be read"))
    return table.load(sorted(wanted), choice.time), replace(choice, temperature=None)


def resolve(table: Table, options: Options) -> tuple[Choice, dict[str, str], list[str], list[Finding]]:
    """Which column is what, the unit of each channel as spelled, notes and findings; raises as `assemble` does."""
    choice = choose(table.columns, options.channels)
    _check_keys(choice, options)
    _check_kind(table, choice, options)
    choice = _without_text_stamps(table, choice, options)
    return choice, *_units(table, choice, options)


def find_rate(
    table: Table, choice: Choice, stamps_raw: NDArray[np.float64], spelled: str | None, options: Options
) -> tuple[float, str, bool]:
    """Sampling rate from the option or the first stamps, how it was found, and whether lost samples were counted."""
    raw = {} if choice.time is None else {choice.time: stamps_raw}
    timing = timed(table, replace(choice, channels={}), raw, spelled, options)
    return timing.rate, timing.source, timing.counted


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
    foreigners: list[str] = []
    counts = False
    indices = choice.channels if choice.time is None else {**choice.channels, "time": choice.time}
    for channel, index in indices.items():
        match = recognised[index]
        stated = unit_of(table.columns[index])[1]
        stream = "time" if channel == "time" else stream_name(channel)
        if stated is None and match is not None and stream in (match[0], match[0].split("_")[0]):
            stated = match[1]
        said = options.unit.get(channel, options.unit.get(stream))
        if channel == "time" and is_date(table.columns[index].first):
            said = None  # dates have no unit that one could err about
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
        foreign = stated_unit(table.columns[index]) if stated is None and channel != "time" else None
        if said is not None and foreign is not None:
            overruled.append(
                Finding(
                    code="unit_overruled",
                    severity="warning",
                    channel=channel,
                    message=f"the unit given is {said}, the file says {foreign[:20]!r}, which is no unit of it",
                    effect="the numbers are taken in the given unit" + _scaled(channel, stream, options),
                )
            )
        spelled = said or stated
        if spelled is None:
            if channel != "time":
                missing.append(channel)
                foreigners += [f"{channel} in {foreign[:20]!r}"] if foreign is not None else []
                counts = counts or _whole(table.columns[index].first)
            continue
        if stream in _SI or channel == "time":
            _check_unit(channel, spelled, stream)
        unit[channel] = spelled
    if missing:
        if foreigners and len(foreigners) == len(missing):
            hint = (
                f" (the file has {', '.join(foreigners)}: say --scale too, e.g. --scale {stream_name(missing[0])}=0.01)"
            )
        else:
            hint = " (whole numbers may be counts: then say --scale too)" if counts and not options.scale else ""
        raise _ask_for_units(missing, options.input, no_rate=_lacks_rate(table, choice, unit, options) + hint)
    return unit, notes, overruled


def _whole(text: str) -> bool:
    """Whether a first field is a number without decimals, other than 0."""
    return text.lstrip("+-").isdigit() and text.strip("+-0") != ""


def _scaled(channel: str, stream: str, options: Options) -> str:
    given = channel in options.scale or stream in options.scale
    return ", times the scale given" if given else ": give --scale if they are volts or counts"


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
