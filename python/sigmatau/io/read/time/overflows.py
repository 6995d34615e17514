"""Unwrapping of stamps: counters that overflow, clocks that start again, and clocks written as digits."""

from __future__ import annotations

from collections.abc import Callable
from datetime import date
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import median
from sigmatau.findings.finding import Finding
from sigmatau.findings.stamps import CounterOverflows

# Periods of counters of 16, 24 and 32 bits, also of ticks of 1e-3 and 1e-6 s logged in seconds or milliseconds.
_COUNTERS = tuple(2.0**bits * ticks for bits in (16, 24, 32) for ticks in (1.0, 1e-3, 1e-6))
# Periods of clocks in s, ms, us and ns: a minute, an hour, a day and a week.
_CLOCKS = tuple(period * ticks for period in (60.0, 3600.0, 86400.0, 604800.0) for ticks in (1.0, 1e3, 1e6, 1e9))
_LONGEST_INTERVAL = 4.0  # longest interval across an overflow: up to three samples may be lost there [intervals]
_SHORTEST_INTERVAL = 0.1  # shortest interval across an overflow, because of jitter [intervals]
_RESTART = 10.0  # a clock that begins below this value was set to zero at the start of the log [intervals]
_ROUNDING = 1e-9  # relative error of a period


def continue_overflows(
    stamps: NDArray[Any], where: Callable[[int], str], name: str
) -> tuple[NDArray[Any], Finding] | None:
    """Unwrap stamps whose steps back are the period of a counter or a clock, and report a finding; None if a step back has
    another cause.

    `where`: place of a row, for the finding; `name`: the column.
    """
    values = stamps.astype(np.float64)
    steps = np.diff(values)
    back = np.flatnonzero(steps < 0)
    forward = steps[steps > 0]
    usual = median(forward) if len(forward) else 0.0
    low, high = float(values.min()), float(values.max())
    if not (len(back) and usual > 0 and low >= 0):
        return None
    for period in (*_COUNTERS, *_CLOCKS):
        over = steps[back] + period
        if high >= period * (1 + _ROUNDING) or period - high > _LONGEST_INTERVAL * usual + low:
            continue
        if not (_SHORTEST_INTERVAL * usual <= over.min() and over.max() <= _LONGEST_INTERVAL * usual):
            continue
        if period in _CLOCKS and values[0] < _RESTART * usual:
            continue
        count = np.zeros(len(stamps), dtype=np.int64)
        count[back + 1] = 1
        turns = np.cumsum(count)
        whole = stamps.dtype.kind in "iu" and period.is_integer()
        counted_on = stamps.astype(np.int64) + turns * int(period) if whole else values + turns * period
        details = CounterOverflows(period=period, column=name.strip("'"), place=where(int(back[0]) + 1))
        return counted_on, Finding(details=details, severity="info", size=len(back))
    return None


_DAY = 86400.0  # [s]
_LAST_CLOCK = 240000.0  # last time of the form HHMMSS
_DATES = (19990101000000.0, 20421231235960.0)  # first and last date of the form YYYYMMDDHHMMSS
_TESTED = 4096  # number of stamps that are tested first: a log in seconds has digits above 59 in them
_JUMP = 40.0  # step from 59 to 100, and a multiple of it from 5959 to 10000


def read_clock_digits(stamps: NDArray[Any]) -> NDArray[np.float64] | None:
    """Convert stamps written as HHMMSS.sss or YYYYMMDDHHMMSS.sss to seconds; None if they are not of this form. Shape (n,)
    [s].

    None also if no full minute shows the form: within a minute such stamps count seconds anyway.
    """
    if len(stamps) < 2 or stamps.dtype.kind not in "iuf":
        return None
    ends = np.asarray(stamps[[0, -1]], dtype=np.float64)
    has_dates = bool(((ends >= _DATES[0]) & (ends < _DATES[1])).all())
    if not has_dates and not ((ends >= 0) & (ends < _LAST_CLOCK)).all():
        return None
    if not _are_digits(np.asarray(stamps[:: max(len(stamps) // _TESTED, 1)], dtype=np.float64), has_dates=has_dates):
        return None
    values = np.asarray(stamps, dtype=np.float64)
    jumps = np.abs(np.diff(values)) > _JUMP
    if not jumps.any() or not _are_digits(values, has_dates=has_dates):
        return None
    seconds = values // 1e4 % 100 * 3600 + values // 100 % 100 * 60 + values % 100
    if has_dates:
        days = _days(values // 1e6)
        if days is None:
            return None
        seconds += days * _DAY
    intervals = np.diff(seconds)
    intervals[intervals < -_DAY / 2] += _DAY  # intervals over midnight
    fits = (intervals > 0) & (intervals <= _LONGEST_INTERVAL * median(intervals))
    return seconds if fits[jumps].all() else None


def _are_digits(values: NDArray[np.float64], *, has_dates: bool) -> bool:
    hours = values // 1e4 % 100 if has_dates else values // 1e4
    return bool(((values % 100 < 60) & (values // 100 % 100 < 60) & (hours < 24)).all())


def _days(dates: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Days of dates YYYYMMDD; None if any of them is not a date."""
    unique, places = np.unique(dates.astype(np.int64), return_inverse=True)
    try:
        days = [date(int(d) // 10000, int(d) // 100 % 100, int(d) % 100).toordinal() for d in unique]
    except ValueError:
        return None
    return np.array(days, dtype=np.float64)[places] - days[0]
