"""The question for units that neither the file nor an option states, with a command for each unit that the values allow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np

from sigmatau import units
from sigmatau.digits import two_digits
from sigmatau.errors import DataError, OptionError
from sigmatau.hints import RATE, Hint
from sigmatau.io.read.gravity import ROWS_TESTED, unit_of_gravity
from sigmatau.io.read.table import Table, all_without_absurd
from sigmatau.record.record import stream_name
from sigmatau.record.streams import InputKind

_OPEN_UNITS: dict[str, dict[InputKind, tuple[str, ...]]] = {
    "gyro": {"rate": ("deg/s", "rad/s"), "increments": ("deg", "rad"), "accumulated": ("deg", "rad")},
    "accel": {"rate": ("m/s^2", "g"), "increments": ("m/s",), "accumulated": ("m/s",)},
}
"""The usual units of a sensor. The values do not distinguish between them."""

_PLACEHOLDER = "UNIT"  # placeholder for a unit that the values do not show; no option accepts it


def ask_for_units(
    table: Table,
    channels: Mapping[str, int],
    missing: Sequence[str],
    kind: InputKind,
    *,
    stated: set[str],
    scaled: set[str],
    lacks: Literal["rate", "unit of time"] | None,
    hint: str,
    column: int | None,
) -> OptionError:
    """Ask for the units of the channels `missing`.

    `stated` are sensors with a channel whose unit is known, so that the unit must be given by channel. `scaled` are
    sensors with a scale, whose numbers do not show the unit. `lacks` is the option that the rate still needs, `hint` a
    remark about the numbers, and `column` the number, from 1, of the only channel without a unit, which may be an
    unnamed gyro.
    """
    asked = {name if stream_name(name) in stated else stream_name(name): stream_name(name) for name in missing}
    gravity = None if "accel" in scaled or kind != "rate" else unit_of_gravity(table, channels)
    accel = (gravity,) if gravity else _OPEN_UNITS["accel"][kind]
    time_hint = f"; add {Hint('unit', 'time', 's')} (or ms, us, ns) too" if lacks == "unit of time" else ""

    def answer(gyro: str, accel: str, remark: str = "") -> str:
        """The options that state all that is missing."""
        by_sensor = {"gyro": gyro, "accel": accel}
        value = {name: by_sensor.get(sensor, "1") for name, sensor in asked.items()}
        units_hint = Hint("unit", value=value, remark=remark)
        return f"{units_hint} {RATE}" if lacks == "rate" else str(units_hint)

    question = f"does not state the unit of {', '.join(missing)}; give e.g. "
    if "gyro" in asked.values():
        noise = None if hint or "gyro" in scaled or kind != "rate" else _noise_of_gyro(table, channels)
        ways = [
            answer(unit, accel[0] if len(accel) == 1 else _PLACEHOLDER, "" if noise is None else _noise_in(unit, noise))
            for unit in _OPEN_UNITS["gyro"][kind]
        ]
    elif "accel" in asked.values():
        ways = [answer("", unit) for unit in accel]
    else:
        as_gyro = f"{Hint('channels', 'gyro', column)} {Hint('unit', 'gyro', 'deg/s')}"
        gyro_hint = f"; if it is a gyro, give {as_gyro}" if column is not None else ""
        return OptionError(
            f"{question}{answer('', '')} (any word; 1 for none){hint}{time_hint}{gyro_hint}", option="unit"
        )
    doubt = ". The values do not show which; see the manual of the sensor" if len(ways) > 1 else ""
    return OptionError(
        f"{question}{' or '.join(ways)}{hint}{time_hint}{doubt}",
        option="unit",
        question=f"does not state the unit of {' and '.join(asked)}{hint}. The values do not show it; see the manual",
    )


def _noise_in(unit: str, noise: float) -> str:
    """Noise of a gyro if its column is in this unit, in words, for comparison with its datasheet."""
    size = noise * units.find(unit).factor / units.find("deg/s").factor
    return f"gyro noise {two_digits(size)} deg/s rms"


def _noise_of_gyro(table: Table, channels: Mapping[str, int]) -> float | None:
    """Standard deviation of the noise of the noisiest gyro axis, from first differences, in the unit of the log.

    None if the columns cannot be loaded or never change.
    """
    axes = [index for channel, index in channels.items() if stream_name(channel) == "gyro"]
    try:
        loaded = dict(all_without_absurd(table.load(axes, None).columns))
    except DataError:  # the error is raised again when the record is read
        return None
    with np.errstate(over="ignore", invalid="ignore"):
        steps = [np.diff(np.asarray(loaded[index][:ROWS_TESTED], dtype=np.float64)) for index in axes]
        spreads = [float(np.nanstd(each)) / np.sqrt(2) for each in steps if np.isfinite(each).any()]
    noise = max(spreads, default=0.0)
    return noise if 0 < noise < np.inf else None
