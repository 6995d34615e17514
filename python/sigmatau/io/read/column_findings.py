"""Findings about the columns of a table: a sensor without one axis, mixed units, columns that are not used."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

from sigmatau import units
from sigmatau.findings.columns import IncompleteSensor, MixedUnits, UnreadSensor, UnusedColumns
from sigmatau.findings.finding import Finding
from sigmatau.io.read.columns import ColumnChoice
from sigmatau.io.read.name_tables import TIMES
from sigmatau.io.read.names import bare_name, name_key, names_sensor, split_unit
from sigmatau.io.read.options import Options
from sigmatau.io.read.table import Column, Table
from sigmatau.record.record import stream_name

_SENSORS = ("gyro", "accel")
_SIMILAR = 0.7  # smallest similarity of a damaged name to those of the other axes; 1 is identical

# Formats whose columns are fields of declared messages. Their users know the other fields.
_MESSAGE_FORMATS = frozenset({"mcap", "rosbag1", "rosbag2", "ulog", "dataflash", "novatel", "vectornav"})

# Columns other than samples whose meaning is clear, so that no message names them.
_KNOWN_COLUMNS = (
    r"(?:.*_)?(?:index|n|id|seq|sequence|frame_?id|row|count|counter|packet_?counter|sample|number|line)(?:_.*)?|.*covariance.*|"
    r".*(?:n?secs?|nanosec)|copy_of_.*|" + "|".join(TIMES)
)


def column_findings(table: Table, choice: ColumnChoice, options: Options, *, by_name: bool) -> list[Finding]:
    """Findings about the columns that are read, and about unused columns if columns are chosen by name."""
    used = {*choice.columns, None if choice.temperature is None else choice.temperature.index}
    by_file = {
        channel: i
        for channel, i in choice.channels.items()
        if not {channel, stream_name(channel)} & options.unit.keys()
    }
    findings = _mixed_units(table.columns, by_file)
    if not by_name:
        return findings
    spare = [
        index
        for index, column in enumerate(table.columns)
        if index not in used and column.name.strip() and _is_numeric(column)
    ]
    findings += _incomplete(table.columns, choice.channels, spare)
    if table.format in _MESSAGE_FORMATS:
        return findings
    unnamed = {finding.details.number for finding in findings if isinstance(finding.details, IncompleteSensor)}
    unread = _unread_sensors(table.columns, choice.channels, spare)
    findings += [Finding(details=details, severity="warning") for details in unread]
    unnamed |= {number for details in unread for number in details.numbers}
    names = tuple(
        table.columns[index].name
        for index in spare
        if index + 1 not in unnamed and not re.fullmatch(_KNOWN_COLUMNS, name_key(bare_name(table.columns[index])))
    )
    return [*findings, Finding(details=UnusedColumns(columns=names), severity="info")] if names else findings


def _is_numeric(column: Column) -> bool:
    """Whether the first row of a column is a number or unknown."""
    try:
        return math.isfinite(float(column.first or 0))
    except ValueError:
        return False


def _incomplete(columns: Sequence[Column], channels: Mapping[str, int], spare: Sequence[int]) -> list[Finding]:
    """Sensors of which exactly two axes are read although another column has a similar name or the other sensor has three
    axes.
    """
    findings = []
    for sensor in _SENSORS:
        axes = {axis: channels[f"{sensor}_{axis}"] for axis in "xyz" if f"{sensor}_{axis}" in channels}
        if len(axes) != 2:
            continue
        from difflib import SequenceMatcher

        missing = next(axis for axis in "xyz" if axis not in axes)
        names = [columns[index].name for index in axes.values()]
        likeness = {i: min(SequenceMatcher(None, columns[i].name, name).ratio() for name in names) for i in spare}
        best = max(likeness, key=likeness.__getitem__, default=None)
        if best is not None and likeness[best] < _SIMILAR:
            best = None
        if best is None and not _is_complete(channels, next(name for name in _SENSORS if name != sensor)):
            continue  # some sensors have two axes
        details = IncompleteSensor(
            missing=f"{sensor}_{missing}",
            column="" if best is None else columns[best].name,
            number=None if best is None else best + 1,
        )
        findings.append(
            Finding(
                details=details,
                severity="info" if best is None and missing == "z" else "warning",  # sensors of two axes have x and y
                channels=tuple(f"{sensor}_{axis}" for axis in axes),
            )
        )
    return findings


def _unread_sensors(columns: Sequence[Column], channels: Mapping[str, int], spare: Sequence[int]) -> list[UnreadSensor]:
    """Sensors of which no channel is read, although the names or units of three or more columns show them."""
    unread = []
    for sensor in _SENSORS:
        if any(stream_name(channel) == sensor for channel in channels):
            continue
        shown = [index for index in spare if names_sensor(columns[index]) == sensor]
        if len(shown) >= len("xyz"):
            names, numbers = tuple(columns[i].name for i in shown), tuple(i + 1 for i in shown)
            unread.append(UnreadSensor(sensor=sensor, columns=names, numbers=numbers))
    return unread


def _is_complete(channels: Mapping[str, int], sensor: str) -> bool:
    """Whether all three axes of a sensor are read."""
    return all(f"{sensor}_{axis}" in channels for axis in "xyz")


def _mixed_units(columns: Sequence[Column], channels: Mapping[str, int]) -> list[Finding]:
    """Sensors whose axes have different units in the file."""
    findings = []
    for sensor in _SENSORS:
        axes = {channel: index for channel, index in channels.items() if channel.startswith(f"{sensor}_")}
        stated = {
            channel: unit for channel, index in axes.items() if (unit := split_unit(columns[index])[1]) is not None
        }
        if len({units.find(unit) for unit in stated.values()}) > 1:
            details = MixedUnits(
                units=tuple((split_unit(columns[axes[channel]])[0], unit) for channel, unit in stated.items())
            )
            findings.append(Finding(details=details, severity="warning", channels=tuple(stated)))
    return findings
