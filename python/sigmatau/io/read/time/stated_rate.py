"""A sampling rate that the user states, against the time stamps of the log or the rate that the file states."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sigmatau import units
from sigmatau.errors import OptionError
from sigmatau.hints import Hint
from sigmatau.io.read.time.plausible import SHORTEST, SLOW, UNITS, is_possible
from sigmatau.record.sampling import RateSource

NOMINAL_RATIO = 1.1
"""Largest ratio of two rates that are one nominal rate by two clocks.

The oscillators of MEMS sensors are within 10 % of their nominal rate, and the rates that a datasheet lists differ by more
(1000 and 1125 Hz). At this ratio a random walk is off by 5 %, which a finding states. A larger ratio is a contradiction.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class RateContradiction:
    """A stated rate and the other rate, which are not one nominal rate."""

    stated: float  # [Hz]
    logged: float  # By the time stamps, or stated by the file. [Hz]
    source: RateSource  # What gives the other one
    sensor: str = ""  # The sensor whose rate is stated; empty if the rate is that of all
    unit: str = ""  # The unit of time in use, if it follows from the stated rate or the size of the stamps
    other_unit: str = ""  # The unit of time in which the stamps give the stated rate; empty if there is none
    names_time: bool = False  # Whether the user named the time column

    def error(self) -> OptionError:
        """The refusal, with both readings and the option for each."""
        logged, stated = f"{self.logged:.6g} Hz", f"{self.stated:.6g} Hz"
        in_unit = f" in {self.unit}" if self.unit else ""
        omit = "omit {option}" + (f" and add {Hint('unit', 'time', self.unit)}" if self.unit else "")
        if self.other_unit:
            use = f"give {Hint('unit', 'time', self.other_unit)}"
        elif self.names_time:
            use = f"put time=none in place of the time column in {Hint('channels')}"
        else:
            use = f"add {Hint('channels', 'time', 'none')}"
        choice = f"For {logged}, {omit}; for {stated}, {use}" if is_possible(self.logged) else f"For {stated}, {use}"
        rate = Hint("rate", self.sensor or None, int(self.stated) if self.stated.is_integer() else self.stated)
        if self.source.kind == "file":
            states = f"the file states, as {self.source}," if self.source.place else "the file states"
        else:
            states = f"the time stamps in column {self.source.place} give"
        return OptionError(f"{states} {logged}{in_unit}, which contradicts {rate}. {choice}", option="rate")


def is_one_nominal_rate(rate: float, reference: float) -> bool:
    """Whether two rates may be one nominal rate by two clocks."""
    return 1 / NOMINAL_RATIO <= rate / reference <= NOMINAL_RATIO


def unit_by_rate(interval: float, typical: float, rate: float) -> str | None:
    """The unit of time in which stamps with the mean `interval` are closest to a rate. None for a counter: its `typical`
    interval is 1, or a tick of 10^-k s gives the rate, as the 0.1 ms of a sensor or the 100 ns of a host.
    """
    unit = min(UNITS, key=lambda name: abs(math.log(rate * interval * units.find(name).factor)))
    if is_one_nominal_rate(1 / (interval * units.find(unit).factor), rate):
        return unit
    ticks = 10.0 ** round(math.log10(rate * interval))
    is_counter = typical.is_integer() and (typical == 1 or is_one_nominal_rate(ticks / interval, rate))
    return None if is_counter else unit


def unit_for(second: float, by_stamps: float, stated: float) -> str:
    """The unit of time in which stamps that give one rate in the unit of `second` give the stated rate; empty if none."""
    sizes = {name: units.find(name).factor for name in UNITS}
    return next(
        (
            name
            for name, size in sizes.items()
            if not math.isclose(size, second) and is_one_nominal_rate(by_stamps * second / size, stated)
        ),
        "",
    )


def is_confirmed(*, by_stamps: float, length: float, other_unit: str, has_stated_unit: bool, is_inertial: bool) -> bool:
    """Whether a stated rate that the stamps contradict is used: no inertial sensor has the rate of the stamps, or few
    have it and another unit of time gives the stated rate. A unit that the user gives is not overridden.
    """
    if has_stated_unit or not is_inertial:
        return False
    is_unusual = by_stamps < SLOW or length < SHORTEST
    return not is_possible(by_stamps) or (is_unusual and bool(other_unit))
