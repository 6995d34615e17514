"""From the names of columns to channels: which column is the x gyro, and in what unit.

A name is recognised only when it is certain, because a wrong column gives a wrong answer without a sign, and an
unrecognised one costs the user an option. To teach a name: add it to one of the tables below, and to the table in
``tests/io/test_columns.py``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from sigmatau import units
from sigmatau.errors import OptionError
from sigmatau.io.read.table import Column, listing
from sigmatau.io.read.thermometer import Thermometer, degrees_of, find_thermometer

__all__ = ["Choice", "choose", "holds_increments", "recognise", "stated_unit", "unit_of"]

# Names are compared in lower case, with ``_`` for spaces, dots, slashes, colons and hyphens, ``[0]`` as ``_x``, and these
# words taken off the front.
_PREFIX = re.compile(r"^(?:(?:field|data|msgs?|message|imu\d*|imu_data|imu_raw|sensors?|sensor_combined|values?)_)+")

# What an axis may follow, with or without an underscore: ``gyro_x``, ``gyrox``.
_STEMS = {
    "gyro": (
        "gyros?",
        "gyr",
        "gyroscope",
        "gyroskop|giroscopio|giroscópio",  # phyphox in other languages
        "gyro_fifo",  # PX4
        "angular_?velocity",
        "angular_?rate",
        "ang_?vel",
        "rotation_?rate",
        "omega",
        "w",
        "w_rs_s",  # EuRoC
        "g",  # see _ALONE
        "d_?theta|delta_?theta|d_?angle|delta_?angle",  # increments, see _INCREMENTS
    ),
    "accel": (
        "accel",
        "acc",
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

# What an axis may stand before: ``xgyro`` (MAVLink).
_AFTER_AXIS = {"gyro": "gyro|gyr", "accel": "accel|acc"}

# Names that say that a column holds increments.
_INCREMENTS = re.compile(r"^(?:delta_?(?:theta|angle|vel|velocity|v)|d_?(?:theta|angle|vel|velocity)|dv)_?[xyz]")

# ``gx`` may be gravity and ``az`` an azimuth, unless the other two axes are there as well.
_ALONE = re.compile(r"^[ag]_?[xyz]$")

# Of two time columns of one file, the one further up is taken: the sensor's own stamp before that of its arrival.
_TIMES = (
    r"sample_?us|time_?stamp_sample",  # ArduPilot, PX4: when the sensor sampled
    r"(?:header_)?stamp|seconds_elapsed|elapsed(?:_time|_seconds)?|time_elapsed",
    r"timeus",  # before T, which is a temperature in ArduPilot's messages
    r"t|time|time_?stamps?|t_(?:host|imu|sensor|sys|rel|mcu)|(?:unix|epoch|sys|system|sensor|host|imu|ros)_?time(?:stamp)?"
    r"|time_(?:boot|since_start|since_boot)|seconds|secs?|epoch|date_?time|date_?time_utc|time_?utc|utc_?time|date_and_time"
    r"|zeit|temps|tiempo|tempo",
    r"log_time",  # of the recorder of an MCAP file or a bag
)
_SECONDS = re.compile(r"^(?:seconds_elapsed|elapsed_seconds|seconds)$")

# Half of a stamp is no stamp.
_SPLIT_STAMP = re.compile(r"(?:^|_)(?:n?secs?|nanosec(?:onds)?|usecs?)$")

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
_LONGEST_NAME = 200
_WHOSE = re.compile(r"imu_?\d{1,3}(?!\d)")


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """Which columns are used, and for what.

    Attributes
    ----------
    channels : dict
        Channel to column, counted from 0; sensors together, gyro first.
    time : int or None
        The column of the stamps.
    notes : tuple of str
        What was decided on the way, in words.
    temperature : Thermometer or None
        A temperature beside the sensors, which nobody asked for.
    """

    channels: dict[str, int]
    time: int | None
    notes: tuple[str, ...] = ()
    temperature: Thermometer | None = None


def unit_of(column: Column) -> tuple[str, str | None]:
    """The name of a column without its unit, and the unit if there is one that is known; as the file spells both."""
    name, unit = column.name.strip(), column.unit
    # The pattern takes the square of the length of what it fails on: no name with a unit is so long.
    match = _BRACKETS.match(name) if len(name) <= _LONGEST_NAME else None
    if match and match["name"] and not match["unit"].strip().isdigit():
        name = match["name"].strip()
        unit = unit or match["unit"].strip()
    return name, unit if unit and _known(unit) else None


def recognise(columns: Sequence[Column]) -> list[tuple[str, str | None] | None]:
    """The channel that each column is, with its unit if the name says one; None for a column that is not recognised.

    Channels are ``gyro_x`` … ``gyro_z``, ``accel_x`` … ``accel_z`` and ``time``.
    """
    keys = [_key(unit_of(column)[0]) for column in columns]
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
        if degrees_of(column):  # T in degrees is no time
            found.append(None)
            continue
        stated = unit_of(column)[1]
        if stated is None and _ROSTOPIC.fullmatch(column.name.strip()):
            stated = "ns"
        match = None
        if _clock_in_another_unit(column, key):
            found.append(None)
            continue
        for stem, unit in _readings(key, stated):
            if _ALONE.match(stem) and stem not in together and stem == key:
                continue
            channel, own = _channel(stem)
            if channel is None:
                continue
            unit = unit or own
            if unit is None and of_ros and column.name.startswith("field."):
                unit = _ROS_UNITS.get(channel.split("_")[0])
            if unit is None or units.find(unit).si in _KINDS[channel.split("_")[0]]:
                match = (channel, unit)
                break
        found.append(match)
    return found


def stated_unit(column: Column) -> str | None:
    """What the file says in brackets behind a name, or in its row of units, whether it is a unit that is known or not."""
    match = _BRACKETS.match(column.name.strip()) if len(column.name) <= _LONGEST_NAME else None
    said = column.unit or (match["unit"].strip() if match and match["name"] else None)
    return said if said and not said.isdigit() else None


def _clock_in_another_unit(column: Column, key: str) -> bool:
    """``T [degC]`` is no time, and a bare ``T`` in upper case is a temperature as often as a time."""
    said = stated_unit(column)
    if key != "t":
        return False
    if said is None:
        return column.name.strip() == "T"
    return not _known(said) or units.find(said).si != "s"


def holds_increments(column: Column) -> bool:
    """Whether the name of a column says that it holds increments."""
    return _INCREMENTS.match(_key(unit_of(column)[0])) is not None


def choose(columns: Sequence[Column], asked: Mapping[str, str | int] | None) -> Choice:
    """Channels by the user's word, or else by the names of the columns.

    Parameters
    ----------
    columns : sequence of Column
    asked : mapping, optional
        Channel to column, see `sigmatau.io.read.read`.

    Raises
    ------
    OptionError
        If a column that was asked for is not there, two columns claim one channel, or no channel is found.
    """
    found = recognise(columns)
    without = asked is not None and no_time(columns, asked)
    if asked:
        named = _resolve(columns, {c: where for c, where in asked.items() if c.strip() != "time" or not without})
        time = named.pop("time", None)
        notes: tuple[str, ...] = ("no time stamps, as asked",) if without else ()
        if time is None and not without:
            time, notes = _time(columns, found, taken=set(named.values()), strict=False)
        sensors = {channel: index for channel, index in named.items() if channel.startswith(("gyro", "accel"))}
        for channel, index in sensors.items():
            twin = next(other for other, where in sensors.items() if where == index)
            if twin != channel:
                raise OptionError(f"column {index + 1} is given twice, for {twin} and for {channel}", option="channels")
        if named:
            return Choice(channels=_ordered(named), time=time, notes=notes)
    else:
        time, notes = _time(columns, found, taken=set(), strict=True)
    channels: dict[str, int] = {}
    for index, match in enumerate(found):
        if match is None or match[0] == "time" or index == time:
            continue
        channel = match[0]
        if channel in channels:
            first = channels[channel]
            raise OptionError(
                f"columns {first + 1} {columns[first].name!r} and {index + 1} {columns[index].name!r} both look like"
                f" {channel}; say which is meant, e.g. --channels {channel}={first + 1}, with all other channels wanted",
                option="channels",
            )
        channels[channel] = index
    if not channels and len(columns) == 1 and not columns[0].name and time is None:
        return Choice(channels={"x": 0}, time=None, notes=(*notes, "one column without a name: a signal x"))
    _refuse_mixed(columns, channels)
    if not channels:
        what = "has no column names" if not any(c.name for c in columns) else "has no column with a known name"
        raise OptionError(
            f"{what} (columns: {listing(columns)}); say which column is what, e.g. --channels {_example(columns)}",
            option="channels",
        )
    taken = {index for index, match in enumerate(found) if match is not None}
    thermometer = find_thermometer(columns, [_key(_bare_name(column)) for column in columns], taken)
    return Choice(channels=_ordered(channels), time=time, notes=notes, temperature=thermometer)


def _bare_name(column: Column) -> str:
    """Without what stands in brackets at its end, be it a unit that is known or not."""
    match = _BRACKETS.match(column.name.strip())
    return match["name"].strip() if match and match["name"] else column.name.strip()


def _refuse_mixed(columns: Sequence[Column], channels: Mapping[str, int]) -> None:
    """The axes of one sensor are not those of two units."""
    for sensor in ("gyro", "accel"):
        axes = {channel: index for channel, index in channels.items() if channel.startswith(sensor)}
        found = {match[0] if (match := _WHOSE.search(columns[i].name.lower())) else "" for i in axes.values()}
        if len(found) > 1:
            example = ",".join(f"{channel}={index + 1}" for channel, index in axes.items())
            whose = ", ".join(sorted(one or "no unit" for one in found))
            raise OptionError(
                f"{sensor} would be made of {whose}; say which columns are meant, e.g. --channels {example}",
                option="channels",
            )


def no_time(columns: Sequence[Column], asked: Mapping[str, str | int]) -> bool:
    """Whether ``time=none`` is asked for, and no column is called so."""
    where = next((where for channel, where in asked.items() if channel.strip() == "time"), None)
    return (
        isinstance(where, str)
        and where.strip().lower() == "none"
        and all(column.name.strip().lower() != "none" for column in columns)
    )


def _key(name: str) -> str:
    key = re.sub(r"[\[(]([012])[\])]$", lambda m: "_" + "xyz"[int(m[1])], name.strip().lower())
    key = re.sub(r"[\s./:\-]+", "_", key).strip("_")
    return _PREFIX.sub("", key)


def _readings(key: str, stated: str | None) -> list[tuple[str, str | None]]:
    """The ways to read a name: as it is, and with its end as a unit."""
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
    if any(re.fullmatch(names, key) for names in _TIMES):
        return "time", "s" if _SECONDS.match(key) else None
    return None, None


def _time(
    columns: Sequence[Column],
    found: Sequence[tuple[str, str | None] | None],
    *,
    taken: set[int],
    strict: bool,
) -> tuple[int | None, tuple[str, ...]]:
    """The time column, if one is recognised and no other use is made of it."""
    keys = [_key(unit_of(column)[0]) for column in columns]
    halves = [k for k in keys if _SPLIT_STAMP.search(k)]
    times = [
        i
        for i, match in enumerate(found)
        if match is not None and match[0] == "time" and i not in taken and not (keys[i] in halves and len(halves) > 1)
    ]
    for names in _TIMES:
        best = [i for i in times if any(re.fullmatch(names, stem) for stem, _ in _readings(keys[i], None))]
        if len(best) > 1:
            if not strict:
                return None, ()
            listed = " and ".join(f"{i + 1} {columns[i].name!r}" for i in best)
            raise OptionError(
                f"columns {listed} both look like time; say which is meant, e.g. --channels time={best[0] + 1}",
                option="channels",
            )
        if best:
            others = [columns[i].name for i in times if i != best[0]]
            note = f"time from {columns[best[0]].name!r}, not from {', '.join(map(repr, others))}" if others else ""
            return best[0], (note,) if note else ()
    return (times[0] if len(times) == 1 else None), ()


def _ordered(channels: Mapping[str, int]) -> dict[str, int]:
    def rank(channel: str) -> int:
        return 0 if channel.startswith("gyro") else 1 if channel.startswith("accel") else 2

    return dict(sorted(channels.items(), key=lambda item: (rank(item[0]), item[0] if rank(item[0]) < 2 else "")))


def _resolve(columns: Sequence[Column], asked: Mapping[str, str | int]) -> dict[str, int]:
    named: dict[str, int] = {}
    for channel, where in asked.items():
        if not channel.strip():
            raise OptionError(f"a channel without a name was asked for (={where})", option="channels")
        for name, index in _places(columns, channel.strip(), where):
            if name in named:
                raise OptionError(f"{name} is given twice in --channels", option="channels")
            named[name] = index
    return named


def _places(columns: Sequence[Column], channel: str, where: str | int) -> list[tuple[str, int]]:
    """One channel and its column, or three for a range."""
    text = str(where).strip()
    if not isinstance(where, int):
        for same in (
            [i for i, c in enumerate(columns) if c.name.strip() == text],
            [i for i, c in enumerate(columns) if unit_of(c)[0] == text],
            [i for i, c in enumerate(columns) if c.name.strip().lower() == text.lower()],
            [i for i, c in enumerate(columns) if unit_of(c)[0].lower() == text.lower()],
        ):
            if text and len(same) == 1:
                return [(channel, same[0])]
            if text and len(same) > 1:
                numbers = " and ".join(str(i + 1) for i in same)
                raise OptionError(
                    f"columns {numbers} are both named {text!r}; give the number, e.g. --channels {channel}={same[0] + 1}",
                    option="channels",
                )
    if re.fullmatch(r"\d{1,9}", text):
        return [(channel, _number(columns, int(text)))]
    if match := re.fullmatch(r"(\d{1,9})\s*:\s*(\d{1,9})", text):
        first, last = int(match[1]), int(match[2])
        if last - first != 2:
            raise OptionError(
                f"{channel}={text}: a range names the three columns x, y, z, e.g. {channel}={first}:{first + 2}",
                option="channels",
            )
        if channel == "time":
            raise OptionError(f"time={text}: time is one column", option="channels")
        return [(f"{channel}_{axis}", _number(columns, first + k)) for k, axis in enumerate("xyz")]
    raise OptionError(f"has no column {text!r} (columns: {listing(columns)})", option="channels")


def _number(columns: Sequence[Column], number: int) -> int:
    if not 1 <= number <= len(columns):
        raise OptionError(f"has no column {number} (columns: {listing(columns)})", option="channels")
    return number - 1


def _example(columns: Sequence[Column]) -> str:
    n = len(columns)
    if n >= 7:
        return "time=1,gyro=2:4,accel=5:7"
    if n == 6:
        return "gyro=1:3,accel=4:6"
    return "gyro=1:3" if n >= 3 else f"gyro_z={n}"


def _known(spelling: str) -> bool:
    try:
        units.find(spelling)
    except OptionError:
        return False
    return True
