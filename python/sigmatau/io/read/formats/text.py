"""Text tables: CSV and its relatives, plain or gzip-compressed.

`layout` detects the layout. Compiled code reads the rows, checks each line against the layout, and rounds each number to the
nearest double.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import formats
from sigmatau._native.formats import DayOrder
from sigmatau.errors import DataError, OptionError
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.reading import Damaged, Place, SkippedLines
from sigmatau.io.read.formats import gcsv, ros_csv, truncation
from sigmatau.io.read.formats.damage import largest_expansion, refuse_expansion
from sigmatau.io.read.formats.layout import (
    COMMENTS,
    LINES,
    Layout,
    NoRowsError,
    bare_fields,
    decode,
    find_layout,
    header_fields,
)
from sigmatau.io.read.formats.preamble import SAMPLE_TIME, unwrapped
from sigmatau.io.read.formats.row_kinds import Kinds, find_kinds, first_values, rows_of_kind
from sigmatau.io.read.names import recognise
from sigmatau.io.read.table import HEAD, Column, Head, Loaded, RowKind, Table
from sigmatau.io.read.time.dates import NO_STAMP, ORDERS, DateColumn, continued, date_columns, is_ordered, order_of
from sigmatau.record import memory

_NOT_TEXT = (b"%PDF", b"#ROSBAG")
_UTF16 = {b"\xff\xfe": ("utf-16-le", "UTF-16 LE"), b"\xfe\xff": ("utf-16-be", "UTF-16 BE")}
_BOM = b"\xef\xbb\xbf"
_SENSOR_LOGGER = {
    "gyroscope": "gyroscope",
    "gyroscopeuncalibrated": "gyroscope",
    "accelerometer": "accelerometer",
    "accelerometeruncalibrated": "accelerometer",
    "totalacceleration": "accelerometer",
}
_COUNTED = {1_000_000: "us", 10_000: "0.1 ms"}  # what one count of SampleTimeFine is, by counts in a second
_IN_PIECES = "save it as .npy, which is not loaded whole, or let `sigmatau watch` read it in pieces"
_EXCHANGED = str.maketrans(",.", ".,")
_TAIL = 1 << 10  # [bytes]
_OVERLAP = 50  # lines that are searched twice, since names and units of columns are above the samples
_MOST_PREAMBLES = 64  # parts of 256 KiB or 2000 lines that are searched for a table, 16 MiB of text above it
_MIN_LINES = 16  # lines before the first bytes that are not text, to be a damaged table and not a binary file


@dataclass(frozen=True, slots=True, kw_only=True)
class _Beginning:
    """The head of a file in UTF-8, up to the first byte that is not text."""

    data: bytes
    whole: bool
    encoding: str
    called: str  # name of the encoding for the notes; empty if it is ASCII or not known yet
    skip: int = 0  # lines of the file above it

    @classmethod
    def of(cls, head: bytes, *, whole: bool) -> _Beginning:
        encoding, called = _UTF16.get(head[:2], ("ascii", "UTF-8 with a byte order mark" if head[:3] == _BOM else ""))
        data = head
        if encoding != "ascii":
            data = head[: len(head) // 2 * 2].decode(encoding, errors="replace").encode("utf-8", errors="replace")
        if bad := truncation.BREAK.search(data):
            return cls(
                data=data[: data.rfind(b"\n", 0, bad.start()) + 1], whole=False, encoding=encoding, called=called
            )
        return cls(data=data, whole=whole, encoding=encoding, called=called)


def sniff(head: bytes, path: Path) -> bool:
    """Whether the file is text: no control characters, or a table before the first of them."""
    if head.startswith(_NOT_TEXT):
        return False
    beginning = _Beginning.of(head, whole=True)
    if beginning.whole:
        return True
    if beginning.data.count(b"\n") < _MIN_LINES:
        return False
    try:
        find_layout(beginning.data, whole=False)
    except DataError:
        return False
    return True


def read(path: Path, head: Head, *, skip: int = 0) -> tuple[Table, ...]:
    """The columns of a text table below `skip` lines, which are read on demand; a table for each kind of rows, if it has
    several.
    """
    return tables_of(path, head, path.name.split(".")[0], skip=skip)


def tables_of(source: Path | bytes, head: Head, name: str, topic: str = "", *, skip: int = 0) -> tuple[Table, ...]:
    """The tables of a file, or of text in memory: one, or one for each kind of its rows. `name`: name of the file without
    its suffix; `topic`: name of the only table, or what those of several tables begin with.
    """
    beginning = _Beginning.of(head.data, whole=head.whole)
    if skip:
        beginning = _below(source, beginning, skip)
    try:
        lines, _ = decode(beginning.data, whole=beginning.whole)
    except DataError:
        lines = ""  # said by `find_layout`
    kinds = find_kinds(lines)
    tables = [] if kinds is None else list(_tables_of_kinds(source, head, beginning, lines, kinds, topic))
    return tuple(tables) or (_table_of(source, head, beginning, name, topic),)


def _tables_of_kinds(
    source: Path | bytes, head: Head, beginning: _Beginning, lines: str, kinds: Kinds, topic: str
) -> Iterator[Table]:
    """The tables of the kinds of rows that have a layout."""
    from sigmatau.io.read.formats.kind_columns import with_sensor_names

    for label in kinds.labels:
        rows = rows_of_kind(lines, kinds, label)
        kind_text, skip = rows.text, beginning.skip
        try:
            layout = find_layout(kind_text.encode(), whole=beginning.whole, encoding=beginning.called, skip=skip)
        except DataError:
            continue  # rows without numbers
        if layout.delimiter != kinds.delimiter or len(layout.columns) <= kinds.column:
            continue
        kind = kinds.kind_of(label)
        further = find_kinds(kind_text, without=kinds.column)
        if further is not None and len(further.labels) > 1:
            both = f"{kind.place()}, and {further.kind_of(label).place()}"
            raise DataError(f"{both}: rows of several sensors by both; save the rows of each sensor to its own file")
        columns, notes = with_sensor_names(layout.columns, label, first_values(kind_text, kinds, label))
        named = replace(
            layout,
            columns=columns,
            notes=(*layout.notes, kind.rows_of(), *notes),
            skip_lines=skip + rows.numbers[layout.skip_lines - skip] - 1,
        )
        yield _table_of(source, head, beginning, "", f"{topic}/{kind.topic}" if topic else kind.topic, named, kind)


def _table_of(
    source: Path | bytes,
    head: Head,
    beginning: _Beginning,
    name: str,
    topic: str,
    layout: Layout | None = None,
    kind: RowKind | None = None,
) -> Table:
    if layout is None:
        layout = _first_layout(source, beginning)
    if beginning.skip:
        skipped = f"the first {beginning.skip} lines skipped" if beginning.skip > 1 else "the first line skipped"
        layout = replace(layout, notes=(*layout.notes, skipped))
    dated, dates = date_columns(layout.columns)
    text = Text(
        source=source,
        layout=replace(layout, columns=dated),
        encoding=beginning.encoding,
        gzip=head.gzip,
        dates=dates,
        kind=kind,
    )

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        if isinstance(source, Path) and not head.gzip:
            _refuse_too_large(source, head, len(wanted) + (exact is not None))
        return text.load(tuple(wanted), exact)

    columns, named = _of_sensor_logger(dated, name)
    loaded: Callable[[Sequence[int], int | None], Loaded] = load
    if layout.counts_per_second is not None:
        columns, loaded, counted = _of_mt_manager(columns, load, layout.counts_per_second)
        named = (*named, counted)
    if scales := gcsv.find_scales(beginning.data):
        columns, loaded = gcsv.scaled(columns, loaded, scales)
        named = (*named, gcsv.NOTE)
    if layout.delimiter == "," and ros_csv.is_imu(columns):
        columns, loaded = ros_csv.named(columns, loaded)
        named = (*named, ros_csv.NOTE)
    return Table(
        format="text",
        columns=columns,
        notes=(*(("gzip",) if head.gzip else ()), *layout.notes, *named),
        load=loaded,
        rate=None if layout.rate is None else layout.rate.rate,
        rate_source=layout.rate.source if layout.rate else "",
        where=lambda row: f"line {text.line(row)}",
        topic=topic,
        kind=kind,
    )


def _below(source: Path | bytes, beginning: _Beginning, skip: int) -> _Beginning:
    """The beginning of a text below `skip` lines; raises `OptionError` if there is none."""
    data = truncation.beginning_below(source, skip, beginning.encoding, HEAD)
    if not data:
        raise OptionError(f"has fewer than {skip + 1} lines; {{option}} skips all of them", option="skip")
    return replace(beginning, data=data[:HEAD], whole=len(data) <= HEAD, skip=skip)


def _first_layout(source: Path | bytes, beginning: _Beginning) -> Layout:
    """The layout of the first table in a text, however many lines are above it; raises `DataError`.

    Lines above a table may look like rows of a table of their own. Thus a layout that does not fit the last line is only
    taken if the text goes on in it, or if no other is found.
    """
    first: Layout | NoRowsError
    try:
        first = find_layout(beginning.data, whole=beginning.whole, encoding=beginning.called, skip=beginning.skip)
    except NoRowsError as error:
        if beginning.whole and error.last - beginning.skip < LINES:
            raise DataError(error.message) from None
        first = error
    last = truncation.last_line(source, beginning.encoding)
    if isinstance(first, Layout) and (last is None or first.fits(last)):
        return first
    searched, skip = first.last, beginning.skip
    for _ in range(_MOST_PREAMBLES):
        if searched - skip <= _OVERLAP:
            break
        skip = searched - _OVERLAP
        data = truncation.beginning_below(source, skip, beginning.encoding, HEAD)
        if not data or truncation.BREAK.search(data):
            break
        try:
            layout = find_layout(data[:HEAD], whole=len(data) <= HEAD, encoding=beginning.called, skip=skip)
            if isinstance(first, NoRowsError) or (last is not None and layout.fits(last)):
                return layout
            searched = layout.last
        except NoRowsError as error:
            searched = error.last
        except DataError:
            break
        if isinstance(first, Layout) and layout.of_same_rows(first) and any(c.name for c in first.columns):
            break  # one table, whose end is damaged
        if len(data) <= HEAD and searched - skip < LINES:
            break
    if isinstance(first, Layout):
        return first
    raise DataError(f"{first}; if the table begins further down, give --skip N for N lines above it") from None


def _of_sensor_logger(columns: tuple[Column, ...], name: str) -> tuple[tuple[Column, ...], tuple[str, ...]]:
    """Columns of the app Sensor Logger with the sensor in their names: the columns of each file are x, y and z."""
    sensor = _SENSOR_LOGGER.get(name.lower())
    if sensor is None or {"seconds_elapsed", "x", "y", "z"} - {column.name for column in columns}:
        return columns, ()
    full = tuple(replace(c, name=f"{sensor} {c.name}") if c.name in ("x", "y", "z") else c for c in columns)
    return full, (f"x, y, z of the {sensor} by the name of the file, {name}",)


def _of_mt_manager(
    columns: tuple[Column, ...], load: Callable[[Sequence[int], int | None], Loaded], per_second: int
) -> tuple[tuple[Column, ...], Callable[[Sequence[int], int | None], Loaded], str]:
    """The columns and their loading with the counter SampleTimeFine as nanoseconds."""
    fine = next(k for k, column in enumerate(columns) if column.name.lower() == SAMPLE_TIME)

    def load_times(wanted: Sequence[int], exact: int | None) -> Loaded:
        loaded = load(wanted, exact)
        counts = loaded.columns.get(fine)
        if counts is None or counts.dtype != np.int64:
            return loaded
        return replace(loaded, columns={**loaded.columns, fine: unwrapped(counts, per_second)})

    counted = _COUNTED[per_second]
    timed = tuple(replace(c, unit="ns", counted=counted) if k == fine else c for k, c in enumerate(columns))
    return timed, load_times, f"SampleTimeFine counts 1/{per_second} s in 32 bits; read as ns"


@dataclass(frozen=True, slots=True, kw_only=True)
class Text:
    """A text whose layout is known, and the reading of its columns."""

    source: Path | bytes
    layout: Layout
    encoding: str
    gzip: bool
    dates: Mapping[int, DateColumn]  # columns of dates and times of day
    kind: RowKind | None = None  # the kind of the rows that are read

    def load(self, wanted: tuple[int, ...], exact: int | None) -> Loaded:
        found: tuple[Finding, ...] = ()
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
            found = (Finding(details=replace(damage, kept=len(read.columns[0])), severity="error"),)
        last = until
        if (stop := self._other_header(read)) is not None:
            last = stop - 1
            read = self._read(wanted, exact, last, order)
            kept = SkippedLines(what="header", line=stop, kept=len(read.columns[0]))
            found = (Finding(details=kept, severity="error"),)
        raw: dict[int, NDArray[Any]] = dict(zip(wanted, read.columns, strict=True))
        if exact is not None and read.integers is not None:
            raw[exact] = self._with_days(exact, read.integers, last)
        if read.hidden and (stop is None or read.first_hidden < stop):
            hidden = SkippedLines(what="comments", line=read.first_hidden, count=read.hidden)
            found = (*found, Finding(details=hidden, severity="error"))
        if last is None and len(self.layout.columns) - 1 in wanted and self._is_open(read):
            raw = {index: column[:-1] for index, column in raw.items()}
            found = (*found, Finding(details=SkippedLines(what="last"), severity="info"))
        return Loaded(columns=raw, findings=found)

    def _with_days(self, column: int, stamps: NDArray[np.int64], lines: int | None) -> NDArray[np.int64]:
        """Times of day with the days of the column that has them, and counted on after midnight; other stamps unchanged."""
        date = self.dates.get(column)
        if date is None or not date.period:
            return stamps
        if date.day is not None:
            days = self._read((date.day,), date.day, lines, self._order(date.day)).integers
            if days is not None:
                missing = (stamps == NO_STAMP) | (days == NO_STAMP)
                stamps = np.where(missing, NO_STAMP, stamps + np.where(missing, 0, days))
        return continued(stamps, date.period)

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
            lines = broken[farthest] - 1  # the same damage in both orders
        if not stamps:
            return farthest
        named = repr(self.layout.columns[column].name) if self.layout.columns[column].name else str(column + 1)
        return order_of(named, first, stamps)

    def _has_dates(self, column: int) -> bool:
        return column in self.dates or any(date.day == column for date in self.dates.values())

    def _is_open(self, read: formats.TextColumns) -> bool:
        """Whether the last number may be truncated: no line end follows, and it has fewer decimals than the one above."""
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
        own = [column.name for column in self.layout.columns[: len(self.layout.columns) - self.layout.arrow]]
        for line, text in read.headers:
            # In text with decimal commas the decoder exchanges commas and points.
            fields = header_fields(text.translate(_EXCHANGED) if self.layout.decimal_comma else text, self.layout)
            named = [Column(name=name) for name in fields]
            if fields and fields != own and recognise(named) != recognise(self.layout.columns):
                return line
        return None

    def _read(
        self, wanted: tuple[int, ...], exact: int | None, lines: int | None, order: DayOrder | None
    ) -> formats.TextColumns:
        return formats.read_text(
            self.source if isinstance(self.source, bytes) else str(self.source),
            delimiter=self.layout.delimiter,
            comment=COMMENTS,
            skip_lines=self.layout.skip_lines,
            columns=len(self.layout.columns),
            wanted=wanted,
            exact=exact,
            encoding=self.encoding,
            decimal_comma=self.layout.decimal_comma,
            lines=lines,
            dates=order,
            arrow=self.layout.arrow,
            most=self._most(),
            tag=None if self.kind is None else (self.kind.column, self._in_figures(self.kind.label)),
        )

    def _in_figures(self, text: str) -> str:
        """A text of the file as the decoder makes it: with commas and points exchanged where numbers have decimal commas."""
        return text.translate(_EXCHANGED) if self.layout.decimal_comma else text

    def _most(self) -> int:
        """Bytes that compressed text may be unpacked to: numbers take about as much memory as their text."""
        if not (self.gzip and isinstance(self.source, Path)):
            return largest_expansion(1 << 62)
        free = memory.available()
        allowed = largest_expansion(self.source.stat().st_size)
        return allowed if free is None else min(allowed, free)

    def _break(self, error: formats.TextReadError, exact: int | None) -> tuple[int, Damaged]:
        """The number of lines before the damage, and what it is; raises `DataError` for any other mistake in the file."""
        if error.kind == "too_large" and isinstance(self.source, Path):
            if (most := self._most()) < largest_expansion(stored := self.source.stat().st_size):
                raise DataError(f"unpacks to more than the {most / 1e9:.3g} GB of memory that are free; {_IN_PIECES}")
            refuse_expansion(stored, None)
        if error.kind == "memory":
            raise DataError(f"its rows do not fit in memory; {_IN_PIECES}")
        if error.kind == "truncated":
            return error.line, Damaged(truncated=True, what="gzip stream", place=Place("line", error.line + 1))
        if error.kind in ("ragged", "not_a_number", "too_long"):
            line = truncation.line_at(self.source, error.line, self.encoding)
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
        """The line of a row; the text is read again, so this is only used for errors and findings."""
        blank = b" \r\n" if self.layout.delimiter == "\t" else b" \t\r\n"
        comments = tuple(c.encode() for c in COMMENTS)
        rows = -1
        for number, line in enumerate(truncation.lines_of(self.source, self.encoding), 1):
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


def _refuse_too_large(path: Path, head: Head, columns: int) -> None:
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
        f", line {error.line}: the time column {name} has {error.text!r}, which is neither a number nor a date"
        " or time (such as 2026-03-01 12:00:00.000); name another column by --channels time=…, or ignore it by --channels"
        " time=none --rate HZ"
    )


def _explained(error: formats.TextReadError, layout: Layout, *, dates: bool = False) -> DataError:
    place = f", line {error.line}"
    if layout.decimal_comma:
        error.text = error.text.translate(_EXCHANGED)  # as in the file
    if error.kind == "ragged":
        last = " (the file was truncated, if it is the last)" if error.got < error.expected else ""
        return DataError(
            f"{place}: {error.got} field{'s' if error.got != 1 else ''}, {error.expected} expected;"
            f" correct or delete the line{last}"
        )
    if error.kind == "not_a_number":
        name = layout.columns[error.column].name or f"number {error.column + 1}"
        return DataError(
            f"{place}: column {name} has {error.text!r}, which is not a {'time' if dates else 'number'}; correct or delete"
            " the line"
        )
    if error.kind == "too_long":
        return DataError(f"{place}: longer than 1 MiB, so it is not a row; delete it")
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
