"""Spikes: single samples far from their neighbours."""

from __future__ import annotations

import math
from statistics import NormalDist

import numpy as np

from sigmatau._native.neighbours import outliers
from sigmatau.arrays import Bools, Floats, Ints, median, medians_of_present
from sigmatau.findings.disturbances import Spikes
from sigmatau.findings.finding import Finding
from sigmatau.findings.spans import longest_spans
from sigmatau.frozen import frozen
from sigmatau.quality.facts import channel_fact, stream_fact
from sigmatau.quality.samples.common import block_rms, largest_rounding, present
from sigmatau.quality.samples.dense_spikes import dense_spikes, has_hidden_spikes
from sigmatau.quality.samples.masking import MaskedFinding, masked
from sigmatau.quality.samples.resolution import step_of_changes
from sigmatau.quality.samples.spike_scale import (
    FALSE_SPIKES,
    MIN_HEIGHT,
    NORMAL_QUARTILE,
    SIDE,
    STRETCH,
    STRETCHES,
    TAIL_COUNT,
    TAIL_FROM,
    WIDE,
    neighbours,
    stretches,
)
from sigmatau.quality.samples.tails import TailReading, read_small_spikes, read_tail
from sigmatau.record.streams import Stream

# Height that is added for rounding. [steps] Derived: a step q shifts a sample and a median by q/2 each.
_STEPS = 1.0
# Noise that may not be visible in the scatter of numbers with this step. [steps] Study: docs/study/coarse.md; noise of
# 0.2 steps shows 0.06 to 0.5.
_UNSEEN = 0.3
# Ratio of the scale from blocks to that from the median, above which most blocks of 32 residuals contain a spike. [1]
# Derived: for about 2 % of spikes or more.
_SPOILED = 2.0
# Number of further searches in the remaining samples. [1] Judgement: adjacent spikes hide each other.
_ROUNDS = 8
# Number of samples with all four preceding neighbours, below which samples with two of these are used too. [samples]
# Judgement: their scale then has an error of 2 %.
_MIN_RESIDUALS = 1024
# Smallest number of samples with a scale. [samples] Judgement: one block of `block_rms`.
_MIN_SAMPLES = 32
# Number of neighbours on either side whose scatter a spike must also exceed. [samples] Judgement: in a shock all
# samples are large.
_SCATTER_SIDE = 32
# Fourth differences, over 6, in units of the residual, below which noise is smooth: medians of neighbours then follow
# slopes but not extremes, which are not spikes. [1] Derived: 0.8 for white noise and 0.53 for a random walk; a spike
# beyond the threshold then has 15 standard deviations of the fourth differences.
_SMOOTH = 0.4


_BATCH = 1 << 16  # samples per batch, to limit memory: each has 16 neighbours
_MIDDLE = 6.0  # weight of a single spike in its fourth difference: 6 of (1, 4, 6, 4, 1)


def find_spikes(x: Floats) -> Bools:
    """Samples that stand out from the medians of the four samples before and of the four samples after them; shape (n,).

    If spikes form a hump in the tail (a thousandth of all samples or more), the threshold is six standard deviations of
    the noise, see `sigmatau.quality.samples.dense_spikes`. If most blocks of 32 samples contain spikes, the scale is that
    of the median residual and the medians are over 16 samples: up to 20 % of spikes are found. The remaining samples are
    then searched again.

    The threshold is at least six standard deviations of that residual, plus one step of the numbers, so that Gaussian
    noise of any of the five terms has less than 0.001 spikes per record of any length. The standard deviation is a median
    over blocks, which spikes cannot move. If the neighbours scatter more than the record as a whole, as in a shock, their
    scatter is used. In noise smoother than a random walk, a spike must stand out in the fourth differences too. A step of
    the mean is not a spike. No spikes are found with fewer than 32 samples that can be judged.
    """
    x = np.asarray(x, dtype=np.float64)
    is_spike = np.zeros(len(x), dtype=bool)
    if len(x) < _MIN_SAMPLES:
        return is_spike
    rest, quantile = x, 0.5
    multiple = _multiple(len(x))
    for k in range(_ROUNDS):
        scale = _scale(rest)
        if k == 0 and scale.in_tail >= TAIL_COUNT and (dense := dense_spikes(x, scale.step)) is not None:
            is_spike[_beyond_smooth(x, np.flatnonzero(dense), scale, multiple)] = True
            rest = np.where(is_spike, np.nan, x)
            scale = _scale(rest)
        rounding = _STEPS * scale.step
        threshold = multiple * max(scale.noise, _UNSEEN * scale.step) + rounding
        if not (math.isfinite(threshold) and threshold > 0):
            break
        new = outliers(rest, threshold=threshold, multiple=multiple, smallest=rounding, side=scale.side, part=quantile)
        new = _beyond_smooth(x, new, scale, multiple)
        if len(new) == 0:
            break
        is_spike[new] = True
        if rest is x:
            rest = x.copy()
        rest[new] = np.nan
        quantile = 0.25 if scale.side == WIDE else 0.5  # where half of the changes at a spike may be to other spikes
    return is_spike


@channel_fact
def spike_mask(stream: Stream, channel: str) -> Bools:
    """The spikes of a channel, see `find_spikes`; read-only."""
    mask = find_spikes(stream.column(channel))
    mask.setflags(write=False)
    return mask


def more_below(rest: Floats) -> bool:
    """Whether the remaining samples have more outliers than noise, so that smaller spikes remain."""
    scale = _scale(rest)
    return not scale.smooth and has_hidden_spikes(rest, scale.step)


@stream_fact
def spikes(stream: Stream) -> list[MaskedFinding]:
    """Report the spikes of each channel: number, time and height. At most one finding per channel."""
    findings: list[MaskedFinding] = []
    for k, channel in enumerate(stream.channels):
        is_spike = spike_mask(stream, channel)
        if is_spike.any():
            mask = np.zeros((stream.grid.n, len(stream.channels)), dtype=bool)
            mask[:, k] = is_spike
            findings.append((_finding(stream, channel, is_spike), mask))
    return findings


@stream_fact
def spikes_missing(stream: Stream) -> Stream:
    """Mark the spikes of a stream as missing; the same object if there are none."""
    return masked(stream, np.stack([spike_mask(stream, channel) for channel in stream.channels], axis=1))


def _finding(stream: Stream, channel: str, is_spike: Bools) -> Finding:
    x, places = stream.column(channel), np.flatnonzero(is_spike)
    clean = np.where(is_spike, np.nan, x)
    heights = _heights(x, clean, places)
    largest = int(np.argmax(np.abs(heights)))
    times = stream.grid.lead + places * stream.grid.tau0
    spans, more_spans = longest_spans(times, times)
    heavy = more_below(clean)
    tail = read_tail(clean, heights) if heavy else TailReading(factor=1.0, error=0.0)
    return Finding(
        details=Spikes(
            unit=stream.unit,
            count=len(places),
            samples=len(x),
            share=len(places) / int(np.count_nonzero(np.isfinite(x))),
            height=float(heights[largest]),
            time=stream.grid.time(int(places[largest])),
            more_below=heavy,
            tail_factor=tail.factor,
            tail_error=tail.error,
            small_factor=1.0 if heavy else read_small_spikes(clean),
        ),
        severity="warning",
        channels=(channel,),
        spans=spans,
        more_spans=more_spans,
        size=float(np.abs(heights[largest])),
        unit=stream.unit,
    )


def _multiple(n: int) -> float:
    """Threshold in standard deviations: six; more for long records, and for short records, whose scale is uncertain."""
    needed = -NormalDist().inv_cdf(FALSE_SPIKES / (2 * n))
    used = min(n, STRETCH * STRETCHES)
    return max(MIN_HEIGHT, needed) * (1 + 2 / math.sqrt(used / _SCATTER_SIDE))


def _heights(x: Floats, clean: Floats, places: Ints) -> Floats:
    """Distance of spikes from the median of the adjacent good samples, or of all good samples if there are none."""
    heights = np.empty(len(places))
    for start in range(0, len(places), _BATCH):
        some = places[start : start + _BATCH]
        around_each = neighbours(clean, some, -WIDE, WIDE)
        lonely = ~np.isfinite(around_each).any(axis=1)
        if lonely.any():
            around_each[lonely] = np.nanmedian(clean)
        heights[start : start + _BATCH] = x[some] - medians_of_present(around_each)
    return heights


@frozen(kw_only=False)
class _Scale:
    """Noise to which a sample is compared."""

    noise: float  # standard deviation of the residual against one side
    step: float  # step of the numbers
    side: int  # number of neighbours on either side
    in_tail: int  # number of residuals in the tail
    fourth: float  # standard deviation of the fourth differences, over 6
    smooth: bool  # whether the noise is smooth, because a low-pass filter is far below the sampling rate


def _beyond_smooth(x: Floats, places: Ints, scale: _Scale, multiple: float) -> Ints:
    """In smooth noise, keep only the samples that also stand out in the fourth differences; otherwise keep all."""
    if len(places) == 0 or not scale.smooth:
        return places
    places_present = np.flatnonzero(np.isfinite(x))
    middle = np.clip(np.searchsorted(places_present, places), 2, len(places_present) - 3)
    fourth = np.abs(np.diff(x[places_present[middle[:, None] + np.arange(-2, 3)]], n=4)[:, 0]) / _MIDDLE
    limit = multiple * max(scale.fourth, _UNSEEN * scale.step) + _STEPS * scale.step
    return np.asarray(places[fourth > limit])


def _scale(x: Floats) -> _Scale:
    """Estimate the noise of a part of the record."""
    parts, side = stretches(x), SIDE
    rows = np.stack(parts)
    dust = largest_rounding(rows.ravel(), len(x))
    residual = (rows[:, side:] - _median(*(rows[:, k : k - side] for k in range(side)))).ravel()
    if np.isnan(rows).any():
        differences = np.abs(np.concatenate([np.diff(present(part)) for part in parts]))
    else:
        differences = np.abs(np.diff(rows)).ravel()
    changes = differences[differences > dust]
    if np.count_nonzero(np.isfinite(residual)) < _MIN_RESIDUALS:
        residual = _where_two_are(x)
        if len(residual) < _MIN_SAMPLES:
            return _Scale(math.nan, 0.0, side, 0, math.inf, smooth=False)
    step = max(float(changes.min()), step_of_changes(changes)) if len(changes) else 0.0
    scale = block_rms(residual)
    # A median of |residuals| is an integer number of half steps, and may hide noise of that size.
    usual = median(np.abs(present(residual))) / NORMAL_QUARTILE
    in_tail = int(np.count_nonzero(np.abs(residual) > TAIL_FROM * min(scale, usual + step / 2)))
    fourth = present(np.abs(np.diff(rows, n=4, axis=1)).ravel())
    enough = len(fourth) >= _MIN_SAMPLES
    fourth_scale = median(fourth) / NORMAL_QUARTILE / _MIDDLE if enough else math.inf
    if scale > _SPOILED * (usual + step):
        scale, side = usual + step / 2, WIDE
    return _Scale(scale, step, side, in_tail, fourth_scale, smooth=fourth_scale < _SMOOTH * scale)


def _where_two_are(x: Floats) -> Floats:
    """Residuals of samples with at least two of the four preceding samples; if most are missing, residuals of the whole
    record.
    """
    places_present = np.flatnonzero(np.isfinite(x))
    has_two = places_present[2:] - places_present[:-2] <= SIDE
    places = places_present[2:][has_two][: STRETCH * STRETCHES]
    if len(places) == 0:
        return np.zeros(0)
    return np.asarray(x[places] - medians_of_present(neighbours(x, places, -SIDE, -1)))


def _median(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """Medians of four numbers: half the sum without the extremes. NaN if one is missing."""
    low = np.minimum(np.maximum(a, b), np.maximum(c, d))
    high = np.maximum(np.minimum(a, b), np.minimum(c, d))
    return np.asarray((low + high) / 2)
