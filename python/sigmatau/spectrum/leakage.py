"""Density of a sinusoid in a spectrum, at its frequency and beside it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

__all__ = ["line_density"]

Floats = NDArray[np.float64]


def line_density(
    frequency: Floats, line: float, amplitude: float, *, tau0: float, resolution: float, tapers: int | None
) -> Floats:
    """Upper bound of the density that a sinusoid shows at each frequency, sampled and tapered; shape as `frequency`.

    Parameters
    ----------
    frequency : ndarray, shape (n_f,)
        [Hz]
    line, amplitude : float
        Of the sinusoid, which is folded back from above half the sampling rate. [Hz], [unit]
    tau0 : float
        Sample interval. [s]
    resolution : float
        Of the spectrum. [Hz]
    tapers : int or None
        Sine tapers of a multitaper estimate; None for Hann's taper.

    Returns
    -------
    ndarray, shape (n_f,)
        [unit²/Hz, two-sided]

    Notes
    -----
    The power A²/4 of either side times the power of the taper's transform, whose oscillation is taken at its maxima: of
    Hann's taper 1/(πd(d² − 1))² of its peak at d bins, of the sine taper k at most 8k²/(π(4d² − k²))² over the length of
    the record. In the main lobe it is the peak.
    """
    folded = abs(math.remainder(line * tau0, 1.0)) / tau0
    away = np.abs(frequency - folded)
    if tapers is None:
        d = away / (resolution / 1.5)
        beside = 1 / np.square(math.pi * np.maximum(d, 2.0) * (np.maximum(d, 2.0) ** 2 - 1))
        window = np.where(d < 2.0, 1.0, beside) / resolution
    else:
        width = 2 * resolution / (tapers + 1)
        d = np.maximum(away / width, 0.5 * tapers + 1)[:, None]
        k = np.arange(1, tapers + 1)
        beside = np.mean(8 * k**2 / np.square(math.pi * (4 * d**2 - k**2)), axis=1) / width
        window = np.where(away / width < 0.5 * tapers + 1, 1 / resolution, beside)
    return np.asarray(amplitude**2 / 4 * window)
