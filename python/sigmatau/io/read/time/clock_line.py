"""Least-squares line through stamps on a known grid: interval, jitter, and drift of the rate."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import distinct, median
from sigmatau.frozen import frozen

BLOCK = 64  # number of stamps whose phase on the grid is averaged
_JITTER_BLOCKS = 512  # number of blocks from which the jitter is computed
_PARTS = 10  # number of equal parts of a record whose rates are compared
_SHORT_INTERVAL = 0.5  # share of the sample interval below which an interval belongs to a burst
_MIN_CHANGE = 1.05  # smallest ratio of the rates for an abrupt change
_MIN_SIDE = 16  # smallest number of intervals before and after the change
_EXCEPTIONS = 0.03  # share of the intervals of the shorter side that may be on the wrong side of the threshold
_MIN_INDEPENDENT = 3.0  # smallest number of independent stamps in a part: two determine a line without scatter


@frozen
class ClockDrift:
    """Mean rates of ten equal parts relative to the rate of the record, and the standard error of each."""

    rates: NDArray[np.float64]
    error: float

    @property
    def size(self) -> float:
        """Range of the relative rates."""
        return float(np.ptp(self.rates))


@frozen
class GridFit:
    """The grid of stamps; times are in the unit of the stamps."""

    kind: Literal["grid", "coarse", "host"]
    interval: float  # Sample interval
    error: float  # Standard error of the interval
    start: int  # first stamp in use: of all, or of the longest piece between long pauses
    stop: int
    # shape (stop - start,); the place of each stamp on the grid, increasing from 0; None if every place has a stamp
    places: NDArray[np.int64] | None
    n: int  # Number of places
    jitter: float  # Standard deviation of the stamps about the grid
    short: float  # Share of intervals under half the sample interval
    median: float  # Median of the intervals
    drift: ClockDrift | None  # None if there are too few stamps
    # Number of pieces between pauses that are longer than the samples of the record. 1 if there is no such pause; 0 if
    # there are so many pauses that the stamps are not used and all samples are treated as evenly spaced
    pieces: int
    period: int = 0  # Rows after which the pattern of intervals repeats; 0 if it does not
    bound: float = 0.0  # Largest relative error of the interval on a coarse clock


def about_line(
    t: NDArray[np.float64], x: NDArray[np.float64]
) -> tuple[NDArray[np.float64], float, NDArray[np.float64]]:
    """Residuals of the least-squares line of times over x, its slope, and x minus its mean."""
    first = float((t[-1] - t[0]) / (x[-1] - x[0]))
    rest = t - t[0] - x * first
    rest -= rest.mean()
    middle = x - x.mean()
    correction = float(middle @ rest) / float(middle @ middle)
    rest -= correction * middle
    return rest, first + correction, middle


def rate_change(intervals: NDArray[np.float64]) -> tuple[int, float, float] | None:
    """The first interval after an abrupt change of the sampling rate, and the mean intervals before and after it; None if
    there is none.

    The rate must change once and permanently, as after a new setting of the sensor. Lost samples and bunches do not
    count.
    """
    n = len(intervals)
    ends = max(n // 100, _MIN_SIDE)
    before, after = (median(some[:: max(ends // 4096, 1)]) for some in (intervals[:ends], intervals[-ends:]))
    if not (min(before, after) > 0 and max(before, after) > _MIN_CHANGE * min(before, after)):
        return None
    later = (intervals < math.sqrt(before) * math.sqrt(after)) == (after < before)
    ahead = np.cumsum(np.where(later, -1, 1))
    change = int(np.argmax(ahead)) + 1
    wrong = np.count_nonzero(later[:change]) + np.count_nonzero(~later[change:])
    if min(change, n - change) < _MIN_SIDE or wrong > _EXCEPTIONS * min(change, n - change):
        return None
    ratios = (
        median(intervals[max(change - BLOCK, 0) : change]) / before,
        median(intervals[change : change + BLOCK]) / after,
    )
    largest = (max(before, after) / min(before, after)) ** 0.25
    return (change, before, after) if all(1 / largest < ratio < largest for ratio in ratios) else None


def _by_blocks(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Means of blocks of 64, which are sufficient for a line; the remainder is a shorter block."""
    if len(values) < 4 * BLOCK:
        return values
    whole = len(values) // BLOCK * BLOCK
    return np.append(
        values[:whole].reshape(-1, BLOCK).mean(axis=1), values[whole:].mean() if whole < len(values) else ()
    )


def make_grid_fit(
    t: NDArray[np.float64],
    places: NDArray[np.int64] | None,
    kind: Literal["grid", "coarse", "host"],
    median: float,
    intervals: NDArray[np.float64] | None,
    *,
    start: int = 0,
    pieces: int = 1,
    period: int = 0,
) -> GridFit:
    """The grid of one piece of stamps; `intervals` is None if all intervals are close to the mean."""
    n = len(t)
    last = n - 1 if places is None else int(places[-1] - places[0])
    first = float(t[-1] - t[0]) / last
    along = _by_blocks(places.astype(np.float64)) if places is not None else _counted_by_blocks(n)
    rest, correction, middle = about_line(_by_blocks(t) - first * along, along)
    slope = first + correction
    squares = float(middle @ middle)
    short = 0.0
    if intervals is not None:
        short = float(np.count_nonzero(intervals < _SHORT_INTERVAL * slope)) / len(intervals)
    apart = (1 - short) * n  # number of independent stamps: the stamps of a bunch have a common error
    scatter = math.sqrt(float(rest @ rest) / min(float(len(rest)), max(apart, 1.0)))
    return GridFit(
        kind=kind,
        interval=slope,
        error=scatter / math.sqrt(squares) if squares > 0 else math.inf,
        start=start,
        stop=start + n,
        places=places,
        n=n if places is None else int(places[-1]) + 1,
        jitter=_jitter(t, places, slope),
        short=short,
        median=median,
        drift=_drift(rest, along, slope, apart / _PARTS) if n >= 4 * _PARTS * BLOCK else None,
        pieces=pieces,
        period=period,
    )


def _counted_by_blocks(n: int) -> NDArray[np.float64]:
    """`_by_blocks` of 0, 1, 2 … n - 1."""
    if n < 4 * BLOCK:
        return np.arange(n, dtype=np.float64)
    blocks = n // BLOCK
    means: NDArray[np.float64] = np.arange((BLOCK - 1) / 2, BLOCK * (blocks + (n % BLOCK > 0)), BLOCK)
    if n % BLOCK:
        means[-1] = (blocks * BLOCK + n - 1) / 2
    return means


def _jitter(t: NDArray[np.float64], places: NDArray[np.int64] | None, slope: float) -> float:
    """Standard deviation about the line of each block of 64, from at most 512 evenly spaced blocks."""
    size = min(BLOCK, len(t))
    if size < 4:
        return 0.0
    blocks = len(t) // size
    starts = distinct(np.linspace(0, blocks - 1, min(blocks, _JITTER_BLOCKS)).astype(np.int64))
    rows = starts[:, None] * size + np.arange(size)
    along = (rows if places is None else places[rows]).astype(np.float64)
    values = t[rows] - slope * along
    values = values - values.mean(axis=1, keepdims=True)
    along = along - along.mean(axis=1, keepdims=True)
    slopes = (values * along).sum(axis=1) / (along * along).sum(axis=1)
    values = values - slopes[:, None] * along
    return math.sqrt(float((values * values).sum()) / (len(starts) * (size - 2)))


def _drift(rest: NDArray[np.float64], along: NDArray[np.float64], interval: float, apart: float) -> ClockDrift | None:
    """Mean rates of ten parts, from means of blocks; the scatter of the blocks about ten lines gives their error.
    Blocks are not independent if bunches are longer than a block: then a part has `apart` independent blocks.
    """
    if apart < _MIN_INDEPENDENT:
        return None
    per = len(rest) // _PARTS
    values, along = (x[: _PARTS * per].reshape(_PARTS, per) for x in (rest, along))
    values = values - values.mean(axis=1, keepdims=True)
    along = along - along.mean(axis=1, keepdims=True)
    squares = (along * along).sum(axis=1)
    slopes = (values * along).sum(axis=1) / squares
    residuals = values - slopes[:, None] * along
    scatter = math.sqrt(float((residuals * residuals).sum()) / (_PARTS * (per - 2)) * max(1.0, per / apart))
    return ClockDrift(rates=-slopes / interval, error=scatter / math.sqrt(float(squares.mean())) / interval)
