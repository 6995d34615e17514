"""Text tables whose cells or rows contain more than numbers.

A unit in each cell (``0.01 sec``, MATLAB's timetables), or a mark at the end of each row besides the delimiters
(``1,2,3;``). The marks and units are removed from the text; a unit becomes that of its column.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.io.read.formats.text_lines import COMMENTS
from sigmatau.io.read.names import split_unit, stated_unit
from sigmatau.io.read.table import Column, Table

_LINES = 60  # lines at the beginning of the text that are examined
_ROWS = 20  # number of last rows among them that show the form of a row
_ROW_ENDS = (";", "|")
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_CELL = re.compile(rf"\s*\"?{_NUMBER}[ \u00a0]*(?P<unit>[A-Za-zµμ°Ωω][^\s,;\t\"]{{0,15}})\"?\s*")
_MAY_BE_CELL = re.compile(r"\d[ \u00a0]*[A-Za-zµμ°]")
_DELIMITERS = (",", ";", "\t")


@frozen
class Decoration:
    """Content of the cells or rows of a text besides numbers."""

    row_end: str = ""
    units: tuple[str | None, ...] = ()  # units of the columns
    delimiter: str = ""  # delimiter between cells with units

    def strip(self, data: bytes) -> bytes:
        """Remove the marks and units from a text. Raises `DataError` if the cells of one column have several units."""
        if self.row_end:
            data = re.sub(re.escape(self.row_end.encode()) + rb"(?=[ \t]*\r?$)", b"", data, flags=re.MULTILINE)
        if self.units:
            data = self._without_units(data)
        return data

    def _without_units(self, data: bytes) -> bytes:
        spelled = Counter(unit for unit in self.units if unit)
        any_unit = b"|".join(re.escape(unit.encode()) for unit in sorted(spelled, key=len, reverse=True))
        end = re.escape(self.delimiter.encode())
        pattern = re.compile(
            rb"(?<=[0-9.])(?: |\xc2\xa0)*(" + any_unit + rb")(?=\"?[ ]*(?:" + end + rb"|\r?$))", re.MULTILINE
        )
        counts = Counter(match[1].decode() for match in pattern.finditer(data)) if len(spelled) > 1 else {}
        rows = {unit: counts[unit] // columns for unit, columns in spelled.items()} if counts else {}
        if rows and max(rows.values()) - min(rows.values()) > 1:
            raise DataError(
                f"has cells of a column in several units ({', '.join(spelled)}); save each column in one unit"
            )
        return pattern.sub(b"", data)

    def apply(self, table: Table) -> Table:
        """Set the units of the columns of a table. Raises `DataError` if the name of a column states another unit."""
        if not self.units:
            return table
        columns = tuple(_with_unit(column, unit) for column, unit in zip(table.columns, self.units, strict=False))
        listed = ", ".join(dict.fromkeys(unit for unit in self.units if unit))
        return replace(
            table,
            columns=(*columns, *table.columns[len(columns) :]),
            notes=(*table.notes, f"unit within each cell: {listed}"),
        )


def _with_unit(column: Column, unit: str | None) -> Column:
    if unit is None:
        return column
    stated = split_unit(column)[1]
    if stated is not None and stated != split_unit(Column(name="x", unit=unit))[1]:
        raise DataError(f"column {column.name!r} has cells in {unit!r}; correct its name")
    return column if stated_unit(column) else replace(column, unit=unit)


def find_decoration(text: str) -> Decoration | None:
    """Find what the rows of a text contain besides numbers, from its first lines; None if there is nothing."""
    lines = [line.strip() for line in text.split("\n", _LINES)[:_LINES]]
    rows = [line for line in lines if line and not line.startswith(COMMENTS)][-_ROWS - 1 : -1]
    if len(rows) < 2:
        return None
    row_end = next((mark for mark in _ROW_ENDS if all(_ends_with_only(row, mark) for row in rows)), "")
    if row_end:
        rows = [row[:-1] for row in rows]
    units: tuple[str | None, ...] = ()
    delimiter = ""
    if all(map(_MAY_BE_CELL.search, rows)):
        for mark in _DELIMITERS:
            if units := _units_of_cells([row.split(mark) for row in rows]):
                delimiter = mark
                break
    return Decoration(row_end=row_end, units=units, delimiter=delimiter) if row_end or units else None


def _ends_with_only(row: str, mark: str) -> bool:
    return row.endswith(mark) and row.count(mark) == 1 and any(delimiter in row for delimiter in (",", "\t", " "))


def _units_of_cells(rows: Sequence[Sequence[str]]) -> tuple[str | None, ...]:
    """The unit of each column in which all cells have the same known unit; empty if there is no such column."""
    width = len(rows[0])
    if width < 2 or any(len(row) != width for row in rows):
        return ()
    units: list[str | None] = []
    for cells in zip(*rows, strict=True):
        matches = [_CELL.fullmatch(cell) for cell in cells]
        spelled = {match["unit"] for match in matches if match}
        unit = spelled.pop() if all(matches) and len(spelled) == 1 else None
        units.append(unit if unit and split_unit(Column(name="x", unit=unit))[1] is not None else None)
    return tuple(units) if any(units) else ()
