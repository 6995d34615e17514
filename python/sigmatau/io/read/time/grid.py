"""The grid of time stamps: its interval, and its empty places.

There are three kinds of stamps. Stamps of a sensor lie on a regular grid, with jitter, and with holes where samples were
lost. Stamps of a clock that is coarser than the sampling repeat, but deviate from a straight line by at most one step of the
clock. Stamps of a host come in bunches: the samples are then treated as evenly spaced, and the stamps only provide the
mean rate.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import distinct, median
from sigmatau.io.read.time.clock_line import BLOCK, GridFit, about_line, make_grid_fit

_MAX_INTERVALS = 1 << 16  # intervals used for medians and quantiles
_MAX_PHASES = 1 << 18  # stamps whose phase is computed
# No sample is lost if all intervals are within relative limits, and their relative standard deviation is small.
_EVEN_INTERVALS = (0.5, 1.5)  # relative limits of the intervals
_EVEN_SCATTER = 0.12  # largest standard deviation of the intervals, over their mean
_SHORT_INTERVAL = 0.5  # share of the sample interval below which an interval belongs to a burst
_MAX_SHORT = 0.05  # share of short intervals above which stamps are of a host: jitter of 0.2 intervals makes 0.039
# Mean resultant length of the phases of a grid: 0.45 for jitter of 0.2 intervals, 0.11 for 64 random phases.
_MIN_COHERENCE = 0.4
_MAX_MOVED = 0.05  # largest share of stamps that are closer to a neighbouring place than to theirs
# distance from an integer multiple up to which a difference determines a number of intervals [intervals]
_NEAR_MULTIPLE = 0.35
_PAUSE_RARITY = 1000  # smallest number of intervals per pause, in stamps of a host
_PAUSE_LENGTH = 20.0  # smallest length of a pause, over that of the other intervals
_EQUAL_INTERVALS = 1e-3  # relative difference up to which two intervals count as equal
_FINE_QUANTILE = 0.15  # quantile of the intervals that belongs to a grid finer than that of the median
_MIN_FIT = 0.5  # smallest mean cosine of the intervals for which a grid fits them
_FINER = 0.8  # a finer grid has at most this share of the interval
_MAX_PAUSES = 64
# root mean square distance from the grid up to which stamps are of the sensor's clock [intervals]
_EXACT_STAMPS = 0.05
_MAX_LOSSES = 4  # largest number of random losses that exact stamps may show, over the number of samples
_SHARE_ERROR = 0.25  # largest relative error of the share of single intervals, if losses are random
_INTERVAL_CORRELATION = 0.15  # largest correlation of neighbouring intervals, if losses are random
_COARSE = 2.0  # length of a clock step that alone causes bunches [intervals]
_ONE_STEP = 1.05  # deviation of evenly spaced samples, with a little jitter, from a line [steps of the clock]
_MIN_PIECE = 0.1  # share of the rows that the longest piece between pauses must have


def resolution(intervals: NDArray[Any], largest: float) -> float:
    """The resolution of the clock if the intervals are whole multiples of a decimal step; else 0. `largest`: largest
    absolute value of the stamps, which limits the accuracy of the intervals.
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


@np.errstate(over="ignore", invalid="ignore")  # a stamp may be arbitrarily wrong
def fit_grid(
    t: NDArray[np.float64], intervals: NDArray[np.float64], step: float, *, stated_interval: float | None = None
) -> GridFit:
    """The grid of stamps.

    Notes
    -----
    Evenly spaced samples on a coarse clock and samples with every k-th one lost can have the same stamps: 80 Hz in steps of
    10 ms, and 100 Hz without every fifth sample. The beat of two clocks does not remain a short pattern for long, so a
    pattern that repeats to the end of the record consists of losses.

    The first estimate of the interval is the median, which is refined over increasing lags: the intervals in a lag are
    counted, so that lost samples do not bias it. The phase of the stamps modulo the interval is averaged on the circle in
    blocks of 64: it is not affected by lost samples, and follows a clock that drifts or steps by a part of an interval. The
    place of a stamp is its time minus that phase, rounded; neighbours correct a stamp that is late or early by more than
    half an interval. The returned interval is the slope of the least-squares line of stamp against place.

    `t` are the stamps minus the first one, not decreasing, n ≥ 2, the last larger than the first. `step` is the
    resolution of their clock, from `resolution`. `stated_interval`, given by the user, decides if the stamps fit two
    grids.
    """
    n = len(t)
    mean = float(t[-1] - t[0]) / (n - 1)
    some = intervals[:: max(n // _MAX_INTERVALS, 1)]
    usual = median(some)
    even = _EVEN_INTERVALS[0] * mean < float(intervals.min()) and float(intervals.max()) < _EVEN_INTERVALS[1] * mean
    if even and float(np.std(some)) < _EVEN_SCATTER * mean:
        return make_grid_fit(t, None, "grid", usual, None)
    if (stairs := _stairs(intervals, t, step)) is not None:
        interval, bound = stairs
        longest = interval if bound == math.inf else interval * (1 + bound)
        interval = (
            stated_interval if stated_interval and interval * (1 - bound) <= stated_interval <= longest else interval
        )
        coarse = make_grid_fit(t, None, "coarse", usual, intervals)
        return replace(coarse, interval=interval, error=bound * interval, drift=None, bound=bound)
    if _even_line(t, intervals, step):
        period = pattern(intervals, step)
        stated = (
            bool(stated_interval) and period > 0 and abs(cast("float", stated_interval) / step - 1) < _EQUAL_INTERVALS
        )
        even_stated = bool(stated_interval) and abs(cast("float", stated_interval) / mean - 1) < _EQUAL_INTERVALS
        if stated or (is_loss_pattern(period, n) and not even_stated):
            filled: NDArray[np.int64] = np.rint(t / step).astype(np.int64)
            return make_grid_fit(t, filled, "grid", usual, intervals, period=0 if stated else period)
        kind_: Literal["grid", "coarse"] = "grid" if intervals.all() else "coarse"
        return make_grid_fit(t, None, kind_, usual, intervals, period=0 if even_stated else period)
    kind: Literal["grid", "host"] = "grid"
    lost = _places(t, intervals, usual)
    if lost is None and is_jitter_only(t):
        return make_grid_fit(t, None, "grid", usual, intervals)
    if lost is None:
        kind, lost = "host", _pauses(intervals)
    # Random losses are not pauses; there are at most 4 times as many as samples.
    random = kind == "grid" and _scattered(lost) and float(lost[-1] - lost[0]) <= 1.1 * _MAX_LOSSES * n
    start, stop, pieces = (0, n, 1) if random else _longest_piece(lost)
    if not pieces:
        return make_grid_fit(t, None, "host", usual, intervals, pieces=0)
    lost = lost[start:stop] - lost[start]
    places = np.arange(stop - start) + lost.astype(np.int64) if lost[-1] > 0 else None
    fitted = make_grid_fit(t[start:stop], places, kind, usual, intervals[start : stop - 1], start=start, pieces=pieces)
    return fitted if kind == "grid" else _by_ticks(fitted, t[start:stop], intervals[start : stop - 1], step)


def _stairs(intervals: NDArray[np.float64], t: NDArray[np.float64], step: float) -> tuple[float, float] | None:
    """The interval between the first and the last step of a clock with few steps, and its largest relative error; None for
    other stamps.

    A step is one sample wide, whereas a staircase changes the slope of the least-squares line by up to 1/steps². After a
    single step the interval is the longest possible one; it has no lower limit.
    """
    n, up = len(t), np.flatnonzero(intervals) + 1
    if not (step > 0 and len(up) ** 2 < n):
        return None
    if len(up) == 1:
        return float(t[-1]) / max(up[0] - 1, n - up[0] - 1, 1), math.inf
    first, last = int(up[0]), int(up[-1])
    interval = float(t[last] - t[first]) / (last - first)
    width = float(np.ptp(t - interval * np.arange(n)))
    if width > _ONE_STEP * step + interval:
        return None
    # number of samples by which ticks are late, beyond the one sample of any staircase
    late = (width - step) / interval
    return interval, max(1.0, late) / (last - first)


def _by_ticks(fitted: GridFit, t: NDArray[np.float64], intervals: NDArray[np.float64], step: float) -> GridFit:
    """Correct the interval of bunches from a coarse clock: use the samples between its first and last tick.

    Other bunches, and those of a piece with pauses, are not changed.
    """
    ticks = np.flatnonzero(intervals) + 1
    single = np.abs(intervals[ticks - 1] - step) < 0.5 * step
    if not (step > _COARSE * fitted.interval and len(ticks) > 2 and single.all()):
        return fitted
    first, last = int(ticks[0]), int(ticks[-1])
    interval = float(t[last] - t[first]) / (last - first)
    counts = np.diff(ticks)
    bound = max(1.0, float(np.ptp(counts))) / (last - first)
    return replace(fitted, kind="coarse", interval=interval, error=bound * interval, drift=None, bound=bound)


def _even_line(t: NDArray[np.float64], intervals: NDArray[np.float64], step: float) -> bool:
    """Whether evenly spaced samples would have these stamps on a clock with this step."""
    n = len(t)
    mean = float(t[-1] - t[0]) / (n - 1)
    if not step > 0 or step < 1e-6 * mean:
        return False
    # A lost sample moves the line by at most one interval: with a step of about one interval, several are needed.
    if (
        step >= _SHORT_INTERVAL * mean
        and np.count_nonzero(np.abs(intervals - np.rint(mean / step) * step) > 0.5 * step) < 5
    ):
        return False
    rest, _, _ = about_line(t, np.arange(n, dtype=np.float64))
    return bool(np.ptp(rest) <= _ONE_STEP * step)


def _places(t: NDArray[np.float64], intervals: NDArray[np.float64], median: float) -> NDArray[np.float64] | None:
    """Samples lost before each stamp, from 0 and not decreasing; None if the stamps do not lie on a grid."""
    n = len(t)
    usual = intervals[(intervals > 0.4 * median) & (intervals < 1.6 * median)] if median > 0 else intervals[:0]
    if not len(usual):
        return None
    interval = _refined(t, float(usual.mean()))
    if _cosine(intervals, interval) < _MIN_FIT:
        finer = _finer(t, intervals)
        interval = finer if 0 < finer < _FINER * interval else interval
    if np.count_nonzero(intervals < _SHORT_INTERVAL * interval) > _MAX_SHORT * len(intervals):
        return None
    late = t / interval - np.arange(n)
    if not np.abs(late).max() < 2**52:
        return None if np.abs(late).max() >= 2**1000 or not np.isfinite(late).all() else _estimate_coarse_losses(late)
    phase = _phase(late)
    if phase is None:
        return None
    lost: NDArray[np.float64] = np.rint(late - phase)
    single, lost = lost, consistent_losses(lost, late - phase)
    if np.count_nonzero(lost != single) > _MAX_MOVED * n:
        return None
    if _scattered(lost) and not _lost_at_random(lost, late - phase - lost):
        return None
    return np.asarray(lost - lost[0])


def _cosine(intervals: NDArray[np.float64], interval: float) -> float:
    """Mean cosine: 1 if the intervals are whole multiples of `interval`, about 0 or less if not."""
    some = intervals[:: max(len(intervals) // _MAX_INTERVALS, 1)] / interval
    return float(np.mean(np.cos(2 * np.pi * (some - np.rint(some)))))


def _finer(t: NDArray[np.float64], intervals: NDArray[np.float64]) -> float:
    """The interval of a finer grid than that of the median that fits the intervals; 0 if there is none."""
    some = intervals[:: max(len(intervals) // _MAX_INTERVALS, 1)]
    place = int((len(some) - 1) * _FINE_QUANTILE)
    low = float(np.partition(some, place)[place])
    typical = some[(some > 0.7 * low) & (some < 1.4 * low)] if low > 0 else some[:0]
    if not len(typical):
        return 0.0
    interval = _refined(t, float(typical.mean()))
    return interval if _cosine(intervals, interval) > _MIN_FIT else 0.0


def _lost_at_random(lost: NDArray[np.float64], off: NDArray[np.float64]) -> bool:
    """Whether exact stamps show independent losses, up to four of five samples, rather than bunches of a host. If
    samples are lost at random with probability p, the share 1 - p of the intervals is single, and neighbouring
    intervals are independent. Intervals of bunches are correlated, and more of them are short than their mean allows.
    """
    n = len(lost)
    holes = np.diff(lost)
    if n < BLOCK or float(lost[-1] - lost[0]) > 1.1 * _MAX_LOSSES * n or float(np.mean(off * off)) > _EXACT_STAMPS**2:
        return False
    whole, present = float(np.mean(holes == 0)), n / (n + float(lost[-1] - lost[0]))
    some = holes - holes.mean()
    alike = float(some[1:] @ some[:-1]) / max(float(some @ some), 1e-300)
    return abs(whole / present - 1) < _SHARE_ERROR + 3 / math.sqrt(n * present) and abs(
        alike
    ) < _INTERVAL_CORRELATION + 3 / math.sqrt(n)


def _scattered(lost: NDArray[np.float64]) -> bool:
    """Whether most places outside of pauses are empty: the interval within bunches was mistaken for the sample interval."""
    n = len(lost)
    if lost[-1] - lost[0] <= n:
        return False
    holes = np.sort(np.diff(lost))
    return bool(holes[: n - 1 - min(max(math.ceil(n / _PAUSE_RARITY), 3), n // 4)].sum() > n)


def _estimate_coarse_losses(late: NDArray[np.float64]) -> NDArray[np.float64]:
    """Estimate losses without a phase, for stamps that are too far apart to have a phase."""
    lost: NDArray[np.float64] = np.rint(np.minimum.accumulate(late[::-1])[::-1] - late[0])
    return lost


def _refined(t: NDArray[np.float64], interval: float) -> float:
    """Refine the interval by differences over increasing lags; the intervals in each lag are counted."""
    n = len(t)
    lag = 1
    while 4 * lag <= max(n - 1, 4) and lag < n:
        starts = np.arange(0, n - lag, max((n - lag) // 16384, 1))
        spans = t[starts + lag] - t[starts]
        counts = np.rint(spans / interval)
        good = (counts > 0) & (counts < 4.0 * lag + 4)
        close = good & (np.abs(spans / interval - counts) < _NEAR_MULTIPLE)
        if 2 * np.count_nonzero(close) < len(starts):
            break
        # The mean is circular: a mean of only the small differences would be biased towards the previous interval.
        turned = np.mean(np.exp(2j * np.pi * (spans[good] / interval - counts[good])))
        off = float(np.angle(turned)) / (2 * np.pi)
        interval *= 1 + off / float(counts[good].mean())
        if lag >= 4096:
            break
        lag *= 4
    return interval


def _phase(late: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """The phase of each stamp on the grid, in intervals, by its neighbours; None if they are not coherent."""
    n = len(late)
    stride = max(n // _MAX_PHASES, 1)
    size = BLOCK * stride
    blocks = max(n // size, 1)
    size = min(size, n)
    angles = late[: blocks * size : stride] if n >= size else late
    per = math.ceil(size / stride)
    turned = np.exp(2j * np.pi * (angles - np.rint(angles)))[: blocks * per].reshape(blocks, -1).mean(axis=1)
    if float(np.abs(turned).mean()) < _MIN_COHERENCE:
        return None
    by_block = np.unwrap(np.angle(turned)) / (2 * np.pi)
    middle = (np.arange(blocks) + 0.5) * size - 0.5
    phase: NDArray[np.float64] = np.interp(np.arange(n), middle, by_block)
    return phase


def _pauses(intervals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Estimated losses before each stamp of a host: the samples that fit into each pause."""
    n = len(intervals)
    rare = min(max(math.ceil(n / _PAUSE_RARITY), 3), n // 4)
    usual = float(np.partition(intervals, n - 1 - rare)[n - 1 - rare])
    long = intervals > _PAUSE_LENGTH * usual if usual > 0 else np.zeros(n, dtype=bool)
    if not long.any():
        return np.zeros(n + 1)
    mean = float(intervals[~long].mean())
    held = np.where(long, np.minimum(np.rint(intervals / mean) - 1, 2.0**52), 0.0)
    return np.concatenate(([0.0], np.cumsum(held)))


def _longest_piece(lost: NDArray[np.float64]) -> tuple[int, int, int]:
    """The longest piece after cutting at pauses until at most half of the places are empty; the number of pieces, 0 if too
    many.
    """
    start, stop, pieces = 0, len(lost), 1
    while lost[stop - 1] - lost[start] > stop - start:
        if pieces > _MAX_PAUSES:
            return start, stop, 0
        border = start + 1 + int(np.argmax(np.diff(lost[start:stop])))
        start, stop = (start, border) if border - start >= stop - border else (border, stop)
        pieces += 1
    if pieces > 1 and (stop - start < 4 or stop - start < _MIN_PIECE * len(lost)):
        return start, stop, 0
    return start, stop, pieces


_WINDOW = 4  # number of rows on each side whose median determines the place of a stamp
# -ln of the probability of a loss at a row; a loss is accepted if the alternative jitter is less likely
_LOSS_PRIOR = 8.0
# largest jitter over the interval: bunches of two rows have 0.5, larger ones more; this jitter swaps 5 % of the rows
_MAX_JITTER = 0.45
# largest correlation of neighbours: 0.06 for sorted jitter of 0.4, -1 for bunches of two rows, -0.5 for three
_MAX_CORRELATION = 0.15
# The means of two blocks with one block between them differ by a whole interval if a sample is lost. With a jitter of
# 0.45 alone the difference has a standard deviation of 0.08, and reaches half an interval once in 1e9 blocks.
_LOST_SAMPLE = 0.5
_MIN_BLOCKS = 4


def is_jitter_only(t: NDArray[np.float64]) -> bool:
    """Whether the stamps are those of evenly spaced samples without losses, with independent jitter and without bunches.

    Notes
    -----
    With jitter of more than 0.2 intervals the places of single stamps are uncertain, and so is their phase. They are not
    needed if no sample is lost.
    """
    blocks = len(t) // BLOCK
    if blocks < _MIN_BLOCKS:
        return False
    rest, interval, _ = about_line(t, np.arange(len(t), dtype=np.float64))
    parts = (rest / interval)[: blocks * BLOCK].reshape(blocks, BLOCK)
    means = parts.mean(axis=1)
    if not np.abs(means[2:] - means[:-2]).max() < _LOST_SAMPLE:
        return False
    parts = parts - means[:, None]
    square = float(np.mean(parts * parts)) * BLOCK / (BLOCK - 1)
    together = float(np.mean(parts[:, 1:] * parts[:, :-1])) + square / BLOCK
    return 0 < square < _MAX_JITTER**2 and abs(together / square) < _MAX_CORRELATION + 3 / math.sqrt(len(t))


def consistent_losses(lost: NDArray[np.float64], rest: NDArray[np.float64]) -> NDArray[np.float64]:
    """Samples lost before each stamp, made non-decreasing, from the estimates of single stamps."""
    jitter_limit = 0.5 + _LOSS_PRIOR * float(np.mean((rest - lost) ** 2))
    lost = _correct_ends(lost.copy(), rest, jitter_limit)
    falls = np.flatnonzero(np.diff(lost) < 0)
    return _correct_falls(_correct_by_neighbours(lost, falls, rest, jitter_limit)) if len(falls) else lost


def _correct_ends(lost: NDArray[np.float64], rest: NDArray[np.float64], jitter_limit: float) -> NDArray[np.float64]:
    """Remove the loss of one sample at the first or last stamp if jitter is more likely; no neighbours decide there."""
    if len(lost) > 2:
        if lost[-1] - lost[-2] == 1 and rest[-1] - lost[-2] < jitter_limit:
            lost[-1] = lost[-2]
        if lost[1] - lost[0] == 1 and lost[1] - rest[0] < jitter_limit:
            lost[0] = lost[1]
    return lost


def _correct_falls(lost: NDArray[np.float64]) -> NDArray[np.float64]:
    """Correct late or early stamps so that losses never decrease, and so that few stamps move."""
    late = np.minimum.accumulate(lost[::-1])[::-1]
    early = np.maximum.accumulate(lost)
    return late if np.count_nonzero(late != lost) <= np.count_nonzero(early != lost) else early


def _correct_by_neighbours(
    lost: NDArray[np.float64], falls: NDArray[np.intp], rest: NDArray[np.float64], jitter_limit: float
) -> NDArray[np.float64]:
    """Replace estimates that contradict the median of their neighbours; estimates in order are kept. Next to a loss the
    median may be wrong by one, so a stamp is moved by one place only if its jitter makes that likely.
    """
    n, width = len(lost), 2 * _WINDOW + 1
    if n < width:
        return lost
    contradicting = distinct(np.clip(falls[:, None] + np.arange(-_WINDOW, _WINDOW + 2), 0, n - 1))
    windows = np.clip(contradicting[:, None] + np.arange(-_WINDOW, _WINDOW + 1), 0, n - 1)
    medians = np.median(lost[windows], axis=1)
    before, after = lost[np.maximum(contradicting - 1, 0)], lost[np.minimum(contradicting + 1, n - 1)]
    fits = (before <= lost[contradicting]) & (lost[contradicting] <= after)
    stays = (
        fits & (np.abs(medians - lost[contradicting]) == 1) & (np.abs(rest[contradicting] - medians) >= jitter_limit)
    )
    mended = lost.copy()
    mended[contradicting] = np.where(stays, lost[contradicting], medians)
    return mended


_MAX_PERIOD = 32  # longest period [rows]; a longer pattern is attributed to a clock coarser than the samples
# shortest pattern over the square of its period [rows]: the beat of two clocks is not periodic for so long
_MIN_LENGTH = 20
_MIN_SINGLE = 0.3  # share of intervals that are one interval of the sensor


def pattern(intervals: NDArray[np.float64], step: float) -> int:
    """The period in rows of a pattern of intervals, the shortest of them one step of the clock; 0 if there is no pattern."""
    counts = np.rint(intervals / step)
    single = counts == 1
    if counts.min() < 1 or np.count_nonzero(single) < _MIN_SINGLE * len(counts) or single.all():
        return 0
    # From the end of one run of single steps to the end of the next.
    ends = np.flatnonzero(single[:-1] & ~single[1:])
    if len(ends) < 3:
        return 0
    period = int(median(np.diff(ends)))
    return period if np.array_equal(counts[period:], counts[:-period]) else 0


def is_loss_pattern(period: int, n: int) -> bool:
    """Whether a pattern is too short, in too many stamps, to be the beat of two clocks."""
    return 0 < period <= _MAX_PERIOD and n >= _MIN_LENGTH * period**2
