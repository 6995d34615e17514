"""Conditions of runs: temperature, supply voltage and sampling rate. Runs under different conditions are not compared."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING, Literal

from sigmatau.frozen import frozen

if TYPE_CHECKING:
    from sigmatau import Analysis

FactorName = Literal["temperature", "supply", "rate"]

TEMPERATURE_NOTES = ("temperature", "temp")
"""Notes of `analyze` that state the temperature."""

SUPPLY_NOTES = ("supply", "supply voltage", "voltage")
"""Notes of `analyze` that state the supply voltage."""

SUPPLY_CHANNELS = ("supply", "supply_voltage", "vdd", "vcc", "vin", "vbat")
"""Names of a channel of a log with the supply voltage in V."""

KELVIN = 273.15
"""Absolute temperature of 0 °C. [K]"""

_TEMPERATURE = re.compile(r"([-+]?\d+(?:\.\d*)?) *(°C|degC|C|K)?", re.ASCII)
_VOLTAGE = re.compile(r"(\d+(?:\.\d+)?) *(V|mV)?", re.ASCII)
# 3.3V and 3V3 as a part of a name, but not V2, 12Vx or 0x3V
_VOLTAGE_IN_NAME = re.compile(r"(?<![0-9A-Za-z.])(\d{1,2}(?:\.\d{1,3})?)V(\d{0,2})(?![0-9A-Za-z])", re.ASCII)


@frozen
class ConditionFactor:
    """A condition, with the differences that separate groups of its values.

    Attributes
    ----------
    name : {"temperature", "supply", "rate"}
    unit : str
    gap : float
        Smallest difference between two groups. [unit]
    ratio : float
        Smallest ratio of the values of two groups. [1]
    """

    name: FactorName
    unit: str
    gap: float = 0.0
    ratio: float = 1.0

    def groups(self, values: Sequence[float | None]) -> list[str]:
        """The group of each value in words, ``"at 25 °C"``; all are empty if there is only one group. If there are several,
        values that are not stated form a further group.
        """
        stated = [value for value in values if value is not None]
        middles = self.middles(stated)
        if len({*middles}) < 2:
            return [""] * len(values)
        names = {value: f"at {middle:.3g} {self.unit}" for value, middle in zip(stated, middles, strict=True)}
        return [f"at an unknown {self.name}" if value is None else names[value] for value in values]

    def middles(self, values: Sequence[float]) -> list[float]:
        """The middle of the group of each value. [unit]"""
        groups: list[list[float]] = []
        for value in sorted({*values}):
            last = groups[-1][-1] if groups else value
            if groups and (value - last < self.gap or value < self.ratio * last):
                groups[-1].append(value)
            else:
                groups.append([value])
        middles = {value: (group[0] + group[-1]) / 2 for group in groups for value in group}
        return [middles[value] for value in values]


# Differences within which the conditions of a test plan count as equal. A chamber keeps 25 °C within less than 5 K, a
# laboratory supply is within 3 %, clocks of sensors are within 2 %. [Judgement]
TEMPERATURE = ConditionFactor(name="temperature", unit="°C", gap=5.0)
"""Temperature. [degC]"""

SUPPLY = ConditionFactor(name="supply", unit="V", ratio=1.03)
"""Supply voltage. [V]"""

RATE = ConditionFactor(name="rate", unit="Hz", ratio=1.02)
"""Sampling rate. [Hz]"""


def condition_groups(temperatures: Sequence[float | None], supplies: Sequence[float | None]) -> list[str]:
    """The group of each run by temperature and supply voltage in words, ``"at 25 °C at 3.3 V"``, without a condition in
    which the runs do not differ.
    """
    labels = zip(TEMPERATURE.groups(temperatures), SUPPLY.groups(supplies), strict=True)
    return [" ".join(filter(None, pair)) for pair in labels]


def celsius(text: str) -> float | None:
    """Parse a temperature, 25, 25degC or 298K; None for another form. [degC]"""
    match = _TEMPERATURE.fullmatch(text.strip())
    return None if match is None else float(match[1]) - (KELVIN if match[2] == "K" else 0.0)


def volts(text: str) -> float | None:
    """Parse a voltage, 3.3, 3.3V or 3300mV; None for another form. [V]"""
    match = _VOLTAGE.fullmatch(text.strip())
    return None if match is None else float(match[1]) / (1000 if match[2] == "mV" else 1)


def run_temperature(result: Analysis) -> float | None:
    """The temperature in the notes of a result, otherwise the mean of the thermometer of its log. [degC]"""
    notes = _by_key(result.notes)
    for key in TEMPERATURE_NOTES:
        if (degrees := celsius(notes.get(key, ""))) is not None:
            return degrees
    measured = result.source.temperature
    return None if measured is None else measured.mean


def run_supply(result: Analysis) -> float | None:
    """The supply voltage in the notes of a result, otherwise in a channel of its log, otherwise in its name. [V]"""
    notes = _by_key(result.notes)
    for key in SUPPLY_NOTES:
        if (voltage := volts(notes.get(key, ""))) is not None:
            return voltage
    for name in SUPPLY_CHANNELS:
        if name in result.means and result.means[name].unit == "V":
            return result.means[name].value
    return _supply_in_name(result.source.path or "")


def _supply_in_name(log: str) -> float | None:
    """The only voltage in the name of a log: 3.3 of ``SN7_3.3V.csv`` and of ``SN7_3V3.csv``. [V]"""
    matches = _VOLTAGE_IN_NAME.findall(PurePath(log).name.replace("_", " "))
    if len(matches) != 1 or ("." in matches[0][0] and matches[0][1]):
        return None
    whole, decimals = matches[0]
    return float(f"{whole}.{decimals}" if decimals else whole)


def _by_key(notes: Mapping[str, str]) -> dict[str, str]:
    return {key.strip().lower(): text for key, text in notes.items()}
