"""Cosine transform of several channels, summed in bands of frequency.

In the type-II transform, values at different frequencies are exactly independent for white noise and for a random walk,
with variances σ² and σ²/(4 sin²(πk/2N)): its basis vectors are the eigenvectors of the second difference with free ends.

References
----------
G. Strang, "The discrete cosine transform," SIAM Review, vol. 41, no. 1, 1999, :doi:`10.1137/S0036144598336745`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sigmatau.arrays import Bools, Floats
from sigmatau.frozen import frozen

# Number of the lowest frequencies, each of which is a band. Judgement: the densities of slow noise change most there.
_SINGLE = 24
# Ratio of the ends of a wider band. [1] Judgement: a density f⁻² changes by an eighth in a band, which uses its mean.
_RATIO = 1.06
# Half width of the band that is left out at a line: a number of frequencies of the transform, plus a share of the number of
# the line. [1] Judgement: the line is subtracted first, so that only its modulation remains.
_LINE_WIDTH, _LINE_SHARE = 32, 0.005


@frozen(eq=False)
class Bands:
    """Sums over the frequencies of each band.

    Attributes
    ----------
    first, last : ndarray of int, shape (n_bands,)
        First and last number k of the frequencies k/(2·N·τ₀) of a band.
    count : ndarray, shape (n_bands,)
        Number of frequencies.
    power : ndarray, shape (n_bands, n, n)
        Sums of y·yᵀ over the channels. [unit²]
    trend : ndarray, shape (n_bands, q, n)
        Sums of x·yᵀ, where x are the transforms of the regressors. [unit]
    trends : ndarray, shape (n_bands, q, q)
        Sums of x·xᵀ. [1]
    samples : int
    tau0 : float
        [s]
    used : ndarray of bool, shape (samples,)
        Frequencies of the transform that are in a band.
    """

    first: np.ndarray
    last: np.ndarray
    count: Floats
    power: Floats
    trend: Floats
    trends: Floats
    samples: int
    tau0: float
    used: Bools

    @property
    def low(self) -> Floats:
        """Lowest frequency of each band. [Hz]"""
        return np.asarray(self.first / (2 * self.samples * self.tau0))

    @property
    def high(self) -> Floats:
        """Highest frequency of each band. [Hz]"""
        return np.asarray(self.last / (2 * self.samples * self.tau0))

    def mean(self, density: Floats) -> Floats:
        """Mean of a density over the frequencies of each band; `density` has its values at k = 0 … N − 1, shape (N,)."""
        edges = np.stack([self.first, self.last + 1], axis=1).ravel()
        sums = np.add.reduceat(np.append(np.where(self.used, density, 0.0), 0.0), edges)[::2]
        return np.asarray(sums / self.count)

    def combined(self, matrix: Floats) -> Bands:
        """The bands of linear combinations of the channels; `matrix` has their coefficients, shape (n, n_combined)."""
        return Bands(
            first=self.first,
            last=self.last,
            count=self.count,
            power=np.einsum("ia,bij,jc->bac", matrix, self.power, matrix),
            trend=self.trend @ matrix,
            trends=self.trends,
            samples=self.samples,
            tau0=self.tau0,
            used=self.used,
        )


def cosine_transform(x: Floats) -> Floats:
    """Orthonormal type-II cosine transform along the last axis, by a Fourier transform of the same length."""
    n = x.shape[-1]
    folded = np.concatenate([x[..., ::2], x[..., 1::2][..., ::-1]], axis=-1)
    turned = np.fft.fft(folded, axis=-1) * np.exp(-0.5j * np.pi * np.arange(n) / n)
    result = np.sqrt(2 / n) * turned.real
    result[..., 0] /= np.sqrt(2)
    return np.asarray(result)


def gather_bands(
    samples: Floats,
    tau0: float,
    *,
    regressors: Sequence[Floats] = (),
    lines: Sequence[float] = (),
    excluded: Sequence[tuple[float, float]] = (),
    highest: float | None = None,
) -> Bands:
    """Transform channels, shape (n, N), and sum their products over bands of neighbouring frequencies.

    `regressors`: curves of the mean besides a constant and a ramp. The frequencies of `lines`, those in `excluded` bands
    and those above `highest` are left out. [Hz]
    """
    n = samples.shape[1]
    time = (np.arange(n) + 0.5) / n - 0.5
    curves = np.stack([time, *regressors])
    y = cosine_transform(samples)
    x = cosine_transform(curves)
    x /= np.sqrt(np.sum(x[:, 1:] ** 2, axis=1, keepdims=True))
    used = _usable(n, tau0, lines, excluded, highest)
    first, last = _edges(used)
    y, x = np.where(used, y, 0.0), np.where(used, x, 0.0)
    rows = [np.s_[:, a : b + 1] for a, b in zip(first, last, strict=True)]
    return Bands(
        first=first,
        last=last,
        count=np.array([np.count_nonzero(used[a : b + 1]) for a, b in zip(first, last, strict=True)], dtype=float),
        power=np.stack([y[row] @ y[row].T for row in rows]),
        trend=np.stack([x[row] @ y[row].T for row in rows]),
        trends=np.stack([x[row] @ x[row].T for row in rows]),
        samples=n,
        tau0=tau0,
        used=used,
    )


def _usable(
    n: int, tau0: float, lines: Sequence[float], excluded: Sequence[tuple[float, float]], highest: float | None
) -> Bools:
    """Frequencies that are used: all but the constant, the lines, excluded bands, and those above `highest`."""
    used = np.ones(n, dtype=bool)
    used[0] = False
    if highest is not None:
        used[int(2 * n * tau0 * highest) + 1 :] = False
    for low, high in excluded:
        used[max(int(2 * n * tau0 * low), 1) : int(2 * n * tau0 * high) + 1] = False
    for frequency in lines:
        width = _LINE_WIDTH + _LINE_SHARE * 2 * n * tau0 * frequency
        middle = 2 * n * tau0 * frequency
        used[max(int(middle - width), 1) : int(middle + width) + 1] = False
    return used


def _edges(used: Bools) -> tuple[np.ndarray, np.ndarray]:
    """First and last frequency of each band with at least one usable frequency."""
    first, k, n = [], 1, len(used)
    while k < n:
        first.append(k)
        k = k + 1 if k < _SINGLE else max(int(k * _RATIO), k + 1)
    last = [*(k - 1 for k in first[1:]), n - 1]
    usable = [(a, b) for a, b in zip(first, last, strict=True) if used[a : b + 1].any()]
    return np.array([a for a, _ in usable]), np.array([b for _, b in usable])
