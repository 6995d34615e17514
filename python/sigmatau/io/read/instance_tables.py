"""Rows of several instances or kinds of a sensor in a table of columns: MATLAB, HDF5, Parquet, NumPy, data frames.

In text the rows of a kind are chosen while the text is read (`sigmatau.io.read.formats.row_kinds`). Here the column that
tells the kinds is loaded, and the rows of the other columns are chosen by it.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.io.read.formats.kind_columns import with_sensor_names
from sigmatau.io.read.instances import find_sensor, has_instance_name, may_be_instance, tells_kinds
from sigmatau.io.read.names import recognise
from sigmatau.io.read.table import RowKind, Table

_FORMATS = ("npy", "npz", "matlab", "hdf5", "parquet", "arrow", "tdms", "frame", "json")
_IN_MEMORY = ("npy", "npz", "matlab", "frame", "json")  # a column is at hand without a pass over the file
_HEAD = 2000  # rows that show whether a column tells kinds
_MAX_KINDS = 16  # different values of such a column
_MAX_COLUMNS = 16  # columns without the name of an instance that are tested
_MAX_LABEL = 9999  # largest number of an instance
_COVERED = 0.97  # share of all rows that have the values of the head


def separate_instances(tables: Sequence[Table]) -> Sequence[Table]:
    """The tables, with one for each kind of rows in place of a single table that has rows of several kinds."""
    if len(tables) != 1 or tables[0].format not in _FORMATS or tables[0].kind is not None:
        return tables
    table = tables[0]
    for name, column, load in _candidates(table):
        try:
            values = load()
        except DataError:
            continue  # raised again if it is wanted
        head = values if column < 0 else values[:_HEAD]  # rows of another word may begin late
        labels = _labels(head)
        if _names_sensor(labels, column) or (len(labels) > 1 and _tells_kinds(table, name, column, head, labels)):
            texts = np.asarray(values[:]).astype(str) if column < 0 else np.asarray(values[:])
            masks = {label: texts == value for label, value in labels.items()}
            if sum(float(np.mean(mask)) for mask in masks.values()) >= _COVERED:
                kinds = {
                    label: RowKind(column=column, name=name, label=label, labels=tuple(labels)) for label in labels
                }
                return [_take_kind(table, kinds[label], mask) for label, mask in masks.items()]
    return tables


def _candidates(table: Table) -> Iterator[tuple[str, int, Callable[[], NDArray[np.generic]]]]:
    """Name, place and values of the columns that may tell kinds; columns of words have the place -1."""
    for name, words in table.words.items():
        yield name, -1, words
    used = recognise(table.columns)
    spare = [k for k, match in enumerate(used) if match is None]
    named = [k for k in spare if has_instance_name(table.columns[k].name)]
    unnamed = [k for k in spare if k not in named and may_be_instance(table.columns[k].name)]
    for k in (*named, *(unnamed[:_MAX_COLUMNS] if table.format in _IN_MEMORY else ())):
        yield table.columns[k].name, k, lambda k=k: table.load([k], None).columns[k]  # type: ignore[misc]


def _labels(head: NDArray[np.generic]) -> dict[str, object]:
    """The values of a column by their texts, if they are few words or small whole numbers; none otherwise."""
    values = np.asarray(head)
    if values.dtype.kind not in "iuf":
        texts = list(dict.fromkeys(values.astype(str).tolist()))
        return {text: text for text in texts} if len(texts) <= _MAX_KINDS and "" not in texts else {}
    numbers = np.unique(values)
    if not 2 <= len(numbers) <= _MAX_KINDS or not np.isfinite(numbers).all():
        return {}
    if numbers[0] < 0 or numbers[-1] > _MAX_LABEL or (numbers != np.round(numbers)).any():
        return {}
    return {str(int(number)): number for number in numbers}


def _names_sensor(labels: Mapping[str, object], column: int) -> bool:
    """Whether all rows have one word, and it names a sensor."""
    return column < 0 and len(labels) == 1 and find_sensor(next(iter(labels))) is not None


def _tells_kinds(table: Table, name: str, column: int, head: NDArray[np.generic], labels: dict[str, object]) -> bool:
    order = np.asarray(head).astype(str).tolist() if column < 0 else [str(int(value)) for value in head]
    if column < 0 and table.format == "json" and _have_fields_of_their_kind(table, order, labels):
        return True
    rows = np.arange(min(len(order), _HEAD))
    return tells_kinds(name, tuple(labels), order[:_HEAD], lambda: _values(table, rows), words=column < 0)


def _have_fields_of_their_kind(table: Table, order: Sequence[str], labels: Collection[str]) -> bool:
    """Whether rows of each word have other fields than those of another, as messages do."""
    present = np.isfinite(_values(table, np.arange(min(len(order), _HEAD))))
    words = np.array(order[: len(present)])
    fields = [present[words == label] for label in labels]
    return all(len(rows) and (rows == rows[0]).all() for rows in fields) and len(
        {rows[0].tobytes() for rows in fields}
    ) == len(fields)


def _values(table: Table, rows: NDArray[np.intp]) -> NDArray[np.float64]:
    """Some rows of all columns of numbers, NaN in columns of words: shape (n, columns)."""
    columns = []
    for k in range(len(table.columns)):
        try:
            column = table.load([k], None).columns[k]
            columns.append(np.asarray(column[rows[rows < len(column)]], dtype=np.float64))
        except (DataError, ValueError):  # words
            columns.append(np.full(len(rows), np.nan))
    shortest = min(map(len, columns))
    return np.stack([column[:shortest] for column in columns], axis=1)


def _take_kind(table: Table, kind: RowKind, mask: NDArray[np.bool_]) -> Table:
    """The rows of a table where `mask` is true."""
    part = table.take_rows(np.flatnonzero(mask), kind.topic, kind.describe_rows())
    columns, notes = table.columns, tuple[str, ...]()
    if kind.column < 0:
        values = _values(part, np.arange(min(len(np.flatnonzero(mask)), _HEAD)))
        empty = [table.format == "json" and bool(np.isnan(column).all()) for column in values.T]
        # Rows of another kind have other fields.
        columns = tuple(
            replace(c, name="", unit=None, first="") if e else c for c, e in zip(columns, empty, strict=True)
        )
        columns, notes = with_sensor_names(columns, kind.label, values)
    return replace(part, columns=columns, notes=(*part.notes, *notes), kind=kind)
