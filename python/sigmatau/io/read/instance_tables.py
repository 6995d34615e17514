"""Rows of several instances or kinds of a sensor in a table of columns: MATLAB, HDF5, Parquet, NumPy, data frames.

In text, the rows of a kind are selected while the text is read (`sigmatau.io.read.formats.row_kinds`). Here, the column that
shows the kinds is loaded, and the rows of the other columns are selected by it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.io.read.instances import find_sensor, has_instance_name, may_be_instance, shows_kinds
from sigmatau.io.read.names import recognise
from sigmatau.io.read.table import Column, RowKind, Table

_FORMATS = ("npy", "npz", "matlab", "hdf5", "parquet", "arrow", "tdms", "frame", "json")
# formats in which a column is available without reading the whole file
_IN_MEMORY = ("npy", "npz", "matlab", "frame", "json")
_HEAD = 2000  # number of rows that show whether a column contains kinds
_MAX_KINDS = 16  # largest number of distinct values of such a column
_MAX_COLUMNS = 16  # largest number of columns without the name of an instance that are tested
_MAX_LABEL = 9999  # largest number of an instance
_COVERED = 0.97  # smallest share of all rows whose values occur in the head


def separate_instances(tables: Sequence[Table]) -> Sequence[Table]:
    """Replace a single table with rows of several kinds by one table for each kind."""
    if len(tables) != 1 or tables[0].format not in _FORMATS or tables[0].kind is not None:
        return tables
    table = tables[0]
    for name, column, load in _candidates(table):
        try:
            values = load()
        except DataError:
            continue  # raised again when the table is read
        head = values if column < 0 else values[:_HEAD]  # rows with another word may begin later
        labels = _labels(head)
        if _names_sensor(labels, column) or (len(labels) > 1 and _shows_kinds(table, name, column, head, labels)):
            texts = np.asarray(values[:]).astype(str) if column < 0 else np.asarray(values[:])
            masks = {label: texts == value for label, value in labels.items()}
            if sum(float(np.mean(mask)) for mask in masks.values()) >= _COVERED:
                kinds = {
                    label: RowKind(column=column, name=name, label=label, labels=tuple(labels)) for label in labels
                }
                return [_take_kind(table, kinds[label], mask) for label, mask in masks.items()]
    return tables


def _candidates(table: Table) -> Iterator[tuple[str, int, Callable[[], NDArray[np.generic]]]]:
    """Name, place and values of the columns that may show kinds; columns of words have the place −1."""
    for name, words in table.words.items():
        yield name, -1, words
    used = recognise(table.columns)
    spare = [k for k, match in enumerate(used) if match is None]
    named = [k for k in spare if has_instance_name(table.columns[k].name)]
    unnamed = [k for k in spare if k not in named and may_be_instance(table.columns[k].name)]
    for k in (*named, *(unnamed[:_MAX_COLUMNS] if table.format in _IN_MEMORY else ())):
        yield table.columns[k].name, k, lambda k=k: table.load([k], None).columns[k]  # type: ignore[misc]


def _labels(head: NDArray[np.generic]) -> dict[str, object]:
    """The values of a column as texts, if there are few words or small integers; else empty."""
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


def _shows_kinds(table: Table, name: str, column: int, head: NDArray[np.generic], labels: dict[str, object]) -> bool:
    order = np.asarray(head).astype(str).tolist() if column < 0 else [str(int(value)) for value in head]
    if column < 0 and table.format == "json" and _have_fields_of_their_kind(table, order, labels):
        return True
    rows = np.arange(min(len(order), _HEAD))
    return shows_kinds(name, tuple(labels), order[:_HEAD], lambda: _values(table, rows), words=column < 0)


def _have_fields_of_their_kind(table: Table, order: Sequence[str], labels: Collection[str]) -> bool:
    """Whether rows of different words fill different fields, as messages of several kinds do."""
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
    """Select the rows of a table for which `mask` is true."""
    part = table.take_rows(np.flatnonzero(mask), kind.topic, kind.describe_rows())
    columns, notes = table.columns, tuple[str, ...]()
    if kind.column < 0:
        values = _values(part, np.arange(min(len(np.flatnonzero(mask)), _HEAD)))
        empty = [table.format == "json" and bool(np.isnan(column).all()) for column in values.T]
        # Rows of another kind fill other fields.
        columns = tuple(
            replace(c, name="", unit=None, first="") if e else c for c, e in zip(columns, empty, strict=True)
        )
        columns, notes = with_sensor_names(columns, kind.label, values)
    return replace(part, columns=columns, notes=(*part.notes, *notes), kind=kind)


_MIN_ROWS = 16  # number of rows needed to identify columns without names
_ALWAYS = 0.999  # smallest share of the intervals in which a clock goes forward
_GRAVITY = ((0.85, 1.15), (9.0, 10.5), (900.0, 1100.0))  # length of three means [g, m/s^2, mg]
_SCATTER = 0.05  # largest standard deviation of an axis at rest, over the size of gravity


def with_sensor_names(
    columns: Sequence[Column], label: str, values: NDArray[np.float64]
) -> tuple[tuple[Column, ...], tuple[str, ...]]:
    """Add the sensor to the names of its three axes, with a note. The columns are unchanged if the sensor is not certain.

    `values`: shape (n, columns), the first rows of this kind, NaN for a missing number.
    """
    sensor = find_sensor(label)
    if sensor is None:
        return tuple(columns), ()
    snake = [replace(column, name=_snake(column.name)) for column in columns]
    if _has_axes(snake, sensor):
        return tuple(snake), ()
    first, named = _axes_by_name(snake, sensor)
    if first is None:
        first, named = _axes_by_values(snake, sensor, values)
    if first is None or not _has_axes(named, sensor):
        return tuple(columns), ()
    return tuple(named), (f"columns {first + 1} to {first + 3} of the {label} rows read as {sensor} x, y, z",)


def _has_axes(columns: Sequence[Column], sensor: str) -> bool:
    matched = [match[0] for match in recognise(columns) if match is not None]
    return all(matched.count(f"{sensor}_{axis}") == 1 for axis in "xyz")


def _snake(name: str) -> str:
    """``UncalGyroXRadPerSec`` as ``uncal_gyro_x_rad_per_sec``; a name that is not in camel case unchanged."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9]*[a-z][A-Z][A-Za-z0-9]*", name):
        return name
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name).lower()


def _axes_by_name(columns: Sequence[Column], sensor: str) -> tuple[int | None, list[Column]]:
    """The first of three columns whose names differ only in x, y, z, and all columns with the sensor added to these
    names.
    """
    for first in range(len(columns) - 2):
        parts = [re.fullmatch(rf"(.*?)(?<![a-z])({axis})(?![a-z])(.*)", columns[first + k].name, re.IGNORECASE)
                 for k, axis in enumerate("xyz")]  # fmt: skip
        stems = {(match[1], match[3]) for match in parts if match}
        if all(parts) and len(stems) == 1:
            rest = stems.pop()[1]
            named = list(columns)
            for k, axis in enumerate("xyz"):
                named[first + k] = replace(columns[first + k], name=f"{sensor}_{axis}{rest}")
            return first, named
    return None, list(columns)


def _axes_by_values(
    columns: Sequence[Column], sensor: str, values: NDArray[np.float64]
) -> tuple[int | None, list[Column]]:
    """The only three columns that are not a clock, a counter or constant, if gravity shows the accelerometer; with all
    columns renamed.
    """
    named = list(columns)
    if len(values) < _MIN_ROWS:
        return None, named
    signals, clocks = [], []
    for k, column in enumerate(values.T[: len(columns)]):
        if not np.isfinite(column).all() or np.ptp(column) == 0:
            continue
        steps = np.diff(column)
        if np.mean(steps > 0) > _ALWAYS:
            if not (steps == steps[0]).all() or steps[0] != 1:  # a counter
                clocks.append(k)
        else:
            signals.append(k)
    if len(signals) != 3 or signals[2] - signals[0] != 2:
        return None, named
    axes = values[:, signals]
    size = float(np.linalg.norm(axes.mean(axis=0)))
    gravity = any(low < size < high for low, high in _GRAVITY) and bool((axes.std(axis=0) < _SCATTER * size).all())
    if gravity != (sensor == "accel"):
        return None, named
    for k, axis in zip(signals, "xyz", strict=True):
        named[k] = replace(columns[k], name=f"{sensor}_{axis}")
    if (
        clocks
        and not columns[clocks[0]].name
        and all(_is_same_clock(values[:, clocks[0]], values[:, k]) for k in clocks[1:])
    ):
        named[clocks[0]] = replace(columns[clocks[0]], name="time")
    return signals[0], named


def _is_same_clock(first: NDArray[np.float64], second: NDArray[np.float64]) -> bool:
    """Whether two clocks have the same unit and run at the same rate."""
    intervals, second_intervals = np.diff(first), np.diff(second)
    return bool(np.abs(intervals - second_intervals).max() <= 0.01 * np.median(intervals))
