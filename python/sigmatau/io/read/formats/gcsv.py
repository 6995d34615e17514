"""Logs of Gyroflow, ``.gcsv``: text tables of counts whose scales stand above them.

Source: Gyroflow documentation, "Gyroflow IMU log (.gcsv)", format 1.3: ``tscale`` in seconds, ``gscale`` in rad/s and
``ascale`` in g, each per count.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from sigmatau.io.read.names import recognise
from sigmatau.io.read.table import Column, Load, Loaded

_TITLE = re.compile(rb"(?:\xef\xbb\xbf)?(?:GYROFLOW|CAMERA) IMU LOG\b")
_SCALE = re.compile(rb"^(?P<key>[tga])scale[,;\t ][ \t]*(?P<size>[0-9.eE+-]+)", re.MULTILINE)
_SENSORS = {"t": ("time", "s"), "g": ("gyro", "rad/s"), "a": ("accel", "g")}
_LONGEST_HEAD = 1 << 14  # in which the scales are searched [bytes]
NOTE = "counts times the scales of the head (gcsv)"


@dataclass(frozen=True, slots=True, kw_only=True)
class Scale:
    """Size of a count of a sensor."""

    size: float  # [unit]
    unit: str


def find_scales(head: bytes) -> dict[str, Scale]:
    """The scales of the time, gyro and accelerometer that the head of a log states; empty if it is not one of Gyroflow."""
    if not _TITLE.match(head):
        return {}
    scales: dict[str, Scale] = {}
    for match in _SCALE.finditer(head[:_LONGEST_HEAD]):
        sensor, unit = _SENSORS[match["key"].decode()]
        try:
            size = float(match["size"])
        except ValueError:
            continue
        if np.isfinite(size) and size > 0:
            scales[sensor] = Scale(size=size, unit=unit)
    return scales


def scaled(
    columns: tuple[Column, ...],
    load: Load,
    scales: Mapping[str, Scale],
) -> tuple[tuple[Column, ...], Load]:
    """The columns with their units, and their loading times the scales."""
    sensors = {
        index: scales[match[0].split("_")[0]]
        for index, match in enumerate(recognise(columns))
        if match is not None and match[0].split("_")[0] in scales
    }

    def load_scaled(wanted: Sequence[int], exact: int | None) -> Loaded:
        loaded = load(wanted, None if exact in sensors else exact)
        converted = {i: values * sensors[i].size if i in sensors else values for i, values in loaded.columns.items()}
        return replace(loaded, columns=converted)

    full = tuple(
        replace(column, unit=sensors[index].unit, counted="counts") if index in sensors else column
        for index, column in enumerate(columns)
    )
    return full, load_scaled
