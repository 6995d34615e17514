"""Logarithmic bins of frequencies."""

from __future__ import annotations

from numbers import Integral

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import OptionError
from sigmatau.spectrum.tapers import sine_correlation

Floats = NDArray[np.float64]

_STEEPEST_SLOPE = 4.0  # Slope of a density in a log-log plot that is followed within a bin

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
    # A last bin that is cut short, at half the sampling rate, goes to the one before.
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


def shared(count: NDArray[np.intp], *, method: str, tapers: int) -> Floats:
    """Relative increase of the variance of a mean over neighbouring frequencies, compared with independent ones."""
    correlation = (
        _NEIGHBOUR_CORRELATION if method == "welch" else sine_correlation(tapers, np.arange(1, 2 * tapers + 1))
    )
    apart = np.arange(1, len(correlation) + 1)
    return np.asarray(2 * (np.maximum(1 - apart / count[:, None], 0) @ correlation))
