"""Assign channels and units to the columns of a table. Raises `OptionError` if neither the file nor an option states
them.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from functools import partial
from typing import Literal

from sigmatau import units
from sigmatau.errors import OptionError
from sigmatau.findings.columns import UnitOverruled
from sigmatau.findings.finding import Finding
from sigmatau.hints import TIME_COLUMN, Hint
from sigmatau.io.read.column_findings import column_findings
from sigmatau.io.read.columns import ColumnChoice, choose
from sigmatau.io.read.names import holds_increments, recognise, split_unit, stated_unit
from sigmatau.io.read.options import Options
from sigmatau.io.read.table import Table
from sigmatau.io.read.time.dates import is_date
from sigmatau.io.read.time.plausible import epoch_unit
from sigmatau.record.record import QUANTITIES, stream_name

# Assignment of columns to channels, unit of each channel as spelled, and findings
Resolved = tuple[ColumnChoice, dict[str, str], list[Finding]]
_UNIT_SHOWN = 20  # number of characters of an unknown unit that a message shows
SI = {"gyro": QUANTITIES["angular_rate"], "accel": QUANTITIES["acceleration"]}  # SI units of the rates of both sensors


def resolve(table: Table, options: Options, *, without_times: Collection[int] = ()) -> Resolved:
    """Assign columns to channels, and find the unit of each channel as spelled, with findings; raises as `assemble`
    does.

    `without_times` are columns that are not time, whatever their name.
    """
    are_named = any(channel.strip() != "time" for channel in options.channels)
    by_mean = None if are_named or any(c.name for c in table.columns) else _by_gravity(table)
    choice = choose(
        table.columns,
        options.channels if by_mean is None else {**by_mean[0], **options.channels},
        increments=options.input == "increments",
        ask=partial(_ask_for_columns, table),
        without_times=without_times,
    )
    if options.sensors:
        read = {channel: i for channel, i in choice.channels.items() if stream_name(channel) in options.sensors}
        choice = replace(choice, channels=read)
    _check_keys(choice, options)
    _check_kind(table, choice, options)
    choice = _without_text_stamps(table, choice, options)
    unit, findings = _units(table, choice, options)
    findings = [*findings, *column_findings(table, choice, options, by_name=not options.channels and by_mean is None)]
    return choice, unit, findings if by_mean is None else [by_mean[1], *findings]


def _by_gravity(table: Table) -> tuple[dict[str, str | int], Finding] | None:
    """Name the columns of a table without names, if gravity identifies the accelerometer. The import is delayed until
    then.
    """
    from sigmatau.io.read.suggestions import by_gravity

    return by_gravity(table)


def _ask_for_columns(table: Table) -> OptionError:
    """Build the question for the columns of a table whose names do not identify them. The import is delayed until then."""
    from sigmatau.io.read.suggestions import ask_for_columns

    return ask_for_columns(table)


def _check_keys(choice: ColumnChoice, options: Options) -> None:
    """Raise `OptionError` for a unit, scale, offset or rate of a channel that is not read: its name is probably
    misspelled.
    """
    sensors = dict.fromkeys(map(stream_name, choice.channels))
    for sensor in options.rates:
        if sensor not in sensors:
            raise OptionError(
                f"{{option}} {sensor}=…: no such sensor is read; sensors: {', '.join(sensors)}", option="rate"
            )
    names = {*choice.channels, *map(stream_name, choice.channels)}
    for name, keys in (("unit", options.unit), ("scale", options.scale), ("offset", options.offset)):
        for key in keys:
            if key in names or (key == "time" and name != "offset" and choice.time is not None):
                continue
            if key == "time" and choice.time is None:
                raise OptionError(
                    f"has no time column, but a {name} of the time is given. Name the column with {TIME_COLUMN}",
                    option=name,
                )
            channels = ", ".join(choice.channels)
            raise OptionError(f"{Hint(name, key, '…')}: no such channel is read; channels: {channels}", option=name)


def _check_kind(table: Table, choice: ColumnChoice, options: Options) -> None:
    if options.input == "rate":
        for channel, index in choice.channels.items():
            if stream_name(channel) in SI and holds_increments(table.columns[index]):
                raise OptionError(
                    f"column {table.label(index)} contains increments according to its name;"
                    f" give {Hint('input', value='increments')}",
                    option="input",
                )


def _without_text_stamps(table: Table, choice: ColumnChoice, options: Options) -> ColumnChoice:
    """Drop a time column of dates or words if a rate is given and `channels` does not name that column."""
    if choice.time is None or not options.states_rate or "time" in options.channels:
        return choice
    try:
        float(table.columns[choice.time].first or 0)
    except ValueError:
        note = f"time stamps in column {table.label(choice.time)} are not numbers and not used"
        return replace(choice, time=None, notes=(*choice.notes, note))
    return choice


def _units(table: Table, choice: ColumnChoice, options: Options) -> tuple[dict[str, str], list[Finding]]:
    """Unit of each channel, as spelled by the user or the file, with findings."""
    recognised = recognise(table.columns)
    unit: dict[str, str] = {}
    overruled: list[Finding] = []
    missing: list[str] = []
    unknown_units: dict[str, str] = {}  # unknown unit of each channel
    counted_streams: dict[str, None] = {}  # streams whose numbers may be counts
    scale_hint = ""
    indices = choice.channels if choice.time is None else {**choice.channels, "time": choice.time}
    for channel, index in indices.items():
        match = recognised[index]
        stated = split_unit(table.columns[index])[1]
        stream = "time" if channel == "time" else stream_name(channel)
        if stated is None and match is not None and stream in (match[0], match[0].split("_")[0]):
            stated = match[1]
        chosen = options.unit.get(channel, options.unit.get(stream))
        if channel == "time" and choice.split is not None:
            chosen, stated = None, "ns"  # the unit of the joined columns
        if channel == "time" and is_date(table.columns[index].first):
            chosen = None  # dates have no unit
        if chosen is not None and (counted := table.columns[index].counted):
            chosen = _unit_of_converted(table, index, stream, chosen, counted)
        if chosen is not None and stated is not None and not _same(chosen, stated):
            overruled.append(_overruled(channel, chosen, stated))
        unknown = stated_unit(table.columns[index]) if stated is None and channel != "time" else None
        if unknown is not None and stream not in SI and unknown.isprintable():  # a signal may have any unit
            stated, unknown = unknown, None
            if chosen is not None and not _same(chosen, stated):
                overruled.append(_overruled(channel, chosen, stated))
        if chosen is not None and unknown is not None:
            overruled.append(
                _overruled(
                    channel,
                    chosen,
                    unknown,
                    recognised=False,
                    scaled=channel in options.scale or stream in options.scale,
                )
            )
        spelled = chosen or stated
        if spelled is None:
            if channel != "time":
                missing.append(channel)
                if unknown is not None:
                    unknown_units[channel] = unknown[:_UNIT_SHOWN]
                if unknown is not None and units.needs_scale(unknown):
                    scale_hint = f": give {Hint('scale')} too, e.g. {Hint('scale', stream_name(missing[0]), 0.01)}"
                first = table.columns[index].first
                is_scaled = channel in options.scale or stream in options.scale
                if (
                    not is_scaled and first.lstrip("+-").isdigit() and first.strip("+-0") != ""
                ):  # an integer other than 0
                    counted_streams[stream] = None
            continue
        if stream in SI or channel == "time":
            _check_unit(channel, spelled, stream)
        unit[channel] = spelled
    if missing:
        if len(unknown_units) == len(missing) and not scale_hint:
            raise _unknown_unit(unknown_units)
        if unknown_units and len(unknown_units) == len(missing):
            hint = f" (the file has {', '.join(f'{c} in {u!r}' for c, u in unknown_units.items())}{scale_hint})"
        else:
            factors = " ".join(str(Hint("scale", stream, "FACTOR")) for stream in counted_streams)
            hint = f" (whole numbers may be counts: then add {factors})" if counted_streams else ""
        is_unnamed = len(missing) == 1 and stream_name(missing[0]) not in SI and not options.channels
        from sigmatau.io.read.unit_question import ask_for_units

        raise ask_for_units(
            table,
            choice.channels,
            missing,
            options.input,
            stated={stream_name(c) for c in unit},
            scaled=set(map(stream_name, options.scale)),
            lacks=_missing_for_rate(table, choice, unit, options),
            hint=hint,
            column=choice.channels[missing[0]] + 1 if is_unnamed else None,
        )
    return unit, overruled


def _unknown_unit(unknown_units: Mapping[str, str]) -> OptionError:
    """Build the question for a unit that is stated in the file but not in the table of units. No usual unit may replace
    it.
    """
    first, unit = next(iter(unknown_units.items()))
    channels = ", ".join(channel for channel, text in unknown_units.items() if text == unit)
    key = stream_name(first)
    return OptionError(
        f"the unit {unit!r} of {channels} is not known. State a known unit and the factor that converts to it:"
        f" {Hint('unit', key, 'UNIT')} {Hint('scale', key, 'FACTOR')}",
        option="unit",
    )


def _unit_of_converted(table: Table, index: int, stream: str, unit: str, counted: str) -> str | None:
    """Unit to apply to a column that the reader converts: None, because the conversion includes the unit.

    Raises `OptionError` if the user states a unit other than the file's.
    """
    column = table.columns[index]
    if any(_same(unit, shown) for shown in (counted, column.unit) if shown):
        return None
    raise OptionError(
        f"{stream}={unit}: the head of the file states that column {table.label(index)} counts in"
        f" {column.unit if counted == 'counts' else counted}; leave out the unit of {stream}",
        option="unit",
    )


def _overruled(channel: str, chosen: str, stated: str, *, recognised: bool = True, scaled: bool = False) -> Finding:
    details = UnitOverruled(given=chosen, stated=stated, known=recognised, scaled=scaled)
    return Finding(details=details, severity="warning", channels=(channel,))


def _missing_for_rate(
    table: Table, choice: ColumnChoice, unit: Mapping[str, str], options: Options
) -> Literal["rate", "unit of time"] | None:
    """The option that is still missing to know the rate, once the units are known."""
    is_timed = table.rate is not None if choice.time is None else "time" in unit or _shows_unit(table, choice.time)
    if options.states_rate or is_timed:
        return None
    return "rate" if choice.time is None else "unit of time"


def _shows_unit(table: Table, time: int) -> bool:
    """Whether the size of the first stamp shows the unit of a count from 1970."""
    try:
        return epoch_unit(float(table.columns[time].first)) is not None
    except ValueError:
        return False


def _check_unit(channel: str, spelled: str, stream: str) -> None:
    if units.needs_scale(spelled):
        raise OptionError(
            f"{channel}: {spelled} need a scale; give it by {Hint('scale')}, and the resulting unit, e.g."
            f" {Hint('unit', stream, 'deg/s')} {Hint('scale', stream, 0.01)}",
            option="unit",
        )
    kinds = ("s",) if stream == "time" else (SI[stream], units.integral(SI[stream]))
    try:
        units.find(spelled, si=kinds)
    except OptionError as error:
        raise error.about(channel) from None


def _same(first_spelled: str, second_spelled: str) -> bool:
    first, second = units.find_unit(first_spelled), units.find_unit(second_spelled)
    return first_spelled == second_spelled if first is None or second is None else first == second
