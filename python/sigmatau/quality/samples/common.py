"""Functions shared by the checks of samples: reading in pieces, robust scale, Allan variance by octaves, merging of axes."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from sigmatau.arrays import Bools, Floats, Ints, median
from sigmatau.estimators.octaves import octaves
from sigmatau.findings.finding import Finding, Span
from sigmatau.findings.spans import longest_spans
from sigmatau.quality.facts import stream_fact
from sigmatau.record.streams import CHUNK, Stream

# Number of evenly spaced stretches from which samples of a channel are taken. [1] Judgement: they represent a changing
# record with few reads.
_STRETCHES = 32
# Length of the blocks whose powers `block_rms` sorts. [samples] Judgement: short enough that a bad sample spoils few of
# the blocks.
_BLOCK = 32
# Largest starting angle, over the angle covered in the record. [1] Judgement: six bits of a double; the increment of
# two angles has an error of one unit in the last place of the angle.
_STARTED = 64.0
# Share of the usual change below which changes may be rounding errors. [1] Derived: of the changes of noise, √(2/π)
# of this share are below it.
_ROUNDING_SHARE = 1e-4
# Share of such changes above which they are rounding errors. [1] Derived: a hundred times the share of noise, see
# `_ROUNDING_SHARE`.
_MAX_ROUNDING_SHARE = 0.01
# Number of samples used to recognise rounding errors. [samples] Derived: `_MAX_ROUNDING_SHARE` of them are 650 changes.
_EXAMINED = 1 << 16
# Noise above which neighbours are rarely equal by chance. [steps] Derived: a share of 1/(2√π·30), 0.9 %.
_FINE = 30.0
# Parts of a record whose steps are compared. [1] Judgement: eighths of the record show a step that doubles with the angle.
_STEP_PARTS = 8
# Shortest part whose step is determined, and ten times the number of changes needed. [samples] Judgement: the smallest
# of 25 changes shows a coarse step.
_MIN_IN_PART = 250
# Ratio of the coarsest to the finest step above which the step grows. [1] Derived: steps of floating-point numbers
# differ by factors of 2.
_STEP_GROWTH = 1.5
# Share of the samples at an end of the range above which it is not the tail of fine noise. [1] Judgement: noise with
# steps of 1 % of its deviation has far fewer at its outermost value.
_FULL = 5e-3
# Number of pairs of clusters below which an Allan variance is not a bound on white noise. [1] Derived: its relative
# error is √(3/200), 12 %.
_MIN_PAIRS = 200
# Number of standard errors, √(3/pairs) for white noise, by which a variance is raised, because the smallest of many
# variances is likely to have few pairs. [1] Judgement: a 95 % interval.
_PAIR_ERRORS = 2.0
# Smallest number of runs whose tail is judged. [1] Judgement: half of them are `_MIN_TAIL`.
_MIN_RUNS = 40
# Ratio of the number of runs to those in the tail. [1] Judgement: the last tenth of waiting times is exponential.
_TAIL_PART = 10
# Smallest number of runs in a tail. [1] Derived: the median of 20 excesses has a relative error of 1/(ln 2·√20), 32 %.
_MIN_TAIL = 20
# Standard errors that are added to a number expected by chance. [1] Judgement: no record reaches six standard errors by
# chance.
SIGMAS = 6.0
# Ratio of the number of equal or zero rows to that expected by chance, above which they are a fault. [1] Judgement:
# axes with coarse numbers may be equal or 0 at the same time without a fault.
TIMES_CHANCE = 10.0
# Largest noise in steps at which samples may stay at one value without a fault. [steps] Derived: pulses of up to 16 counts.
FEW_STEPS = 32.0


def beyond_chance(by_chance: float, *, times: float) -> float:
    """Number of samples above which chance does not explain them: a multiple of that by chance, plus 6 standard errors."""
    return times * by_chance + SIGMAS * math.sqrt(by_chance)


def pieces(stream: Stream, channel: str, *, overlap: int = 0) -> Iterator[tuple[int, Floats]]:
    """Read a channel in consecutive pieces that fit in the cache of a processor, each with its start and `overlap`
    further samples.
    """
    c, n = stream.channels.index(channel), stream.grid.n
    for start in range(0, n, CHUNK):
        yield start, stream.samples.read(c, start, min(start + CHUNK + overlap, n))


def take_samples(stream: Stream, channel: str, *, count: int) -> Floats:
    """Take about `count` samples of a channel from evenly spaced stretches, or all samples if there are fewer."""
    c, n = stream.channels.index(channel), stream.grid.n
    if n <= count:
        return stream.samples.read(c, 0, n)
    length = count // _STRETCHES
    starts = np.linspace(0, n - length, _STRETCHES).astype(int)
    return np.concatenate(stream.samples.read_stretches(c, starts.tolist(), length))


def present(x: Floats) -> Floats:
    """The samples that are not missing."""
    is_present = np.isfinite(x)
    return x if is_present.all() else x[is_present]


_SHORT_ROW = 32  # row length below which NumPy is slow, so that columns are summed


def row_means(rows: Floats, *, share: float = 0.5) -> Floats:
    """Mean of each row; NaN if less than `share` of its values are present."""
    # Columns are summed, because NumPy is slow for short rows.
    means = functools.reduce(np.add, rows.T) / rows.shape[1] if rows.shape[1] < _SHORT_ROW else rows.mean(axis=1)
    torn = np.flatnonzero(np.isnan(means))
    if len(torn):
        is_present = ~np.isnan(rows[torn])
        number = is_present.sum(axis=1)
        sums = np.where(is_present, rows[torn], 0.0).sum(axis=1)
        means[torn] = np.where(number >= share * rows.shape[1], sums / np.maximum(number, 1), np.nan)
    return np.asarray(means)


def block_means(stream: Stream, channel: str, length: int) -> Floats:
    """Means of a channel over blocks of samples, NaN if half of a block is missing; shape (n_blocks,)."""
    c, n = stream.channels.index(channel), stream.grid.n // length * length
    many = max(CHUNK // length, 1) * length
    parts = [row_means(stream.samples.read(c, a, min(a + many, n)).reshape(-1, length)) for a in range(0, n, many)]
    return np.concatenate([np.zeros(0), *parts])


def means_by_octave(means: Floats, octaves: int) -> list[Floats]:
    """Compute means by octave of averaging time, each from pairs of the previous means."""
    by_octave = [means]
    while len(by_octave) < octaves:
        means = row_means(means[: len(means) // 2 * 2].reshape(-1, 2))
        by_octave.append(means)
    return by_octave


def block_rms(x: Floats) -> float:
    """Root mean square of the middle half of blocks of 32; unlike a median it is not quantized if x is. 0 without
    samples.
    """
    block = _BLOCK
    if len(x) < 2 * block:
        x = present(x)
        return float(np.sqrt(np.mean(x * x))) if len(x) else 0.0
    blocks = x[: len(x) // block * block].reshape(-1, block)
    power = present(np.einsum("ij,ij->i", blocks, blocks)) / block
    if len(power) == 0:
        return block_rms(present(x))
    power.sort()
    quarter = len(power) // 4
    return float(np.sqrt(np.mean(power[quarter : len(power) - quarter])))


def largest_rounding(x: Floats, n: int) -> float:
    """Largest change of n increments x by rounding of the original angles: ε·64·n·rms(x).

    In n samples an angle changes by at most n times their root mean square, and it is rounded to ε of that.
    """
    return _STARTED * float(np.finfo(float).eps) * n * block_rms(x)


@stream_fact
def without_rounding_errors(stream: Stream) -> Stream:
    """Make values equal that differ only by rounding, such as differences of printed angles."""
    columns, changed = [], False
    if stream.samples.transforms[0].kind != "increments":  # counts minus a slow bias differ by more than rounding
        return stream
    for channel in stream.channels:
        x = stream.column(channel)
        sample = take_samples(stream, channel, count=_EXAMINED)
        some = np.abs(np.diff(sample))
        some = some[some > 0]
        scale = block_rms(
            some[some > largest_rounding(sample, stream.grid.n)]
        )  # most changes of coarse counts may be rounding errors
        if scale > 0 and np.count_nonzero(some < _ROUNDING_SHARE * scale) > _MAX_ROUNDING_SHARE * len(some):
            x, changed = _joined(x, _ROUNDING_SHARE * scale), True
        columns.append(x)
    return stream.with_rates(columns) if changed else stream


def _joined(x: Floats, apart: float) -> Floats:
    """Merge values that differ by at most `apart` into one value."""
    values, which = np.unique(x, return_inverse=True)  # NaN is last, and differs from all other values
    group = np.concatenate(([0], np.cumsum(~(np.diff(values) <= apart))))
    first = np.flatnonzero(np.diff(group, prepend=-1))
    return np.asarray(values[first][group][which], dtype=np.float64)


def growing_step(x: Floats) -> float:
    """Coarsest step in any part of a record, if it is large compared with the noise and differs between parts; otherwise 0.

    The step of a single-precision angle or velocity doubles with its size; the common step of all values is the first one.
    """
    if len(x) < _STEP_PARTS * _MIN_IN_PART:
        return 0.0
    steps, coarse = [], 0.0
    for part in np.array_split(x, _STEP_PARTS):
        changes = np.abs(np.diff(part))
        changes = changes[changes > 0]
        if len(changes) < _MIN_IN_PART // 10:
            continue
        nearest = float(changes.min())
        steps.append(nearest)
        if block_rms(changes) < _FINE * nearest:
            coarse = max(coarse, nearest)
    return coarse if steps and coarse > _STEP_GROWTH * min(steps) else 0.0


def full_ends(x: Floats) -> list[float]:
    """Largest and smallest value, each if more samples have it than the next inner value, which does not occur in a tail."""
    low, high = float(np.fmin.reduce(x)), float(np.fmax.reduce(x))
    ends = []
    for end, sign in ((low, 1.0), (high, -1.0)):
        count = int(np.count_nonzero(x == end))
        if not low < high or count < max(_FULL * len(x), 2):
            continue
        inside = x[sign * x > sign * end]
        next_value = inside.min() if sign > 0 else inside.max()
        if count > np.count_nonzero(x == next_value):
            ends.append(end)
    return ends


def white_level(x: Floats, tau0: float) -> tuple[float, int]:
    """Smallest τ·σ²(τ) and its number of samples: N² if the record shows white noise, otherwise an upper bound of N².

    Every other term only adds to τ·σ²: 3Q²/τ, (2 ln 2/π)B²τ, K²τ²/3, R²τ³/2 (eqs. (15) to (25) of the paper).
    """
    levels = [
        (tau0 * m * avar * (1 + _PAIR_ERRORS * math.sqrt(3 / pairs)), tau0 * m * avar, m)
        for m, avar, pairs in octaves(x)
        if pairs >= _MIN_PAIRS or m == 1
    ]
    _, level, m = min(levels, default=(math.nan, math.nan, 1))
    return level, m


def longest_of_tail(lengths: Ints, *, false_alarm: float) -> float:
    """Length that the longest of these runs exceeds with probability `false_alarm`, estimated from the other runs; 0 if
    there are too few.

    The tail of waiting times is exponential. The m runs beyond a length u exceed it by a median of e·ln 2, and the longest
    exceeds u + e·ln(m/p) with probability p. A median is used so that faulty runs do not raise the limit.
    """
    if len(lengths) < _MIN_RUNS:
        return 0.0
    m = max(len(lengths) // _TAIL_PART, _MIN_TAIL)
    tail = np.sort(lengths)[-m - 1 :].astype(float)
    scale = max(median(tail[1:] - tail[0]), 1.0) / math.log(2)
    return float(tail[0]) + scale * math.log(m / false_alarm)


def mask_of_runs(n: int, first: Ints, lengths: Ints) -> Bools:
    """Mask of n samples that is True in runs that do not overlap, given by first samples and lengths; shape (n,)."""
    mask = np.zeros(n, dtype=bool)
    before = np.cumsum(lengths) - lengths
    mask[np.repeat(first - before, lengths) + np.arange(int(lengths.sum()))] = True
    return mask


def spans_of_runs(stream: Stream, first: Ints, lengths: Ints) -> tuple[tuple[Span, ...], int]:
    """Convert runs of samples to `longest_spans`, from the beginning of the whole record. [s]"""
    grid = stream.grid
    return longest_spans(grid.lead + first * grid.tau0, grid.lead + (first + lengths) * grid.tau0)


def merged_axes(findings: Sequence[tuple[float, Finding]]) -> list[Finding]:
    """Merge the findings of several axes, each with the size of its effect, into one.

    The result has the channels and spans of all axes, and is a warning if one of them is. Details, size and factors are
    those of the axis with the largest effect, the field `strongest` of the details.
    """
    if len(findings) < 2:
        return [finding for _, finding in findings]
    _, strongest = max(findings, key=lambda axis: axis[0])
    return [
        replace(
            strongest,
            severity="warning" if any(axis.severity == "warning" for _, axis in findings) else "info",
            channels=tuple(channel for _, axis in findings for channel in axis.channels),
            spans=united(span for _, axis in findings for span in axis.spans),
            more_spans=sum(axis.more_spans for _, axis in findings),
        )
    ]


def united(spans: Iterable[Span], *, gap: float = 0.0) -> tuple[Span, ...]:
    """Sort spans by time, and join those that overlap or are separated by at most a gap [s]."""
    joined: list[Span] = []
    for start, stop in sorted(spans):
        if joined and start <= joined[-1][1] + gap:
            joined[-1] = joined[-1][0], max(stop, joined[-1][1])
        else:
            joined.append((start, stop))
    return tuple(joined)
