"""Tapers, and other preparation of samples for a transform."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["good_length", "hann", "sine_correlation", "without_line"]

Floats = NDArray[np.float64]


def hann(n: int) -> Floats:
    """Hann's taper, periodic; shape (n,)."""
    return np.asarray(0.5 - 0.5 * np.cos(2 * np.pi / n * np.arange(n)))


def sine_correlation(tapers: int, apart: ArrayLike) -> Floats:
    """Correlation of the mean power of a number of sine tapers at two frequencies, for white noise.

    Notes
    -----
    The mean over tapers k and l of |Σ v_k·v_l·exp(−j2πdt/(n + 1))|², d the distance. v_k·v_l is a difference of two cosines:
    where k − l is even it meets d only at 2d = |k − l| and 2d = k + l, where it is odd the sum is imaginary.

    `apart`: distance of the frequencies in steps of 1/((n + 1)·τ₀).
    """
    k = np.arange(1, tapers + 1)
    d = np.abs(np.asarray(apart, dtype=np.float64))[..., None]
    total = np.zeros(np.shape(apart))
    for row in k:
        even = k[(k - row) % 2 == 0]
        odd = k[(k - row) % 2 == 1]
        meets = 0.5 * (np.abs(even - row) == 2 * d) * (1 + (d == 0))
        total += ((meets - 0.5 * (even + row == 2 * d)) ** 2).sum(axis=-1)
        shared = 4 * d / np.pi * (1 / (4 * d**2 - (odd - row) ** 2) - 1 / (4 * d**2 - (odd + row) ** 2))
        total += (shared**2).sum(axis=-1)
    return np.asarray(total / tapers)


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
    """Samples without their mean and slope, by least squares, which reduces leakage from low frequencies."""
    n = len(y)
    t = np.arange(n, dtype=np.float64)
    t -= (n - 1) / 2
    rest: Floats = y - y.mean()
    t *= float(t @ rest) / (n * (n * n - 1) / 12)  # Σ t²
    rest -= t
    return rest
