"""Rows by turn: every second, third or fourth row of a log, in parts that are spread over its length."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

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
