"""Choice of the tables to read from a file with several topics, messages or groups."""

from __future__ import annotations

import re
from collections.abc import Sequence

from sigmatau.errors import OptionError
from sigmatau.io.read.names import recognise
from sigmatau.io.read.table import Table

__all__ = ["choose_tables", "describe", "sensors"]

_LISTED = 12


def sensors(table: Table) -> tuple[str, ...]:
    """Sensors whose three axes are recognised by column names: ``gyro``, ``accel``, both or none."""
    found = {match[0] for match in recognise(table.columns) if match is not None}
    return tuple(s for s in ("gyro", "accel") if {f"{s}_{axis}" for axis in "xyz"} <= found)


def describe(table: Table) -> str:
    """Name, sensors and number of rows of a topic."""
    rows = "" if table.rows is None else f"{table.rows} rows"
    what = ", ".join(filter(None, (" and ".join(sensors(table)), rows)))
    return f"{table.topic} ({what})" if what else table.topic


def choose_tables(tables: Sequence[Table], asked: Sequence[str]) -> list[Table]:
    """The tables that were asked for, or else the only table or tables with a gyro and an accelerometer.

    `asked`: topics by name. The name without the number of the instance, or its end, is enough if only one topic
    matches.
    """
    if asked:
        named = [name for spelled in asked for name in _split(tables, spelled)]
        return list({table.topic: table for table in (_named(tables, name) for name in named)}.values())
    if len(tables) == 1:
        return list(tables)
    by_sensors: dict[tuple[str, ...], list[Table]] = {}
    for table in tables:
        if table.rows != 0:
            by_sensors.setdefault(sensors(table), []).append(table)
    both, gyro, accel = (by_sensors.get(key, []) for key in (("gyro", "accel"), ("gyro",), ("accel",)))
    if len(both) == 1:
        return both
    if not both and len(gyro) <= 1 and len(accel) <= 1 and (gyro or accel):
        return [*gyro, *accel]
    likely = [*both, *gyro, *accel] or [table for table in tables if table.rows != 0] or list(tables)
    what = "has several sensors" if both or gyro or accel else "has several tables, none with known column names"
    examples = [gyro[0], accel[0]] if gyro and accel and not both else likely[:1]
    example = " ".join(f"--topic {table.topic!r}" for table in examples)
    raise OptionError(f"{what}: {_listed(likely)}; choose, e.g. {example}", option="topic")


def _split(tables: Sequence[Table], spelled: str) -> list[str]:
    """``a,b`` as two names, unless a topic has that name."""
    if "," not in spelled or any(table.topic == spelled for table in tables):
        return [spelled]
    return [name.strip() for name in spelled.split(",") if name.strip()]


def _named(tables: Sequence[Table], name: str) -> Table:
    for same in (
        [table for table in tables if table.topic == name],
        [table for table in tables if table.topic.lower() == name.lower()],
        [table for table in tables if name and _without_instance(table.topic.lower()) == name.lower()],
        [table for table in tables if name and table.topic.lower().endswith(name.lower())],
    ):
        if len(same) == 1:
            return same[0]
        if same:
            raise OptionError(f"several topics match {name!r}: {_listed(same)}; give the whole name", option="topic")
    if not any(table.topic for table in tables):
        raise OptionError(f"has one table and no topics; leave out --topic {name}", option="topic")
    raise OptionError(f"has no topic {name!r}; it has {_listed(tables)}", option="topic")


def _without_instance(topic: str) -> str:
    """The name without the number of the instance: ``sensor_gyro`` of ``sensor_gyro:0``, ``IMU`` of ``IMU[0]``."""
    return re.sub(r"(?::\d+|\[\d+\])$", "", topic)


def _listed(tables: Sequence[Table]) -> str:
    shown = ", ".join(describe(table) for table in tables[:_LISTED])
    return shown if len(tables) <= _LISTED else f"{shown}, … {len(tables)} in all"
