"""What every reader hands over: the columns of a file, before they mean anything."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from numpy.typing import NDArray

__all__ = ["HEAD", "Column", "Format", "Head", "Table", "listing"]

HEAD = 1 << 18
"""A format, and the layout of a text table, is found out from this many bytes. [bytes]"""

_LISTED = 12
_WORD = 50


@dataclass(frozen=True, slots=True, kw_only=True)
class Head:
    """The beginning of a file.

    Attributes
    ----------
    data : bytes
        The first `HEAD` bytes, decompressed.
    whole : bool
        True if the file holds no more than this.
    gzip : bool
        True if the file is compressed.
    """

    data: bytes
    whole: bool
    gzip: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """A column of a file.

    Attributes
    ----------
    name : str
        As the file has it, with the unit if that is part of it; empty if the column has no name.
    unit : str or None
        Its unit from a row of units, as the file spells it.
    first : str
        What stands in its first row, to show columns without names by; may be empty.
    """

    name: str
    unit: str | None = None
    first: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A file as columns, of which those that are wanted are loaded later.

    Attributes
    ----------
    format : str
        ``"text"``, ``"npy"`` or ``"npz"``.
    columns : tuple of Column
    notes : tuple of str
        What was found out about the layout, in words.
    load : callable
        ``load(wanted, exact)`` returns a mapping from column (counted from 0) to raw numbers, all finite, all of one
        length, for every column in `wanted`. The column `exact` comes as 64-bit integers if it holds such.
        Raises `DataError`.
    where : callable
        ``where(row)`` says where a row (counted from 0) stands in the file: ``"line 17"``.
    """

    format: str
    columns: tuple[Column, ...]
    notes: tuple[str, ...]
    load: Callable[[Sequence[int], int | None], Mapping[int, NDArray[Any]]]
    where: Callable[[int], str]

    def label(self, index: int) -> str:
        """Name of a column for messages; its number if it has none."""
        name = self.columns[index].name
        return repr(name) if name else str(index + 1)


class Format(Protocol):
    """A module that reads one format."""

    def sniff(self, head: bytes, path: Path) -> bool:
        """Whether a file that begins so is of this format."""
        ...

    def read(self, path: Path, head: Head) -> Table:
        """The columns of a file that `sniff` took; raises `DataError`."""
        ...


def listing(columns: Sequence[Column]) -> str:
    """The columns of a file in one line: ``1 't', 2 'wx'``, or with their first numbers; the first twelve of many."""
    shown = ", ".join(_shown(i, column) for i, column in enumerate(columns[:_LISTED], 1))
    return shown if len(columns) <= _LISTED else f"{shown}, … {len(columns)} in all"


def _shown(number: int, column: Column) -> str:
    text = column.name or column.first
    text = text if len(text) <= _WORD else text[: _WORD - 1] + "…"
    if column.name:
        return f"{number} {text!r}"
    return f"{number} ({text} …)" if text else str(number)
