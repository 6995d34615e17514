"""Stamps whose digits are a clock: 235959.990 is followed by 0.0, and 20260301095959.990 by 20260301100000.0."""

from __future__ import annotations

from datetime import date
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import median

_DAY = 86400.0  # [s]
_LAST_CLOCK = 240000.0  # HHMMSS
_DATES = (19990101000000.0, 20421231235960.0)  # YYYYMMDDHHMMSS
_TESTED = 4096  # stamps that are tested first: a log in seconds shows digits above 59 in them
_JUMP = 40.0  # from 59 to 100, and beyond it from 5959 to 10000
_LONGEST_INTERVAL = 4.0  # across a full minute: up to three samples may be lost there [intervals]


def read_clock_digits(stamps: NDArray[Any]) -> NDArray[np.float64] | None:
    """Seconds of stamps that are written as HHMMSS.sss or YYYYMMDDHHMMSS.sss; None if they are not, or if no full minute
    shows it: within a minute they count seconds anyway. Shape (n,) [s].
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
    intervals[intervals < -_DAY / 2] += _DAY  # over midnight
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
