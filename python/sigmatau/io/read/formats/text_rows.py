"""The rows of a text table with a known layout: compiled code reads them; damage and mistakes of the user are
distinguished.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import formats
from sigmatau._native.formats import DayOrder
from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import Damaged, Place, SkippedLines
from sigmatau.frozen import frozen
from sigmatau.hints import TIME_COLUMN, WITHOUT_STAMPS
from sigmatau.io.read.formats import truncation
from sigmatau.io.read.formats.damage import largest_expansion, refuse_expansion
from sigmatau.io.read.formats.layout import Layout, header_fields
from sigmatau.io.read.formats.text_lines import COMMENTS, EXCHANGED, bare_fields
from sigmatau.io.read.names import recognise
from sigmatau.io.read.table import Column, Head, Loaded, RowKind
from sigmatau.io.read.time.dates import NO_STAMP, ORDERS, DateColumn, find_order, is_ordered, unwrap_clock
from sigmatau.record import memory

_IN_PIECES = "save it as .npy, which is not loaded whole, or let `sigmatau watch` read it in pieces"
_TAIL = 1 << 10  # size of the end of a file that is examined [bytes]


def read_rows(
    source: str | bytes,
    layout: Layout,
    wanted: Sequence[int],
    **options: Any,  # noqa: ANN401  of `formats.read_text`
) -> formats.TextColumns:
    """Read the columns of a text of this layout, below the lines before its first row. Raises `formats.TextReadError`."""
    return formats.read_text(
        source,
        delimiter=layout.delimiter,
        comment=COMMENTS,
        columns=len(layout.columns),
        wanted=tuple(wanted),
        decimal_comma=layout.decimal_comma,
        arrow=layout.arrow,
        **options,
    )


@frozen
class Text:
    """A text with a known layout. Loads its columns."""

    source: Path | bytes
    layout: Layout
    encoding: str
    gzip: bool
    dates: Mapping[int, DateColumn]  # columns of dates and times of day
    kind: RowKind | None = None  # the kind of the rows that are read

    def load(self, wanted: Sequence[int], exact: int | None) -> Loaded:
        findings: tuple[Finding, ...] = ()
        until: int | None = None
        order = self._order(exact)
        try:
            read = self._read(wanted, exact, None, order)
        except formats.TextReadError as error:
            until, damage = self._break(error, exact)
            try:
                read = self._read(wanted, exact, until, order)
            except formats.TextReadError:
                raise _explained(error, self.layout) from None
            findings = (Finding(details=replace(damage, kept=len(read.columns[0])), severity="error"),)
        last = until
        if (stop := self._other_header(read)) is not None:
            last = stop - 1
            read = self._read(wanted, exact, last, order)
            skipped = SkippedLines(what="header", line=stop, kept=len(read.columns[0]))
            findings = (Finding(details=skipped, severity="error"),)
        raw: dict[int, NDArray[Any]] = dict(zip(wanted, read.columns, strict=True))
        if exact is not None and read.integers is not None:
            raw[exact] = self._with_days(exact, read.integers, last)
        if read.hidden and (stop is None or read.first_hidden < stop):
            hidden = SkippedLines(what="comments", line=read.first_hidden, count=read.hidden)
            findings = (*findings, Finding(details=hidden, severity="error"))
        if last is None and len(self.layout.columns) - 1 in wanted and self._is_open(read):
            raw = {index: column[:-1] for index, column in raw.items()}
            findings = (*findings, Finding(details=SkippedLines(what="last"), severity="info"))
        return Loaded(columns=raw, findings=findings)

    def _with_days(self, column: int, stamps: NDArray[np.int64], lines: int | None) -> NDArray[np.int64]:
        """Add days to times of day, from the column of days, and continue after midnight. Other stamps are
        unchanged.
        """
        date = self.dates.get(column)
        if date is None or not date.period:
            return stamps
        if date.day is not None:
            days = self._read((date.day,), date.day, lines, self._order(date.day)).integers
            if days is not None:
                missing = (stamps == NO_STAMP) | (days == NO_STAMP)
                stamps = np.where(missing, NO_STAMP, stamps + np.where(missing, 0, days))
        return unwrap_clock(stamps, date.period)

    def _order(self, column: int | None) -> DayOrder | None:
        """The order of day and month in a column of dates; None if the column has no dates."""
        if column is None or not self._has_dates(column):
            return None
        first = self.layout.columns[column].first
        if not is_ordered(first):
            return ORDERS[0]
        lines: int | None = None
        stamps: dict[DayOrder, NDArray[np.int64]] = {}
        while not stamps:
            broken = dict.fromkeys(ORDERS, 0)
            for order in ORDERS:
                try:
                    read = self._read((column,), column, lines, order)
                except formats.TextReadError as error:
                    broken[order] = error.line
                else:
                    if read.integers is not None:
                        stamps[order] = read.integers
            farthest = max(broken, key=lambda order: broken[order])
            if stamps or min(broken.values()) < max(broken.values()) or lines is not None:
                break
            lines = broken[farthest] - 1  # both orders fail at the same damage
        if not stamps:
            return farthest
        named = repr(self.layout.columns[column].name) if self.layout.columns[column].name else str(column + 1)
        return find_order(named, first, stamps)

    def _has_dates(self, column: int) -> bool:
        return column in self.dates or any(date.day == column for date in self.dates.values())

    def _is_open(self, read: formats.TextColumns) -> bool:
        """Whether the last number may be truncated: it has no line end, and fewer decimals than the number above."""
        if isinstance(self.source, Path) and self.gzip:
            return read.open_end
        tail = self.source
        if isinstance(tail, Path):
            with tail.open("rb") as stream:
                stream.seek(max(stream.seek(0, 2) - _TAIL, 0))
                tail = stream.read()
        encoding, point = "latin-1" if self.encoding == "ascii" else self.encoding, ".,"[self.layout.decimal_comma]
        blanks = "\0 \x1a" if self.layout.delimiter == "\t" else "\0 \t\x1a"
        lines = tail[-_TAIL:].decode(encoding, "replace").rstrip(blanks).split("\n")
        if self.kind is not None:
            lines = [line for k, line in enumerate(lines) if k + 1 == len(lines) or self._is_of_kind(line)]
            if not self._is_of_kind(lines[-1]):
                return False
        if not lines[-1].strip() or lines[-1].lstrip().startswith(COMMENTS):
            return False
        if mark := self.layout.delimiter:
            trailing = [line.count(mark) == len(self.layout.columns) for line in lines[-2:]]
            if any(trailing):  # a delimiter also follows the last field
                return not trailing[-1]
        above, *_, last = 2 * [line.split(self.layout.delimiter)[-1].strip() for line in lines[-2:] if line.strip()]
        return point not in last or len(last.partition(point)[2]) < len(above.partition(point)[2])

    def _is_of_kind(self, line: str) -> bool:
        """Whether a line is of the kind of rows that are read."""
        kind = self.kind
        return kind is None or bare_fields(line.strip(), self.layout.delimiter)[kind.column : kind.column + 1] == [
            kind.label
        ]

    def _other_header(self, read: formats.TextColumns) -> int | None:
        """The line of the first header that names other columns."""
        names = [column.name for column in self.layout.columns[: len(self.layout.columns) - self.layout.arrow]]
        for line, text in read.headers:
            # In text with decimal commas the decoder has exchanged commas and points.
            fields = header_fields(text.translate(EXCHANGED) if self.layout.decimal_comma else text, self.layout)
            named = [Column(name=name) for name in fields]
            if fields and fields != names and recognise(named) != recognise(self.layout.columns):
                return line
        return None

    def _read(
        self, wanted: Sequence[int], exact: int | None, lines: int | None, order: DayOrder | None
    ) -> formats.TextColumns:
        return read_rows(
            self.source if isinstance(self.source, bytes) else str(self.source),
            self.layout,
            wanted,
            exact=exact,
            skip_lines=self.layout.skip_lines,
            encoding=self.encoding,
            lines=lines,
            dates=order,
            max_bytes=self._largest_size(),
            tag=None if self.kind is None else (self.kind.column, self._decoder_form(self.kind.label)),
        )

    def _decoder_form(self, text: str) -> str:
        """Convert a text of the file to the form of the decoder: exchange commas and points if numbers have decimal
        commas.
        """
        return text.translate(EXCHANGED) if self.layout.decimal_comma else text

    def _largest_size(self) -> int:
        """Largest size of unpacked text: its numbers take about as much memory as the text. [bytes]"""
        if not (self.gzip and isinstance(self.source, Path)):
            return largest_expansion(1 << 62)
        free = memory.available()
        allowed = largest_expansion(self.source.stat().st_size)
        return allowed if free is None else min(allowed, free)

    def _break(self, error: formats.TextReadError, exact: int | None) -> tuple[int, Damaged]:
        """Number of lines before the damage, and the damage. Raises `DataError` for any other mistake in the file."""
        if error.kind == "too_large" and isinstance(self.source, Path):
            if (allowed := self._largest_size()) < largest_expansion(stored := self.source.stat().st_size):
                raise DataError(
                    f"unpacks to more than the {allowed / 1e9:.3g} GB of memory that are free; {_IN_PIECES}"
                )
            refuse_expansion(stored, None)
        if error.kind == "memory":
            raise DataError(f"its rows do not fit in memory; {_IN_PIECES}")
        if error.kind == "truncated":
            return error.line, Damaged(truncated=True, what="gzip stream", place=Place("line", error.line + 1))
        if error.kind in ("ragged", "not_a_number", "too_long"):
            line = truncation.find_line(self.source, error.line, self.encoding)
            columns = len(self.layout.columns)
            end = columns - 1 - self.layout.arrow
            short = error.got < error.expected if error.kind == "ragged" else error.column == end
            if line.last and not line.ended and short and error.kind != "too_long":
                return error.line - 1, Damaged(truncated=True, place=Place("line", error.line))
            # In damaged compressed data earlier lines may be wrong and still look like rows.
            if not self.gzip and truncation.damaged(line.text, self.encoding):
                return error.line - 1, Damaged(place=Place("line", error.line), reason="bytes that are not text")
        if error.kind == "not_a_number" and error.column == exact and error.row == 0:
            raise _no_time(error, self.layout)
        raise _explained(error, self.layout, dates=self._has_dates(error.column)) from None

    def line(self, row: int) -> int:
        """The line number of a row. The text is read again, so this is only used for errors and findings."""
        blank = b" \r\n" if self.layout.delimiter == "\t" else b" \t\r\n"
        comments = tuple(c.encode() for c in COMMENTS)
        rows = -1
        for number, line in enumerate(truncation.iterate_lines(self.source, self.encoding), 1):
            text = line.strip(blank)
            if self.layout.arrow and b"->" in text:
                text = text.partition(b"->")[2].strip(blank)
            rows += (
                number > self.layout.skip_lines
                and bool(text)
                and not text.startswith(comments)
                and (self.kind is None or self._is_of_kind(text.decode("utf-8", "replace")))
            )
            if rows == row:
                return number
        raise DataError("changed while it was read")


def refuse_too_large(path: Path, head: Head, columns: int) -> None:
    """Raise `DataError` if the columns do not fit in memory."""
    lines = head.data.count(b"\n")
    free = memory.available()
    if head.whole or not lines or free is None:
        return
    rows = path.stat().st_size * lines / len(head.data)
    if 8 * rows * columns > free:
        raise DataError(
            f"about {rows:.2g} rows need {8e-9 * rows * columns:.3g} GB of memory, but {1e-9 * free:.3g} GB are free;"
            f" {_IN_PIECES}"
        )


def _no_time(error: formats.TextReadError, layout: Layout) -> DataError:
    name = layout.columns[error.column].name or f"number {error.column + 1}"
    return DataError(
        f"the time column {name} has {error.text!r}, which is neither a number nor a date"
        f" or time (such as 2026-03-01 12:00:00.000); name another column by {TIME_COLUMN}, or ignore it by"
        f" {WITHOUT_STAMPS}",
        place=f"line {error.line}",
    )


def _explained(error: formats.TextReadError, layout: Layout, *, dates: bool = False) -> DataError:
    place = f"line {error.line}"
    if layout.decimal_comma:
        error.text = error.text.translate(EXCHANGED)  # the text as it is in the file
    if error.kind == "ragged":
        last = " (the file was truncated, if it is the last)" if error.got < error.expected else ""
        return DataError(
            f"{error.got} field{'s' if error.got != 1 else ''}, {error.expected} expected;"
            f" correct or delete the line{last}",
            place=place,
        )
    if error.kind == "not_a_number":
        name = layout.columns[error.column].name or f"number {error.column + 1}"
        return DataError(
            f"column {name} has {error.text!r}, which is not a {'time' if dates else 'number'}; correct or delete"
            " the line",
            place=place,
        )
    if error.kind == "too_long":
        return DataError("longer than 1 MiB, so it is not a row; delete it", place=place)
    if error.kind == "truncated":
        return DataError(f"the gzip stream is truncated after line {error.line}; copy or record the file again")
    if error.kind == "damaged":
        return DataError(
            f"the compressed data are damaged after line {error.line}, and the lines before may be wrong too;"
            " copy or record the file again"
        )
    if error.kind == "empty":
        return DataError("has no row of data")
    return DataError(f"cannot be read: {error.text}")
