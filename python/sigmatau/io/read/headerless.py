"""Tables without names for their columns: which three are the accelerometers is told by gravity.

Six columns, or seven with a time that goes forward in front, of which three have a mean of the size of gravity that hardly
changes and the other three have not: nothing else looks so. Everything else is asked for.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.io.read.table import Table

__all__ = ["by_gravity"]

_LEAST_ROWS = 100
_LOOKED_AT = 100_000
_GRAVITY = ((0.9, 1.1), (9.3, 10.3), (900.0, 1100.0))  # in g, m/s^2 and mg, biases and scale errors allowed for
_STEADY = 0.05  # scatter of an axis over the size of gravity
_OTHERS = 0.2  # size of the other three's mean, over that of gravity: or either could be meant


def by_gravity(table: Table) -> tuple[dict[str, str | int], Finding] | None:
    """Channels of a table whose columns have no names, as ``--channels`` would say them; None if that is not certain.

    Parameters
    ----------
    table : Table
    """
    count = len(table.columns)
    if count not in (6, 7) or any(column.name for column in table.columns):
        return None
    try:
        columns = table.load(list(range(count)), None).columns
    except DataError:  # which is said when the columns are read for good
        return None
    rows = np.stack([np.asarray(columns[k][:_LOOKED_AT], dtype=np.float64) for k in range(count)], axis=1)
    rows = rows[np.isfinite(rows).all(axis=1)]
    if len(rows) < _LEAST_ROWS or (count == 7 and not _forward(rows[:, 0])):
        return None
    first, second = rows[:, count - 6 : count - 3], rows[:, count - 3 :]
    found = [_gravity(three) for three in (first, second)]
    sizes = [float(np.linalg.norm(three.mean(axis=0))) for three in (first, second)]
    which = 0 if found[0] else 1
    if found[0] == found[1] or sizes[1 - which] > _OTHERS * sizes[which]:
        return None
    texts = [f"{count - 5}:{count - 3}", f"{count - 2}:{count}"]
    channels: dict[str, str | int] = {"gyro": texts[1 - which], "accel": texts[which]}
    if count == 7:
        channels = {"time": 1, **channels}
    said = ",".join(f"{channel}={where}" for channel, where in channels.items())
    return channels, Finding(
        code="columns_by_gravity",
        severity="info",
        message=f"the columns have no names; the mean of columns {texts[which]} has the size {sizes[which]:.4g} of gravity,"
        f" that of {texts[1 - which]} is {sizes[1 - which]:.2g}: taken as --channels {said}",
        effect="wrong columns would make wrong sensors",
        remedy=f"say --channels {said} to be sure, or other columns",
    )


def _forward(time: NDArray[np.float64]) -> bool:
    return bool(np.all(np.diff(time) >= 0) and time[-1] > time[0])


def _gravity(three: NDArray[np.float64]) -> bool:
    size = float(np.linalg.norm(three.mean(axis=0)))
    return any(low <= size <= high for low, high in _GRAVITY) and bool(three.std(axis=0).max() < _STEADY * size)
