"""Limits that the parts of the spike detector share, neighbours of samples, and medians of rows."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np

from sigmatau.arrays import Floats, Ints

NORMAL_QUARTILE = NormalDist().inv_cdf(0.75)  # median of absolute standard normal deviates


# Expected number of spikes that noise alone makes in a record. [samples] Judgement: one false alarm in 10⁴ channels.
# The residual (a sample less a median of its neighbours) of Gaussian noise that is no smoother than a random walk is
# Gaussian in its tail, and a spike must exceed it on both sides.
FALSE_SPIKES = 1e-4
# Smallest height of a spike. [standard deviations] Judgement: a smaller one in a short record would depend on a guess
# at the tail.
LEAST_HEIGHT = 6.0
# Beginning of the tail. [standard deviations] Derived: noise has 1.6 of the residuals that determine the scale beyond
# it.
TAIL_FROM = 4.0
# Number of residuals in the tail from which on it is examined. [samples] Derived: noise does not have this many, see
# `TAIL_FROM`.
TAIL_COUNT = 12
# Number of neighbours on either side. [samples] Derived: their median tolerates one other spike among them.
SIDE = 4
# The same if two of four are often spikes. [samples] Judgement: 20 % of spikes are seldom half of 16.
WIDE = 16
# Length of the stretches from which the scale is estimated. [samples] Judgement: limits the time of a long record.
STRETCH = 1024
# Number of the stretches. [1] Judgement: see `STRETCH`.
STRETCHES = 24
# Number of samples in the tail over that of noise, from which on spikes remain. [1] Judgement: Gaussian noise has a
# ratio of one.
TIMES = 2.0


def neighbours(x: Floats, indices: Ints, first: int, last: int) -> Floats:
    """The samples from offset `first` to `last` after each index; NaN beyond the ends."""
    places = indices[:, None] + np.arange(first, last + 1)
    inside = (places >= 0) & (places < len(x))
    return np.where(inside, x[np.clip(places, 0, len(x) - 1)], np.nan)


def medians(rows: Floats) -> Floats:
    """Median of each row without NaN; NaN for an empty row."""
    ordered = np.sort(rows, axis=1)  # NaN last
    count = np.isfinite(ordered).sum(axis=1)
    row = np.arange(len(rows))
    both = ordered[row, np.maximum(count - 1, 0) // 2] + ordered[row, np.minimum(count // 2, rows.shape[1] - 1)]
    return np.asarray(np.where(count > 0, both / 2, np.nan))


def stretches(x: Floats) -> list[Floats]:
    """Evenly spread stretches of a long record, which bound the time; else the record."""
    length, count = STRETCH, STRETCHES
    if len(x) <= length * count:
        return [x]
    return [x[start : start + length] for start in np.linspace(0, len(x) - length, count).astype(int).tolist()]
