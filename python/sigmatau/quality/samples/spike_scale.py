"""Limits shared by the parts of the spike detector, neighbours of samples, and medians of rows."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np

from sigmatau.arrays import Floats, Ints

NORMAL_QUARTILE = NormalDist().inv_cdf(0.75)  # median of absolute standard normal deviates


# Expected number of false spikes in a record of noise. [samples] Judgement: one false alarm in 10⁴ channels. The
# residual (a sample less a median of its neighbours) of Gaussian noise that is no smoother than a random walk is
# Gaussian in its tail, and a spike must exceed it on both sides.
FALSE_SPIKES = 1e-4
# Smallest height of a spike. [standard deviations] Judgement: in a short record a smaller limit would depend on an
# assumed tail.
MIN_HEIGHT = 6.0
# Beginning of the tail. [standard deviations] Derived: of the residuals that determine the scale, noise has 1.6 beyond it.
TAIL_FROM = 4.0
# Number of residuals in the tail from which it is examined. [samples] Derived: noise has fewer, see `TAIL_FROM`.
TAIL_COUNT = 12
# Number of neighbours on either side. [samples] Derived: their median tolerates one other spike among them.
SIDE = 4
# Number of neighbours on either side if two of four are often spikes. [samples] Judgement: with 20 % of spikes, half of
# 16 samples are rarely spikes.
WIDE = 16
# Length of the stretches from which the scale is estimated. [samples] Judgement: limits the time of a long record.
STRETCH = 1024
# Number of the stretches. [1] Judgement: see `STRETCH`.
STRETCHES = 24
# Ratio of the number of samples in the tail to that of noise, above which spikes remain. [1] Judgement: Gaussian noise
# has a ratio of one.
TIMES = 2.0


def neighbours(x: Floats, indices: Ints, first: int, last: int) -> Floats:
    """Samples from offset `first` to `last` after each index; NaN beyond the ends."""
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
    """Evenly spread stretches of a long record, to limit the time; otherwise the whole record."""
    length, count = STRETCH, STRETCHES
    if len(x) <= length * count:
        return [x]
    return [x[start : start + length] for start in np.linspace(0, len(x) - length, count).astype(int).tolist()]
