"""Cells of a table of runs, one for each group, channel and term, and the random effects of each cell."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import Floats, Ints
from sigmatau.frozen import frozen
from sigmatau.lab.lots.group_effects import GroupEffects, group_effects
from sigmatau.lab.lots.runs import LIMITED, OBSERVED, SIGNED, WITHOUT_ERROR, RunTable


@frozen(eq=False)
class Cells:
    """Cells of a table of runs: the values of a group, channel and term. Arrays have one entry per cell."""

    group: Ints  # position of the group's name
    label: Ints  # position of the label
    order: Ints  # rows of the table, cell by cell
    first: Ints  # first entry of a cell in `order`
    valued: Ints  # number of values
    looked: Ints  # number of values and upper limits
    limit: Floats  # largest upper limit of the runs without a value, NaN if there is none [SI]
    std: Floats  # standard deviation of the values, ddof = 1 [SI]
    delta: Floats  # mean δ of the paper's rule, NaN if no run has one [SI]
    typical: Floats  # mean standard error of a run, NaN if a run has none [SI]
    has_errors: NDArray[np.bool_]  # whether all values have errors

    def rows(self, cell: int) -> Ints:
        """Rows of the table whose values a cell compares."""
        return self.order[self.first[cell] : self.first[cell] + self.valued[cell]]

    def limited(self, cell: int) -> Ints:
        """Rows of the table with the upper limits of the runs of a cell that do not show the term."""
        return self.order[self.first[cell] + self.valued[cell] : self.first[cell] + self.looked[cell]]


def sort_into_cells(table: RunTable, group_of_run: Ints, usable: NDArray[np.bool_]) -> Cells:
    """Sort the rows of the usable runs into cells; the values of a cell are in the order of the runs."""
    labels = max(len(table.labels), 1)
    valued = (table.status == OBSERVED) | (table.status == WITHOUT_ERROR)
    counted = usable[table.run] & (valued | (table.status == LIMITED))
    rows = np.flatnonzero(counted)
    code = group_of_run[table.run[rows]] * labels + table.label[rows]
    codes, cell = np.unique(code, return_inverse=True)
    looked = np.bincount(cell, minlength=len(codes))
    with_value = valued[rows]
    values_of_cell = np.bincount(cell[with_value], minlength=len(codes))
    limit = np.full(len(codes), np.nan)
    np.fmax.at(limit, cell[~with_value], table.limit[rows[~with_value]])
    order = rows[np.lexsort((table.run[rows], ~with_value, cell))]
    first = np.concatenate([[0], np.cumsum(looked)[:-1]]).astype(np.int64) if len(codes) else np.zeros(0, np.int64)
    values, cell_of_value = table.value[rows[with_value]], cell[with_value]
    k = np.maximum(values_of_cell, 1)
    mean = np.bincount(cell_of_value, weights=values, minlength=len(codes)) / k
    with np.errstate(over="ignore"):  # values near the largest number have no finite spread
        squares = np.bincount(cell_of_value, weights=(values - mean[cell_of_value]) ** 2, minlength=len(codes))
    std = np.where(values_of_cell > 1, np.sqrt(squares / np.maximum(values_of_cell - 1, 1)), np.nan)
    signed = np.array([label.term in SIGNED for label in table.labels], dtype=bool)
    errors = table.error[rows[with_value]]
    absolute = np.where(signed[table.label[rows[with_value]]], errors, errors * np.abs(values))
    has_errors = np.bincount(cell_of_value, weights=np.isnan(errors), minlength=len(codes)) == 0
    typical = np.bincount(cell_of_value, weights=absolute, minlength=len(codes)) / k
    deltas = table.delta[rows[with_value]]
    stated = np.isfinite(deltas)
    with_delta = np.bincount(cell_of_value[stated], minlength=len(codes))
    total = np.bincount(cell_of_value[stated], weights=deltas[stated], minlength=len(codes))
    return Cells(
        group=codes // labels,
        label=codes % labels,
        order=order,
        first=first,
        valued=values_of_cell,
        looked=looked,
        limit=limit,
        std=std,
        delta=np.where(with_delta > 0, total / np.maximum(with_delta, 1), np.nan),
        typical=np.where(values_of_cell > 0, typical, np.nan),
        has_errors=has_errors,
    )


def estimate_effects(table: RunTable, cells: Cells, *, level: float) -> GroupEffects:
    """Estimate the random effects of all cells; cells with similar numbers of runs are computed together."""
    signed = np.array([label.term in SIGNED for label in table.labels], dtype=bool)
    count = len(cells.valued)
    estimates: dict[str, NDArray[Any]] = {}
    for estimate in fields(GroupEffects):
        is_integer = estimate.name in ("k", "outlier")
        estimates[estimate.name] = np.zeros(count, dtype=np.int64) if is_integer else np.full(count, np.nan)
    estimates["outlier"][:] = -1
    size = np.ceil(np.log2(np.maximum(cells.valued, 1))).astype(int)
    for has_errors in (False, True):
        for power in np.unique(size):
            chosen = np.flatnonzero((cells.has_errors == has_errors) & (size == power) & (cells.valued > 0))
            if not len(chosen):
                continue
            runs = int(cells.valued[chosen].max())
            columns = np.arange(runs)
            valid = columns < cells.valued[chosen, None]
            places = np.where(valid, cells.first[chosen, None] + columns, 0)
            row = cells.order[places]
            is_signed = signed[cells.label[chosen]][:, None]
            value = np.where(valid, table.value[row], 1.0)
            with np.errstate(divide="ignore", invalid="ignore"):
                value = np.where(is_signed, value, np.log(value))
            values = np.where(valid, value, np.nan)
            errors = np.where(valid, table.error[row], np.nan) if has_errors else None
            part = group_effects(values, errors, level=level)
            for name, array in estimates.items():
                array[chosen] = getattr(part, name)
    return GroupEffects(**estimates)


def holm(p: Floats, group: Ints) -> Floats:
    """Correct p-values for the number of tests of each group (S. Holm, Scand. J. Statist. 6, 1979); NaN remains NaN."""
    corrected = np.full(len(p), np.nan)
    tested = np.flatnonzero(~np.isnan(p))
    order = tested[np.lexsort((p[tested], group[tested]))]
    if not len(order):
        return corrected
    test_group = group[order]
    first = np.searchsorted(test_group, test_group, side="left")
    tests = np.searchsorted(test_group, test_group, side="right") - first
    steps = np.minimum((tests - (np.arange(len(test_group)) - first)) * p[order], 1.0)
    rank = np.cumsum(np.diff(test_group, prepend=test_group[0]) != 0)
    corrected[order] = np.maximum.accumulate(steps + 2.0 * rank) - 2.0 * rank
    return corrected
