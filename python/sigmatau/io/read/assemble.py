"""The last step of reading: a record from columns and options."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from sigmatau.errors import OptionError
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import Damaged
from sigmatau.hints import Hint
from sigmatau.io.read.instances import find_sensor
from sigmatau.io.read.names import recognise
from sigmatau.io.read.options import Options
from sigmatau.io.read.resolve import SI
from sigmatau.io.read.table import Table
from sigmatau.io.read.table_streams import Part, part
from sigmatau.io.read.thermometers import thermometer_part
from sigmatau.io.read.time.plausible import is_one_nominal_rate
from sigmatau.io.read.time.stamps import later
from sigmatau.record.record import Checksum, Provenance, Record, stream_name
from sigmatau.record.streams import Stream


def assemble(tables: Sequence[Table], file: Path | None, options: Options, thermometer: Table | None = None) -> Record:
    """Build a record from the chosen tables of a file and the table of its temperature.

    `file` provides the name and the checksum; it is None for a data frame.
    """
    if len(tables) > 1 and options.channels and not _name_each_sensor(tables):
        topics = " and ".join(table.topic for table in tables)
        raise OptionError(
            f"{{option}} applies to one topic, but {topics} are read; choose one by {Hint('topic')}", option="channels"
        )
    parts = [part_with_data(table, options_for_table(table, tables, options)) for table in tables]
    warm = None if thermometer is None else thermometer_part(thermometer, options, parts)
    if warm is None or thermometer is None:
        record = joined(shift_to_one_clock(parts), tables, file)
    else:
        record = joined(shift_to_one_clock([*parts, warm]), [*tables, thermometer], file)
    if options.rate is not None:
        check_common_rate(options.rate, _measured_rates(parts))
    refuse_contradictions(parts, options)
    return record


def refuse_contradictions(parts: Sequence[Part], options: Options) -> None:
    """Raise `OptionError` for a given rate that contradicts the time stamps, or the rate that the file states."""
    for each in parts:
        for stream, contradiction in each.contradictions.items():
            raise replace(contradiction, sensor=stream if stream in options.rates else "").error()


def _measured_rates(parts: Sequence[Part]) -> dict[str, float]:
    """Rates of the streams of a record from their time stamps, or as the file states them. [Hz]"""
    with_samples = _without_empty_sensors(parts)
    return {
        stream.name: each.rates[stream.name]
        for each in with_samples
        for stream in each.streams
        if stream.name in each.rates
    }


def check_common_rate(rate: float, measured: Mapping[str, float]) -> None:
    """Raise `OptionError` if one rate is given for sensors whose rates differ. `measured`: rates by stream."""
    if not measured or is_one_nominal_rate(max(measured.values()), min(measured.values())):
        return
    listed = ", ".join(f"{name} {hertz:.6g} Hz" for name, hertz in measured.items())
    stated = Hint("rate", value={name: f"{hertz:.4g}" for name, hertz in measured.items()})
    raise OptionError(
        f"{{option}} {rate:g} is one rate, but the log has several ({listed}); omit it, or give {stated}",
        option="rate",
    )


def shift_to_one_clock(parts: Sequence[Part]) -> list[Part]:
    """Shift the times of the findings of each part to the beginning of the earliest stream of all parts."""
    origin = min(stream.grid.start for stream in _one_temperature([s for each in parts for s in each.streams]))
    starts = [min(stream.grid.start for stream in each.streams) for each in parts]
    return [
        replace(each, findings=tuple(later(finding, start - origin) for finding in each.findings))
        for each, start in zip(parts, starts, strict=True)
    ]


def joined(parts: Sequence[Part], tables: Sequence[Table], file: Path | None) -> Record:
    """Join the streams of several tables in a record. Raises `OptionError` if two tables have the same sensor."""
    parts = _without_empty_sensors(parts)
    checksum = None if file is None else Checksum(file)
    streams = _one_temperature([stream for each in parts for stream in each.streams])
    for stream in streams:
        if [each.name for each in streams].count(stream.name) > 1:
            topics = " and ".join(table.topic for table in tables)
            raise OptionError(f"{topics} both have {stream.name}; choose one by {{option}}", option="topic")
    several = len(tables) > 1
    findings = with_topics([(each.topic, each.findings) for each in parts])
    return Record(
        streams=tuple(streams),
        provenance=Provenance(
            path=None if file is None else str(file),
            format=tables[0].format,
            topics=tuple(table.topic for table in tables if table.topic),
            rows=max(each.rows for each in parts),
            conversions=tuple(f"{each.topic}: {c}" if several else c for each in parts for c in each.conversions),
            units_stated=tuple(channel for each in parts for channel in each.units_stated),
            ignored=tuple(f"{each.topic}: {c}" if several else c for each in parts for c in each.ignored),
            checksum=checksum,
            started=_started(parts),
        ),
        findings=tuple(dict.fromkeys(finding for each in findings for finding in each)),
    )


def _started(parts: Sequence[Part]) -> str | None:
    """Time of the first sample of all parts, to the second."""
    begun = min((each.begun for each in parts if each.begun is not None), default=None)
    return None if begun is None else f"{datetime.fromtimestamp(begun // 1, tz=UTC):%Y-%m-%dT%H:%M:%S}"


def with_topics(by_topic: Sequence[tuple[str, Sequence[Finding]]]) -> list[tuple[Finding, ...]]:
    """Add the topic to each finding, except to findings that all topics share, because those are about the file."""
    shared = set(by_topic[0][1]).intersection(*(findings for _, findings in by_topic[1:]))
    return [
        tuple(
            finding if finding in shared or _names_topic(finding) else replace(finding, topic=topic)
            for finding in findings
        )
        for topic, findings in by_topic
    ]


def _names_topic(finding: Finding) -> bool:
    return isinstance(finding.details, Damaged) and bool(finding.details.topic)


def _without_empty_sensors(parts: Sequence[Part]) -> list[Part]:
    """Remove sensors that are zero in one part if another part has their data.

    Some drivers send gyro and accelerometer in separate messages, each with the fields of both.
    """
    names = [stream.name for each in parts for stream in each.streams]
    findings = []
    for each in parts:
        empty = tuple(stream for stream in each.streams if names.count(stream.name) > 1 and _is_zero(stream))
        if len(empty) == len(each.streams):  # another check reports a sensor that is off
            empty = ()
        ignored = tuple(f"{stream.name}: zero in all rows, and in another topic too" for stream in empty)
        streams = tuple(stream for stream in each.streams if stream not in empty)
        findings.append(replace(each, streams=streams, ignored=(*each.ignored, *ignored)))
    return findings


def part_with_data(table: Table, options: Options) -> Part:
    """Read a table; omit a sensor whose values are zero if the messages declare that they have no data of it.

    A sensor whose channels are named is not left out.
    """
    each = part(table, options)
    if options.channels:
        return each
    absent = {}
    for stream in each.streams:
        if stream.name not in _COVARIANCES:
            continue
        element = re.compile(rf"(?:.*\.)?{_COVARIANCES[stream.name]}(?:\[0\]|_?0)")
        for k, column in enumerate(table.columns):
            if not element.fullmatch(column.name) or not _is_zero(stream):
                continue
            if (table.load([k], None).columns[k] == _NO_DATA).all():
                absent[stream.name] = (
                    f"{stream.name} is left out: {column.name} is -1, so the messages have no data of it"
                )
    streams = tuple(stream for stream in each.streams if stream.name not in absent)
    if not streams:  # another check reports a sensor that is off
        return each
    return replace(each, streams=streams, conversions=(*each.conversions, *absent.values()))


@np.errstate(invalid="ignore")  # a damaged number may be a signalling NaN
def _is_zero(stream: Stream) -> bool:
    return not any(np.nan_to_num(chunk).any() for chunk in stream.chunks())


def _one_temperature(streams: list[Stream]) -> list[Stream]:
    """Remove all temperatures but the first, unless they were asked for."""
    first = next((stream for stream in streams if stream.quantity == "temperature"), None)
    return [stream for stream in streams if stream.quantity != "temperature" or stream is first]


def options_for_table(table: Table, tables: Sequence[Table], options: Options) -> Options:
    """Remove the units, scales, offsets and rates of sensors that only other tables have.

    If a device has two topics, each is read for the sensor in its name.
    """
    if len(tables) == 1:
        return options
    named = _sensor_by_table(pair_topics(tables))
    by_columns = _named_sensors if options.channels else _sensors

    def sensors_in(each: Table) -> set[str]:
        return set(named.get(id(each), ())) or by_columns(each)

    here, elsewhere = sensors_in(table), {s for further in tables if further is not table for s in sensors_in(further)}

    def select(values: Mapping[str, Any]) -> dict[str, Any]:
        return {
            key: value for key, value in values.items() if stream_name(key) in here or stream_name(key) not in elsewhere
        }

    return replace(
        options,
        sensors=named.get(id(table), ()),
        unit=select(options.unit),
        scale=select(options.scale),
        offset=select(options.offset),
        rates=select(options.rates),
        channels=select(options.channels),
    )


def _named_sensors(table: Table) -> set[str]:
    """Find the sensor whose name is the same word in all rows of a table."""
    sensor = None if table.kind is None else find_sensor(table.kind.label)
    return set() if sensor is None else {sensor}


def _name_each_sensor(tables: Sequence[Table]) -> bool:
    """Whether the words of the rows name one sensor for each table, and no sensor twice."""
    named = [sensor for table in tables for sensor in _named_sensors(table)]
    return len(set(named)) == len(named) == len(tables)


def _sensors(table: Table) -> set[str]:
    return {stream_name(match[0]) for match in recognise(table.columns) if match is not None and match[0] != "time"}


_LISTED = 12
_NO_DATA = -1  # first number of a covariance in sensor_msgs/Imu that declares the vector absent
_COVARIANCES = {"gyro": "angular_velocity_covariance", "accel": "linear_acceleration_covariance"}
_PROPOSED = 3  # largest number of devices whose topics a message proposes


def sensors(table: Table) -> tuple[str, ...]:
    """Sensors whose three axes are recognised by column names: ``gyro``, ``accel``, both or none."""
    channels = {match[0] for match in recognise(table.columns) if match is not None}
    return tuple(s for s in ("gyro", "accel") if {f"{s}_{axis}" for axis in "xyz"} <= channels)


def describe(table: Table) -> str:
    """Name, sensors and number of rows of a topic."""
    rows = "" if table.rows is None else f"{table.rows} rows"
    what = ", ".join(filter(None, (" and ".join(sensors(table)), rows)))
    return f"{table.topic} ({what})" if what else table.topic


def choose_tables(tables: Sequence[Table], asked: Sequence[str], channels: Collection[str] = ()) -> list[Table]:
    """Choose the requested tables, or else the only table or tables with a gyro and an accelerometer.

    `asked`: topics by name. It is enough to give the name without the number of the instance, its end, or a part between
    slashes, if only one topic matches. Empty topics match only if no other topic does. `channels`: channels named by the
    user; if words in the rows name sensors, the tables of these sensors are chosen.
    """
    if asked:
        named = [name for spelled in asked for name in _split(tables, spelled)]
        return list({table.topic: table for table in (_table_named(tables, name) for name in named)}.values())
    if len(tables) == 1:
        return list(tables)
    wanted = {stream_name(channel) for channel in channels} & set(SI)
    by_word = [table for table in tables if wanted & _named_sensors(table)]
    if wanted and len(by_word) == len(wanted) and _name_each_sensor(by_word):
        return by_word
    devices = pair_topics([table for table in tables if table.rows != 0])
    sensor_by_table = _sensor_by_table(devices)
    by_sensors: dict[tuple[str, ...], list[Table]] = {}
    for table in tables:
        if table.rows != 0:
            by_sensors.setdefault(sensor_by_table.get(id(table), sensors(table)), []).append(table)
    both, gyro, accel = (by_sensors.get(key, []) for key in (("gyro", "accel"), ("gyro",), ("accel",)))
    if len(both) == 1:
        return both
    if not both and len(gyro) <= 1 and len(accel) <= 1 and (gyro or accel):
        return [*gyro, *accel]
    likely = [*both, *gyro, *accel]
    if not likely and tables[0].kind is None and not any(map(_sensors, tables)):
        raise _no_imu(tables)
    likely = likely or [table for table in tables if table.rows != 0] or list(tables)
    counter = ""
    what = "has several sensors" if both or gyro or accel else "has several tables, none with all axes of a sensor"
    if (kind := tables[0].kind) is not None:
        what = f"{kind.place()}, so the rows are of several sensors"
        if both and kind.label.replace(".", "").isdigit():
            counter = f". If the column is a counter of one sensor, state {Hint('interleaved', value=1)}"
    examples = list(map(list, devices[:_PROPOSED]))
    examples = examples or ([[gyro[0], accel[0]]] if gyro and accel and not both else [likely[:1]])
    example = ", or ".join(f"{Hint('topic', value=[table.topic for table in chosen])}" for chosen in examples)
    raise OptionError(f"{what}: {_listed(likely)}; choose, e.g. {example}{counter}", option="topic")


def _no_imu(tables: Sequence[Table]) -> OptionError:
    """The question for a file in which no table has a sensor. No table is proposed."""
    counted = f"none of its {len(tables)} topics or tables has a column of a gyro or accelerometer"
    return OptionError(
        f"has no IMU: {counted}: {_listed(tables)}; record one, or name a topic and its columns by {{option}} and"
        f" {Hint('channels')}",
        option="topic",
    )


def _split(tables: Sequence[Table], spelled: str) -> list[str]:
    """Split ``a,b`` into two names, unless a topic has that name."""
    if "," not in spelled or any(table.topic == spelled for table in tables):
        return [spelled]
    return [name.strip() for name in spelled.split(",") if name.strip()]


def _table_named(tables: Sequence[Table], name: str) -> Table:
    typed = name.lower()
    with_rows = [table for table in tables if table.rows != 0]
    for same in (
        [table for table in tables if table.topic == name],
        [table for table in tables if table.topic.lower() == typed],
        *(
            [table for table in some if name and matches(table.topic.lower())]
            for some in (with_rows, tables)
            for matches in (
                lambda topic: _without_instance(topic) == typed,
                lambda topic: topic.endswith(typed),
                lambda topic: typed in topic.split("/"),
            )
        ),
    ):
        if len(same) == 1:
            return same[0]
        if same:
            raise OptionError(f"several topics match {name!r}: {_listed(same)}; give the whole name", option="topic")
    if not any(table.topic for table in tables):
        raise OptionError(f"has one table and no topics; leave out {Hint('topic', value=name)}", option="topic")
    raise OptionError(f"has no topic {name!r}; it has {_listed(tables)}", option="topic")


def _without_instance(topic: str) -> str:
    """The name without the number of the instance: ``sensor_gyro`` of ``sensor_gyro:0``, ``IMU`` of ``IMU[0]``."""
    return re.sub(r"(?::\d+|\[\d+\])$", "", topic)


def _listed(tables: Sequence[Table]) -> str:
    shown = ", ".join(describe(table) for table in tables[:_LISTED])
    return shown if len(tables) <= _LISTED else f"{shown}, … {len(tables)} in all"


_WORDS = {
    "gyro": r"(?i)gyro(?:scope|meter)?s?|(?<![a-z])gyr(?![a-z])|ang(?:ular)?_?(?:vel(?:ocity)?|rate)",
    "accel": r"(?i)(?:lin(?:ear)?_?)?accel(?:eration|erometer)?s?|(?<![a-z])acc(?![a-z])",
}


def pair_topics(tables: Sequence[Table]) -> list[tuple[Table, Table]]:
    """Pair the topics of the gyro and of the accelerometer of each device.

    A table that has the fields of both sensors is assigned by its name.
    """
    gyros: dict[str, list[Table]] = {}
    accels: dict[str, list[Table]] = {}
    for table in tables:
        for sensor, topics in (("gyro", gyros), ("accel", accels)):
            if sensor in sensors(table) and (rest := _without_sensor(table.topic, sensor)) is not None:
                topics.setdefault(rest, []).append(table)
    return [
        (gyros[rest][0], accels[rest][0])
        for rest in gyros
        if len(gyros[rest]) == 1 and len(accels.get(rest, ())) == 1 and gyros[rest][0] is not accels[rest][0]
    ]


def _without_sensor(topic: str, sensor: str) -> str | None:
    """Replace the word for the sensor in the name of a topic by a mark; None if it has no such word or more than one."""
    words = re.findall(_WORDS[sensor], topic)
    return re.sub(_WORDS[sensor], "\0", topic).lower() if len(words) == 1 else None


def _sensor_by_table(devices: Sequence[tuple[Table, Table]]) -> dict[int, tuple[str, ...]]:
    """The sensor for which each topic of a device is read, by the identity of its table."""
    return {id(table): (sensor,) for pair in devices for table, sensor in zip(pair, ("gyro", "accel"), strict=True)}
