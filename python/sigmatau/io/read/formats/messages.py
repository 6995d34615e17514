"""Definitions of ROS messages, as columns and as steps for the compiled decoder.

A definition is text: one type and name per line, then the definitions of the types that it uses, each after a line of ``=``
and ``MSG: package/Type``. A column is named by the path of its field (``angular_velocity.x``). Strings and sequences do not
become columns.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.io.read.table import Column

# Type, count (-1: a sequence), first column (-1: none); see crates/formats/src/ros/steps.rs
Step = tuple[str, int, int]
LOG_TIME = "log_time [ns]"  # The time stamp that the recorder gave to a message
_NUMBERS = {
    "bool": "u1",
    "char": "u1",
    "uint8": "u1",
    "int8": "i1",
    "uint16": "u2",
    "int16": "i2",
    "uint32": "u4",
    "int32": "i4",
    "uint64": "u8",
    "int64": "i8",
    "float32": "f4",
    "float64": "f8",
}
_ROS1 = {**_NUMBERS, "byte": "i1", "time": "utime", "duration": "duration"}
_ROS2 = {**_NUMBERS, "byte": "u1", "builtin_interfaces/Time": "time", "builtin_interfaces/Duration": "duration"}

# Units by type and field, from the definitions of these packages; they hold for all parts of the field.
_UNITS = {
    ("sensor_msgs/Imu", "angular_velocity"): "rad/s",
    ("sensor_msgs/Imu", "linear_acceleration"): "m/s^2",
    ("px4_msgs/SensorGyro", "x"): "rad/s",
    ("px4_msgs/SensorGyro", "y"): "rad/s",
    ("px4_msgs/SensorGyro", "z"): "rad/s",
    ("px4_msgs/SensorAccel", "x"): "m/s^2",
    ("px4_msgs/SensorAccel", "y"): "m/s^2",
    ("px4_msgs/SensorAccel", "z"): "m/s^2",
    ("px4_msgs/SensorCombined", "gyro_rad"): "rad/s",
    ("px4_msgs/SensorCombined", "accelerometer_m_s2"): "m/s^2",
    ("px4_msgs/VehicleImu", "delta_angle"): "rad",
    ("px4_msgs/VehicleImu", "delta_velocity"): "m/s",
}
_STAMPS = {"time": "ns", "utime": "ns", "duration": "ns"}

# Limits, so that a damaged definition costs little.
_ARRAY_COLUMNS = 64  # longest array that is read; a longer one is a map or an image
_COLUMNS = 2000
_STEPS = 20_000
_DEPTH = 24

_SEPARATOR = re.compile(r"^={20,}\s*$", re.MULTILINE)
_FIELD = re.compile(
    r"^(?P<type>[A-Za-z][\w/]*)(?:<=\d+)?(?P<array>\[(?P<bound><=)?(?P<count>\d*)\])?\s+(?P<name>[A-Za-z]\w*)\s*(?P<rest>.*)$"
)


@frozen
class MessageLayout:
    """A message as columns."""

    columns: tuple[Column, ...]  # The last column is `LOG_TIME`
    steps: tuple[Step, ...]  # For the decoder


@frozen
class _Field:
    """A field of a definition."""

    type: str
    name: str
    count: int | None  # None for a single value, -1 for a sequence


@dataclass(slots=True)
class _Builder:
    """Columns and steps of a message while its definition is followed."""

    types: Mapping[str, tuple[_Field, ...]]
    ros1: bool
    columns: list[Column] = field(default_factory=list)
    steps: list[Step] = field(default_factory=list)
    open: bool = False  # whether the offsets of further fields are unknown

    @property
    def numbers(self) -> Mapping[str, str]:
        """The types of numbers."""
        return _ROS1 if self.ros1 else _ROS2

    def add_message(self, name: str, path: str, unit: str | None, *, depth: int, columns: bool) -> None:
        """Add the fields of a message. Without `columns`, the decoder skips them."""
        if name not in self.types:
            raise DataError(f"the definition of {name} is missing")
        if depth > _DEPTH or len(self.steps) > _STEPS:
            raise DataError(f"the definition of {name} is too deep or too long")
        fields = self.types[name]
        if not fields and not self.ros1:
            self.steps.append(("u1", 1, -1))  # in ROS 2 an empty structure takes one byte
        for part in fields:
            if self.open:
                return
            unit_of_field = _UNITS.get((name, part.name), unit)
            if (
                unit_of_field is None
                and name.startswith("px4_msgs/")
                and part.name in ("timestamp", "timestamp_sample")
            ):
                unit_of_field = "us"
            self._add_field(
                part, self._resolve(part.type, name), path + part.name, unit_of_field, depth, columns=columns
            )

    def _resolve(self, name: str, within: str) -> str:
        """The full name of a type; a name without a package is of the same package."""
        name = _short(name)
        if name in self.numbers or name in ("string", "wstring") or "/" in name:
            return name
        return "std_msgs/Header" if name == "Header" else f"{within.split('/')[0]}/{name}"

    def _add_field(self, part: _Field, kind: str, path: str, unit: str | None, depth: int, *, columns: bool) -> None:
        count = 1 if part.count is None else part.count
        columns = columns and 0 <= count <= _ARRAY_COLUMNS
        if kind == "wstring":
            self.open = True  # its width depends on the middleware
        elif kind == "string":
            self.steps.append(("string", count, -1))
        elif kind in self.numbers:
            word = self.numbers[kind]
            first = -1
            if columns and len(self.columns) + count <= _COLUMNS:
                first = len(self.columns)
                bracket = f" [{_STAMPS.get(word, unit)}]" if _STAMPS.get(word, unit) else ""
                elements = [""] if part.count is None else [f"[{k}]" for k in range(count)]
                self.columns += [Column(name=f"{path}{element}{bracket}") for element in elements]
            self.steps.append((word, count, first))
        elif part.count is None:
            self.add_message(kind, f"{path}.", unit, depth=depth + 1, columns=columns)
        elif columns and len(self.steps) < _STEPS // 10:
            for k in range(count):
                self.add_message(kind, f"{path}[{k}].", unit, depth=depth + 1, columns=True)
        else:
            self.steps.append(("[", count, -1))
            self.add_message(kind, f"{path}.", unit, depth=depth + 1, columns=False)
            self.steps.append(("]", 0, -1))
            if self.open and count != 0:
                # The offset is lost within the loop, so the loop and all after it are dropped.
                start = max(i for i, step in enumerate(self.steps) if step[0] == "[")
                del self.steps[start:]


def find_columns(definition: str, type_name: str, *, ros1: bool) -> MessageLayout:
    """Columns and steps of a message.

    `definition` is the text, with the definitions of the types that it uses. `type_name` is ``sensor_msgs/msg/Imu`` or
    ``sensor_msgs/Imu``. `ros1` states whether the definition is of ROS 1, where ``time`` is a type.
    """
    name = _short(type_name)
    builder = _Builder(types=_types(definition, name), ros1=ros1)
    builder.add_message(name, "", None, depth=0, columns=True)
    if builder.open:
        builder.steps.append(("?", 0, -1))
    builder.steps.insert(0, ("log_time", 1, len(builder.columns)))
    builder.columns.append(Column(name=LOG_TIME))
    return MessageLayout(columns=tuple(builder.columns), steps=tuple(builder.steps))


def _types(definition: str, name: str) -> dict[str, tuple[_Field, ...]]:
    types: dict[str, tuple[_Field, ...]] = {}
    for number, section in enumerate(_SEPARATOR.split(definition)):
        lines = section.strip().splitlines()
        full_name = name
        if lines and lines[0].startswith("MSG:"):
            full_name = _short(lines[0].removeprefix("MSG:").strip())
            lines = lines[1:]
        elif number > 0:
            raise DataError(f"the definition of {name} has a part without a name")
        types.setdefault(full_name, tuple(f for f in (_field(line, full_name) for line in lines) if f is not None))
    return types


def _field(line: str, within: str) -> _Field | None:
    text = line.strip()
    if not text or text.startswith("#"):
        return None
    match = _FIELD.match(text)
    if match is None:
        raise DataError(f"the definition of {within} has an invalid line: {text[:60]!r}")
    if match["rest"].startswith("="):
        return None  # a constant
    count = None if not match["array"] else -1 if match["bound"] or not match["count"] else int(match["count"][:20])
    if count is not None and count >= 1 << 31:
        raise DataError(f"the definition of {within} has an array of {count} elements")
    return _Field(type=match["type"], name=match["name"], count=count)


def _short(name: str) -> str:
    return name.replace("/msg/", "/")
