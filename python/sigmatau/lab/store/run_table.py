"""Coefficients of a store as the table that `compare_runs` compares: a million rows in less than a second."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.distributions import normal_quantile
from sigmatau.analysis import as_result
from sigmatau.arrays import Floats
from sigmatau.lab.lots.conditions import condition_groups
from sigmatau.lab.lots.preparing import mark_copies
from sigmatau.lab.lots.runs import (
    LIMITED,
    MEAN,
    OBSERVED,
    SIGNED,
    WITHOUT_ERROR,
    WITHOUT_INTERVAL,
    ComparedRun,
    Label,
    RunsBuilder,
    RunTable,
    joined,
)
from sigmatau.lab.store.packing import NUMBERS, contents
from sigmatau.noise.terms import TERMS

if TYPE_CHECKING:
    from sqlalchemy import ColumnElement
    from sqlalchemy.engine import Connection

_TERMS = (*TERMS, MEAN)


def run_table(connection: Connection, conditions: list[ColumnElement[bool]]) -> RunTable:
    """Rows of the runs that have coefficients. Of the results of a log with several options, the latest fit is taken,
    or else the latest that was read off. The runs of a unit at each temperature and supply are those of a separate unit.

    If a log has results with several options, the latest fit is used, otherwise the latest read-off. Runs of a unit at
    different temperatures count as those of different units. Lines and filters of the fits are not read, so that clocks
    are not compared. δ of eq. (26) is read for up to 1000 runs.
    """
    from sqlalchemy import select

    from sigmatau.lab.store.tables import label, model, result, run, unit

    columns = label.c
    labels = connection.execute(
        select(columns.id, columns.channel, columns.quantity, columns.term, columns.unit, columns.rate_unit)
    ).all()
    rows = connection.execute(
        select(
            run.c.id, unit.c.name, run.c.name, run.c.sha256, result.c.numbers, run.c.state, run.c.temperature,
            run.c.supply,
        )
        .join_from(run, unit)
        .join(result, result.c.run_id == run.c.id)
        .outerjoin(model, unit.c.model_id == model.c.id)
        .where(*conditions, run.c.state.in_(("fitted", "not_fitted")))
        .order_by(unit.c.name, run.c.recorded, run.c.id)
    ).all()  # fmt: skip
    rising = sorted(rows, key=lambda row: (row[5] == "fitted", row[0]))
    latest = {(serial, sha or key): key for key, serial, _, sha, *_ in rising}
    conditions_of_runs = condition_groups([row[6] for row in rows], [row[7] for row in rows])
    groups = dict(zip((row[0] for row in rows), conditions_of_runs, strict=True))
    usable = [row for row in rows if latest[row[1], row[3] or row[0]] == row[0]]
    fitted = [row for row in usable if row[5] == "fitted"]
    numbers = np.frombuffer(b"".join(row[4] for row in fitted), dtype=NUMBERS)
    counts = np.array([len(row[4]) // NUMBERS.itemsize for row in fitted], dtype=np.int64)
    table = _table(
        runs=tuple(
            ComparedRun(
                name=name,
                serial=f"{serial} {groups[key]}".strip(),
                sha256=sha,
                temperature=temperature,
                supply=supply,
            )
            for key, serial, name, sha, _, _, temperature, supply in fitted
        ),
        labels={
            key: Label(channel=c, quantity=q, term=t, unit=u, rate_unit=r)
            for key, c, q, t, u, r in sorted(labels, key=_order)
        },
        run=np.repeat(np.arange(len(fitted)), counts),
        numbers=numbers,
    )
    if len(fitted) <= _MOST_CONTENTS:
        table = _with_deltas(connection, table, [row[0] for row in fitted])
    lines = _read_off_alone(connection, [row for row in usable if row[5] != "fitted"][:_MOST_CONTENTS], groups)
    whole = joined([table, lines]) if len(lines.run) else table
    return replace(whole, runs=mark_copies(whole))  # a log that was saved again has equal values


_MOST_CONTENTS = 1000
"""Largest number of runs whose whole results are read, which takes a millisecond each: the tables have no read-offs."""


def _with_deltas(connection: Connection, table: RunTable, keys: list[int]) -> RunTable:
    """Add δ of eq. (26) for coefficients that were read off in addition to a fit."""
    position = {key: index for index, key in enumerate(keys)}
    deltas = {
        (position[key], channel, term): float(line["error"])
        for key, content in contents(connection, keys, without_damaged=True)
        for channel, part in content["channels"].items()
        for term, line in (part.get("read_off") or {}).items()
    }
    names = [(label.channel, label.term) for label in table.labels]
    rows = zip(table.run.tolist(), table.label.tolist(), table.value.tolist(), strict=True)
    row_deltas = [
        math.nan if math.isnan(value) else deltas.get((run, *names[label]), math.nan) for run, label, value in rows
    ]
    return replace(table, delta=np.array(row_deltas, dtype=np.float64))


def _read_off_alone(connection: Connection, rows: Sequence[Any], groups: Mapping[int, str]) -> RunTable:
    """The rows of results without a fit whose coefficients were read off."""
    builder, row_by_key = RunsBuilder(), {row[0]: row for row in rows}
    for key, content in contents(connection, list(row_by_key)):
        parts = content["channels"].values()
        if any(part.get("read_off") for part in parts) and not any("fit" in part for part in parts):
            serial = f"{row_by_key[key][1]} {groups[key]}".strip()
            builder.add_result(as_result(content), name=row_by_key[key][2], serial=serial)
    return builder.table()


def _order(label: Sequence[Any]) -> tuple[Any, ...]:
    """Sort key: gyros first, and terms in the order of results."""
    _, channel, quantity, term, *units = label
    return quantity != "angular_rate", quantity, channel, _TERMS.index(term) if term in _TERMS else -1, units


def _table(
    *, runs: tuple[ComparedRun, ...], labels: dict[int, Label], run: NDArray[np.int64], numbers: NDArray[np.void]
) -> RunTable:
    positions = np.zeros(max(labels, default=0) + 1, dtype=np.int64)
    positions[list(labels)] = np.arange(len(labels))
    signed = np.array([label_.term in SIGNED for label_ in labels.values()], dtype=bool)
    means = np.array([label_.term == MEAN for label_ in labels.values()], dtype=bool)
    label = positions[numbers["label"]]
    value, limit = numbers["value"], numbers["limit"]
    keep = np.flatnonzero(~(np.isnan(value) & np.isnan(limit)))
    run, label, value, limit, numbers = run[keep], label[keep], value[keep], limit[keep], numbers[keep]
    valued = ~np.isnan(value)
    if not len(labels):
        signed = means = np.zeros(1, dtype=bool)
    error = _errors(value, numbers, signed=signed[label])
    mean = means[label]
    error = np.where(valued & (numbers["fits"] == 1) & ~mean, error, np.nan)
    status = np.where(np.isnan(error), WITHOUT_INTERVAL, OBSERVED)
    status = np.where(mean, WITHOUT_ERROR, np.where(valued, status, LIMITED)).astype(np.int8)
    return RunTable(
        runs=runs,
        labels=tuple(labels.values()),
        run=run,
        label=label,
        value=np.ascontiguousarray(value),
        error=error,
        limit=np.where(valued, np.nan, limit),
        delta=np.full(len(value), np.nan),
        status=status,
    )


def _errors(value: Floats, numbers: NDArray[np.void], *, signed: NDArray[np.bool_]) -> Floats:
    """Standard errors, like `lots.runs.standard_error`: relative, or in SI for signed values; NaN without an interval."""
    low, high = np.ascontiguousarray(numbers["low"]), np.ascontiguousarray(numbers["high"])
    levels, which = np.unique(numbers["level"], return_inverse=True)
    z = normal_quantile((1 + levels) / 2)[which]
    with np.errstate(invalid="ignore", divide="ignore"):
        inside = (low <= value) & (value <= high) & (low < high)
        relative = np.where((value > 0) & (value < high), np.log(high / value) / z, np.nan)
        errors = np.where(signed, (high - low) / (2 * z), relative)
    return np.where(inside, errors, np.nan)
