"""Whether a sensor rests, and when it moves, by the means of its samples over 1/16 s to 4 s.

The noise of a sensor at rest is white at these averaging times, or falls with them: √τ times the deviation of the means is
the same at all of them, N, beside drifts that take second differences out. Motion has its power between 0.1 Hz and 10 Hz:
the same measure then rises with the averaging time, beyond the random walk of any sensor. Vibration that is faster does not
raise it, so that a sensor on an engine may rest.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from sigmatau.arrays import Bools, Floats, median
from sigmatau.findings.finding import Span
from sigmatau.findings.rest import Motion
from sigmatau.quality.facts import in_threads
from sigmatau.quality.samples.common import present
from sigmatau.quality.samples.gravity_direction import gravity_tilts, measures_gravity
from sigmatau.quality.samples.octave_means import (
    FLOOR,
    LEAST_DIFFERENCES,
    NORMAL_MEDIAN,
    OCTAVES,
    SECOND,
    SHORTEST,
    STEPS,
    OctaveMeans,
)
from sigmatau.quality.samples.tremor import shaken
from sigmatau.quality.sensor_class import SENSOR_CLASSES
from sigmatau.record.streams import PLAUSIBLE_RATES, Stream

_BLOCK, _MOST_BLOCKS = 40.0, 128  # least length of the blocks that are judged as a whole [s], and their number

# √τ times the deviation of means beyond which a sensor moves, and the rise over the noise at shorter times that goes with
# it: beyond the noise of all sensors a small rise, beyond that of most a large one. Studied in studies/rest.py. The noise of
# gyros for sale is up to 0.05 (deg/s)/√Hz, that of accelerometers up to 1 mg/√Hz, see `units`. [SI unit/√Hz]
_LEVELS = {"angular_rate": (math.radians(0.05), math.radians(0.175)), "acceleration": (0.015, 0.03)}
_RISE, _RISE_OF_HIGH = 8.0, 1.6
# Change of the mean from one 4 s to the next over the steepest warm-up of a sensor, so that it is not one with rate random
# walk; and over the noise of the means.
_DRIFT, _DRIFT_OVER_NOISE = 2.0, 5.0
_ERRORS = 3.0  # a level by the median of n differences is wrong by no more than so many times 1/√n

# Largest mean rate of a gyro at rest: twice the largest zero-rate offset of consumer sensors' datasheets. [rad/s]
_LARGEST_BIAS = math.radians(20)

# Change of the mean from second to second, in standard deviations of one mean, of a sensor in someone's hands, and how much
# more than its noise that is. Steps and knocks of a table are less. [SI unit]
_HANDLED = {"angular_rate": math.radians(1.0), "acceleration": 0.2}
_HANDLED_RISE = 10.0
_LEAST_HANDLED = 4  # seconds of motion that are more than a knock; in a record shorter than a block, a knock is motion
# Departure of the means of 1/8 s to 1 s from their median that no drift makes in a record shorter than a block: also at its
# ends, where there are no second differences. Twice the change of the mean of a sensor that is handled. [SI unit]
_DEPARTS = {quantity: 2 * limit for quantity, limit in _HANDLED.items()}
_DEPARTS_FROM = 1  # octave of 1/8 s
_LEAST_SECONDS = 2  # of a stream that is judged; one below 1 Hz has four samples in place of a second
_GAP = 4  # seconds of rest between two motions that are not a stretch
_TURNED = {"angular_rate": math.radians(5), "acceleration": 9.8 * math.radians(5)}  # another position, after any motion
_BESIDE = 5  # seconds before and after a motion that show the position
_MOST_MISSING = 0.5  # share of the samples of a channel that is judged


@dataclass(frozen=True, slots=True)
class Moved:
    """Stretches in which a sensor moves, and the strongest motion that shows it; None if there are none."""

    spans: tuple[Span, ...]  # from the beginning of the log, in order of time [s]
    motion: Motion | None


def moved(streams: Iterable[Stream], *, threads: int | None = None) -> Moved:
    """When the sensors of a record move, by their angular rates and accelerations.

    Seconds move if their means, or those of quarters of them, depart from those beside them as in someone's hands, for more
    than a moment or to another position. Of the rest, a block of 40 s or more moves, or the whole, if the median of its
    second differences is beyond noise at some averaging time.
    """
    by_stream = [_of_stream(stream, threads) for stream in streams]
    means = [one for alike in by_stream for one in alike]
    handled = [_seconds(one) for one in means]
    gone = joined(span for one in handled for span in one.spans)
    for one in means:
        one.leave_out(gone)
    tilted = [Moved((span,), motion) for alike in by_stream for span, motion in _tilts(alike)]
    found = [*handled, *tilted, *map(_blocks, means)]
    if not any(one.spans for one in found) and (motion := shaken(means)) is not None:
        whole = means[0].span(0.0, math.inf)
        found.append(Moved((whole,), motion))
    strongest = max((one.motion for one in found if one.motion is not None), key=lambda one: one.times, default=None)
    return Moved(joined(span for one in found for span in one.spans), strongest)


def _tilts(means: Sequence[OctaveMeans]) -> Sequence[tuple[Span, Motion]]:
    """Stretches in which gravity changes its direction, which the means are then without."""
    tilts = gravity_tilts(means)
    for axis in means if tilts else ():
        axis.leave_out([span for span, _ in tilts])
    return tilts


def _of_stream(stream: Stream, threads: int | None) -> Sequence[OctaveMeans]:
    if stream.quantity not in _LEVELS:
        return ()
    if not _is_plausible(stream) and stream.samples.transforms[0].kind != "rate":
        return ()  # rates over an interval that is wrong are wrong by as much
    base = max(round(SHORTEST / stream.grid.tau0), 1)
    first = max(round(math.log2(base * stream.grid.tau0 / SHORTEST)), 0)  # octave of the means of `base` samples
    if stream.grid.n < _LEAST_SECONDS * base << max(SECOND - first, 2):
        return ()
    missing = np.zeros(len(stream.channels)) if stream.mask is None else stream.mask.mean(axis=0)
    known = [channel for channel, share in zip(stream.channels, missing, strict=True) if share <= _MOST_MISSING]
    found = in_threads(lambda channel: OctaveMeans(stream, channel, base, first), known, threads)
    means = [one for one in found.values() if one.floor > 0]  # a constant is not measured
    sure = measures_gravity(means, in_si=True)
    for one in means:
        one.unit_is_sure = sure
        one.limit_floor()
    return means


def _is_plausible(stream: Stream) -> bool:
    return PLAUSIBLE_RATES[0] <= stream.grid.rate <= PLAUSIBLE_RATES[1]


def joined(spans: Iterable[Span], gap: float = _GAP) -> tuple[Span, ...]:
    """Stretches in order of time, with those as one that a rest of no more than `gap` seconds parts."""
    united: list[Span] = []
    for start, stop in sorted(spans):
        if united and start <= united[-1][1] + gap:
            united[-1] = united[-1][0], max(stop, united[-1][1])
        else:
            united.append((start, stop))
    return tuple(united)


def _blocks(found: OctaveMeans) -> Moved:
    """Blocks that move, and the whole if those that are left move together; drifts are not white over longer means."""
    if found.slow:
        return Moved((), None)
    length = min(max(round(found.stream.grid.duration / _BLOCK), 1), _MOST_BLOCKS)
    block = found.stream.grid.duration / length
    spans: list[Span] = []
    motions: list[Motion] = []
    edges = np.arange(length + 1, dtype=np.float64) * block
    may_move, may_drift = _may_move(found, edges), _may_drift(found, edges)
    for k in range(length):
        start, stop = k * block, (k + 1) * block
        motion = _judged(found, start, stop) if may_move[k] else None
        if motion is None and may_drift[k]:
            motion = _drift(found, start, stop)
        if motion is not None:
            spans.append(found.span(start, stop))
            motions.append(motion)
    found.leave_out(spans)
    whole = found.stream.grid.duration
    whole_may_move = length > len(spans) and _may_move(found, np.array([0.0, whole])).any()
    if whole_may_move and (motion := _judged(found, 0.0, whole)) is not None:
        spans.append(found.span(0.0, whole))
        motions.append(motion)
    return Moved(tuple(spans), max(motions, key=lambda one: one.times, default=None))


def _may_move(found: OctaveMeans, edges: Floats) -> Bools:
    """Whether stretches between edges reach the level that both conditions of `_judged` need."""
    limit, high_limit = _LEVELS[found.quantity]
    return found.reach(min(high_limit, max(limit, _RISE * found.floor)), edges)


def _judged(found: OctaveMeans, start: float, stop: float) -> Motion | None:
    """The strongest motion by the median of second differences; None at rest."""
    limit, high_limit = _LEVELS[found.quantity]
    lowest = math.inf
    motions: list[Motion] = []
    for octave in range(found.first, OCTAVES):
        tau = found.tau(octave)
        inside = present(found.differences(octave, start, stop))
        if len(inside) < LEAST_DIFFERENCES:
            break
        usual = median(inside)
        level = usual / NORMAL_MEDIAN * math.sqrt(tau)
        times = level / found.floor if found.floor > 0 else math.inf
        sure = level * (1 - _ERRORS / math.sqrt(len(inside)))
        high = level > high_limit and sure > _RISE_OF_HIGH * lowest
        risen = octave > FLOOR and level > limit and times > _RISE
        if usual > STEPS * found.step and (high or risen):
            motions.append(found.motion("varies", usual / NORMAL_MEDIAN, max(times, level / limit), tau))
        lowest = min(lowest, max(level, found.rounding_level(octave)))
    return max(motions, key=lambda one: one.times, default=None)


def _steepest(found: OctaveMeans, tau: float) -> tuple[float, float]:
    """Change of the mean of a sensor from one averaging time to the next, and that beyond which it is a motion."""
    steepest = SENSOR_CLASSES[found.quantity].noisiest["rate_ramp"] * tau
    noise = max(found.floor / math.sqrt(tau), found.step)
    return steepest, max(_DRIFT * steepest, _DRIFT_OVER_NOISE * noise)


def _may_drift(found: OctaveMeans, edges: Floats) -> list[bool]:
    """Whether half of the changes between edges are beyond that of a motion, as `_drift` needs it."""
    octave = _octave_of_drift(found)
    tau = found.tau(octave)
    _, limit = _steepest(found, tau)
    changes = np.abs(np.diff(found.by_octave[octave]))
    present_to = np.concatenate(([0], np.cumsum(np.isfinite(changes))))
    beyond_to = np.concatenate(([0], np.cumsum(changes > limit)))
    places = [min(round(edge / tau), len(changes) + 1) for edge in edges.tolist()]
    spans = [(a, max(b - 1, a)) for a, b in pairwise(places)]
    return [2 * int(beyond_to[b] - beyond_to[a]) >= int(present_to[b] - present_to[a]) for a, b in spans]


def _octave_of_drift(found: OctaveMeans) -> int:
    """That of 4 s; in a record shorter than a block, one that has enough means."""
    octave = OCTAVES - 1
    while octave > SECOND and len(found.by_octave[octave]) <= LEAST_DIFFERENCES:
        octave -= 1
    return octave


def _drift(found: OctaveMeans, start: float, stop: float) -> Motion | None:
    """A motion with a steady change of the mean that no sensor has: the median of first differences of means of 4 s."""
    octave = _octave_of_drift(found)
    tau = found.tau(octave)
    x = found.by_octave[octave][round(start / tau) : round(stop / tau)]
    changes = present(np.diff(x))
    if len(changes) < LEAST_DIFFERENCES:
        return None
    usual, (steepest, limit) = abs(median(changes)), _steepest(found, tau)
    if usual <= limit:
        return None
    return found.motion("varies", usual, usual / steepest, tau)


def _seconds(found: OctaveMeans) -> Moved:
    """Stretches of seconds in which the sensor is handled."""
    limit = _HANDLED[found.quantity]
    second = found.by_octave[found.second]
    size, n = found.tau(found.second), len(second)
    largest = np.zeros(n)
    for octave in range(max(FLOOR, found.first), found.second + 1):
        d = np.nan_to_num(found.differences(octave))
        tau = found.tau(octave)
        beyond = np.where(
            (d > limit) & (d * math.sqrt(tau) > _HANDLED_RISE * found.floor) & (d > STEPS * found.step), d, 0.0
        )
        at = np.minimum(((np.arange(len(d)) + 1) * tau / size).astype(int), n - 1)
        np.maximum.at(largest, at, beyond)
    is_short = found.stream.grid.duration < _BLOCK and not found.slow
    if is_short:
        _raise_by_departures(found, largest)
    turning = np.abs(np.nan_to_num(second)) if found.quantity == "angular_rate" else np.zeros(n)
    turning[turning < max(_LARGEST_BIAS, _HANDLED_RISE * found.floor / math.sqrt(size))] = 0.0
    flagged = (largest > 0) | (turning > 0)
    least = 1 if is_short else _LEAST_HANDLED
    spans: list[Span] = []
    strongest: Motion | None = None
    for a, b in _groups(flagged):
        if np.count_nonzero(flagged[a:b]) < least and not _turned(found, second, a, b):
            continue
        spans.append(found.span((a - 1) * size, (b + 1) * size))
        amount, rate = float(largest[a:b].max()), float(turning[a:b].max())
        times = amount * math.sqrt(size) / found.floor if found.floor > 0 else math.inf
        varies = found.motion("varies", amount, times, size)
        motion = varies if amount > 0 else found.motion("turns", rate, rate / _LARGEST_BIAS, (b - a) * size)
        strongest = motion if strongest is None or motion.times > strongest.times else strongest
    return Moved(tuple(spans), strongest)


def _raise_by_departures(found: OctaveMeans, largest: Floats) -> None:
    """Raise the largest change of each second of a short record to the departure of its means from their median."""
    n, size = len(largest), found.tau(found.second)
    for octave in range(max(_DEPARTS_FROM, found.first), found.second + 1):
        x, tau = found.by_octave[octave], found.tau(octave)
        away = np.nan_to_num(np.abs(x - median(present(x))))
        limit = max(_DEPARTS[found.quantity], _HANDLED_RISE * found.floor / math.sqrt(tau), STEPS * found.step)
        at = np.minimum((np.arange(len(x)) * tau / size).astype(int), n - 1)
        np.maximum.at(largest, at, np.where(away > limit, away, 0.0))


def _groups(flagged: Bools) -> Sequence[tuple[int, int]]:
    at = np.flatnonzero(flagged)
    if not len(at):
        return ()
    parts = np.split(at, np.flatnonzero(np.diff(at) > _GAP) + 1)
    return [(int(part[0]), int(part[-1]) + 1) for part in parts]


def _turned(found: OctaveMeans, second: Floats, a: int, b: int) -> bool:
    """Whether the sensor has another position after the seconds a to b: by gravity, or by the angle turned."""
    before, after = (
        present(part) for part in (second[max(a - 1 - _BESIDE, 0) : max(a - 1, 0)], second[b + 1 : b + 1 + _BESIDE])
    )
    if not (len(before) and len(after)):
        return False
    levels = median(before), median(after)
    if found.quantity == "acceleration":
        return abs(levels[1] - levels[0]) > _TURNED["acceleration"]
    inside = present(second[max(a - 1, 0) : b + 1]) - sum(levels) / 2
    return abs(float(inside.sum())) * found.tau(found.second) > _TURNED["angular_rate"]
