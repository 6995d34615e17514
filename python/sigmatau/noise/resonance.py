"""Allan variance of a band-pass resonance, the noise of a damped oscillator driven by white noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_FOLDING = 0.02  # frequency over the sampling rate below which nothing worth mentioning is folded
_FOLDED = 0.02  # share of the density of the white noise
_GRID = 8192  # frequencies up to half the rate
_AVERAGED = 1024  # cluster size from which sin⁴ is replaced by its mean of 3/8


def resonance_avar(sigma: float, frequency: float, width: float, m: NDArray[np.int64], tau0: float) -> Floats:
    """Allan variance of a sampled resonance. [(rate unit)²]

    The autocovariance of the speed of a damped oscillator is σ² Re[(1 + iγ/ω) exp((iω − γ) t)], with γ = 2π·width and
    ω² = (2π·frequency)² − γ²; cluster means are sums of geometric series.

    Parameters
    ----------
    sigma : float
        Standard deviation. [rate unit]
    frequency, width : float
        Centre and half width; the width must be less than the centre. [Hz]
    m : ndarray of int
        Cluster sizes.
    tau0 : float
        Sample interval. [s]
    """
    damping = 2 * np.pi * width
    turning = np.sqrt((2 * np.pi * frequency) ** 2 - damping**2)
    z = (damping - 1j * turning) * tau0
    lost, lost_cluster = -np.expm1(-z), -np.expm1(-z * m)
    own = (m * lost * (1 + np.exp(-z)) - 2 * np.exp(-z) * lost_cluster) / (m * lost) ** 2
    neighbour = np.exp(-z) * (lost_cluster / (m * lost)) ** 2
    return np.asarray(sigma**2 * ((1 + 1j * damping / turning) * (own - neighbour)).real)


def resonance_psd(sigma: float, frequency: float, width: float, f: Floats) -> Floats:
    """Two-sided density of a resonance: 0 at the frequency 0. [(rate unit)²/Hz]"""
    square = f * f
    below = (square - frequency**2) ** 2 + 4 * width**2 * square
    return np.asarray(sigma**2 * 2 * width / np.pi * square / below)


def folded_level(sigma: float, frequency: float, width: float, tau0: float) -> float:
    """Two-sided density at the frequency 0 of a sampled resonance: what sampling folds from beyond half the rate.
    [(rate unit)²/Hz]
    """
    damping = 2 * np.pi * width
    turning = np.sqrt((2 * np.pi * frequency) ** 2 - damping**2)
    decay = np.exp(-(damping - 1j * turning) * tau0)
    return float(tau0 * sigma**2 * ((1 + 1j * damping / turning) * (1 + decay) / (1 - decay)).real)


def folds(sigma: float, frequency: float, width: float, tau0: float, *, random_walk: float) -> bool:
    """Whether a sampled resonance adds to the white noise at low frequencies what a fit of the spectrum did not find there:
    a model without it describes longer averaging times better.
    """
    return folded_level(sigma, frequency, width, tau0) > _FOLDED * random_walk**2


def unfolded_avar(sigma: float, frequency: float, width: float, m: NDArray[np.int64], tau0: float) -> Floats:
    """Allan variance of samples whose density is that of a resonance up to half the rate, as a fit of the spectrum has it:
    without what `resonance_avar` holds from beyond. [(rate unit)²]
    """
    if frequency * tau0 < _FOLDING:
        return resonance_avar(sigma, frequency, width, m, tau0)
    f: Floats = (np.arange(_GRID, dtype=np.float64) + 0.5) / (2 * _GRID * tau0)
    weight = resonance_psd(sigma, frequency, width, f) / np.sin(np.pi * f * tau0) ** 2
    sums = np.array([weight @ np.sin(np.pi * k * tau0 * f) ** 4 if k < _AVERAGED else 0.375 * weight.sum() for k in m])
    return np.asarray(4 * (f[1] - f[0]) * sums / m.astype(np.float64) ** 2)
