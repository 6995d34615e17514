"""Text tables whose rows are of several kinds: messages of several sensors, or instances of one sensor, in one table.

A column shows the kind of each row: a word (``Gyro``, ``Accel``; ``imu_left``, ``imu_right``) or a small whole number
(instance 0, 1). Rows of different kinds may have different numbers of fields. The kinds are detected from the beginning
of the file. A flag, a counter or a coarse signal also has few values. It counts as a kind only under the conditions of
`find_kinds`.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sigmatau.frozen import frozen
from sigmatau.io.read.formats.text_delimiter import names_something
from sigmatau.io.read.formats.text_lines import COMMENTS, bare_fields, is_number
from sigmatau.io.read.instances import cycles_with_rows, find_sensor, has_device_name, shows_kinds
from sigmatau.io.read.table import RowKind

_LINES = 2000  # number of lines of the head that are tested
_FIRST_LINES = 64  # lines in which a column of numbers must show two kinds to be tested further
_FIRST_COLUMNS = 24  # number of columns that are searched for a kind
_HEADERS = 20  # lines above the rows that may be a header
_MAX_KINDS = 16  # largest number of distinct texts in a column that shows kinds
_MIN_ROWS = 3  # rows of a kind in the head; rarer texts are not kinds
_RARE = 0.03  # share of the rows that may have rarer texts
# share of the rows of a kind that must have the same number of fields: the last row may be truncated
_CONSTANT_WIDTH = 0.98
_MIN_NUMBERS = 2  # smallest number of numbers in a row besides its kind
_WHOLE = re.compile(r"\d{1,4}(?:\.0*)?")


@frozen
class Kinds:
    """The kinds of the rows of a text."""

    column: int  # place of the column, counted from 0
    name: str  # name of the column; empty if it has none
    labels: tuple[str, ...]  # distinct texts of the column, in the order of the file
    delimiter: str | None
    are_late: bool = False  # Whether the rows of some kinds begin below the head

    def find_kind(self, label: str) -> RowKind:
        """The kind of the rows with this text."""
        return RowKind(column=self.column, name=self.name, label=label, labels=self.labels)


def find_kinds(text: str, *, without: int | None = None) -> Kinds | None:
    """Find the kinds of the rows of a text from its beginning; None if all rows are of one kind and no word names a sensor.

    Any column except `without` may show the kinds. A column of words shows the kind if rows with different words have
    different numbers of fields, or if a word names a gyro or an accelerometer. Any other column of few words or
    integers must cycle with the rows, or come in blocks of rows and have the name of a device. If it cycles, it must
    have the name of a device (``I``, ``imu``, ``sensor_id``), or divide the rows into groups whose means differ or, for
    words, whose scatters differ. If it has the name of an instance (``frame``, ``id``), words are enough, and numbers
    need rows that differ. If the user states that all rows are of a single sensor, only words that name a gyro or an
    accelerometer still count.
    """
    lines = _row_lines(text.split("\n", _FIRST_LINES + _HEADERS)[:-1]) or _row_lines(text.split("\n", _LINES)[:_LINES])
    delimiter = _delimiter(lines[:_FIRST_LINES])
    if delimiter is _NO_DELIMITER:
        return None
    split = [bare_fields(line, delimiter) for line in lines[:_FIRST_LINES]]
    first = [fields for fields in split if _is_row(fields)]
    width = min(map(len, first), default=0)
    names = _names(split, text, delimiter)
    columns = [c for c in range(min(width, _FIRST_COLUMNS)) if c != without and _may_show_kinds(first, c, names)]
    if not columns:
        return None
    late = any(
        not is_number(first[0][column]) or len({row[column] for row in first}) == 1 for column in columns
    )  # rows with another word or number may begin later
    lines = _row_lines(text.split("\n") if late else text.split("\n", _LINES)[:_LINES])
    split += [bare_fields(line, delimiter) for line in lines[_FIRST_LINES:]]
    rows = [fields for fields in split if _is_row(fields)]
    for column in columns:
        labels = _labels(rows, column)
        if _is_sensor(labels) or (len(labels) > 1 and _shows_kinds(rows, column, labels, names)):
            name = names[column] if column < len(names) else ""
            return Kinds(column=column, name=name, labels=labels, delimiter=delimiter)
    return None


def find_device_column(text: str) -> Kinds | None:
    """Find the column with the name of a device, if all rows at the beginning of a text have one integer in it; else None.

    Rows of another device may follow in blocks.
    """
    lines = _row_lines(text.split("\n", _FIRST_LINES + _HEADERS)[:-1])
    delimiter = _delimiter(lines[:_FIRST_LINES])
    split = [bare_fields(line, delimiter) for line in lines] if delimiter != _NO_DELIMITER else []
    rows = [fields for fields in split if _is_row(fields)]
    for column, name in enumerate(_names(split, text, delimiter) if rows else ()):
        labels = {row[column] for row in rows if len(row) > column}
        if has_device_name(name) and len(labels) == 1 and _WHOLE.fullmatch(label := labels.pop()):
            return Kinds(column=column, name=name, labels=(label,), delimiter=delimiter)
    return None


def _row_lines(lines: Sequence[str]) -> list[str]:
    """The lines without blank ones and comments."""
    return [line for raw in lines if (line := raw.strip()) and not line.startswith(COMMENTS)]


def _is_sensor(labels: Sequence[str]) -> bool:
    """Whether all rows have one word, which names a sensor. Rows of another sensor may follow."""
    return len(labels) == 1 and find_sensor(labels[0]) is not None


@frozen
class KindText:
    """The lines of a text, without the rows of other kinds."""

    text: str
    numbers: tuple[int, ...]  # number of each line in the whole text, counted from 1


def rows_of_kind(text: str, kinds: Kinds, label: str) -> KindText:
    """The text without the rows of other kinds; other lines that are not of this kind are blank."""
    chosen, numbers = [], []
    before, named = True, False  # no row yet, and no line of names after the word of the kind
    for number, line in enumerate(text.split("\n"), 1):
        stripped = line.strip()
        comment = stripped.startswith(COMMENTS)
        fields = bare_fields(stripped.lstrip("#%/ ") if comment else stripped, kinds.delimiter)
        text_of_kind = fields[kinds.column] if len(fields) > kinds.column else ""
        is_row = not comment and _is_row(fields)
        is_header = text_of_kind not in kinds.labels and (comment or (before and not is_row))
        names = _names_of_kind(stripped, kinds, label) if is_header else None
        named = named or (names is not None and names.startswith(kinds.find_kind(label).topic))
        if named and names == stripped:
            names = None  # a mark below the names, such as $DATA
        is_header = names is not None
        if text_of_kind == label or is_header or not is_row:
            chosen.append(line if text_of_kind == label else names or "")
            numbers.append(number)
        before = before and not is_row
    return KindText(text="\n".join(chosen), numbers=tuple(numbers))


def _names_of_kind(line: str, kinds: Kinds, label: str) -> str | None:
    """A line above the rows that may name the columns of a kind; None if it only has the word of another kind.

    Names may follow the word of their kind: ``% Gyroscope data: 'GYRO;AppTimestamp(s);…`` or ``$COL,IMU,time,wx``. The part
    before that word is then left out.
    """
    words = {label: RowKind(column=0, name="", label=label, labels=()).topic for label in kinds.labels}
    named = {each for each, word in words.items() if _is_word(word) and re.search(rf"\b{re.escape(word)}\b", line)}
    if label not in named:
        return None if named else line
    mark = re.escape(kinds.delimiter) if kinds.delimiter else r"\s"
    match = re.search(rf"(?P<quote>['\"`]?)(?P<names>\b{re.escape(words[label])}\b['\"]?\s*{mark}.*)", line)
    if match is None or kinds.column != 0:
        return line
    return match["names"].removesuffix(match["quote"]) if match["quote"] else match["names"]


def _is_word(text: str) -> bool:
    return len(text) > 1 and text[0].isalpha()


def first_values(text: str, kinds: Kinds, label: str) -> NDArray[np.float64]:
    """The first rows of a kind as numbers, with NaN for missing ones: shape (n, columns). `text` comes from
    `rows_of_kind`.
    """
    lines = _row_lines(text.split("\n"))[:_LINES]
    rows = [fields for fields in (bare_fields(line, kinds.delimiter) for line in lines) if _is_row(fields)]
    width = Counter(map(len, rows)).most_common(1)[0][0] if rows else 0
    return np.array(
        [[_value(field) for field in row] for row in rows if len(row) == width and row[kinds.column] == label]
    )


_NO_DELIMITER = "none"


def _delimiter(lines: Sequence[str]) -> str | None:
    """The delimiter that splits rows into at least three fields; `_NO_DELIMITER` if there is none."""
    for delimiter in (";", "\t", ",", None):
        rows = sum(
            _is_row(fields) and 2 * _numbers(fields) > len(fields)
            for fields in (bare_fields(line, delimiter) for line in lines)
        )
        if rows >= max(_MIN_ROWS, 0.5 * len(lines)):
            return delimiter
    return _NO_DELIMITER


def _is_row(fields: Sequence[str]) -> bool:
    """Whether a line with these fields is a row: at least a third of the fields, and at least some, are numbers."""
    numbers = _numbers(fields)
    return numbers >= _MIN_NUMBERS and 3 * numbers >= len(fields)


def _numbers(fields: Sequence[str]) -> int:
    return sum(is_number(f) or ("," in f and is_number(f.replace(",", "."))) for f in fields)


def _may_show_kinds(rows: Sequence[Sequence[str]], column: int, names: Sequence[str]) -> bool:
    """Whether the first rows of a column have words, or small integers: two, or one if the column has the name of a
    device.
    """
    texts = {row[column] for row in rows}
    if "" in texts:
        return False
    if not any(map(is_number, texts)):
        return len(texts) <= _MAX_KINDS and not any(
            text.replace(",", ".").strip("0123456789.:-/+TZ ") == "" for text in texts
        )
    fewest = 1 if column < len(names) and has_device_name(names[column]) else 2
    return fewest <= len(texts) <= _MAX_KINDS and all(map(_WHOLE.fullmatch, texts))


def _labels(rows: Sequence[Sequence[str]], column: int) -> tuple[str, ...]:
    """The texts of a column, if they are few; none otherwise."""
    counts = Counter(row[column] for row in rows if len(row) > column)
    labels = [label for label, count in counts.items() if count >= _MIN_ROWS]
    rare = len(rows) - sum(counts[label] for label in labels)
    words = not any(map(is_number, labels))
    if len(labels) > _MAX_KINDS or (rare > _RARE * len(rows) and not words):
        return ()
    if not words and not all(map(_WHOLE.fullmatch, labels)):
        return ()
    return tuple(labels)


def _names(split: Sequence[Sequence[str]], text: str, delimiter: str | None) -> Sequence[str]:
    """The fields of the header, which may be a comment; empty if there is no header."""
    headers: list[Sequence[str]] = []
    for fields in split[:_HEADERS]:
        if _is_row(fields):
            break
        if not any(map(is_number, fields)):
            headers.append(fields)
    if headers:  # a row of units may be below the header
        return next((fields for fields in headers if names_something(fields)), headers[-1])
    first = text.lstrip().split("\n", 1)[0].strip()
    if first.startswith(COMMENTS):
        fields = bare_fields(first.lstrip("#%/ "), delimiter)
        return fields if len(fields) > 1 and not any(map(is_number, fields)) else []
    return []


def _shows_kinds(rows: Sequence[Sequence[str]], column: int, labels: Sequence[str], names: Sequence[str]) -> bool:
    words = not any(map(is_number, labels))
    widths = {label: Counter(len(row) for row in rows if row[column : column + 1] == [label]) for label in labels}
    if all(width.most_common(1)[0][1] < _CONSTANT_WIDTH * width.total() for width in widths.values()):
        return False
    usual = {width.most_common(1)[0][0] for width in widths.values()}
    if len(usual) > 1:
        return words or cycles_with_rows([row[column] for row in rows if len(row) > column and row[column] in labels])
    usual_rows = [row for row in rows if len(row) in usual and row[column] in labels]

    def values() -> NDArray[np.float64]:
        return np.array([[_value(f) for f in row] for row in usual_rows])

    name = names[column] if len(names) in usual else ""
    return shows_kinds(name, labels, [row[column] for row in usual_rows], values, words=words)


def _value(text: str) -> float:
    return (
        float(text)
        if is_number(text)
        else float(text.replace(",", "."))
        if is_number(text.replace(",", "."))
        else np.nan
    )
