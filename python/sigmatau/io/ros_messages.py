"""Messages of ROS for a log: rows of an IMU as ``sensor_msgs/Imu`` and ``sensor_msgs/Temperature``, many at a time.

All messages of a topic have the same length, so a structured array has the bytes of all messages: CDR of ROS 2 (OMG DDS-RTPS
2.2, section 10, little-endian), or the serialization of ROS 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.record.thermometers import CELSIUS

FIRST_STAMP = 1_700_000_000
"""Time stamp of the first sample, 2023-11-14 22:13:20 UTC: a stamp of 0 means "not set" in ROS. [s]"""

_LONGEST_RECORD = 1e8  # largest time since the start of a record: three years. Larger values are dates [s]

_GYRO = [f"gyro_{axis}" for axis in "xyz"]
_ACCEL = [f"accel_{axis}" for axis in "xyz"]
_UNITS = {**dict.fromkeys(_GYRO, "rad/s"), **dict.fromkeys(_ACCEL, "m/s^2"), "temperature": CELSIUS}
_FRAME = b"imu_link"
_NANO = 10**9
_RULE = "=" * 80
_HEADER_2 = "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
_TIME_2 = "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
_HEADER_1 = "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"
_IMU = """\
std_msgs/Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance
"""
_QUATERNION = "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
_VECTOR = "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
_TEMPERATURE = "std_msgs/Header header\nfloat64 temperature\nfloat64 variance\n"


def _text(message: str, *parts: str) -> str:
    return f"{_RULE}\n".join([message, *parts])


IMU_ROS2 = _text(_IMU, _HEADER_2, _TIME_2, _QUATERNION, _VECTOR)
"""Definition of ``sensor_msgs/msg/Imu`` of ROS 2."""

# 37 numbers of an Imu: orientation, its covariance, angular velocity, its covariance, linear acceleration, its covariance
_NUMBERS = 37
_VECTORS = {"gyro": 13, "accel": 25}  # position of the vector of each sensor
_COVARIANCE = {
    "orientation": 4,
    "gyro": 16,
    "accel": 28,
}  # position of each covariance, whose first number −1 means "no data"


@frozen
class Topic:
    """A topic of a bag.

    Attributes
    ----------
    name : str
    type : str
        Type as spelled in ROS 1: ``"sensor_msgs/Imu"``.
    columns : tuple of int
        Positions of its columns in the table, after time.
    fields : tuple of int
        Positions of these columns among the numbers of a message.
    numbers : tuple of float
        The numbers of a message, 0 or a constant in the fields of its columns and in those without data.
    definition, definition_1 : str
        The text that defines the message, of ROS 2 and ROS 1.
    md5 : str
        Checksum of the ROS 1 definition.
    """

    name: str
    type: str
    columns: tuple[int, ...]
    fields: tuple[int, ...]
    numbers: tuple[float, ...]
    definition: str
    definition_1: str
    md5: str

    @property
    def type_2(self) -> str:
        """The type as spelled in ROS 2."""
        return self.type.replace("/", "/msg/")


def make_topics(columns: Sequence[tuple[str, str]]) -> list[Topic]:
    """The topics for the columns of a table, the first of which is the time. Raises `DataError` for a column that has no
    field.
    """
    units = dict(columns[1:])
    for name, unit in units.items():
        if name not in _UNITS:
            raise DataError(
                f"a bag has one IMU and a thermometer, and no field for {name}; write .csv, .npy, .npz or .parquet"
            )
        if unit != _UNITS[name]:
            raise DataError(f"a bag has {name} in {_UNITS[name]}, not in {unit}: write rates, or another format")
    position = {name: k for k, (name, _) in enumerate(columns)}
    numbers = [0.0] * _NUMBERS
    numbers[3], numbers[_COVARIANCE["orientation"]] = 1.0, -1.0
    fields: dict[int, int] = {}  # field number of each column
    for sensor, axes in (("gyro", _GYRO), ("accel", _ACCEL)):
        lacking = [name for name in axes if name not in units]
        if len(lacking) == len(axes):
            numbers[_COVARIANCE[sensor]] = -1.0
        elif lacking:
            raise DataError(f"a message has three axes, and there is no {', '.join(lacking)}; write another format")
        else:
            fields |= {position[name]: _VECTORS[sensor] + k for k, name in enumerate(axes)}
    if not fields:
        raise DataError("a bag needs a gyro or an accelerometer of three axes")
    topics = [
        Topic(
            name="/imu",
            type="sensor_msgs/Imu",
            columns=tuple(fields),
            fields=tuple(fields.values()),
            numbers=tuple(numbers),
            definition=IMU_ROS2,
            definition_1=_text(_IMU, _HEADER_1, _QUATERNION, _VECTOR),
            md5="6a62c6daae103f4ff57a132d6f95cec2",
        )
    ]
    if "temperature" in units:
        topics.append(
            Topic(
                name="/imu/temperature",
                type="sensor_msgs/Temperature",
                columns=(position["temperature"],),
                fields=(0,),
                numbers=(0.0, 0.0),
                definition=_text(_TEMPERATURE, _HEADER_2, _TIME_2),
                definition_1=_text(_TEMPERATURE, _HEADER_1),
                md5="ff71b307acdbe7c871a5a6d7ed359100",
            )
        )
    return topics


def make_stamps(time: NDArray[np.float64]) -> NDArray[np.int64]:
    """Time stamps of a bag. Times that are dates, in seconds since 1970, are kept. [ns]"""
    start = 0 if time[0] > _LONGEST_RECORD else FIRST_STAMP
    seconds = np.floor(time)
    return (seconds.astype(np.int64) + start) * _NANO + np.round((time - seconds) * _NANO).astype(np.int64)


def make_messages(
    topic: Topic, piece: Sequence[NDArray[np.float64]], stamps: NDArray[np.int64], *, ros1: bool = False, first: int = 0
) -> NDArray[Any]:
    """Build the messages of a topic as elements of a structured array. `first`: number of earlier messages, for ROS 1."""
    head: list[tuple[str, str]] = [("sec", "<u4"), ("nanosec", "<u4"), ("length", "<u4")]
    if ros1:
        head = [("seq", "<u4"), *head, ("frame", f"S{len(_FRAME)}")]
    else:
        filled = 4 + 8 + len(_FRAME) + 1  # bytes after the header of CDR, from which numbers are aligned to 8
        head = [("mark", "V4"), *head, ("frame", f"S{len(_FRAME) + 1}"), ("filler", f"V{-filled % 8}")]
    dtype = np.dtype([*head, ("numbers", "<f8", (len(topic.numbers),))])
    messages = np.zeros(len(stamps), dtype=dtype)
    messages["sec"], messages["nanosec"] = stamps // _NANO, stamps % _NANO
    messages["length"], messages["frame"] = len(_FRAME) + (not ros1), _FRAME
    if ros1:
        messages["seq"] = np.arange(first, first + len(stamps))
    else:
        messages["mark"] = np.void(b"\0\1\0\0")
    messages["numbers"] = topic.numbers
    for column, place in zip(topic.columns, topic.fields, strict=True):
        messages["numbers"][:, place] = piece[column]
    return messages
