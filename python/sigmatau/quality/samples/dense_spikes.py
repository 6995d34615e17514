"""Frequent spikes, which show as a hump in the tail of the noise although each alone could be noise."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from sigmatau._native.neighbours import medians_of_others, residuals, scatter
from sigmatau.arrays import Bools, Floats, Ints, median
from sigmatau.frozen import frozen
from sigmatau.quality.samples.common import present
from sigmatau.quality.samples.local_scatter import medians, neighbours
from sigmatau.record.streams import CHUNK

_NORMAL = NormalDist()


@frozen
class HumpThresholds:
    """Thresholds of `dense_spikes`; lengths are in standard deviations of the noise."""

    tail: float = 4.0
    """Beginning of the tail. [standard deviations] Derived: of 24 000 samples of Gaussian noise 1.5 are beyond it."""

    beyond: float = 5.0
    """Beginning of the hump. [standard deviations] Derived: of 24 000 samples of Gaussian noise 0.01 are beyond it."""

    count: int = 12
    """Samples of a hump, at least. [samples] Derived: so many are not noise, see `beyond`."""

    hump: float = 2.0
    """Samples beyond 5 over those from 4 to 5, at least. [1] Derived: Laplace's law has 0.4, Student's of 4 degrees
    0.8, of 3 degrees 1.2; spikes of 6 standard deviations have 5."""

    false_share: float = 1e-5
    """Share of noise among the spikes found. [1] Judgement: it is 1e-4 where the scale of the noise is known to 7 %
    only."""

    near_false_share: float = 1e-2
    """The same where more than `near_share` of the spikes is above that threshold by less than `near_width`. [1]
    Judgement: spikes below the threshold would be missed, which costs more."""

    near_width: float = 1.0
    """Distance above the threshold within which spikes are near it. [standard deviations] Judgement: see
    `near_false_share`."""

    near_share: float = 0.05
    """Part of the spikes that is near it. [1] Judgement: see `near_false_share`."""

    highest: float = 6.0
    """Threshold, at most. [standard deviations] Derived: that of single spikes, see `SpikeThresholds`."""

    remaining: float = 3.5
    """Spikes remain if more samples are beyond it than noise makes. [standard deviations] Derived: of 24 000 samples
    of Gaussian noise 11 are beyond it."""

    times: float = 2.0
    """Samples there over those of noise, from which on spikes remain. [1] Judgement: Gaussian noise has one times."""

    sigmas: float = 6.0
    """Standard errors of that number that are added to it. [1] Judgement: no record reaches six standard errors by
    chance."""

    spoiled: float = 0.05
    """Share of spikes beyond which half of the neighbours are often spikes. [1] Derived: of four neighbours two are
    in 1.4 % of the cases."""

    max_share: float = 0.25
    """Share of spikes beyond which the noise has no scale. [1] Judgement: the median of the residuals of such a
    record is not that of its noise."""

    apart: int = 3
    """Spikes are independent: those from here to `reach` from another are counted. [samples] Judgement: a spike
    behind a filter has two samples or three."""

    reach: int = 16
    """The end of that range. [samples] Judgement: noise that swells does so for longer."""

    clustered: float = 2.0
    """Their number over that by chance beyond which the noise swells. [1] Judgement: independent spikes have one
    times."""

    scatter_factor: float = 3.0
    """Factor over the scatter of its neighbours that a spike must exceed. [1] Judgement: noise that swells for a
    moment does not."""

    scatter_factor_many: float = 2.0
    """The same where half of the neighbours may be spikes. [1] Judgement: their scatter is then larger."""

    one_side: float = 0.5
    """Part of the residual that a spike must have against either side. [1] Derived: at a step of the mean a sample
    is far from one side only."""

    almost: float = 1.5
    """Samples below the threshold by less than this are examined again without the spikes beside them. [standard
    deviations] Judgement: a spike beside another moves the median by so much."""

    rounds: int = 4
    """How often they are. [1] Judgement: of spikes beside each other each round finds one on either side."""

    sides: tuple[int, int] = (16, 4)
    """Neighbours on either side whose median a sample is compared with. [samples] Derived: many are better for white
    noise, few for a random walk; the one with the least residual counts."""

    stretch: int = 1024
    """Length of the stretches that the tail is taken from. [samples] Judgement: bounds the time of a long record."""

    stretches: int = 24
    """Their number. [1] Judgement: see `stretch`."""

    least_residuals: int = 512
    """Residuals that the tail is taken from, at least. [samples] Judgement: their scale is known to 4 %."""

    block: int = 128
    """Samples of the blocks whose scale a spike is compared with, the noisiest of three. [samples] Judgement: a
    median of them is known to 7 %."""


THRESHOLDS = HumpThresholds()


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Tail:
    """Residuals of a part of a record in standard deviations."""

    side: int
    usual: float
    scale: float
    share: float
    far: Floats
    count: int
    clustered: bool


def dense_spikes(x: Floats, step: float, *, thresholds: HumpThresholds = THRESHOLDS) -> Bools | None:
    """Samples in a hump of the tail, more than 4 to 6 standard deviations from the median about them; None without a hump.

    A record has a hump if of 24 000 samples twelve or more are beyond 5 standard deviations, and twice as many as between 4
    and 5. The standard deviation is that of the samples outside the tail; where the noise is stronger for 128 samples, the
    local one. Noise below the `step` of the numbers is not examined.
    """
    tail = _tail(x, step, thresholds=thresholds)
    if tail is None or tail.share > thresholds.max_share:
        return None
    beyond = int(np.count_nonzero(tail.far > thresholds.beyond))
    if tail.clustered or beyond < thresholds.count or beyond < thresholds.hump * (len(tail.far) - beyond):
        return None
    share = beyond / tail.count
    threshold = _threshold(thresholds.false_share * share, thresholds=thresholds)
    close = np.count_nonzero((tail.far > threshold) & (tail.far < threshold + thresholds.near_width))
    if close > thresholds.near_share * len(tail.far):
        threshold = _threshold(thresholds.near_false_share * share, thresholds=thresholds)
    strength = np.concatenate(
        [_strength(x, start, tail, step, thresholds=thresholds) for start in range(0, len(x), CHUNK)]
    )
    is_spike = np.zeros(len(x), dtype=bool)
    rest, part = x, 0.5 if share < thresholds.spoiled else 0.25
    candidates = np.flatnonzero(strength > threshold)
    residual = np.abs(_residual_at(x, candidates, tail.side, thresholds=thresholds))
    new = candidates[
        _stands_alone(x, candidates, tail.side, residual, part, thresholds.scatter_factor_many, thresholds=thresholds)
    ]
    below = np.flatnonzero(strength > threshold - thresholds.almost)
    size = (
        np.abs(_residual_at(x, below, tail.side, thresholds=thresholds)) / strength[below]
    )  # of one standard deviation there
    for _ in range(thresholds.rounds):
        if len(new) == 0:
            break
        if rest is x:
            rest = x.copy()
        is_spike[new], rest[new] = True, np.nan
        is_open = ~is_spike[below]
        below, size = below[is_open], size[is_open]
        away = np.abs(_residual_at(rest, below, tail.side, thresholds=thresholds))
        beyond_it = np.flatnonzero(away > threshold * size)
        new = below[beyond_it]
        new = new[
            _stands_alone(
                rest, new, tail.side, away[beyond_it], 0.5, thresholds.scatter_factor_many, thresholds=thresholds
            )
        ]
    return is_spike if is_spike.any() else None


def hidden(rest: Floats, step: float, *, thresholds: HumpThresholds = THRESHOLDS) -> bool:
    """Whether a record without its spikes has more outliers than noise makes: smaller spikes remain."""
    tail = _tail(rest, step, thresholds=thresholds)
    if tail is None:
        return False
    by_chance = 2 * tail.count * _NORMAL.cdf(-thresholds.remaining)
    return bool(
        np.count_nonzero(tail.far > thresholds.remaining)
        > thresholds.times * by_chance + thresholds.sigmas * math.sqrt(by_chance)
    )


def _threshold(false: float, *, thresholds: HumpThresholds) -> float:
    return min(max(-_NORMAL.inv_cdf(false / 2), thresholds.tail), thresholds.highest)


def _tail(x: Floats, step: float, *, thresholds: HumpThresholds) -> _Tail | None:
    """The tail of a part of the record, for the number of neighbours that leaves the least residual."""
    n = len(x)
    starts = (
        [0]
        if n <= thresholds.stretch * thresholds.stretches
        else np.linspace(0, n - thresholds.stretch, thresholds.stretches).astype(int).tolist()
    )
    parts = [x[s : s + thresholds.stretch] if len(starts) > 1 else x for s in starts]
    best: tuple[float, int, list[Floats]] | None = None
    for side in thresholds.sides:
        away = [np.abs(_residual(part, side, step)) for part in parts]
        residuals_present = present(np.concatenate(away))
        if len(residuals_present) < thresholds.least_residuals:
            return None
        usual = median(residuals_present)
        if best is None or usual < best[0]:
            best = usual, side, away
    if best is None or not best[0] / _NORMAL.inv_cdf(0.75) > step:
        return None
    usual, side, away = best
    relative = [each / _local(each, usual, thresholds=thresholds) for each in away]
    ordered = np.sort(present(np.concatenate(relative)))
    scale, share = _scale(ordered, thresholds=thresholds)
    heights, spread = [], []
    for part, size, each in zip(parts, away, relative, strict=True):
        places = np.flatnonzero(each > thresholds.remaining * scale)
        quantile = 0.5 if share < thresholds.spoiled else 0.25
        alone = places[
            _stands_alone(part, places, side, size[places], quantile, thresholds.scatter_factor, thresholds=thresholds)
        ]
        heights.append(each[alone])
        spread.append(_with_others(alone[each[alone] > thresholds.tail * scale], thresholds=thresholds))
    return _Tail(
        side=side,
        usual=usual,
        scale=scale,
        share=share,
        far=np.concatenate(heights) / scale,
        count=len(ordered),
        clustered=_more_than_chance(np.concatenate(spread), len(ordered), thresholds=thresholds),
    )


def _with_others(places: Ints, *, thresholds: HumpThresholds) -> Bools:
    """Which of some indices have another one near, but not next to them."""
    after = np.searchsorted(places, places + thresholds.reach, side="right") > np.searchsorted(
        places, places + thresholds.apart
    )
    before = np.searchsorted(places, places - thresholds.apart, side="right") > np.searchsorted(
        places, places - thresholds.reach
    )
    return np.asarray(after | before)


def _more_than_chance(has_others: Bools, n: int, *, thresholds: HumpThresholds) -> bool:
    chance = 1 - (1 - min(len(has_others) / n, 1.0)) ** (2 * (thresholds.reach - thresholds.apart + 1))
    expected = len(has_others) * chance
    return bool(
        np.count_nonzero(has_others) > thresholds.clustered * expected + thresholds.sigmas * math.sqrt(expected + 1)
    )


def _scale(ordered: Floats, *, thresholds: HumpThresholds) -> tuple[float, float]:
    """Standard deviation from the median outside the tail, and the share of samples in the tail beyond that of noise."""
    share, n = 0.0, len(ordered)
    chance = 2 * _NORMAL.cdf(-thresholds.remaining)
    for _ in range(20):
        scale = float(ordered[int(n * (1 - share) / 2)]) / _NORMAL.inv_cdf(0.75)
        tail = (n - int(np.searchsorted(ordered, thresholds.remaining * scale))) / n
        share = min(max((tail - chance) / (1 - chance), 0.0), 2 * thresholds.max_share)
    return scale, share


def _residual(x: Floats, side: int, step: float) -> Floats:
    """Samples less the median of those on both sides, NaN where more than half of these are missing; steps are blurred."""
    result: Floats = x - medians_of_others(x, side, side)
    if step > 0:
        golden = (math.sqrt(5) - 1) / 2
        result += step / 2 * (np.arange(len(x)) * golden % 1 - 0.5)
    return result


def _local(away: Floats, usual: float, *, thresholds: HumpThresholds) -> Floats:
    """The median residual of blocks, the largest of a block and those beside it, and the usual one at least."""
    blocks = max(-(-len(away) // thresholds.block), 1)
    padded = np.full(blocks * thresholds.block, np.nan)
    padded[: len(away)] = away
    rows = padded.reshape(blocks, thresholds.block)
    has_scale = np.isfinite(rows).sum(axis=1) >= thresholds.block // 2
    here = np.where(has_scale, medians(rows), usual)
    wide = np.concatenate((here[:1], here, here[-1:]))
    largest = np.maximum(np.maximum(wide[:-2], wide[1:-1]), wide[2:])
    return np.repeat(np.maximum(largest, usual), thresholds.block)[: len(away)]


def _strength(x: Floats, start: int, tail: _Tail, step: float, *, thresholds: HumpThresholds) -> Floats:
    """Residuals of a piece of the record in standard deviations; 0 where there is none."""
    before = min(start, thresholds.block)
    part = x[start - before : start + CHUNK + thresholds.block]
    away = np.abs(_residual(part, tail.side, step))
    strength = away / (_local(away, tail.usual, thresholds=thresholds) * tail.scale)
    return np.nan_to_num(strength[before : before + CHUNK])


def _residual_at(x: Floats, places: Ints, side: int, *, thresholds: HumpThresholds) -> Floats:
    """Some samples less the median of those on both sides; 0 where these are all missing."""
    result = np.zeros(len(places))
    for start in range(0, len(places), CHUNK):
        some = places[start : start + CHUNK]
        others = neighbours(x, some, -side, side)
        others[:, side] = np.nan
        enough = np.isfinite(others).sum(axis=1) >= min(thresholds.sides)
        result[start : start + CHUNK][enough] = x[some[enough]] - medians(others[enough])
    return result


def _stands_alone(
    x: Floats, places: Ints, side: int, away: Floats, part: float, times: float, *, thresholds: HumpThresholds
) -> Bools:
    """Whether samples are far from either side, compared with the scatter of their neighbours."""
    alone = np.zeros(len(places), dtype=bool)
    for start in range(0, len(places), CHUNK):
        piece = slice(start, start + CHUNK)
        on_sides = np.abs(residuals(x, places[piece], side))
        alone[piece] = (on_sides > thresholds.one_side * away[piece]) & (
            away[piece] > times * scatter(x, places[piece], part)
        )
    return alone
