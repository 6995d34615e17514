"""Recognition of the channel and unit of a column from its name.

Only unambiguous names are recognised: a wrong column gives a wrong result without a warning, while an unrecognised column
only costs the user an option. The names are in the tables of `sigmatau.io.read.name_tables`.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

from sigmatau import units
from sigmatau.frozen import frozen
from sigmatau.io.read.name_tables import (
    AFTER_AXIS,
    ANGLE_INCREMENTS,
    BY_MESSAGE,
    DESCRIPTORS,
    DESIRED_VELOCITY,
    INCREMENTS,
    NOT_A_SENSOR,
    OTHER_VECTORS,
    PHONE_NAMES,
    PREFIXES,
    PROGRAMS,
    ROS_IMU,
    ROS_PATH,
    ROS_UNITS,
    ROSTOPIC_STAMP,
    SECONDS,
    SENSOR_PREFIXES,
    SENSOR_WORDS,
    STEMS,
    SUFFIXES,
    TIMES,
    UNIT_ENDS,
    WITH_UNIT,
    WITHOUT_GRAVITY,
    Program,
)
from sigmatau.io.read.table import Column

_KINDS = {"gyro": ("rad/s", "rad"), "accel": ("m/s^2", "m/s"), "time": ("s",)}

_PREFIX = re.compile(f"^(?:(?:{PREFIXES})_)+")
_SENSOR_PREFIX = re.compile(f"^(?:(?:{PREFIXES}|{'|'.join(SENSOR_PREFIXES)})_)+")
_SUFFIX = re.compile(rf"_(?:{SUFFIXES})$|(?<=_[xyz])out$")  # ACCEL_XOUT of InvenSense

# Axes as numbers, ``accl0`` to ``accl2``: recognised only if all three exist, and no fourth.
_NUMBERED = re.compile(r"(?P<stem>[a-z][a-z_]+?)_?(?P<axis>[0-3])")

# ``gx`` may be gravity and ``az`` an azimuth: recognised only if all three axes exist.
_ALONE = re.compile(r"^[ag]_?[xyz]$")

_UNIT_END = re.compile(
    r"^(?P<stem>.+?)(?:_in)?_(?P<unit>"
    + "|".join(sorted(map(re.escape, UNIT_ENDS), key=len, reverse=True))
    + r")(?P<axis>_[xyz])?$"
)

# A name with an axis but no known stem, ``X (rad/s)``: the unit identifies the sensor.
_AXIS_OF_NAME = re.compile(r"(?P<stem>.*?)_?(?P<axis>[xyz])")
_BY_KIND = {"rad/s": "gyro", "m/s^2": "accel"}
_AXIS_WORD = re.compile(r"_?axis(?=_|$)|(?<=^)axis_")
_SEPARATOR = re.compile(r"[./:]")
_BY_STEM = {
    sensor: (re.compile(f"(?:{'|'.join(stems)})_?([xyz])"), re.compile(f"([xyz])_?(?:{AFTER_AXIS[sensor]})"))
    for sensor, stems in STEMS.items()
}

# Content of brackets that is an axis or a number, and not a unit: ``Gyroscope (z)``, ``gyro[0]``.
_AXIS_IN_BRACKETS = re.compile(r"\d+|[xyzXYZ]")
_LETTERS = dict(zip("012", "xyz", strict=True))
_BRACKETS = re.compile(r"^(?P<name>.*?)[\s_]*[\[({]\s*(?P<unit>[^\[\](){}]*(?:\([^()]*\)[^\[\](){}]*)?)\s*[\])}]\s*$")
LONGEST_NAME = 200  # Longest column name, with its unit in brackets. [characters]
_LONGEST_END = 40  # length of the end of a name that is searched for a unit [characters]
SPELLED = {
    **dict.fromkeys(("degc", "°c", "℃", "c", "celsius", "deg c", "° c", "deg_c", "degrees celsius"), "degC"),
    **dict.fromkeys(("k", "kelvin", "degk", "°k"), "K"),
    **dict.fromkeys(("degf", "°f", "℉", "f", "fahrenheit", "deg f", "deg_f"), "degF"),
}


def split_unit(column: Column) -> tuple[str, str | None]:
    """Split the name of a column into the name and a known unit, as the file spells them."""
    name, unit = column.name.strip(), column.unit
    # The pattern takes quadratic time on text that it does not match, so long names are not matched.
    match = _BRACKETS.match(name) if len(name) <= LONGEST_NAME else None
    if match and match["name"] and not _AXIS_IN_BRACKETS.fullmatch(match["unit"].strip()):
        name = match["name"].strip()
        unit = unit or DESCRIPTORS.get(match["unit"].strip().lower(), match["unit"].strip())
    return name, unit if unit and units.find_unit(unit) else None


Match = tuple[str, str | None]
"""A channel, and its unit if the name or the program states it."""


def recognise(columns: Sequence[Column]) -> list[Match | None]:
    """The channel of each column, with its unit if the name states one; None for a column that is not recognised.
    Channels are ``gyro_x`` … ``gyro_z``, ``accel_x`` … ``accel_z`` and ``time``.
    """
    keys = [sensor_key(split_unit(column)[0]) for column in columns]
    names = set(keys)
    program = next((each for each in PROGRAMS if each.keys == names), None)
    keys = _lettered(keys)
    # Beside the g-force of Physics Toolbox, ax is an acceleration without gravity.
    short = ("g", "g_") if {"gfx", "gfy", "gfz"} <= names else ("a", "a_", "g", "g_")
    log = _Log(
        complete=frozenset(stem for stem in short if {stem + axis for axis in "xyz"} <= set(keys)),
        program=program,
        ros_imu=any(column.name.strip() == ROS_IMU for column in columns),
        ros_paths=_is_ros_imu(columns),
        phone=not any(key.startswith("angular_vel") for key in keys),
        angle_increments=any(map(ANGLE_INCREMENTS.match, keys)),
    )
    matches = [_match(column, key, log) for column, key in zip(columns, keys, strict=True)]
    return _by_unit_of_axes(columns, keys, _without_linear(keys, matches))


@frozen
class _Log:
    """Facts about all columns of a log that decide the meaning of a single name."""

    complete: frozenset[str]  # Short stems for which all three axes exist
    program: Program | None
    ros_imu: bool  # Whether the columns are those of ``rostopic echo -p``
    ros_paths: bool  # Whether the log has both vectors of a sensor_msgs/Imu as paths
    phone: bool  # Whether linear accelerations are without gravity, as on phones
    angle_increments: bool  # Whether the log has increments of angle

    def unit(self, column: Column, sensor: str) -> str | None:
        """The unit of a sensor or of the time that the program or message implies."""
        name = column.name.strip()
        if self.program is not None and sensor in self.program.units:
            return self.program.units[sensor]
        if self.ros_imu and name.startswith("field.") and sensor in ROS_UNITS:
            return ROS_UNITS[sensor]
        if self.ros_paths and ROS_PATH.fullmatch(name):
            return ROS_UNITS[sensor]
        return next((units.get(sensor) for pattern, units in BY_MESSAGE.items() if re.fullmatch(pattern, name)), None)


def _match(column: Column, key: str, log: _Log) -> Match | None:
    """Find the channel of a column from its name, the unit in the name, and the other columns."""
    name, stated = split_unit(column)
    if temperature_unit(column) or _clock_in_another_unit(column, key) or (log.phone and PHONE_NAMES.match(name)):
        return None
    if not log.angle_increments and DESIRED_VELOCITY.match(key):
        return None
    if log.program is not None and key in log.program.channels:
        channel = log.program.channels[key]
        return channel, stated or log.program.units[channel.split("_")[0]]
    if stated is None and ROSTOPIC_STAMP.fullmatch(name):
        stated = "ns"
    for stem, unit_of_stem in (*readings(key, stated), *((end, stated) for end in _ends_of_path(name))):
        if _ALONE.match(stem) and stem[:-1] not in log.complete and stem == key:
            continue
        meant, by_format = _channel(stem)
        if meant is None or (meant == "time" and stem not in _stems(key)):
            continue
        sensor = meant.split("_")[0]
        unit = unit_of_stem or by_format or log.unit(column, sensor)
        if unit is None or units.find(unit).si in _KINDS[sensor]:
            return meant, unit
    return None


def _stems(key: str) -> tuple[str, ...]:
    """The possible stems of a key, without units."""
    return tuple(stem for stem, _ in readings(key, None))


def _ends_of_path(name: str) -> tuple[str, ...]:
    """The last two parts of a path, and the last, as keys: ``/imu/data_raw/gyro/x`` gives ``gyro_x``."""
    parts = _SEPARATOR.split(name)
    if len(parts) < 2 or re.search(OTHER_VECTORS, name):
        return ()
    ends = (sensor_key("_".join(parts[-2:])), sensor_key(parts[-1]))
    return tuple(end for end in ends if not INCREMENTS.match(end))


def _is_ros_imu(columns: Sequence[Column]) -> bool:
    """Whether the columns have both vectors of a sensor_msgs/Imu, as paths with one root."""
    vectors: dict[str, set[str]] = {}
    for column in columns:
        if match := ROS_PATH.fullmatch(column.name.strip()):
            root = column.name.strip()[: match.start("vector")]
            vectors.setdefault(root, set()).add(match["vector"] + match["axis"])
    return any(len(vector) == 6 for vector in vectors.values())  # two vectors of three axes


def _without_linear(keys: Sequence[str], matches: list[Match | None]) -> list[Match | None]:
    """Remove the matches of linear accelerations for which a plain accelerometer has the same channel."""
    linear = [
        match is not None and WITHOUT_GRAVITY.fullmatch(key) is not None
        for key, match in zip(keys, matches, strict=True)
    ]
    plain = {match[0] for match, drop in zip(matches, linear, strict=True) if match is not None and not drop}
    return [
        None if drop and match is not None and match[0] in plain else match
        for match, drop in zip(matches, linear, strict=True)
    ]


def _by_unit_of_axes(columns: Sequence[Column], keys: Sequence[str], matches: list[Match | None]) -> list[Match | None]:
    """Add matches of three axes that only their unit identifies: rad/s for a gyro, m/s^2 for an accelerometer.

    Nothing is added for a sensor that is recognised by name, or if two triples have such a unit.
    """
    triples: dict[str, dict[str, dict[str, int]]] = {"gyro": {}, "accel": {}}
    for index, (column, key, match) in enumerate(zip(columns, keys, matches, strict=True)):
        axis = None if match is not None else _AXIS_OF_NAME.fullmatch(key)
        if axis is None or re.search(NOT_A_SENSOR, column.name):
            continue
        unit = split_unit(column)[1]
        sensor = None if unit is None else _BY_KIND.get(units.find(unit).si)
        if sensor is not None:
            triples[sensor].setdefault(axis["stem"] or "", {})[axis["axis"]] = index
    completed = list(matches)
    for sensor, by_stem in triples.items():
        full = [axes for axes in by_stem.values() if len(axes) == len("xyz")]
        if len(full) != 1 or any(match is not None and match[0].startswith(sensor) for match in matches):
            continue
        for axis_name, index in full[0].items():
            completed[index] = f"{sensor}_{axis_name}", split_unit(columns[index])[1]
    return completed


def _lettered(keys: Sequence[str]) -> list[str]:
    """Replace the axes 0, 1, 2 of a sensor by x, y, z in the keys."""
    axes: dict[str, set[str]] = {}
    matches = [_NUMBERED.fullmatch(key) for key in keys]
    for match in matches:
        if match:
            axes.setdefault(match["stem"], set()).add(match["axis"])
    return [
        f"{match['stem']}_{'xyz'[int(match['axis'])]}" if match and axes[match["stem"]] == set("012") else key
        for key, match in zip(keys, matches, strict=True)
    ]


def stated_unit(column: Column) -> str | None:
    """The text in brackets after a name, or in the row of units, whether it is a known unit or not."""
    match = _BRACKETS.match(column.name.strip()) if len(column.name) <= LONGEST_NAME else None
    text = column.unit or (match["unit"].strip() if match and match["name"] else None)
    return text if text and not _AXIS_IN_BRACKETS.fullmatch(text) else None


def signal_name(column: Column, *, taken: Collection[str]) -> str:
    """A channel name for a column that is not a sensor's, in characters that ``--channels`` accepts; not one of `taken`."""
    name = re.sub(r"\W+", "_", bare_name(column)).strip("_").lower()
    if not name or name.isdigit() or name.startswith(("gyro", "accel", "time")):
        name = f"signal_{name}".rstrip("_")
    return name if name not in taken else next(f"{name}_{k}" for k in range(2, 1000) if f"{name}_{k}" not in taken)


def _clock_in_another_unit(column: Column, key: str) -> bool:
    """Whether a column ``T`` is not a time: it has another unit, or it has no unit and may be a temperature."""
    text = stated_unit(column)
    if key != "t":
        return False
    if text is None:
        return column.name.strip() == "T"
    unit = units.find_unit(text)
    return unit is None or unit.si != "s"


def holds_increments(column: Column) -> bool:
    """Whether a column has increments, by its name."""
    return INCREMENTS.match(name_key(split_unit(column)[0])) is not None


def names_sensor(column: Column) -> str:
    """The sensor that the unit or a word in the name of a column suggests, "gyro" or "accel"; empty for none."""
    name, unit = split_unit(column)
    if len(name) > LONGEST_NAME or re.search(NOT_A_SENSOR, name):
        return ""
    if unit is not None:
        return _BY_KIND.get(units.find(unit).si, "")
    return next((sensor for sensor, words in SENSOR_WORDS.items() if words.search(name)), "")


def bare_name(column: Column) -> str:
    """The name of a column without the brackets at its end."""
    match = _BRACKETS.match(column.name.strip())
    if match is None or not match["name"] or _AXIS_IN_BRACKETS.fullmatch(match["unit"].strip()):
        return column.name.strip()
    return match["name"].strip()


def name_key(name: str) -> str:
    """The form of a name that is compared: lower case, with underscores, without prefixes."""
    key = re.sub(r"[\[(]([012xyz])[\])]$", lambda m: " " + _LETTERS.get(m[1], m[1]), name.strip().lower())
    key = re.sub(r"[\s./:%\-]+", "_", key).strip("_")
    return _PREFIX.sub("", key)


def sensor_key(name: str) -> str:
    """Remove the prefixes and suffixes around the key of a sensor."""
    key = _SUFFIX.sub("", _SENSOR_PREFIX.sub("", name_key(name)))
    return _AXIS_WORD.sub("", key) if "axis" in key else key


def readings(key: str, stated: str | None) -> list[tuple[str, str | None]]:
    """The possible readings of a name, with and without a unit at its end."""
    readings: list[tuple[str, str | None]] = [(key, stated)]
    match = _UNIT_END.match(key)
    if match:
        readings.append((match["stem"] + (match["axis"] or ""), stated or UNIT_ENDS[match["unit"]]))
    return readings


def _channel(key: str) -> tuple[str | None, str | None]:
    """The channel that a key means, and the unit that its format states."""
    for pattern, (sensor, unit) in WITH_UNIT.items():
        if match := re.fullmatch(pattern, key):
            return (f"{sensor}_{match[1]}" if match.groups() else sensor), unit
    for sensor, patterns in _BY_STEM.items():
        if match := next(filter(None, (pattern.fullmatch(key) for pattern in patterns)), None):
            return f"{sensor}_{match[1]}", None
    if any(re.fullmatch(names, key) for names in TIMES):
        return "time", "s" if SECONDS.match(key) else None
    return None, None


def temperature_unit(column: Column) -> str | None:
    """The unit of temperature that a column states; "" for any other unit, None if it states none."""
    in_brackets = re.search(r"[\[({]([^\[\](){}]*)[\])}]\s*$", column.name[-_LONGEST_END:])
    stated = column.unit or (in_brackets[1] if in_brackets else None)
    return SPELLED.get(stated.strip().lower(), "") if stated else None
