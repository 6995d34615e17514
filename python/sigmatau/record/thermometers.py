"""Recognition of temperatures: by names, units and plausible values."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

CELSIUS = "degC"
"""Unit of a stream of temperatures."""

NAMES = (
    r"temp|temperature|imu_?temp(?:erature)?|(?:sensor|chip|die|internal|int)_temp(?:erature)?|temp(?:erature)?_(?:imu|sensor|chip|die)",
    r"(?:gyro|gyr|gyroscope)_?temp(?:erature)?|temp(?:erature)?_(?:gyro|gyr)",
    r"(?:accel|acc|accelerometer)_?temp(?:erature)?|temp(?:erature)?_(?:accel|acc)",
)
"""Patterns of whole names, the more likely one first: of the whole sensor, of the gyro, of the accelerometer."""

TO_CELSIUS = {"degC": (1.0, 0.0), "K": (1.0, 273.15), "degF": (1 / 1.8, 32.0)}
"""By unit, scale and offset: (value - offset)·scale is in °C."""

PLAUSIBLE = (-90.0, 150.0)
"""Temperatures of electronics that work. [°C]"""


def typical(values: NDArray[np.float64], unit: str) -> float:
    """Median of the numbers in one of the units, without NaN. [°C]"""
    scale, offset = TO_CELSIUS[unit]
    present = values[~np.isnan(values)]
    return (
        (float(np.median(present[:: max(len(present) // 4096, 1)])) - offset) * scale if len(present) else float("nan")
    )


def thermometers(
    by_stream: Mapping[str, Mapping[str, NDArray[np.float64]]], unit: Mapping[str, str]
) -> tuple[dict[str, str], tuple[str, ...]]:
    """Units of the streams that are temperatures by name and values, and notes about the decision.

    If all streams are temperatures, they are the signals to analyse, and count as temperatures only with a unit.
    """
    units, notes = {}, []
    for name, columns in by_stream.items():
        stated = unit.get(name)
        if (
            not any(re.fullmatch(names, name) for names in NAMES)
            or tuple(columns) != (name,)
            or stated not in (None, *TO_CELSIUS)
        ):
            continue
        median = typical(columns[name], stated or CELSIUS)
        if PLAUSIBLE[0] <= median <= PLAUSIBLE[1]:
            units[name] = stated or CELSIUS
            notes += [f"{name}: {CELSIUS} assumed"] if stated is None else []
        elif stated is None:
            notes.append(f"{name}: not a temperature in {CELSIUS} (median {median:.4g}), treated as a signal")
    if len(units) == len(by_stream):
        units = {name: u for name, u in units.items() if name in unit}
        notes = []
    return units, tuple(notes)
