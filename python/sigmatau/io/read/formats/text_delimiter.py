"""The delimiter of a text table, its decimal commas, and the names and units of its columns.

Decimal commas are read if the delimiter is another character and no number has a point. Ambiguous tables (decimal
commas and comma delimiters, two delimiters) are refused with advice. Names and units are in a header, a row of units,
or a row of axes above the samples.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from sigmatau.errors import DataError
from sigmatau.io.read.formats.text_lines import (
    DELIMITERS,
    EXCHANGED,
    Line,
    NoRowsError,
    bare,
    bare_fields,
    is_number,
    is_row,
)
from sigmatau.io.read.names import recognise, split_unit
from sigmatau.io.read.table import Column

HEADERS = 20  # number of lines above the samples that may contain numbers
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")


def find_delimiter(rows: list[Line], with_comments: list[Line]) -> tuple[str | None, int]:
    """The delimiter and the number of columns that give the most numbers in rows."""
    best: tuple[int, float] = (0, 0.0)
    choice: tuple[str | None, int] | None = None
    without_commas = [
        row for row in rows if len(row.numbers_only() or ()) < 2
    ]  # several numbers have no other delimiter
    for delimiter in DELIMITERS:
        numbers: dict[int, int] = {}
        fields: dict[int, int] = {}
        trailing: dict[int, int] = {}
        lines: dict[int, int] = {}
        for row in rows if delimiter == "," else without_commas:
            n, count, open_end = row.numbers(delimiter)
            if not n:
                continue
            lines[n] = lines.get(n, 0) + 1
            numbers[n] = numbers.get(n, 0) + count
            fields[n] = fields.get(n, 0) + n
            trailing[n] = trailing.get(n, 0) + (n > 1 and open_end)
        for n, count in numbers.items():
            score = (count, count / fields[n])
            if score > best:
                best = score
                # A delimiter at the end of every line does not add a column that has no name.
                bare = trailing[n] == lines[n] and not _names_last(rows[:HEADERS], delimiter, n)
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


def _named_tabs(rows: list[Line], lines: list[Line], filled: int) -> int | None:
    """The number of columns between tabs, if a header names more columns than the rows fill; else None."""
    row = next((r for r in rows if len(r.split(None)) == filled and is_row(r.split(None))), None)
    if row is None or "\t\t" not in f"\t{row.text}\t":
        return None
    columns = len(row.split("\t"))
    if columns <= filled or sum(map(bool, row.split("\t"))) != filled or not row.is_data("\t", columns):
        return None
    before = [line for line in lines if line.number < row.number]
    for width in (columns, columns - 1):  # a tab at the end of the rows
        for line in before[-3:]:
            fields = names_in(line, "\t", width)
            if width > filled and fields and all(fields) and len(line.text.split("\t")) >= width:
                return width
    return None


def _names_last(rows: list[Line], delimiter: str | None, columns: int) -> bool:
    """Whether a line names the last column, whose samples may begin later than those of the others."""
    split = (row.split(delimiter) for row in rows)
    return any(len(f) == columns and f[-1].strip() and not is_row(f, columns) for f in split)


def exchange_decimal_commas(rows: list[Line]) -> bool:
    """Exchange commas and points of rows with decimal commas, as in the reader; return whether there are any."""
    candidates = [row for row in rows if "," in row.text and not row.numbers_only()]
    for delimiter in (";", "\t", None):
        first = next((row for row in candidates if _has_decimal_commas(row, delimiter)), None)
        if first is None:
            continue
        for row in rows:
            point = next((f for f in row.split(delimiter) if "." in f and is_number(f)), None)
            if point is not None:
                raise DataError(
                    f"numbers with a decimal comma ({first.text[:40]!r}), though line {row.number}"
                    f" has {point!r} with a point; save all with points",
                    place=f"line {first.number}",
                )
        for row in rows:
            exchanged = row.text.translate(EXCHANGED)
            if row.number == first.number or is_row([bare(f) for f in exchanged.split(delimiter)]):
                row.exchange()
        return True
    return False


def _has_decimal_commas(row: Line, delimiter: str | None) -> bool:
    if "," not in row.text or len(row.text.split(delimiter, 1)) < 2:
        return False  # fast path: most rows
    fields = [f for f in row.split(delimiter) if f]
    commas = sum(_DECIMAL_COMMA.fullmatch(f) is not None for f in fields)
    numbers = commas + sum(map(is_number, fields))
    # Spaces also separate dates from times, and the words of a comment.
    return commas > 0 and (numbers == len(fields) if delimiter is None else 2 * numbers >= len(fields))


def refuse_split_numbers(rows: list[Line], first: Line, columns: int) -> None:
    """Raise `DataError` for decimal commas in a comma-separated table, where each number is split into two integers."""
    if columns % 2:
        return
    data = []
    for row in rows:
        fields = row.split(",")
        if is_row(fields, columns):
            if not all(f.lstrip("+-").isdigit() for f in fields[:columns]):
                return
            data.append(fields)
    padded = any(len(f) > 1 and f[0] == "0" for fields in data for f in fields[1:columns:2])
    header = next((row for row in reversed(rows) if row.number < first.number), None)
    halved = header is not None and 2 * max(len(header.split(d)) for d in DELIMITERS) == columns
    if padded or halved:
        raise _decimal_comma(first)


def _decimal_comma(row: Line) -> DataError:
    return DataError(
        f"numbers with a decimal comma ({row.text[:40]!r}) cannot be distinguished from two numbers"
        " with a comma between them; save them with a decimal point, or with semicolons between them",
        place=f"line {row.number}",
    )


def refuse_other_delimiters(first: Line, delimiter: str | None) -> None:
    """Raise `DataError` if a field of the first row has several numbers, with another delimiter between them."""
    for text in first.split(delimiter):
        if delimiter is not None and delimiter in text:
            continue  # within quotes
        parts = [p for p in re.split(r"[;,\s|]+", text) if p]
        if len(parts) > 1 and all(map(is_number, parts)):
            raise DataError(
                f"{text[:40]!r} between two {DELIMITERS[delimiter]}s has another delimiter;"
                " save the table with one delimiter",
                place=f"line {first.number}",
            )


_UNIT_GAP = re.compile(r"(?<!\s)\s++(?=[\[(])")
# Text before the names in a comment: its mark (%time is a name in rostopic), and a word for names, ``;Headers,
# Time,Ax``.
_MARK = re.compile(r"^\s*(?:#+|%+(?!time\b)|//+|;)\s*(?:(?:headers?|columns|fields|names)\s*[:=,]\s*)?", re.IGNORECASE)
_IN_BRACKETS = re.compile(r"[\[(][^\])]{0,80}[\])]")


def find_names(
    before: list[Line], delimiter: str | None, columns: int
) -> tuple[list[str], list[str | None], int | None, list[str]]:
    """Names, units of a unit row, number of the header line, and notes."""
    blank: list[str] = [""] * columns
    nothing: list[str | None] = [None] * columns
    marked = [line for line in before if any(c.isalnum() for c in line.text)]  # without rows of dashes
    fitting = [(line, fields) for line in marked if (fields := names_in(line, delimiter, columns))]
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
    in_header = any(split_unit(Column(name=f))[1] for f in fields)
    return fields, nothing, line.number, ["units in the header"] if in_header else []


def names_something(fields: Sequence[str]) -> bool:
    """Whether some of these words are names of channels."""
    return any(recognise([Column(name=f) for f in fields]))


def names_in(line: Line, delimiter: str | None, columns: int) -> list[str]:
    """The names in a line with one name for each column and no numbers; else empty."""
    text = line.text
    if line.comment:
        text = _MARK.sub("", text)
        if columns == 1 and len(_IN_BRACKETS.sub("", text).split()) != 1:
            return []  # a comment
    if not text:
        return []
    if columns == 1:
        options = [[bare(text.rstrip(",;\t "))]]
    else:
        options = [bare_fields(t, d) for d in (delimiter, *DELIMITERS) for t in (text, _UNIT_GAP.sub("", text))]
    for fields in options:
        if len(fields) == columns + 1 and not fields[-1]:
            fields = fields[:-1]
        if len(fields) == columns and any(fields) and not any(map(is_number, fields)):
            return fields
    return []


def _is_axis_row(fields: list[str]) -> bool:
    """Whether a line contains the axes of the columns that the line above names."""
    axes = [f.lower() for f in fields if f.lower() in ("x", "y", "z")]
    rest = [f for f in fields if f and f.lower() not in ("x", "y", "z")]
    return len(axes) >= 3 and len(rest) <= 1


def _with_axes(stems: list[str], axes: list[str]) -> list[str]:
    """Add the axes to the names. A name may stand above the first axis only."""
    names, last = [], ""
    for stem, axis in zip(stems, axes, strict=True):
        last = stem or last
        names.append(f"{last} {axis}" if axis.lower() in ("x", "y", "z") else stem or axis)
    return names


def _is_unit_row(fields: list[str]) -> bool:
    named = [f.strip("[](){} ") for f in fields if f.strip("[](){} -")]
    units = sum(split_unit(Column(name="x", unit=f))[1] is not None for f in named)
    return units > 0 and 2 * units >= len(named)
