"""Compiled readers and writer of text tables, with their errors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau import _core
from sigmatau.frozen import frozen

_ANY_SIZE = 1 << 62  # [bytes]


class TextReadError(Exception):
    """A text table that cannot be read, with the place of the fault and the text there.

    Attributes
    ----------
    kind : str
        ``"ragged"``, ``"not_a_number"``, ``"too_long"``, ``"truncated"``, ``"damaged"``, ``"too_large"``, ``"memory"``,
        ``"io"`` or ``"empty"``.
    line : int
        Line of the file, counted from 1; 0 if unknown.
    row : int
        Row of data, counted from 0.
    column : int
        Column, counted from 0.
    text : str
        Text at this place, or the error of the system.
    got, expected : int
        Fields found and expected.
    """

    def __init__(self, kind: str, line: int, row: int, column: int, text: str, got: int, expected: int) -> None:
        super().__init__(f"{kind} at line {line}: {text}")
        self.kind = kind
        self.line = line
        self.row = row
        self.column = column
        self.text = text
        self.got = got
        self.expected = expected


@frozen
class TextColumns:
    """Columns of a text table, and the lines that were skipped between its rows. Lines count from 1.

    Attributes
    ----------
    columns : list of ndarray, shape (n,)
    integers : ndarray of int64 or None
        The exact column, if all its values are integers, or dates.
    hidden, first_hidden : int
        Number of lines that look like rows after a comment mark, and the first such line.
    headers : list of (int, str)
        Line number and text of the first 16 lines with as many fields as a row but no number.
    open_end : bool
        Whether the last line lacks a line end; not checked in large uncompressed files.
    """

    columns: list[NDArray[np.float64]]
    integers: NDArray[np.int64] | None
    hidden: int
    first_hidden: int
    headers: list[tuple[int, str]]
    open_end: bool


def read_text(
    source: str | bytes,
    *,
    delimiter: str | None,
    comment: tuple[str, ...],
    columns: int,
    wanted: tuple[int, ...],
    exact: int | None = None,
    skip_lines: int = 0,
    encoding: str = "ascii",
    decimal_comma: bool = False,
    lines: int | None = None,
    dates: DayOrder | None = None,
    arrow: bool = False,
    max_bytes: int = _ANY_SIZE,
    tag: tuple[int, str] | None = None,
) -> TextColumns:
    """Columns of a text table.

    Parameters
    ----------
    source : str or bytes
        Path of a file (gzip is recognised by the first bytes), or the text itself.
    delimiter : str or None
        One ASCII character; None for runs of white space.
    comment : tuple of str
        Lines that begin with one of these are skipped.
    columns : int
        Fields in every row.
    wanted : tuple of int
        Columns to return, counted from 0.
    exact : int or None
        A column to return as integers too, if all its values are integers that fit 64 bits.
    skip_lines : int
        Lines before the data.
    encoding : {"ascii", "utf-16-le", "utf-16-be"}
        ``"ascii"`` also for its supersets, such as UTF-8.
    decimal_comma : bool
        Whether the decimal separator is a comma; then 0.5 is not a number.
    lines : int or None
        Number of lines of the source to read; None for all.
    dates : {"day_first", "month_first"} or None
        Order of day and month in dates of the exact column, which come as nanoseconds since 1970; None for numbers.
    arrow : bool
        Whether each row begins with a time and an arrow; the time becomes the last column.
    max_bytes : int
        Largest size of a compressed file after unpacking. [bytes]
    tag : (int, str) or None
        Column, counted from 0, and its text in the rows to read; lines with another text are skipped.

    Raises
    ------
    TextReadError
    """
    writing = (encoding, decimal_comma, lines, dates, arrow, max_bytes, tag)
    how = (delimiter, list(comment), skip_lines, columns, list(wanted), exact, writing)
    try:
        parsed = _core.parse_text(source, *how) if isinstance(source, bytes) else _core.read_text(source, *how)
    except _core.TextError as error:
        raise TextReadError(*error.args) from None
    floats, integers, (hidden, first_hidden, headers), open_end = parsed
    return TextColumns(
        columns=floats,
        integers=integers,
        hidden=hidden,
        first_hidden=first_hidden,
        headers=headers,
        open_end=open_end,
    )


DayOrder = Literal["day_first", "month_first"]


@frozen
class Stamp:
    """A date or a time of day.

    Attributes
    ----------
    form : {"date", "day", "clock", "minutes"}
        What the text states: a day and a time, a day, a time, or minutes and seconds.
    nanoseconds : int
        Time since 1970; a time without a date counts as on 1 January 1970.
    ordered : bool
        Whether the order of day and month matters.
    """

    form: Literal["date", "day", "clock", "minutes"]
    nanoseconds: int
    ordered: bool


def parse_stamp(text: str, order: DayOrder = "day_first") -> Stamp | None:
    """The date or time of day that a text states; None for any other text."""
    parsed = _core.parse_stamp(text, order)
    return None if parsed is None else Stamp(form=parsed[0], nanoseconds=parsed[1], ordered=parsed[2])


@frozen
class Sentences:
    """The sentences of one name in a log.

    Attributes
    ----------
    columns : list of ndarray, shape (n,)
    broken, inner : int
        Number of lines that are not complete sentences, and number of such lines after the first row.
    examples : list of (int, str)
        Numbers of the first such lines, counted from 1, and their faults.
    other_count : int
        Number of complete sentences with other names.
    gap : (int, int)
        Length of the longest run of such sentences after the first row, and the line where it begins.
    other_name : str
        Name of the first such sentence.
    cut : bool
        Whether the last line is broken and has no line end.
    """

    columns: list[NDArray[np.float64]]
    broken: int
    inner: int
    examples: list[tuple[int, str]]
    other_count: int
    gap: tuple[int, int]
    other_name: str
    cut: bool


def read_sentences(
    path: str, *, name: str, fields: int, wanted: tuple[int, ...], max_bytes: int = _ANY_SIZE
) -> Sentences:
    """Read the wanted fields, counted from 0, of the VectorNav sentences `name` (without ``$``); raises
    `TextReadError`.
    """
    try:
        columns, broken, inner, examples, other_lines, cut = _core.read_sentences(
            path, name, fields, list(wanted), max_bytes
        )
    except _core.TextError as error:
        raise TextReadError(*error.args) from None
    count, gap, example = other_lines
    return Sentences(
        columns=columns,
        broken=broken,
        inner=inner,
        examples=examples,
        other_count=count,
        gap=gap,
        other_name=example,
        cut=cut,
    )


def bytes_read() -> int:
    """Number of bytes of files that the compiled readers of this process have read so far, for a progress bar."""
    return _core.bytes_read()


def format_text(delimiter: str, columns: Sequence[NDArray[Any]]) -> bytes:
    """Columns as lines of text, each number with the fewest digits that read back to the same bits."""
    return _core.format_text(delimiter, [np.ascontiguousarray(c, dtype=np.float64) for c in columns])
