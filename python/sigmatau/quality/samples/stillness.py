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
from sigmatau.frozen import frozen
from sigmatau.quality.facts import in_threads
from sigmatau.quality.samples.common import present
from sigmatau.quality.samples.gravity_direction import gravity_tilts, measures_gravity
from sigmatau.quality.samples.octave_means import (
    NORMAL_MEDIAN,
    OctaveMeans,
    OctaveThresholds,
)
from sigmatau.quality.samples.tremor import shaken
from sigmatau.quality.sensor_class import SENSOR_CLASSES, ByQuantity
from sigmatau.record.streams import PLAUSIBLE_RATES, Stream


@frozen
class StillnessThresholds:
    """Thresholds of `moved`; docs/study/rest.md measures the false alarms and the motion that is missed."""

    octaves: OctaveThresholds = OctaveThresholds()
    """Averaging times of the means, and thresholds of their noise. [1] Derived: see there."""

    block: float = 40.0
    """Length of the blocks that are judged as a whole, at least; a shorter record is judged by single seconds too.
    [s] Judgement: ten means of 4 s."""

    most_blocks: int = 128
    """Number of blocks, at most. [1] Judgement: bounds the time of a long record."""

    level: ByQuantity = ByQuantity(angular_rate=math.radians(0.05), acceleration=0.015)
    """√τ times the deviation of means beyond which a sensor moves that rises by `rise`. [rad/s/√Hz, m/s^2/√Hz]
    Study: docs/study/rest.md; gyros for sale have up to 0.05 (deg/s)/√Hz, accelerometers 1 mg/√Hz."""

    high_level: ByQuantity = ByQuantity(angular_rate=math.radians(0.175), acceleration=0.03)
    """The same of a sensor that rises by `rise_of_high`: beyond the noise of all sensors. [rad/s/√Hz, m/s^2/√Hz]
    Study: docs/study/rest.md."""

    rise: float = 8.0
    """Rise of that level over the noise at shorter times, beyond the noise of most sensors. [1] Study:
    docs/study/rest.md, clean records with Gauss-Markov processes up to 8 times the white noise."""

    rise_of_high: float = 1.6
    """The same beyond `high_level`. [1] Study: docs/study/rest.md."""

    drift: float = 2.0
    """Change of the mean from one 4 s to the next over the steepest warm-up of a sensor. [1] Judgement: a sensor
    that warms up has rate random walk too."""

    drift_over_noise: float = 5.0
    """The same over the noise of the means. [1] Judgement: the median of five changes or more does not reach it by
    chance."""

    errors: float = 3.0
    """A level by the median of n differences is wrong by no more than so many times 1/√n. [1] Derived: the median of
    absolute normal deviates has a relative error of 1.17/√n; 2.6 standard errors."""

    largest_bias: float = math.radians(20)
    """Mean rate of a gyro at rest, at most. [rad/s] Datasheets: twice the largest zero-rate offset of usual consumer
    sensors, see `UnitThresholds`."""

    handled: ByQuantity = ByQuantity(angular_rate=math.radians(1.0), acceleration=0.2)
    """Change of the mean from second to second, as the deviation of a mean, of a sensor in someone's hands. [rad/s,
    m/s^2] Judgement: steps and knocks of a table are less; docs/study/rest.md has the windows."""

    handled_rise: float = 10.0
    """The same over the noise of the sensor. [1] Judgement: no noise makes it by chance."""

    least_handled: int = 4
    """Seconds of motion that are more than a knock; in a record shorter than a block, a knock is motion. [s]
    Judgement: a knock rings for less."""

    departure: float = 2.0
    """Departure of a mean of a short record from the median, over `handled`, also at its ends, where there are no
    second differences. [1] Judgement: no drift makes twice the change of a sensor that is handled."""

    departs_from: int = 1
    """Octave from which on means depart, 1/8 s. [octaves] Judgement: shorter means have the noise of vibration."""

    least_seconds: int = 2
    """Length of a stream that is judged; below 1 Hz a second is four samples. [s] Derived: two seconds and a second
    difference of halves."""

    gap: int = 4
    """Rest between two motions that are one. [s] Judgement: too short a stretch for an analysis."""

    turned: ByQuantity = ByQuantity(angular_rate=math.radians(5), acceleration=9.8 * math.radians(5))
    """Change of position after any motion that is more than a knock. [rad, m/s^2] Derived: the 5° of
    `TiltThresholds`."""

    position_length: int = 5
    """Seconds before and after a motion that show the position. [s] Judgement: a median of five tolerates two that
    are disturbed."""

    most_missing: float = 0.5
    """Share of missing samples of a channel that is judged, at most. [1] Judgement: half of the record shows motion
    that lasts."""


THRESHOLDS = StillnessThresholds()


@dataclass(frozen=True, slots=True)
class Moved:
    """Stretches in which a sensor moves, and the strongest motion that shows it; None if there are none."""

    spans: tuple[Span, ...]  # from the beginning of the log, in order of time [s]
    motion: Motion | None


def moved(
    streams: Iterable[Stream], *, threads: int | None = None, thresholds: StillnessThresholds = THRESHOLDS
) -> Moved:
    """When the sensors of a record move, by their angular rates and accelerations.

    Seconds move if their means, or those of quarters of them, depart from those beside them as in someone's hands, for more
    than a moment or to another position. Of the rest, a block of 40 s or more moves, or the whole, if the median of its
    second differences is beyond noise at some averaging time.
    """
    by_stream = [_octave_means(stream, threads, thresholds=thresholds) for stream in streams]
    means = [one for alike in by_stream for one in alike]
    handled = [_seconds(one, thresholds=thresholds) for one in means]
    gone = joined([span for one in handled for span in one.spans], thresholds=thresholds)
    for one in means:
        one.leave_out(gone)
    tilted = [Moved((span,), motion) for alike in by_stream for span, motion in _tilts(alike)]
    found = [*handled, *tilted, *(_blocks(one, thresholds=thresholds) for one in means)]
    if not any(one.spans for one in found) and (motion := shaken(means)) is not None:
        whole = means[0].span(0.0, math.inf)
        found.append(Moved((whole,), motion))
    strongest = max((one.motion for one in found if one.motion is not None), key=lambda one: one.times, default=None)
    return Moved(joined([span for one in found for span in one.spans], thresholds=thresholds), strongest)


def _tilts(means: Sequence[OctaveMeans]) -> Sequence[tuple[Span, Motion]]:
    """Stretches in which gravity changes its direction, which the means are then without."""
    tilts = gravity_tilts(means)
    for axis in means if tilts else ():
        axis.leave_out([span for span, _ in tilts])
    return tilts


def _octave_means(stream: Stream, threads: int | None, *, thresholds: StillnessThresholds) -> Sequence[OctaveMeans]:
    """Computes the means of the channels of a sensor that can be judged."""
    if stream.quantity not in SENSOR_CLASSES:
        return ()
    if not _is_plausible(stream) and stream.samples.transforms[0].kind != "rate":
        return ()  # rates over an interval that is wrong are wrong by as much
    times = thresholds.octaves
    base = max(round(times.shortest / stream.grid.tau0), 1)
    first = max(round(math.log2(base * stream.grid.tau0 / times.shortest)), 0)  # octave of the means of `base` samples
    if stream.grid.n < thresholds.least_seconds * base << max(times.second - first, 2):
        return ()
    missing = np.zeros(len(stream.channels)) if stream.mask is None else stream.mask.mean(axis=0)
    known = [
        channel for channel, share in zip(stream.channels, missing, strict=True) if share <= thresholds.most_missing
    ]
    found = in_threads(lambda channel: OctaveMeans(stream, channel, base, first, thresholds=times), known, threads)
    means = [one for one in found.values() if one.floor > 0]  # a constant is not measured
    sure = measures_gravity(means, in_si=True)
    for one in means:
        one.unit_is_sure = sure
        one.limit_floor()
    return means


def _is_plausible(stream: Stream) -> bool:
    return PLAUSIBLE_RATES[0] <= stream.grid.rate <= PLAUSIBLE_RATES[1]


def joined(spans: Iterable[Span], *, thresholds: StillnessThresholds = THRESHOLDS) -> tuple[Span, ...]:
    """Stretches in order of time, with those as one that a short rest parts."""
    united: list[Span] = []
    for start, stop in sorted(spans):
        if united and start <= united[-1][1] + thresholds.gap:
            united[-1] = united[-1][0], max(stop, united[-1][1])
        else:
            united.append((start, stop))
    return tuple(united)


def _blocks(found: OctaveMeans, *, thresholds: StillnessThresholds) -> Moved:
    """Blocks that move, and the whole if those that are left move together; drifts are not white over longer means."""
    if found.slow:
        return Moved((), None)
    length = min(max(round(found.stream.grid.duration / thresholds.block), 1), thresholds.most_blocks)
    block = found.stream.grid.duration / length
    spans: list[Span] = []
    motions: list[Motion] = []
    edges = np.arange(length + 1, dtype=np.float64) * block
    may_move, may_drift = (
        _may_move(found, edges, thresholds=thresholds),
        _may_drift(found, edges, thresholds=thresholds),
    )
    for k in range(length):
        start, stop = k * block, (k + 1) * block
        motion = _judged(found, start, stop, thresholds=thresholds) if may_move[k] else None
        if motion is None and may_drift[k]:
            motion = _drift(found, start, stop, thresholds=thresholds)
        if motion is not None:
            spans.append(found.span(start, stop))
            motions.append(motion)
    found.leave_out(spans)
    whole = found.stream.grid.duration
    whole_may_move = length > len(spans) and _may_move(found, np.array([0.0, whole]), thresholds=thresholds).any()
    if whole_may_move and (motion := _judged(found, 0.0, whole, thresholds=thresholds)) is not None:
        spans.append(found.span(0.0, whole))
        motions.append(motion)
    return Moved(tuple(spans), max(motions, key=lambda one: one.times, default=None))


def _may_move(found: OctaveMeans, edges: Floats, *, thresholds: StillnessThresholds) -> Bools:
    """Whether stretches between edges reach the level that both conditions of `_judged` need."""
    limit, high_limit = thresholds.level[found.quantity], thresholds.high_level[found.quantity]
    return found.reach(min(high_limit, max(limit, thresholds.rise * found.floor)), edges)


def _judged(found: OctaveMeans, start: float, stop: float, *, thresholds: StillnessThresholds) -> Motion | None:
    """The strongest motion by the median of second differences; None at rest."""
    limit, high_limit = thresholds.level[found.quantity], thresholds.high_level[found.quantity]
    lowest = math.inf
    motions: list[Motion] = []
    for octave in range(found.first, found.thresholds.octaves):
        tau = found.tau(octave)
        inside = present(found.differences(octave, start, stop))
        if len(inside) < found.thresholds.least_differences:
            break
        usual = median(inside)
        level = usual / NORMAL_MEDIAN * math.sqrt(tau)
        times = level / found.floor if found.floor > 0 else math.inf
        sure = level * (1 - thresholds.errors / math.sqrt(len(inside)))
        high = level > high_limit and sure > thresholds.rise_of_high * lowest
        risen = octave > found.thresholds.floor and level > limit and times > thresholds.rise
        if usual > found.thresholds.steps * found.step and (high or risen):
            motions.append(found.motion("varies", usual / NORMAL_MEDIAN, max(times, level / limit), tau))
        lowest = min(lowest, max(level, found.rounding_level(octave)))
    return max(motions, key=lambda one: one.times, default=None)


def _steepest(found: OctaveMeans, tau: float, *, thresholds: StillnessThresholds) -> tuple[float, float]:
    """Change of the mean of a sensor from one averaging time to the next, and that beyond which it is a motion."""
    steepest = SENSOR_CLASSES[found.quantity].noisiest["rate_ramp"] * tau
    noise = max(found.floor / math.sqrt(tau), found.step)
    return steepest, max(thresholds.drift * steepest, thresholds.drift_over_noise * noise)


def _may_drift(found: OctaveMeans, edges: Floats, *, thresholds: StillnessThresholds) -> list[bool]:
    """Whether half of the changes between edges are beyond that of a motion, as `_drift` needs it."""
    octave = _octave_of_drift(found)
    tau = found.tau(octave)
    _, limit = _steepest(found, tau, thresholds=thresholds)
    changes = np.abs(np.diff(found.by_octave[octave]))
    present_to = np.concatenate(([0], np.cumsum(np.isfinite(changes))))
    beyond_to = np.concatenate(([0], np.cumsum(changes > limit)))
    places = [min(round(edge / tau), len(changes) + 1) for edge in edges.tolist()]
    spans = [(a, max(b - 1, a)) for a, b in pairwise(places)]
    return [2 * int(beyond_to[b] - beyond_to[a]) >= int(present_to[b] - present_to[a]) for a, b in spans]


def _octave_of_drift(found: OctaveMeans) -> int:
    """That of 4 s; in a record shorter than a block, one that has enough means."""
    octave = found.thresholds.octaves - 1
    while octave > found.thresholds.second and len(found.by_octave[octave]) <= found.thresholds.least_differences:
        octave -= 1
    return octave


def _drift(found: OctaveMeans, start: float, stop: float, *, thresholds: StillnessThresholds) -> Motion | None:
    """A motion with a steady change of the mean that no sensor has: the median of first differences of means of 4 s."""
    octave = _octave_of_drift(found)
    tau = found.tau(octave)
    x = found.by_octave[octave][round(start / tau) : round(stop / tau)]
    changes = present(np.diff(x))
    if len(changes) < found.thresholds.least_differences:
        return None
    usual, (steepest, limit) = abs(median(changes)), _steepest(found, tau, thresholds=thresholds)
    if usual <= limit:
        return None
    return found.motion("varies", usual, usual / steepest, tau)


def _seconds(found: OctaveMeans, *, thresholds: StillnessThresholds) -> Moved:
    """Stretches of seconds in which the sensor is handled."""
    limit = thresholds.handled[found.quantity]
    second = found.by_octave[found.second]
    size, n = found.tau(found.second), len(second)
    largest = np.zeros(n)
    for octave in range(max(found.thresholds.floor, found.first), found.second + 1):
        d = np.nan_to_num(found.differences(octave))
        tau = found.tau(octave)
        beyond = np.where(
            (d > limit)
            & (d * math.sqrt(tau) > thresholds.handled_rise * found.floor)
            & (d > found.thresholds.steps * found.step),
            d,
            0.0,
        )
        at = np.minimum(((np.arange(len(d)) + 1) * tau / size).astype(int), n - 1)
        np.maximum.at(largest, at, beyond)
    is_short = found.stream.grid.duration < thresholds.block and not found.slow
    if is_short:
        _raise_by_departures(found, largest, thresholds=thresholds)
    turning = np.abs(np.nan_to_num(second)) if found.quantity == "angular_rate" else np.zeros(n)
    turning[turning < max(thresholds.largest_bias, thresholds.handled_rise * found.floor / math.sqrt(size))] = 0.0
    flagged = (largest > 0) | (turning > 0)
    least = 1 if is_short else thresholds.least_handled
    spans: list[Span] = []
    strongest: Motion | None = None
    for a, b in _groups(flagged, thresholds=thresholds):
        if np.count_nonzero(flagged[a:b]) < least and not _turned(found, second, a, b, thresholds=thresholds):
            continue
        spans.append(found.span((a - 1) * size, (b + 1) * size))
        amount, rate = float(largest[a:b].max()), float(turning[a:b].max())
        times = amount * math.sqrt(size) / found.floor if found.floor > 0 else math.inf
        varies = found.motion("varies", amount, times, size)
        motion = varies if amount > 0 else found.motion("turns", rate, rate / thresholds.largest_bias, (b - a) * size)
        strongest = motion if strongest is None or motion.times > strongest.times else strongest
    return Moved(tuple(spans), strongest)


def _raise_by_departures(found: OctaveMeans, largest: Floats, *, thresholds: StillnessThresholds) -> None:
    """Raise the largest change of each second of a short record to the departure of its means from their median."""
    n, size = len(largest), found.tau(found.second)
    for octave in range(max(thresholds.departs_from, found.first), found.second + 1):
        x, tau = found.by_octave[octave], found.tau(octave)
        away = np.nan_to_num(np.abs(x - median(present(x))))
        limit = max(
            thresholds.departure * thresholds.handled[found.quantity],
            thresholds.handled_rise * found.floor / math.sqrt(tau),
            found.thresholds.steps * found.step,
        )
        at = np.minimum((np.arange(len(x)) * tau / size).astype(int), n - 1)
        np.maximum.at(largest, at, np.where(away > limit, away, 0.0))


def _groups(flagged: Bools, *, thresholds: StillnessThresholds) -> Sequence[tuple[int, int]]:
    at = np.flatnonzero(flagged)
    if not len(at):
        return ()
    parts = np.split(at, np.flatnonzero(np.diff(at) > thresholds.gap) + 1)
    return [(int(part[0]), int(part[-1]) + 1) for part in parts]


def _turned(found: OctaveMeans, second: Floats, a: int, b: int, *, thresholds: StillnessThresholds) -> bool:
    """Whether the sensor has another position after the seconds a to b: by gravity, or by the angle turned."""
    before, after = (
        present(part)
        for part in (
            second[max(a - 1 - thresholds.position_length, 0) : max(a - 1, 0)],
            second[b + 1 : b + 1 + thresholds.position_length],
        )
    )
    if not (len(before) and len(after)):
        return False
    levels = median(before), median(after)
    if found.quantity == "acceleration":
        return abs(levels[1] - levels[0]) > thresholds.turned["acceleration"]
    inside = present(second[max(a - 1, 0) : b + 1]) - sum(levels) / 2
    return abs(float(inside.sum())) * found.tau(found.second) > thresholds.turned["angular_rate"]
