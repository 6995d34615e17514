"""Lost samples that were filled in with straight lines: single samples and outages."""

from __future__ import annotations

import math

import numpy as np

from sigmatau.arrays import Floats, Ints, Runs
from sigmatau.frozen import frozen
from sigmatau.quality.facts import channel_fact
from sigmatau.quality.samples.common import FEW_STEPS, SIGMAS, block_rms, longest_of_tail, pieces, take_samples
from sigmatau.quality.samples.repeated_samples import runs_of_places
from sigmatau.quality.samples.resolution import find_step, resolution
from sigmatau.record.streams import Stream

# Probability of a reported outage in a record of noise alone. [1] Judgement: one false alarm in 10⁴ channels.
_FALSE_ALARM = 1e-4
# Smallest share of single samples that is reported, beyond chance. [1] Judgement: fewer do not change a coefficient.
_MIN_SHARE = 0.004
# Multiple of the share by chance that is added. [1] Judgement: intermittent noise has more differences near zero than
# its mean shows.
_TIMES_CHANCE = 3.0
# Shortest line in the tail by which other lines are judged. [samples] Judgement: three samples are on a line by chance
# more often than an exponential tail predicts.
_MIN_IN_TAIL = 4
# Share of samples on lines above which too little noise is left for a comparison. [1] Judgement: a tenth of the record
# must be noise.
_MAX_SHARE = 0.9
# Length above which a line is an outage instead of interpolated single samples. [samples] Judgement: a radio link
# loses a few samples at a time.
_MIN_STRETCH = 16
# Share of second differences that are 0 by chance, above which chance and lines cannot be distinguished. [1] Judgement:
# a line of 5 samples is then one in 10⁴.
TOO_COARSE = 0.15
# Rounding of a second difference, relative to the samples. [1] Derived: half a unit in the last place of each of four
# samples, and of their unit conversion.
_ROUNDING = 16 * float(np.finfo(float).eps)
# Share of the usual second difference that counts as 0, because of single precision and printed decimals. [1] Derived:
# noise is below it in one of 1250 cases.
_ZERO_SHARE = 1e-3
# Smallest number of differences for a share. [1] Judgement: a share then has an error of 0.06.
_MIN_DIFFERENCES = 64
# Number of samples that decide which differences are 0. [samples] Derived: 52 are below `_ZERO_SHARE` by chance, with
# an error of a seventh.
_EXAMINED = 1 << 16


@frozen(kw_only=False)
class Tolerance:
    """Size up to which second differences of a channel count as 0."""

    rounding: float  # rounding of a second difference by double precision [unit of the stream]
    largest: float  # second differences up to this are 0 [unit of the stream]
    scale: float  # root mean square of the second differences that are not 0 to rounding [unit of the stream]
    chance: float  # share of second differences that are 0 in noise; 1 if there is no noise


def tolerance(stream: Stream, channel: str, some: Floats) -> Tolerance | None:
    """Tolerance for zero second differences, from some samples of a channel; None if there are too few."""
    second = np.diff(some, n=2)
    if np.count_nonzero(np.isfinite(second)) < _MIN_DIFFERENCES:
        return None
    rounding = _ROUNDING * float(np.abs(some[np.isfinite(some)]).max())
    scale = block_rms(second[np.abs(second) > rounding])
    # Rounding of four numbers by up to q/2 each adds up to 2q.
    largest = rounding + _ZERO_SHARE * scale + 2.01 * find_step(stream, channel)
    chance = 2 * largest / (math.sqrt(2 * math.pi) * scale) if scale > 0 else 1.0
    return Tolerance(rounding, largest, scale, chance)


@frozen(kw_only=False, eq=False)
class StraightParts:
    """Samples on the line through their neighbours."""

    places: Ints  # indices of these samples
    chance: float  # share of all samples that are on a line in noise
    # change of second differences from sample to sample, over their size: 1.8 for white noise, small after a filter
    smooth: float


@frozen(kw_only=False, eq=False)
class Filled:
    """Lost samples that were filled in with straight lines."""

    first: Ints  # first sample and length of each run of filled samples
    lengths: Ints
    min_stretch: int  # length of a run above which it is an outage
    singles: float  # share of the samples in shorter runs, minus that on lines by chance
    # N at long τ over that of the sensor: samples next to a gap have more weight. Runs of 16 samples or more are ignored
    random_walk: float
    short: float  # σ at one sample over that of the sensor

    @property
    def outages(self) -> Runs:
        """First samples and lengths of the runs that are outages."""
        long = self.lengths >= self.min_stretch
        return self.first[long], self.lengths[long]


def straight_parts(stream: Stream, channel: str) -> StraightParts | None:
    """Find samples on the line through their neighbours, to rounding; None if coarse steps or too few samples hide lines."""
    some = take_samples(stream, channel, count=_EXAMINED)
    zero = tolerance(stream, channel, some)
    if zero is None or zero.chance > TOO_COARSE:
        return None
    places = [np.empty(0, dtype=np.int64)]
    beyond = 0
    for start, x in pieces(stream, channel, overlap=2):
        size = np.abs(np.diff(x, n=2))
        small = np.flatnonzero(size <= 3 * zero.largest)
        on = size[small] <= zero.largest
        beyond += len(small) - int(np.count_nonzero(on))
        places.append(small[on] + start + 1)
    # Noise has nearly the same density just beyond the tolerance; intermittent noise is near zero more often than its
    # mean predicts.
    chance = max(zero.chance, beyond / (2 * max(stream.grid.n, 1)))
    # Counts with an added slow bias have no common step, but their changes are nearly zero as often as their second
    # differences. In white noise,
    # changes are near zero √3 times as often as second differences, which are √3 times larger.
    second = np.diff(some, n=2)
    second = second[np.isfinite(second)]
    equal = float(np.count_nonzero(np.abs(np.diff(some)) <= zero.largest)) / len(second)
    chance = max(chance, equal / math.sqrt(3))
    moving = second[np.abs(second) > zero.rounding]
    return StraightParts(np.concatenate(places), chance, block_rms(np.diff(moving)) / zero.scale)


@channel_fact
def filled(stream: Stream, channel: str) -> Filled | None:
    """Find lost samples of a channel that were filled in with straight lines.

    A line of L samples is reported if n·p^L < 1e-4, where p is the share of samples on lines in white noise; a longer one
    is required if the changes of second differences are small. Single samples are reported if more than 0.4 % are on
    lines, beyond three times the share by chance, and the samples between them change like noise: in a record
    interpolated from another rate all samples are on lines.
    """
    parts = straight_parts(stream, channel)
    if parts is None or not len(parts.places):
        return None
    first, lengths = runs_of_places(parts.places)
    n = stream.grid.n
    share = len(parts.places) / n
    if share > _MAX_SHARE:
        return None
    longest = math.log(n / _FALSE_ALARM) / -math.log(max(share, parts.chance)) * max(1.0, 1 / max(parts.smooth, 1e-3))
    steps = resolution(stream, channel)
    if steps is not None and steps.ratio < FEW_STEPS:
        longest = max(longest, longest_of_tail(lengths[lengths >= _MIN_IN_TAIL], false_alarm=_FALSE_ALARM))
    long = lengths >= max(_MIN_STRETCH, longest)
    single = lengths < _MIN_STRETCH
    chance = parts.chance
    needed = _MIN_SHARE + _TIMES_CHANCE * chance + SIGMAS * math.sqrt(chance / n)
    if float(lengths[single].sum()) < needed * n:
        single[:] = False
    if not (long | single).any():
        return None
    x = stream.column(channel)
    # Equal samples are stuck and not on a line.
    moves = np.cumsum(np.concatenate(([False, False], x[1:] != x[:-1])))
    level = moves[first + lengths] == moves[first]
    long &= ~level
    single &= ~level
    if float(lengths[single].sum()) < needed * n or not _noise_between(x, parts.places):
        single[:] = False
    is_filled = long | single
    if not is_filled.any():
        return None
    random_walk, short = _effect_of_lost(first[single], lengths[single], n)
    part = float(lengths[single].sum()) / n
    true = max(1 - chance / part, 0.0) if part else 0.0
    return Filled(
        first[is_filled],
        lengths[is_filled],
        _MIN_STRETCH,
        part * true,
        1 + (random_walk - 1) * true,
        1 + (short - 1) * true,
    )


def _noise_between(x: Floats, straight: Ints) -> bool:
    """Whether adjacent changes away from the lines belong to different lines, as in noise.

    Interpolation to less than 2.5 times the rate has a correlation of +0.2, white noise −1/2, and noise after a filter up
    to 1. If the correlation does not decide, the number of samples between lines does: for a lower rate it is even, or
    one.
    """
    between = np.ones(len(x), dtype=bool)
    between[straight] = False
    apart_from_lines = between[1:-1] & between[2:] & between[:-2]
    change = np.diff(x)
    a, b = change[:-1][apart_from_lines], change[1:][apart_from_lines]
    is_present = np.isfinite(a) & np.isfinite(b)
    a, b = a[is_present], b[is_present]
    if len(a) < _MIN_DIFFERENCES:
        return False
    if float(a @ b) < -0.1 * float(a @ a):
        return True
    _, lengths = runs_of_places(np.flatnonzero(between))
    odd = (lengths % 2 == 1) & (lengths > 1)
    return bool(np.count_nonzero(odd) > 0.25 * len(lengths))


def _effect_of_lost(first: Ints, lengths: Ints, n: int) -> tuple[float, float]:
    """N at long τ and σ at one sample, both over those of the sensor.

    A gap of g samples adds a weight of g/2 to each of the two adjacent samples: N² is proportional to the mean of the
    squared weights over all rows. Each of the g + 1 changes across the gap is (b − a)/(g + 1), so that their squares sum
    to a (g + 1)⁻¹ share instead of g + 1.
    """
    weight = np.ones(n + 2)
    gone = np.zeros(n + 2, dtype=np.int8)
    np.add.at(weight, first, lengths / 2)  # row 0 of `weight` is before the first sample
    np.add.at(weight, first + lengths + 1, lengths / 2)
    np.add.at(gone, first + 1, 1)
    np.add.at(gone, first + lengths + 1, -1)
    weight[np.cumsum(gone) > 0] = 0.0
    squares = float(weight @ weight) - 2 - float(np.sum(weight[[0, -1]] ** 2 - 1))
    changes = n - float(np.sum(lengths + 1 - 1 / (lengths + 1)))
    return math.sqrt(squares / n), math.sqrt(max(changes, 0.0) / n)
