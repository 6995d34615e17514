"""Columns of a log in this package's own form that are not read.

Only sensors are read by default. Most logs have other columns (a magnetic field, a norm, a counter) that nobody misses. If
all columns of a log are named like channels, each with its unit, all of them are channels.
"""

from __future__ import annotations

import re
from collections.abc import Collection

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.reading import ColumnsNotRead
from sigmatau.io.read.columns import Choice
from sigmatau.io.read.names import recognise, signal_name, stated_unit, unit_of
from sigmatau.io.read.options import Options
from sigmatau.io.read.table import Table

__all__ = ["not_read"]

_SHOWN = 4  # columns that the example of --channels names
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|")  # or nothing: a missing value


def not_read(table: Table, choice: Choice, options: Options, used: Collection[int | None]) -> tuple[Finding, ...]:
    """A finding that names them; nothing if the user chose channels."""
    if set(options.channels) - {"time"} or not _own_form(table, choice):
        return ()
    known = recognise(table.columns)
    left = [
        index
        for index, column in enumerate(table.columns)
        if index not in used and known[index] is None and _NUMBER.fullmatch(column.first.strip())
    ]
    if not left:
        return ()
    # With --input increments a signal would be taken for increments too: then signals are read alone, as rates.
    read = dict(choice.channels) if options.input == "rate" else {}
    for index in left[:_SHOWN]:
        read[signal_name(table.columns[index], taken=read)] = index
    details = ColumnsNotRead(
        columns=tuple(table.label(index) for index in left),
        channels=tuple((channel, index + 1) for channel, index in read.items()),
        as_rates=options.input != "rate",
        topic=table.topic,
    )
    return (Finding(details=details, severity="info"),)


def _own_form(table: Table, choice: Choice) -> bool:
    """Whether the columns are called ``time``, ``gyro_x`` …, and each has a unit, as `simulate` writes them."""
    if choice.time is None:
        return False
    used = {"time": choice.time, **choice.channels}
    return all(unit_of(table.columns[index])[0] == channel for channel, index in used.items()) and all(
        column.name.strip() and stated_unit(column) for column in table.columns
    )
