"""Channel and unit of a column by its name.

Only unambiguous names are recognised: a wrong column gives a wrong result without a warning, while an unrecognised column
only costs the user an option. To add a name, add it to a table below and to the table in ``tests/io/test_columns.py``.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau import units
from sigmatau.errors import DataError, OptionError
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.reading import ColumnsByGravity
from sigmatau.io.read.table import Column, Table

# Names are compared in lower case, with ``_`` for spaces, dots, slashes, colons and hyphens, ``[0]`` as ``_x``, and without
# these prefixes.
_PREFIX = re.compile(r"^(?:(?:field|data|msgs?|message|imu\d*|imu_data|imu_raw|sensors?|sensor_combined|values?)_)+")

# Stems before an axis, with or without an underscore: ``gyro_x``, ``gyrox``.
_STEMS = {
    "gyro": (
        "gyros?",
        "gyr",
        "gyr(?:o|oscope)?_?reading",
        "gyroscope",
        "gyroskop|giroscopio|giroscópio",  # phyphox in other languages
        "gyro_fifo",  # PX4
        "angular_?velocity",
        "angular_?rate",
        "ang_?vel",
        "rotation_?rate",
        "omega",
        "rot",
        "w",
        "w_rs_s",  # EuRoC
        "g",  # see _ALONE
        "d_?theta|delta_?theta|d_?angle|delta_?angle",  # increments, see _INCREMENTS
    ),
    "accel": (
        "accel",
        "accl?",
        "acc(?:el|elerometer)?_?reading",
        "accelerometer",
        "accel_fifo",  # PX4
        "acceleration",
        "beschleunigung|accélération|aceleración|accelerazione|aceleração",
        "linear_?acceleration",
        "linear_?accel",
        "lin_?acc",
        "specific_?force",
        "a",  # see _ALONE
        "a_rs_s",  # EuRoC
        "f(?=_)",  # specific force, but not ``fx``
        "d_?vel|delta_?vel|d_?velocity|delta_?velocity|dv|delta_?v",  # increments
    ),
}

# Stems after an axis: ``xgyro`` (MAVLink).
_AFTER_AXIS = {"gyro": "gyro|gyr", "accel": "accel|acc"}

# Axes as numbers, ``accl0`` to ``accl2``: recognised only if all three exist, and no fourth.
_NUMBERED = re.compile(r"(?P<stem>[a-z][a-z_]+?)_?(?P<axis>[0-3])")

# Logs whose columns tell the program that wrote them, with its units.
_OF_PROGRAMS = (
    (
        {"index", "time", "accl0", "accl1", "accl2", "rot0", "rot1", "rot2", "x", "y", "z", "w"},
        {"accel": "g", "gyro": "rad/s", "time": "s"},
    ),
)

# Names of increments.
_INCREMENTS = re.compile(r"^(?:delta_?(?:theta|angle|vel|velocity|v)|d_?(?:theta|angle|vel|velocity)|dv)_?[xyz]")

# ``gx`` may be gravity and ``az`` an azimuth: recognised only if all three axes exist.
_ALONE = re.compile(r"^[ag]_?[xyz]$")

# Time columns by priority: the time stamp of the sensor before that of the receiver.
TIMES = (
    r"sample_?us|time_?stamp_sample",  # ArduPilot, PX4: when the sensor sampled
    r"(?:header_)?stamp|seconds_elapsed|elapsed(?:_time|_seconds)?|time_elapsed",
    r"timeus",  # before T, which is a temperature in ArduPilot's messages
    r"t|time|time_?stamps?|t_(?:host|imu|sensor|sys|rel|mcu)|(?:unix|epoch|sys|system|sensor|host|imu|ros)_?time(?:stamp)?"
    r"|time_(?:boot|since_start|since_boot)|seconds|secs?|epoch|date_?time|date_?time_utc|time_?utc|utc_?time|date_and_time"
    r"|zeit|temps|tiempo|tempo",
    r"log_time",  # of the recorder of an MCAP file or a bag
)
_SECONDS = re.compile(r"^(?:seconds_elapsed|elapsed_seconds|seconds)$")

# One half of a time stamp that is split into two columns.
SPLIT_STAMP = re.compile(r"(?:^|_)(?:n?secs?|nanosec(?:onds)?|usecs?)$")

_KINDS = {"gyro": ("rad/s", "rad"), "accel": ("m/s^2", "m/s"), "time": ("s",)}

# Units as the last part of a name: ``gyro_x_dps``, ``t_ns``.
_SUFFIXES = {
    **dict.fromkeys(("dps", "deg_s", "degps", "deg_per_s", "deg_per_sec", "deg_sec"), "deg/s"),
    **dict.fromkeys(("mdps", "mdeg_s"), "mdeg/s"),
    **dict.fromkeys(("rad_s", "radps", "rads", "rps", "rad_per_s", "rad_per_sec", "rad_sec"), "rad/s"),
    **dict.fromkeys(("mrad_s", "mradps"), "mrad/s"),
    **dict.fromkeys(("dph", "deg_h", "deg_hr", "deg_per_h", "deg_per_hr", "deg_per_hour"), "deg/h"),
    "g": "g",
    "mg": "mg",
    "ug": "ug",
    **dict.fromkeys(("m_s2", "m_s_2", "m_ss", "m_s_s", "mps2", "ms2", "mss", "m_per_s2", "m_s^2", "m_s²"), "m/s^2"),
    **dict.fromkeys(("s", "sec", "secs", "seconds"), "s"),
    **dict.fromkeys(("ms", "msec", "msecs", "millis", "milliseconds"), "ms"),
    **dict.fromkeys(("us", "usec", "usecs", "micros", "microseconds"), "us"),
    **dict.fromkeys(("ns", "nsec", "nsecs", "nanos", "nanoseconds"), "ns"),
}
_SUFFIX = re.compile(
    r"^(?P<stem>.+?)_(?P<unit>"
    + "|".join(sorted(map(re.escape, _SUFFIXES), key=len, reverse=True))
    + r")(?P<axis>_[xyz])?$"
)

# Names whose unit is part of a published format.
_WITH_UNIT = {
    r"gyro_rad_([xyz])": ("gyro", "rad/s"),  # PX4, sensor_combined: "in rad/s"
    r"time_?us(?:ec)?": ("time", "us"),  # ArduPilot TimeUS, MAVLink time_usec
    r"sample_?us": ("time", "us"),  # ArduPilot SampleUS
    r"time_?stamp_sample": ("time", "us"),  # PX4
    r"time_(?:boot_)?ms|timems": ("time", "ms"),  # MAVLink time_boot_ms
    r"millis": ("time", "ms"),  # Arduino's millis()
    r"micros": ("time", "us"),
}

# ``rostopic echo -p`` writes stamps in nanoseconds; and a message with this covariance is a sensor_msgs/Imu, in SI.
_ROSTOPIC = re.compile(r"field\.(?:[\w.]+\.)?header\.stamp")
_ROS_IMU = "field.angular_velocity_covariance0"
_ROS_UNITS = {"gyro": "rad/s", "accel": "m/s^2"}

_BRACKETS = re.compile(r"^(?P<name>.*?)[\s_]*[\[({]\s*(?P<unit>[^\[\](){}]*(?:\([^()]*\)[^\[\](){}]*)?)\s*[\])}]\s*$")
LONGEST_NAME = 200  # Longest column name, with its unit in brackets. [characters]
_LONGEST_END = 40  # longest end of a name that is searched for a unit [characters]
SPELLED = {
    **dict.fromkeys(("degc", "°c", "℃", "c", "celsius", "deg c", "° c", "deg_c", "degrees celsius"), "degC"),
    **dict.fromkeys(("k", "kelvin", "degk", "°k"), "K"),
    **dict.fromkeys(("degf", "°f", "℉", "f", "fahrenheit", "deg f", "deg_f"), "degF"),
}


def unit_of(column: Column) -> tuple[str, str | None]:
    """The name of a column without its unit, and its unit if that is known; as the file spells them."""
    name, unit = column.name.strip(), column.unit
    # The pattern takes quadratic time on text that it does not match, so long names are not matched.
    match = _BRACKETS.match(name) if len(name) <= LONGEST_NAME else None
    if match and match["name"] and not match["unit"].strip().isdigit():
        name = match["name"].strip()
        unit = unit or match["unit"].strip()
    return name, unit if unit and _known(unit) else None


def recognise(columns: Sequence[Column]) -> list[tuple[str, str | None] | None]:
    """The channel of each column, with its unit if the name states one; None for a column that is not recognised.
    Channels are ``gyro_x`` … ``gyro_z``, ``accel_x`` … ``accel_z`` and ``time``.
    """
    keys = [key_of(unit_of(column)[0]) for column in columns]
    by_program = next((known for names, known in _OF_PROGRAMS if names == set(keys)), {})
    keys = _lettered(keys)
    together = {
        key
        for stem in "ag"
        for sep in ("", "_")
        if {f"{stem}{sep}{a}" for a in "xyz"} <= set(keys)
        for key in (f"{stem}{sep}{a}" for a in "xyz")
    }
    found: list[tuple[str, str | None] | None] = []
    of_ros = any(column.name.strip() == _ROS_IMU for column in columns)
    for column, key in zip(columns, keys, strict=True):
        if degrees_of(column):  # T in degrees is a temperature
            found.append(None)
            continue
        stated = unit_of(column)[1]
        if stated is None and _ROSTOPIC.fullmatch(column.name.strip()):
            stated = "ns"
        match = None
        if _clock_in_another_unit(column, key):
            found.append(None)
            continue
        for stem, unit in readings(key, stated):
            if _ALONE.match(stem) and stem not in together and stem == key:
                continue
            channel, own = _channel(stem)
            if channel is None:
                continue
            unit = unit or own
            if unit is None and of_ros and column.name.startswith("field."):
                unit = _ROS_UNITS.get(channel.split("_")[0])
            unit = unit or by_program.get(channel.split("_")[0])
            if unit is None or units.find(unit).si in _KINDS[channel.split("_")[0]]:
                match = (channel, unit)
                break
        found.append(match)
    return found


def _lettered(keys: Sequence[str]) -> list[str]:
    """The keys with the axes 0, 1, 2 of a sensor as x, y, z."""
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
    return text if text and not text.isdigit() else None


def signal_name(column: Column, *, taken: Collection[str]) -> str:
    """A channel name for a column that is not a sensor's, in characters that ``--channels`` accepts; not one of `taken`."""
    name = re.sub(r"\W+", "_", bare_name(column)).strip("_").lower()
    if not name or name.isdigit() or name.startswith(("gyro", "accel", "time")):
        name = f"signal_{name}".rstrip("_")
    return name if name not in taken else next(f"{name}_{k}" for k in range(2, 1000) if f"{name}_{k}" not in taken)


def _clock_in_another_unit(column: Column, key: str) -> bool:
    """Whether a column ``T`` is not a time: it has another unit, or no unit and may be a temperature."""
    text = stated_unit(column)
    if key != "t":
        return False
    if text is None:
        return column.name.strip() == "T"
    return not _known(text) or units.find(text).si != "s"


def holds_increments(column: Column) -> bool:
    """Whether a column has increments, by its name."""
    return _INCREMENTS.match(key_of(unit_of(column)[0])) is not None


def bare_name(column: Column) -> str:
    """The name of a column without the brackets at its end."""
    match = _BRACKETS.match(column.name.strip())
    return match["name"].strip() if match and match["name"] else column.name.strip()


def key_of(name: str) -> str:
    """A name in the form that is compared: in lower case, with underscores, without prefixes."""
    key = re.sub(r"[\[(]([012])[\])]$", lambda m: "_" + "xyz"[int(m[1])], name.strip().lower())
    key = re.sub(r"[\s./:\-]+", "_", key).strip("_")
    return _PREFIX.sub("", key)


def readings(key: str, stated: str | None) -> list[tuple[str, str | None]]:
    """The readings of a name, with and without a unit at its end."""
    readings: list[tuple[str, str | None]] = [(key, stated)]
    match = _SUFFIX.match(key)
    if match:
        readings.append((match["stem"] + (match["axis"] or ""), stated or _SUFFIXES[match["unit"]]))
    return readings


def _channel(key: str) -> tuple[str | None, str | None]:
    for pattern, (sensor, unit) in _WITH_UNIT.items():
        if match := re.fullmatch(pattern, key):
            return (f"{sensor}_{match[1]}" if match.groups() else sensor), unit
    for sensor, stems in _STEMS.items():
        if match := re.fullmatch(f"(?:{'|'.join(stems)})_?([xyz])", key):
            return f"{sensor}_{match[1]}", None
        if match := re.fullmatch(f"([xyz])_?(?:{_AFTER_AXIS[sensor]})", key):
            return f"{sensor}_{match[1]}", None
    if any(re.fullmatch(names, key) for names in TIMES):
        return "time", "s" if _SECONDS.match(key) else None
    return None, None


def _known(spelling: str) -> bool:
    try:
        units.find(spelling)
    except OptionError:
        return False
    return True


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
    rows = np.stack([np.asarray(columns[k][:_ROWS_TESTED], dtype=np.float64) for k in range(count)])
    rows = rows[:, np.isfinite(rows).all(axis=0)]
    if rows.shape[1] < _MIN_ROWS or (count == 7 and not (np.all(np.diff(rows[0]) >= 0) and rows[0, -1] > rows[0, 0])):
        return None
    triples = rows[count - 6 : count - 3], rows[count - 3 :]
    found = [_is_gravity(three) for three in triples]
    sizes = [float(np.linalg.norm(three.mean(axis=1))) for three in triples]
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


def gravity_on_gyro(gyro: Sequence[NDArray[Any]], accel: Sequence[NDArray[Any]]) -> tuple[float, float] | None:
    """Sizes of the means of the two sensors, if gravity is on the gyro and not on the accelerometer; in units of the log."""
    step = max(len(gyro[0]) // _ROWS_TESTED, 1)
    with np.errstate(invalid="ignore"):  # a damaged number may be a signalling NaN
        triples = [np.stack([np.asarray(c[::step], dtype=np.float64) for c in sensor]) for sensor in (gyro, accel)]
    finite = [three[:, np.isfinite(three).all(axis=0)] for three in triples]
    if min(three.shape[1] for three in finite) < _MIN_ROWS or not _is_gravity(finite[0]) or _is_gravity(finite[1]):
        return None
    sizes = [float(np.linalg.norm(three.mean(axis=1))) for three in finite]
    return (sizes[0], sizes[1]) if sizes[1] <= _GYRO_MEAN * sizes[0] else None


def _is_gravity(three: NDArray[np.float64]) -> bool:
    size = float(np.linalg.norm(three.mean(axis=1)))
    return any(low <= size <= high for low, high in _GRAVITY) and bool(three.std(axis=1).max() < _SCATTER * size)


def degrees_of(column: Column) -> str | None:
    """The unit of temperature that a column states; "" for any other unit, None if it states none."""
    in_brackets = re.search(r"[\[({]([^\[\](){}]*)[\])}]\s*$", column.name[-_LONGEST_END:])
    stated = column.unit or (in_brackets[1] if in_brackets else None)
    return SPELLED.get(stated.strip().lower(), "") if stated else None
