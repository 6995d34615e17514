"""Detection of gravity in the columns of a log: the unit of an accelerometer, and gravity on a gyro."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.io.read.table import Table, all_without_absurd

MIN_ROWS = 100
"""Smallest number of rows whose values are judged."""

ROWS_TESTED = 100_000
"""Largest number of rows that are judged."""

GRAVITY = ((0.9, 1.1), (9.3, 10.3), (900.0, 1100.0))
"""Sizes of gravity in g, m/s^2 and mg, with margins for biases and scale errors."""

GYRO_MEAN = 0.2
"""Largest mean of a gyro that is read without a question, over the size of gravity."""

_GRAVITY_UNITS = ("g", "m/s^2", "mg")
_SCATTER = 0.05  # largest standard deviation of an axis, over the size of gravity


def unit_of_gravity(table: Table, channels: Mapping[str, int]) -> str | None:
    """Find the unit in which the mean of the three axes of an accelerometer is gravity; None if there is none."""
    axes = [channels[name] for name in ("accel_x", "accel_y", "accel_z") if name in channels]
    if len(axes) < 3:
        return None
    try:
        loaded = dict(all_without_absurd(table.load(axes, None).columns))
    except DataError:  # raised again when the record is read
        return None
    samples = np.stack([np.asarray(loaded[index][:ROWS_TESTED], dtype=np.float64) for index in axes])
    if not np.isfinite(samples).any(axis=1).all():
        return None
    size = float(np.linalg.norm(np.nanmedian(samples, axis=1)))
    return next((unit for unit, (low, high) in zip(_GRAVITY_UNITS, GRAVITY, strict=True) if low <= size <= high), None)


def gravity_on_gyro(gyro: Sequence[NDArray[Any]], accel: Sequence[NDArray[Any]]) -> tuple[float, float] | None:
    """Sizes of the means of both sensors in units of the log, if gravity is on the gyro and not on the accelerometer; else
    None.
    """
    step = max(len(gyro[0]) // ROWS_TESTED, 1)
    with np.errstate(invalid="ignore"):  # a damaged number may be a signalling NaN
        triples = [np.stack([np.asarray(c[::step], dtype=np.float64) for c in sensor]) for sensor in (gyro, accel)]
    finite = [three[:, np.isfinite(three).all(axis=0)] for three in triples]
    if min(three.shape[1] for three in finite) < MIN_ROWS or not _is_gravity(finite[0]) or _is_gravity(finite[1]):
        return None
    sizes = [float(np.linalg.norm(three.mean(axis=1))) for three in finite]
    return (sizes[0], sizes[1]) if sizes[1] <= GYRO_MEAN * sizes[0] else None


def _is_gravity(three: NDArray[np.float64]) -> bool:
    size = float(np.linalg.norm(three.mean(axis=1)))
    return any(low <= size <= high for low, high in GRAVITY) and bool(three.std(axis=1).max() < _SCATTER * size)
