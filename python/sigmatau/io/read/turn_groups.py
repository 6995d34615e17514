"""Rows of several sensors in no fixed order: their samples are in groups, on several axes at once.

Each sensor has its bias on each axis, so the rows of two sensors are two clouds of points, and the place of a row on one
axis tells its place on the others. Noise and motion of one sensor leave no gap between two groups. A line that is locked to
the samples leaves gaps, but its groups follow each other periodically, with two values only if the period is four rows or
less. Rounding makes gaps, so axes of few values do not count.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_FEWEST_ROWS = 512
_FEWEST_VALUES = 32  # of an axis: fewer are of a coarse resolution
_AXES = 2  # that must differ
_EMPTY = 0.01  # share of the rows in the gap between two groups
_TAIL = 0.08  # share of the rows on each side of the gap
_GAP = 0.08  # width of the gap, over the range of the rows without tails: 0.02 for white noise, 0.017 for a line
_SHIFT = 2.0  # difference of the means of both groups, over the scatter within them
_CHANGES = 0.02  # share of the rows that are of another group than the row before: blocks of 50 rows
_LONGEST_PERIOD = 64  # of a line that is locked to the samples [rows]
_LONGEST_OF_TWO_VALUES = 4  # period of a line that may have two values [rows]
_EQUAL = 0.25  # difference of two means of a group, over the distance of the groups: 0.02 of it is noise
_PERIODIC = 0.95  # share of the rows that have the group of their place in the period


@dataclass(frozen=True, slots=True, kw_only=True)
class Groups:
    """Two groups of rows."""

    axis: int  # with the largest difference, over its scatter
    size: float  # difference of the means of this axis [unit of the samples]


def find_groups(parts: NDArray[np.float64], starts: NDArray[np.intp]) -> Groups | None:
    """The groups of rows that are in no fixed order; None if there are none.

    `parts`: shape (parts, rows, channels); `starts`: the first row of each part, shape (parts,).
    """
    rows = (starts[:, None] + np.arange(parts.shape[1])).ravel()
    fine = [len(np.unique(parts[..., k])) >= _FEWEST_VALUES for k in range(parts.shape[2])]
    parts = np.where(fine, parts, 0.0)
    x = (parts - parts.mean(axis=1, keepdims=True)).reshape(len(rows), -1)
    finite = np.isfinite(x).all(axis=1)
    x, rows = x[finite], rows[finite]
    scales = x.std(axis=0) if len(x) else np.zeros(0)
    if len(x) < _FEWEST_ROWS or np.count_nonzero(scales > 0) < _AXES:
        return None
    relative = x[:, scales > 0] / scales[scales > 0]
    projected = relative @ np.linalg.eigh(relative.T @ relative)[1][:, -1]
    border = _find_gap(projected)
    if border is None:
        return None
    above = projected > border
    if np.mean(above[1:] != above[:-1]) < _CHANGES or _is_line(projected, above, rows):
        return None
    sizes = x[above].mean(axis=0) - x[~above].mean(axis=0)
    scatter = np.sqrt((x[above].var(axis=0) + x[~above].var(axis=0)) / 2)
    shift = np.divide(np.abs(sizes), scatter, out=np.zeros_like(sizes), where=scatter > 0)
    if np.count_nonzero(shift >= _SHIFT) < _AXES:
        return None
    axis = int(np.argmax(shift))
    return Groups(axis=axis, size=float(abs(sizes[axis])))


def _find_gap(values: NDArray[np.float64]) -> float | None:
    """The middle of the widest interval with few values, if it is wide."""
    ordered = np.sort(values)
    tail, within = int(_TAIL * len(ordered)), max(int(_EMPTY * len(ordered)), 1)
    widths = ordered[tail + within : len(ordered) - tail] - ordered[tail : len(ordered) - tail - within]
    place = int(np.argmax(widths))
    if not widths[place] > _GAP * (ordered[-tail - 1] - ordered[tail]):
        return None
    return float(ordered[tail + place] + ordered[tail + place + within]) / 2


def _is_line(values: NDArray[np.float64], above: NDArray[np.bool_], rows: NDArray[np.intp]) -> bool:
    """Whether the place of a row in a period tells its group, in the whole log, as a line does that is locked to the
    samples. Blocks of rows of several sensors are periodic as well, but their rows have one mean in each group.
    """
    for period in range(1, _LONGEST_PERIOD + 1):
        places = rows % period
        counts = np.bincount(places, minlength=period)
        above_counts = np.bincount(places, weights=above, minlength=period)
        if np.maximum(above_counts, counts - above_counts).sum() >= _PERIODIC * len(above):
            means = np.bincount(places, weights=values, minlength=period) / np.maximum(counts, 1)
            high, low = means[above_counts > counts / 2], means[above_counts <= counts / 2]
            within = max(np.ptp(high), np.ptp(low))
            return period <= _LONGEST_OF_TWO_VALUES or bool(within > _EQUAL * (high.mean() - low.mean()))
    return False
