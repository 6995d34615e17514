"""The line through stamps on a known grid: interval, jitter, and how the rate drifts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

__all__ = ["BLOCK", "Drift", "GridFit", "about_line", "finished"]

BLOCK = 64
"""Stamps that share a phase."""

_BLOCKS = 512  # looked at for the jitter
_PARTS = 10  # of a record, for the drift of the rate
_SHORT = 0.5  # of the interval: a burst
_LEAST_APART = 3.0  # stamps in a tenth: two of them would be on any line


@dataclass(frozen=True, slots=True, kw_only=True)
class Drift:
    """The rate by tenths of a record, relative to that of the whole, and the standard error of one of them."""

    rates: NDArray[np.float64]
    error: float

    @property
    def size(self) -> float:
        """Largest less smallest."""
        return float(np.ptp(self.rates))


@dataclass(frozen=True, slots=True, kw_only=True)
class GridFit:
    """The grid of stamps; times are in the unit of the stamps.

    Attributes
    ----------
    kind : {"grid", "coarse", "host"}
    interval : float
        Sample interval.
    error : float
        Standard error of the interval.
    start, stop : int
        The stamps that are used: all, or those of the longest piece between long pauses.
    places : ndarray of int64, shape (stop - start,), or None
        The place of each stamp on the grid, from 0 and growing; None if every place has one.
    n : int
        Places.
    jitter : float
        Standard deviation of the stamps about the grid.
    short : float
        Share of intervals under half the sample interval.
    median : float
        Median of the intervals.
    drift : Drift or None
        None if there are too few stamps.
    pieces : int
        Pieces between pauses that hold more places than the record has samples; 1 if there is no such pause, 0 if there are
        so many that the stamps are of no use, and all samples are taken as even.
    """

    kind: Literal["grid", "coarse", "host"]
    interval: float
    error: float
    start: int
    stop: int
    places: NDArray[np.int64] | None
    n: int
    jitter: float
    short: float
    median: float
    drift: Drift | None
    pieces: int
    period: int = 0
    bound: float = 0.0


def about_line(
    t: NDArray[np.float64], x: NDArray[np.float64]
) -> tuple[NDArray[np.float64], float, NDArray[np.float64]]:
    """What times are more than their line over x, its slope, and x less its mean."""
    first = float((t[-1] - t[0]) / (x[-1] - x[0]))
    rest = t - t[0] - x * first
    rest -= rest.mean()
    middle = x - x.mean()
    more = float(middle @ rest) / float(middle @ middle)
    rest -= more * middle
    return rest, first + more, middle


def _by_blocks(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Means of blocks of 64, which hold all that a line needs; what is left at the end is a block of its own."""
    if len(values) < 4 * BLOCK:
        return values
    whole = len(values) // BLOCK * BLOCK
    return np.append(
        values[:whole].reshape(-1, BLOCK).mean(axis=1), values[whole:].mean() if whole < len(values) else ()
    )


def finished(
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
    """What the stamps of one piece say; intervals are None if each of them is near the mean."""
    n = len(t)
    last = n - 1 if places is None else int(places[-1] - places[0])
    first = float(t[-1] - t[0]) / last
    along = _by_blocks(places.astype(np.float64)) if places is not None else _counted_by_blocks(n)
    rest, more, middle = about_line(_by_blocks(t) - first * along, along)
    slope = first + more
    squares = float(middle @ middle)
    short = 0.0
    if intervals is not None:
        short = float(np.count_nonzero(intervals < _SHORT * slope)) / len(intervals)
    apart = (1 - short) * n  # stamps that say something of their own: those of one bunch are late or early together
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
    """The same of 0, 1, 2 … n - 1."""
    if n < 4 * BLOCK:
        return np.arange(n, dtype=np.float64)
    blocks = n // BLOCK
    means: NDArray[np.float64] = np.arange((BLOCK - 1) / 2, BLOCK * (blocks + (n % BLOCK > 0)), BLOCK)
    if n % BLOCK:
        means[-1] = (blocks * BLOCK + n - 1) / 2
    return means


def _jitter(t: NDArray[np.float64], places: NDArray[np.int64] | None, slope: float) -> float:
    """Standard deviation about the line of each block of 64, from at most 512 blocks spread over the record."""
    size = min(BLOCK, len(t))
    if size < 4:
        return 0.0
    blocks = len(t) // size
    at = np.unique(np.linspace(0, blocks - 1, min(blocks, _BLOCKS)).astype(np.int64))
    rows = at[:, None] * size + np.arange(size)
    along = (rows if places is None else places[rows]).astype(np.float64)
    values = t[rows] - slope * along
    values = values - values.mean(axis=1, keepdims=True)
    along = along - along.mean(axis=1, keepdims=True)
    slopes = (values * along).sum(axis=1) / (along * along).sum(axis=1)
    values = values - slopes[:, None] * along
    return math.sqrt(float((values * values).sum()) / (len(at) * (size - 2)))


def _drift(rest: NDArray[np.float64], along: NDArray[np.float64], interval: float, apart: float) -> Drift | None:
    """Rates by tenths, from the means of blocks: their scatter about ten lines says how sure they are.

    In bunches that are longer than a block, blocks are not independent: there are as many as the stamps `apart` in a tenth.
    """
    if apart < _LEAST_APART:
        return None
    per = len(rest) // _PARTS
    values, along = (x[: _PARTS * per].reshape(_PARTS, per) for x in (rest, along))
    values = values - values.mean(axis=1, keepdims=True)
    along = along - along.mean(axis=1, keepdims=True)
    squares = (along * along).sum(axis=1)
    slopes = (values * along).sum(axis=1) / squares
    left = values - slopes[:, None] * along
    scatter = math.sqrt(float((left * left).sum()) / (_PARTS * (per - 2)) * max(1.0, per / apart))
    return Drift(rates=-slopes / interval, error=scatter / math.sqrt(float(squares.mean())) / interval)
