"""The first lines of a text, decoded, split into fields, and classified as rows, comments and other lines.

A number is what Python's ``float`` accepts, without underscores. A line is a row if at least half of its fields are numbers
and it has as many fields as the table has columns.
"""

from __future__ import annotations

import csv
import math
import re
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Literal

from sigmatau.errors import DataError

COMMENTS = ("#", "%", "//")

DELIMITERS: dict[str | None, str] = {",": "comma", ";": "semicolon", "\t": "tab", None: "space"}
LINES = 2000  # number of lines that are tested
_LONG_LINE = 64  # a line with more numbers than this is not one row of samples

# Each pattern matches a text in only one way, so that failing lines take linear time.
_NUMBER = re.compile(r"[+-]?(?:\d++(?:\.\d*+)?|\.\d++)(?:[eE][+-]?\d++)?")
# Fast path: removing these characters leaves nothing of most rows.
_NUMERIC = {
    delimiter: str.maketrans("", "", f"0123456789+-.eE{marks}")
    for delimiter, marks in ((",", ","), (";", ";"), ("\t", "\t"), (None, " \t"))
}
_MISSING = re.compile(r"[+-]?(?:nan|inf|infinity)|na|n/a|null|none|nil|", re.IGNORECASE)
EXCHANGED = str.maketrans(",.", ".,")
# time stamp written by the serial monitor of the Arduino IDE
ARROW = re.compile(r"\s*(\d{1,2}:\d\d:\d\d(?:[.,:]\d{1,9})?)\s*->")


@dataclass(slots=True)
class Line:
    """A line of the head, with its fields by delimiter."""

    number: int  # counted from 1
    text: str
    comment: bool
    clock: str = ""  # the time before an arrow, which is not part of the text
    fields: dict[str | None, list[str]] = field(default_factory=dict)
    # numbers of a purely numeric row, by delimiter
    plain: dict[str | None, list[float] | Literal[False]] = field(default_factory=dict)

    def split(self, delimiter: str | None) -> list[str]:
        if delimiter not in self.fields:
            self.fields[delimiter] = bare_fields(self.text, delimiter)
        return self.fields[delimiter]

    def numbers_only(self, delimiter: str | None = ",") -> list[float] | Literal[False]:
        """The numbers of a row that consists only of numbers and delimiters, as most rows do; False for any other line."""
        if delimiter not in self.plain:
            self.plain[delimiter] = False
            if not self.text.translate(_NUMERIC[delimiter]):
                with suppress(ValueError):
                    self.plain[delimiter] = list(map(float, self.text.split(delimiter)))
        return self.plain[delimiter]

    def exchange(self) -> None:
        """Exchange commas and points, for decimal commas."""
        self.text = self.text.translate(EXCHANGED)
        self.fields.clear()
        self.plain.clear()

    def is_data(self, delimiter: str | None, columns: int) -> bool:
        """Whether the line is a row with this number of columns, see `is_row`."""
        if numbers := self.numbers_only(delimiter):
            return len(numbers) == columns
        return is_row(self.split(delimiter), columns)

    def values(self, delimiter: str | None) -> list[float]:
        """The fields as numbers; NaN for a field that is not a number."""
        if numbers := self.numbers_only(delimiter):
            return numbers
        return [float(f) if is_number(f) else math.nan for f in self.split(delimiter)]

    def numbers(self, delimiter: str | None) -> tuple[int, int, bool]:
        """Number of fields, number of numeric fields, and whether the last field is empty; 0 fields if the line is not a
        row.
        """
        if numbers := self.numbers_only():
            n = len(numbers)
            return (n, n, False) if n == 1 or delimiter == "," else (0, 0, False)
        if numbers := self.numbers_only(delimiter):
            return len(numbers), len(numbers), False
        single = '"' not in self.text and len(self.text.split(delimiter, 1)) < 2
        if single and ("," in self.text or ";" in self.text or len(self.text.split(None, 1)) > 1):
            return 0, 0, False  # the only field is not a number, because it contains another delimiter
        parts = self.split(delimiter)
        if not is_row(parts):
            return 0, 0, False
        return len(parts), sum(map(is_number, parts)), not parts[-1]


class NoRowsError(DataError):
    """The first lines of a text contain no row of numbers; later lines may.

    Attributes
    ----------
    last : int
        Number of the last line that was searched.
    """

    def __init__(self, message: str, *, last: int) -> None:
        super().__init__(message)
        self.last = last


def decode(data: bytes, *, whole: bool) -> tuple[str, str]:
    """Decode the whole lines at the beginning of a file; return the text and a note on its encoding. Raises `DataError`."""
    if not whole:
        end = data.rfind(b"\n") + 1
        if not end:
            ends = "; its lines end in CR alone: save it with LF or CR LF" if b"\r" in data else ""
            raise long_line(data, "the first line", ends)
        if b"\n" not in data[:end].strip() and len(data) - end > end:
            raise long_line(data[end:], "the second line")
        data = data[:end]
    data = data.removeprefix(b"\xef\xbb\xbf")
    if b"\n" not in data and b"\r" in data.strip():
        raise DataError("its lines end in CR alone, as on old Macs; save it with LF or CR LF")
    try:
        return data.decode("utf-8"), ""
    except UnicodeDecodeError:
        # Windows logs write the degree sign in this encoding.
        return data.decode("cp1252", errors="replace"), ", read as Windows-1252"


def long_line(data: bytes, which: str, ends: str = "") -> DataError:
    """The error for a line that does not end within `data`."""
    return numbers_in_line(data, which) or DataError(
        f"{which} is longer than {kibibytes(data)} KiB, so this is not a text table{ends}"
    )


def numbers_in_line(data: bytes, which: str) -> DataError | None:
    """Build the error for an overlong line of nothing but numbers, which is not one sample; None for any other line."""
    begun = data[:1000].decode("latin-1").strip()
    fields = re.split(r"[,;\s]+", begun)[:-1]
    if len(fields) <= _LONG_LINE or not all(map(is_number, fields)):
        return None
    marks = "".join(sorted({c for c in begun if c in ",; \t"}, reverse=True)).replace("\t", "\\t")
    skipped = "tail -n +2 LOG | tr" if which == "the second line" else "tr"
    command = f"{skipped} -s '{marks}' '\\n'{'' if skipped != 'tr' else ' < LOG'} | paste -d, - - - > rows.csv"
    return DataError(
        f"{which} is longer than {kibibytes(data)} KiB, all of it numbers. Write each sample on its own line;"
        f" for samples of 3 numbers: {command}"
    )


def kibibytes(data: bytes) -> int:
    """The size of data in KiB, rounded down."""
    return len(data) // 1024


def split_lines(text: str, skip: int) -> list[Line]:
    """Split off the lines of a text that are not blank, at most `LINES` of them, numbered from `skip` + 1."""
    lines = []
    for number, raw in enumerate(text.split("\n")[:LINES], skip + 1):
        # As in the reader of the rows: leading tabs may delimit empty fields, so only spaces are removed.
        line = raw.strip(" \r") if "\t" in raw else raw.strip()
        if line:
            lines.append(Line(number, line, line.lstrip().startswith(COMMENTS) or _is_remark(line)))
    return lines


def _is_remark(line: str) -> bool:
    """Whether a semicolon before a line with commas makes it a comment (Gulf Coast Data Concepts)."""
    return line.startswith(";") and "," in line and ";" not in line[1:]


def without_arrows(lines: list[Line]) -> tuple[list[Line], bool]:
    """Remove the time and arrow that a serial monitor writes before each line; return the lines, and whether arrows were
    removed.
    """
    arrows = [ARROW.match(line.text) if "->" in line.text else None for line in lines]
    if 2 * sum(match is not None for match in arrows) < max(len(lines), 1):
        return lines, False
    rest = []
    for line, match in zip(lines, arrows, strict=True):
        text = line.text[match.end() :].strip() if match else line.text
        if text:
            rest.append(Line(line.number, text, text.startswith(COMMENTS), clock=match[1] if match else ""))
    return rest, True


def bare_fields(text: str, delimiter: str | None) -> list[str]:
    """Split a line into fields, without the spaces and quotes around them."""
    if delimiter is None:
        fields = text.split()
    elif '"' in text:
        try:
            fields = next(csv.reader([text], delimiter=delimiter, skipinitialspace=True), [])
        except csv.Error:  # a carriage return within, for instance
            fields = text.split(delimiter)
    else:
        fields = text.split(delimiter)
    return [bare(f) for f in fields]


def bare(text: str) -> str:
    """Remove the spaces and quotes around a field."""
    text = text.strip()
    return text[1:-1].strip() if len(text) >= 2 and text[0] == text[-1] == '"' else text


def is_number(text: str) -> bool:
    """Whether a field is a decimal number."""
    return _NUMBER.fullmatch(text) is not None


def _is_missing(text: str) -> bool:
    return _MISSING.fullmatch(text) is not None


def is_row(fields: list[str], columns: int | None = None) -> bool:
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
