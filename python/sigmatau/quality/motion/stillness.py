"""Detection of motion from the means of samples over 1/16 s to 4 s.

The noise of a sensor at rest is white at these averaging times, or falls faster: √τ times the deviation of the means has
the same value N at all of them. Second differences remove drifts. Motion has its power between 0.1 Hz and 10 Hz: √τ times
the deviation then rises with the averaging time, beyond the random walk of any sensor. Faster vibration does not raise
this product, so that a sensor on an engine may count as at rest.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

from sigmatau.arrays import Bools, Floats, column_counts, median
from sigmatau.findings.finding import Span
from sigmatau.findings.rest import Motion
from sigmatau.frozen import frozen
from sigmatau.quality.facts import in_threads
from sigmatau.quality.motion.gravity_direction import gravity_tilts, measures_gravity
from sigmatau.quality.motion.octave_means import (
    FLOOR,
    MIN_DIFFERENCES,
    NORMAL_MEDIAN,
    OCTAVES,
    SECOND,
    STEPS,
    OctaveMeans,
)
from sigmatau.quality.motion.tremor import shaken
from sigmatau.quality.samples.common import present, united
from sigmatau.quality.samples.units import has_plausible_values
from sigmatau.quality.sensor_class import SENSOR_CLASSES
from sigmatau.record.streams import Stream

# Shortest averaging time. [s] Derived: motion of people and vehicles has its power between 0.1 Hz and 10 Hz.
_SHORTEST = 1 / 16
# Smallest length of the blocks that are judged as a whole; a shorter record is judged by single seconds too. [s]
# Judgement: ten means of 4 s.
_BLOCK = 40.0
# Largest number of blocks. [1] Judgement: limits the time of a long record.
_MAX_BLOCKS = 128
# √τ times the deviation of means above which a sensor moves if this level also rises by `_RISE`. [rad/s/√Hz, m/s^2/√Hz]
# Study: docs/study/rest.md; existing gyros have up to 0.05 (deg/s)/√Hz, and accelerometers up to 1 mg/√Hz.
_LEVEL = {"angular_rate": math.radians(0.05), "acceleration": 0.015}
# Limit of that level if it rises by `_RISE_OF_HIGH`: beyond the noise of all sensors. [rad/s/√Hz, m/s^2/√Hz] Study:
# docs/study/rest.md.
_HIGH_LEVEL = {"angular_rate": math.radians(0.175), "acceleration": 0.03}
# Ratio of that level to the noise at shorter times, beyond the noise of most sensors. [1] Study: docs/study/rest.md,
# clean records with Gauss-Markov processes up to 8 times the white noise.
_RISE = 8.0
# Such a ratio for a level beyond `_HIGH_LEVEL`. [1] Study: docs/study/rest.md.
_RISE_OF_HIGH = 1.6
# Change of the mean from one interval of 4 s to the next, over that of the steepest warm-up of a sensor. [1] Judgement:
# a sensor that warms up has rate random walk too.
_DRIFT = 2.0
# Ratio of that change to the noise of the means. [1] Judgement: the median of at least five changes does not reach it
# by chance.
_DRIFT_OVER_NOISE = 5.0
# Largest relative error of a level from the median of n differences, times √n. [1] Derived: the median of absolute
# normal deviates has a relative error of 1.17/√n; 2.6 standard errors.
_ERRORS = 3.0
# Largest mean rate of a gyro at rest. [rad/s] Datasheets: twice the largest zero-rate offset of usual consumer sensors,
# see `sigmatau.quality.samples.units`.
_LARGEST_BIAS = math.radians(20)
# Change of the mean from second to second, as the deviation of a mean, of a hand-held sensor. [rad/s, m/s^2] Judgement:
# footsteps and knocks on a table are smaller; docs/study/rest.md lists the windows.
_HAND_CHANGE = {"angular_rate": math.radians(1.0), "acceleration": 0.2}
# Ratio of that change to the noise of the sensor. [1] Judgement: noise does not reach it by chance.
_HAND_RISE = 10.0
# Shortest motion that is longer than a knock; in a record shorter than a block, a knock counts as motion. [s]
# Judgement: a knock rings for less.
_MIN_HAND_TIME = 4
# Departure of a mean from the median of a short record, over `_HAND_CHANGE`; also tested at the ends of the record,
# where there are no second differences. [1] Judgement: no drift is twice the change of a hand-held sensor.
_DEPARTURE = 2.0
# Octave from which departures of means are tested, 1/8 s. [octaves] Judgement: shorter means have the noise of vibration.
_DEPARTS_FROM = 1
# Shortest stream that is judged; below 1 Hz four samples replace a second. [s] Derived: two seconds and a second
# difference of half seconds.
_MIN_SECONDS = 2
# Longest rest between two motions that count as one. [s] Judgement: too short a stretch for an analysis.
_GAP = 4
# Smallest change of position of a motion that is more than a knock. [rad, m/s^2] Derived: the 5° of `gravity_tilts`.
_MIN_TURN = {"angular_rate": math.radians(5), "acceleration": 9.8 * math.radians(5)}
# Length of the stretches before and after a motion that show the position. [s] Judgement: a median of five seconds
# tolerates two disturbed seconds.
_POSITION_LENGTH = 5
# Largest share of missing samples in a channel that is judged. [1] Judgement: half of the record shows lasting motion.
_MAX_MISSING = 0.5


@frozen(kw_only=False)
class Movement:
    """Stretches in which a sensor moves, and the strongest motion; None at rest."""

    spans: tuple[Span, ...]  # from the beginning of the log, in order of time [s]
    motion: Motion | None


def find_movement(streams: Iterable[Stream], *, threads: int | None = None) -> Movement:
    """Find the stretches in which the sensors of a record move, by angular rates and accelerations.

    A second is in motion if its means, or the means of its quarters, differ from the neighbouring ones as in a hand-held
    sensor, for longer than a knock or with a change of position. Outside such seconds, a block of 40 s or more, or the
    whole record, is in motion if the median of its second differences exceeds the noise at some averaging time.
    """
    by_stream = [_octave_means(stream, threads) for stream in streams]
    means = [axis for axes in by_stream for axis in axes]
    moving = [stretch for axis in means for stretch in _seconds(axis)]
    handled = united((span for span, _ in moving), gap=_GAP)
    for axis in means:
        axis.leave_out(handled)
    for axes in by_stream:
        tilts = gravity_tilts(axes)
        for axis in axes:
            axis.leave_out([span for span, _ in tilts])
        moving += tilts
    moving += [stretch for axis in means for stretch in _blocks(axis)]
    if not moving and (motion := shaken(means)) is not None:
        moving.append((means[0].span(0.0, math.inf), motion))
    strongest = max((motion for _, motion in moving), key=lambda motion: motion.times, default=None)
    return Movement(united((span for span, _ in moving), gap=_GAP), strongest)


def _octave_means(stream: Stream, threads: int | None) -> Sequence[OctaveMeans]:
    """Compute the means of those channels of a sensor that can be judged."""
    if stream.quantity not in SENSOR_CLASSES:
        return ()
    if not has_plausible_values(stream):
        return ()
    base = max(round(_SHORTEST / stream.grid.tau0), 1)
    first = max(round(math.log2(base * stream.grid.tau0 / _SHORTEST)), 0)  # octave of the means of `base` samples
    if stream.grid.n < _MIN_SECONDS * base << max(SECOND - first, 2):
        return ()
    missing = np.zeros(len(stream.channels)) if stream.mask is None else column_counts(stream.mask) / stream.grid.n
    channels = [channel for channel, share in zip(stream.channels, missing, strict=True) if share <= _MAX_MISSING]
    by_channel = in_threads(lambda channel: OctaveMeans(stream, channel, base, first), channels, threads)
    means = [axis for axis in by_channel.values() if axis.floor > 0]  # a constant channel is not a measurement
    sure = measures_gravity(means, in_si=True)
    for axis in means:
        axis.unit_is_sure = sure
        axis.limit_floor()
    return means


def _blocks(axis: OctaveMeans) -> list[tuple[Span, Motion]]:
    """Find blocks in motion, or drifting; the whole record too, if the other blocks together are in motion."""
    if axis.slow:
        return []
    whole = axis.stream.grid.duration
    length = min(max(round(whole / _BLOCK), 1), _MAX_BLOCKS)
    block = whole / length
    edges = np.arange(length + 1, dtype=np.float64) * block
    may_move, may_drift = _may_move(axis, edges), _may_drift(axis, edges)
    moving: list[tuple[Span, Motion]] = []
    for k in range(length):
        start, stop = k * block, (k + 1) * block
        motion = _judged(axis, start, stop) if may_move[k] else None
        if motion is None and may_drift[k]:
            motion = _drift(axis, start, stop)
        if motion is not None:
            moving.append((axis.span(start, stop), motion))
    axis.leave_out([span for span, _ in moving])
    whole_may_move = length > len(moving) and _may_move(axis, np.array([0.0, whole])).any()
    if whole_may_move and (motion := _judged(axis, 0.0, whole)) is not None:
        moving.append((axis.span(0.0, whole), motion))
    return moving


def _may_move(axis: OctaveMeans, edges: Floats) -> Bools:
    """Whether stretches between edges reach the level that both conditions of `_judged` require."""
    limit, high_limit = _LEVEL[axis.quantity], _HIGH_LEVEL[axis.quantity]
    return axis.reach(min(high_limit, max(limit, _RISE * axis.floor)), edges)


def _judged(axis: OctaveMeans, start: float, stop: float) -> Motion | None:
    """Strongest motion by the median of second differences; None at rest."""
    limit, high_limit = _LEVEL[axis.quantity], _HIGH_LEVEL[axis.quantity]
    lowest = math.inf
    motions: list[Motion] = []
    for octave in range(axis.first, OCTAVES):
        tau = axis.tau(octave)
        inside = present(axis.differences(octave, start, stop))
        if len(inside) < MIN_DIFFERENCES:
            break
        usual = median(inside)
        level = usual / NORMAL_MEDIAN * math.sqrt(tau)
        times = level / axis.floor if axis.floor > 0 else math.inf
        sure = level * (1 - _ERRORS / math.sqrt(len(inside)))
        high = level > high_limit and sure > _RISE_OF_HIGH * lowest
        risen = octave > FLOOR and level > limit and times > _RISE
        if usual > STEPS * axis.step and (high or risen):
            motions.append(axis.motion("varies", usual / NORMAL_MEDIAN, max(times, level / limit), tau))
        lowest = min(lowest, max(level, axis.rounding_level(octave)))
    return max(motions, key=lambda motion: motion.times, default=None)


def _steepest(axis: OctaveMeans, tau: float) -> tuple[float, float]:
    """Steepest drift of the mean of a sensor over an averaging time, and the change above which it is a motion."""
    steepest = SENSOR_CLASSES[axis.quantity].noisiest["rate_ramp"] * tau
    noise = max(axis.floor / math.sqrt(tau), axis.step)
    return steepest, max(_DRIFT * steepest, _DRIFT_OVER_NOISE * noise)


def _may_drift(axis: OctaveMeans, edges: Floats) -> list[bool]:
    """Whether half of the changes between edges exceed the limit of a motion, as `_drift` requires."""
    octave = _octave_of_drift(axis)
    tau = axis.tau(octave)
    _, limit = _steepest(axis, tau)
    changes = np.abs(np.diff(axis.by_octave[octave]))
    present_to = np.concatenate(([0], np.cumsum(np.isfinite(changes))))
    beyond_to = np.concatenate(([0], np.cumsum(changes > limit)))
    places = [min(round(edge / tau), len(changes) + 1) for edge in edges.tolist()]
    spans = [(a, max(b - 1, a)) for a, b in pairwise(places)]
    return [2 * int(beyond_to[b] - beyond_to[a]) >= int(present_to[b] - present_to[a]) for a, b in spans]


def _octave_of_drift(axis: OctaveMeans) -> int:
    """Octave of means over 4 s, or a shorter one in a record that has too few such means."""
    octave = OCTAVES - 1
    while octave > SECOND and len(axis.by_octave[octave]) <= MIN_DIFFERENCES:
        octave -= 1
    return octave


def _drift(axis: OctaveMeans, start: float, stop: float) -> Motion | None:
    """Detect a steady change of the mean that no sensor has, from the median of first differences of means of 4 s."""
    octave = _octave_of_drift(axis)
    tau = axis.tau(octave)
    x = axis.by_octave[octave][round(start / tau) : round(stop / tau)]
    changes = present(np.diff(x))
    if len(changes) < MIN_DIFFERENCES:
        return None
    usual, (steepest, limit) = abs(median(changes)), _steepest(axis, tau)
    if usual <= limit:
        return None
    return axis.motion("varies", usual, usual / steepest, tau)


def _seconds(axis: OctaveMeans) -> list[tuple[Span, Motion]]:
    """Find stretches of seconds in which the sensor is hand-held."""
    limit = _HAND_CHANGE[axis.quantity]
    second = axis.by_octave[axis.second_octave]
    size, n = axis.tau(axis.second_octave), len(second)
    largest = np.zeros(n)
    for octave in range(max(FLOOR, axis.first), axis.second_octave + 1):
        d, tau = np.nan_to_num(axis.differences(octave)), axis.tau(octave)
        over_noise = d * math.sqrt(tau) > _HAND_RISE * axis.floor
        is_large = (d > limit) & over_noise & (d > STEPS * axis.step)
        _raise_seconds(largest, np.where(is_large, d, 0.0), tau, size, first=1)
    is_short = axis.stream.grid.duration < _BLOCK and not axis.slow
    if is_short:
        _raise_by_departures(axis, largest)
    turning = np.abs(np.nan_to_num(second)) if axis.quantity == "angular_rate" else np.zeros(n)
    turning[turning < max(_LARGEST_BIAS, _HAND_RISE * axis.floor / math.sqrt(size))] = 0.0
    flagged = (largest > 0) | (turning > 0)
    least_seconds = 1 if is_short else _MIN_HAND_TIME
    moving: list[tuple[Span, Motion]] = []
    for a, b in _groups(flagged):
        if np.count_nonzero(flagged[a:b]) < least_seconds and not _turned(axis, second, a, b):
            continue
        amount, rate = float(largest[a:b].max()), float(turning[a:b].max())
        if amount > 0:
            times = amount * math.sqrt(size) / axis.floor if axis.floor > 0 else math.inf
            motion = axis.motion("varies", amount, times, size)
        else:
            motion = axis.motion("turns", rate, rate / _LARGEST_BIAS, (b - a) * size)
        moving.append((axis.span((a - 1) * size, (b + 1) * size), motion))
    return moving


def _raise_seconds(largest: Floats, sizes: Floats, tau: float, second: float, *, first: int) -> None:
    """Raise the largest change of each second to the sizes of means over `tau`; sizes[0] belongs to mean `first`."""
    second_of_mean = np.minimum(((np.arange(len(sizes)) + first) * tau / second).astype(int), len(largest) - 1)
    np.maximum.at(largest, second_of_mean, sizes)


def _raise_by_departures(axis: OctaveMeans, largest: Floats) -> None:
    """Raise the largest change of each second of a short record to the departure of its means from their median."""
    for octave in range(max(_DEPARTS_FROM, axis.first), axis.second_octave + 1):
        x, tau = axis.by_octave[octave], axis.tau(octave)
        away = np.nan_to_num(np.abs(x - median(present(x))))
        limit = max(
            _DEPARTURE * _HAND_CHANGE[axis.quantity],
            _HAND_RISE * axis.floor / math.sqrt(tau),
            STEPS * axis.step,
        )
        _raise_seconds(largest, np.where(away > limit, away, 0.0), tau, axis.tau(axis.second_octave), first=0)


def _groups(flagged: Bools) -> Sequence[tuple[int, int]]:
    places = np.flatnonzero(flagged)
    if not len(places):
        return ()
    parts = np.split(places, np.flatnonzero(np.diff(places) > _GAP) + 1)
    return [(int(part[0]), int(part[-1]) + 1) for part in parts]


def _turned(axis: OctaveMeans, second: Floats, a: int, b: int) -> bool:
    """Whether the position of the sensor changes from second a to second b, by gravity or by the angle turned."""
    before, after = (
        present(part)
        for part in (
            second[max(a - 1 - _POSITION_LENGTH, 0) : max(a - 1, 0)],
            second[b + 1 : b + 1 + _POSITION_LENGTH],
        )
    )
    if not (len(before) and len(after)):
        return False
    levels = median(before), median(after)
    if axis.quantity == "acceleration":
        return abs(levels[1] - levels[0]) > _MIN_TURN["acceleration"]
    inside = present(second[max(a - 1, 0) : b + 1]) - sum(levels) / 2
    return abs(float(inside.sum())) * axis.tau(axis.second_octave) > _MIN_TURN["angular_rate"]
