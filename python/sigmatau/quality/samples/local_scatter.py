"""Medians and scatter of the neighbours of samples."""

from __future__ import annotations

import math
from statistics import NormalDist

import numpy as np

from sigmatau.arrays import Floats, Ints

__all__ = ["AROUND", "medians", "neighbours", "residuals", "scatter"]

AROUND = 32  # neighbours on either side whose scatter a spike must exceed too: in a shock all samples are large
_LEAST = 4  # changes that a scatter is taken from


def neighbours(x: Floats, at: Ints, first: int, last: int) -> Floats:
    """The samples from `first` to `last` after each index; NaN beyond the ends."""
    places = at[:, None] + np.arange(first, last + 1)
    inside = (places >= 0) & (places < len(x))
    return np.where(inside, x[np.clip(places, 0, len(x) - 1)], np.nan)


def medians(rows: Floats) -> Floats:
    """Median of each row without NaN; NaN for an empty row."""
    ordered = np.sort(rows, axis=1)  # NaN last
    count = np.isfinite(ordered).sum(axis=1)
    row = np.arange(len(rows))
    both = ordered[row, np.maximum(count - 1, 0) // 2] + ordered[row, np.minimum(count // 2, rows.shape[1] - 1)]
    return np.asarray(np.where(count > 0, both / 2, np.nan))


def residuals(x: Floats, at: Ints, side: int) -> Floats:
    """Distance of samples from the medians of either side: the smaller of the two, 0 if they are between them.

    A side with fewer than two samples is ignored; NaN if both are.
    """
    sides = []
    for first, last in ((-side, -1), (1, side)):
        near = neighbours(x, at, first, last)
        count = np.isfinite(near).sum(axis=1)
        median = np.full(len(at), np.nan)
        enough, two = count > 2, count == 2
        if enough.any():
            median[enough] = medians(near[enough])
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


def scatter(x: Floats, at: Ints, part: float) -> Floats:
    """Standard deviation of the samples before or after a spike, from a quantile `part` of their changes; 0 if unknown.

    The larger of both, because a shock has a first sample; a quarter in place of the median where half may be spikes.
    """
    scatter = np.zeros(len(at))
    for first, last in ((-AROUND, -2), (2, AROUND)):
        changes = np.abs(np.diff(neighbours(x, at, first, last), axis=1))
        known = np.isfinite(changes).sum(axis=1) >= _LEAST
        if known.any():
            ordered = np.sort(changes[known], axis=1)  # NaN last
            middle = part * (np.isfinite(ordered).sum(axis=1) - 1)
            row, below = np.arange(len(ordered)), np.floor(middle).astype(int)
            low, high = ordered[row, below], ordered[row, np.ceil(middle).astype(int)]
            usual = low + (middle - below) * (high - low)
            deviation = usual / (math.sqrt(2) * NormalDist().inv_cdf((1 + part) / 2))
            scatter[known] = np.maximum(scatter[known], deviation)
    return scatter
