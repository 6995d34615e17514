"""Detect rows of several sensors in one table: in a fixed order (turns), in no fixed order (groups), and slow noise
that two series of rows share.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import distinct, medians
from sigmatau.frozen import frozen

ROWS = 256
"""Number of rows in a part of the log. A lost row shifts the turns only in the parts after it."""
MIN_PARTS = 2
_UNEVEN = 0.618  # golden ratio, so that the distances between the parts have no period
_SAME = 0.8  # share of the parts that must have the same means by turn
# largest difference of the means of two parts, over the largest mean; a line that drifts in phase exceeds it
_TOLERANCE = 0.25
_TOLERANCE_ERRORS = 3.0  # the same over the standard error of a mean; both tolerances are added
_ERRORS = 6.0  # means are different if they differ by more than this number of standard errors
_EXCEPTIONS = 0.1  # share of the intervals that need not fit the groups
_SHORT = 0.25  # longest interval between two rows of one instant, over the mean interval
_MIN_STEPS = 16  # smallest number of distinct values of a turn in a part: a scatter of at least 3 steps
# Largest difference of the means of two turns of one sensor, over the scatter: 4 standard errors of a median.
_SAME_SENSOR = 0.3


@frozen
class TurnMeans:
    """Means of the rows of each turn."""

    # shape (channels, period), relative to the mean of all turns; 0 if they are not significant
    means: NDArray[np.float64]
    scatter: NDArray[np.float64]  # scatter of the rows of one turn, shape (channels,)
    # turn of the first row of each part; -1 for a part whose means differ from the others
    first_turns: NDArray[np.intp]


def starts_of_parts(rows: int, period: int, limit: int) -> list[int]:
    """First rows of at most `limit` parts. All begin with the same turn if no row is lost."""
    size = ROWS // period * period
    count = min(rows // size, limit)
    spread = np.arange(count) * _UNEVEN % 1  # evenly spaced parts would not show a line with the period of the spacing
    return [int(start) // period * period for start in (np.arange(count) + spread) / count * (rows - size)]


def rows_by_turn(column: NDArray[Any], starts: Sequence[int], period: int) -> NDArray[np.float64]:
    """Read the rows of a channel in all parts: shape (parts, rows / period, period)."""
    size = ROWS // period * period
    with np.errstate(invalid="ignore"):  # a damaged number may be a signalling NaN
        parts = [np.asarray(column[start : start + size], dtype=np.float64) for start in starts]
    return np.stack(parts).reshape(len(starts), size // period, period)


def means_by_turn(parts: NDArray[np.float64]) -> TurnMeans | None:
    """Means of each channel by turn; None if no channel has significant means.

    A channel has means of 0 if they are not significant, or not the same in most parts of the log. `parts`: shape (parts,
    rows, period, channels).
    """
    period, channels = parts.shape[2:]
    with np.errstate(invalid="ignore"):
        centred = parts - parts.mean(axis=2, keepdims=True)  # without motion and drift
        means = centred.mean(axis=1)  # (part, turn, channel)
        scatter = (centred.std(axis=1) * (period / (period - 1)) ** 0.5).mean(axis=1)
    finite = np.isfinite(means).all(axis=(1, 2))
    means, scatter = means[finite], scatter[finite]
    if len(means) < MIN_PARTS:
        return None
    error = scatter / parts.shape[1] ** 0.5
    sizes = np.ptp(means, axis=1)
    significant = (sizes > _ERRORS * error).mean(axis=0) >= _SAME
    if not significant.any():
        return None
    typical_scatter = medians(scatter)
    relative = np.divide(medians(sizes), typical_scatter, out=np.zeros(channels), where=typical_scatter > 0)
    clearest = int(np.argmax(np.where(significant, relative, -1.0)))
    aligned, distance = means.copy(), np.full((len(means), channels), np.inf)
    turns = np.zeros(len(means), dtype=np.intp)
    for turn in range(period):  # after a lost row the turns are shifted
        moved = np.roll(means, turn, axis=1)
        apart = np.abs(moved - means[0]).max(axis=1)
        closer = apart[:, clearest] < distance[:, clearest]
        aligned[closer], distance[closer], turns[closer] = moved[closer], apart[closer], turn
    allowed = _TOLERANCE * np.abs(means[0]).max(axis=0) + _TOLERANCE_ERRORS * medians(error)
    fits = distance <= allowed
    same = significant & (fits.mean(axis=0) >= _SAME)
    if not same.any():
        return None
    first_turns = np.full(len(parts), -1, dtype=np.intp)
    first_turns[finite] = np.where(fits[:, clearest], turns, -1)
    return TurnMeans(means=medians(aligned).T * same[:, None], scatter=typical_scatter, first_turns=first_turns)


def ratio_of_scatters(parts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Largest scatter of the rows of a turn over the smallest, by channel.

    1 if the rows of a turn have so few distinct values that rounding determines the scatter. `parts`: as in `means_by_turn`.
    """
    with np.errstate(invalid="ignore"):
        scatters = np.diff(parts, axis=1).std(axis=1)
        by_turn = medians(np.where(np.isfinite(scatters), scatters, np.inf))  # (turn, channel)
    smallest, largest = by_turn.min(axis=0), by_turn.max(axis=0)
    steps = np.count_nonzero(np.diff(np.sort(parts[0], axis=0), axis=0), axis=0).min(axis=0)
    fine = (smallest > 0) & np.isfinite(largest) & (steps >= _MIN_STEPS)
    return np.asarray(np.divide(largest, smallest, out=np.ones_like(largest), where=fine))


def is_bunched(stamps: NDArray[Any], period: int) -> bool:
    """Whether stamps come in groups of `period` rows, with short intervals within a group and a long one between groups."""
    with np.errstate(invalid="ignore"):
        intervals = np.diff(stamps).astype(np.float64)
        mean = float(np.mean(intervals))
    if not mean > 0:
        return False
    short = intervals < _SHORT * mean
    same = short[period:] == short[:-period]
    share, repeated = float(np.mean(short)), float(np.mean(same))
    return bool(abs(share - (period - 1) / period) < _EXCEPTIONS / 2 and repeated > 1 - _EXCEPTIONS)


def single_turn(means: NDArray[np.float64]) -> int | None:
    """Find the only turn whose means differ from those of all others; None if there is none.

    This is the row of a slow sensor after each two or three rows of a faster one. `means`: over the scatter, shape
    (channels, turns).
    """
    if means.shape[1] <= 2:
        return None
    spreads = [np.ptp(np.delete(means, turn, axis=1), axis=1).max() for turn in range(means.shape[1])]
    return int(np.argmin(spreads)) if min(spreads) <= _SAME_SENSOR else None


def shortest_period(means: NDArray[np.float64]) -> int:
    """Number of turns after which the means repeat, for example 2 if two sensors make four turns. `means`: over the scatter,
    shape (channels, turns).
    """
    count = means.shape[1]
    divisors = (period for period in range(1, count) if count % period == 0)
    return next((p for p in divisors if np.abs(np.roll(means, p, axis=1) - means).max() <= _SAME_SENSOR), count)


_MIN_ROWS = 512
_MIN_VALUES = 32  # smallest number of distinct values of an axis that is used: fewer mean a coarse resolution
_AXES = 2  # smallest number of axes in which the groups must differ
_EMPTY = 0.01  # share of the rows that may lie in the gap between two groups
_TAIL = 0.08  # share of the rows on each side that is ignored in the search for the gap
_GAP = 0.08  # smallest width of the gap, over the range of the rows without tails: white noise has 0.02, a line 0.017
_SHIFT = 2.0  # smallest difference of the means of both groups, over the scatter within them
_CHANGES = 0.02  # smallest share of the rows that are in another group than the row before: blocks of 50 rows
_LONGEST_PERIOD = 64  # longest period of a line that is locked to the samples [rows]
_LONGEST_OF_TWO_VALUES = 4  # longest period of a line that may have only two values [rows]
_EQUAL = 0.25  # largest difference of two means within a group, over the distance of the groups: noise makes 0.02
_PERIODIC = 0.95  # share of the rows whose place in the period determines their group


@frozen
class Groups:
    """Two groups of rows."""

    axis: int  # axis with the largest difference over its scatter
    size: float  # difference of the means of both groups on this axis [unit of the samples]


def find_groups(parts: NDArray[np.float64], starts: NDArray[np.intp]) -> Groups | None:
    """Find two groups of rows in no fixed order; None if there are none.

    `parts`: shape (parts, rows, channels); `starts`: the first row of each part, shape (parts,).
    """
    rows = (starts[:, None] + np.arange(parts.shape[1])).ravel()
    fine = [len(distinct(parts[..., k])) >= _MIN_VALUES for k in range(parts.shape[2])]
    parts = np.where(fine, parts, 0.0)
    x = (parts - parts.mean(axis=1, keepdims=True)).reshape(len(rows), -1)
    finite = np.isfinite(x).all(axis=1)
    x, rows = x[finite], rows[finite]
    scales = x.std(axis=0) if len(x) else np.zeros(0)
    if len(x) < _MIN_ROWS or np.count_nonzero(scales > 0) < _AXES:
        return None
    relative = x[:, scales > 0] / scales[scales > 0]
    projected = relative @ np.linalg.eigh(relative.T @ relative)[1][:, -1]
    border = _find_gap(projected)
    if border is None:
        return None
    above = projected > border
    if np.mean(above[1:] != above[:-1]) < _CHANGES or _is_line(projected, above, rows):
        return None
    sizes = x[above].mean(axis=0) - x[~above].mean(axis=0)
    scatter = np.sqrt((x[above].var(axis=0) + x[~above].var(axis=0)) / 2)
    shift = np.divide(np.abs(sizes), scatter, out=np.zeros_like(sizes), where=scatter > 0)
    if np.count_nonzero(shift >= _SHIFT) < _AXES:
        return None
    axis = int(np.argmax(shift))
    return Groups(axis=axis, size=float(abs(sizes[axis])))


def _find_gap(values: NDArray[np.float64]) -> float | None:
    """Middle of the widest interval that contains few values; None if it is not wide enough."""
    ordered = np.sort(values)
    tail, within = int(_TAIL * len(ordered)), max(int(_EMPTY * len(ordered)), 1)
    widths = ordered[tail + within : len(ordered) - tail] - ordered[tail : len(ordered) - tail - within]
    place = int(np.argmax(widths))
    if not widths[place] > _GAP * (ordered[-tail - 1] - ordered[tail]):
        return None
    return float(ordered[tail + place] + ordered[tail + place + within]) / 2


def _is_line(values: NDArray[np.float64], above: NDArray[np.bool_], rows: NDArray[np.intp]) -> bool:
    """Whether the place of a row in some period determines its group throughout the log, as for a line locked to the
    samples.

    Blocks of rows of several sensors are periodic too, but all rows of a group then have one mean.
    """
    for period in range(1, _LONGEST_PERIOD + 1):
        places = rows % period
        counts = np.bincount(places, minlength=period)
        above_counts = np.bincount(places, weights=above, minlength=period)
        if np.maximum(above_counts, counts - above_counts).sum() >= _PERIODIC * len(above):
            means = np.bincount(places, weights=values, minlength=period) / np.maximum(counts, 1)
            high, low = means[above_counts > counts / 2], means[above_counts <= counts / 2]
            within = max(np.ptp(high), np.ptp(low))
            return period <= _LONGEST_OF_TWO_VALUES or bool(within > _EQUAL * (high.mean() - low.mean()))
    return False


# The spectra of the sum and of the difference of two series are compared. A share is the power of the sum over the
# power of both together.

_MAX_BLOCKS = 4096  # largest number of means whose spectra are compared
_MIN_BLOCKS = 64
_FIRST_EDGE = 3  # upper edge of the first band; the bands above it are octaves
_TAPER = 0.25  # share of the series at either end that the window tapers
# variance of a mean share over that of independent shares: the window correlates neighbouring frequencies
_CORRELATED = 1.4
# smallest significant deviation of the mean share from 1/2, in standard errors: 11 bands are tested
_SHARE_ERRORS = 4.5
_COMMON_SHARE = 0.65  # smallest mean share of common noise; independent noise has 0.5
# smallest ratio of the power of a band of slow noise to that of the highest bands, for the sum and the difference
_SLOW_RISE = 3.0
_MIN_SHARES = 48  # smallest number of shares in bands of slow noise that can show independence: standard error 0.05
# largest deviation of the mean of such shares from 1/2 for independent noise; common slow noise of this rise has 0.28
_INDEPENDENT = 0.12

SlowNoise = Literal["in common", "independent", "not measured"]


def compare_slow_noise(first: NDArray[np.float64], second: NDArray[np.float64]) -> SlowNoise:
    """Determine whether two series of rows share their slow noise. `first` and `second`: shape (n, channels), without
    NaN.
    """
    n = len(first)
    size = max(1, n // _MAX_BLOCKS)
    blocks = n // size
    if blocks < _MIN_BLOCKS:
        return "not measured"
    first, second = (_over_white_noise(_block_means(x, blocks, size)) for x in (first, second))
    noisy = np.isfinite(first).all(axis=0) & np.isfinite(second).all(axis=0)
    if not noisy.any():
        return "not measured"
    power_of_sum, power_of_difference = (_power(x[:, noisy]) for x in (first + second, first - second))
    total = power_of_sum + power_of_difference
    shares = power_of_sum / np.maximum(total, np.finfo(np.float64).tiny)
    high = medians(total[len(total) // 2 :])
    slow = []
    for low, top in _bands(len(shares)):
        up_to_band = shares[1:top]
        error = (_CORRELATED / (12 * up_to_band.size)) ** 0.5
        if up_to_band.mean() - 0.5 > max(_SHARE_ERRORS * error, _COMMON_SHARE - 0.5):
            return "in common"
        # A line at half the rate is either in the sum or in the difference, hence the smaller power.
        powers = np.minimum(power_of_sum[low:top].mean(axis=0), power_of_difference[low:top].mean(axis=0))
        slow.append(shares[low:top, powers > _SLOW_RISE / 2 * high].ravel())
    slow_shares = np.concatenate(slow)
    if len(slow_shares) >= _MIN_SHARES and abs(slow_shares.mean() - 0.5) < _INDEPENDENT:
        return "independent"
    return "not measured"


def _block_means(x: NDArray[np.float64], blocks: int, size: int) -> NDArray[np.float64]:
    return np.asarray(x[: blocks * size].reshape(blocks, size, -1).mean(axis=1))


def _over_white_noise(means: NDArray[np.float64]) -> NDArray[np.float64]:
    """Subtract the mean of each series and divide by the scatter of its first differences; NaN if the scatter is 0."""
    scatter = np.diff(means, axis=0).std(axis=0)
    return np.asarray((means - means.mean(axis=0)) / np.where(scatter > 0, scatter, np.nan))


def _power(series: NDArray[np.float64]) -> NDArray[np.float64]:
    """Power at the Fourier frequencies, after tapering: shape (frequencies, channels)."""
    ends = (np.arange(len(series)) + 0.5) / (_TAPER * len(series))
    window = 0.5 - 0.5 * np.cos(np.pi * np.minimum(np.minimum(ends, ends[::-1]), 1))
    return np.asarray(np.abs(np.fft.rfft(window[:, None] * series, axis=0)) ** 2)


def _bands(frequencies: int) -> list[tuple[int, int]]:
    """Octaves of Fourier frequencies: first and end of each."""
    edges = [1, _FIRST_EDGE]
    while edges[-1] < frequencies:
        edges.append(min(2 * edges[-1], frequencies))
    return list(pairwise(edges))
