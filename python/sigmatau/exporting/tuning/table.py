"""Innovations from a text table, with columns identified by name or by the user."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.errors import DataError, OptionError
from sigmatau.exporting.tuning.innovations import Innovations
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.units import find_unit, to_si

_TIMES = {"t", "time", "timestamp", "stamp", "seconds", "sec"}
_INNOVATION = {"innovation", "innovations", "innov", "nu", "residual"}
_VARIANCE = {"s", "variance", "var", "variances", "cov", "covariance"}
_DEVIATION = {"std", "sigma", "stddev", "deviation"}
_RATE = {"rate", "omega"}
_NORMALISED = {"normalised", "normalized", "nis", "nees", "whitened"}
# Unit in brackets: [(m/s)^2] or ((m/s)^2), but not an index [0].
_UNIT = re.compile(r"\s*(?:\[(?!\d+\])([^\]]*)\]|\(((?:[^()]|\([^()]*\))*)\))\s*$")
_SENSORS = {"sensor", "channel", "id", "source", "measurement", "type", "axis", "name", "label"}
_MAX_SENSORS = 16  # largest number of sensors that a column names; a column with more values is a counter
_SECONDS = ("s", "ms", "us", "µs", "ns")
_LONGEST_INTERVAL = 1e4  # longest interval; times with longer intervals are in another unit [s]
_UNNAMED = "innovation"  # name of the channel if the columns name none
_LISTED = 12  # largest number of columns in a message


@frozen
class _Columns:
    """Columns of a channel."""

    innovation: int
    variance: int
    is_deviation: bool
    rate: int | None = None


@frozen(eq=False)
class _Table:
    """Names, units and values of the columns of a table; NaN where a cell is empty."""

    path: Path
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Floats
    lines: tuple[int, ...]
    start: Floats  # first row of all sensors, the origin of the time; shape (1, n_columns)
    sensors: tuple[str, ...] = ()  # sensor of each row, from a column that is not part of the table

    @property
    def listed(self) -> str:
        """List the columns for a message."""
        return ", ".join(self.names[:_LISTED]) + (", …" if len(self.names) > _LISTED else "")

    def index(self, name: str, option: str) -> int:
        """Find a column by its name, or by its number from 1."""
        if name in self.names:
            return self.names.index(name)
        if name.isdigit() and 1 <= int(name) <= len(self.names):
            return int(name) - 1
        raise OptionError(f"{Hint(option)}: no column {name!r}. {self.path} has {self.listed}", option=option)


def read_innovations(
    place: Path, *, columns: Mapping[str, str] | None = None, time: str | None = None
) -> dict[str, Innovations]:
    """Read the innovations of all channels of a table.

    Parameters
    ----------
    place : Path
        Text file with a header; columns are separated by commas, semicolons, tabs or blanks.
    columns : mapping of str to str, optional
        Columns of innovation, variance and optionally the rate of motion by channel, ``"nu:S:rate"``. Default: by their
        names.
    time : str, optional
        Column of the time. Default: by its name.

    Returns
    -------
    dict of str to Innovations

    Raises
    ------
    DataError
        For a table that cannot be read, or innovations that cannot be from a filter.
    OptionError
        For columns that are not recognised, or do not exist.
    """
    result = {}
    for sensor, table in _by_sensor(_read(place)).items():
        for channel, data in _read_channels(table, columns, time).items():
            result[sensor if channel == _UNNAMED and sensor else "_".join(filter(None, [sensor, channel]))] = data
    return result


def _by_sensor(table: _Table) -> dict[str, _Table]:
    """Split the rows by sensor if a column names it; otherwise return all rows without a name."""
    if not table.sensors:
        return {"": table}
    named = np.array(table.sensors)
    lines = np.array(table.lines)
    return {
        sensor: replace(
            table, values=table.values[named == sensor], lines=tuple(lines[named == sensor].tolist()), sensors=()
        )
        for sensor in dict.fromkeys(table.sensors)
    }


def _read_channels(table: _Table, columns: Mapping[str, str] | None, time: str | None) -> dict[str, Innovations]:
    """Read the innovations of all channels of a table of one sensor, or with a pair of columns per channel."""
    place = table.path
    times = _times(table, time)
    chosen = _stated(table, columns) if columns else _recognised(table)
    result = {}
    for channel, places in chosen.items():
        innovation, variance = (table.values[:, k] for k in (places.innovation, places.variance))
        used = ~(np.isnan(innovation) & np.isnan(variance))
        lines = np.array(table.lines)[used]
        for k in (places.innovation, places.variance, places.rate):
            if k is None:
                continue
            wrong = np.flatnonzero(~np.isfinite(table.values[used, k]))
            if wrong.size:
                raise DataError(
                    f"{table.names[k]} is not a finite number. Remove this row", place=f"line {lines[wrong[0]]}"
                ).about(str(place))
        scale, square = _scales(table, places)
        stated = variance[used] * square
        if places.is_deviation:
            stated = np.where(stated > 0, stated**2, stated)
        moments = times[used]
        faults = (
            (np.flatnonzero(stated <= 0), f"{table.names[places.variance]} is not positive. Write S = H·P·Hᵀ + R"),
            (
                1 + np.flatnonzero(np.diff(moments) <= 0),
                "the time does not increase. Sort the rows, remove repeated ones",
            ),
        )
        for wrong, text in faults:
            if wrong.size:
                raise DataError(text, place=f"line {lines[wrong[0]]}").about(str(place))
        try:
            result[channel] = Innovations(
                time=moments,
                innovation=innovation[used] * scale,
                variance=stated,
                rate=_read_rate(table, places)[used] if places.rate is not None else None,
            )
        except DataError as error:
            raise error.about(channel).about(str(place)) from None
    return result


def _read(place: Path) -> _Table:
    try:
        rows = place.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise DataError(f"cannot be read: {error.strerror or error}").about(str(place)) from None
    except UnicodeDecodeError:
        raise DataError("is not text. Write the innovations as CSV with a header").about(str(place)) from None
    numbered = [(k, row.strip()) for k, row in enumerate(rows, 1) if row.strip()]
    if not numbered:
        raise DataError("is empty. Write the innovations as CSV with a header").about(str(place))
    head = numbered[0][1].lstrip("#% ")
    delimiter = next((mark for mark in ",;\t" if mark in head), None)
    cells = [cell.strip().strip('"') for cell in head.split(delimiter)]
    if all(_number(cell) is not None for cell in cells):
        raise DataError(
            "has no header. Name the columns in the first line: t,innovation,S", place=f"line {numbered[0][0]}"
        ).about(str(place))
    values, lines, sensors = list[list[float | None]](), list[int](), list[str]()
    naming = next(
        (k for k, cell in enumerate(cells) if {*_words(cell)} & _SENSORS and {*_words(cell)} <= _SENSORS), None
    )
    for line, row in numbered[1:]:
        if row.startswith(("#", "%")):
            continue
        parts = [cell.strip() for cell in row.split(delimiter)]
        if len(parts) != len(cells):
            raise DataError(
                f"{len(parts)} columns, but the header has {len(cells)}. Correct or remove this row",
                place=f"line {line}",
            ).about(str(place))
        if naming is not None:
            sensors.append(parts[naming].strip('"'))
            parts[naming] = ""
        # A comma is a decimal comma if the delimiter is a semicolon.
        numbers = [_number(part.replace(",", ".") if delimiter == ";" else part) for part in parts]
        wrong = [k for k, number in enumerate(numbers) if number is None]
        if wrong:
            text = row.split(delimiter)[wrong[0]].strip()
            raise DataError(
                f"{cells[wrong[0]]} is not a number: {text!r}. Correct or remove this row", place=f"line {line}"
            ).about(str(place))
        values.append(numbers)
        lines.append(line)
    if len({*sensors}) > _MAX_SENSORS:
        raise DataError(
            f"{cells[naming or 0]} has {len({*sensors})} values, too many for names of sensors. Remove this column"
        ).about(str(place))
    units = tuple((match[1] or match[2] or "").strip() if (match := _UNIT.search(cell)) else "" for cell in cells)
    array = np.array(values, dtype=np.float64).reshape(len(values), len(cells))
    return _Table(
        path=place,
        names=tuple(_UNIT.sub("", cell) for cell in cells),
        units=units,
        values=array,
        lines=tuple(lines),
        start=array[:1],
        sensors=tuple(sensors if naming is None else _sensor_names(cells[naming], sensors)),
    )


def _sensor_names(column: str, sensors: Sequence[str]) -> list[str]:
    """Channel name for the sensor of each row: its text, or for a number the name of the column and the number."""
    return [
        "_".join(_words(sensor)) if _number(sensor) is None else f"{_words(column)[0]}_{sensor}" for sensor in sensors
    ]


def _number(cell: str) -> float | None:
    """Convert a cell to a number; NaN for an empty cell, None for other text."""
    if not cell:
        return float("nan")
    try:
        number = float(cell)
    except ValueError:
        return None
    return number if number == number else float("inf")  # only an empty cell may be NaN


def _times(table: _Table, name: str | None) -> Floats:
    """Convert times to seconds from the first row of the file. Raises `OptionError` for an unknown unit."""
    if name is not None:
        k = table.index(name, "time")
    else:
        matching = [k for k, words in enumerate(map(_words, table.names)) if words and words[0] in _TIMES]
        if len(matching) != 1:
            raise OptionError(
                f"{table.path}: no column is recognised as the time among {table.listed}."
                f" Name it, {Hint('time', value=table.names[0])}",
                option="time",
            )
        (k,) = matching
    words = _words(table.names[k])
    unit = table.units[k] or (words[-1] if words[-1] in _SECONDS and len(words) > 1 else "s")
    if unit not in _SECONDS:
        raise OptionError(
            f"{table.path}: the time has the unit {unit!r}. Use one of {', '.join(_SECONDS)}", option="time"
        )
    times = table.values[:, k]
    wrong = np.flatnonzero(~np.isfinite(times))
    if wrong.size:
        raise DataError(
            f"{table.names[k]} is not a finite number. Remove this row", place=f"line {table.lines[wrong[0]]}"
        ).about(str(table.path))
    seconds = (times - table.start[:, k]) * to_si(1.0, unit)
    if len(seconds) > 1 and (step := float(np.median(np.diff(seconds)))) > _LONGEST_INTERVAL:
        raise OptionError(
            f"{table.path}: the rows of {table.names[k]} are {step:.3g} s apart. Write its unit in the header,"
            f" {table.names[k]} [ns]",
            option="time",
        )
    return seconds


def _recognised(table: _Table) -> dict[str, _Columns]:
    """Recognise pairs of columns by their names, which contain a word for innovation or variance, and the channel."""
    innovations: dict[str, int] = {}
    variances: dict[str, tuple[int, bool]] = {}
    rates: dict[str, int] = {}
    for k, words in enumerate(map(_words, table.names)):
        if words and words[0] in _TIMES:
            continue
        kinds = set(words)
        channel = (
            "_".join(word for word in words if word not in _INNOVATION | _VARIANCE | _DEVIATION | _RATE) or _UNNAMED
        )
        if kinds & (_VARIANCE | _DEVIATION):
            if channel in variances:
                raise _not_recognised(table, f"two columns of the variance of {channel}")
            variances[channel] = (k, not kinds & _VARIANCE)
        elif kinds & _RATE:
            rates[channel] = k
        elif kinds & _INNOVATION:
            if channel in innovations:
                raise _not_recognised(table, f"two columns of the innovation of {channel}")
            innovations[channel] = k
    for channel in innovations:
        if channel not in variances:
            name = table.names[innovations[channel]]
            if {*_words(name)} & _NORMALISED:
                raise OptionError(
                    f"{table.path}: {name} has no column of its variance."
                    " Normalised innovations have the variance 1: add a column S with 1 in each row",
                    option="columns",
                )
            raise _not_recognised(table, f"{name} has no column of its variance S")
    if not innovations:
        raise _not_recognised(table, "no column is recognised as an innovation")
    return {
        channel: _Columns(
            innovation=k,
            variance=variances[channel][0],
            is_deviation=variances[channel][1],
            rate=rates.get(channel),
        )
        for channel, k in innovations.items()
    }


def _not_recognised(table: _Table, what: str) -> OptionError:
    return OptionError(
        f"{table.path}: {what}; it has {table.listed}. Name the columns, {Hint('columns', 'gyro_x', 'INNOVATION:S')}",
        option="columns",
    )


def _stated(table: _Table, columns: Mapping[str, str]) -> dict[str, _Columns]:
    chosen = {}
    for channel, text in columns.items():
        names = text.split(":")
        if len(names) not in (2, 3):
            raise OptionError(
                f"{Hint('columns')} of {channel} must name the innovation and its variance,"
                f" {Hint('columns', channel, 'INNOVATION:S')}, not {text!r}",
                option="columns",
            )
        innovation, variance, *rate = (table.index(name, "columns") for name in names)
        words = {*_words(table.names[variance])} | {*_words(names[1])}
        chosen[channel] = _Columns(
            innovation=innovation,
            variance=variance,
            is_deviation=bool(words & _DEVIATION) and not words & _VARIANCE,
            rate=rate[0] if rate else None,
        )
    return chosen


def _words(name: str) -> Sequence[str]:
    return [word for word in re.split(r"[^a-z0-9µ]+", name.lower()) if word]


def _squares(unit: str) -> set[str]:
    """Spellings of the square of a unit: (m/s)^2, m^2/s^2, rad^2."""
    plain = unit.replace(" ", "")
    parts = "/".join(f"{part}^2" for part in plain.split("/"))
    return {f"({plain})^2", f"{plain}^2", parts}


def _scales(table: _Table, chosen: _Columns) -> tuple[float, float]:
    """Factors to SI of the innovation and of its variance. Raises `OptionError` if only one of them has a unit."""
    unit, stated = table.units[chosen.innovation], table.units[chosen.variance]
    names = table.names[chosen.innovation], table.names[chosen.variance]
    if not unit and not stated:
        return 1.0, 1.0
    if stated.replace("²", "^2").replace(" ", "") not in ({unit} if chosen.is_deviation else _squares(unit)):
        raise OptionError(
            f"{table.path}: {names[0]} has the unit {unit or 'none'!r}, {names[1]} {stated or 'none'!r}."
            f" Write {unit or 'rad'} and ({unit or 'rad'})^2 in the header, or none for SI",
            option="columns",
        )
    if (known_unit := find_unit(unit)) is None:
        raise OptionError(f"{table.path}: {names[0]} has the unknown unit {unit!r}. Write it in SI", option="columns")
    factor = known_unit.factor
    return factor, factor if chosen.is_deviation else factor**2


def _read_rate(table: _Table, chosen: _Columns) -> Floats:
    """Read the rate in SI. Raises `OptionError` unless its unit is that of the innovation per second."""
    assert chosen.rate is not None
    values = table.values[:, chosen.rate]
    unit, stated = table.units[chosen.innovation], table.units[chosen.rate]
    if not unit and not stated:
        return values
    expected, rate_unit = find_unit("m/s^2" if unit == "m/s" else f"{unit or 'rad'}/s"), find_unit(stated)
    if expected is None or rate_unit is None or rate_unit.si != expected.si:
        raise OptionError(
            f"{table.path}: {table.names[chosen.innovation]} has the unit {unit or 'none'!r},"
            f" {table.names[chosen.rate]} {stated or 'none'!r}. Write rad and rad/s, or m/s and m/s^2",
            option="columns",
        )
    return values * rate_unit.factor
