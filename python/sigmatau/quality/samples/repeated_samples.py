"""Samples that occur several times: a sensor slower than its log, and messages that are logged twice."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from sigmatau.arrays import Bools, Floats, Ints, Runs
from sigmatau.findings.finding import Finding
from sigmatau.findings.values import RepeatedSamples
from sigmatau.frozen import frozen
from sigmatau.quality.facts import stream_fact
from sigmatau.quality.samples.common import FEW_STEPS, SIGMAS, block_rms, full_ends, growing_step
from sigmatau.quality.samples.resolution import equal_by_chance, find_step, resolution
from sigmatau.record.streams import Stream

# Smallest share of repeated samples beyond chance. [1] Derived: samples that occur twice raise N² by twice their share,
# here N by 2 %.
_MIN_SHARE = 0.02
# Smallest number of equal neighbours. [samples] Judgement: the number then has an error of a quarter.
_MIN_EQUAL = 20
# Largest share of equal neighbours expected from the step of a channel. [1] Judgement: above it, chance and repetition
# cannot be distinguished.
_MAX_CHANCE = 0.5
# Smallest size of the changes of a channel that is judged. [steps] Judgement: coarser numbers repeat without a fault.
_MIN_STEPS = 3.0
# Number of copies in a stretch in which they are counted. [samples] Judgement: their number varies by a quarter by chance.
_COPIES_IN_STRETCH = 20
# Number of such stretches below which copies count as regular. [1] Judgement: the spread of 20 numbers has an error of
# a sixth.
_MIN_STRETCHES = 20
# Largest spread of regular copies, over that by chance. [1] Judgement: halfway between a clock and chance.
_MAX_SPREAD = 0.5
# Smallest share of copies among values other than the most frequent one, over that among all. [1] Judgement: a sensor
# that is slower than its log repeats all values equally.
_MIN_SHARE_RATIO = 0.9
# Number of parts of the record; more than half of them must have copies. [1] Judgement: a sensor that is slower than
# its log is slow all the time.
_PARTS = 8
# Largest relative distance of the mean number of copies from an integer. [1] Judgement: two clocks differ by less than
# 1 %.
_INTEGER_TOLERANCE = 0.01
# Factor of the random walk above which repetition is reported. [1] Judgement: the usual interval is 5 %.
_MIN_FACTOR = 1.01
# Shortest averaging time from which σ is correct. [samples] Judgement: copies change σ within a few samples.
_CORRECT_FROM = 8
# Shortest such averaging time per repetition. [samples] Judgement: see `_CORRECT_FROM`.
_CORRECT_FROM_TIMES = 4


@frozen(kw_only=False)
class Repeats:
    """Repetition of the samples of a stream."""

    channels: tuple[str, ...]  # channels whose samples repeat
    share: float  # share of the samples that are copies of the previous one
    shortest: int  # number of repetitions of a sample, ignoring the rarest 2.5 % at either end
    longest: int
    # mean over the rows of the number of copies of their sample: N² of the rows over that of a sensor at the rate of
    # the rows
    squares: float
    regular: bool  # whether copies are evenly spaced, as from a sensor at a lower rate, and not random

    @property
    def times(self) -> float:
        """Mean number of occurrences of a sample."""
        return 1 / (1 - self.share)


def runs_of_equal(x: Floats, *, shortest: int = 2) -> Runs:
    """First samples and lengths of all runs of at least `shortest` equal samples; NaN differs from all values."""
    return _runs(x[1:] == x[:-1], shortest)


def runs_of_places(places: Ints) -> Runs:
    """First places and lengths of the runs of consecutive places; `places` in order."""
    if len(places) == 0:
        return places, places
    breaks = np.flatnonzero(np.diff(places) > 1)
    first = places[np.concatenate(([0], breaks + 1))]
    return first, places[np.concatenate((breaks, [len(places) - 1]))] - first + 1


def _runs(equal: Bools, shortest: int) -> Runs:
    longer = max(shortest - 2, 0)
    # Starts of runs that are long enough: they are rarer than equal neighbours, and so faster to collect.
    n = max(len(equal) - longer, 0)
    going = equal[:n].copy()
    for k in range(1, longer + 1):
        going &= equal[k : n + k]
    first, lengths = runs_of_places(np.flatnonzero(going))
    return first, lengths + 1 + longer


@stream_fact
def repeats(stream: Stream) -> Repeats | None:
    """Find repeated samples on all channels at the same time, or on some; None if there are none or if it cannot be decided.

    On several channels: if a part h of all samples is copied on all of them at once, and neighbours of channel c are
    equal by chance with probability p_c, then f_c = h + (1-h)·p_c are equal on one and A = h + (1-h)·∏p_c on all:
    as many equations as unknowns. On one channel: p = q/(√(2π)·s) for steps q and changes of standard deviation s.
    """
    together: Bools | None = None
    inside: Bools | None = None
    equals: dict[str, Bools] = {}  # channels that repeat and change
    alone: dict[str, float] = {}
    whole = True
    for channel in stream.channels:
        x = stream.column(channel)
        equal = x[1:] == x[:-1]
        count = int(np.count_nonzero(equal))
        if count == len(equal):
            continue
        if count < _MIN_EQUAL:
            whole = False
            continue
        counted = _inside(x)
        if (share := _share_alone(stream, channel, x, equal, counted)) > 0:
            alone[channel] = share
        if counted is not None:
            inside = counted if inside is None else inside & counted
        equals[channel] = equal
        together = equal if together is None else together & equal
    if whole and together is not None and len(equals) > 1:
        columns = [*equals.values(), together]
        if inside is not None:
            columns = [equal[inside] for equal in columns]
        n = len(columns[-1])
        *shares, at_once = (int(np.count_nonzero(equal)) / (n + 1) for equal in columns)
        share = _share_together(shares, at_once, n) if n else 0.0
        if share > 0 and _in_all_parts(columns, share):
            return _repeats(tuple(equals), share, columns[-1])
    if not alone:
        return None
    channel = max(alone, key=lambda c: alone[c])
    x = stream.column(channel)
    equal, inside = x[1:] == x[:-1], _inside(x)
    return _repeats(tuple(alone), alone[channel], equal if inside is None else equal[inside])


def _in_all_parts(columns: list[Bools], share: float) -> bool:
    """Whether most parts of the record have copies: the step of single precision grows with an angle, on all axes at the
    same time.
    """
    parts = 0
    edges = np.linspace(0, len(columns[-1]), _PARTS + 1).astype(int).tolist()
    for a, b in pairwise(edges):
        *shares, at_once = (int(np.count_nonzero(equal[a:b])) / (b - a) for equal in columns)
        parts += _solved(shares, at_once) > share / 3
    return 2 * parts > _PARTS


def _inside(x: Floats) -> Bools | None:
    """Mask of samples inside the range; None if all are. Samples at an end of the range may be equal without a fault."""
    ends = full_ends(x)
    if not ends:
        return None
    inside = np.ones(len(x) - 1, dtype=bool)
    for end in ends:
        inside &= x[:-1] != end
    return inside


def _repeats(channels: tuple[str, ...], share: float, equal: Bools) -> Repeats:
    _, lengths = _runs(equal, 2)
    single = max(len(equal) + 1 - int(lengths.sum()), 0)
    counts = np.bincount(lengths)
    counts[1] = single
    part = np.cumsum(counts) / counts.sum()
    shortest, longest = (int(np.searchsorted(part, level)) for level in (0.025, 0.975))
    whole = round(1 / (1 - share))
    if shortest == whole and abs((1 - share) * whole - 1) < _INTEGER_TOLERANCE:
        longest = whole  # longer runs are equal by chance
    rows = single + int(lengths.sum())
    squares = (single + float(lengths.astype(float) @ lengths)) / rows
    if whole == longest and shortest == longest:
        squares = float(whole)
    return Repeats(channels, share, shortest, longest, squares, _evenly(equal, share))


def _evenly(equal: Bools, share: float) -> bool:
    """Whether the number of copies in stretches with about twenty of them varies by less than half as much as by chance."""
    size = max(math.ceil(_COPIES_IN_STRETCH / min(share, 1 - share)), 1)
    count = len(equal) // size
    if count < _MIN_STRETCHES:
        return True
    copies = equal[: count * size].reshape(count, size).sum(axis=1)
    # Only the middle half of the stretches is used, ±0.67 standard deviations, so that a pause or two does not matter.
    low, high = np.quantile(copies, [0.25, 0.75])
    spread = float(high - low) / 1.349
    return spread < _MAX_SPREAD * math.sqrt(size * share * (1 - share))


def _share_alone(stream: Stream, channel: str, x: Floats, equal: Bools, inside: Bools | None) -> float:
    """Share of copies on a channel beyond those expected by chance; 0 if chance may explain them."""
    counted = equal if inside is None else equal[inside]
    n = len(counted)
    differences = np.diff(x[: 1 << 18])
    scale, step = block_rms(differences[differences != 0]), find_step(stream, channel)
    if not n or scale < _MIN_STEPS * step or growing_step(x) > 0:
        return 0.0
    by_step = step / (math.sqrt(2 * math.pi) * scale) if scale > 0 else 0.0
    chance = max(by_step, equal_by_chance(stream, channel))
    if not chance < 1:
        return 0.0
    share = (int(np.count_nonzero(counted)) / (n + 1) - chance) / (1 - chance)
    if not share > _MIN_SHARE + chance + SIGMAS * math.sqrt(chance / n):
        return 0.0
    # A stuck part of the record is not a repetition: samples must repeat in most parts of the record.
    by_part = sorted(np.count_nonzero(part) / max(len(part), 1) for part in np.array_split(counted, 8))
    spread_out = by_part[2] > chance + (1 - chance) * share / 3
    return share if spread_out and _repeats_beside_mode(stream, channel, x, equal, share) else 0.0


def _repeats_beside_mode(stream: Stream, channel: str, x: Floats, equal: Bools, share: float) -> bool:
    """Whether values other than the most frequent one repeat as often; a counter rests at one value between its pulses."""
    steps = resolution(stream, channel)
    if steps is None or steps.ratio >= FEW_STEPS:
        return True
    values, counts = np.unique(x[: 1 << 16], return_counts=True)
    moving = x[:-1] != values[np.argmax(counts)]
    return int(np.count_nonzero(equal & moving)) > _MIN_SHARE_RATIO * share * int(np.count_nonzero(moving))


def _share_together(shares: list[float], all_at_once: float, n: int) -> float:
    """Solve the equations of `repeats` for h by bisection; 0 if chance may explain it."""
    f = np.array(shares)
    if all_at_once * n < _MIN_EQUAL:
        return 0.0
    h = _solved(shares, all_at_once)
    chance = (f - h) / (1 - h)
    if chance.max() > _MAX_CHANCE:
        return 0.0
    noise = math.sqrt(float(np.prod(f)) / n)  # at h = 0
    return h if h > _MIN_SHARE + SIGMAS * noise else 0.0


def _solved(shares: list[float], all_at_once: float) -> float:
    f = np.array(shares)
    low, high = 0.0, min(all_at_once, float(f.min()))
    for _ in range(60):
        h = (low + high) / 2
        by_chance = np.prod((f - h) / (1 - h)) if h < 1 else 0.0
        low, high = (h, high) if h + (1 - h) * by_chance < all_at_once else (low, h)
    return (low + high) / 2


def repeated_samples(stream: Stream) -> list[Finding]:
    """Report samples that are copies of the previous one: sample and hold, duplicated messages. At most one finding.

    `factors` has terms other than the random walk only if the user gave the rate, which may then be the sensor's.
    """
    how = repeats(stream)
    if how is None:
        return []
    k, rate, may_be_sensors = how.times, stream.grid.rate, stream.grid.source.given_alone
    # Samples have weights w: N² of the rows over that of a sensor is Σw²/n at the same rate, and Σw²/(n·k) at a lower rate.
    at_log_rate, at_sensor_rate = math.sqrt(how.squares), math.sqrt(how.squares / k)
    factors: tuple[tuple[str, float], ...] = ()
    if not how.regular:
        factors = (("random_walk", at_log_rate),)
    elif may_be_sensors:
        walks = (("rate_random_walk", 1 / math.sqrt(k)), ("rate_ramp", 1 / k))
        factors = (("quantization", k), ("random_walk", at_log_rate), *walks)
    elif at_sensor_rate > _MIN_FACTOR:
        factors = (("random_walk", at_sensor_rate),)
    details = RepeatedSamples(
        pattern="held" if how.regular else "irregular",
        copies=round(how.share * stream.grid.n),
        share=how.share,
        times=k,
        shortest=how.shortest,
        longest=how.longest,
        log_rate=rate,
        sensor_rate=rate / k,
        rate_given=may_be_sensors,
        sigma_one_sample=1 / k,
        right_from=max(_CORRECT_FROM, math.ceil(_CORRECT_FROM_TIMES * k)),
        walk_at_log_rate=at_log_rate,
        walk_at_sensor_rate=at_sensor_rate,
    )
    return [Finding(details=details, severity="warning", channels=how.channels, size=k, factors=factors)]
