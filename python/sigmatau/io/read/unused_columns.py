"""Columns of a log in this package's own form that no channel was made of.

Read by default are sensors alone, whose names are certain. Most logs have columns beside (a magnetic field, a norm, a
counter) that nobody misses; but in a log whose columns are called as channels are, each with its unit, all are channels.
"""

from __future__ import annotations

import re
from collections.abc import Collection

from sigmatau.findings.finding import Finding
from sigmatau.io.read.columns import Choice
from sigmatau.io.read.names import recognise, signal_name, stated_unit, unit_of
from sigmatau.io.read.options import Options
from sigmatau.io.read.table import Table

__all__ = ["not_read"]

_SHOWN = 4  # of the names, and of the columns that are spelled out
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|")  # or nothing: a missing value


def not_read(table: Table, choice: Choice, options: Options, used: Collection[int | None]) -> tuple[Finding, ...]:
    """What is to be said of them; nothing if channels were asked for, which is a choice.

    Parameters
    ----------
    table : Table
    choice : Choice
    options : Options
    used : collection of int
        Columns that something was made of.
    """
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
    shown = ", ".join(table.label(index) for index in left[:_SHOWN])
    more = f" and {len(left) - _SHOWN} more" if len(left) > _SHOWN else ""
    # Of increments a signal beside them would be taken for one, too.
    read = dict(choice.channels) if options.input == "rate" else {}
    for index in left[:_SHOWN]:
        read[signal_name(table.columns[index], taken=read)] = index
    asked = "--channels " + ",".join(f"{channel}={index + 1}" for channel, index in read.items())
    alone = "" if options.input == "rate" else "--input rate "
    topic = f" --topic {table.topic}" if table.topic else ""
    one = len(left) == 1
    return (
        Finding(
            code="columns_not_read",
            severity="info",
            message=f"not read: column{'' if one else 's'} {shown}{more}, of no name that a gyro or an accelerometer has",
            effect="what is said of the record does not include " + ("it" if one else "them"),
            remedy=f"to read {'it' if one else 'them'}, say {alone}{asked}{topic}; then these alone are read",
        ),
    )


def _own_form(table: Table, choice: Choice) -> bool:
    """Whether the columns are called ``time``, ``gyro_x`` …, and each has a unit, as `simulate` writes them."""
    if choice.time is None:
        return False
    used = {"time": choice.time, **choice.channels}
    return all(unit_of(table.columns[index])[0] == channel for channel, index in used.items()) and all(
        column.name.strip() and stated_unit(column) for column in table.columns
    )
