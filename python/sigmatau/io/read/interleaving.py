"""Rows of several sensors in turn, without a column that tells them: found from the means by turn.

Each sensor has its bias, so the means of the rows differ from turn to turn and stay so. A line at half, a third or a quarter
of the sampling rate makes such means for a while, and a converter with two phases makes small ones. `find_interleaving` says
how they are told apart.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError

_PARTS = 16  # parts of the log that are tested, over its whole length: a line that is not locked to the samples drifts
_ROWS = 256  # rows of a part: a lost row changes the turns in the parts after it
_UNEVEN = 0.618  # the golden ratio: the distances of the parts have no period
_MIN_PARTS = 2
_PERIODS = (4, 3, 2)  # sensors in turn
_SAME = 0.8  # share of the parts that must have the same means
_TOLERANCE = 0.25  # difference of the means of two parts, over the largest mean; a line that drifts in phase exceeds it
_TOLERANCE_ERRORS = 3.0  # the same, over the standard error of a mean: added
_ERRORS = 6.0  # means that are different, over their standard error
_EXCEPTIONS = 0.1  # share of the intervals that may not fit the groups
_SHORT = 0.25  # interval between two rows of one instant, over the mean interval
_BUNCHED_SHIFT = 1.2  # smallest difference of the means over the scatter, if stamps come in groups of the period
_EVEN_SHIFT = 2.0  # the same for even stamps, or none: twice the largest step of converters with two phases
_UNEQUAL = (
    1.15  # smallest ratio of the differences on two axes of one sensor: a simulated line has one size on all axes
)
_PAIR = 2  # sensors of different rates that are told apart
_SAME_SENSOR = (
    0.3  # difference of the means of two turns of one sensor, over the scatter: 4 standard errors of a median
)
_UNEVEN_INTERVALS = (
    0.2  # smallest difference of the intervals by turn, over their mean, of two sensors of different rates
)
_EVEN_AXES = 2  # axes of either sensor, or one more of a single sensor
_NEIGHBOURS = 6.0  # correlation of neighbouring rows beyond that of rows of one turn, over its standard error


@dataclass(frozen=True, slots=True, kw_only=True)
class Interleaving:
    """Sensors whose rows take turns."""

    sensors: int
    period: int  # rows after which the sensors repeat; more than sensors if they have different rates
    channel: str  # with the largest difference
    means: tuple[float, ...]  # of this channel, by turn; in the unit of the log
    bunched: bool  # whether the stamps come in groups

    def error(self, label: str) -> DataError:
        """The error of a log with such rows; `label`: the column of the channel."""
        turn = {2: "second", 3: "third", 4: "fourth"}[self.period]
        size = max(self.means) - min(self.means)
        return DataError(
            f"has rows of {self.sensors} interleaved sensors: the means of every {turn} row of {self.channel} (column"
            f" {label}) differ by {size:.3g}. Save each sensor to its own file, or log the number of the sensor in a column"
        )


def find_interleaving(channels: Mapping[str, NDArray[Any]], stamps: NDArray[Any] | None) -> Interleaving | None:
    """The sensors whose rows take turns, by the first rows of a log; None if all rows are of one sensor.

    `channels`: columns of gyro and accelerometer, each of shape (n,), in the order of the file; `stamps`: shape (n,).

    If stamps come in groups (``0, 0.06, 10, 10.06 ms``), two axes must have means that depend on the turn. A first-in
    first-out memory makes such stamps too, but not the means. Two sensors of which one has two or three rows for each
    row of the other have means in one proportion, as a line at a third of the rate has, but also uneven stamps. If
    stamps are even, or absent, the means must differ by twice the scatter on two axes of both sensors, or on three axes
    of one by different amounts, and neighbouring rows must not be more alike than rows of one turn. All parts of the log
    must show the same means.
    """
    names = list(channels)
    if not names or len(channels[names[0]]) < _MIN_PARTS * _ROWS:
        return None
    for period in _PERIODS:
        starts = _starts(len(channels[names[0]]), period)
        parts = np.stack([_turns(channels[name], starts, period) for name in names], axis=-1)
        turns = _means_of_turns(parts)
        if turns is None:
            continue
        means, scatter = turns
        shift = np.divide(np.ptp(means, axis=1), scatter, out=np.zeros(len(names)), where=scatter > 0)
        sensors = period
        bunched = stamps is not None and _is_bunched(np.asarray(stamps[: _MIN_PARTS * _ROWS]), period)
        if bunched:
            is_interleaved = bool(np.count_nonzero(shift >= _BUNCHED_SHIFT) >= _EVEN_AXES)
        else:
            relative = means / np.where(scatter > 0, scatter, 1.0)[:, None]
            apart = period > _PAIR and _has_single_turn_apart(relative) and not _is_even(stamps, period)
            is_interleaved = _is_large(names, shift, relative, in_proportion=apart) and not _are_neighbours_alike(parts)
            sensors = _PAIR if apart else period
        if is_interleaved:
            largest = int(np.argmax(shift))
            return Interleaving(
                sensors=sensors,
                period=period,
                channel=names[largest],
                means=tuple(means[largest].tolist()),
                bunched=bunched,
            )
    return None


def _starts(rows: int, period: int) -> list[int]:
    """First rows of the parts, all of the same turn if no row is lost."""
    size = _ROWS // period * period
    count = min(rows // size, _PARTS)
    spread = np.arange(count) * _UNEVEN % 1  # even distances would hide a line of that period
    return [int(start) // period * period for start in (np.arange(count) + spread) / count * (rows - size)]


def _turns(column: NDArray[Any], starts: Sequence[int], period: int) -> NDArray[np.float64]:
    """The rows of a channel in all parts: shape (parts, rows / period, period)."""
    size = _ROWS // period * period
    with np.errstate(invalid="ignore"):  # a damaged number may be a signalling NaN
        parts = [np.asarray(column[start : start + size], dtype=np.float64) for start in starts]
    return np.stack(parts).reshape(len(starts), size // period, period)


def _means_of_turns(parts: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Means of each channel by turn, shape (channels, period), without the common mean, and the scatter within a turn, shape
    (channels,). Channels whose means are not significant, or not the same in most parts of the log, are 0; None if all are.
    `parts`: shape (parts, rows, period, channels).
    """
    period, channels = parts.shape[2:]
    with np.errstate(invalid="ignore"):
        centred = parts - parts.mean(axis=2, keepdims=True)  # without motion and drift
        means = centred.mean(axis=1)  # (part, turn, channel)
        scatter = (centred.std(axis=1) * (period / (period - 1)) ** 0.5).mean(axis=1)
    finite = np.isfinite(means).all(axis=(1, 2))
    means, scatter = means[finite], scatter[finite]
    if len(means) < _MIN_PARTS:
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
    for turn in range(period):  # after a lost row the turns are shifted
        moved = np.roll(means, turn, axis=1)
        apart = np.abs(moved - means[0]).max(axis=1)
        closer = apart[:, lead] < distance[:, lead]
        aligned[closer], distance[closer] = moved[closer], apart[closer]
    allowed = _TOLERANCE * np.abs(means[0]).max(axis=0) + _TOLERANCE_ERRORS * np.median(error, axis=0)
    same = significant & ((distance <= allowed).mean(axis=0) >= _SAME)
    return (np.median(aligned, axis=0).T * same[:, None], typical_scatter) if same.any() else None


def _is_bunched(stamps: NDArray[Any], period: int) -> bool:
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


def _has_single_turn_apart(means: NDArray[np.float64]) -> bool:
    """Whether all turns but one have the same means, as two or three rows of a sensor have for each of a slower one.
    `means`: over the scatter, shape (channels, turns).
    """
    spreads = [np.ptp(np.delete(means, turn, axis=1), axis=1).max() for turn in range(means.shape[1])]
    return bool(min(spreads) <= _SAME_SENSOR)


def _is_even(stamps: NDArray[Any] | None, period: int) -> bool:
    """Whether the intervals between rows do not depend on the turn, as far as is known."""
    if stamps is None:
        return True
    with np.errstate(invalid="ignore"):
        intervals = np.diff(np.asarray(stamps[: _ROWS * period + 1]).astype(np.float64))
    by_turn = np.median(intervals[: len(intervals) // period * period].reshape(-1, period), axis=0)
    return not float(np.ptp(by_turn)) > _UNEVEN_INTERVALS * float(np.mean(by_turn))


def _is_large(
    names: Sequence[str], shift: NDArray[np.float64], means: NDArray[np.float64], *, in_proportion: bool
) -> bool:
    """Whether the means differ by much on enough axes, and not as a line would make them. `means`: over the scatter;
    `in_proportion`: whether the means of all axes may have the same proportions.
    """
    large = shift >= _EVEN_SHIFT
    axes = [np.array([name.startswith(sensor) for name in names]) & large for sensor in ("gyro", "accel")]
    counts = [int(np.count_nonzero(of_sensor)) for of_sensor in axes]
    both = min(counts) >= _EVEN_AXES
    unequal = any(
        count > _EVEN_AXES and np.max(shift[of_sensor]) > _UNEQUAL * np.min(shift[of_sensor])
        for count, of_sensor in zip(counts, axes, strict=True)
    )
    if not both and not unequal:
        return False
    if in_proportion:
        return True
    # A line has one phase on all axes of a rigid body, and three turns or more then have means in one proportion.
    sizes = np.linalg.svd(means[large], compute_uv=False)
    return bool(np.count_nonzero(sizes >= _EVEN_SHIFT / 2) >= means.shape[1] - 1)


def _are_neighbours_alike(parts: NDArray[np.float64]) -> bool:
    """Whether neighbouring rows are more alike than rows of one turn, as those of one filtered sensor are."""
    count, rows, period, channels = parts.shape
    x = (parts - parts.mean(axis=1, keepdims=True)).reshape(count, rows * period, channels)
    x = x[np.isfinite(x).all(axis=(1, 2))]
    power = np.maximum((x * x).mean(axis=(0, 1)), np.finfo(np.float64).tiny)
    next_row, same_turn = ((x[:, lag:] * x[:, :-lag]).mean(axis=(0, 1)) / power for lag in (1, period))
    return bool(np.max(next_row - same_turn) > _NEIGHBOURS * (2 / (len(x) * rows * period)) ** 0.5)
