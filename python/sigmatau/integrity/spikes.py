"""Spikes: single samples far from their neighbours."""

from __future__ import annotations

import math
from dataclasses import replace
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from sigmatau.integrity.masking import masked
from sigmatau.integrity.samples import affected, block_rms, place, when, white_level
from sigmatau.record import Record
from sigmatau.results import Finding
from sigmatau.streams import CHUNK, Stream

__all__ = ["find_spikes", "mask_spikes", "spikes"]

# Neighbours on either side; their median bears one other spike among them.
_SIDE = 4

# Samples that the scale is taken from, in stretches of 1024.
_STRETCH, _STRETCHES = 1024, 24

# Neighbours on either side whose own scatter a spike must exceed too: in a knock all samples are large, and none is a spike.
_AROUND = 32

# Spikes that noise alone makes in a record, on average: the residual of Gaussian noise of any spectrum is Gaussian in its
# tail (a sample less a median of its neighbours), and a spike must be one on both sides.
_FALSE = 1e-4

# A step q of the numbers moves a sample and a median by q/2 each; noise below 0.3 q leaves no trace in their scatter.
_STEPS, _UNSEEN = 1.0, 0.3

# Fewer samples with all four before them have no scale to speak of: then those with two of them make it.
_FEW = 1024

# Fewer samples have no scale of their own to speak of.
_LEAST = 32

# From here on a coefficient changes noticeably.
_MATTERS = 1.02


def find_spikes(x: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Samples that stand out from the medians of the four before them and of the four after them.

    The threshold is six standard deviations of that residual or more, so that Gaussian noise of any of the five terms gives
    less than 0.001 spikes a record, whatever its length; plus one step of the numbers. The standard deviation is a
    median over blocks, which spikes cannot move; where the neighbours scatter more than the record as a whole, as in a
    knock, theirs counts. A change of level is no spike.

    Parameters
    ----------
    x : ndarray, shape (n,)
        NaN where samples are missing.

    Returns
    -------
    ndarray of bool, shape (n,)
        All False for fewer than 32 samples, or fewer than 32 that have two of the four before them: at random, with more
        than about 95 % of 10⁵ missing.
    """
    x = np.asarray(x, dtype=np.float64)
    n = len(x)
    found = np.zeros(n, dtype=bool)
    if n < _LEAST:
        return found
    scale, step = _scale(x)
    threshold = _multiple(n) * max(scale, _UNSEEN * step) + _STEPS * step
    if not (math.isfinite(threshold) and threshold > 0):
        return found
    candidates = _candidates(x, threshold)
    if len(candidates) == 0:
        return found
    residual = _residuals(x, candidates)
    kept = np.abs(residual) > threshold
    candidates, residual = candidates[kept], residual[kept]
    if len(candidates) == 0:
        return found
    around = _scatter(x, candidates)
    kept = np.abs(residual) > _multiple(n) * around + _STEPS * step
    found[candidates[kept]] = True
    return found


def spikes(stream: Stream) -> list[Finding]:
    """Spikes of each channel: how many, where, how large, and what they add to the random walk.

    n_s spikes of height a in n samples add white noise of N_add² = n_s·a²·τ₀/n; spikes beside each other add up first.

    Parameters
    ----------
    stream : Stream

    Returns
    -------
    list of Finding
        At most one a channel.
    """
    findings = []
    for channel in stream.channels:
        x = stream.column(channel)
        found = find_spikes(x)
        if found.any():
            findings.append(_finding(stream, channel, x, found))
    return findings


def mask_spikes(record: Record) -> tuple[Record, list[Finding]]:
    """The record with its spikes taken for missing samples, and the findings that say so.

    Parameters
    ----------
    record : Record

    Returns
    -------
    record : Record
        NaN in place of each spike; the very same record if there is none.
    findings : list of Finding
        One a channel that had spikes, of severity info.
    """
    streams, findings = [], []
    for stream in record.streams:
        masks = [find_spikes(stream.column(channel)) for channel in stream.channels]
        for channel, mask in zip(stream.channels, masks, strict=True):
            count = int(mask.sum())
            if count:
                findings.append(
                    Finding(
                        code="spikes_masked",
                        severity="info",
                        channel=channel,
                        message=f"{_count(count)} taken for missing, of {len(mask)} samples",
                        where=place(int(np.argmax(mask)), stream),
                        size=float(count),
                    )
                )
        streams.append(masked(stream, masks) if any(mask.any() for mask in masks) else stream)
    if not findings:
        return record, []
    return replace(record, streams=tuple(streams)), findings


def _finding(stream: Stream, channel: str, x: NDArray[np.float64], found: NDArray[np.bool_]) -> Finding:
    tau0 = stream.grid.tau0
    at = np.flatnonzero(found)
    heights = _residuals(x, at)
    largest = int(np.argmax(np.abs(heights)))
    # Neighbouring spikes are one to a cluster that holds them both.
    groups = np.cumsum(np.concatenate(([0], np.diff(at) > 1)))
    areas = np.bincount(groups, weights=heights)
    there = int(np.count_nonzero(np.isfinite(x)))
    added = float(areas @ areas) * tau0 / there
    clean = x.copy()
    clean[found] = np.nan
    level, _ = white_level(clean, tau0)
    factor = math.sqrt(1 + added / level) if level > 0 else math.inf
    first = int(at[0])
    count = len(at)
    span = f"the first at {when(first, stream)}, " if count > 1 else ""
    return Finding(
        code="spikes",
        severity="warning" if factor > _MATTERS else "info",
        channel=channel,
        message=(
            f"{_count(count)} in {len(x)} samples: {span}the largest, {heights[largest]:+.3g} {stream.unit}, at"
            f" {when(int(at[largest]), stream)}"
        ),
        where=place(first, stream),
        size=float(np.abs(heights[largest])),
        unit=stream.unit,
        effect=(
            f"{'they add' if count > 1 else 'it adds'} white noise of {math.sqrt(added):.3g} {stream.unit}·√s"
            + (f": {affected(factor)}" if math.isfinite(factor) else "")
        ),
        changes=(("random_walk", factor),) if math.isfinite(factor) else (),
        remedy="mask the spikes, --spikes mask; find out whether sensor or log makes them",
    )


def _count(count: int) -> str:
    return f"{count} spike{'s' if count > 1 else ''}"


def _multiple(n: int) -> float:
    """How many standard deviations: six, as many as a long record needs, more where a short one knows its own badly."""
    needed = -NormalDist().inv_cdf(_FALSE / (2 * n))
    return max(6.0, needed) * (1 + 2 / math.sqrt(min(n, _STRETCH * _STRETCHES) / _AROUND))


def _scale(x: NDArray[np.float64]) -> tuple[float, float]:
    """Standard deviation of the residual against one side, and the step of the numbers if they have one worth a thought."""
    n = len(x)
    if n <= _STRETCH * _STRETCHES:
        parts = [x]
    else:
        parts = [x[s : s + _STRETCH] for s in np.linspace(0, n - _STRETCH, _STRETCHES).astype(int)]
    residuals, steps = [], []
    for part in parts:
        windows = np.lib.stride_tricks.sliding_window_view(part, _SIDE + 1)
        residuals.append(windows[:, -1] - _median(windows[:, :-1]))
        differences = np.abs(np.diff(part[~np.isnan(part)]))
        steps.append(differences[differences > 0])
    residual = np.concatenate(residuals)
    if np.count_nonzero(np.isfinite(residual)) < _FEW:
        residual = _where_two_are(x)
        if len(residual) < _LEAST:
            return math.nan, 0.0
    changes = np.concatenate(steps)
    return block_rms(residual), float(changes.min()) if len(changes) else 0.0


def _where_two_are(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Residuals of samples that have two or more of the four before them: where most are missing, of all the record."""
    there = np.flatnonzero(np.isfinite(x))
    before = there[2:] - there[:-2] <= _SIDE
    at = there[2:][before][: _STRETCH * _STRETCHES]
    near = _neighbours(x, at, -_SIDE, -1)
    return np.asarray(x[at] - np.nanmedian(near, axis=1)) if len(at) else at.astype(float)


def _median(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Medians of rows of four: the sum less the extremes. NaN if one is missing."""
    a, b, c, d = x.T
    low = np.minimum(np.maximum(a, b), np.maximum(c, d))
    high = np.maximum(np.minimum(a, b), np.minimum(c, d))
    return np.asarray((low + high) / 2)


def _candidates(x: NDArray[np.float64], threshold: float) -> NDArray[np.int64]:
    """Samples within two of a change that a spike cannot do without: half of the threshold. Of three in a row, all.

    Missing samples are passed over: a spike beside a gap differs from the next sample that is there.
    """
    there = np.flatnonzero(~np.isnan(x))
    whole = len(there) == len(x)
    found = []
    for start in range(0, len(there), CHUNK):
        part = slice(start, start + CHUNK + 1)
        steps = np.abs(np.diff(x[part] if whole else x[there[part]]))
        found.append(start + np.flatnonzero(steps > threshold / 2))
    edges = np.concatenate([*found, np.empty(0, dtype=np.int64)])
    edges = np.unique(edges[:, None] + np.arange(-1, 3))
    return np.asarray(there[edges[(edges >= 0) & (edges < len(there))]])


def _neighbours(x: NDArray[np.float64], at: NDArray[np.int64], first: int, last: int) -> NDArray[np.float64]:
    """The samples `first` to `last` places after each of some; NaN beyond the ends."""
    places = at[:, None] + np.arange(first, last + 1)
    inside = (places >= 0) & (places < len(x))
    return np.where(inside, x[np.clip(places, 0, len(x) - 1)], np.nan)


def _residuals(x: NDArray[np.float64], at: NDArray[np.int64]) -> NDArray[np.float64]:
    """How far samples are from the medians of either side: the lesser of the two, 0 if they are between them.

    A side with fewer than two samples says nothing; NaN if neither says anything.
    """
    sides = []
    for first, last in ((-_SIDE, -1), (1, _SIDE)):
        near = _neighbours(x, at, first, last)
        count = np.isfinite(near).sum(axis=1)
        median = np.full(len(at), np.nan)
        enough, two = count > 2, count == 2
        if enough.any():
            median[enough] = np.nanmedian(near[enough], axis=1)
        if two.any():
            # Of two the nearer: the other may be a spike, which would move the mean of both.
            distance = np.abs(near[two] - x[at[two], None])
            nearer = np.nanargmin(distance, axis=1)
            median[two] = near[two][np.arange(len(nearer)), nearer]
        sides.append(x[at] - median)
    before, after = sides
    lesser = np.where(np.abs(before) < np.abs(after), before, after)
    both = np.where(before * after > 0, lesser, 0.0)
    one = np.where(np.isfinite(before), before, after)
    return np.where(np.isfinite(before) & np.isfinite(after), both, one)


def _scatter(x: NDArray[np.float64], at: NDArray[np.int64]) -> NDArray[np.float64]:
    """Standard deviation of the samples before or after a spike, whichever is larger, by the median of their changes.

    Whichever is larger, because a knock has a first sample. 0 if unknown.
    """
    scatter = np.zeros(len(at))
    for first, last in ((-_AROUND, -2), (2, _AROUND)):
        changes = np.abs(np.diff(_neighbours(x, at, first, last), axis=1))
        known = np.isfinite(changes).sum(axis=1) >= _SIDE
        if known.any():
            deviation = np.nanmedian(changes[known], axis=1) / (math.sqrt(2) * NormalDist().inv_cdf(0.75))
            scatter[known] = np.maximum(scatter[known], deviation)
    return scatter
