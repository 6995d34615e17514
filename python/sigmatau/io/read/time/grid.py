"""The grid that time stamps sit on: its interval, and which of its places are empty.

Three kinds of stamps are told apart. Those of a sensor sit on a regular grid, with jitter, and where samples were lost there
are holes. Those of a clock that is coarser than the sampling repeat, but an even line goes through them within one step of
the clock. Those of a host come in bunches: then only the samples are even, and the stamps say no more than how many there
were in all.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import NDArray

from sigmatau.io.read.time.clock_line import BLOCK, GridFit, about_line, finished
from sigmatau.io.read.time.coarse_clock import Allowed, allowed, few_steps
from sigmatau.io.read.time.loss_pattern import lasts, pattern
from sigmatau.io.read.time.neighbours import agreed, scatter_alone

__all__ = ["fit_grid", "resolution"]

_SPREAD = 1 << 16  # intervals looked at for their median
_PHASES = 1 << 18  # stamps whose phase is computed, at most
_EVEN = (0.5, 1.5)  # no interval beyond: nothing is lost
_SMOOTH = 0.12  # and the intervals scatter by no more than this part of their mean
_SHORT = 0.5  # of the interval: a burst
_BURSTS = 0.05  # share of short intervals above which stamps are of a host: jitter of 0.2 intervals makes 0.039
_COHERENT = 0.4  # mean resultant length of the phases: jitter of 0.2 intervals has 0.45, 64 phases of no grid 0.11
_MENDED = 0.05  # share of stamps that may be nearer to another place than their own
_NEAR = 0.35  # of an interval: a difference of stamps that counts intervals
_RARE, _LONG = (
    1000,
    20.0,
)  # of a host: one interval in so many may be a pause, if it is so many times as long as the others
_SAME = 1e-3  # relative difference of two intervals that are the same
_FINEST = 0.15  # quantile of the intervals that is of the finest grid, if one is finer than that of the median
_FITS = 0.5  # mean cosine of the intervals: poor below, good above
_FINER = 0.8  # times the interval, at most
_SPLITS = 64
_EXACT = 0.05  # of the interval, root mean square: stamps of the sensor's own clock
_LOST = 4  # times as many samples as there are: so many may be lost of stamps that are exact, and lost at random
_GEOMETRIC, _APART = 0.25, 0.15  # relative error of the share of whole intervals; correlation of neighbouring intervals
_ONE_STEP = 1.05  # steps of the clock within which evenly spaced samples are, with a little jitter
_LEAST_LEFT = 0.1  # of the rows: a longest piece with less than this is no record


def resolution(intervals: NDArray[Any], largest: float) -> float:
    """The step of the clock, if the intervals are whole multiples of a decimal one; else 0.

    Parameters
    ----------
    intervals : ndarray, shape (n,)
    largest : float
        Largest absolute value of the stamps, which says how exact the intervals are.
    """
    some = intervals[:: max(len(intervals) // 8192, 1)]
    if intervals.dtype.kind in "iu":
        return float(np.gcd.reduce(some.astype(np.int64)))
    for power in range(10):
        step = 10.0**-power
        multiples = some / step
        slack = 4 * np.spacing(max(largest, 1e-300)) / step
        if slack > 0.01:
            return 0.0
        if float(np.abs(multiples).max(initial=0)) < 2**53 and np.all(np.abs(multiples - np.rint(multiples)) <= slack):
            return step * float(np.gcd.reduce(np.rint(multiples).astype(np.int64)))
    return 0.0


@np.errstate(over="ignore", invalid="ignore")  # a stamp may lie beyond all reason
def fit_grid(
    t: NDArray[np.float64], intervals: NDArray[np.float64], step: float, *, given: float | None = None
) -> GridFit:
    """The grid that stamps sit on.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Stamps from the first one on, growing or equal, n ≥ 2, the last larger than the first.
    intervals : ndarray, shape (n - 1,)
        Between them.
    step : float
        Step of their clock, from `resolution`.
    given : float, optional
        Interval that the user states: where stamps can be read in two ways, it says which is right.

    Notes
    -----
    Evenly spaced samples on a coarse clock and samples of which every k-th is lost can have the very same stamps: 80 Hz in
    steps of 10 ms, and 100 Hz without every fifth. Two clocks do not beat in a short pattern for ever; a pattern that
    repeats to the end of the record is of losses.

    The interval is first the median interval, refined over longer and longer lags: the number of intervals in a lag is
    counted, so that lost samples make no error. The phase of the stamps, modulo the interval, is averaged on the circle by
    blocks of 64: it does not see lost samples either, and follows a clock that drifts or steps by a part of an interval.
    The place of a stamp is its time less that phase, rounded; a stamp that is late or early by more than half an interval
    is put right by its neighbours. The interval that is returned is the slope of the least-squares line of stamp against
    place.
    """
    n = len(t)
    mean = float(t[-1] - t[0]) / (n - 1)
    some = intervals[:: max(n // _SPREAD, 1)]
    median = float(np.median(some))
    even = _EVEN[0] * mean < float(intervals.min()) and float(intervals.max()) < _EVEN[1] * mean
    if even and float(np.std(some)) < _SMOOTH * mean:
        return finished(t, None, "grid", median, None)
    if (stairs := _stairs(t, intervals, step)) is not None:
        if given and stairs.least <= given <= stairs.most:
            stairs = replace(stairs, interval=given)
        elif stairs.least == 0:
            stairs = replace(stairs, interval=stairs.most)
        one = finished(t, None, "coarse", median, intervals)
        return replace(
            one, interval=stairs.interval, error=stairs.error * stairs.interval, drift=None, bound=stairs.error
        )
    if _even_line(t, intervals, step):
        period = pattern(intervals, step)
        stated = bool(given) and period > 0 and abs(cast("float", given) / step - 1) < _SAME
        even_stated = bool(given) and abs(cast("float", given) / mean - 1) < _SAME
        if stated or (lasts(period, n) and not even_stated):
            filled: NDArray[np.int64] = np.rint(t / step).astype(np.int64)
            return finished(t, filled, "grid", median, intervals, period=0 if stated else period)
        kind_: Literal["grid", "coarse"] = "grid" if intervals.all() else "coarse"
        return finished(t, None, kind_, median, intervals, period=0 if even_stated else period)
    kind: Literal["grid", "host"] = "grid"
    lost = _places(t, intervals, median)
    if lost is None and scatter_alone(t):
        return finished(t, None, "grid", median, intervals)
    if lost is None:
        kind, lost = "host", _pauses(intervals)
    # Samples lost at random, which are no pauses: of them there are not many more than are there.
    random = kind == "grid" and _scattered(lost) and float(lost[-1] - lost[0]) <= 1.1 * _LOST * n
    start, stop, pieces = (0, n, 1) if random else _longest_piece(lost)
    if not pieces:
        return finished(t, None, "host", median, intervals, pieces=0)
    lost = lost[start:stop] - lost[start]
    places = np.arange(stop - start) + lost.astype(np.int64) if lost[-1] > 0 else None
    return finished(t[start:stop], places, kind, median, intervals[start : stop - 1], start=start, pieces=pieces)


def _stairs(t: NDArray[np.float64], intervals: NDArray[np.float64], step: float) -> Allowed | None:
    """What even samples on a clock of few steps may be, if these are such stamps.

    Its rate cannot be seen to drift: an even line is within one step of all stamps.
    """
    if not (step > 0 and few_steps(len(t), int(np.count_nonzero(intervals)))):
        return None
    found = allowed(t, step)
    return found if found.width <= _ONE_STEP * step else None


def _even_line(t: NDArray[np.float64], intervals: NDArray[np.float64], step: float) -> bool:
    """Whether evenly spaced samples would have these stamps on a clock of such a step."""
    n = len(t)
    mean = float(t[-1] - t[0]) / (n - 1)
    if not step > 0 or step < 1e-6 * mean:
        return False
    # A lost sample moves a line by no more than an interval: with a step like the interval, it takes several to tell.
    if step >= _SHORT * mean and np.count_nonzero(np.abs(intervals - np.rint(mean / step) * step) > 0.5 * step) < 5:
        return False
    rest, _, _ = about_line(t, np.arange(n, dtype=np.float64))
    return bool(np.ptp(rest) <= _ONE_STEP * step)


def _places(t: NDArray[np.float64], intervals: NDArray[np.float64], median: float) -> NDArray[np.float64] | None:
    """Samples lost before each stamp, none of it negative and never falling; None if the stamps sit on no grid."""
    n = len(t)
    usual = intervals[(intervals > 0.4 * median) & (intervals < 1.6 * median)] if median > 0 else intervals[:0]
    if not len(usual):
        return None
    interval = _refined(t, float(usual.mean()))
    if _cosine(intervals, interval) < _FITS:
        finer = _finer(t, intervals)
        interval = finer if 0 < finer < _FINER * interval else interval
    if np.count_nonzero(intervals < _SHORT * interval) > _BURSTS * len(intervals):
        return None
    late = t / interval - np.arange(n)
    if not np.abs(late).max() < 2**52:
        return None if np.abs(late).max() >= 2**1000 or not np.isfinite(late).all() else _coarsely(late)
    phase = _phase(late)
    if phase is None:
        return None
    lost: NDArray[np.float64] = np.rint(late - phase)
    own, lost = lost, agreed(lost, late - phase)
    if np.count_nonzero(lost != own) > _MENDED * n:
        return None
    if _scattered(lost) and not _lost_at_random(lost, late - phase - lost):
        return None
    return np.asarray(lost - lost[0])


def _cosine(intervals: NDArray[np.float64], interval: float) -> float:
    """1 if the intervals are whole multiples of one, near 0 or less if not."""
    some = intervals[:: max(len(intervals) // _SPREAD, 1)] / interval
    return float(np.mean(np.cos(2 * np.pi * (some - np.rint(some)))))


def _finer(t: NDArray[np.float64], intervals: NDArray[np.float64]) -> float:
    """The interval of a grid finer than the median interval, of which the intervals are whole multiples; 0 if none is."""
    some = intervals[:: max(len(intervals) // _SPREAD, 1)]
    low = float(np.quantile(some, _FINEST, method="lower"))
    near = some[(some > 0.7 * low) & (some < 1.4 * low)] if low > 0 else some[:0]
    if not len(near):
        return 0.0
    interval = _refined(t, float(near.mean()))
    return interval if _cosine(intervals, interval) > _FITS else 0.0


def _lost_at_random(lost: NDArray[np.float64], off: NDArray[np.float64]) -> bool:
    """Whether exact stamps miss samples one by one, up to four in five: a sensor's grid with losses, and no host's bunches.

    Of samples lost at random with probability p, a share 1 - p of the intervals is whole, and neighbours know nothing of
    each other; those of bunches do, and have far more short intervals than their mean allows.
    """
    n = len(lost)
    holes = np.diff(lost)
    if n < BLOCK or float(lost[-1] - lost[0]) > 1.1 * _LOST * n or float(np.mean(off * off)) > _EXACT**2:
        return False
    whole, there = float(np.mean(holes == 0)), n / (n + float(lost[-1] - lost[0]))
    some = holes - holes.mean()
    alike = float(some[1:] @ some[:-1]) / max(float(some @ some), 1e-300)
    return abs(whole / there - 1) < _GEOMETRIC + 3 / math.sqrt(n * there) and abs(alike) < _APART + 3 / math.sqrt(n)


def _scattered(lost: NDArray[np.float64]) -> bool:
    """Whether most places are empty, not in a few pauses: bunches, whose own interval was taken for the samples'."""
    n = len(lost)
    if lost[-1] - lost[0] <= n:
        return False
    holes = np.sort(np.diff(lost))
    return bool(holes[: n - 1 - min(max(math.ceil(n / _RARE), 3), n // 4)].sum() > n)


def _coarsely(late: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where a stamp lies beyond all reason, the phase cannot be told; the pauses can."""
    lost: NDArray[np.float64] = np.rint(np.minimum.accumulate(late[::-1])[::-1] - late[0])
    return lost


def _refined(t: NDArray[np.float64], interval: float) -> float:
    """The interval from differences over longer and longer lags, in each of which the intervals are counted."""
    n = len(t)
    lag = 1
    while 4 * lag <= max(n - 1, 4) and lag < n:
        at = np.arange(0, n - lag, max((n - lag) // 16384, 1))
        spans = t[at + lag] - t[at]
        counts = np.rint(spans / interval)
        good = (counts > 0) & (counts < 4.0 * lag + 4)
        near = good & (np.abs(spans / interval - counts) < _NEAR)
        if 2 * np.count_nonzero(near) < len(at):
            break
        # By the mean on the circle: that of the good ones alone would be drawn to the interval that they were counted with.
        turned = np.mean(np.exp(2j * np.pi * (spans[good] / interval - counts[good])))
        off = float(np.angle(turned)) / (2 * np.pi)
        interval *= 1 + off / float(counts[good].mean())
        if lag >= 4096:
            break
        lag *= 4
    return interval


def _phase(late: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """The phase of each stamp on the grid, in intervals, as its neighbours have it; None if they agree on none."""
    n = len(late)
    stride = max(n // _PHASES, 1)
    size = BLOCK * stride
    blocks = max(n // size, 1)
    size = min(size, n)
    angles = late[: blocks * size : stride] if n >= size else late
    per = math.ceil(size / stride)
    turned = np.exp(2j * np.pi * (angles - np.rint(angles)))[: blocks * per].reshape(blocks, -1).mean(axis=1)
    if float(np.abs(turned).mean()) < _COHERENT:
        return None
    by_block = np.unwrap(np.angle(turned)) / (2 * np.pi)
    middle = (np.arange(blocks) + 0.5) * size - 0.5
    phase: NDArray[np.float64] = np.interp(np.arange(n), middle, by_block)
    return phase


def _pauses(intervals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Samples lost before each stamp of a host: in intervals far longer than all but the rarest, about as many as fit."""
    n = len(intervals)
    rare = min(max(math.ceil(n / _RARE), 3), n // 4)
    usual = float(np.partition(intervals, n - 1 - rare)[n - 1 - rare])
    long = intervals > _LONG * usual if usual > 0 else np.zeros(n, dtype=bool)
    if not long.any():
        return np.zeros(n + 1)
    mean = float(intervals[~long].mean())
    held = np.where(long, np.minimum(np.rint(intervals / mean) - 1, 2.0**52), 0.0)
    return np.concatenate(([0.0], np.cumsum(held)))


def _longest_piece(lost: NDArray[np.float64]) -> tuple[int, int, int]:
    """What is left when pauses are cut out until no more places are empty than filled; the pieces, 0 if too many."""
    start, stop, pieces = 0, len(lost), 1
    while lost[stop - 1] - lost[start] > stop - start:
        if pieces > _SPLITS:
            return start, stop, 0
        at = start + 1 + int(np.argmax(np.diff(lost[start:stop])))
        start, stop = (start, at) if at - start >= stop - at else (at, stop)
        pieces += 1
    if pieces > 1 and (stop - start < 4 or stop - start < _LEAST_LEFT * len(lost)):
        return start, stop, 0
    return start, stop, pieces
