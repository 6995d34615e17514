"""A column that holds a temperature: a stream beside the sensors, for what drifts with it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.io.read.table import Column
from sigmatau.record import MIN_SAMPLES, TEMPERATURE, make_stream
from sigmatau.streams import Stream

if TYPE_CHECKING:
    from sigmatau.io.read.timing import Timing

_LONGEST = 40  # characters at the end of a name that may hold a unit

__all__ = ["Thermometer", "degrees_of", "find_thermometer", "temperature_stream"]

# Names in the form that `sigmatau.io.read.columns` compares them in, the more likely one first: of the whole sensor, of the
# gyro, of the accelerometer.
_NAMES = (
    r"temp|temperature|imu_?temp(?:erature)?|(?:sensor|chip|die|internal|int)_temp(?:erature)?|temp(?:erature)?_(?:imu|sensor|chip|die)",
    r"(?:gyro|gyr|gyroscope)_?temp(?:erature)?|temp(?:erature)?_(?:gyro|gyr)",
    r"(?:accel|acc|accelerometer)_?temp(?:erature)?|temp(?:erature)?_(?:accel|acc)",
)
_ONLY_WITH_UNIT = re.compile("t")  # ArduPilot
_SPELLED = {
    **dict.fromkeys(("degc", "°c", "℃", "c", "celsius", "deg c", "° c", "deg_c", "degrees celsius"), "degC"),
    **dict.fromkeys(("k", "kelvin", "degk", "°k"), "K"),
    **dict.fromkeys(("degf", "°f", "℉", "f", "fahrenheit", "deg f", "deg_f"), "degF"),
}
_SUFFIX = re.compile(r"^(?P<stem>.+?)_(?P<unit>degc|c|celsius|deg_c|k|kelvin|degf|f|fahrenheit|deg_f)$")
_TO_CELSIUS = {"degC": (1.0, 0.0), "K": (1.0, 273.15), "degF": (1 / 1.8, 32.0)}  # (value - offset) * scale
_PLAUSIBLE = (-90.0, 150.0)  # of electronics that work. [°C]


@dataclass(frozen=True, slots=True, kw_only=True)
class Thermometer:
    """The column of a temperature.

    Attributes
    ----------
    index : int
    unit : {"degC", "K", "degF"} or None
        None if the log does not say.
    """

    index: int
    unit: str | None


def degrees_of(column: Column) -> str | None:
    """The unit of temperature that a column states; "" for another unit, None for none."""
    in_brackets = re.search(r"[\[({]([^\[\](){}]*)[\])}]\s*$", column.name[-_LONGEST:])
    stated = column.unit or (in_brackets[1] if in_brackets else None)
    return _SPELLED.get(stated.strip().lower(), "") if stated else None


def find_thermometer(columns: Sequence[Column], keys: Sequence[str], taken: set[int]) -> Thermometer | None:
    """The one column that is a temperature by its name and unit; None if there is none, or no way to tell which.

    Parameters
    ----------
    columns : sequence of Column
    keys : sequence of str
        Their names, without the unit, as `sigmatau.io.read.columns` compares them.
    taken : set of int
        Columns that are something else.
    """
    found: dict[int, list[Thermometer]] = {}
    for index, (column, key) in enumerate(zip(columns, keys, strict=True)):
        if index in taken:
            continue
        unit, stem = degrees_of(column), key
        if unit is None and (match := _SUFFIX.match(key)):
            stem, unit = match["stem"], _SPELLED[match["unit"]]
        if unit == "":
            continue
        for rank, names in enumerate(_NAMES):
            if re.fullmatch(names, stem):
                found.setdefault(rank, []).append(Thermometer(index=index, unit=unit))
        if unit and _ONLY_WITH_UNIT.fullmatch(stem):
            found.setdefault(0, []).append(Thermometer(index=index, unit=unit))
    if not found:
        return None
    best = found[min(found)]
    return best[0] if len(best) == 1 else None


def temperature_stream(
    label: str, found: Thermometer, raw: Mapping[int, NDArray[Any]], timing: Timing, *, missing: bool
) -> tuple[tuple[Stream, ...], str]:
    """The stream, and what is to be said of it; no stream if the numbers are no temperatures. Never refused.

    A thermometer that is read more rarely than the sensors leaves its column empty in between: so many samples are missing.
    """
    column = raw[found.index]
    scale, offset = _TO_CELSIUS[found.unit or "degC"]
    values = column[~np.isnan(column)] if missing else column
    if len(values) < MIN_SAMPLES:
        return (), f"temperature: column {label} holds {len(values)} numbers, too few"
    typical = (float(np.median(values[:: max(len(values) // 4096, 1)])) - offset) * scale
    if not _PLAUSIBLE[0] <= typical <= _PLAUSIBLE[1]:
        unit = found.unit or "degC, which was assumed"
        return (), f"temperature: column {label} is no temperature in {unit} (median {typical:.4g} °C)"
    try:
        stream = make_stream(
            "temperature",
            {"temperature": timing.laid(column)},
            rate=timing.rate,
            unit={"temperature": TEMPERATURE},
            scale={"temperature": scale},
            offset={"temperature": offset},
            grid_source=timing.source,
            start=timing.start,
            jitter=timing.jitter,
            finite=timing.places is None and not missing,
        )
    except DataError as error:
        return (), f"temperature: column {label} is not used: {error}"
    how = "degC assumed" if found.unit is None else found.unit
    return (stream,), f"temperature from column {label}, {how}"
