"""Components of the expected Allan variances, their covariance and their skewness, by term.

The components depend on the record's length, the cluster sizes and the shapes of the terms, not on the data: they are
computed once and shared by all axes, all steps of a fit and all files of a run. Times are in samples: the sample interval is
1, and a squared coefficient θ is for this interval.

The expected Allan variance is Σ θ(p) D(p), its covariance Σ θ(p) θ(q) Γ(p, q), exact for finite records
(`sigmatau.noise.uncertainty.avar_covariance`). The third cumulant of a weighted sum of Allan variances is computed as if the
modes of the discrete cosine transform were independent, which is exact for white noise plus a random walk: with the
spectrum θ·S(k) at mode k and its gain g(k, n) in the variance at n, the cumulant of order r of Σ h(n) AVAR(n) is
2^(r−1) (r−1)! Σ_k (Σ_n h(n) g(k, n) θ·S(k))^r.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import kernels
from sigmatau.frozen import frozen

Floats = NDArray[np.float64]

# Noise terms: the Allan variance is linear in their squared coefficients. The ramp is not a noise.
LINEAR = ("quantization", "random_walk", "bias_instability", "rate_random_walk")
_POWERS = {"quantization": 0, "random_walk": 1, "bias_instability": 2, "rate_random_walk": 3}

_LOW_MODES = 512  # the lowest modes, which are all used
_HIGH_MODES = 400  # modes that represent all higher ones


def power_of_interval(name: str) -> int:
    """The power p by term: θ in samples is θ in SI times tau0^(p − 2); 2 for processes given by their variance."""
    return _POWERS.get(name, 2)


@frozen(eq=False)
class Components:
    """Terms at the cluster sizes `m` of a record of `n` samples."""

    names: tuple[str, ...]  # The four of `LINEAR`, then ``"gauss_markov"`` or ``"sinusoid"`` if one is fitted
    n: int
    m: NDArray[np.int64]  # shape (n_tau,)
    design: Floats  # shape (n_tau, n_terms); expected Allan variance for θ = 1
    noise: (
        Floats  # shape (n_terms·(n_terms+1)/2, …); Γ(p, q) of the pairs p ≤ q; both orders of an unequal pair together
    )
    # shape (n_terms, n_tau, n_tau); covariance, for θ = 1, of the ramps estimated from the mean second differences
    slopes: Floats
    spectra: Floats  # shape (n_terms, n_modes); power of a mode for θ = 1, over n
    gains: Floats  # shape (n_tau, n_modes)
    modes: Floats  # shape (n_modes,); number of modes that each represents
    squares: Floats  # shape (n_tau,); m²: twice the variance of a ramp of 1
    ramp_weights: Floats | None = None  # shape (n_tau,); weights of the ramp that was removed, if any

    def from_index(self, first: int) -> Self:
        """The components without the `first` shortest averaging times."""
        return replace(
            self,
            m=self.m[first:],
            design=self.design[first:],
            noise=np.ascontiguousarray(self.noise[:, first:, first:]),
            slopes=self.slopes[:, first:, first:],
            gains=self.gains[first:],
            squares=self.squares[first:],
        )

    def without_ramp(self, weights: Floats) -> Self:
        """The components of Allan variances from which a ramp was removed, see `remove_ramp`. The ramp is Σ
        weights·ramp(m). Its variance v and its covariance c with every ramp(m) are known, and hence the expected
        variances after its removal.
        """
        c = np.einsum("pij,j->ip", self.slopes, weights)
        v = np.einsum("i,ip->p", weights, c)
        return replace(self, design=self.design - self.squares[:, None] * (c - 0.5 * v), ramp_weights=weights)

    def covariance(self, theta: Floats) -> Floats:
        """Covariance of the Allan variances, if θ is true. After the removal of a ramp, a second difference is m²(β −
        1) times the ramp's error plus a remainder, with β = c/v; the remainder is taken as independent of the ramp's
        error, which holds on average over the record.
        """
        first, second = _pairs(len(theta))
        # Not @, which may start threads for such a small product.
        flat = np.einsum("k,kj->j", theta[first] * theta[second], self.noise.reshape(len(first), -1))
        total = np.asarray(flat.reshape(len(self.m), len(self.m)))
        if self.ramp_weights is None:
            return total
        slopes = np.einsum("p,pij->ij", theta, self.slopes)
        c = np.einsum("ij,j->i", slopes, self.ramp_weights)
        v = float(self.ramp_weights @ c)
        if v <= 0:
            return total
        squares = self.squares
        beta = c / v
        remainder = slopes - np.outer(c, c) / v
        for sign, share in ((-1.0, squares * beta), (1.0, squares * (beta - 1))):
            both = np.outer(share, share)
            ends = np.outer(beta if sign < 0 else beta - 1, beta if sign < 0 else beta - 1)
            total = total + sign * both * v * (0.5 * v * ends + remainder)
        return total

    def remove_ramp(self, avar: Floats, ramps: Floats, ramp: float) -> Floats:
        """Allan variances without a `ramp`: means of the squares of z − ramp·m² in place of z."""
        return avar - ramp * self.squares * (ramps - 0.5 * ramp)

    def degrees_of_freedom(self, theta: Floats, *, ramp: float) -> Floats:
        """Degrees of freedom of every Allan variance, 2·AVAR²/Var, for θ and a ramp per sample."""
        drift = 0.5 * ramp * ramp * self.squares
        diagonals = np.diagonal(self.noise, axis1=1, axis2=2)
        variances = sum(
            theta[p] * theta[q] * diagonal
            for (p, q), diagonal in zip(pairs_of_terms(len(theta)), diagonals, strict=True)
        )
        variances = variances + (ramp * self.squares) ** 2 * (theta @ np.diagonal(self.slopes, axis1=1, axis2=2))
        return np.asarray(2 * (self.design @ theta + drift) ** 2 / variances)

    def skewness(self, weights: Floats, theta: Floats) -> tuple[float, float]:
        """Skewness and variance of Σ weights·AVAR, computed from independent modes."""
        parts = np.einsum("j,jk->k", weights, self.gains) * np.einsum("p,pk->k", theta, self.spectra)
        squares = self.modes * parts * parts
        variance = 2 * float(squares.sum())
        return 8 * float(squares @ parts) / variance**1.5, variance


@functools.cache
def _pairs(n_terms: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The pairs p ≤ q of terms, in the order of `Components.noise`."""
    return np.triu_indices(n_terms)


@functools.lru_cache(maxsize=32)
def components(
    n: int, m: tuple[int, ...], *, correlation_time: float | None = None, frequency: float | None = None
) -> Components:
    """The components of the four noise terms and at most one more. `m`: cluster sizes, increasing, at most n/2;
    `correlation_time`: of a Gauss-Markov process; its θ is the variance [samples]; `frequency`: of a sinusoid of random
    phase; its θ is the squared amplitude [cycles per sample].
    """
    if frequency is not None:
        return with_sinusoid(components(n, m), frequency)
    sizes = np.array(m, dtype=np.int64)
    times = () if correlation_time is None else (correlation_time,)
    tensors, drifts = kernels.covariance_tensors(n, sizes, 1.0, correlation_times=times)
    names: tuple[str, ...] = LINEAR
    columns = [kernels.term_avar(name, 1.0, sizes, 1.0) for name in LINEAR]
    angle, modes = _modes(n)
    sine = np.sin(angle / 2)
    spectra = [4 * sine**2, np.ones_like(sine), 0.5 / sine, 0.25 / sine**2]
    if correlation_time is not None:
        names = (*LINEAR, "gauss_markov")
        columns.append(kernels.gauss_markov_avar(1.0, correlation_time, sizes, 1.0))
        decay = -math.expm1(-1 / correlation_time)
        spectra.append(decay * (2 - decay) / (decay**2 + 4 * (1 - decay) * sine**2))
    order = range(len(names))
    squares = sizes.astype(float) ** 2
    result = Components(
        names=names,
        n=n,
        m=sizes,
        design=np.column_stack(columns),
        noise=np.array([(1 if p == q else 2) * tensors[p, q] for p, q in pairs_of_terms(len(names))]),
        slopes=np.array([drifts[p] / np.outer(squares, squares) for p in order]),
        spectra=np.array(spectra) / n,
        gains=2 * np.sin(np.outer(sizes, angle) / 2) ** 4 / np.outer(squares, sine**2),
        modes=modes,
        squares=squares,
    )
    for array in (result.design, result.noise, result.slopes, result.spectra, result.gains):
        array.setflags(write=False)
    return result


def densities(frequency: float) -> tuple[float, float, float, float]:
    """Two-sided densities of the four noise terms for θ = 1 at a frequency in cycles per sample."""
    sine = math.sin(math.pi * frequency)
    return 4 * sine**2, 1.0, 0.5 / sine, 0.25 / sine**2


def with_sinusoid(linear: Components, frequency: float) -> Components:
    """The noise terms and a sinusoid of random phase, whose θ is the squared amplitude; frequency in cycles per sample.

    A sinusoid is not a noise: it enters the covariance only through the noise at its frequency. The squared amplitude
    measured in a record of n samples has the variance 8A²S(f)/n, with S two-sided, and every Allan variance is proportional
    to it.
    """
    column = kernels.sinusoid_avar(1.0, frequency, linear.m, 1.0)
    at = densities(frequency)
    outer = np.outer(column, column)
    zero = np.zeros_like(outer)
    matrices = iter(linear.noise)
    terms = len(LINEAR)
    noise = [
        next(matrices) if q < terms else (8 / linear.n * at[p] * outer if p < terms else zero)
        for p, q in pairs_of_terms(terms + 1)
    ]
    return replace(
        linear,
        names=(*LINEAR, "sinusoid"),
        design=np.column_stack([linear.design, column]),
        noise=np.array(noise),
        slopes=np.concatenate([linear.slopes, zero[None]]),
        spectra=np.vstack([linear.spectra, np.zeros_like(linear.spectra[:1])]),
    )


def pairs_of_terms(terms: int) -> list[tuple[int, int]]:
    """All p ≤ q, in the order of `Components.noise`."""
    return [(p, q) for p in range(terms) for q in range(p, terms)]


def _modes(n: int) -> tuple[Floats, Floats]:
    """Angles π k/n of modes of the discrete cosine transform, and the number of modes that each represents."""
    low = np.arange(1, min(_LOW_MODES, n - 1) + 1)
    high = np.round(np.geomspace(_LOW_MODES + 1, n - 1, _HIGH_MODES)) if n - 1 > _LOW_MODES else np.empty(0)
    k = np.unique(np.concatenate([low, high]))
    edges = np.concatenate([[0.5], (k[1:] + k[:-1]) / 2, [n - 0.5]])
    return np.pi * k / n, np.diff(edges)


def half_octaves(smallest: int, largest: int) -> Sequence[int]:
    """Those of the cluster sizes 1, 2, 3, 4, 6, 8, 12 … that lie between two sizes."""
    sizes = {seed << j for seed in (1, 3) for j in range(largest.bit_length())}
    return tuple(sorted(size for size in sizes if smallest <= size <= largest))
