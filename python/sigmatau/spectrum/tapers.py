"""Tapers and other preparation of samples for a transform, sinusoids under tapers, logarithmic bins of frequencies."""

from __future__ import annotations

import functools
import math
from numbers import Integral

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau.arrays import Floats
from sigmatau.errors import OptionError


@functools.lru_cache(maxsize=8)
def hann(n: int) -> Floats:
    """Hann's taper, periodic; shape (n,), read-only."""
    taper: Floats = 0.5 - 0.5 * np.cos(2 * np.pi / n * np.arange(n))
    taper.setflags(write=False)
    return taper


def sine_correlation(tapers: int, apart: ArrayLike) -> Floats:
    """Correlation of the mean power of `tapers` sine tapers at two frequencies, for white noise.

    Notes
    -----
    It is the mean over tapers k and l of |Σ v_k·v_l·exp(−j2πdt/(n + 1))|² at the distance d. v_k·v_l is a difference of
    two cosines. For even k − l the sum differs from 0 only at 2d = |k − l| and 2d = k + l; for odd k − l it is
    imaginary.

    `apart` is the distance of the frequencies in steps of 1/((n + 1)·τ₀).
    """
    k = np.arange(1, tapers + 1)
    d = np.abs(np.asarray(apart, dtype=np.float64))[..., None]
    total = np.zeros(np.shape(apart))
    for row in k:
        even = k[(k - row) % 2 == 0]
        odd = k[(k - row) % 2 == 1]
        meets = 0.5 * (np.abs(even - row) == 2 * d) * (1 + (d == 0))
        total += ((meets - 0.5 * (even + row == 2 * d)) ** 2).sum(axis=-1)
        overlap = 4 * d / np.pi * (1 / (4 * d**2 - (odd - row) ** 2) - 1 / (4 * d**2 - (odd + row) ** 2))
        total += (overlap**2).sum(axis=-1)
    return np.asarray(total / tapers)


def good_length(n: int) -> int:
    """The largest length up to `n` without a prime factor above 5, for a fast transform."""
    best = 1
    five = 1
    while five <= n:
        three = five
        while three <= n:
            best = max(best, three << ((n // three).bit_length() - 1))
            three *= 3
        five *= 5
    return best


def remove_trend(y: Floats) -> Floats:
    """Samples without their mean and slope, by least squares, which reduces leakage from low frequencies."""
    n = len(y)
    t = np.arange(n, dtype=np.float64)
    t -= (n - 1) / 2
    rest: Floats = y - y.mean()
    t *= float(t @ rest) / (n * (n * n - 1) / 12)  # Σ t²
    rest -= t
    return rest


def line_density(
    frequency: Floats, line: float, amplitude: float, *, tau0: float, resolution: float, tapers: int | None
) -> Floats:
    """Upper bound of the density that a sinusoid shows at each frequency, sampled and tapered; shape as `frequency`.

    Notes
    -----
    The bound is the power A²/4 at f and at −f times the maxima of the oscillating power of the taper's transform. At d
    bins this is 1/(πd(d² − 1))² of the peak for Hann's taper, and at most 8k²/(π(4d² − k²))² over the length of the
    record for the sine taper k. In the main lobe it is the peak.

    `frequency` is in Hz. `line` [Hz] and `amplitude` [unit] describe the sinusoid, which is folded back from above half
    the sampling rate. `tau0` is the sample interval [s], `resolution` that of the spectrum [Hz], `tapers` the number of
    sine tapers of a multitaper estimate, or None for Hann's taper. The result is two-sided, in unit²/Hz.
    """
    folded = abs(math.remainder(line * tau0, 1.0)) / tau0
    away = np.abs(frequency - folded)
    if tapers is None:
        d = away / (resolution / 1.5)
        leakage = 1 / np.square(math.pi * np.maximum(d, 2.0) * (np.maximum(d, 2.0) ** 2 - 1))
        window = np.where(d < 2.0, 1.0, leakage) / resolution
    else:
        width = 2 * resolution / (tapers + 1)
        d = np.maximum(away / width, 0.5 * tapers + 1)[:, None]
        k = np.arange(1, tapers + 1)
        leakage = np.mean(8 * k**2 / np.square(math.pi * (4 * d**2 - k**2)), axis=1) / width
        window = np.where(away / width < 0.5 * tapers + 1, 1 / resolution, leakage)
    return np.asarray(amplitude**2 / 4 * window)


_STEEPEST_SLOPE = 4.0  # largest log-log slope of a density that is followed within a bin

# Correlation of the powers of neighbouring bins under a Hann taper: (2/3)² and (1/6)².
_NEIGHBOUR_CORRELATION = np.array([4 / 9, 1 / 36])


def bin_starts(frequency: Floats, per_octave: int) -> NDArray[np.intp]:
    """Index of the first frequency of each bin; `OptionError` unless there is at least 1 bin per octave."""
    if isinstance(per_octave, bool) or not (isinstance(per_octave, Integral) and per_octave >= 1):
        raise OptionError(
            f"{{option}} must be a whole number of bins, 1 or more, not {per_octave!r}", option="per_octave"
        )
    edges = frequency[0] * 2.0 ** (np.arange(int(np.log2(frequency[-1] / frequency[0]) * per_octave) + 2) / per_octave)
    starts = np.unique(np.searchsorted(frequency, edges * (1 - 1e-9)))
    starts = starts[starts < len(frequency)]
    # An incomplete last bin, at half the sampling rate, is joined to the one before.
    if len(starts) > 1 and frequency[-1] < frequency[starts[-1]] * 2 ** (0.5 / per_octave):
        starts = starts[:-1]
    return starts


def slopes(density: Floats, frequency: Floats) -> Floats:
    """Log-log slope at each bin, from its neighbours; 0 if there are too few neighbours or a density is 0."""
    if len(density) < 3 or not (density > 0).all():
        return np.zeros(len(density))
    return np.asarray(np.clip(np.gradient(np.log(density), np.log(frequency)), -_STEEPEST_SLOPE, _STEEPEST_SLOPE))


def levelled(density: Floats, frequency: Floats, starts: NDArray[np.intp]) -> tuple[Floats, Floats, Floats]:
    """Frequencies and densities of bins, and the factor by which each density was moved to the frequency of its bin."""
    count = np.diff(np.append(starts, len(frequency)))
    centres = np.add.reduceat(frequency, starts) / count
    slope = slopes(np.add.reduceat(density, starts) / count, centres)
    factor = (frequency / np.repeat(centres, count)) ** -np.repeat(slope, count)
    return centres, np.add.reduceat(density * factor, starts) / count, factor


def variance_increase(count: NDArray[np.intp], *, method: str, tapers: int) -> Floats:
    """Relative increase of the variance of a mean over neighbouring frequencies, compared with independent ones."""
    correlation = (
        _NEIGHBOUR_CORRELATION if method == "welch" else sine_correlation(tapers, np.arange(1, 2 * tapers + 1))
    )
    apart = np.arange(1, len(correlation) + 1)
    return np.asarray(2 * (np.maximum(1 - apart / count[:, None], 0) @ correlation))
