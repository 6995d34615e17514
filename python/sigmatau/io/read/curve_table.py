"""Read Allan deviations or variances from the table of another program. A missing statement is a question to the user."""

from __future__ import annotations

import re
from collections.abc import Mapping
from os import PathLike
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau import units
from sigmatau.arrays import Floats
from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.io.read import opened
from sigmatau.io.read.options import ReadOptions
from sigmatau.io.read.small_table import bare_name, column_place, name_words, unit_in
from sigmatau.io.read.table import Table
from sigmatau.record.record import stream_name

Content = Literal["deviation", "variance"]
Sizes = NDArray[np.int64]

_TIMES = {"tau", "taus", "τ", "averaging", "cluster", "period", "t"}
_SECONDS = {"", "s", "sec", "second", "seconds"}
_DEVIATIONS = {"adev", "oadev", "deviation", "adevs", "sigma", "σ", "std"}
_VARIANCES = {"avar", "oavar", "variance", "var", "avars"}
_FURTHER_DEVIATIONS = {
    f"{kind}{end}" for kind in ("m", "om", "h", "oh", "t", "tot", "mtot", "tto", "hto") for end in ("dev", "var")
}
_SQUARE = re.compile(r"\((.+)\)\s*(?:\^2|²)")
_QUANTITIES = {"rad/s": ("angular_rate", "gyro"), "m/s^2": ("acceleration", "accel")}
_SENSORS = {"gyro": "angular_rate", "accel": "acceleration"}
_MULTIPLE = 0.01  # largest distance of an averaging time from a multiple of the sample interval [samples, relative]
_LISTED = 12  # largest number of columns in a message
_LEAST_TIMES = 8


_UNNAMED = ""  # of a column without the name of a channel


@frozen(eq=False)
class TableCurve:
    """The curve of a column: SI unit of the rate, quantity, and Allan variances."""

    unit: str
    quantity: str
    avar: Floats


def read_curve_table(
    path: str | PathLike[str],
    *,
    rate: float,
    samples: int,
    columns: Mapping[str, str] | None = None,
    unit: str | None = None,
    content: Content | None = None,
) -> tuple[Sizes, dict[str, TableCurve]]:
    """Cluster sizes and the curves by channel; parameters and errors as of `sigmatau.read_curves`."""
    with opened(path, ReadOptions()) as (_, tables):
        if len(tables) != 1:
            raise DataError(f"has {len(tables)} tables; write averaging times and deviations as the columns of one")
        (table,) = tables
        places = _chosen(table, dict(columns or {}))
        loaded = table.load(sorted(set(places.values())), None)
        for finding in loaded.findings:
            raise DataError(f"is damaged: {finding}")
        values = {key: np.asarray(loaded.columns[k], dtype=np.float64) for key, k in places.items()}
        times = table.columns[places["tau"]]
        time_unit = unit_in(times.name, times.unit)
        if time_unit.lower() not in _SECONDS:
            raise DataError(f"has averaging times in {time_unit}. Convert them to s")
        sizes = _sizes(table, values.pop("tau"), rate, samples)
        curves = {}
        for key, numbers in values.items():
            column = table.columns[places[key]]
            si, factor, is_squared = _unit(column.name, column.unit, unit, content)
            _check(table, numbers, bare_name(column.name) or key)
            hint = Hint("columns", value={"tau": "1", "signal": "2"})
            name, quantity = named_channel(key, si, hint)
            with np.errstate(over="ignore", under="ignore"):
                avar = numbers * factor**2 if is_squared else (numbers * factor) ** 2
            _check(table, avar, f"the variance of {bare_name(column.name) or key}")
            curves[name] = TableCurve(unit=si, quantity=quantity, avar=avar)
    return sizes, curves


def named_channel(key: str, rate_unit: str, hint: Hint) -> tuple[str, str]:
    """Name and quantity of a channel; `key`: its stated name, or empty. `hint`: how a user names one."""
    if rate_unit not in _QUANTITIES and (key == _UNNAMED or stream_name(key) in _SENSORS):
        signal = f". For another signal, name its column, {hint}" if key == _UNNAMED else ""
        raise OptionError(
            f"{rate_unit!r} is not the unit of a rate. Give one such as deg/h, m/s^2 or ug{signal}",
            option="unit",
        )
    quantity, sensor = _QUANTITIES.get(rate_unit, ("signal", ""))
    name = key or sensor
    if _SENSORS.get(stream_name(name), quantity) != quantity:
        raise OptionError(f"{Hint(hint.option)}: {name} is not a sensor of {rate_unit}", option=hint.option)
    return name, quantity


def rate_unit(text: str) -> tuple[str, float]:
    """SI unit and size of the unit of a rate; an unknown unit stays as it is, for a named channel."""
    unit = units.find_unit(text)
    if unit is None:
        return text, 1.0
    if unit.si not in _QUANTITIES:
        raise OptionError(f"{text!r} is not the unit of a rate. Give one such as deg/h, m/s^2 or ug", option="unit")
    return unit.si, unit.factor


def _chosen(table: Table, columns: dict[str, str]) -> dict[str, int]:
    """Places of the averaging times and of the channels. Raises the question for columns that no name identifies."""
    names = [column.name for column in table.columns]
    listed = ", ".join(name or f"column {k}" for k, name in enumerate(names[:_LISTED], 1))
    places = {key: column_place(names, text, listed) for key, text in columns.items()}
    if "tau" not in places:
        matching = [k for k, name in enumerate(names) if {*_first_words(name)} & _TIMES]
        if len(matching) != 1:
            hint = Hint("columns", value={"tau": "1", "gyro_x": "2"})
            raise OptionError(
                f"has no single column of averaging times: {listed}. Name the columns, e.g. {hint}", option="columns"
            )
        places["tau"] = matching[0]
    if len(places) == 1:
        rest = [k for k in range(len(names)) if k != places["tau"]]
        channels: dict[str, int] = {}
        for k in rest:
            name = _channel(names[k])
            if name and channels.setdefault(name, k) != k:
                hint = Hint("columns", value={name: names[channels[name]]})
                raise OptionError(f"has several columns of {name}: {listed}. Name one, e.g. {hint}", option="columns")
        if channels:
            places |= channels
        elif len(rest) == 1:
            places[_UNNAMED] = rest[0]
        else:
            hint = Hint("columns", value={"gyro_x": names[rest[0]] or str(rest[0] + 1)}) if rest else Hint("columns")
            raise OptionError(
                f"has no column with the name of a channel: {listed}. Name the columns, e.g. {hint}", option="columns"
            )
    if len({*places.values()}) < len(places):
        raise OptionError(f"{Hint('columns')} names a column twice", option="columns")
    return places


def _first_words(name: str) -> list[str]:
    return ["τ"] if name.strip().startswith("τ") else name_words(bare_name(name))[:1]


def _channel(name: str) -> str:
    """The channel in the name of a column, such as gyro_x of ``gyro_x adev [deg/h]``; empty if there is none."""
    match = re.match(r"(gyro|accel)(?:[ _]([xyz]))?\b", bare_name(name).lower())
    return "" if match is None else "_".join(filter(None, match.groups()))


def _sizes(table: Table, tau: Floats, rate: float, samples: int) -> Sizes:
    """Cluster sizes. Raises `DataError`, with the row, for a time that a curve of the record cannot have."""
    with np.errstate(invalid="ignore", over="ignore"):  # a time beyond all records
        m = np.round(tau * rate)
        wrong = (
            (~np.isfinite(tau) | (tau <= 0), "the averaging time is not a positive number. Remove this row"),
            (
                np.diff(tau, prepend=-np.inf) <= 0,
                "the averaging time does not rise. Sort the rows, remove repeated ones",
            ),
            (
                (m < 1) | (np.abs(tau * rate - m) > _MULTIPLE * m),
                f"the averaging time is no multiple of the sample interval, {1 / rate:g} s. Correct the rate",
            ),
            (
                2 * m > samples,
                f"the averaging time exceeds half of the record, {samples / rate / 2:g} s. Correct the length",
            ),
        )
    for rows, text in wrong:
        if rows.any():
            raise DataError(text, place=table.where(int(np.flatnonzero(rows)[0])))
    if len(m) < _LEAST_TIMES:
        raise DataError(f"has {len(m)} averaging times. {_LEAST_TIMES} or more are needed for the coefficients")
    return m.astype(np.int64)


def _unit(name: str, column_unit: str | None, stated: str | None, content: Content | None) -> tuple[str, float, bool]:
    """SI unit of the rate, its size, and whether the values are variances."""
    header = unit_in(name, column_unit)
    match = _SQUARE.fullmatch(header)
    header_unit = match[1] if match else header
    text = stated or header_unit
    if not text:
        hint = Hint("unit", value="deg/h")
        raise OptionError(f"does not state the unit of {name or 'the deviation'}. Give it, e.g. {hint}", option="unit")
    if stated and header_unit and units.find_unit(stated) != units.find_unit(header_unit):
        hint = Hint("unit", value=stated)
        raise OptionError(f"{hint} is not the unit {header!r} of {name}. Leave it out", option="unit")
    is_variance = _is_variance(name, content, has_square=match is not None, has_unit=bool(header))
    return (*rate_unit(text), is_variance)


def _is_variance(name: str, content: Content | None, *, has_square: bool, has_unit: bool) -> bool:
    """Whether a column has variances, by the option or by its name and unit. Raises the question if nothing states it."""
    words = {*name_words(bare_name(name)), *(["σ"] if "σ" in name else [])}
    if words & _FURTHER_DEVIATIONS:
        raise DataError(f"{name} is another deviation. Overlapped Allan deviations are needed")
    is_variance = bool(words & _VARIANCES) or has_square
    is_deviation = not is_variance and (bool(words & _DEVIATIONS) or has_unit)
    if content is None and not (is_variance or is_deviation):
        hints = f"{Hint('content', value='deviation')} or {Hint('content', value='variance')}"
        raise OptionError(
            f"does not state whether {name or 'the column'} has deviations or variances. Give {hints}", option="content"
        )
    if (content == "deviation" and is_variance) or (content == "variance" and bool(words & _DEVIATIONS)):
        hint = Hint("content", value=content)
        raise OptionError(f"{hint} contradicts the column {name}. Leave it out", option="content")
    return is_variance if content is None else content == "variance"


def _check(table: Table, values: Floats, name: str) -> None:
    wrong = ~(np.isfinite(values) & (values > 0))
    if wrong.any():
        raise DataError(
            f"{name} is not a positive number. Remove this row", place=table.where(int(np.flatnonzero(wrong)[0]))
        )
