"""Rows at the end that were never written: what a logger left of a file that it laid out in advance, or a copy of one.

Such a file has its full length from the beginning, and where it was not written it reads as zeros. Sensors at rest do give
an exact 0, so that one value of 0 says nothing; that everything is 0 at once, up to the end, does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.findings.finding import Finding

__all__ = ["without_unwritten"]

_ROWS = 8  # that are 0 in all columns
_TIMES = 4  # as many as are 0 in all columns anywhere before: coarse counts of a sensor at rest are 0 now and then
_OF_ONE = 64  # that are 0 in one column, which is 0 nowhere before
_PIECE = 1 << 16


def without_unwritten(
    columns: Mapping[int, NDArray[Any]], time: int | None, labels: Sequence[str]
) -> tuple[dict[int, NDArray[Any]], tuple[Finding, ...]]:
    """The columns up to where they were written, and what is left out.

    Left out are rows at the end in which all columns, at least two, are 0, or the time is; and those from where on one
    column of several is 0, if that is a long run and it was 0 nowhere before: containers that hold a column after the other
    break off within one. The row before them goes too: the break may lie within it.

    Parameters
    ----------
    columns : mapping of int to ndarray, shape (n,)
    time : int or None
        The column of the stamps.
    labels : sequence of str
        Of all columns of the table, for the words.
    """
    kept = dict(columns)
    n = min(map(len, kept.values()), default=0)
    if n <= 1 or len(kept) < 2:
        return kept, ()
    zeros = {index: _zeros_at_end(array[:n]) for index, array in kept.items()}
    together = min(zeros.values())
    if together >= n:  # of a log that is 0 from end to end other things are said
        return kept, ()
    if time is not None and 0 < zeros[time] < n and kept[time][n - zeros[time] - 1] > 0:
        return _cut(kept, n - zeros[time], f"the time stamp {labels[time]} is")
    if together >= _ROWS and together > _TIMES * _longest(kept, n - together):
        return _cut(kept, n - together, f"all {len(kept)} columns are")
    for index, run in zeros.items():
        if _OF_ONE <= run < n and index != time and np.all(kept[index][: n - run] != 0):
            return _cut(kept, n - run, f"column {labels[index]}, which is not 0 anywhere before, is")
    return kept, ()


def _cut(
    columns: Mapping[int, NDArray[Any]], rows: int, what: str
) -> tuple[dict[int, NDArray[Any]], tuple[Finding, ...]]:
    n = min(map(len, columns.values()))
    finding = Finding(
        code="never_written",
        severity="error",
        message=f"in the last {n - rows} of {n} rows {what} exactly 0: they were never written to; the first {rows - 1} are"
        " read, and the one before the zeros is given up with them, for it may be half written",
        effect="the rest of the log is missing; get or make the file again",
        where=f"row {rows - 1}",
    )
    return {index: array[: rows - 1] for index, array in columns.items()}, (finding,)


def _longest(columns: Mapping[int, NDArray[Any]], rows: int) -> int:
    """The most rows one after the other, of the first so many, in which all columns are 0."""
    zero = np.ones(rows, dtype=bool)
    for array in columns.values():
        zero &= array[:rows] == 0
    ends = np.flatnonzero(~zero)
    return int(np.diff(ends, prepend=-1, append=rows).max(initial=1)) - 1


def _zeros_at_end(array: NDArray[Any]) -> int:
    """How many numbers at the end are 0; of a column on disk no more is read than is needed."""
    end, step = len(array), _ROWS
    while end > 0:
        start = max(0, end - step)
        others = np.flatnonzero(array[start:end])
        if len(others):
            return len(array) - (start + int(others[-1]) + 1)
        end, step = start, _PIECE
    return len(array)
