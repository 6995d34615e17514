"""Assignment of the columns of a table to channels, as the user names them or else by column names."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import field, replace

from sigmatau import units
from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.io.read.name_tables import NOT_A_CLOCK, SPLIT_STAMP, TIMES
from sigmatau.io.read.names import (
    SPELLED,
    bare_name,
    holds_increments,
    name_key,
    readings,
    recognise,
    sensor_key,
    split_unit,
    temperature_unit,
)
from sigmatau.io.read.table import Column, listing
from sigmatau.io.read.time.dates import is_date
from sigmatau.io.read.time.split_stamps import SplitStamp, find_split_stamps
from sigmatau.record.thermometers import NAMES

_IMU = re.compile(r"imu_?\d{1,3}(?!\d)")


@frozen
class ColumnChoice:
    """The columns that are read, by channel."""

    # Channel to column, counted from 0; the gyro first, then the accelerometer
    channels: dict[str, int] = field(default_factory=dict)
    time: int | None = None  # column of the time stamps
    notes: tuple[str, ...] = ()  # Decisions, listed in the provenance of the record
    temperature: Thermometer | None = None  # The column of the temperature, if it is recognised
    split: SplitStamp | None = None  # Both columns of split time stamps; the first one is also `time`
    # Further columns that look like a time: those not chosen, or the one that `channels` with time=none ignores
    other_times: tuple[int, ...] = ()

    @property
    def columns(self) -> tuple[int, ...]:
        """All columns that are read, except the temperature."""
        times = () if self.time is None else (self.time,)
        return tuple(dict.fromkeys((*self.channels.values(), *times, *(self.split.columns if self.split else ()))))

    @property
    def places(self) -> dict[str, int]:
        """The column of each channel, of the time and of the temperature."""
        places = {} if self.time is None else {"time": self.time}
        places |= {} if self.temperature is None else {"temperature": self.temperature.index}
        return places | self.channels


def choose(
    columns: Sequence[Column],
    asked: Mapping[str, str | int] | None,
    *,
    increments: bool = False,
    ask: Callable[[], OptionError] | None = None,
    without_times: Collection[int] = (),
) -> ColumnChoice:
    """Assign columns to channels, as the user names them or else by column names.

    `asked`: column by channel, see `sigmatau.io.read.read`; `increments`: whether increments are read if a log has rates
    too; `ask`: builds the error that asks the user if no name is known; `without_times`: columns that are not time,
    whatever their name.
    """
    matches = recognise(columns)
    matches, kind_notes = _drop_rates_or_increments(columns, matches, increments=increments)
    without = asked is not None and no_time(columns, asked)
    chosen = ColumnChoice()
    if asked:
        named = _resolve(columns, {c: where for c, where in asked.items() if c.strip() != "time" or not without})
        time = named.pop("time", None)
        if without:
            ignored = find_time(columns, matches, taken=set(named.values()), strict=False).time
            chosen = ColumnChoice(
                notes=("no time stamps, as asked",), other_times=() if ignored is None else (ignored,)
            )
        elif time is not None:
            pairs = (pair for pair in find_split_stamps(columns) if pair.seconds == time and time not in without_times)
            chosen = ColumnChoice(time=time, split=next(pairs, None))
        else:
            chosen = find_time(columns, matches, taken={*named.values(), *without_times}, strict=False)
        sensors = {channel: index for channel, index in named.items() if channel.startswith(("gyro", "accel"))}
        for channel, index in sensors.items():
            twin = next(name for name, where in sensors.items() if where == index)
            if twin != channel:
                raise OptionError(f"column {index + 1} is given twice, for {twin} and for {channel}", option="channels")
        if named:
            return replace(chosen, channels=_ordered(named))
    else:
        chosen = find_time(columns, matches, taken=without_times, strict=True)
    time, notes = chosen.time, (*chosen.notes, *kind_notes)
    channels: dict[str, int] = {}
    for index, match in enumerate(matches):
        if match is None or match[0] == "time" or index == time:
            continue
        channel = match[0]
        if channel in channels:
            first = channels[channel]
            raise OptionError(
                f"columns {first + 1} {columns[first].name!r} and {index + 1} {columns[index].name!r} both look like"
                f" {channel}; choose one and name all channels to read, e.g. {_first_of_each(matches, time)}",
                option="channels",
            )
        channels[channel] = index
    if not channels and len(columns) == 1 and not columns[0].name and time is None:
        return ColumnChoice(channels={"x": 0}, time=None, notes=(*notes, "one column without a name, read as signal x"))
    _refuse_mixed(columns, channels)
    if not channels:
        raise ask() if ask is not None else _unknown_names(columns)
    taken = {index for index, match in enumerate(matches) if match is not None}
    thermometer = find_thermometer(columns, [name_key(bare_name(column)) for column in columns], taken)
    return replace(chosen, channels=_ordered(channels), notes=notes, temperature=thermometer)


def _first_of_each(matches: Sequence[tuple[str, str | None] | None], time: int | None) -> Hint:
    """Names the first column of each channel that is recognised."""
    channels = {} if time is None else {"time": time}
    for index, match in enumerate(matches):
        if match is not None and match[0] != "time":
            channels.setdefault(match[0], index)
    return channels_hint(channels)


def _unknown_names(columns: Sequence[Column]) -> OptionError:
    what = "has no column names" if not any(column.name for column in columns) else "has no column with a known name"
    return OptionError(f"{what} (columns: {listing(columns)}); name them by {{option}}", option="channels")


def channels_hint(channels: Mapping[str, int]) -> Hint:
    """The option that names channels, three consecutive axes as a range: ``time=1,gyro=2:4``."""
    places: dict[str, str | int] = {}
    for channel, index in channels.items():
        sensor = channel.split("_")[0]
        axes = [channels[name] for name in (f"{sensor}_{axis}" for axis in "xyz") if name in channels]
        if len(axes) == len("xyz") and axes == list(range(axes[0], axes[0] + 3)):
            places[sensor] = f"{axes[0] + 1}:{axes[-1] + 1}"
        else:
            places[channel] = index + 1
    return Hint("channels", value=places)


def _drop_rates_or_increments(
    columns: Sequence[Column], matches: list[tuple[str, str | None] | None], *, increments: bool
) -> tuple[list[tuple[str, str | None] | None], tuple[str, ...]]:
    """Remove the increments of channels that also have rates, or the rates if increments are asked for. Return a note
    too.
    """
    kinds = [
        match is not None and match[0] != "time" and holds_increments(columns[i]) for i, match in enumerate(matches)
    ]
    both = {m[0] for m, k in zip(matches, kinds, strict=True) if m and k} & {
        m[0] for m, k in zip(matches, kinds, strict=True) if m and not k
    }
    dropped = [i for i, m in enumerate(matches) if m is not None and m[0] in both and kinds[i] is not increments]
    if not dropped:
        return matches, ()
    names = ", ".join(columns[i].name for i in dropped)
    what = ("rates", "increments") if increments else ("increments", "rates")
    remaining = [None if i in dropped else match for i, match in enumerate(matches)]
    return remaining, (f"{names} not read: {what[0]} of channels that also have {what[1]}",)


def _refuse_mixed(columns: Sequence[Column], channels: Mapping[str, int]) -> None:
    """Raise `OptionError` if the axes of a sensor belong to different IMUs."""
    for sensor in ("gyro", "accel"):
        axes = {channel: index for channel, index in channels.items() if channel.startswith(sensor)}
        devices = {match[0] if (match := _IMU.search(columns[i].name.lower())) else "" for i in axes.values()}
        if len(devices) > 1:
            example = Hint("channels", value={channel: index + 1 for channel, index in axes.items()})
            whose = ", ".join(sorted(device or "no IMU" for device in devices))
            raise OptionError(
                f"the columns of {sensor} belong to several IMUs ({whose}); choose the columns, e.g. {example}",
                option="channels",
            )


def no_time(columns: Sequence[Column], asked: Mapping[str, str | int]) -> bool:
    """Whether the user asks for ``time=none``, and no column has the name ``none``."""
    where = next((where for channel, where in asked.items() if channel.strip() == "time"), None)
    return (
        isinstance(where, str)
        and where.strip().lower() == "none"
        and all(column.name.strip().lower() != "none" for column in columns)
    )


_SENSOR_STAMP = re.compile(TIMES[1])  # the stamp made by the sensor has priority over that made by the receiver


def is_clock(column: Column) -> bool:
    """Whether the unit in the name of an otherwise unknown column makes it a clock: ``Device clock [ms]``."""
    name, unit = split_unit(column)
    return unit is not None and units.find(unit).si == "s" and not NOT_A_CLOCK.search(sensor_key(name))


def find_time(
    columns: Sequence[Column],
    matches: Sequence[tuple[str, str | None] | None],
    *,
    taken: Collection[int],
    strict: bool,
) -> ColumnChoice:
    """Choose the time column, if one is recognised by its name or is the only column of dates.

    `taken`: columns that are something else; `strict`: whether several such columns are an error.
    """
    keys = [sensor_key(split_unit(column)[0]) for column in columns]
    pairs = [pair for pair in find_split_stamps(columns) if not set(pair.columns) & set(taken)]
    halves = [i for i, key in enumerate(keys) if SPLIT_STAMP.search(key) and i not in taken]
    excluded = {*taken, *(index for pair in pairs for index in pair.columns)}
    times = [
        i
        for i, match in enumerate(matches)
        if match is not None and match[0] == "time" and i not in excluded and not (i in halves and len(halves) > 1)
    ]
    if not times and not pairs:
        times = [i for i, column in enumerate(columns) if i not in taken and is_date(column.first)]
        times = times or [i for i in range(len(columns)) if i not in taken and is_clock(columns[i])]
    ranked = [
        [i for i in times if any(re.fullmatch(names, stem) for stem, _ in readings(keys[i], None))] for names in TIMES
    ]
    pair = pairs[0] if len(pairs) == 1 else None
    if pair is not None and not ranked[0]:
        stem = re.sub(r"_?[a-z]+$", "", keys[pair.seconds])
        if _SENSOR_STAMP.fullmatch(stem) or not ranked[1]:
            names = " and ".join(repr(columns[k].name) for k in pair.columns)
            joined = (f"time from {names}, joined",)
            return ColumnChoice(time=pair.seconds, notes=joined, split=pair, other_times=tuple(times))
    best = next((group for group in ranked if group), times if len(times) == 1 else [])
    if len(best) > 1 and strict:
        listed = " and ".join(f"{i + 1} {columns[i].name!r}" for i in best)
        raise OptionError(
            f"columns {listed} both look like time; choose one, e.g. {Hint('channels', 'time', best[0] + 1)}",
            option="channels",
        )
    if len(best) != 1:
        return ColumnChoice()
    further = tuple(i for i in times if i != best[0])
    names = ", ".join(repr(columns[i].name) for i in further)
    notes = (f"time from {columns[best[0]].name!r}, not from {names}",) if further else ()
    return ColumnChoice(time=best[0], notes=notes, other_times=further)


def _ordered(channels: Mapping[str, int]) -> dict[str, int]:
    def rank(channel: str) -> int:
        return 0 if channel.startswith("gyro") else 1 if channel.startswith("accel") else 2

    return dict(sorted(channels.items(), key=lambda item: (rank(item[0]), item[0] if rank(item[0]) < 2 else "")))


def _resolve(columns: Sequence[Column], asked: Mapping[str, str | int]) -> dict[str, int]:
    named: dict[str, int] = {}
    for channel, where in asked.items():
        if not channel.strip():
            raise OptionError(f"{{option}} has a channel without a name (={where})", option="channels")
        for name, index in _places(columns, channel.strip(), where):
            if name in named:
                raise OptionError(f"{name} is given twice in {{option}}", option="channels")
            named[name] = index
    return named


def _places(columns: Sequence[Column], channel: str, where: str | int) -> list[tuple[str, int]]:
    """Expand a channel and its column, or three channels and a range of columns."""
    text = str(where).strip()
    if not isinstance(where, int):
        for same in (
            [i for i, c in enumerate(columns) if c.name.strip() == text],
            [i for i, c in enumerate(columns) if split_unit(c)[0] == text],
            [i for i, c in enumerate(columns) if c.name.strip().lower() == text.lower()],
            [i for i, c in enumerate(columns) if split_unit(c)[0].lower() == text.lower()],
            [i for i, c in enumerate(columns) if c.name.strip() == f"%{text}"],
        ):
            if text and len(same) == 1:
                return [(channel, same[0])]
            if text and len(same) > 1:
                numbers = " and ".join(str(i + 1) for i in same)
                raise OptionError(
                    f"columns {numbers} are both named {text!r}; give the number,"
                    f" e.g. {Hint('channels', channel, same[0] + 1)}",
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


_ONLY_WITH_UNIT = re.compile("t")  # ArduPilot
_SUFFIX = re.compile(r"^(?P<stem>.+?)_(?P<unit>degc|c|celsius|deg_c|k|kelvin|degf|f|fahrenheit|deg_f)$")


@frozen
class Thermometer:
    """The column of a temperature."""

    index: int
    unit: str | None  # None if the log does not state it


def find_thermometer(columns: Sequence[Column], keys: Sequence[str], taken: set[int]) -> Thermometer | None:
    """Find the temperature column by its name and unit; None if there is none or more than one.

    `keys`: names as `sigmatau.io.read.names.name_key` returns them; `taken`: columns that are recognised as something else.
    """
    thermometers: dict[int, list[Thermometer]] = {}
    for index, (column, key) in enumerate(zip(columns, keys, strict=True)):
        if index in taken:
            continue
        unit, stem = temperature_unit(column), key
        if unit is None and (match := _SUFFIX.match(key)):
            stem, unit = match["stem"], SPELLED[match["unit"]]
        if unit == "":
            continue
        for rank, names in enumerate(NAMES):
            if re.fullmatch(names, stem):
                thermometers.setdefault(rank, []).append(Thermometer(index=index, unit=unit))
        if unit and _ONLY_WITH_UNIT.fullmatch(stem):
            thermometers.setdefault(0, []).append(Thermometer(index=index, unit=unit))
    if not thermometers:
        return None
    best = thermometers[min(thermometers)]
    return best[0] if len(best) == 1 else None
