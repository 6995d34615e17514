"""Detection of rows of several sensors that take turns without a column that shows them, from means, scatter and stamps by
turn.

Each sensor has a bias, so the means of the rows differ from turn to turn throughout. A line at half, a third or a quarter of
the sampling rate makes such means too, and a converter with two phases makes small ones. Sensors with equal biases are
detected by their scatter or their stamps. Then the slow noise decides (`sigmatau.io.read.turns`): rows of one sensor
share it. In doubt, the user is asked.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.hints import Hint, command
from sigmatau.io.read import turns
from sigmatau.io.read.turns import MIN_PARTS, ROWS, SlowNoise, compare_slow_noise, find_groups

# number of parts of the log that are tested, over its whole length: a line that is not locked to the samples drifts
_PARTS = 16
_ALL_PARTS = 256  # the same if the first parts show several sensors
_PERIODS = (4, 3, 2)  # numbers of sensors in turn that are tested
_BUNCHED_SHIFT = 1.2  # smallest difference of the means over the scatter, if stamps come in groups of the period
_EVEN_SHIFT = 2.0  # the same for even or absent stamps: twice the largest step of converters with two phases
_UNEQUAL = 0.15  # smallest relative difference of two axes of one sensor: a simulated line has one size on all axes
_PAIR = 2  # number of sensors of different rates that can be distinguished
_EVEN_AXES = 2  # smallest number of axes that must differ
_NEIGHBOURS = 6.0  # correlation of neighbouring rows minus that of rows of one turn, over its standard error
_SCATTERS = 1.3  # smallest ratio of the scatters of two sensors: 6 standard errors for 16 parts
_TURN_NAMES = {2: "second", 3: "third", 4: "fourth"}
_FRACTIONS = {2: "half", 3: "a third of", 4: "a quarter of"}

Sign = Literal["means", "scatter", "stamps", "groups"]


@frozen
class Interleaving:
    """Detected sensors whose rows take turns."""

    sensors: int
    period: int  # rows after which the sensors repeat; more than sensors if they have different rates, 0 if they do not
    sign: Sign  # property that depends on the turn
    channel: str  # channel with the largest difference
    # difference of the means of this channel [unit of the log], or ratio of its scatters; 0 for stamps
    size: float = 0.0
    means: tuple[float, ...] = ()  # means of this channel by turn [unit of the log]
    certain: bool = False  # False if a single sensor may produce such rows too

    def error(self, label: str, topic: str) -> OptionError:
        """The question for a log with such rows. `label`: column of the channel; `topic`: that of the table, or empty."""
        single = Hint("interleaved", value=1)
        if self.sensors != self.period:
            advice = f"Save each to its own file, or state {single} if it is a single one"
        else:
            first = Hint("topic", value=f"{topic}/imu0".removeprefix("/"))
            advice = f"State {Hint('interleaved', value=self.sensors)} {first}"
            advice += f", or {single}" + (" if it is a single one" if self.certain else "")
        return OptionError(f"{self._reading()}: {self._sign(label)}. {advice}", option="interleaved")

    def error_of_live(self, label: str) -> OptionError:
        """The question for samples of a live log."""
        advice = f"Save the log and run {command('analyze', 'FILE')}, or state {Hint('interleaved', value=1)}"
        return OptionError(f"{self._reading()}: {self._sign(label)}. {advice}", option="interleaved")

    def error_of_count(self, label: str, topic: str, count: int) -> OptionError:
        """The error for a stated number of sensors if a topic still has rows of several sensors."""
        advice = "State another number" if self.period else "Save each to its own file"
        return OptionError(
            f"{{option}} {count} leaves rows of several sensors in {topic}: {self._sign(label)}. {advice}",
            option="interleaved",
        )

    def _reading(self) -> str:
        """Words for the detected meaning of the rows, and for the alternative if it is possible."""
        if self.sign == "groups":
            return "has rows of several sensors in no fixed order, or of one that switches between two states"
        other_reading = {
            "means": f"one with a line at {_FRACTIONS[self.period]} the rate",
            "scatter": "one whose noise changes from row to row",
            "stamps": "one whose samples were sent together",
        }[self.sign]
        several = f"has rows of {self.sensors} interleaved sensors"
        return several if self.certain else f"{several}, or of {other_reading}"

    def _sign(self, label: str) -> str:
        """Words for the observed difference between rows of different turns."""
        if self.sign == "groups":
            return f"the rows are in groups, {self.size:.3g} apart in {self.channel} (column {label})"
        rows = f"of every {_TURN_NAMES[self.period]} row of {self.channel} (column {label})"
        return {
            "means": f"the means {rows} differ by {self.size:.3g}",
            "scatter": f"the scatter {rows} differs by a factor of {self.size:.3g}",
            "stamps": f"its time stamps come in groups of {self.period}",
        }[self.sign]


def find_interleaving(channels: Mapping[str, NDArray[Any]], stamps: NDArray[Any] | None) -> Interleaving | None:
    """Find the sensors whose rows take turns; None if all rows are of one sensor, or if nothing shows several.

    `channels`: columns of gyro and accelerometer, each of shape (n,), in the order of the file; `stamps`: shape (n,).

    If stamps come in groups (``0, 0.06, 10, 10.06 ms``), the means of two axes must depend on the turn; the groups alone
    raise a question. If stamps are even or absent, one of three conditions must hold. The means differ by twice the scatter
    on two axes, not by the same amount on both axes of a sensor, and neighbouring rows are not more alike than rows of one
    turn; or the rows form groups in no fixed order; or the scatter depends on the turn. All parts of the log must show the
    same means. Rows of several turns that share their slow noise are of one sensor.
    """
    names = list(channels)
    if not names or len(channels[names[0]]) < MIN_PARTS * ROWS:
        return None
    for find in (_find_by_means, _find_by_groups):
        for period in _PERIODS:
            if (interleaving := find(channels, stamps, period)) is not None:
                return interleaving
    return _find_by_order(channels) or _find_by_scatter(channels)


@frozen
class Turns:
    """Turns of a stated number of sensors."""

    slow_turn: int | None  # the only turn whose sensor differs from that of the others
    period: int  # turns after which the means repeat
    lost: tuple[int, int] | None  # row numbers between which a row was lost, so that the turns shift


def find_turns(channels: Mapping[str, NDArray[Any]], count: int) -> Turns | None:
    """Find the turns of a stated number of sensors; None if the means do not show them. `channels`: as in
    `find_interleaving`.
    """
    rows = min(map(len, channels.values()))
    if rows < MIN_PARTS * ROWS:
        return None
    by_turn = turns.means_by_turn(_parts(channels, count, _ALL_PARTS))
    if by_turn is None:
        return None
    starts = turns.starts_of_parts(rows, count, _ALL_PARTS)
    steady = [(start, turn) for start, turn in zip(starts, by_turn.first_turns, strict=True) if turn >= 0]
    lost = next(((a, b + ROWS - 1) for (a, before), (b, after) in pairwise(steady) if before != after), None)
    relative = _over_scatter(by_turn)[1]
    return Turns(slow_turn=turns.single_turn(relative), period=turns.shortest_period(relative), lost=lost)


def _find_by_means(
    channels: Mapping[str, NDArray[Any]], stamps: NDArray[Any] | None, period: int
) -> Interleaving | None:
    names = list(channels)
    parts = _parts(channels, period, _PARTS)
    by_turn = turns.means_by_turn(parts)
    if by_turn is None:
        return None
    bunched = _has_groups(stamps, period)
    shift, relative = _over_scatter(by_turn)
    slow_turn = None if bunched else turns.single_turn(relative)
    if bunched:
        if np.count_nonzero(shift >= _BUNCHED_SHIFT) < _EVEN_AXES:
            return None
    elif not _is_large(names, shift, relative, in_proportion=slow_turn is not None) or _are_neighbours_alike(parts):
        return None
    # the first parts may have the same phase by chance
    by_turn = turns.means_by_turn(_parts(channels, period, _ALL_PARTS))
    if by_turn is None:
        return None
    shift, _ = _over_scatter(by_turn)
    if not np.any(shift >= _BUNCHED_SHIFT):
        return None
    stretch = _longest_stretch(len(channels[names[0]]), period, by_turn.first_turns)
    slow = _slow_noise(channels, period, stretch, pair=(0, 1) if slow_turn is None else (slow_turn, slow_turn - 1))
    if slow == "in common" and not bunched:
        return None
    largest = int(np.argmax(shift))
    return Interleaving(
        sensors=period if slow_turn is None else _PAIR,
        period=period,
        sign="means",
        channel=names[largest],
        size=float(np.ptp(by_turn.means[largest])),
        means=tuple(by_turn.means[largest].tolist()),
        certain=slow == "independent",
    )


def _find_by_groups(
    channels: Mapping[str, NDArray[Any]], stamps: NDArray[Any] | None, period: int
) -> Interleaving | None:
    """Test for sensors with equal biases whose stamps come in groups."""
    if not _has_groups(stamps, period):
        return None
    name, column = next(iter(channels.items()))
    slow = _slow_noise(channels, period, slice(0, len(column)), pair=(0, 1))
    if slow == "in common":
        return None
    return Interleaving(
        sensors=period,
        period=period,
        sign="stamps",
        channel=name,
        certain=slow == "independent",
    )


def _find_by_order(channels: Mapping[str, NDArray[Any]]) -> Interleaving | None:
    """Test for sensors in no fixed order."""
    names = list(channels)
    starts = turns.starts_of_parts(len(channels[names[0]]), 1, _PARTS)
    parts = np.concatenate([turns.rows_by_turn(column, starts, 1) for column in channels.values()], axis=2)
    groups = find_groups(parts, np.array(starts))
    if groups is None:
        return None
    return Interleaving(
        sensors=_PAIR,
        period=0,
        sign="groups",
        channel=names[groups.axis],
        size=groups.size,
    )


def _find_by_scatter(channels: Mapping[str, NDArray[Any]]) -> Interleaving | None:
    """Test for two sensors with equal biases and different noise."""
    ratios = turns.ratio_of_scatters(_parts(channels, _PAIR, _PARTS))
    if np.count_nonzero(ratios >= _SCATTERS) < _EVEN_AXES:
        return None
    names = list(channels)
    slow = _slow_noise(channels, _PAIR, slice(0, len(channels[names[0]])), pair=(0, 1))
    if slow == "in common" or _has_several_means(channels):
        return None
    largest = int(np.argmax(ratios))
    return Interleaving(
        sensors=_PAIR,
        period=_PAIR,
        sign="scatter",
        channel=names[largest],
        size=float(ratios[largest]),
        certain=slow == "independent",
    )


def _has_several_means(channels: Mapping[str, NDArray[Any]]) -> bool:
    """Whether the means of every fourth row differ, as for sensors of different rates."""
    by_turn = turns.means_by_turn(_parts(channels, 2 * _PAIR, _PARTS))
    return by_turn is not None and bool(np.any(_over_scatter(by_turn)[0] >= _BUNCHED_SHIFT))


def _parts(channels: Mapping[str, NDArray[Any]], period: int, limit: int) -> NDArray[np.float64]:
    """Rows by turn: shape (parts, rows, period, channels)."""
    starts = turns.starts_of_parts(len(next(iter(channels.values()))), period, limit)
    return np.stack([turns.rows_by_turn(column, starts, period) for column in channels.values()], axis=-1)


def _has_groups(stamps: NDArray[Any] | None, period: int) -> bool:
    return stamps is not None and turns.is_bunched(np.asarray(stamps[: MIN_PARTS * ROWS]), period)


def _over_scatter(by_turn: turns.TurnMeans) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Largest difference of the means, and the means, both over the scatter."""
    scatter = by_turn.scatter
    shift = np.divide(np.ptp(by_turn.means, axis=1), scatter, out=np.zeros(len(scatter)), where=scatter > 0)
    return shift, by_turn.means / np.where(scatter > 0, scatter, 1.0)[:, None]


def _longest_stretch(rows: int, period: int, first_turns: NDArray[np.intp]) -> slice:
    """The rows of the longest stretch without a lost row, from the first turn of each part."""
    starts = np.array(turns.starts_of_parts(rows, period, len(first_turns)))
    changes = np.flatnonzero(np.diff(first_turns)) + 1
    borders = [0, *changes.tolist(), len(first_turns)]
    stretches = [
        (int(starts[first]) if first else 0, int(starts[end - 1]) + ROWS if end < len(starts) else rows)
        for first, end in pairwise(borders)
    ]
    return slice(*max(stretches, key=lambda stretch: stretch[1] - stretch[0]))


def _slow_noise(
    channels: Mapping[str, NDArray[Any]], period: int, stretch: slice, *, pair: tuple[int, int]
) -> SlowNoise:
    """Compare the slow noise of rows of two turns."""
    series = []
    for turn in pair:
        turn_rows = [
            np.asarray(column[stretch][turn % period :: period], dtype=np.float64) for column in channels.values()
        ]
        series.append(np.stack(turn_rows, axis=1))
    size = min(map(len, series))
    first, second = (_without_missing(x[:size]) for x in series)
    return compare_slow_noise(first, second)


def _without_missing(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Replace missing samples by the median; by 0 in a channel without samples."""
    missing = ~np.isfinite(x)
    if not missing.any():
        return x
    medians = [np.median(column[~gaps]) if not gaps.all() else 0.0 for column, gaps in zip(x.T, missing.T, strict=True)]
    return np.where(missing, medians, x)


def _is_large(
    names: Sequence[str], shift: NDArray[np.float64], means: NDArray[np.float64], *, in_proportion: bool
) -> bool:
    """Whether the means differ enough on enough axes, in a way that a line cannot cause.

    `means`: over the scatter; `in_proportion`: whether the means of all axes may be proportional.
    """
    large = shift >= _EVEN_SHIFT
    axes = [np.array([name.startswith(sensor) for name in names]) & large for sensor in ("gyro", "accel")]
    both = all(chosen.any() for chosen in axes)
    unequal = any(np.ptp(shift[chosen]) > _UNEQUAL * np.min(shift[chosen]) for chosen in axes if chosen.any())
    if np.count_nonzero(large) < _EVEN_AXES or not (both or unequal):
        return False
    if in_proportion:
        return True
    # On a rigid body a line has one phase on all axes, so the means of three or more turns are proportional between
    # axes.
    sizes = np.linalg.svd(means[large], compute_uv=False)
    return bool(np.count_nonzero(sizes >= _EVEN_SHIFT / 2) >= means.shape[1] - 1)


def _are_neighbours_alike(parts: NDArray[np.float64]) -> bool:
    """Whether neighbouring rows are more alike than rows of one turn, as for one filtered sensor."""
    count, rows, period, channels = parts.shape
    x = (parts - parts.mean(axis=1, keepdims=True)).reshape(count, rows * period, channels)
    x = x[np.isfinite(x).all(axis=(1, 2))]
    power = np.maximum((x * x).mean(axis=(0, 1)), np.finfo(np.float64).tiny)
    next_row, same_turn = ((x[:, lag:] * x[:, :-lag]).mean(axis=(0, 1)) / power for lag in (1, period))
    return bool(np.max(next_row - same_turn) > _NEIGHBOURS * (2 / (len(x) * rows * period)) ** 0.5)
