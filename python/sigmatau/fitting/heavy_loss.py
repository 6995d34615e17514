"""Covariance of the Allan variances of white noise where a large share of the samples is missing.

If only half of all clusters are used, the set of pairs changes within a fraction of a cluster, and differs from one cluster
size to the next: neighbouring pairs, and variances at neighbouring sizes, are less correlated than in a complete record. The
Allan variance is a quadratic form ½ Σ Q(j, j′) y(j) y(j′), with Q the mean of a(j) a(j′) over the pairs and a the weights
∓1/m of a pair on its samples. For white noise of variance 1 the covariance of two variances is ½ Σ Q(j, j′) Q′(j, j′). The
sum is evaluated at a few thousand samples j and at distances that widen geometrically: it stays a sum of squares, and hence
a covariance.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["HEAVY_LOSS", "white_covariance"]

Floats = NDArray[np.float64]

HEAVY_LOSS = 0.25
"""Share of missing samples; below it, gaps change the covariance only by the number of pairs."""

_SAMPLES = 6000  # rows of the sum, about
_ALL_DISTANCES = 24  # up to here, every distance is used [samples]
_PER_OCTAVE = 12  # ranges of longer distances


def white_covariance(there: NDArray[np.bool_], m: NDArray[np.int64]) -> Floats:
    """Covariance of the Allan variances of white noise of variance 1, for the pairs of clusters at least half full.

    `m`: cluster sizes, each with a pair; Returns positive semidefinite; good to about 3 %.
    """
    n = len(there)
    edges = _edges(min(2 * int(m.max()), n))
    width = np.diff(edges)
    # An odd step samples every phase of a periodic mask.
    step = max(n // _SAMPLES, 1) | 1
    rows = np.arange(0, n, step)
    rows = rows[there[rows]]
    # Each row takes another distance from every range, so that all distances are sampled.
    within = (np.arange(len(rows))[:, None] * 0.6180339887498949 + np.arange(len(width)) * 0.41421356) % 1
    far = edges[:-1] + np.floor(within * width).astype(np.int64)
    second = rows[:, None] + far
    use = second < n
    use[use] = there[second[use]]
    weight = np.broadcast_to(np.sqrt(np.where(edges[:-1] == 0, 1.0, 2.0) * width * step), use.shape)[use]
    first, second = np.broadcast_to(rows[:, None], use.shape)[use], second[use]
    forms = np.stack([weight * _form(there, int(size), first, second) for size in m])
    return np.asarray(0.5 * np.einsum("ik,jk->ij", forms, forms, optimize=True))


def _edges(longest: int) -> NDArray[np.int64]:
    """Beginnings of ranges of distances, and the end of the last."""
    octaves = np.log2(max(longest / _ALL_DISTANCES, 1))
    wider = _ALL_DISTANCES * 2 ** (np.arange(1, int(np.ceil(octaves * _PER_OCTAVE)) + 1) / _PER_OCTAVE)
    return np.unique(np.concatenate([np.arange(_ALL_DISTANCES + 1), np.round(wider)])).astype(np.int64)


def _form(there: NDArray[np.bool_], m: int, i: NDArray[np.int64], j: NDArray[np.int64]) -> Floats:
    """Mean over the pairs of the product of their weights on samples i ≤ j, which are not missing."""
    counts = np.concatenate([[0], np.cumsum(there)])
    in_cluster = counts[m:] - counts[:-m]
    full = 2 * in_cluster >= m
    reciprocal = np.where(full, 1.0 / np.maximum(in_cluster, 1), 0.0)
    r1, r2 = reciprocal[:-m], reciprocal[m:]
    pairs = np.count_nonzero(full[:-m] & full[m:])
    last = len(r1)

    def total(values: Floats, low: NDArray[np.int64], high: NDArray[np.int64]) -> Floats:
        """Sum over the starts from low up to before high."""
        sums = np.concatenate([[0.0], np.cumsum(values)])
        high = np.clip(high, 0, last)
        return np.asarray(sums[high] - sums[np.clip(low, 0, high)])

    both = np.where(r2 > 0, r1 * r1, 0.0)
    found = total(both, j - m + 1, i + 1)
    both = np.where(r1 > 0, r2 * r2, 0.0)
    found += total(both, j - 2 * m + 1, i - m + 1)
    # Sample i in the first cluster, sample j in the second.
    found -= total(r1 * r2, np.maximum(i - m, j - 2 * m) + 1, np.minimum(i, j - m) + 1)
    return found / pairs
