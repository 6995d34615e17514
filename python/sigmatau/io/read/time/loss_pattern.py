"""Distinction between rows lost in a periodic pattern and a clock coarser than the samples."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["is_loss_pattern", "pattern"]

_MAX_PERIOD = 32  # rows; a longer pattern is attributed to a clock coarser than the samples
_LEAST_LENGTH = 20  # rows, times the square of the period: the beat of two clocks is not periodic for so long
_LEAST_SINGLE = 0.3  # share of intervals that are one interval of the sensor


def pattern(intervals: NDArray[np.float64], step: float) -> int:
    """The period in rows of a pattern of intervals, the shortest of them one step of the clock; 0 if there is no pattern."""
    counts = np.rint(intervals / step)
    single = counts == 1
    if counts.min() < 1 or np.count_nonzero(single) < _LEAST_SINGLE * len(counts) or single.all():
        return 0
    # From the end of one run of single steps to the end of the next.
    ends = np.flatnonzero(single[:-1] & ~single[1:])
    if len(ends) < 3:
        return 0
    period = int(np.median(np.diff(ends)))
    return period if np.array_equal(counts[period:], counts[:-period]) else 0


def is_loss_pattern(period: int, n: int) -> bool:
    """Whether a pattern is too short, in too many stamps, to be the beat of two clocks."""
    return 0 < period <= _MAX_PERIOD and n >= _LEAST_LENGTH * period**2
