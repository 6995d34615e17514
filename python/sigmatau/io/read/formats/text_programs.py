"""Rates, scales, units and names that the writer of a text table states above it or implies by its columns."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sigmatau.frozen import frozen
from sigmatau.io.read.names import recognise
from sigmatau.io.read.table import Column, Load, Loaded
from sigmatau.record.sampling import RateSource

_SENSOR_LOGGER = {
    "gyroscope": "gyroscope",
    "gyroscopeuncalibrated": "gyroscope",
    "accelerometer": "accelerometer",
    "accelerometeruncalibrated": "accelerometer",
    "totalacceleration": "accelerometer",
}
_COUNTED = {1_000_000: "us", 10_000: "0.1 ms"}  # unit of a count of SampleTimeFine, by counts per second


def name_sensor_logger(columns: tuple[Column, ...], name: str) -> tuple[tuple[Column, ...], tuple[str, ...]]:
    """Add the sensor to the names of the columns of the app Sensor Logger, which are x, y and z in each file."""
    sensor = _SENSOR_LOGGER.get(name.lower())
    if sensor is None or {"seconds_elapsed", "x", "y", "z"} - {column.name for column in columns}:
        return columns, ()
    full = tuple(replace(c, name=f"{sensor} {c.name}") if c.name in ("x", "y", "z") else c for c in columns)
    return full, (f"x, y, z of the {sensor} by the name of the file, {name}",)


def time_mt_manager(columns: tuple[Column, ...], load: Load, per_second: int) -> tuple[tuple[Column, ...], Load, str]:
    """Load the counter SampleTimeFine as nanoseconds."""
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


_GCSV_TITLE = re.compile(rb"(?:\xef\xbb\xbf)?(?:GYROFLOW|CAMERA) IMU LOG\b")
_GCSV_SCALE = re.compile(rb"^(?P<key>[tga])scale[,;\t ][ \t]*(?P<size>[0-9.eE+-]+)", re.MULTILINE)
_GCSV_SENSORS = {"t": ("time", "s"), "g": ("gyro", "rad/s"), "a": ("accel", "g")}
_LONGEST_HEAD = 1 << 14  # beginning of a file in which the scales are searched [bytes]
GCSV_NOTE = "counts times the scales of the head (gcsv)"


@frozen
class Scale:
    """Size of a count of a sensor."""

    size: float  # [unit]
    unit: str


def find_scales(head: bytes) -> dict[str, Scale]:
    """Find the scales of time, gyro and accelerometer in the head of a log of Gyroflow; empty for other logs."""
    if not _GCSV_TITLE.match(head):
        return {}
    scales: dict[str, Scale] = {}
    for match in _GCSV_SCALE.finditer(head[:_LONGEST_HEAD]):
        sensor, unit = _GCSV_SENSORS[match["key"].decode()]
        try:
            size = float(match["size"])
        except ValueError:
            continue
        if np.isfinite(size) and size > 0:
            scales[sensor] = Scale(size=size, unit=unit)
    return scales


def scale_columns(
    columns: tuple[Column, ...],
    load: Load,
    scales: Mapping[str, Scale],
) -> tuple[tuple[Column, ...], Load]:
    """Add units to the columns, and multiply them by the scales when they are loaded."""
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
_STAMP = 3  # number of columns of the header: seconds, nanoseconds, name of the frame
_UNIT_TOLERANCE = 0.01  # largest deviation of the length of a quaternion from 1, because drivers round
_NO_ORIENTATION = -1.0  # first covariance of an orientation that is not estimated (definition of the message)
ROS_CSV_NOTE = "columns of sensor_msgs/Imu, as ros2 topic echo --csv writes them"


def is_imu(columns: Sequence[Column]) -> bool:
    """Whether unnamed columns are those of the message, judged by their number and the values of the first row."""
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


def name_imu(columns: Sequence[Column], load: Load) -> tuple[tuple[Column, ...], Load]:
    """Name the columns of the message, and join its stamp into one column in nanoseconds."""

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


_RATE = (  # re.IGNORECASE
    r"\b(?P<name>(?:update|output|sampl(?:e|ing)|data|logging)[ _]?(?:rate|frequency|freq))\b"
    r"[ \t]*(?:\((?P<before>hz)\)|\[hz\])?[\"' \t:=,;]{0,9}(?P<rate>\d+(?:\.\d+)?)[ \t\"',;]{0,3}(?P<behind>hz\b)?"
)
SAMPLE_TIME = "sampletimefine"
_WRAP = 1 << 32  # counts of SampleTimeFine, an unsigned 32-bit counter (Xsens, MT Low Level Communication Protocol)
# Counts in a second: 10 kHz in the MT series (the same source), 1 MHz in Movella DOT (its BLE services specification).
_COUNTS_PER_SECOND = (10_000, 1_000_000)
_RATE_TOLERANCE = 0.01  # relative tolerance of the counts between two rows, which are whole numbers
_ROWS = 20  # number of rows whose counts are compared with the stated rate; fewer cannot show a regular interval


# Units of MT Manager's exports, which do not state them: Xsens, MT Manager User Manual, table of exported data.
_MT_MANAGER_UNITS = {"acc_": "m/s^2", "gyr_": "rad/s"}


@frozen
class StatedRate:
    """A sampling rate that a line above the table states with its unit."""

    rate: float  # [Hz]
    source: RateSource


def find_rate(lines: Sequence[tuple[int, str]]) -> StatedRate | None:
    """Find the sampling rate in Hz that the numbered lines state; None if no line states it, or if lines contradict each
    other.
    """
    stated: dict[float, StatedRate] = {}
    for number, text in lines:
        match = re.search(_RATE, text, re.IGNORECASE) if "hz" in text.lower() else None
        if match is None or not (match["before"] or match["behind"] or "[hz]" in match[0].lower()):
            continue
        rate = float(match["rate"])
        if rate > 0:
            source = RateSource(kind="file", place=match["name"], line=number)
            stated.setdefault(rate, StatedRate(rate=rate, source=source))
    return next(iter(stated.values())) if len(stated) == 1 else None


def units_of_mt_manager(
    lines: Sequence[tuple[int, str]], names: Sequence[str], units: Sequence[str | None]
) -> tuple[str | None, ...]:
    """Units of the columns, including those of MT Manager's manual if a numbered line names that program."""
    if not any("MT Manager" in text for _, text in lines):
        return tuple(units)
    return tuple(unit or _MT_MANAGER_UNITS.get(name.lower()[:4]) for name, unit in zip(names, units, strict=True))


def counts_per_second(counts: Sequence[float], rate: float) -> int | None:
    """Counts of SampleTimeFine per second, from the counts of the first rows and the stated rate.

    None if the counts are irregular or fit neither of the two clocks.
    """
    values = np.asarray(counts, dtype=np.float64)
    if len(values) < _ROWS or not np.isfinite(values).all():
        return None
    interval = float(np.median(np.mod(np.diff(values), _WRAP)))
    return next((c for c in _COUNTS_PER_SECOND if abs(interval * rate / c - 1) < _RATE_TOLERANCE), None)


def unwrapped(counts: NDArray[np.int64], per_second: int) -> NDArray[np.int64]:
    """Unwrap a 32-bit counter, and convert its counts to nanoseconds. Missing counts, the smallest 64-bit integer, stay
    missing.
    """
    missing = counts == np.iinfo(np.int64).min
    present = counts[~missing]
    turns = np.cumsum(np.diff(present, prepend=present[:1]) < -(_WRAP // 2))
    times = np.full(len(counts), np.iinfo(np.int64).min)
    times[~missing] = (present + turns * _WRAP) * (1_000_000_000 // per_second)
    return times
