"""Rows of a table of runs by group, channel and term, and the random effects of each."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.frozen import frozen
from sigmatau.lab.lots.group_effects import Floats, GroupEffects, Ints, group_effects
from sigmatau.lab.lots.runs import LIMITED, OBSERVED, SIGNED, WITHOUT_ERROR, RunTable


@frozen(eq=False)
class Cells:
    """Groups of values; arrays with one entry per cell."""

    group: Ints  # position of the group's name
    label: Ints  # position of the label
    order: Ints  # rows of the table, cell by cell
    first: Ints  # of a cell in `order`
    seen: Ints  # values
    looked: Ints  # values and upper limits
    limit: Floats  # largest upper limit of the runs without a value, NaN if there is none [SI]
    std: Floats  # standard deviation of the values, ddof = 1 [SI]
    delta: Floats  # mean δ of the paper's rule, NaN if no run has one [SI]
    typical: Floats  # mean standard error of a run, NaN if a run has none [SI]
    known: NDArray[np.bool_]  # whether all values have errors

    def rows(self, at: int) -> Ints:
        """Rows of the table whose values a cell compares."""
        return self.order[self.first[at] : self.first[at] + self.seen[at]]

    def limited(self, at: int) -> Ints:
        """Rows of the table with the upper limits of the runs of a cell that do not show the term."""
        return self.order[self.first[at] + self.seen[at] : self.first[at] + self.looked[at]]


def cells_of(table: RunTable, group_of_run: Ints, usable: NDArray[np.bool_]) -> Cells:
    """Sort the rows of the usable runs into cells; the values of a cell are in the order of the runs."""
    labels = max(len(table.labels), 1)
    valued = (table.status == OBSERVED) | (table.status == WITHOUT_ERROR)
    counted = usable[table.run] & (valued | (table.status == LIMITED))
    rows = np.flatnonzero(counted)
    code = group_of_run[table.run[rows]] * labels + table.label[rows]
    codes, cell = np.unique(code, return_inverse=True)
    looked = np.bincount(cell, minlength=len(codes))
    with_value = valued[rows]
    seen = np.bincount(cell[with_value], minlength=len(codes))
    limit = np.full(len(codes), np.nan)
    np.fmax.at(limit, cell[~with_value], table.limit[rows[~with_value]])
    order = rows[np.lexsort((table.run[rows], ~with_value, cell))]
    first = np.concatenate([[0], np.cumsum(looked)[:-1]]).astype(np.int64) if len(codes) else np.zeros(0, np.int64)
    values, own = table.value[rows[with_value]], cell[with_value]
    k = np.maximum(seen, 1)
    mean = np.bincount(own, weights=values, minlength=len(codes)) / k
    with np.errstate(over="ignore"):  # of values near the largest number, whose spread is then not known
        squares = np.bincount(own, weights=(values - mean[own]) ** 2, minlength=len(codes))
    std = np.where(seen > 1, np.sqrt(squares / np.maximum(seen - 1, 1)), np.nan)
    signed = np.array([label.term in SIGNED for label in table.labels], dtype=bool)
    errors = table.error[rows[with_value]]
    absolute = np.where(signed[table.label[rows[with_value]]], errors, errors * np.abs(values))
    known = np.bincount(own, weights=np.isnan(errors), minlength=len(codes)) == 0
    typical = np.bincount(own, weights=absolute, minlength=len(codes)) / k
    deltas = table.delta[rows[with_value]]
    stated = np.isfinite(deltas)
    with_delta = np.bincount(own[stated], minlength=len(codes))
    total = np.bincount(own[stated], weights=deltas[stated], minlength=len(codes))
    return Cells(
        group=codes // labels,
        label=codes % labels,
        order=order,
        first=first,
        seen=seen,
        looked=looked,
        limit=limit,
        std=std,
        delta=np.where(with_delta > 0, total / np.maximum(with_delta, 1), np.nan),
        typical=np.where(seen > 0, typical, np.nan),
        known=known,
    )


def effects_of(table: RunTable, cells: Cells, *, level: float) -> GroupEffects:
    """Random effects of all cells, those of similar numbers of runs together."""
    signed = np.array([label.term in SIGNED for label in table.labels], dtype=bool)
    count = len(cells.seen)
    found: dict[str, NDArray[Any]] = {}
    for one in fields(GroupEffects):
        whole = one.name in ("k", "outlier")
        found[one.name] = np.zeros(count, dtype=np.int64) if whole else np.full(count, np.nan)
    found["outlier"][:] = -1
    size = np.ceil(np.log2(np.maximum(cells.seen, 1))).astype(int)
    for known in (False, True):
        for power in np.unique(size):
            chosen = np.flatnonzero((cells.known == known) & (size == power) & (cells.seen > 0))
            if not len(chosen):
                continue
            runs = int(cells.seen[chosen].max())
            columns = np.arange(runs)
            there = columns < cells.seen[chosen, None]
            places = np.where(there, cells.first[chosen, None] + columns, 0)
            row = cells.order[places]
            plain = signed[cells.label[chosen]][:, None]
            value = np.where(there, table.value[row], 1.0)
            with np.errstate(divide="ignore", invalid="ignore"):
                value = np.where(plain, value, np.log(value))
            values = np.where(there, value, np.nan)
            errors = np.where(there, table.error[row], np.nan) if known else None
            part = group_effects(values, errors, level=level)
            for name, array in found.items():
                array[chosen] = getattr(part, name)
    return GroupEffects(**found)


def holm(p: Floats, group: Ints) -> Floats:
    """P-values corrected for the number of tests of each group (S. Holm, Scand. J. Statist. 6, 1979); NaN stays NaN."""
    found = np.full(len(p), np.nan)
    there = np.flatnonzero(~np.isnan(p))
    order = there[np.lexsort((p[there], group[there]))]
    if not len(order):
        return found
    own = group[order]
    first = np.searchsorted(own, own, side="left")
    tests = np.searchsorted(own, own, side="right") - first
    steps = np.minimum((tests - (np.arange(len(own)) - first)) * p[order], 1.0)
    rank = np.cumsum(np.diff(own, prepend=own[0]) != 0)
    found[order] = np.maximum.accumulate(steps + 2.0 * rank) - 2.0 * rank
    return found
