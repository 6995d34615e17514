"""Names of the columns of rows of one kind, whose word names the sensor: x, y, z of ``Gyro`` rows are those of a gyro."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sigmatau.io.read.instances import find_sensor
from sigmatau.io.read.names import recognise
from sigmatau.io.read.table import Column

_LEAST_ROWS = 16  # rows that must show what the columns without names are
_ALWAYS = 0.999  # share of the intervals in which a clock goes forward
_GRAVITY = ((0.85, 1.15), (9.0, 10.5), (900.0, 1100.0))  # length of three means [g, m/s^2, mg]
_SCATTER = 0.05  # largest standard deviation of an axis at rest, over the size of gravity


def with_sensor_names(
    columns: Sequence[Column], label: str, values: NDArray[np.float64]
) -> tuple[tuple[Column, ...], tuple[str, ...]]:
    """The columns with the sensor in the names of its three axes, and a note; unchanged if they are not certain.
    `values`: shape (n, columns), the first rows of this kind, NaN where there is no number.
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
    """The first of three columns whose names differ only in x, y, z, and all columns with the sensor in these names."""
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
    """The only three columns that are neither a clock, a counter nor constant, if gravity is on an accelerometer and not
    on a gyro; and all columns with names.
    """
    named = list(columns)
    if len(values) < _LEAST_ROWS:
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
    """Whether two clocks have the same unit and run together."""
    intervals, second_intervals = np.diff(first), np.diff(second)
    return bool(np.abs(intervals - second_intervals).max() <= 0.01 * np.median(intervals))
