"""The columns of ``ros2 topic echo --csv`` of `sensor_msgs/Imu`, which has no header."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sigmatau.io.read.table import Column, Load, Loaded

# Fields in the order of the message definition, sensor_msgs/msg/Imu of ROS 2, each matrix of covariances row by row.
_VECTORS = (
    ("orientation", "xyzw", None),
    ("angular_velocity", "xyz", "rad/s"),
    ("linear_acceleration", "xyz", "m/s^2"),
)
_FIELDS = tuple(
    Column(name=name, unit=unit)
    for vector, axes, si in _VECTORS
    for name, unit in (
        *((f"{vector}.{axis}", si) for axis in axes),
        *((f"{vector}_covariance[{k}]", None) for k in range(9)),
    )
)
_STAMP = 3  # columns of the header: seconds, nanoseconds, name of the frame
_UNIT_TOLERANCE = 0.01  # of the length of the quaternion, which drivers round
_NO_ORIENTATION = -1.0  # first covariance of an orientation that is not estimated (definition of the message)
NOTE = "columns of sensor_msgs/Imu, as ros2 topic echo --csv writes them"


def is_imu(columns: Sequence[Column]) -> bool:
    """Whether columns without names are those of the message, by their number and the values of the first row."""
    if len(columns) != _STAMP + len(_FIELDS) or any(column.name for column in columns):
        return False
    first = [column.first for column in columns]
    if not (first[0].isdigit() and first[1].isdigit() and int(first[1]) < 1_000_000_000):
        return False
    numbers = _as_numbers(first[_STAMP:])
    if not numbers:
        return False
    length = math.hypot(*numbers[:4])
    return abs(length - 1) < _UNIT_TOLERANCE or length == 0 or numbers[4] == _NO_ORIENTATION


def _as_numbers(texts: Sequence[str]) -> list[float]:
    try:
        return [float(text) for text in texts]
    except ValueError:
        return []


def named(columns: Sequence[Column], load: Load) -> tuple[tuple[Column, ...], Load]:
    """The columns with their names, the stamp as one column in nanoseconds, and their loading."""

    def load_message(wanted: Sequence[int], exact: int | None) -> Loaded:
        places = {k: k + 1 for k in wanted if k > 0}
        stamp = [0, 1] if 0 in wanted or exact == 0 else []
        loaded = load([*stamp, *places.values()], places.get(exact) if exact else None)
        columns = {k: loaded.columns[place] for k, place in places.items()}
        if stamp:
            seconds, nanoseconds = loaded.columns[0], loaded.columns[1]
            missing = np.isnan(seconds) | np.isnan(nanoseconds)
            parts = [np.where(missing, 0, part).astype(np.int64) for part in (seconds, nanoseconds)]
            columns[0] = np.where(missing, np.iinfo(np.int64).min, parts[0] * 1_000_000_000 + parts[1])
        return replace(loaded, columns=columns)

    fields = tuple(replace(f, first=c.first) for f, c in zip(_FIELDS, columns[_STAMP:], strict=True))
    header = (Column(name="header.stamp", unit="ns"), replace(columns[2], name="header.frame_id"))
    return (*header, *fields), load_message
