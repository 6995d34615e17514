"""Running means before a sampler, as interpolation makes them: what is left of white noise, τ by τ.

A running mean over a time L has a triangle as the autocovariance of the white noise behind it; two such means in a row
(Bartlett's window) have its convolution with itself, the cubic B-spline.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from sigmatau.arrays import Floats, Ints

__all__ = ["Shape", "autocovariance", "relative_avar", "right_from"]

Shape = Literal["mean", "bartlett"]


def autocovariance(shape: Shape, length: float, lag: ArrayLike) -> Floats:
    """Autocovariance of white noise of unit two-sided density behind running means over `length` seconds. [1/s]"""
    u: Floats = np.abs(np.atleast_1d(np.asarray(lag, dtype=float))) / length
    if shape == "mean":
        return np.asarray(np.maximum(1 - u, 0) / length)
    inner = 2 / 3 - u * u + u**3 / 2
    return np.where(u < 1, inner, np.maximum(2 - u, 0) ** 3 / 6) / length


def relative_avar(shape: Shape, length: float, m: ArrayLike, tau0: float) -> Floats:
    """Allan variance of sampled, averaged white noise over that of the white noise which it is at long times.

    AVAR(m)·τ/N², with N the random walk of the sampled record, folding included; tends to 1. For small cluster sizes: all
    lags up to twice the largest are summed.
    """
    sizes = np.atleast_1d(np.asarray(m, dtype=np.int64))
    r = autocovariance(shape, length, np.arange(2 * int(sizes.max())) * tau0)
    # Variance of the sum of l samples: l·r(0) + 2·Σ_{k<l} (l − k) r(k).
    sums = np.concatenate(([0.0], np.cumsum(r)))
    totals = np.concatenate(([0.0], np.cumsum(r * np.arange(len(r)))))

    def variance(count: Ints) -> Floats:
        return np.asarray(2 * (count * sums[count] - totals[count]) - count * r[0])

    avar = (4 * variance(sizes) - variance(2 * sizes)) / (2 * sizes.astype(float) ** 2)
    return np.asarray(avar * sizes * tau0 / _plateau(shape, length, tau0))


def right_from(shape: Shape, length: float, tau0: float, *, share: float = 0.02) -> float:
    """Averaging time from which the Allan variance is within `share` of that of noise without a running mean. [s]

    The deficit falls as 1/τ once the autocovariance is over.
    """
    m = max(math.ceil(10 * length / tau0), 2)
    deficit = abs(1 - float(relative_avar(shape, length, m, tau0)[0]))
    return max(deficit * m * tau0 / share, tau0)


def _plateau(shape: Shape, length: float, tau0: float) -> float:
    """Density of the samples at the frequency 0, images folded in."""
    lags = np.arange(1, math.ceil(2 * length / tau0) + 1) * tau0
    r = autocovariance(shape, length, np.concatenate(([0.0], lags)))
    return float(tau0 * (r[0] + 2 * r[1:].sum()))
