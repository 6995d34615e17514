"""Frequent spikes, which form a hump in the tail of the noise although each alone could be noise."""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import Literal

import numpy as np

from sigmatau._native.neighbours import neighbour_medians, residuals, scatter
from sigmatau.arrays import Bools, Floats, Ints, median
from sigmatau.frozen import frozen
from sigmatau.quality.samples.common import SIGMAS, beyond_chance, present
from sigmatau.quality.samples.spike_scale import (
    MIN_HEIGHT,
    NORMAL_QUARTILE,
    SIDE,
    TAIL_COUNT,
    TAIL_FROM,
    TIMES,
    WIDE,
    medians,
    neighbours,
    stretches,
)
from sigmatau.record.streams import CHUNK

# Beginning of the hump. [standard deviations] Derived: of 24 000 samples of Gaussian noise 0.01 are beyond it.
_HUMP_FROM = 5.0
# Smallest ratio of the number of samples beyond 5 to the number from 4 to 5. [1] Derived: Laplace's law has 0.4,
# Student's of 4 degrees 0.8, of 3 degrees 1.2; spikes of 6 standard deviations have 5.
_HUMP_RATIO = 2.0
# Share of noise among the detected spikes. [1] Judgement: it is 1e-4 if the scale of the noise has an error of 7 %.
_FALSE_SHARE = 1e-5
# Share of noise among them if more than `_NEAR_SHARE` of the spikes exceed the threshold by less than `_NEAR_WIDTH`.
# [1] Judgement: otherwise spikes below the threshold would be missed, which is worse.
_NEAR_FALSE_SHARE = 1e-2
# Distance above the threshold within which spikes are near it. [standard deviations] Judgement: see
# `_NEAR_FALSE_SHARE`.
_NEAR_WIDTH = 1.0
# Smallest share of the spikes near the threshold. [1] Judgement: see `_NEAR_FALSE_SHARE`.
_NEAR_SHARE = 0.05
# Distance beyond which additional samples, compared with noise, show that spikes remain. [standard deviations] Derived:
# of 24 000 samples of Gaussian noise 11 are beyond it.
_REMAINING = 3.5
# Share of spikes above which half of the neighbours are often spikes. [1] Derived: two of four neighbours are spikes in
# 1.4 % of the cases.
_MANY_SPIKES = 0.05
# Share of spikes above which the scale of the noise is unknown. [1] Judgement: the median of the residuals of such a
# record is not that of its noise.
_MAX_SHARE = 0.25
# Shortest distance to the next spike in the test of whether spikes are independent. [samples] Judgement: a filtered
# spike has two or three samples.
_APART = 3
# Longest distance in that test. [samples] Judgement: a swell of the noise lasts longer.
_REACH = 16
# Ratio of the number of such spikes to that by chance, above which the noise swells. [1] Judgement: independent spikes
# have a ratio of one.
_CLUSTERED = 2.0
# Smallest ratio of a spike to the scatter of its neighbours. [1] Judgement: a short swell of the noise stays below.
_SCATTER_FACTOR = 3.0
# Smallest such ratio if half of the neighbours may be spikes. [1] Judgement: their scatter is then larger.
_SCATTER_FACTOR_MANY = 2.0
# Smallest distance of a spike from either side, over its residual. [1] Derived: at a step of the mean a sample is far
# from one side only.
_ONE_SIDE = 0.5
# Distance below the threshold within which samples are examined again without neighbouring spikes. [standard
# deviations] Judgement: a neighbouring spike moves the median by up to this distance.
_RECHECKED = 1.5
# Number of these further rounds. [1] Judgement: each round finds one more spike on either side of a group.
_RECHECK_ROUNDS = 4
# Smallest number of residuals in the tail. [samples] Judgement: their scale has an error of 4 %.
_MIN_RESIDUALS = 512
# Length of the blocks; a spike is compared with the noisiest of three blocks. [samples] Judgement: a median of one
# block has an error of 7 %.
_SCALE_BLOCK = 128


_NORMAL = NormalDist()
_GOLDEN = (math.sqrt(5) - 1) / 2


@frozen(eq=False)
class _Tail:
    """Residuals of a part of a record, in standard deviations."""

    side: int  # number of neighbours on either side whose median is subtracted
    usual: float  # median of the absolute residuals [unit of the samples]
    scale: float  # standard deviation outside the tail over the median residual of a block
    share: float  # share of samples in the tail, minus that of noise [1]
    heights: Floats  # sizes of the samples beyond `remaining` without a large neighbour
    count: int  # number of residuals
    clustered: bool  # whether the largest residuals are closer to each other than by chance

    def number_beyond(self, height: float) -> int:
        return int(np.count_nonzero(self.heights > height))


def dense_spikes(x: Floats, step: float) -> Bools | None:
    """Find samples in a hump of the tail, more than 4 to 6 standard deviations from the local median; None without a hump.

    A record has a hump if at least 12 of 24 000 samples are beyond 5 standard deviations, and twice as many as between 4 and
    5. The standard deviation is that of the samples outside the tail, or the local one where the noise is stronger for 128
    samples. Noise below the `step` of the numbers is not examined.
    """
    tail = _tail(x, step)
    if tail is None or tail.share > _MAX_SHARE or tail.clustered:
        return None
    in_hump = tail.number_beyond(_HUMP_FROM)
    if in_hump < max(TAIL_COUNT, _HUMP_RATIO * (len(tail.heights) - in_hump)):
        return None
    share = in_hump / tail.count
    threshold = _threshold(_FALSE_SHARE * share)
    close = np.count_nonzero((tail.heights > threshold) & (tail.heights < threshold + _NEAR_WIDTH))
    if close > _NEAR_SHARE * len(tail.heights):
        threshold = _threshold(_NEAR_FALSE_SHARE * share)
    strength = np.concatenate([_strength(x, start, tail, step) for start in range(0, len(x), CHUNK)])
    is_spike = np.zeros(len(x), dtype=bool)
    rest, quantile = x.copy(), 0.5 if share < _MANY_SPIKES else 0.25
    candidates = np.flatnonzero(strength > threshold)
    heights = _heights(x, candidates, tail.side)
    below = np.flatnonzero(strength > threshold - _RECHECKED)
    sd = _heights(x, below, tail.side) / strength[below]  # standard deviation at each sample of `below`
    for _ in range(_RECHECK_ROUNDS):
        alone = _stands_alone(rest, candidates, tail.side, heights, quantile, _SCATTER_FACTOR_MANY)
        new, quantile = candidates[alone], 0.5
        if len(new) == 0:
            break
        is_spike[new], rest[new] = True, np.nan
        is_open = ~is_spike[below]
        below, sd = below[is_open], sd[is_open]
        heights = _heights(rest, below, tail.side)
        is_beyond = heights > threshold * sd
        candidates, heights = below[is_beyond], heights[is_beyond]
    return is_spike if is_spike.any() else None


def has_hidden_spikes(rest: Floats, step: float) -> bool:
    """Whether the remaining samples have more outliers than noise, so that smaller spikes remain."""
    tail = _tail(rest, step)
    if tail is None:
        return False
    by_chance = 2 * tail.count * _NORMAL.cdf(-_REMAINING)
    return tail.number_beyond(_REMAINING) > beyond_chance(by_chance, times=TIMES)


def _threshold(false_share: float) -> float:
    return min(max(-_NORMAL.inv_cdf(false_share / 2), TAIL_FROM), MIN_HEIGHT)


def _tail(x: Floats, step: float) -> _Tail | None:
    """The tail of a part of the record, with the number of neighbours that gives the smallest residual.

    More neighbours are better for white noise, fewer for a random walk.
    """
    parts = stretches(x)
    best: tuple[float, int, list[Floats]] | None = None
    for side in (WIDE, SIDE):
        sizes = [np.abs(_residual(part, side, step)) for part in parts]
        sizes_present = present(np.concatenate(sizes))
        if len(sizes_present) < _MIN_RESIDUALS:
            return None
        usual = median(sizes_present)
        if best is None or usual < best[0]:
            best = usual, side, sizes
    if best is None or not best[0] / NORMAL_QUARTILE > step:
        return None
    usual, side, sizes = best
    relative = [each / _local(each, usual) for each in sizes]
    ordered = np.sort(present(np.concatenate(relative)))
    scale, share = _scale(ordered)
    quantile = 0.5 if share < _MANY_SPIKES else 0.25
    heights, has_close_neighbour = [], []
    for part, size, each in zip(parts, sizes, relative, strict=True):
        places = np.flatnonzero(each > _REMAINING * scale)
        alone = places[_stands_alone(part, places, side, size[places], quantile, _SCATTER_FACTOR)]
        heights.append(each[alone])
        has_close_neighbour.append(_has_close_neighbour(alone[each[alone] > TAIL_FROM * scale]))
    return _Tail(
        side=side,
        usual=usual,
        scale=scale,
        share=share,
        heights=np.concatenate(heights) / scale,
        count=len(ordered),
        clustered=_is_clustered(np.concatenate(has_close_neighbour), len(ordered)),
    )


def _has_close_neighbour(places: Ints) -> Bools:
    """Mark indices with another index close by, but not adjacent."""
    first, last = _APART, _REACH

    def count_to(index: Ints, side: Literal["left", "right"]) -> Ints:
        return np.searchsorted(places, index, side=side)

    after = count_to(places + last, "right") > count_to(places + first, "left")
    return np.asarray(after | (count_to(places - first, "right") > count_to(places - last, "left")))


def _is_clustered(has_close_neighbour: Bools, n: int) -> bool:
    """Whether more spikes have another spike close by than independent spikes would."""
    chance = 1 - (1 - min(len(has_close_neighbour) / n, 1.0)) ** (2 * (_REACH - _APART + 1))
    expected = len(has_close_neighbour) * chance
    limit = _CLUSTERED * expected + SIGMAS * math.sqrt(expected + 1)
    return bool(np.count_nonzero(has_close_neighbour) > limit)


def _scale(ordered: Floats) -> tuple[float, float]:
    """Standard deviation of the residuals outside the tail, and the share of samples in the tail minus that of noise."""
    share, n = 0.0, len(ordered)
    chance = 2 * _NORMAL.cdf(-_REMAINING)
    for _ in range(20):
        scale = float(ordered[int(n * (1 - share) / 2)]) / NORMAL_QUARTILE
        tail = (n - int(np.searchsorted(ordered, _REMAINING * scale))) / n
        share = min(max((tail - chance) / (1 - chance), 0.0), 2 * _MAX_SHARE)
    return scale, share


def _residual(x: Floats, side: int, step: float) -> Floats:
    """Samples minus the median of their neighbours on both sides; NaN if more than half of these are missing. Dither
    blurs the steps of the numbers.
    """
    result: Floats = x - neighbour_medians(x, side, side)
    if step > 0:
        result += step / 2 * (np.arange(len(x)) * _GOLDEN % 1 - 0.5)
    return result


def _local(sizes: Floats, usual: float) -> Floats:
    """Median residual of the noisiest of a block and its two neighbours, for each sample; never below the usual one."""
    length = _SCALE_BLOCK
    blocks = max(-(-len(sizes) // length), 1)
    rows = np.append(sizes, np.full(blocks * length - len(sizes), np.nan)).reshape(blocks, length)
    has_scale = np.isfinite(rows).sum(axis=1) >= length // 2
    level = np.where(has_scale, medians(rows), usual)
    wide = np.concatenate((level[:1], level, level[-1:]))
    largest = np.maximum(np.maximum(wide[:-2], wide[1:-1]), wide[2:])
    return np.repeat(np.maximum(largest, usual), length)[: len(sizes)]


def _strength(x: Floats, start: int, tail: _Tail, step: float) -> Floats:
    """Residuals of a piece of the record, in standard deviations; 0 where there is no residual."""
    before = min(start, _SCALE_BLOCK)
    sizes = np.abs(_residual(x[start - before : start + CHUNK + _SCALE_BLOCK], tail.side, step))
    strength = sizes / (_local(sizes, tail.usual) * tail.scale)
    return np.nan_to_num(strength[before : before + CHUNK])


def _heights(x: Floats, places: Ints, side: int) -> Floats:
    """Distance of some samples from the median of their neighbours on both sides; 0 if nearly all of these are missing."""
    heights = np.zeros(len(places))
    for start in range(0, len(places), CHUNK):
        some = places[start : start + CHUNK]
        beside_each = neighbours(x, some, -side, side)
        beside_each[:, side] = np.nan
        enough = np.isfinite(beside_each).sum(axis=1) >= SIDE
        heights[start : start + CHUNK][enough] = np.abs(x[some[enough]] - medians(beside_each[enough]))
    return heights


def _stands_alone(x: Floats, places: Ints, side: int, heights: Floats, quantile: float, times: float) -> Bools:
    """Whether samples are far from both sides, compared with the scatter of their neighbours."""
    from_sides = np.abs(residuals(x, places, side))
    is_high = heights > times * scatter(x, places, quantile)
    return np.asarray((from_sides > _ONE_SIDE * heights) & is_high)
