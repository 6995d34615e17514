"""Spikes: single samples far from their neighbours."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from sigmatau._native.neighbours import outliers
from sigmatau.arrays import Bools, Floats, Ints, median
from sigmatau.findings.disturbances import Spikes
from sigmatau.findings.finding import Finding
from sigmatau.findings.spans import longest_spans
from sigmatau.frozen import frozen
from sigmatau.quality.facts import channel_fact, stream_fact
from sigmatau.quality.samples.common import block_rms, present, rounding_dust
from sigmatau.quality.samples.dense_spikes import dense_spikes, hidden
from sigmatau.quality.samples.local_scatter import neighbours
from sigmatau.quality.samples.masking import Found, masked
from sigmatau.quality.samples.resolution import step_of_changes
from sigmatau.quality.samples.tails import TailReading, read_small_spikes, read_tail
from sigmatau.record.streams import Stream

_BATCH = 1 << 16  # samples per batch, for memory: 16 neighbours of each


_MIDDLE = 6.0  # heights of a single spike in the middle of its fourth difference, 6 of (1, 4, 6, 4, 1)


@frozen
class SpikeThresholds:
    """Thresholds of `find_spikes`."""

    false_spikes: float = 1e-4
    """Spikes that noise alone makes in a record, on average. [samples] Judgement: one false alarm in 10⁴ channels.
    The residual (a sample less a median of its neighbours) of Gaussian noise no smoother than a random walk is
    Gaussian in its tail, and a spike must be one on both sides."""

    least_height: float = 6.0
    """Height of a spike, at least. [standard deviations] Judgement: a smaller one in a short record would be a guess
    at its tail."""

    steps: float = 1.0
    """Height that is added for rounding. [steps] Derived: a step q moves a sample and a median by q/2 each."""

    unseen: float = 0.3
    """Noise below it leaves no trace in the scatter of numbers with this step. [steps] Study: docs/study/coarse.md;
    noise of 0.2 steps shows 0.06 to 0.5."""

    spoiled: float = 2.0
    """Scale of blocks over that of the median beyond which most blocks of 32 residuals contain a spike. [1] Derived:
    from some 2 % of spikes on."""

    tail_from: float = 4.0
    """Beginning of the tail. [standard deviations] Derived: beyond it noise has 1.6 of the residuals that the scale
    is taken from."""

    tail_count: int = 12
    """Residuals there from which on the tail is examined. [samples] Derived: so many are not noise, see `tail_from`."""

    rounds: int = 8
    """How often the rest is searched again. [1] Judgement: spikes beside each other hide each other."""

    min_residuals: int = 1024
    """Samples that have all four neighbours before them, below which samples with two of these count too. [samples]
    Judgement: their scale is known to 2 %."""

    min_samples: int = 32
    """Samples from which a scale can be taken. [samples] Judgement: one block of `block_rms`."""

    side: int = 4
    """Neighbours on either side. [samples] Derived: their median tolerates one other spike among them."""

    wide: int = 16
    """The same where two of four are often spikes. [samples] Judgement: 20 % of spikes are seldom half of 16."""

    stretch: int = 1024
    """Length of the stretches that the scale is taken from. [samples] Judgement: bounds the time of a long record."""

    stretches: int = 24
    """Their number. [1] Judgement: see `stretch`."""

    scatter_side: int = 32
    """Neighbours on either side whose scatter a spike must exceed too. [samples] Judgement: in a shock all samples
    are large."""

    smooth: float = 0.4
    """Fourth differences, over 6, in units of the residual, below which noise is smooth: medians of neighbours then
    follow slopes, but no extremes, which are not spikes. [1] Derived: 0.8 for white noise and 0.53 for a random
    walk; a spike beyond the threshold then has 15 standard deviations of it."""


THRESHOLDS = SpikeThresholds()


def find_spikes(x: Floats, *, thresholds: SpikeThresholds = THRESHOLDS) -> Bools:
    """Samples that stand out from the medians of the four samples before and of the four samples after them; shape (n,).

    Where spikes make a hump in the tail, from a thousandth of all samples on, the threshold is six standard deviations of
    the noise, see `sigmatau.quality.samples.dense_spikes`. Where most blocks of 32 samples contain spikes, the scale is
    that of the median residual and the medians are of 16 samples: up to 20 % of spikes are found. The rest is searched
    again without the spikes found.

    The threshold is six standard deviations of that residual or more, so that Gaussian noise of any of the five terms gives
    less than 0.001 spikes a record, whatever its length; plus one step of the numbers. The standard deviation is a median
    over blocks, which spikes cannot move; where the neighbours scatter more than the record as a whole, as in a shock,
    theirs counts. In noise smoother than a random walk, a spike must stand out in the fourth differences too. A step of the
    mean is not a spike. Fewer than 32 samples that can be judged have none.
    """
    x = np.asarray(x, dtype=np.float64)
    n = len(x)
    spikes_at = np.zeros(n, dtype=bool)
    if n < thresholds.min_samples:
        return spikes_at
    rest, part = x, 0.5
    multiple = _multiple(n, thresholds=thresholds)
    for k in range(thresholds.rounds):
        scale = _scale(rest, thresholds=thresholds)
        if k == 0 and scale.far >= thresholds.tail_count:
            many = dense_spikes(x, scale.step)
            if many is not None:
                spikes_at[_beyond_smooth(x, np.flatnonzero(many), scale, multiple, thresholds=thresholds)] = True
                rest = np.where(spikes_at, np.nan, x)
                scale = _scale(rest, thresholds=thresholds)
        rounding = thresholds.steps * scale.step
        threshold = multiple * max(scale.noise, thresholds.unseen * scale.step) + rounding
        if not (math.isfinite(threshold) and threshold > 0):
            break
        new = outliers(rest, threshold=threshold, multiple=multiple, least=rounding, side=scale.side, part=part)
        new = _beyond_smooth(x, new, scale, multiple, thresholds=thresholds)
        if len(new) == 0:
            break
        spikes_at[new] = True
        if rest is x:
            rest = x.copy()
        rest[new] = np.nan
        part = (
            0.25 if scale.side == thresholds.wide else 0.5
        )  # where half of the changes about a spike may be to others
    return spikes_at


@channel_fact
def spike_mask(stream: Stream, channel: str, *, thresholds: SpikeThresholds = THRESHOLDS) -> Bools:
    """The spikes of a channel, see `find_spikes`; read-only."""
    mask = find_spikes(stream.column(channel), thresholds=thresholds)
    mask.setflags(write=False)
    return mask


def more_below(rest: Floats, *, thresholds: SpikeThresholds = THRESHOLDS) -> bool:
    """Whether a record without its spikes has more outliers than noise makes: smaller spikes remain."""
    scale = _scale(rest, thresholds=thresholds)
    return not scale.smooth and hidden(rest, scale.step)


@stream_fact
def spikes(stream: Stream, *, thresholds: SpikeThresholds = THRESHOLDS) -> list[Found]:
    """Spikes of each channel: number, time and height; at most one finding a channel."""
    findings: list[Found] = []
    for k, channel in enumerate(stream.channels):
        is_spike = spike_mask(stream, channel, thresholds=thresholds)
        if is_spike.any():
            mask = np.zeros((stream.grid.n, len(stream.channels)), dtype=bool)
            mask[:, k] = is_spike
            findings.append((_finding(stream, channel, is_spike, thresholds=thresholds), mask))
    return findings


@stream_fact
def spikes_missing(stream: Stream, *, thresholds: SpikeThresholds = THRESHOLDS) -> Stream:
    """The stream with its spikes taken for missing; the very same if it has none."""
    return masked(
        stream, np.stack([spike_mask(stream, channel, thresholds=thresholds) for channel in stream.channels], axis=1)
    )


def _finding(stream: Stream, channel: str, is_spike: Bools, *, thresholds: SpikeThresholds) -> Finding:
    x, places = stream.column(channel), np.flatnonzero(is_spike)
    clean = np.where(is_spike, np.nan, x)
    heights = _heights(x, clean, places, thresholds=thresholds)
    largest = int(np.argmax(np.abs(heights)))
    times = stream.grid.lead + places * stream.grid.tau0
    spans, more_spans = longest_spans(times, times)
    heavy = more_below(clean, thresholds=thresholds)
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


def _multiple(n: int, *, thresholds: SpikeThresholds = THRESHOLDS) -> float:
    """Threshold in standard deviations: six, more for long records, and for short ones, whose scale is uncertain."""
    needed = -NormalDist().inv_cdf(thresholds.false_spikes / (2 * n))
    return max(thresholds.least_height, needed) * (
        1 + 2 / math.sqrt(min(n, thresholds.stretch * thresholds.stretches) / thresholds.scatter_side)
    )


def _heights(x: Floats, clean: Floats, places: Ints, *, thresholds: SpikeThresholds) -> Floats:
    """Distance of spikes from the median of the good samples beside them, or of all good samples where there are none."""
    heights = np.empty(len(places))
    for start in range(0, len(places), _BATCH):
        some = places[start : start + _BATCH]
        around_each = neighbours(clean, some, -thresholds.wide, thresholds.wide)
        lonely = ~np.isfinite(around_each).any(axis=1)
        if lonely.any():
            around_each[lonely] = np.nanmedian(clean)
        heights[start : start + _BATCH] = x[some] - np.nanmedian(around_each, axis=1)
    return heights


@dataclass(frozen=True, slots=True)
class _Scale:
    """What a sample is compared with."""

    noise: float  # standard deviation of the residual against one side
    step: float  # of the numbers
    side: int  # neighbours on either side
    far: int  # residuals in the tail
    fourth: float  # standard deviation of the fourth differences, over 6
    smooth: bool  # whether that is small: a low-pass filter is far below the sampling rate


def _beyond_smooth(x: Floats, places: Ints, scale: _Scale, multiple: float, *, thresholds: SpikeThresholds) -> Ints:
    """Of some samples those that stand out in the fourth differences too, if the noise is smooth; all if it is not."""
    if len(places) == 0 or not scale.smooth:
        return places
    present_at = np.flatnonzero(np.isfinite(x))
    middle = np.clip(np.searchsorted(present_at, places), 2, len(present_at) - 3)
    fourth = np.abs(np.diff(x[present_at[middle[:, None] + np.arange(-2, 3)]], n=4)[:, 0]) / _MIDDLE
    return np.asarray(
        places[fourth > multiple * max(scale.fourth, thresholds.unseen * scale.step) + thresholds.steps * scale.step]
    )


def _scale(x: Floats, *, thresholds: SpikeThresholds) -> _Scale:
    """The noise of a part of the record."""
    n = len(x)
    if n <= thresholds.stretch * thresholds.stretches:
        parts = [x]
    else:
        parts = [
            x[s : s + thresholds.stretch]
            for s in np.linspace(0, n - thresholds.stretch, thresholds.stretches).astype(int)
        ]
    rows = np.stack(parts)
    dust = rounding_dust(rows.ravel(), n)
    residual = (
        rows[:, thresholds.side :] - _median(*(rows[:, k : k - thresholds.side] for k in range(thresholds.side)))
    ).ravel()
    if np.isnan(rows).any():
        differences = np.abs(np.concatenate([np.diff(part[~np.isnan(part)]) for part in parts]))
    else:
        differences = np.abs(np.diff(rows)).ravel()
    changes = differences[differences > dust]
    if np.count_nonzero(np.isfinite(residual)) < thresholds.min_residuals:
        residual = _where_two_are(x, thresholds=thresholds)
        if len(residual) < thresholds.min_samples:
            return _Scale(math.nan, 0.0, thresholds.side, 0, math.inf, smooth=False)
    step = max(float(changes.min()), step_of_changes(changes)) if len(changes) else 0.0
    scale, side = block_rms(residual), thresholds.side
    # A median of |residuals| is a whole number of half steps, so that many may hide in it.
    usual = median(np.abs(present(residual))) / NormalDist().inv_cdf(0.75)
    in_tail = int(np.count_nonzero(np.abs(residual) > thresholds.tail_from * min(scale, usual + step / 2)))
    fourth = present(np.abs(np.diff(rows, n=4, axis=1)).ravel())
    fourth_scale = (
        median(fourth) / NormalDist().inv_cdf(0.75) / _MIDDLE if len(fourth) >= thresholds.min_samples else math.inf
    )
    if scale > thresholds.spoiled * (usual + step):
        scale, side = usual + step / 2, thresholds.wide
    return _Scale(scale, step, side, in_tail, fourth_scale, smooth=fourth_scale < thresholds.smooth * scale)


def _where_two_are(x: Floats, *, thresholds: SpikeThresholds) -> Floats:
    """Residuals of samples that have two or more of the four before them: where most are missing, of all the record."""
    present_at = np.flatnonzero(np.isfinite(x))
    before = present_at[2:] - present_at[:-2] <= thresholds.side
    places = present_at[2:][before][: thresholds.stretch * thresholds.stretches]
    before_each = neighbours(x, places, -thresholds.side, -1)
    return np.asarray(x[places] - np.nanmedian(before_each, axis=1)) if len(places) else places.astype(float)


def _median(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """Medians of four each: the sum less the extremes. NaN if one is missing."""
    low = np.minimum(np.maximum(a, b), np.maximum(c, d))
    high = np.maximum(np.minimum(a, b), np.minimum(c, d))
    return np.asarray((low + high) / 2)
