"""Text tables: CSV and its relatives, plain or gzip-compressed.

The layout is found out in `sigmatau.io.read.layout`; the rows are read by compiled code, which holds every line to that
layout and reads each number to the nearest double.
"""

from __future__ import annotations

import gzip
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from sigmatau import _kernels, memory
from sigmatau.errors import DataError, NonFiniteError
from sigmatau.io.read.layout import COMMENTS, Layout, find_layout
from sigmatau.io.read.table import Head, Loaded, Table

__all__ = ["read", "sniff"]

_CONTROL = bytes(set(range(32)) - set(b"\t\n\r\f\x1a"))  # 0x1a ends files of old systems


def sniff(head: bytes, path: Path) -> bool:
    """Whether the file is text: no control characters."""
    return not head.startswith((b"%PDF", b"#ROSBAG", b"\xff\xfe", b"\xfe\xff")) and not head.translate(
        None, bytes(set(range(256)) - set(_CONTROL))
    )


def read(path: Path, head: Head) -> tuple[Table]:
    """The columns of a text table; rows are read when they are loaded.

    Parameters
    ----------
    path : Path
    head : Head

    Raises
    ------
    DataError
        If no table is found in the head; by ``load``: for a row of another length, a word among the numbers, damaged
        compression; `NonFiniteError` for a NaN, an infinity or an empty field.
    """
    layout = find_layout(head.data, whole=head.whole)

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        if not head.gzip:
            _refuse_too_large(path, head, len(wanted) + (exact is not None))
        try:
            columns, integers = _kernels.read_text(
                str(path),
                delimiter=layout.delimiter,
                comment=COMMENTS,
                skip_lines=layout.skip_lines,
                columns=len(layout.columns),
                wanted=tuple(wanted),
                exact=exact,
            )
        except _kernels.TextReadError as error:
            raise _explained(error, layout) from None
        raw: dict[int, NDArray[Any]] = dict(zip(wanted, columns, strict=True))
        if exact is not None and integers is not None:
            raw[exact] = integers
        return Loaded(columns=raw)

    def where(row: int) -> str:
        return f"line {_line_of(path, row, layout, compressed=head.gzip)}"

    notes = (*(("gzip",) if head.gzip else ()), *layout.notes)
    return (Table(format="text", columns=layout.columns, notes=notes, load=load, where=where),)


def _refuse_too_large(path: Path, head: Head, columns: int) -> None:
    """Before hours of reading end in a process that the system kills."""
    lines = head.data.count(b"\n")
    free = memory.available()
    if head.whole or not lines or free is None:
        return
    rows = path.stat().st_size * lines / len(head.data)
    if 8 * rows * columns > free:
        raise DataError(
            f"some {rows:.2g} rows take {8e-9 * rows * columns:.3g} GB of memory, and {1e-9 * free:.3g} GB are free;"
            " save it as .npy, which is not loaded whole, or let `sigmatau watch` read it in pieces"
        )


def _explained(error: _kernels.TextReadError, layout: Layout) -> DataError:
    place = f", line {error.line}"
    if error.kind == "ragged":
        last = " (the file was cut off, if it is the last)" if error.got < error.expected else ""
        return DataError(
            f"{place}: {error.got} field{'s' if error.got != 1 else ''}, {error.expected} expected;"
            f" mend or delete the line{last}"
        )
    if error.kind in ("not_a_number", "non_finite"):
        name = layout.columns[error.column].name or f"number {error.column + 1}"
        where = f"{place}: column {name}"
        if error.kind == "not_a_number":
            return DataError(f"{where} has {error.text!r}, which is not a number; mend or delete the line")
        what = repr(error.text) if error.text else "nothing"
        return NonFiniteError(
            f"{where} has {what} (row {error.row} of the data, counted from 0), no finite number;"
            " refused until gaps are supported: cut the record there, or fill it in",
            channel=name,
            index=error.row,
        )
    if error.kind == "too_long":
        return DataError(f"{place}: longer than 1 MiB, so this is no line of a table; delete it")
    if error.kind == "truncated":
        return DataError(
            f"the compressed data break off or are damaged after line {error.line}; get or make the file again,"
            " or save what can be decompressed"
        )
    if error.kind == "empty":
        return DataError("has no row of data")
    return DataError(f"cannot be read: {error.text}")


def _line_of(path: Path, row: int, layout: Layout, *, compressed: bool) -> int:
    """The line of a row of data, found by going through the file again: only asked for when something is wrong."""
    blank = b" \r\n" if layout.delimiter == "\t" else b" \t\r\n"
    comments = tuple(c.encode() for c in COMMENTS)
    with gzip.open(path, "rb") if compressed else path.open("rb") as lines:
        rows = -1
        for number, line in enumerate(lines, 1):
            text = line.strip(blank)
            rows += number > layout.skip_lines and bool(text) and not text.startswith(comments)
            if rows == row:
                return number
    raise DataError("changed while it was being read")
