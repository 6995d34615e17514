"""Rows that are lost in a pattern, and a clock coarser than the samples: how the one is told from the other."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["lasts", "pattern"]

_PERIOD = 32  # rows: a pattern of losses that is longer is taken for a clock that is coarser than the samples
_PERIODIC = 20  # times the square of a period, in rows: two clocks that beat so by chance do not for so long
_SINGLE = 0.3  # of the intervals, at least, are one interval of the sensor


def pattern(intervals: NDArray[np.float64], step: float) -> int:
    """The period of a pattern of few sizes, the finest of them one step of the clock; 0 if there is none."""
    counts = np.rint(intervals / step)
    single = counts == 1
    if counts.min() < 1 or np.count_nonzero(single) < _SINGLE * len(counts) or single.all():
        return 0
    # From one end of a run of single steps to the next.
    ends = np.flatnonzero(single[:-1] & ~single[1:])
    if len(ends) < 3:
        return 0
    period = int(np.median(np.diff(ends)))
    return period if np.array_equal(counts[period:], counts[:-period]) else 0


def lasts(period: int, n: int) -> bool:
    """Whether a pattern is so short, and seen in so many stamps, that two clocks do not beat so by chance."""
    return 0 < period <= _PERIOD and n >= _PERIODIC * period**2
