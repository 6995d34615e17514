"""The spectrum of a record with so many lost samples that no stretch is whole: from the pairs of samples that are there.

Samples l apart have the autocovariance r(l) whatever else is missing, so long as what is lost does not depend on what it
would have been: its sum over pairs that are there, over their number, has no bias. The lag window is that of a Hann taper,
so that the expectation is Welch's. The error is larger than his: noise at all frequencies is scattered by the losses over
all others, and a density far below the mean one drowns in it. At random losses of a share q, p = 1 − q, the zero-filled
record has the density p²S + pq·σ²τ₀, of which the variance is that of any estimate.

References
----------
E. Parzen, "On spectral analysis with missing observations and amplitude modulation", Sankhya A 25 (1963), 383-392.
"""

from __future__ import annotations

import numpy as np

from sigmatau.arrays import Bools, Floats
from sigmatau.record.streams import Stream
from sigmatau.spectrum.estimate import default_size
from sigmatau.spectrum.result import Spectrum
from sigmatau.spectrum.tapers import good_length, hann

__all__ = ["by_pairs", "is_torn"]

_WHOLE = 0.7  # of the samples that are there; segments that see less give way to pairs
_LEAST_SHARE = 0.4  # of the samples that must be there
_BLOCK = 8  # tapers in a block, beyond which no pair is looked for
_MOST = 1 << 22  # samples looked at, from the first on
_BATCH = 1 << 21


def is_torn(spectrum: Spectrum | None, there: int) -> bool:
    """Whether Welch's segments, as long as they might be, see too little of the samples that are there, or are none."""
    if spectrum is None:
        return True
    length = round(1.5 / (spectrum.resolution * spectrum.tau0))
    return length < default_size(spectrum.n) or spectrum.segments * (length / 2) < _WHOLE * there


def by_pairs(y: Floats, stream: Stream, channel: str) -> Spectrum | None:
    """The density of a channel with missing samples, NaN, by pairs; None if too few are there.

    Frequencies and resolution are those of Welch's estimate; the slow part, beyond the length of a taper, is taken off.
    """
    y = y[:_MOST]
    there = np.isfinite(y)
    length = default_size(len(y))
    if there.mean() < _LEAST_SHARE or len(y) < 2 * length:
        return None
    taper = hann(length)
    window = np.correlate(taper, taper, "full")[length - 1 :] if length <= 256 else _autocorrelation(taper)
    window = window / window[0]
    size = min(_BLOCK * length, len(y))
    count = -(-len(y) // size)
    x = np.zeros(count * size)
    mask = np.zeros(count * size)
    x[: len(y)][there] = _without_slow(y, there, taper)
    mask[: len(y)][there] = 1.0
    products, pairs = _lagged(x.reshape(count, size), length), _lagged(mask.reshape(count, size), length)
    if pairs.min() < 0.5 * _LEAST_SHARE**2 * (len(y) - count * length):
        return None  # losses at a pace of their own: every second sample, say
    covariance = np.where(pairs > 0, products / np.maximum(pairs, 1), 0.0) * window
    density = _transformed(covariance) * stream.grid.tau0
    if not density.mean() > 0:
        return None
    # What a sample that is there sees, losses scattered in; see above.
    seen = _transformed(covariance * pairs / pairs[0]) * stream.grid.tau0
    share = float(pairs[1:].mean() / pairs[0])
    scattered = np.maximum(seen / share, density)
    power = 1 + 2 * float(window[1:] @ window[1:])
    dof = 2 * len(y) / power * np.clip(density / scattered, 1e-3, 1.0) ** 2
    return Spectrum(
        channel=channel,
        quantity=stream.quantity,
        unit=stream.unit,
        frequency=np.arange(2, length // 2 + 1) / (length * stream.grid.tau0),
        density=density[2:],
        dof=dof[2:],
        resolution=1.5 / (length * stream.grid.tau0),
        segments=count,
        n=stream.grid.n,
        tau0=stream.grid.tau0,
    )


def _without_slow(y: Floats, there: Bools, taper: Floats) -> Floats:
    """The samples that are there, less their mean about each, weighted by a taper."""
    from scipy.signal import oaconvolve

    x = np.where(there, y - float(np.median(y[there])), 0.0)
    total = oaconvolve(x, taper, mode="same")
    number = oaconvolve(there.astype(float), taper, mode="same")
    return np.asarray((x - total / np.maximum(number, 1.0))[there])


def _autocorrelation(taper: Floats) -> Floats:
    size = 2 * len(taper)
    return np.asarray(np.fft.irfft(np.abs(np.fft.rfft(taper, size)) ** 2, size)[: len(taper)])


def _lagged(x: Floats, lags: int) -> Floats:
    """Sum over pairs of each row that are 0, 1 … `lags` − 1 apart."""
    size = good_length(x.shape[1] + lags + x.shape[1] // 16)
    rows = max(_BATCH // size, 1)
    total = np.zeros(size // 2 + 1)
    for first in range(0, len(x), rows):
        total += (np.abs(np.fft.rfft(x[first : first + rows], size, axis=1)) ** 2).sum(axis=0)
    return np.asarray(np.fft.irfft(total, size)[:lags])


def _transformed(covariance: Floats) -> Floats:
    """Of an even covariance, at multiples of 1/length; shape (length/2 + 1,)."""
    both = 2 * covariance
    both[0] = covariance[0]
    return np.asarray(np.fft.rfft(both).real)
