"""Rows at the end that were never written, in a file that the logger preallocated.

A preallocated file has its full length from the beginning, and its unwritten part reads as zeros. A sensor at rest may give
an exact 0, so a single 0 proves nothing; zeros in all columns up to the end of the file do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.reading import NeverWritten

__all__ = ["without_unwritten"]

_MIN_ROWS = 8  # shortest run of rows that are 0 in all columns
_RUN_RATIO = 4  # its length over that of the longest such run before: coarse counts of a sensor at rest are 0 at times
_MIN_ROWS_OF_ONE = 64  # shortest run of zeros in a single column, which is 0 nowhere before
_CHUNK = 1 << 16  # [rows]


def without_unwritten(
    columns: Mapping[int, NDArray[Any]], time: int | None, labels: Sequence[str]
) -> tuple[dict[int, NDArray[Any]], tuple[Finding, ...]]:
    """The columns up to their last written row, and a finding if rows are removed.

    Three kinds of rows at the end are removed: rows in which all columns (at least two) are 0; rows in which the time is 0;
    and a long run of zeros in a single column that is not 0 anywhere before, as in a container that stores one column
    after the other. The row before them is removed too, because it may be half written.

    `labels`: names of all columns of the table.
    """
    kept = dict(columns)
    n = min(map(len, kept.values()), default=0)
    if n <= 1 or len(kept) < 2:
        return kept, ()
    zeros = {index: _zeros_at_end(array[:n]) for index, array in kept.items()}
    together = min(zeros.values())
    if together >= n:  # other checks report a log of nothing but zeros
        return kept, ()
    if time is not None and 0 < zeros[time] < n and kept[time][n - zeros[time] - 1] > 0:
        return _cut(kept, n - zeros[time], labels[time], is_time=True)
    if together >= _MIN_ROWS and together > _RUN_RATIO * _longest(kept, n - together):
        return _cut(kept, n - together)
    for index, run in zeros.items():
        if _MIN_ROWS_OF_ONE <= run < n and index != time and np.all(kept[index][: n - run] != 0):
            return _cut(kept, n - run, labels[index])
    return kept, ()


def _cut(
    columns: Mapping[int, NDArray[Any]], rows: int, column: str = "", *, is_time: bool = False
) -> tuple[dict[int, NDArray[Any]], tuple[Finding, ...]]:
    n = min(map(len, columns.values()))
    details = NeverWritten(rows=n, zeros=n - rows, kept=rows - 1, column=column, is_time=is_time)
    kept = {index: array[: rows - 1] for index, array in columns.items()}
    return kept, (Finding(details=details, severity="error"),)


def _longest(columns: Mapping[int, NDArray[Any]], rows: int) -> int:
    """Longest run of rows that are 0 in all columns, among the first `rows`."""
    zero = np.ones(rows, dtype=bool)
    for array in columns.values():
        zero &= array[:rows] == 0
    ends = np.flatnonzero(~zero)
    return int(np.diff(ends, prepend=-1, append=rows).max(initial=1)) - 1


def _zeros_at_end(array: NDArray[Any]) -> int:
    """Number of zeros at the end; a column on disk is read backwards, in chunks."""
    end, step = len(array), _MIN_ROWS
    while end > 0:
        start = max(0, end - step)
        others = np.flatnonzero(array[start:end])
        if len(others):
            return len(array) - (start + int(others[-1]) + 1)
        end, step = start, _CHUNK
    return len(array)
