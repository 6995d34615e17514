"""Units of time implied by the stamps, sample numbers in place of stamps, and implausible rates and lengths of logs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau import units
from sigmatau.errors import OptionError
from sigmatau.findings.finding import Finding
from sigmatau.findings.rates import ImplausibleRate
from sigmatau.frozen import frozen
from sigmatau.hints import RATE, Hint
from sigmatau.record.sampling import RateSource
from sigmatau.record.streams import PLAUSIBLE_RATES

UNITS = ("s", "ms", "us", "ns")
_RARE_UNITS = ("min", "h", "d")
_EPOCH = (9.4e8, 2.3e9)  # years 1999 to 2042, counted from 1970. [s]
_EXCEL_DAYS = (36161, 52232)  # years 1999 to 2042, counted from 1899 as in Excel. [d]
_MATLAB_DAYS = (730120, 746191)  # years 1999 to 2042, counted from year 0 as in MATLAB. [d]
SHORTEST = 1.0  # length of a log; a shorter one is refused if another unit makes its length usual [s]
_MIN_SAMPLES = 100  # a log with fewer samples may be an excerpt, and is accepted however short
SLOW = 1.0  # rate below which a log contains averages or its unit of time is wrong [Hz]
_FREQUENT = 100.0  # typical rate of logs: units with the closest rate are offered first [Hz]
_FIRST_NUMBERS = (0, 1)  # possible numbers of the first sample of a log
_SENSORS = {"gyro": "a gyro", "accel": "an accelerometer"}
_ROUNDING = 1e-6  # relative difference up to which two rates belong to one unit


@frozen
class RateByUnit:
    """Rate and length of a log in a unit of time."""

    unit: str
    rate: float  # [Hz]
    length: float  # [s]

    @property
    def is_possible(self) -> bool:
        """Whether a gyro or accelerometer may have this rate."""
        return is_possible(self.rate)

    @property
    def is_usual(self) -> bool:
        """Whether a log of a gyro or accelerometer usually has such a rate and length."""
        return self.is_possible and self.rate >= SLOW and self.length >= SHORTEST

    @property
    def distance_from_frequent(self) -> float:
        """Distance of the rate from that of most logs, as the logarithm of a ratio."""
        return abs(math.log(self.rate / _FREQUENT))

    def __str__(self) -> str:
        return f"{Hint('unit', 'time', self.unit)} ({_number(self.rate)} Hz, {_number(self.length)} s)"


def is_possible(rate: float) -> bool:
    """Whether an inertial sensor may have a rate."""
    return PLAUSIBLE_RATES[0] <= rate <= PLAUSIBLE_RATES[1]


def readings(interval: float, n: int) -> list[RateByUnit]:
    """Rate and length of a log of n samples whose stamps have this interval, by unit of time."""
    sizes = [(unit, units.find(unit).factor) for unit in (*UNITS, *_RARE_UNITS)]
    return [RateByUnit(unit=unit, rate=1 / (interval * size), length=n * interval * size) for unit, size in sizes]


def epoch_unit(stamp: float) -> str | None:
    """The unit in which a stamp, counted from 1970, is a present-day date; None if there is none."""
    return next((unit for unit in UNITS if _EPOCH[0] <= stamp * units.find(unit).factor <= _EPOCH[1]), None)


def unit_by_size(first: float, last: float, interval: float, n: int) -> str | None:
    """The unit of stamps that count from 1970: 10 digits are seconds, 13 milliseconds, 16 microseconds, 19 nanoseconds; or
    days, for the day numbers of Excel and MATLAB.

    None if the stamps do not count from 1970, or if the rate in this unit is implausible. None also if the rate is
    below 1 Hz and another unit leads to a usual log: nanoseconds since the start of a phone weeks ago have 16 digits
    too.
    """
    by_unit = {reading.unit: reading for reading in readings(interval, n)}
    possible = {unit for unit, reading in by_unit.items() if reading.is_possible}
    unit = epoch_unit(first)
    if unit is not None and by_unit[unit].rate < SLOW and any(by_unit[name].is_usual for name in UNITS):
        return None
    if unit is None and possible.isdisjoint(UNITS):
        unit = "d" if any(low <= first <= last <= high for low, high in (_EXCEL_DAYS, _MATLAB_DAYS)) else None
    elif epoch_unit(last) != unit:
        return None
    return unit if unit in possible else None


def refuse_implausible(sensor: str, name: str, rate: float, n: int, second: float | None) -> None:
    """Raise `OptionError` for a rate or length that no log of a gyro or accelerometer has. `name`: the column of the
    stamps; `second`: length of the unit of the stamps in seconds, None for dates.
    """
    used = RateByUnit(unit="", rate=rate, length=n / rate)
    alternatives = [] if second is None else readings(1 / (rate * second), n)
    likely = [reading for reading in alternatives if reading.is_usual]
    is_short = used.length < SHORTEST and n >= _MIN_SAMPLES and any(reading.unit in UNITS for reading in likely)
    if used.is_possible and not is_short:
        return
    likely = likely or [reading for reading in alternatives if reading.is_possible]
    offered = " or ".join(map(str, sorted(likely, key=lambda reading: reading.distance_from_frequent)))
    raise OptionError(
        f"the time stamps in column {name} give {_number(used.rate)} Hz for {_number(used.length)} s, which is not a log of"
        f" {_SENSORS[sensor]}; give {offered + ', or ' if offered else ''}{RATE}",
        option="unit",
    )


def ask_for_unit(stamps: NDArray[Any], intervals: NDArray[np.float64], name: str) -> OptionError:
    """The question for the unit of the stamps, with the rate that each unit gives. `name`: the column of the stamps."""
    rates = readings(float(intervals.sum()) / len(intervals), len(stamps))
    usual, rare = rates[: len(UNITS)], rates[len(UNITS) :]
    likely = [r for r in usual if r.is_possible] or [r for r in rare if r.is_possible] or usual
    offered = ", ".join(f"as {reading.unit} {_number(reading.rate)} Hz" for reading in likely)
    epoch = epoch_unit(float(stamps[0]))
    dated = [reading for reading in likely if reading.unit == epoch and reading.rate >= SLOW]
    ordered = sorted(dated or likely, key=lambda reading: reading.distance_from_frequent)
    ways = ", ".join(str(Hint("unit", "time", reading.unit)) for reading in ordered)
    return OptionError(
        f"the unit of the time stamps in column {name} is not stated ({stamps[0]}, {stamps[1]} …: {offered});"
        f" give {ways} or {RATE}",
        option="unit",
    )


def find_stride(stamps: NDArray[Any], intervals: NDArray[np.float64]) -> int:
    """Step from one stamp to the next, if stamps may be sample numbers: integers from 0 or 1 that grow by this step, except
    at lost samples. Else 0.
    """
    stride = intervals[0]
    if len(stamps) < _MIN_SAMPLES or stamps[0] not in _FIRST_NUMBERS or not stride >= 1 or stride % 1:
        return 0
    whole = np.all(intervals >= stride) and not np.any(intervals % stride) and np.median(intervals) == stride
    return int(stride) if whole else 0


def ask_for_sample_numbers(name: str, stamps: NDArray[Any]) -> OptionError:
    """The question for stamps in seconds that may be the numbers of the samples. `name`: their column."""
    first = ", ".join(f"{value:.0f}" for value in stamps[:3])
    return OptionError(
        f"column {name} counts {first} …, which are seconds of a log at 1 Hz, or numbers of the samples. Give"
        f" {RATE} if they are numbers, or {Hint('unit', 'time', 's')} if the rate is 1 Hz",
        option="rate",
    )


def slow_rate(rate: float, n: int, second: float, stride: int) -> tuple[Finding, ...]:
    """A finding about a rate below 1 Hz, with the rate in a smaller unit of time; empty if none is plausible.

    `second`: length of the unit of the stamps in seconds; `stride`: that of the stamps, if they may be sample numbers.
    """
    if rate >= SLOW:
        return ()
    options = readings(1 / (rate * second), n)
    used = next((r for r in options if abs(r.rate / rate - 1) < _ROUNDING), None)
    usual = next((r for r in options if r.is_usual and r.unit in UNITS), None)
    if used is None or usual is None:
        return ()
    details = ImplausibleRate(rate=rate, unit=used.unit, other_rate=usual.rate, other_unit=usual.unit, stride=stride)
    return (Finding(details=details, severity="warning", size=rate, unit="Hz"),)


def _number(value: float) -> str:
    return f"{float(f'{value:.4g}'):g}"


NOMINAL_RATIO = 1.1
"""Largest ratio of two rates that may be one nominal rate measured by two clocks.

The oscillators of MEMS sensors are within 10 % of their nominal rate, and the rates that a datasheet lists differ by more
(1000 and 1125 Hz). At this ratio a random walk is wrong by 5 %, which a finding states. A larger ratio is a
contradiction.
"""


@frozen
class RateContradiction:
    """A stated rate and another rate that cannot be the same nominal rate."""

    stated: float  # [Hz]
    logged: float  # The other rate, from the time stamps or stated by the file. [Hz]
    source: RateSource  # Source of the other rate
    sensor: str = ""  # The sensor whose rate is stated; empty if it is the rate of all sensors
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
    """Whether two rates may be one nominal rate measured by two clocks."""
    return 1 / NOMINAL_RATIO <= rate / reference <= NOMINAL_RATIO


def unit_by_rate(interval: float, typical: float, rate: float) -> str | None:
    """The unit of time in which stamps with the mean `interval` are closest to a rate. None for a counter: the
    `typical` interval is then 1, or the rate follows from ticks of 10^-k s, such as 0.1 ms or 100 ns.
    """
    unit = min(UNITS, key=lambda name: abs(math.log(rate * interval * units.find(name).factor)))
    if is_one_nominal_rate(1 / (interval * units.find(unit).factor), rate):
        return unit
    ticks = 10.0 ** round(math.log10(rate * interval))
    is_counter = typical.is_integer() and (typical == 1 or is_one_nominal_rate(ticks / interval, rate))
    return None if is_counter else unit


def unit_for(second: float, by_stamps: float, stated: float) -> str:
    """The unit of time in which the stamps give the stated rate; empty if there is none.

    `second`: length in seconds of the unit in which they give the rate `by_stamps`.
    """
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
