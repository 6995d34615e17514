"""Tables with a time column for each signal or sensor, as Delsys writes them: ``X[s],ACC.X (g),X[s],ACC.Y (g) …``.

Signals with one clock form a table. Clocks are the same if all their stamps are equal, because rates of signals may differ.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.io.read.columns import is_clock
from sigmatau.io.read.names import recognise
from sigmatau.io.read.table import Column, Table, select_columns

_COPY = re.compile(r"\.\d+$")  # pandas appends a number to repeated names: ``X[s]``, ``X[s].1``


@frozen
class _Clock:
    """A time column and the columns up to the next one."""

    column: int
    signals: tuple[int, ...]


def separate_clocks(tables: Sequence[Table]) -> Sequence[Table]:
    """Split a single table with several clocks into one table for each clock."""
    clocks = _clocks(tables[0].columns) if len(tables) == 1 else []
    if not clocks:
        return tables
    table = tables[0]
    try:
        stamps = table.load([clock.column for clock in clocks], None).columns
    except DataError:
        return tables  # raised again when the table is read
    alike: list[tuple[NDArray[Any], list[_Clock]]] = []
    for clock in clocks:
        times = _without_end(stamps[clock.column])
        same = next((group for first, group in alike if np.array_equal(first, times, equal_nan=True)), None)
        if same is None:
            alike.append((times, [clock]))
        else:
            same.append(clock)
    if len(alike) == 1:
        return [_keep_first_clock(table, clocks)]
    return [_part(table, group, len(times), number) for number, (times, group) in enumerate(alike, 1)]


def _clocks(columns: Sequence[Column]) -> list[_Clock]:
    """The time columns of a table: the first column, and others that have its name or stand before equal numbers of columns.

    Empty if the table has at most one clock.
    """
    names = [_COPY.sub("", column.name.strip()) for column in columns]
    bare = [replace(column, name=name) for column, name in zip(columns, names, strict=True)]
    matches = recognise(bare)
    times = [k for k, match in enumerate(matches) if is_clock(bare[k]) or (match is not None and match[0] == "time")]
    if len(times) < 2 or times[0] != 0:
        return []
    ends = [*times[1:], len(columns)]
    clocks = [_Clock(column=k, signals=tuple(range(k + 1, end))) for k, end in zip(times, ends, strict=True)]
    widths = {len(clock.signals) for clock in clocks}
    alike = len({names[k].lower() for k in times}) == 1 or len(widths) == 1
    return clocks if alike and 0 not in widths else []


def _is_time(column: Column) -> bool:
    match = recognise([column])[0]
    return match is not None and match[0] == "time"


def _without_end(times: NDArray[Any]) -> NDArray[Any]:
    """Cut the stamps after the last one that is present: a slower signal leaves its last rows empty."""
    present = np.flatnonzero(~np.isnan(np.asarray(times, dtype=np.float64)))
    return times[: present[-1] + 1] if len(present) else times[:0]


def _keep_first_clock(table: Table, clocks: Sequence[_Clock]) -> Table:
    """Keep only the first time column of a table."""
    first, *further = (clock.column for clock in clocks)
    columns = list(table.columns)
    columns[first] = _named_time(columns[first])
    for k in further:
        columns[k] = replace(columns[k], name=f"copy of {columns[k].name}", unit=None)
    note = f"{len(clocks)} time columns, all the same"
    return replace(table, columns=tuple(columns), notes=(*table.notes, note))


def _named_time(column: Column) -> Column:
    """Rename a time column so that it is recognised, with its unit."""
    if _is_time(column):
        return column
    unit = re.search(r"[\[(]\s*(\w+)\s*[\])]", column.name)
    return replace(column, name="time", unit=column.unit or (unit[1] if unit else None))


def _part(table: Table, clocks: Sequence[_Clock], rows: int, number: int) -> Table:
    """Take the signals of one clock as a table."""
    places = (clocks[0].column, *(k for clock in clocks for k in clock.signals))
    columns = (_named_time(table.columns[places[0]]), *(table.columns[k] for k in places[1:]))
    selected = replace(table, columns=columns, load=select_columns(table.load, places))
    part = selected.take_rows(slice(0, rows, 1), f"clock{number}", f"signals of time column {places[0] + 1}")
    return replace(part, rows=rows)
