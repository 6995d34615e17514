"""What is done to samples before they are transformed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["good_length", "hann", "without_line"]

Floats = NDArray[np.float64]


def hann(n: int) -> Floats:
    """Hann's taper, periodic; shape (n,)."""
    return np.asarray(0.5 - 0.5 * np.cos(2 * np.pi / n * np.arange(n)))


def good_length(n: int) -> int:
    """The largest length up to `n` without a prime factor above 5: a fast transform."""
    best = 1
    five = 1
    while five <= n:
        three = five
        while three <= n:
            best = max(best, three << ((n // three).bit_length() - 1))
            three *= 3
        five *= 5
    return best


def without_line(y: Floats) -> Floats:
    """Samples without their mean and slope, by least squares: what leaks most from below the lowest frequency."""
    n = len(y)
    t = np.arange(n, dtype=np.float64)
    t -= (n - 1) / 2
    rest: Floats = y - y.mean()
    t *= float(t @ rest) / (n * (n * n - 1) / 12)  # Σ t²
    rest -= t
    return rest
