"""Rows by turn, the groups that rows in no fixed order form, and the slow noise that rows of one sensor have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

ROWS = 256
"""Rows of a part: a lost row changes the turns in the parts after it."""
MIN_PARTS = 2
_UNEVEN = 0.618  # the golden ratio: the distances of the parts have no period
_SAME = 0.8  # share of the parts that must have the same means
_TOLERANCE = 0.25  # difference of the means of two parts, over the largest mean; a line that drifts in phase exceeds it
_TOLERANCE_ERRORS = 3.0  # the same, over the standard error of a mean: added
_ERRORS = 6.0  # means that are different, over their standard error
_EXCEPTIONS = 0.1  # share of the intervals that may not fit the groups
_SHORT = 0.25  # interval between two rows of one instant, over the mean interval
_FEWEST_STEPS = 16  # between the values of the rows of a turn in a part: a scatter of 3 steps and more
# Difference of the means of two turns of one sensor, over the scatter: 4 standard errors of a median.
_SAME_SENSOR = 0.3


@dataclass(frozen=True, slots=True, kw_only=True)
class TurnMeans:
    """Means of the rows of each turn."""

    means: NDArray[np.float64]  # shape (channels, period), without the common mean; 0 if they are not significant
    scatter: NDArray[np.float64]  # of the rows of one turn, shape (channels,)
    first_turns: NDArray[np.intp]  # turn of the first row of each part, -1 if its means are not those of the others


def starts_of_parts(rows: int, period: int, limit: int) -> list[int]:
    """First rows of at most `limit` parts, all of the same turn if no row is lost."""
    size = ROWS // period * period
    count = min(rows // size, limit)
    spread = np.arange(count) * _UNEVEN % 1  # even distances would hide a line of that period
    return [int(start) // period * period for start in (np.arange(count) + spread) / count * (rows - size)]


def rows_by_turn(column: NDArray[Any], starts: Sequence[int], period: int) -> NDArray[np.float64]:
    """The rows of a channel in all parts: shape (parts, rows / period, period)."""
    size = ROWS // period * period
    with np.errstate(invalid="ignore"):  # a damaged number may be a signalling NaN
        parts = [np.asarray(column[start : start + size], dtype=np.float64) for start in starts]
    return np.stack(parts).reshape(len(starts), size // period, period)


def means_by_turn(parts: NDArray[np.float64]) -> TurnMeans | None:
    """Means of each channel by turn. Channels whose means are not significant, or not the same in most parts of the log,
    are 0; None if all are. `parts`: shape (parts, rows, period, channels).
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
    typical_scatter = np.median(scatter, axis=0)
    relative = np.divide(np.median(sizes, axis=0), typical_scatter, out=np.zeros(channels), where=typical_scatter > 0)
    lead = int(np.argmax(np.where(significant, relative, -1.0)))
    aligned, distance = means.copy(), np.full((len(means), channels), np.inf)
    turns = np.zeros(len(means), dtype=np.intp)
    for turn in range(period):  # after a lost row the turns are shifted
        moved = np.roll(means, turn, axis=1)
        apart = np.abs(moved - means[0]).max(axis=1)
        closer = apart[:, lead] < distance[:, lead]
        aligned[closer], distance[closer], turns[closer] = moved[closer], apart[closer], turn
    allowed = _TOLERANCE * np.abs(means[0]).max(axis=0) + _TOLERANCE_ERRORS * np.median(error, axis=0)
    fits = distance <= allowed
    same = significant & (fits.mean(axis=0) >= _SAME)
    if not same.any():
        return None
    first_turns = np.full(len(parts), -1, dtype=np.intp)
    first_turns[finite] = np.where(fits[:, lead], turns, -1)
    return TurnMeans(
        means=np.median(aligned, axis=0).T * same[:, None], scatter=typical_scatter, first_turns=first_turns
    )


def ratio_of_scatters(parts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Largest over smallest scatter of the rows of a turn, of each channel; 1 where the rows of a turn have few values, of
    which rounding makes the scatter. `parts`: as in `means_by_turn`.
    """
    with np.errstate(invalid="ignore"):
        scatters = np.diff(parts, axis=1).std(axis=1)
        by_turn = np.median(np.where(np.isfinite(scatters), scatters, np.inf), axis=0)  # (turn, channel)
    smallest, largest = by_turn.min(axis=0), by_turn.max(axis=0)
    steps = np.count_nonzero(np.diff(np.sort(parts[0], axis=0), axis=0), axis=0).min(axis=0)
    fine = (smallest > 0) & np.isfinite(largest) & (steps >= _FEWEST_STEPS)
    return np.asarray(np.divide(largest, smallest, out=np.ones_like(largest), where=fine))


def is_bunched(stamps: NDArray[Any], period: int) -> bool:
    """Whether stamps come in groups of `period` rows: short intervals within, and one long one after each."""
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
    """The only turn whose means are not those of all others, as one row of a slow sensor has for each two or three rows of a
    faster one; None if there is none. `means`: over the scatter, shape (channels, turns).
    """
    if means.shape[1] <= 2:
        return None
    spreads = [np.ptp(np.delete(means, turn, axis=1), axis=1).max() for turn in range(means.shape[1])]
    return int(np.argmin(spreads)) if min(spreads) <= _SAME_SENSOR else None


def shortest_period(means: NDArray[np.float64]) -> int:
    """The number of turns after which the means repeat: 2 of four turns that two sensors make. `means`: over the scatter,
    shape (channels, turns).
    """
    count = means.shape[1]
    divisors = (period for period in range(1, count) if count % period == 0)
    return next((p for p in divisors if np.abs(np.roll(means, p, axis=1) - means).max() <= _SAME_SENSOR), count)


_FEWEST_ROWS = 512
_FEWEST_VALUES = 32  # of an axis: fewer are of a coarse resolution
_AXES = 2  # that must differ
_EMPTY = 0.01  # share of the rows in the gap between two groups
_TAIL = 0.08  # share of the rows on each side of the gap
_GAP = 0.08  # width of the gap, over the range of the rows without tails: 0.02 for white noise, 0.017 for a line
_SHIFT = 2.0  # difference of the means of both groups, over the scatter within them
_CHANGES = 0.02  # share of the rows that are of another group than the row before: blocks of 50 rows
_LONGEST_PERIOD = 64  # of a line that is locked to the samples [rows]
_LONGEST_OF_TWO_VALUES = 4  # period of a line that may have two values [rows]
_EQUAL = 0.25  # difference of two means of a group, over the distance of the groups: 0.02 of it is noise
_PERIODIC = 0.95  # share of the rows that have the group of their place in the period


@dataclass(frozen=True, slots=True, kw_only=True)
class Groups:
    """Two groups of rows."""

    axis: int  # with the largest difference, over its scatter
    size: float  # difference of the means of this axis [unit of the samples]


def find_groups(parts: NDArray[np.float64], starts: NDArray[np.intp]) -> Groups | None:
    """The groups of rows that are in no fixed order; None if there are none.

    `parts`: shape (parts, rows, channels); `starts`: the first row of each part, shape (parts,).
    """
    rows = (starts[:, None] + np.arange(parts.shape[1])).ravel()
    fine = [len(np.unique(parts[..., k])) >= _FEWEST_VALUES for k in range(parts.shape[2])]
    parts = np.where(fine, parts, 0.0)
    x = (parts - parts.mean(axis=1, keepdims=True)).reshape(len(rows), -1)
    finite = np.isfinite(x).all(axis=1)
    x, rows = x[finite], rows[finite]
    scales = x.std(axis=0) if len(x) else np.zeros(0)
    if len(x) < _FEWEST_ROWS or np.count_nonzero(scales > 0) < _AXES:
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
    """The middle of the widest interval with few values, if it is wide."""
    ordered = np.sort(values)
    tail, within = int(_TAIL * len(ordered)), max(int(_EMPTY * len(ordered)), 1)
    widths = ordered[tail + within : len(ordered) - tail] - ordered[tail : len(ordered) - tail - within]
    place = int(np.argmax(widths))
    if not widths[place] > _GAP * (ordered[-tail - 1] - ordered[tail]):
        return None
    return float(ordered[tail + place] + ordered[tail + place + within]) / 2


def _is_line(values: NDArray[np.float64], above: NDArray[np.bool_], rows: NDArray[np.intp]) -> bool:
    """Whether the place of a row in a period tells its group, in the whole log, as a line does that is locked to the
    samples. Blocks of rows of several sensors are periodic as well, but their rows have one mean in each group.
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


_MOST_BLOCKS = 4096  # means of rows whose spectra are compared
_FEWEST_BLOCKS = 64
_FIRST_EDGE = 3  # upper edge of the first band: bands are octaves above it
_TAPER = 0.25  # share of a series at either end that the window tapers
_CORRELATED = 1.4  # variance of a mean share over that of independent ones: the window makes neighbours alike
_SHARE_ERRORS = (
    4.5  # deviation of the mean share from 1/2 that is significant, in standard errors: 11 bands are looked at
)
_COMMON_SHARE = 0.65  # mean share of noise in common: 0.5 for independent noise
_SLOW_RISE = 3.0  # power of a band over that of the highest ones, of sum and difference: above the white noise
_FEWEST_SHARES = 48  # in bands of slow noise, to tell that it is independent: standard error 0.05
_INDEPENDENT = 0.12  # largest deviation of their mean from 1/2; 0.28 for slow noise in common of this rise

SlowNoise = Literal["in common", "independent", "not measured"]


def compare_slow_noise(first: NDArray[np.float64], second: NDArray[np.float64]) -> SlowNoise:
    """Whether the slow noise of two series of rows is in common. `first`, `second`: shape (n, channels), without NaN."""
    n = len(first)
    size = max(1, n // _MOST_BLOCKS)
    blocks = n // size
    if blocks < _FEWEST_BLOCKS:
        return "not measured"
    first, second = (_over_white_noise(_block_means(x, blocks, size)) for x in (first, second))
    noisy = np.isfinite(first).all(axis=0) & np.isfinite(second).all(axis=0)
    if not noisy.any():
        return "not measured"
    power_of_sum, power_of_difference = (_power(x[:, noisy]) for x in (first + second, first - second))
    total = power_of_sum + power_of_difference
    shares = power_of_sum / np.maximum(total, np.finfo(np.float64).tiny)
    high = np.median(total[len(total) // 2 :], axis=0)
    slow = []
    for low, top in _bands(len(shares)):
        up_to_band = shares[1:top]
        error = (_CORRELATED / (12 * up_to_band.size)) ** 0.5
        if up_to_band.mean() - 0.5 > max(_SHARE_ERRORS * error, _COMMON_SHARE - 0.5):
            return "in common"
        powers = np.minimum(power_of_sum[low:top].mean(axis=0), power_of_difference[low:top].mean(axis=0))
        # A line at half the rate is in one of them only.
        slow.append(shares[low:top, powers > _SLOW_RISE / 2 * high].ravel())
    slow_shares = np.concatenate(slow)
    if len(slow_shares) >= _FEWEST_SHARES and abs(slow_shares.mean() - 0.5) < _INDEPENDENT:
        return "independent"
    return "not measured"


def _block_means(x: NDArray[np.float64], blocks: int, size: int) -> NDArray[np.float64]:
    return np.asarray(x[: blocks * size].reshape(blocks, size, -1).mean(axis=1))


def _over_white_noise(means: NDArray[np.float64]) -> NDArray[np.float64]:
    """Series without their means, over the scatter of differences of neighbours; NaN if it is 0."""
    scatter = np.diff(means, axis=0).std(axis=0)
    return np.asarray((means - means.mean(axis=0)) / np.where(scatter > 0, scatter, np.nan))


def _power(series: NDArray[np.float64]) -> NDArray[np.float64]:
    """Power at the Fourier frequencies, with a tapered window: shape (frequencies, channels)."""
    ends = (np.arange(len(series)) + 0.5) / (_TAPER * len(series))
    window = 0.5 - 0.5 * np.cos(np.pi * np.minimum(np.minimum(ends, ends[::-1]), 1))
    return np.asarray(np.abs(np.fft.rfft(window[:, None] * series, axis=0)) ** 2)


def _bands(frequencies: int) -> list[tuple[int, int]]:
    """Octaves of Fourier frequencies: first and end of each."""
    edges = [1, _FIRST_EDGE]
    while edges[-1] < frequencies:
        edges.append(min(2 * edges[-1], frequencies))
    return list(pairwise(edges))
