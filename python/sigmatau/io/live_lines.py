"""Lines of live input: samples of one sensor, and lines that repeat the line before."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.io.read.formats.keyed import find_records
from sigmatau.io.read.formats.layout import Layout
from sigmatau.io.read.formats.row_kinds import find_kinds
from sigmatau.io.read.names import recognise
from sigmatau.io.read.table import ABSURD, Loaded


def refuse_kinds(lines: bytes) -> None:
    """Raise `DataError` if a column shows rows of several sensors, which one rate does not fit."""
    kinds = find_kinds(lines.decode("latin-1"))
    if kinds is None or len(kinds.labels) < 2:
        return
    place = kinds.find_kind(kinds.labels[0]).place()
    raise DataError(
        f"{place}, so the rows are of several sensors. Pass on the rows of one sensor only, or save the log and run"
        " sigmatau analyze FILE"
    )


def find_named_layout(head: bytes) -> Layout | None:
    """Find the layout of lines of names and values, with spaces for the delimiters; None for other lines."""
    if b":" not in head and b"=" not in head:
        return None
    records = find_records(head)
    if records is None or records.lines > 1 or records.glued:
        return None
    layout = records.layout()
    sensors = any(match is not None and match[0] != "time" for match in recognise(layout.columns))
    return layout if sensors else None


def split_lines(piece: bytes) -> list[bytes]:
    """Split text into lines with their ends, as the reader of tables does: a carriage return alone ends no line."""
    lines = piece.split(b"\n")
    return [line + b"\n" for line in lines[:-1]] + ([lines[-1]] if lines[-1] else [])


def without_absurd(columns: list[NDArray[np.float64]], bad: list[str]) -> list[list[NDArray[np.float64]]]:
    """Split the samples at rows with an absurd or missing number; those rows are added to `bad`."""
    absurd = np.zeros(len(columns[0]), dtype=bool)
    for column in columns:
        absurd |= ~(np.abs(column) <= ABSURD)  # missing numbers too
    if not absurd.any():
        return [columns]
    rows = np.flatnonzero(absurd)
    bad += [next(f"{column[row]:g}" for column in columns if not abs(column[row]) <= ABSURD) for row in rows]
    borders = [-1, *rows.tolist(), len(absurd)]
    stretches = [(a + 1, b) for a, b in pairwise(borders) if b > a + 1]
    return [[column[a:b] for column in columns] for a, b in stretches]


def has_repeated_rows(good: list[list[NDArray[np.float64]]], time: int) -> bool:
    """Whether some rows repeat both the stamp and the values of the row before. Rows with coarse stamps repeat only the
    stamp.
    """
    same_stamp, same_row = 0, 0
    for columns in good:
        equal = np.stack([np.diff(column) == 0 for column in columns])
        same_stamp += int(np.count_nonzero(equal[time]))
        same_row += int(np.count_nonzero(equal.all(axis=0)))
    return 0 < same_stamp == same_row


def without_repeats(columns: list[NDArray[np.float64]], last: NDArray[np.float64] | None) -> list[NDArray[np.float64]]:
    """Remove rows that equal the row before from the columns. `last`: the row before the first."""
    rows = np.stack(columns)
    if not rows.size:
        return columns
    new = np.ones(rows.shape[1], dtype=bool)
    new[1:] = (rows[:, 1:] != rows[:, :-1]).any(axis=0)
    new[0] = last is None or bool((rows[:, 0] != last).any())
    return [column[new] for column in columns]


def not_loaded(*_: object) -> Loaded:
    """Raise `DataError`: there are no samples to load yet."""
    raise DataError("the samples have not arrived yet")  # columns are recognised by their names
