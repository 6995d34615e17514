"""Random walk with the spikes that belong to a continuous tail, and without small spikes that remain in the noise."""

from __future__ import annotations

import math
from statistics import NormalDist

import numpy as np

from sigmatau.arrays import Floats, median
from sigmatau.frozen import frozen
from sigmatau.quality.samples.common import beyond_chance, present
from sigmatau.quality.samples.spike_scale import FALSE_SPIKES, TIMES

# Exponent α of the heaviest tail that ends without a gap. [1] Derived: Student's t with 3 degrees of freedom. The ratio
# of the k-th largest sample to the next smaller one exceeds r with probability r^-kα.
_TAIL_EXPONENT = 3.0
# Height of small, isolated spikes. [standard deviations] Derived: noise is beyond it once in 150 000 samples.
_SMALL = 4.5
# Largest ratio of the variance of the other samples of the block and of its neighbours to the usual variance. [1]
# Derived: χ² with 31 degrees of freedom reaches 2 times its mean once in 1000 blocks.
_QUIET = 2.0
# Length of the stretches whose mean is subtracted. [samples] Judgement: slower noise is not part of the white level.
_MEAN_BLOCK = 32
# Smallest number of samples in a block. [samples] Derived: one sample has no variance.
_MIN_PRESENT = 2


@frozen
class TailReading:
    """Random walk with all samples of a tail.

    Attributes
    ----------
    factor : float
        Random walk with the spikes that belong to the tail, over that without them; 1 if no spike does. [1]
    error : float
        Relative standard error of the random walk with these spikes, from the kurtosis of all samples of the tail and the
        variance of a tail beyond the samples of the record. [1]
    """

    factor: float
    error: float


def read_tail(clean: Floats, heights: Floats) -> TailReading:
    """Compute the random walk with the spikes of a continuous tail, those below all gaps in the sizes of spikes.

    White noise has N² = σ²τ₀, so the factor is the root of the ratio of the variances. The relative variance of N² from n
    samples with the excess kurtosis κ is (2 + κ)/n; the interval of the fit includes the first term. The kurtosis of a
    record does not show the tail beyond the size x that one of its samples exceeds on average: the variance of that part is
    α/(α − 2) x²/n for the exponent α.

    Parameters
    ----------
    clean : ndarray, shape (n,)
        Samples without the spikes, which are NaN. [any unit]
    heights : ndarray, shape (k,)
        Spikes minus the median of their neighbours. [unit of `clean`]
    """
    squares = present(_squares(clean).ravel())
    if len(squares) == 0:
        return TailReading(factor=1.0, error=0.0)
    tail = _without_gap(np.sort(np.abs(heights)), math.sqrt(float(squares.max()))) ** 2
    count = len(squares) + len(tail)
    usual = float(squares.mean())
    variance = (float(squares.sum()) + float(tail.sum())) / count
    if len(tail) == 0 or not usual > 0:
        return TailReading(factor=1.0, error=0.0)
    fourth = (float((squares * squares).sum()) + float((tail * tail).sum())) / count
    kurtosis = max(fourth / variance**2 - 3, 0.0)
    # Half of the tail is above its median m, so that one sample of the record is expected beyond m (k/2)^(1/α).
    highest = median(tail) * (len(tail) / 2) ** (2 / _TAIL_EXPONENT)
    beyond = _TAIL_EXPONENT / (_TAIL_EXPONENT - 2) * highest / (variance * count)
    return TailReading(
        factor=max(math.sqrt(variance / usual), 1.0), error=math.hypot(math.sqrt(kurtosis / count), beyond) / 2
    )


def _without_gap(sizes: Floats, largest: float) -> Floats:
    """Ascending sizes below every gap, counted from the largest sample down. `largest`: the largest of the other samples."""
    while len(sizes) and largest > 0:
        ratio = sizes / np.maximum(np.concatenate(([0.0], sizes[:-1])), largest)
        above = np.arange(len(sizes), 0, -1)
        gaps = np.flatnonzero(ratio > (len(sizes) / FALSE_SPIKES) ** (1 / (_TAIL_EXPONENT * above)))
        if len(gaps) == 0:
            return sizes
        sizes = sizes[: gaps[-1]]
    return sizes[:0]


def read_small_spikes(clean: Floats) -> float:
    """Random walk of all samples over that without small spikes; 1 if there are no more isolated outliers than in noise.

    Parameters
    ----------
    clean : ndarray, shape (n,)
        Samples without the spikes, which are NaN. [any unit]
    """
    squares = _squares(clean)
    counts, sums, largest = np.full(len(squares), _MEAN_BLOCK), squares.sum(axis=1), squares.max(axis=1, initial=0.0)
    torn = np.isnan(sums)
    counts[torn] = np.isfinite(squares[torn]).sum(axis=1)
    sums[torn], largest[torn] = np.nansum(squares[torn], axis=1), np.nanmax(squares[torn], axis=1, initial=0.0)
    count, total = int(counts.sum()), float(sums.sum())
    if not total > 0:
        return 1.0
    usual = total / count
    loud = sums - largest > _QUIET * usual * (counts - 1)
    wide = np.concatenate((loud[:1], loud, loud[-1:]))
    small = largest[(largest > _SMALL**2 * usual) & ~(wide[:-2] | loud | wide[2:])]
    by_chance = 2 * count * NormalDist().cdf(-_SMALL)
    if len(small) <= beyond_chance(by_chance, times=TIMES):
        return 1.0
    return math.sqrt(usual / ((total - float(small.sum())) / (count - len(small))))


def _squares(x: Floats) -> Floats:
    """Squares of the samples minus the mean of their block, scaled to the variance of the samples; one row per block."""
    blocks = x[: len(x) // _MEAN_BLOCK * _MEAN_BLOCK].reshape(-1, _MEAN_BLOCK)
    means, factors = blocks.mean(axis=1), np.full(len(blocks), _MEAN_BLOCK / (_MEAN_BLOCK - 1))
    torn = np.isnan(means)
    count = np.isfinite(blocks[torn]).sum(axis=1)
    means[torn] = np.nansum(blocks[torn], axis=1) / np.maximum(count, 1)
    factors[torn] = count / np.maximum(count - 1, 1)
    squares = (blocks - means[:, None]) ** 2 * factors[:, None]
    if (count >= _MIN_PRESENT).all():
        return np.asarray(squares)
    torn[torn] = count < _MIN_PRESENT
    return np.asarray(squares[~torn])
