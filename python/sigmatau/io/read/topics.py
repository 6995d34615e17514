"""Which tables of a file are read, when it holds several: topics, messages by sensor and instance, groups."""

from __future__ import annotations

import re
from collections.abc import Sequence

from sigmatau.errors import OptionError
from sigmatau.io.read.names import recognise
from sigmatau.io.read.table import Table

__all__ = ["choose_tables", "describe", "sensors"]

_LISTED = 12


def sensors(table: Table) -> tuple[str, ...]:
    """Sensors of which all three axes are recognised by the names of the columns: ``gyro``, ``accel``, both or none."""
    found = {match[0] for match in recognise(table.columns) if match is not None}
    return tuple(s for s in ("gyro", "accel") if {f"{s}_{axis}" for axis in "xyz"} <= found)


def describe(table: Table) -> str:
    """A topic in a few words: its name, its sensors, its rows."""
    rows = "" if table.rows is None else f"{table.rows} rows"
    what = ", ".join(filter(None, (" and ".join(sensors(table)), rows)))
    return f"{table.topic} ({what})" if what else table.topic


def choose_tables(tables: Sequence[Table], asked: Sequence[str]) -> list[Table]:
    """The tables that were asked for; or else the one, or the two, that hold gyro and accelerometer beyond doubt.

    Parameters
    ----------
    tables : sequence of Table
    asked : sequence of str
        Topics by name; or, if that is true of one only, by its name without the number of the instance, or by its end.

    Raises
    ------
    OptionError
        If a topic that was asked for is not there or not the only one, or if several might be meant.
    """
    if asked:
        named = [name for said in asked for name in _parted(tables, said)]
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
    what = (
        "holds several sensors" if both or gyro or accel else "holds several tables, none with known names of columns"
    )
    examples = [gyro[0], accel[0]] if gyro and accel and not both else likely[:1]
    example = " ".join(f"--topic {table.topic!r}" for table in examples)
    raise OptionError(f"{what}: {_listed(likely)}; choose, e.g. {example}", option="topic")


def _parted(tables: Sequence[Table], said: str) -> list[str]:
    """``a,b`` as two names, unless a topic is called so."""
    if "," not in said or any(table.topic == said for table in tables):
        return [said]
    return [name.strip() for name in said.split(",") if name.strip()]


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
            raise OptionError(f"several topics are called so: {_listed(same)}; give the whole name", option="topic")
    if not any(table.topic for table in tables):
        raise OptionError(f"holds one table and no topics: leave --topic {name} out", option="topic")
    raise OptionError(f"has no topic {name!r}; it holds {_listed(tables)}", option="topic")


def _without_instance(topic: str) -> str:
    """``sensor_gyro:0`` and ``IMU[0]`` without their number."""
    return re.sub(r"(?::\d+|\[\d+\])$", "", topic)


def _listed(tables: Sequence[Table]) -> str:
    shown = ", ".join(describe(table) for table in tables[:_LISTED])
    return shown if len(tables) <= _LISTED else f"{shown}, … {len(tables)} in all"
