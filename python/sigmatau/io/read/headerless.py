"""Tables without column names: gravity tells which three columns are the accelerometers.

The table must have six columns, or seven with an increasing time first. Three adjacent columns must have a steady mean of
the size of gravity, and the other three must not. In all other cases the user must name the columns.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.reading import ColumnsByGravity
from sigmatau.io.read.table import Table

__all__ = ["by_gravity"]

_MIN_ROWS = 100
_ROWS_TESTED = 100_000
_GRAVITY = ((0.9, 1.1), (9.3, 10.3), (900.0, 1100.0))  # [g, m/s^2, mg], with room for biases and scale errors
_SCATTER = 0.05  # largest standard deviation of an axis, over the size of gravity
_GYRO_MEAN = 0.2  # largest mean of the other three columns, over the size of gravity


def by_gravity(table: Table) -> tuple[dict[str, str | int], Finding] | None:
    """Channels of a table without column names, in the form of ``--channels``; None if they are not certain."""
    count = len(table.columns)
    if count not in (6, 7) or any(column.name for column in table.columns):
        return None
    try:
        columns = table.load(list(range(count)), None).columns
    except DataError:  # raised again when the record is read
        return None
    rows = np.stack([np.asarray(columns[k][:_ROWS_TESTED], dtype=np.float64) for k in range(count)], axis=1)
    rows = rows[np.isfinite(rows).all(axis=1)]
    if len(rows) < _MIN_ROWS or (count == 7 and not _increases(rows[:, 0])):
        return None
    triples = rows[:, count - 6 : count - 3], rows[:, count - 3 :]
    found = [_is_gravity(three) for three in triples]
    sizes = [float(np.linalg.norm(three.mean(axis=0))) for three in triples]
    which = 0 if found[0] else 1
    if found[0] == found[1] or sizes[1 - which] > _GYRO_MEAN * sizes[which]:
        return None
    places = ((count - 5, count - 3), (count - 2, count))
    texts = [f"{first}:{last}" for first, last in places]
    channels: dict[str, str | int] = {"gyro": texts[1 - which], "accel": texts[which]}
    if count == 7:
        channels = {"time": 1, **channels}
    details = ColumnsByGravity(
        gyro=places[1 - which],
        accel=places[which],
        time=1 if count == 7 else None,
        gravity=sizes[which],
        other=sizes[1 - which],
    )
    return channels, Finding(details=details, severity="info")


def _increases(time: NDArray[np.float64]) -> bool:
    return bool(np.all(np.diff(time) >= 0) and time[-1] > time[0])


def _is_gravity(three: NDArray[np.float64]) -> bool:
    size = float(np.linalg.norm(three.mean(axis=0)))
    return any(low <= size <= high for low, high in _GRAVITY) and bool(three.std(axis=0).max() < _SCATTER * size)
