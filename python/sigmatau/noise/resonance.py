"""Allan variance of a band-pass resonance, the noise of a damped oscillator driven by white noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


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
