"""The delimiter of a text table, and its decimal commas.

Decimal commas are read if the delimiter is another character and no number has a point. An ambiguous table (decimal commas
between commas, two delimiters) is refused, with advice.
"""

from __future__ import annotations

import re

from sigmatau.errors import DataError
from sigmatau.io.read.formats.text_lines import DELIMITERS, EXCHANGED, Line, NoRowsError, bare, is_number, is_row
from sigmatau.io.read.formats.text_names import names_in

HEADERS = 20  # lines above the samples that may have numbers
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")


def find_delimiter(rows: list[Line], with_comments: list[Line]) -> tuple[str | None, int]:
    """The delimiter and the number of columns that give the most numbers in rows."""
    best: tuple[int, float] = (0, 0.0)
    choice: tuple[str | None, int] | None = None
    for delimiter in DELIMITERS:
        numbers: dict[int, int] = {}
        fields: dict[int, int] = {}
        trailing: dict[int, int] = {}
        lines: dict[int, int] = {}
        for row in rows:
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
    """The number of columns between tabs, if a header names more of them than the rows fill; None if not."""
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
    """Whether a line names the last of so many columns, whose samples may begin later than those of the others."""
    split = (row.split(delimiter) for row in rows)
    return any(len(f) == columns and f[-1].strip() and not is_row(f, columns) for f in split)


def exchange_decimal_commas(rows: list[Line]) -> bool:
    """Whether numbers have decimal commas; then commas and points of those rows are exchanged, as in the reader."""
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
