"""The names and units of the columns of a text table: a header, a row of units, or a row of axes above the samples."""

from __future__ import annotations

import re
from collections.abc import Sequence

from sigmatau.io.read.formats.text_lines import DELIMITERS, Line, bare, bare_fields, is_number
from sigmatau.io.read.names import recognise, split_unit
from sigmatau.io.read.table import Column

_UNIT_GAP = re.compile(r"(?<!\s)\s++(?=[\[(])")
# Before the names in a comment: its mark (%time is a name, of rostopic), and a word for them, ``;Headers, Time,Ax``.
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
    """The names in a line, if it has one for each column and no numbers; else nothing."""
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
    """Whether a line has the axes of the columns that the line above it names."""
    axes = [f.lower() for f in fields if f.lower() in ("x", "y", "z")]
    rest = [f for f in fields if f and f.lower() not in ("x", "y", "z")]
    return len(axes) >= 3 and len(rest) <= 1


def _with_axes(stems: list[str], axes: list[str]) -> list[str]:
    """Names with their axes; a name may stand above the first axis only."""
    names, last = [], ""
    for stem, axis in zip(stems, axes, strict=True):
        last = stem or last
        names.append(f"{last} {axis}" if axis.lower() in ("x", "y", "z") else stem or axis)
    return names


def _is_unit_row(fields: list[str]) -> bool:
    named = [f.strip("[](){} ") for f in fields if f.strip("[](){} -")]
    units = sum(split_unit(Column(name="x", unit=f))[1] is not None for f in named)
    return units > 0 and 2 * units >= len(named)
