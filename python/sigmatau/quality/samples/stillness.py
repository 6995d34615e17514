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
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import Bools, Floats, median
from sigmatau.findings.finding import Span
from sigmatau.findings.kinds.rest import Motion
from sigmatau.quality.facts import in_threads
from sigmatau.quality.samples.common import present, row_means
from sigmatau.quality.samples.resolution import step_of
from sigmatau.quality.samples.units import GRAVITY, GRAVITY_TOLERANCE
from sigmatau.record.streams import CHUNK, PLAUSIBLE_RATES, Stream

Counts = NDArray[np.int64]

_SHORTEST, _OCTAVES = 1 / 16, 7  # averaging times: 1/16 s to 4 s
_FLOOR = 2  # octave of the averaging time of the noise that motion is compared with, behind most filters: 1/4 s
_SECOND = 4  # octave of 1 s
_BLOCK, _MOST_BLOCKS = 40.0, 128  # least length of the blocks that are judged as a whole [s], and their number
_FLOOR_BLOCKS, _FLOOR_SHARE = 10.0, 0.1  # blocks whose noise is compared [s], and the share that shows a quiet sensor
_LEAST = 5  # second differences that a level can be taken from

# √τ times the deviation of means beyond which a sensor moves, and the rise over the noise at shorter times that goes with
# it: beyond the noise of all sensors a small rise, beyond that of most a large one. Studied in studies/rest.py. The noise of
# gyros for sale is up to 0.05 (deg/s)/√Hz, that of accelerometers up to 1 mg/√Hz, see `units`. [SI unit/√Hz]
_LEVELS = {"angular_rate": (math.radians(0.05), math.radians(0.175)), "acceleration": (0.015, 0.03)}
_RISE, _RISE_OF_HIGH = 8.0, 1.6
# The same over 2 s and 4 s, where vibration has averaged out: ten times the noise of any accelerometer, so that no rise is
# asked for. Only where three axes measure gravity: a wrong unit would make noise as large.
_LOUD, _LOUD_FROM = 0.1, 5  # [m/s^2/√Hz], octave
_NORMAL_MEDIAN = 0.6745  # of absolute normal deviates
_ERRORS = 3.0  # a level by the median of n differences is wrong by no more than so many times 1/√n

# Largest mean rate of a gyro at rest: twice the largest zero-rate offset of consumer sensors' datasheets. [rad/s]
_LARGEST_BIAS = math.radians(20)

# Change of the mean from second to second, in standard deviations of one mean, of a sensor in someone's hands, and how much
# more than its noise that is. Steps and knocks of a table are less. [SI unit]
_HANDLED = {"angular_rate": math.radians(1.0), "acceleration": 0.2}
_HANDLED_RISE = 10.0
_LEAST_HANDLED = 4  # seconds of motion that are more than a knock
_GAP = 4  # seconds of rest between two motions that are not a stretch
_TURNED = {"angular_rate": math.radians(5), "acceleration": 9.8 * math.radians(5)}  # another position, after any motion
_BESIDE = 5  # seconds before and after a motion that show the position
_MOST_MISSING = 0.5  # share of the samples of a channel that is judged
_STEPS = 3.0  # steps of the numbers by which rounding can move a second difference


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
    means = [one for stream in streams for one in _of_stream(stream, threads)]
    handled = [_seconds(one) for one in means]
    gone = joined(span for one in handled for span in one.spans)
    for one in means:
        one.leave_out(gone)
    found = [*handled, *map(_blocks, means)]
    strongest = max((one.motion for one in found if one.motion is not None), key=lambda one: one.times, default=None)
    return Moved(joined(span for one in found for span in one.spans), strongest)


def _of_stream(stream: Stream, threads: int | None) -> Sequence[_Means]:
    if stream.quantity not in _LEVELS or not PLAUSIBLE_RATES[0] <= stream.grid.rate <= PLAUSIBLE_RATES[1]:
        return ()
    base = max(round(_SHORTEST / stream.grid.tau0), 1)
    first = max(round(math.log2(base * stream.grid.tau0 / _SHORTEST)), 0)  # octave of the means of `base` samples
    if first > _SECOND or stream.grid.n < _LEAST * base << (_SECOND - first):
        return ()
    missing = np.zeros(len(stream.channels)) if stream.mask is None else stream.mask.mean(axis=0)
    known = [channel for channel, share in zip(stream.channels, missing, strict=True) if share <= _MOST_MISSING]
    found = in_threads(lambda channel: _Means(stream, channel, base, first), known, threads)
    means = [one for one in found.values() if one.floor > 0]  # a constant is not measured
    if stream.quantity == "acceleration" and len(means) == len(stream.channels) == 3:
        gravity = math.hypot(*(one.level for one in means))
        for one in means:
            one.loud = _LOUD if abs(gravity / GRAVITY - 1) < GRAVITY_TOLERANCE else math.inf
    return means


def joined(spans: Iterable[Span], gap: float = _GAP) -> tuple[Span, ...]:
    """Stretches in order of time, with those as one that a rest of no more than `gap` seconds parts."""
    united: list[Span] = []
    for start, stop in sorted(spans):
        if united and start <= united[-1][1] + gap:
            united[-1] = united[-1][0], max(stop, united[-1][1])
        else:
            united.append((start, stop))
    return tuple(united)


class _Means:
    """The means of a channel by octaves of averaging time, and the noise that they have at rest."""

    def __init__(self, stream: Stream, channel: str, base: int, first: int) -> None:
        self.stream, self.channel, self.first = stream, channel, first
        self.quantity = stream.quantity
        self.shortest = base * stream.grid.tau0
        means = _means(stream, channel, base)
        self.by_octave: dict[int, Floats] = {}
        for octave in range(first, _OCTAVES):
            self.by_octave[octave] = means
            means = row_means(means[: len(means) // 2 * 2].reshape(-1, 2))
        self.step = step_of(stream, channel) or 0.0
        self.floor = self._floor()
        self.loud = math.inf  # √τ times the deviation of means that no sensor at rest has, where the unit is sure

    @property
    def level(self) -> float:
        """Mean of the channel."""
        known = present(self.by_octave[_SECOND])
        return float(known.mean()) if len(known) else 0.0

    def tau(self, octave: int) -> float:
        """Averaging time of an octave. [s]"""
        return self.shortest * 2.0 ** (octave - self.first)

    def differences(self, octave: int, start: float = 0.0, stop: float = math.inf) -> Floats:
        """Second differences of a stretch, as standard deviations of one mean."""
        tau = self.tau(octave)
        x = self.by_octave[octave]
        x = x[round(start / tau) : min(round(min(stop / tau, len(x))), len(x))]
        return np.asarray(np.abs(x[:-2] - 2 * x[1:-1] + x[2:]) / math.sqrt(6))

    def reach(self, limit: float, edges: Floats) -> Bools:
        """Whether medians between edges may reach a level at some averaging time, by counts of second differences."""
        start, stop = edges[:-1], edges[1:]
        found = np.zeros(len(start), dtype=bool)
        for octave in self.by_octave:
            tau, d = self.tau(octave), self.differences(octave)
            known, above = _before(~np.isnan(d)), _before(d > _NORMAL_MEDIAN * limit / math.sqrt(tau))
            n = len(known) + 1
            a = np.rint(start / tau).astype(int)
            b = np.minimum(np.rint(np.minimum(stop / tau, n)).astype(int), n) - 2
            some = np.flatnonzero(b > a)
            a, b = a[some], b[some]
            found[some[2 * (above[b] - above[a]) >= known[b] - known[a]]] = True
        return found

    def _floor(self) -> float:
        """√τ times the deviation of means in the quiet parts of the record, with what rounding makes. [unit/√Hz]"""
        octave = max(_FLOOR, self.first)
        d, tau = self.differences(octave), self.tau(octave)
        size = min(max(round(_FLOOR_BLOCKS / tau), _LEAST), max(len(d), 1))
        level = present(row_means((d * d)[: len(d) // size * size].reshape(-1, size)))
        quiet = float(np.quantile(level, _FLOOR_SHARE)) * tau if len(level) else 0.0
        return math.sqrt(quiet + self.step**2 / 12 * self.stream.grid.tau0)

    def span(self, start: float, stop: float) -> Span:
        """A stretch from the first sample on as one of the log."""
        lead, length = self.stream.grid.lead, self.stream.grid.duration
        return lead + max(start, 0.0), lead + min(stop, length)

    def leave_out(self, spans: Iterable[Span]) -> None:
        """Take the means of some stretches of the log for missing."""
        lead = self.stream.grid.lead
        for octave, x in self.by_octave.items():
            tau = self.tau(octave)
            for start, stop in spans:
                x[max(math.floor((start - lead) / tau), 0) : max(math.ceil((stop - lead) / tau), 0)] = np.nan

    def motion(self, kind: Literal["varies", "turns"], size: float, times: float, tau: float) -> Motion:
        return Motion(channel=self.channel, quantity=self.quantity, kind=kind, size=size, times=times, tau=tau)


def _before(flags: Bools) -> Counts:
    before = np.zeros(len(flags) + 1, dtype=np.int64)
    np.cumsum(flags, out=before[1:])
    return before


def _means(stream: Stream, channel: str, base: int) -> Floats:
    c, n = stream.channels.index(channel), stream.grid.n // base * base
    many = max(CHUNK // base, 1) * base
    parts = [row_means(stream.samples.read(c, a, min(a + many, n)).reshape(-1, base)) for a in range(0, n, many)]
    return np.concatenate(parts)


def _blocks(found: _Means) -> Moved:
    """Blocks that move, and the whole if those that are left move together."""
    length = min(max(round(found.stream.grid.duration / _BLOCK), 1), _MOST_BLOCKS)
    block = found.stream.grid.duration / length
    spans: list[Span] = []
    motions: list[Motion] = []
    edges = np.arange(length + 1, dtype=np.float64) * block
    for k in np.flatnonzero(_may_move(found, edges)).tolist():
        if (motion := _judged(found, k * block, (k + 1) * block)) is not None:
            spans.append(found.span(k * block, (k + 1) * block))
            motions.append(motion)
    found.leave_out(spans)
    whole = found.stream.grid.duration
    may_move = length > len(spans) and _may_move(found, np.array([0.0, whole])).any()
    if may_move and (motion := _judged(found, 0.0, whole)) is not None:
        spans.append(found.span(0.0, whole))
        motions.append(motion)
    return Moved(tuple(spans), max(motions, key=lambda one: one.times, default=None))


def _may_move(found: _Means, edges: Floats) -> Bools:
    """Whether stretches between edges reach the level that both conditions of `_judged` need."""
    limit, high_limit = _LEVELS[found.quantity]
    return found.reach(min(high_limit, max(limit, _RISE * found.floor)), edges)


def _judged(found: _Means, start: float, stop: float) -> Motion | None:
    """The strongest motion by the median of second differences; None at rest."""
    limit, high_limit = _LEVELS[found.quantity]
    lowest = math.inf
    motions: list[Motion] = []
    for octave in range(found.first, _OCTAVES):
        tau = found.tau(octave)
        inside = present(found.differences(octave, start, stop))
        if len(inside) < _LEAST:
            break
        usual = median(inside)
        level = usual / _NORMAL_MEDIAN * math.sqrt(tau)
        times = level / found.floor if found.floor > 0 else math.inf
        sure = level * (1 - _ERRORS / math.sqrt(len(inside)))
        high = level > high_limit and sure > _RISE_OF_HIGH * lowest
        risen = octave > _FLOOR and level > limit and times > _RISE
        loud = octave >= _LOUD_FROM and sure > found.loud
        if usual > _STEPS * found.step and (high or risen or loud):
            motions.append(found.motion("varies", usual / _NORMAL_MEDIAN, max(times, level / limit), tau))
        lowest = min(lowest, level)
    return max(motions, key=lambda one: one.times, default=None)


def _seconds(found: _Means) -> Moved:
    """Stretches of seconds in which the sensor is handled."""
    limit = _HANDLED[found.quantity]
    second = found.by_octave[_SECOND]
    size, n = found.tau(_SECOND), len(second)
    largest = np.zeros(n)
    for octave in range(max(_FLOOR, found.first), _SECOND + 1):
        d = np.nan_to_num(found.differences(octave))
        tau = found.tau(octave)
        beyond = np.where(
            (d > limit) & (d * math.sqrt(tau) > _HANDLED_RISE * found.floor) & (d > _STEPS * found.step), d, 0.0
        )
        at = np.minimum(((np.arange(len(d)) + 1) * tau / size).astype(int), n - 1)
        np.maximum.at(largest, at, beyond)
    turning = np.abs(np.nan_to_num(second)) if found.quantity == "angular_rate" else np.zeros(n)
    turning[turning < max(_LARGEST_BIAS, _HANDLED_RISE * found.floor / math.sqrt(size))] = 0.0
    flagged = (largest > 0) | (turning > 0)
    spans: list[Span] = []
    strongest: Motion | None = None
    for a, b in _groups(flagged):
        if np.count_nonzero(flagged[a:b]) < _LEAST_HANDLED and not _turned(found, second, a, b):
            continue
        spans.append(found.span((a - 1) * size, (b + 1) * size))
        amount, rate = float(largest[a:b].max()), float(turning[a:b].max())
        times = amount * math.sqrt(size) / found.floor if found.floor > 0 else math.inf
        varies = found.motion("varies", amount, times, size)
        motion = varies if amount > 0 else found.motion("turns", rate, rate / _LARGEST_BIAS, (b - a) * size)
        strongest = motion if strongest is None or motion.times > strongest.times else strongest
    return Moved(tuple(spans), strongest)


def _groups(flagged: Bools) -> Sequence[tuple[int, int]]:
    at = np.flatnonzero(flagged)
    if not len(at):
        return ()
    parts = np.split(at, np.flatnonzero(np.diff(at) > _GAP) + 1)
    return [(int(part[0]), int(part[-1]) + 1) for part in parts]


def _turned(found: _Means, second: Floats, a: int, b: int) -> bool:
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
    return abs(float(inside.sum())) * found.tau(_SECOND) > _TURNED["angular_rate"]
