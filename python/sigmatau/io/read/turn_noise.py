"""Slow noise of the rows of two turns: rows of one sensor have it in common, rows of two sensors have each their own.

Of two series with one spectrum and independent noise, the sum and the difference have the same expected power at every
frequency, whatever the spectrum. Each share power of the sum / (power of the sum + power of the difference) is then uniform
between 0 and 1, with a mean of 1/2. The wander of the bias of one sensor, its filter and its motion are in both series, so
the power is in the sum and the share is 1. White noise alone tells nothing: it is independent from row to row in any case.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

_MOST_BLOCKS = 4096  # means of rows whose spectra are compared
_FEWEST_BLOCKS = 64
_FIRST_EDGE = 3  # upper edge of the first band: bands are octaves above it
_TAPER = 0.25  # share of a series at either end that the window tapers
_CORRELATED = 1.4  # variance of a mean share over that of independent ones: the window makes neighbours alike
_ERRORS = 4.5  # deviation of the mean share from 1/2 that is significant, in standard errors: 11 bands are looked at
_SHARED = 0.65  # mean share of noise in common: 0.5 for independent noise
_RISE = 3.0  # power of a band over that of the highest ones, of sum and difference: above the white noise
_FEWEST_SHARES = 48  # in bands of slow noise, to tell that it is independent: standard error 0.05
_INDEPENDENT = 0.12  # largest deviation of their mean from 1/2; 0.28 for slow noise in common of this rise

SlowNoise = Literal["in common", "independent", "not measured"]


def compare_slow_noise(first: NDArray[np.float64], second: NDArray[np.float64]) -> SlowNoise:
    """Whether the slow noise of two series of rows is in common. `first`, `second`: shape (n, channels), without NaN."""
    n = len(first)
    size = max(1, n // _MOST_BLOCKS)
    blocks = n // size
    if blocks < _FEWEST_BLOCKS:
        return "not measured"
    first, second = (_over_white_noise(_block_means(x, blocks, size)) for x in (first, second))
    noisy = np.isfinite(first).all(axis=0) & np.isfinite(second).all(axis=0)
    if not noisy.any():
        return "not measured"
    power_of_sum, power_of_difference = (_power(x[:, noisy]) for x in (first + second, first - second))
    total = power_of_sum + power_of_difference
    shares = power_of_sum / np.maximum(total, np.finfo(np.float64).tiny)
    high = np.median(total[len(total) // 2 :], axis=0)
    slow = []
    for low, top in _bands(len(shares)):
        up_to_band = shares[1:top]
        error = (_CORRELATED / (12 * up_to_band.size)) ** 0.5
        if up_to_band.mean() - 0.5 > max(_ERRORS * error, _SHARED - 0.5):
            return "in common"
        powers = np.minimum(power_of_sum[low:top].mean(axis=0), power_of_difference[low:top].mean(axis=0))
        # A line at half the rate is in one of them only.
        slow.append(shares[low:top, powers > _RISE / 2 * high].ravel())
    slow_shares = np.concatenate(slow)
    if len(slow_shares) >= _FEWEST_SHARES and abs(slow_shares.mean() - 0.5) < _INDEPENDENT:
        return "independent"
    return "not measured"


def _block_means(x: NDArray[np.float64], blocks: int, size: int) -> NDArray[np.float64]:
    return np.asarray(x[: blocks * size].reshape(blocks, size, -1).mean(axis=1))


def _over_white_noise(means: NDArray[np.float64]) -> NDArray[np.float64]:
    """Series without their means, over the scatter of differences of neighbours; NaN if it is 0."""
    scatter = np.diff(means, axis=0).std(axis=0)
    return np.asarray((means - means.mean(axis=0)) / np.where(scatter > 0, scatter, np.nan))


def _power(series: NDArray[np.float64]) -> NDArray[np.float64]:
    """Power at the Fourier frequencies, with a tapered window: shape (frequencies, channels)."""
    ends = (np.arange(len(series)) + 0.5) / (_TAPER * len(series))
    window = 0.5 - 0.5 * np.cos(np.pi * np.minimum(np.minimum(ends, ends[::-1]), 1))
    return np.asarray(np.abs(np.fft.rfft(window[:, None] * series, axis=0)) ** 2)


def _bands(frequencies: int) -> list[tuple[int, int]]:
    """Octaves of Fourier frequencies: first and end of each."""
    edges = [1, _FIRST_EDGE]
    while edges[-1] < frequencies:
        edges.append(min(2 * edges[-1], frequencies))
    return list(pairwise(edges))
