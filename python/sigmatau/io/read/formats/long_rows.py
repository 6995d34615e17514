"""Tables with a row for each value, ``0.01,gyro_x,0.002``: the values of one clock become the columns of a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.io.read.names import recognise
from sigmatau.io.read.table import Column, Loaded, Table


@dataclass(frozen=True, slots=True, kw_only=True)
class _Series:
    """The rows of one channel."""

    table: Table
    time: int
    value: int
    stamps: NDArray[Any]


def join_channels(tables: Sequence[Table]) -> Sequence[Table]:
    """The tables of the kinds of rows; if each word is the name of a channel, with one for each clock in their place."""
    labels = [Column(name=table.kind.label) for table in tables if table.kind is not None]
    channels = [match[0] for match in recognise(labels) if match is not None and match[0] != "time"]
    if len(channels) != len(tables) or len(set(channels)) < len(channels) or len(channels) < 2:
        return tables
    series = [_find_series(table) for table in tables]
    clocks: list[list[_Series]] = []
    for each in series:
        if each is None:
            return tables
        same = next((clock for clock in clocks if np.array_equal(clock[0].stamps, each.stamps, equal_nan=True)), None)
        if same is None:
            clocks.append([each])
        else:
            same.append(each)
    if any(len(clock) == 1 for clock in clocks):
        return tables
    return [
        _of_clock(clock, f"clock{number}" if len(clocks) > 1 else "") for number, clock in enumerate(clocks, start=1)
    ]


def _find_series(table: Table) -> _Series | None:
    """The only time and the only value of a kind of rows; None if it has others."""
    matches = recognise(table.columns)
    times = [k for k, match in enumerate(matches) if match is not None]
    spare = {k for k, match in enumerate(matches) if match is None}
    values = sorted(spare - {table.kind.column if table.kind is not None else -1})
    if len(times) != 1 or len(values) != 1:
        return None
    try:
        stamps = table.load(times, times[0]).columns[times[0]]
    except DataError:
        return None  # raised again when the table is read
    return _Series(table=table, time=times[0], value=values[0], stamps=stamps)


def _of_clock(clock: Sequence[_Series], topic: str) -> Table:
    """The channels of one clock as a table."""
    first = clock[0]

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        parts = [first.table.load([first.time], first.time if exact == 0 else None)] if 0 in wanted else []
        columns = dict(zip((0,), [part.columns[first.time] for part in parts], strict=False))
        for k in wanted:
            if k:
                each = clock[k - 1]
                parts.append(each.table.load([each.value], None))
                columns[k] = parts[-1].columns[each.value]
        findings = dict.fromkeys(finding for part in parts for finding in part.findings)
        return Loaded(columns=columns, findings=tuple(findings))

    names = [each.table.kind.label for each in clock if each.table.kind is not None]
    units = [each.table.columns[each.value].unit for each in clock]
    return replace(
        first.table,
        columns=(
            first.table.columns[first.time],
            *(Column(name=name, unit=unit) for name, unit in zip(names, units, strict=True)),
        ),
        notes=(*first.table.notes, f"a row for each value; channels {', '.join(names)}"),
        load=load,
        topic=topic,
        rows=len(first.stamps),
        kind=None,
    )
