"""The columns of a file, as every reader returns them."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.record.sampling import STATED, RateSource
from sigmatau.results import printable

HEAD = 1 << 18  # The format, and the layout of a text table, are detected from this many bytes. [bytes]
FORMATS = (
    "text tables, names with values, JSON, LabVIEW .lvm, VectorNav, NovAtel, MCAP, ROS bags, ULog, DataFlash, MATLAB, HDF5,"
    f" Zarr, Parquet, Arrow, TDMS, Excel .xlsx, .npy, .npz, or raw numbers with {Hint('layout')}"
)
"""The formats that are read, for the text of errors."""


_LISTED = 12
_WORD = 50


@frozen
class Head:
    """The beginning of a file."""

    data: bytes  # The first `HEAD` bytes, decompressed
    whole: bool  # True if these are all bytes of the file
    gzip: bool  # True if the file is compressed


@frozen
class Column:
    """A column of a file."""

    name: str  # As the file spells it, with its unit if that is part of the name; empty if the column has no name
    unit: str | None = None  # Unit from a row of units, as the file spells it
    first: str = ""  # Text of its first row, which shows a column without a name; may be empty
    counted: str = ""  # Unit of the file's numbers, if the reader converts them to `unit`: ``"us"``, ``"0.1 ms"``

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", printable(self.name))
        object.__setattr__(self, "unit", None if self.unit is None else printable(self.unit))
        object.__setattr__(self, "first", printable(self.first))


@frozen
class Loaded:
    """The requested columns."""

    # Raw numbers by column, counted from 0; shape (n,), all of one length, finite or NaN for a missing one. In a column
    # of integers, such as time stamps, the smallest 64-bit integer marks a missing one.
    columns: Mapping[int, NDArray[Any]]
    # Faults of the data, such as truncation; severity error if rows are missing
    findings: tuple[Finding, ...] = ()


Load = Callable[[Sequence[int], int | None], Loaded]


def select_columns(load: Load, places: Sequence[int]) -> Load:
    """A function that loads some columns of a table, by their places in it."""

    def load_selected(wanted: Sequence[int], exact: int | None) -> Loaded:
        loaded = load([places[k] for k in wanted], None if exact is None else places[exact])
        return replace(loaded, columns={k: loaded.columns[places[k]] for k in wanted})

    return load_selected


@frozen
class RowKind:
    """The kind of the rows of a table that is part of a larger one: the rows with one text in one column."""

    column: int  # counted from 0; -1 for a column of words that is not one of the table's
    name: str  # name of the column; empty if it has none
    label: str  # text of the column in these rows
    labels: tuple[str, ...]  # texts of the column in all rows

    @property
    def topic(self) -> str:
        """The name of the kind: its word, or ``imu0`` for the number 0."""
        text = self.label.strip(" :=$")
        return f"imu{int(float(text))}" if text.replace(".", "").isdigit() else text

    def place(self) -> str:
        """The column and its text, for messages."""
        *labels, last = self.labels[:_LISTED]
        shown = ", ".join(labels)
        if len(self.labels) > _LISTED:
            shown += f", {last} …"
        else:
            shown += f" and {last}" if labels else last
        return f"{self._column()} has {shown}"

    def describe_rows(self) -> str:
        """The rows of a table in words, for notes."""
        return f"rows with {self.label} in {self._column()}"

    def _column(self) -> str:
        number = "" if self.column < 0 else f" {self.column + 1}"
        return f"column{number}{f' {self.name!r}' if self.name else ''}"


@frozen
class Table:
    """One table of a file; its columns are loaded on demand. Most files have one table. In others each topic, message,
    group or variable is a table, and ``--topic`` chooses it.
    """

    format: str  # ``"text"``, ``"npy"``, ``"mcap"`` …
    columns: tuple[Column, ...]
    notes: tuple[str, ...]  # Properties of the file, for the provenance of the record
    # ``load(wanted, exact)`` returns the columns in `wanted`, counted from 0; the column `exact` as integers if it has them.
    # Raises `DataError`.
    load: Load
    # ``where(row)`` returns the place of a row (counted from 0) in the file: ``"line 17"``
    where: Callable[[int], str] = "row {}".format
    topic: str = ""  # Name in the file; empty if the file has only one table
    rows: int | None = None  # Number of rows, if it is known before they are loaded
    findings: tuple[Finding, ...] = ()  # Faults of the file that are known before it is loaded
    rate: float | None = None  # Sampling rate that the format states, for a table without a time column. [Hz]
    rate_source: RateSource = STATED  # Where the file states this rate
    words: Mapping[str, Callable[[], NDArray[Any]]] = field(default_factory=dict)  # Columns of words, by name
    kind: RowKind | None = None  # The kind of its rows, if the table of the file has rows of several kinds

    def __post_init__(self) -> None:
        object.__setattr__(self, "topic", printable(self.topic))
        object.__setattr__(self, "notes", tuple(map(printable, self.notes)))

    def label(self, index: int) -> str:
        """Name of a column for messages; its number if it has none."""
        name = self.columns[index].name
        return repr(name) if name else str(index + 1)

    def take_rows(self, rows: NDArray[np.intp] | slice, topic: str, note: str) -> Table:
        """Select some rows of a table, as a subordinate topic with this name."""

        def load(wanted: Sequence[int], exact: int | None) -> Loaded:
            loaded = self.load(wanted, exact)
            size = min((len(column) for column in loaded.columns.values()), default=0)
            chosen = rows if isinstance(rows, slice) else rows[rows < size]  # a damaged file may have fewer rows
            return replace(loaded, columns={k: np.asarray(column)[chosen] for k, column in loaded.columns.items()})

        def where(row: int) -> str:
            return self.where(rows.start + row * rows.step if isinstance(rows, slice) else int(rows[row]))

        count = self.rows if isinstance(rows, slice) else len(rows)
        return replace(
            self,
            notes=(*self.notes, note),
            load=load,
            where=where,
            topic=f"{self.topic}/{topic}" if self.topic else topic,
            rows=None if count is None else len(range(count)[rows]) if isinstance(rows, slice) else count,
        )


class Format(Protocol):
    """A module that reads one format."""

    def sniff(self, head: bytes, path: Path) -> bool:
        """Whether a file is of this format. It is only called for entries with ``sniffs``, if the first bytes allow the
        format.
        """
        ...

    def read(self, path: Path, head: Head) -> Sequence[Table]:
        """The tables of a file of this format; raises `DataError`."""
        ...


class TextFormat(Format, Protocol):
    """A module that reads a text format, also from memory."""

    def read_tables(self, source: Path | bytes, head: Head, name: str, topic: str = "") -> Sequence[Table]:
        """The tables of a file, or of text in memory; raises `DataError`. `name` is the name of the file without its
        suffix. `topic` is the name of a single table, or the prefix of several names.
        """
        ...


def listing(columns: Sequence[Column]) -> str:
    """The first twelve columns of a file in one line: ``1 't', 2 'wx'``, or with their first numbers if they have no
    names.
    """
    shown = ", ".join(_column_text(i, column) for i, column in enumerate(columns[:_LISTED], 1))
    return shown if len(columns) <= _LISTED else f"{shown}, … {len(columns)} in all"


def _column_text(number: int, column: Column) -> str:
    text = column.name or column.first
    text = text if len(text) <= _WORD else text[: _WORD - 1] + "…"
    if column.name:
        return f"{number} {text!r}"
    return f"{number} ({text} …)" if text else str(number)


_CHUNK = 1 << 15  # fits in a processor's cache


ABSURD = 1e60
"""A number larger than any output of a sensor, in any unit; its fourth power overflows a double."""


def without_absurd(array: NDArray[Any]) -> NDArray[Any]:
    """Replace infinite values and values beyond `ABSURD` in a column by NaN, which marks a missing value."""
    return all_without_absurd({0: array})[0]


def all_without_absurd(columns: Mapping[int, NDArray[Any]]) -> dict[int, NDArray[Any]]:
    """Columns of one file with NaN as in `without_absurd`; the rows of the file are read only once."""
    changed = dict(columns)
    doubted = {
        index: array.dtype.type(min(ABSURD, float(np.finfo(array.dtype).max)))
        for index, array in columns.items()
        if array.dtype.kind == "f"
    }
    for start in range(0, max((len(columns[index]) for index in doubted), default=0), _CHUNK):
        for index, largest in tuple(doubted.items()):
            array = columns[index]
            if (np.abs(np.asarray(array[start : start + _CHUNK])) > largest).any():
                changed[index] = np.where(np.abs(array) > largest, np.nan, array)
                del doubted[index]
    return changed


def load_stamped(table: Table, wanted: Sequence[int], time: int | None) -> Loaded:
    """Columns of a table, those of the time stamps as int64 if they are integers that fit, else as float64."""
    loaded = table.load(wanted, time)
    return loaded if time is None else replace(loaded, columns={**loaded.columns, time: _stamps(loaded.columns[time])})


def _stamps(array: NDArray[Any]) -> NDArray[Any]:
    array = np.asarray(array)
    whole = array.dtype.kind in "iu" and int(array.max(initial=0)) < 1 << 63
    return array.astype(np.int64 if whole else np.float64)


def need(module: str, extra: str, what: str) -> ModuleType:
    """Import a library that only some formats need. Raises a `DataError` that says how to install it."""
    try:
        return importlib.import_module(module)
    except ImportError:
        raise DataError(
            f"is {what}, which needs a library that is not installed: pip install 'sigmatau[{extra}]'"
        ) from None
