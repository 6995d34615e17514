"""Columns of text tables as the programs that write them mean them: Sensor Logger and MT Manager."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sigmatau.io.read.formats.preamble import SAMPLE_TIME, unwrapped
from sigmatau.io.read.table import Column, Load, Loaded

_SENSOR_LOGGER = {
    "gyroscope": "gyroscope",
    "gyroscopeuncalibrated": "gyroscope",
    "accelerometer": "accelerometer",
    "accelerometeruncalibrated": "accelerometer",
    "totalacceleration": "accelerometer",
}
_COUNTED = {1_000_000: "us", 10_000: "0.1 ms"}  # what one count of SampleTimeFine is, by counts in a second


def name_sensor_logger(columns: tuple[Column, ...], name: str) -> tuple[tuple[Column, ...], tuple[str, ...]]:
    """Columns of the app Sensor Logger with the sensor in their names: the columns of each file are x, y and z."""
    sensor = _SENSOR_LOGGER.get(name.lower())
    if sensor is None or {"seconds_elapsed", "x", "y", "z"} - {column.name for column in columns}:
        return columns, ()
    full = tuple(replace(c, name=f"{sensor} {c.name}") if c.name in ("x", "y", "z") else c for c in columns)
    return full, (f"x, y, z of the {sensor} by the name of the file, {name}",)


def time_mt_manager(columns: tuple[Column, ...], load: Load, per_second: int) -> tuple[tuple[Column, ...], Load, str]:
    """The columns and their loading with the counter SampleTimeFine as nanoseconds."""
    fine = next(k for k, column in enumerate(columns) if column.name.lower() == SAMPLE_TIME)

    def load_times(wanted: Sequence[int], exact: int | None) -> Loaded:
        loaded = load(wanted, exact)
        counts = loaded.columns.get(fine)
        if counts is None or counts.dtype != np.int64:
            return loaded
        return replace(loaded, columns={**loaded.columns, fine: unwrapped(counts, per_second)})

    counted = _COUNTED[per_second]
    timed = tuple(replace(c, unit="ns", counted=counted) if k == fine else c for k, c in enumerate(columns))
    return timed, load_times, f"SampleTimeFine counts 1/{per_second} s in 32 bits; read as ns"
