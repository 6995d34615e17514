"""The layout of a text table, detected from its beginning: delimiter, first row, names, units.

A number is what Python's ``float`` accepts, without underscores. A line is a row if at least half of its fields are numbers
and it has as many fields as the table has columns. Decimal commas are read if the delimiter is another character and no
number has a point. An ambiguous table (decimal commas between commas, two delimiters) is refused, with advice.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Literal

from sigmatau.errors import DataError
from sigmatau.io.read.formats.preamble import (
    SAMPLE_TIME,
    StatedRate,
    counts_per_second,
    find_rate,
    units_of_mt_manager,
)
from sigmatau.io.read.names import recognise, unit_of
from sigmatau.io.read.table import FORMATS, Column

COMMENTS = ("#", "%", "//")

_DELIMITERS: dict[str | None, str] = {",": "comma", ";": "semicolon", "\t": "tab", None: "space"}
LINES = 2000  # number of lines that are tested
_LONG_LINE = 64  # numbers on one line from which on it is said to be no row of samples
_MOST_LYING = 16  # rows of a table that has a row for each channel
_LYING_SAMPLES = 512  # columns that such a table has at least; no sensor's log has as many
_HEADERS = 20  # lines above the samples that may have numbers
_LEAST_SAMPLES = 100  # rows that follow one with other numbers
_FAR = 10  # times the range of a column that a number is outside of it, if it is not one of a sample
_HEAD_OF_RESULT = 100  # characters of a JSON of sigmatau within which its version is

# Each pattern matches a text in only one way, so that failing lines take linear time.
_NUMBER = re.compile(r"[+-]?(?:\d++(?:\.\d*+)?|\.\d++)(?:[eE][+-]?\d++)?")
_NUMERIC = str.maketrans("", "", "0123456789+-.eE,")  # fast path: what of most rows leaves nothing
_MISSING = re.compile(r"[+-]?(?:nan|inf|infinity)|na|n/a|null|none|nil|", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")
_EXCHANGED = str.maketrans(",.", ".,")
_SEPARATOR = re.compile(r'"?sep=.{1,3}$', re.IGNORECASE)  # for Excel
_ARROW = re.compile(r"\s*(\d{1,2}:\d\d:\d\d(?:[.,:]\d{1,9})?)\s*->")  # of the serial monitor of the Arduino IDE
_UNIT_GAP = re.compile(r"(?<!\s)\s++(?=[\[(])")
_IN_BRACKETS = re.compile(r"[\[(][^\])]{0,80}[\])]")


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """The layout of a text table."""

    delimiter: str | None  # One character; None for runs of spaces and tabs
    skip_lines: int  # Lines before the data
    columns: tuple[Column, ...]
    notes: tuple[str, ...]  # Properties of the table, for the provenance of the record
    decimal_comma: bool = False  # Whether 0,5 is one half
    arrow: bool = False  # Whether ``15:00:00.010 ->`` stands before each row; that clock is the last column
    rate: StatedRate | None = None  # What a line above the table states
    last: int = 0  # Number of the last line that was searched
    counts_per_second: int | None = (
        None  # Of the column SampleTimeFine, if there is one and the stated rate confirms it
    )

    def fits(self, line: str) -> bool:
        """Whether a line has as many fields as a row of this layout, or is blank."""
        text = line.translate(_EXCHANGED) if self.decimal_comma else line
        columns = len(self.columns) - self.arrow
        text = _ARROW.sub("", text) if self.arrow else text
        fields = _Line(0, text.strip() if self.delimiter != "\t" else text, comment=False).split(self.delimiter)
        return not text.strip() or len(fields) == columns or (len(fields) == columns + 1 and not fields[-1])

    def of_same_rows(self, layout: Layout) -> bool:
        """Whether another layout has the same delimiter and as many columns."""
        return (self.delimiter, len(self.columns)) == (layout.delimiter, len(layout.columns))


@dataclass(slots=True)
class _Line:
    """A line of the head, with its fields by delimiter."""

    number: int  # counted from 1
    text: str
    comment: bool
    clock: str = ""  # the time before an arrow, which is not part of the text
    fields: dict[str | None, list[str]] = field(default_factory=dict)
    plain: list[float] | Literal[False] | None = None  # of a row of numbers with commas between; None if not known yet

    def split(self, delimiter: str | None) -> list[str]:
        if delimiter not in self.fields:
            self.fields[delimiter] = bare_fields(self.text, delimiter)
        return self.fields[delimiter]

    def numbers_only(self) -> list[float] | Literal[False]:
        """The numbers of a row of numbers with commas between, as most are; False for any other line."""
        if self.plain is None:
            self.plain = False
            if not self.text.translate(_NUMERIC):
                with suppress(ValueError):
                    self.plain = list(map(float, self.text.split(",")))
        return self.plain

    def exchange(self) -> None:
        """Take commas for points, and points for commas."""
        self.text = self.text.translate(_EXCHANGED)
        self.fields.clear()
        self.plain = None

    def is_data(self, delimiter: str | None, columns: int) -> bool:
        """Whether the line is a row of so many columns, see `_is_data`."""
        if delimiter == "," and (numbers := self.numbers_only()):
            return len(numbers) == columns
        return _is_data(self.split(delimiter), columns)

    def values(self, delimiter: str | None) -> list[float]:
        """The fields as numbers; NaN for others."""
        if delimiter == "," and (numbers := self.numbers_only()):
            return numbers
        return [float(f) if is_number(f) else math.nan for f in self.split(delimiter)]

    def numbers(self, delimiter: str | None) -> tuple[int, int, bool]:
        """Number of fields, number of numeric fields, and whether the last is empty; 0 fields if the line is not a row."""
        if numbers := self.numbers_only():
            n = len(numbers)
            return (n, n, False) if n == 1 or delimiter == "," else (0, 0, False)
        if "," in self.text and '"' not in self.text and len(self.text.split(delimiter, 1)) < 2:
            return 0, 0, False  # one field that is not a number
        parts = self.split(delimiter)
        if not _is_data(parts):
            return 0, 0, False
        return len(parts), sum(map(is_number, parts)), not parts[-1]


class NoRowsError(DataError):
    """No line of numbers among the first lines of a text, which may have them further on.

    Attributes
    ----------
    last : int
        Number of the last line that was searched.
    """

    def __init__(self, message: str, *, last: int) -> None:
        super().__init__(message)
        self.last = last


def find_layout(data: bytes, *, whole: bool, encoding: str = "", skip: int = 0) -> Layout:
    """The layout of the table that begins with `data`. `data`: beginning of the file after the skipped lines,
    decompressed; `whole`: true if the file ends there; else the last line is ignored; `encoding`: encoding of the file,
    if it differs from that of `data`; for the notes; `skip`: lines before `data`.
    """
    text, read_as = decode(data, whole=whole)
    written = f", {encoding}" if encoding else read_as
    lines, arrow = _without_arrows(_lines(text, skip))
    rows = [line for line in lines if not line.comment]
    if not rows:
        what = "comments and blank lines" if lines else "blank lines"
        if whole and text.count("\n") < LINES:
            raise DataError(f"has only {what}")
        raise NoRowsError(
            f"has only {what} in its first {_kibibytes(data)} KiB", last=skip + min(text.count("\n"), LINES)
        )
    if rows[0].text.startswith("{") and '"sigmatau":' in text[:_HEAD_OF_RESULT]:
        raise DataError("is a result of sigmatau, not a log; sigmatau export, compare, plan and predict read it")
    if rows[0].text.startswith(("{", "<")):
        raise DataError(f"is JSON or XML, not a format that is read: {FORMATS}")
    _refuse_sentences(rows)
    if whole and len(rows) == 1 and len(rows[0].text) > 1000:
        error = _long_line(rows[0].text.encode(), "the only line")
        if "all of it numbers" in error.message:
            raise error
    _refuse_lying(rows)
    decimal_comma = _exchange_decimal_commas(rows)
    delimiter, columns = _delimiter(rows, lines)
    data_rows = [line for line in rows if line.is_data(delimiter, columns)]
    first, skipped = _first_sample(rows, data_rows, delimiter, columns)
    if delimiter == ",":
        _refuse_split_numbers(rows, first, columns)
    before = [line for line in lines if line.number < first.number and line not in skipped]
    _refuse_other_delimiters(first, delimiter)
    names, units, header, layout_notes = _names(before, delimiter, columns)
    _refuse_cut_rows(before, header, first, delimiter, columns)

    kind = f"{_DELIMITERS[delimiter]}-separated" if columns > 1 else "one column of"
    commas = " with decimal commas" if decimal_comma else ""
    notes = [
        f"{kind} text{commas}, {'no header' if header is None else f'header on line {header}'}{written}",
        *layout_notes,
        *_note_above(rows, header),
        *(("time of day before -> on each line, read as column clock",) if arrow else ()),
        *(f"line {line.number} skipped: its numbers are not those of a sample" for line in skipped),
    ]
    above = [(line.number, line.text) for line in before]
    rate = find_rate(above)
    units_by_manual = units_of_mt_manager(above, names, units)
    if units_by_manual != tuple(units):
        notes.append("units of acceleration and angular rate by the manual of MT Manager")
    fine = [k for k, name in enumerate(names) if name.lower() == SAMPLE_TIME]
    counts = [row.values(delimiter)[fine[0]] for row in data_rows] if fine and rate else []
    return Layout(
        delimiter=delimiter,
        rate=rate,
        last=lines[-1].number,
        counts_per_second=counts_per_second(counts, rate.rate) if rate else None,
        skip_lines=first.number - 1,
        columns=tuple(
            Column(name=n, unit=u, first=f)
            for n, u, f in zip(names, units_by_manual, first.split(delimiter)[:columns], strict=True)
        )
        + ((Column(name="clock", first=first.clock),) if arrow else ()),
        notes=tuple(notes),
        decimal_comma=decimal_comma,
        arrow=arrow,
    )


def _note_above(rows: list[_Line], header: int | None) -> list[str]:
    """A note of the lines of text above the header; nothing if there are none."""
    above = [row for row in rows if header is not None and row.number < header and not _SEPARATOR.match(row.text)]
    if not above:
        return []
    count = f"{len(above)} lines" if len(above) > 1 else "1 line"
    return [f"{count} of text above the header skipped, from line {above[0].number}"]


def _refuse_lying(rows: list[_Line]) -> None:
    """Raise `DataError` for a table with a row of numbers for each channel, and a column for each sample."""
    if len(rows) > _MOST_LYING:
        return
    delimiter = max(_DELIMITERS, key=lambda d: len(rows[-1].split(d)))
    widths = {len(row.split(delimiter)) for row in rows}
    if len(widths) == 1 and (samples := widths.pop()) > max(_LYING_SAMPLES, 10 * len(rows)):
        options = f", delimiter={delimiter!r}" if delimiter else ""
        if not is_number(rows[0].split(delimiter)[0]):
            options += f", usecols=range(1, {samples})"
        raise DataError(
            f"has {len(rows)} rows of {samples} fields, so a row is a channel; turn the table with python -c"
            f" \"import numpy as n; n.savetxt('rows.csv', n.loadtxt('LOG'{options}).T, delimiter=',')\""
        )


def _first_sample(
    rows: list[_Line], data: list[_Line], delimiter: str | None, columns: int
) -> tuple[_Line, list[_Line]]:
    """The first row of samples, and the rows of numbers before it: above the header, or with other numbers than all rows
    that follow, as scales or a position.
    """
    numbers = {line.number for line in data}
    latest = data[min(_HEADERS, len(data) - 1)].number  # a later header is one among the samples
    words = (line for line in rows if line.number <= latest and line.number not in numbers)
    headers = [line for line in words if names_something(_header_fields(line, delimiter, columns))]
    above = [line for line in data if headers and line.number < headers[-1].number]
    rest = data[len(above) :] or data
    above = above if data[len(above) :] else []
    while len(above) < _HEADERS and len(rest) > _LEAST_SAMPLES and _is_odd(rest, delimiter, columns):
        above, rest = [*above, rest[0]], rest[1:]
    return rest[0], above


def _is_odd(rows: list[_Line], delimiter: str | None, columns: int) -> bool:
    """Whether most numbers of the first row are far outside those of all others, or broken among whole ones."""
    table = [row.values(delimiter)[:columns] for row in rows]
    first, others = table[0], list(zip(*table[1:], strict=True))
    if not any(first):
        return False  # a row without a sample
    odd = 0
    for value, column in zip(first, others, strict=True):
        known = [x for x in column if math.isfinite(x)]
        if not known or not math.isfinite(value):
            continue
        low, high = min(known), max(known)
        room = _FAR * (high - low)
        whole = all(x.is_integer() for x in known)
        odd += not low - room <= value <= high + room or (whole and not value.is_integer())
    return 2 * odd > columns


def header_fields(text: str, layout: Layout) -> list[str]:
    """The names in a comment line among the rows; nothing if it is not a header."""
    columns = len(layout.columns) - layout.arrow
    fields = _header_fields(_Line(0, text, comment=True), layout.delimiter, columns)
    return fields if names_something(fields) else []


def decode(data: bytes, *, whole: bool) -> tuple[str, str]:
    """The whole lines of the beginning of a file as text, and a note on its encoding; raises `DataError`."""
    if not whole:
        end = data.rfind(b"\n") + 1
        if not end:
            ends = "; its lines end in CR alone: save it with LF or CR LF" if b"\r" in data else ""
            raise _long_line(data, "the first line", ends)
        if b"\n" not in data[:end].strip() and len(data) - end > end:
            raise _long_line(data[end:], "the second line")
        data = data[:end]
    data = data.removeprefix(b"\xef\xbb\xbf")
    if b"\n" not in data and b"\r" in data.strip():
        raise DataError("its lines end in CR alone, as on old Macs; save it with LF or CR LF")
    try:
        return data.decode("utf-8"), ""
    except UnicodeDecodeError:
        # Windows logs write the degree sign in this encoding.
        return data.decode("cp1252", errors="replace"), ", read as Windows-1252"


def _long_line(data: bytes, which: str, ends: str = "") -> DataError:
    begun = data[:1000].decode("latin-1").strip()
    fields = re.split(r"[,;\s]+", begun)[:-1]
    if len(fields) > _LONG_LINE and all(map(is_number, fields)):
        marks = "".join(sorted({c for c in begun if c in ",; \t"}, reverse=True)).replace("\t", "\\t")
        skipped = "tail -n +2 LOG | tr" if which == "the second line" else "tr"
        command = f"{skipped} -s '{marks}' '\\n'{'' if skipped != 'tr' else ' < LOG'} | paste -d, - - - > rows.csv"
        return DataError(
            f"{which} is longer than {_kibibytes(data)} KiB, all of it numbers, and a sample needs a line of its own;"
            f" for samples of 3 numbers: {command}"
        )
    return DataError(f"{which} is longer than {_kibibytes(data)} KiB, so this is not a text table{ends}")


def _kibibytes(data: bytes) -> int:
    return len(data) // 1024


def _lines(text: str, skip: int) -> list[_Line]:
    lines = []
    for number, raw in enumerate(text.split("\n")[:LINES], skip + 1):
        # As in the reader of the rows: tabs may be empty fields, so only blank lines are skipped.
        line = raw.strip(" \r") if "\t" in raw else raw.strip()
        if line:
            lines.append(_Line(number, line, line.lstrip().startswith(COMMENTS)))
    return lines


def _without_arrows(lines: list[_Line]) -> tuple[list[_Line], bool]:
    """The lines without the time and the arrow before each, as a serial monitor writes them; and whether they have them."""
    found = [_ARROW.match(line.text) if "->" in line.text else None for line in lines]
    if 2 * sum(match is not None for match in found) < max(len(lines), 1):
        return lines, False
    rest = []
    for line, match in zip(lines, found, strict=True):
        text = line.text[match.end() :].strip() if match else line.text
        if text:
            rest.append(_Line(line.number, text, text.startswith(COMMENTS), clock=match[1] if match else ""))
    return rest, True


def bare_fields(text: str, delimiter: str | None) -> list[str]:
    """The fields of a line, without spaces and quotes around them."""
    if delimiter is None:
        fields = text.split()
    elif '"' in text:
        try:
            fields = next(csv.reader([text], delimiter=delimiter, skipinitialspace=True), [])
        except csv.Error:  # a carriage return within, for instance
            fields = text.split(delimiter)
    else:
        fields = text.split(delimiter)
    return [_bare(f) for f in fields]


def _bare(text: str) -> str:
    text = text.strip()
    return text[1:-1].strip() if len(text) >= 2 and text[0] == text[-1] == '"' else text


def is_number(text: str) -> bool:
    """Whether a field is a number in figures."""
    return _NUMBER.fullmatch(text) is not None


def _is_missing(text: str) -> bool:
    return _MISSING.fullmatch(text) is not None


def _is_data(fields: list[str], columns: int | None = None) -> bool:
    """Whether a line with these fields is a row: at least half of them are numbers or mark missing numbers."""
    if columns is not None and len(fields) == columns + 1 and not fields[-1]:
        fields = fields[:-1]
    if columns is not None and len(fields) != columns:
        return False
    numbers = sum(map(is_number, fields))
    if 2 * numbers >= max(len(fields), 1):
        return True  # fast path: most rows
    missing = sum(map(_is_missing, fields))
    words = sum(bool(f) and _is_missing(f) for f in fields)
    return (numbers > 0 or words > 0) and 2 * (numbers + missing) >= len(fields)


def _delimiter(rows: list[_Line], with_comments: list[_Line]) -> tuple[str | None, int]:
    """The delimiter and the number of columns that give the most numbers in rows."""
    best: tuple[int, float] = (0, 0.0)
    choice: tuple[str | None, int] | None = None
    for delimiter in _DELIMITERS:
        numbers: dict[int, int] = {}
        fields: dict[int, int] = {}
        trailing: dict[int, int] = {}
        lines: dict[int, int] = {}
        for row in rows:
            n, found, open_end = row.numbers(delimiter)
            if not n:
                continue
            lines[n] = lines.get(n, 0) + 1
            numbers[n] = numbers.get(n, 0) + found
            fields[n] = fields.get(n, 0) + n
            trailing[n] = trailing.get(n, 0) + (n > 1 and open_end)
        for n, count in numbers.items():
            score = (count, count / fields[n])
            if score > best:
                best = score
                # A delimiter at the end of every line does not add a column that has no name.
                bare = trailing[n] == lines[n] and not _names_last(rows[:_HEADERS], delimiter, n)
                choice = (delimiter, n - 1 if bare else n)
    if choice is None:
        line = rows[0]
        raise NoRowsError(
            f"has no line of numbers in its first {'line' if len(rows) == 1 else f'{len(rows)} lines'}"
            f" (line {line.number} begins {line.text[:40]!r});"
            " a table with columns of numbers is needed",
            last=with_comments[-1].number,
        )
    delimiter, columns = choice
    if delimiter is None and (named := _named_tabs(rows, with_comments, columns)):
        return "\t", named
    return (None if columns == 1 and all(len(r.split(None)) == 1 for r in rows[-5:]) else delimiter), columns


def _named_tabs(rows: list[_Line], lines: list[_Line], filled: int) -> int | None:
    """The number of columns between tabs, if a header names more of them than the rows fill; None if not."""
    row = next((r for r in rows if len(r.split(None)) == filled and _is_data(r.split(None))), None)
    if row is None or "\t\t" not in f"\t{row.text}\t":
        return None
    columns = len(row.split("\t"))
    if columns <= filled or sum(map(bool, row.split("\t"))) != filled or not row.is_data("\t", columns):
        return None
    before = [line for line in lines if line.number < row.number]
    for width in (columns, columns - 1):  # a tab at the end of the rows
        for line in before[-3:]:
            fields = _header_fields(line, "\t", width)
            if width > filled and fields and all(fields) and len(line.text.split("\t")) >= width:
                return width
    return None


def _names_last(rows: list[_Line], delimiter: str | None, columns: int) -> bool:
    """Whether a line names the last of so many columns, whose samples may begin later than those of the others."""
    found = (row.split(delimiter) for row in rows)
    return any(len(f) == columns and f[-1].strip() and not _is_data(f, columns) for f in found)


def _refuse_sentences(rows: list[_Line]) -> None:
    sentences = [row for row in rows if row.text.startswith("$") and re.match(r"\$[A-Z]{3,},", row.text)]
    if 2 * len(sentences) > len(rows):
        name = sentences[0].text.split(",")[0]
        raise DataError(
            f", line {sentences[0].number}: sentences like {name} (NMEA style, with checksums) are not read yet;"
            " cut the columns of numbers out, e.g. by cut -d, -f…"
        )


def _exchange_decimal_commas(rows: list[_Line]) -> bool:
    """Whether numbers have decimal commas; then commas and points of those rows are exchanged, as in the reader."""
    for delimiter in (";", "\t", None):
        found = next((row for row in rows if _has_decimal_commas(row, delimiter)), None)
        if found is None:
            continue
        for row in rows:
            point = next((f for f in row.split(delimiter) if "." in f and is_number(f)), None)
            if point is not None:
                raise DataError(
                    f", line {found.number}: numbers with a decimal comma ({found.text[:40]!r}), though line {row.number}"
                    f" has {point!r} with a point; save all with points"
                )
        for row in rows:
            exchanged = row.text.translate(_EXCHANGED)
            if row.number == found.number or _is_data([_bare(f) for f in exchanged.split(delimiter)]):
                row.exchange()
        return True
    return False


def _has_decimal_commas(row: _Line, delimiter: str | None) -> bool:
    if "," not in row.text or len(row.text.split(delimiter, 1)) < 2:
        return False  # fast path: most rows
    fields = [f for f in row.split(delimiter) if f]
    commas = sum(_DECIMAL_COMMA.fullmatch(f) is not None for f in fields)
    numbers = commas + sum(map(is_number, fields))
    # Spaces also separate dates from times, and the words of a comment.
    return commas > 0 and (numbers == len(fields) if delimiter is None else 2 * numbers >= len(fields))


def _refuse_split_numbers(rows: list[_Line], first: _Line, columns: int) -> None:
    """Raise `DataError` for decimal commas in a comma-separated table, where each number is split into two integers."""
    if columns % 2:
        return
    data = []
    for row in rows:
        fields = row.split(",")
        if _is_data(fields, columns):
            if not all(f.lstrip("+-").isdigit() for f in fields[:columns]):
                return
            data.append(fields)
    padded = any(len(f) > 1 and f[0] == "0" for fields in data for f in fields[1:columns:2])
    header = next((row for row in reversed(rows) if row.number < first.number), None)
    halved = header is not None and 2 * max(len(header.split(d)) for d in _DELIMITERS) == columns
    if padded or halved:
        raise _decimal_comma(first)


def _decimal_comma(row: _Line) -> DataError:
    return DataError(
        f", line {row.number}: numbers with a decimal comma ({row.text[:40]!r}) cannot be distinguished from two numbers"
        " with a comma between them; save them with a decimal point, or with semicolons between them"
    )


def _refuse_other_delimiters(first: _Line, delimiter: str | None) -> None:
    for text in first.split(delimiter):
        if delimiter is not None and delimiter in text:
            continue  # within quotes
        parts = [p for p in re.split(r"[;,\s|]+", text) if p]
        if len(parts) > 1 and all(map(is_number, parts)):
            raise DataError(
                f", line {first.number}: {text[:40]!r} between two {_DELIMITERS[delimiter]}s has another delimiter;"
                " save the table with one delimiter"
            )


def _refuse_cut_rows(
    before: list[_Line], header: int | None, first: _Line, delimiter: str | None, columns: int
) -> None:
    for line in before:
        fields = line.split(delimiter)
        if line.comment or (header is not None and line.number <= header):
            continue
        if all(map(is_number, fields)):
            raise DataError(
                f", line {line.number}: {len(fields)} field{'s' if len(fields) != 1 else ''}, but {columns} on line"
                f" {first.number}; correct or delete the line"
            )


def _names(
    before: list[_Line], delimiter: str | None, columns: int
) -> tuple[list[str], list[str | None], int | None, list[str]]:
    """Names, units of a unit row, number of the header line, and notes."""
    blank: list[str] = [""] * columns
    nothing: list[str | None] = [None] * columns
    marked = [line for line in before if any(c.isalnum() for c in line.text)]  # without rows of dashes
    fitting = [(line, fields) for line in marked if (fields := _header_fields(line, delimiter, columns))]
    plain = [line for line in marked if not line.comment]
    if any(line in plain for line, _ in fitting):  # then the header is not a comment
        fitting = [(line, fields) for line, fields in fitting if line in plain[-3:]]
    if not fitting or (plain and not fitting[-1][0].comment and fitting[-1][0] is not plain[-1]):
        notes = [f"line {plain[-1].number} skipped: it does not name the {columns} columns"] if plain else []
        return blank, nothing, None, notes
    line, fields = fitting[-1]
    units, notes = nothing, []
    if len(fitting) > 1 and _is_unit_row(fields):
        units, notes = [f.strip("[](){} ") or None for f in fields], [f"units on line {line.number}"]
        fitting = fitting[:-1]
    if len(fitting) > 1 and _is_axis_row(fitting[-1][1]):
        (above, stems), (line, axes) = fitting[-2:]
        return _with_axes(stems, axes), units, above.number, [f"axes on line {line.number}", *notes]
    if notes:
        return fitting[-1][1], units, fitting[-1][0].number, notes
    # A comment, or a row of unknown units, may have as many words as the table has columns.
    line, fields = next((c for c in reversed(fitting) if names_something(c[1])), (line, fields))
    in_header = any(unit_of(Column(name=f))[1] for f in fields)
    return fields, nothing, line.number, ["units in the header"] if in_header else []


def names_something(fields: Sequence[str]) -> bool:
    """Whether some of these words are names of channels."""
    return any(recognise([Column(name=f) for f in fields]))


def _header_fields(line: _Line, delimiter: str | None, columns: int) -> list[str]:
    """The names in a line, if it has one for each column and no numbers; else nothing."""
    text = line.text
    if line.comment:
        text = re.sub(r"^\s*(?:#+|%+(?!time\b)|//+)\s*", "", text)  # %time is a name, of rostopic
        if columns == 1 and len(_IN_BRACKETS.sub("", text).split()) != 1:
            return []  # a comment
    if not text:
        return []
    if columns == 1:
        options = [[_bare(text.rstrip(",;\t "))]]
    else:
        options = [bare_fields(t, d) for d in (delimiter, *_DELIMITERS) for t in (text, _UNIT_GAP.sub("", text))]
    for fields in options:
        if len(fields) == columns + 1 and not fields[-1]:
            fields = fields[:-1]
        if len(fields) == columns and any(fields) and not any(map(is_number, fields)):
            return fields
    return []


def _is_axis_row(fields: list[str]) -> bool:
    """Whether a line has the axes of the columns that the line above it names."""
    axes = [f.lower() for f in fields if f.lower() in ("x", "y", "z")]
    others = [f for f in fields if f and f.lower() not in ("x", "y", "z")]
    return len(axes) >= 3 and len(others) <= 1


def _with_axes(stems: list[str], axes: list[str]) -> list[str]:
    """Names with their axes; a name may stand above the first axis only."""
    names, last = [], ""
    for stem, axis in zip(stems, axes, strict=True):
        last = stem or last
        names.append(f"{last} {axis}" if axis.lower() in ("x", "y", "z") else stem or axis)
    return names


def _is_unit_row(fields: list[str]) -> bool:
    named = [f.strip("[](){} ") for f in fields if f.strip("[](){} -")]
    known = sum(unit_of(Column(name="x", unit=f))[1] is not None for f in named)
    return known > 0 and 2 * known >= len(named)
