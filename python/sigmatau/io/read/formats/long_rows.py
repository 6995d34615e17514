"""Tables with one row per value, ``0.01,gyro_x,0.002``. Each channel becomes a column with a separate time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from sigmatau.io.read.names import recognise
from sigmatau.io.read.table import Column, Loaded, Table


def join_channels(tables: Sequence[Table]) -> Sequence[Table]:
    """Join the kinds of rows into a table of times and values, if the word of each kind is the name of a channel.

    Other tables are returned as they are. `sigmatau.io.read.repeated_clocks` joins equal times.
    """
    labels = [table.kind.label for table in tables if table.kind is not None]
    channels = {match[0] for match in recognise([Column(name=label) for label in labels]) if match is not None}
    places = [place for table in tables if (place := _find_value(table)) is not None]
    if not 1 < len(channels - {"time"}) == len(tables) == len(places):
        return tables
    sources = [(table, place) for table, pair in zip(tables, places, strict=True) for place in pair]
    named = [
        column
        for label, table, (time, value) in zip(labels, tables, places, strict=True)
        for column in (table.columns[time], replace(table.columns[value], name=label))
    ]

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        parts = {k: sources[k][0].load([sources[k][1]], sources[k][1] if k == exact else None) for k in wanted}
        findings = dict.fromkeys(finding for part in parts.values() for finding in part.findings)
        return Loaded(columns={k: part.columns[sources[k][1]] for k, part in parts.items()}, findings=tuple(findings))

    notes = (*tables[0].notes[:-1], f"a row for each value of {', '.join(labels)}")
    return [replace(tables[0], columns=tuple(named), notes=notes, load=load, topic="", rows=None, kind=None)]


def _find_value(table: Table) -> tuple[int, int] | None:
    """The only time column and the only value column of a kind of rows; None if it has others."""
    matches = recognise(table.columns)
    times = [k for k, match in enumerate(matches) if match is not None]
    values = [k for k, match in enumerate(matches) if match is None and (table.kind is None or k != table.kind.column)]
    return (times[0], values[0]) if len(times) == len(values) == 1 else None
