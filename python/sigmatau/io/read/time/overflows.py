"""Time stamps of counters that overflow and of clocks that begin again, counted on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import median
from sigmatau.findings.finding import Finding
from sigmatau.findings.stamps import CounterOverflows

# Periods of counters of 16, 24 and 32 bits, also of ticks of 1e-3 and 1e-6 s that are logged in seconds or milliseconds,
_COUNTERS = tuple(2.0**bits * ticks for bits in (16, 24, 32) for ticks in (1.0, 1e-3, 1e-6))
# and of clocks in s, ms, us and ns: seconds of a minute, an hour, a day and a week.
_CLOCKS = tuple(period * ticks for period in (60.0, 3600.0, 86400.0, 604800.0) for ticks in (1.0, 1e3, 1e6, 1e9))
_LONGEST_INTERVAL = 4.0  # across an overflow: up to three samples may be lost there [intervals]
_SHORTEST_INTERVAL = 0.1  # across an overflow: jitter [intervals]
_RESTART = 10.0  # a clock that begins below it is one that is set to zero at the start of a log [intervals]
_ROUNDING = 1e-9  # relative error of a period


def continue_overflows(
    stamps: NDArray[Any], where: Callable[[int], str], name: str
) -> tuple[NDArray[Any], Finding] | None:
    """Stamps that step back, counted on where the step back is the period of a counter or a clock, and a finding; None if
    any step back has another cause. `where`: place of a row, for the finding; `name`: the column.
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
