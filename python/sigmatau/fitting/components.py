"""What the expected Allan variances, their covariance and their skewness are made of, term by term.

Everything here depends on the record's length, the cluster sizes and the shapes of the terms, not on any datum: it is
computed once and shared by all axes, all steps of a fit and all files of a run. Units are samples: the sample interval is
1, and a squared coefficient θ is that for this interval.

The expected Allan variance is Σ θ(p) D(p), its covariance Σ θ(p) θ(q) Γ(p, q), exact for finite records
(`sigmatau.noise.uncertainty.avar_covariance`). For the third cumulant of a weighted sum of Allan variances the record
is taken as
if the discrete cosine transform made its modes independent, which is exact for white noise plus a random walk: with the
spectrum θ·S(k) at mode k and its gain g(k, n) in the variance at n, the cumulant of order r of Σ h(n) AVAR(n) is
2^(r−1) (r−1)! Σ_k (Σ_n h(n) g(k, n) θ·S(k))^r.

Where samples are missing, `sigmatau.fitting.masked_components` makes of these what the gaps leave.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import kernels
from sigmatau.estimators.gaps import Gaps

__all__ = ["LINEAR", "Components", "components", "pairs_of_terms", "power_of_interval", "with_sinusoid"]

Floats = NDArray[np.float64]

LINEAR = ("quantization", "random_walk", "bias_instability", "rate_random_walk")
"""Terms whose squared coefficients the Allan variance is linear in; the ramp is none: it is no noise."""

_POWERS = {"quantization": 0, "random_walk": 1, "bias_instability": 2, "rate_random_walk": 3}

# Modes taken one by one, and how many stand for all others.
_LOW_MODES = 512
_HIGH_MODES = 400

_LEAST_EIGENVALUE = 1e-8

_LEAST_LEFT = 1e-3
"""Of a variance, once a ramp was removed."""


def power_of_interval(name: str) -> int:
    """θ in samples is θ in SI times tau0^(p − 2); p by term, 2 for all that are given by a variance."""
    return _POWERS.get(name, 2)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Components:
    """Terms at the cluster sizes `m` of a record of `n` samples.

    Attributes
    ----------
    names : tuple of str
        The four of `LINEAR`, then ``"gauss_markov"`` or ``"sinusoid"`` if there is one.
    n : int
    m : ndarray of int, shape (n_tau,)
    design : ndarray, shape (n_tau, n_terms)
        Expected Allan variance for θ = 1.
    noise : ndarray, shape (n_terms·(n_terms+1)/2, n_tau, n_tau)
        Γ(p, q) of the pairs p ≤ q; both orders of an unequal pair together.
    slopes : ndarray, shape (n_terms, n_tau, n_tau)
        Covariance, for θ = 1, of the ramps as the mean second differences show them.
    spectra : ndarray, shape (n_terms, n_modes)
        Power of a mode for θ = 1, over n.
    gains : ndarray, shape (n_tau, n_modes)
    modes : ndarray, shape (n_modes,)
        How many modes each stands for.
    squares : ndarray, shape (n_tau,)
        Mean square of the distance of the two clusters of a pair, m² without gaps: of a ramp of 1, twice the variance.
    ramp_weights : ndarray or None, shape (n_tau,)
        Weights of the ramp that was removed, if one was.
    gaps : Gaps or None
        What is missing.
    powers : ndarray or None, shape (n_terms, n_tau, n_modes)
        With gaps, where a term's share of a mode depends on the averaging time: gain times power, for θ = 1.
    """

    names: tuple[str, ...]
    n: int
    m: NDArray[np.int64]
    design: Floats
    noise: Floats
    slopes: Floats
    spectra: Floats
    gains: Floats
    modes: Floats
    squares: Floats
    ramp_weights: Floats | None = None
    gaps: Gaps | None = None
    powers: Floats | None = None

    def from_index(self, first: int) -> Self:
        """The same without the shortest `first` averaging times."""
        return replace(
            self,
            m=self.m[first:],
            design=self.design[first:],
            noise=np.ascontiguousarray(self.noise[:, first:, first:]),
            slopes=self.slopes[:, first:, first:],
            gains=self.gains[first:],
            squares=self.squares[first:],
            powers=None if self.powers is None else self.powers[:, first:],
        )

    def without_ramp(self, weights: Floats) -> Self:
        """The components of Allan variances from which a ramp was removed, see `remove_ramp`.

        The ramp is Σ weights·ramp(m), so that its own variance v and its covariance c with every ramp(m) are known, and
        with them what is left on average.
        """
        c = np.einsum("pij,j->ip", self.slopes, weights)
        v = np.einsum("i,ip->p", weights, c)
        return replace(self, design=self.design - self.squares[:, None] * (c - 0.5 * v), ramp_weights=weights)

    def covariance(self, theta: Floats) -> Floats:
        """Of the Allan variances, if θ is true.

        Without a ramp, a second difference is m²(β − 1) times the ramp's error and a remainder, with β = c/v; the
        remainder is taken as independent of the ramp's error, which it is on average over the record.
        """
        first, second = _pairs(len(theta))
        # Not @, which may start threads for this little.
        flat = np.einsum("k,kj->j", theta[first] * theta[second], self.noise.reshape(len(first), -1))
        total = np.asarray(flat.reshape(len(self.m), len(self.m)))
        if self.gaps is not None:
            total = _made_positive(total)
        if self.ramp_weights is None:
            return total
        slopes = np.einsum("p,pij->ij", theta, self.slopes)
        c = np.einsum("ij,j->i", slopes, self.ramp_weights)
        v = float(self.ramp_weights @ c)
        if v <= 0:
            return total
        squares, without = self.squares, total
        beta = c / v
        remainder = slopes - np.outer(c, c) / v
        for sign, share in ((-1.0, squares * beta), (1.0, squares * (beta - 1))):
            both = np.outer(share, share)
            ends = np.outer(beta if sign < 0 else beta - 1, beta if sign < 0 else beta - 1)
            total = total + sign * both * v * (0.5 * v * ends + remainder)
        return total if self.gaps is None else _covariance_or(total, without)

    def remove_ramp(self, avar: Floats, ramps: Floats, ramp: float) -> Floats:
        """Allan variances as they would be without a `ramp`: z − ramp·m² in place of z, squared and averaged."""
        return avar - ramp * self.squares * (ramps - 0.5 * ramp)

    def degrees_of_freedom(self, theta: Floats, *, ramp: float) -> Floats:
        """2·AVAR²/Var of every Allan variance, for θ and a ramp per sample."""
        drift = 0.5 * ramp * ramp * self.squares
        diagonals = np.diagonal(self.noise, axis1=1, axis2=2)
        variances = sum(
            theta[p] * theta[q] * diagonal
            for (p, q), diagonal in zip(pairs_of_terms(len(theta)), diagonals, strict=True)
        )
        variances = variances + (ramp * self.squares) ** 2 * (theta @ np.diagonal(self.slopes, axis1=1, axis2=2))
        return np.asarray(2 * (self.design @ theta + drift) ** 2 / variances)

    def skewness(self, weights: Floats, theta: Floats) -> tuple[float, float]:
        """Skewness and variance of Σ weights·AVAR by independent modes."""
        if self.powers is None:
            parts = np.einsum("j,jk->k", weights, self.gains) * np.einsum("p,pk->k", theta, self.spectra)
        else:
            parts = np.einsum("j,jk->k", weights, np.einsum("p,pjk->jk", theta, self.powers))
        squares = self.modes * parts * parts
        variance = 2 * float(squares.sum())
        return 8 * float(squares @ parts) / variance**1.5, variance


@functools.cache
def _pairs(n_terms: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The pairs p ≤ q of terms, in the order of `Components.noise`."""
    return np.triu_indices(n_terms)


@functools.lru_cache(maxsize=32)
def components(
    n: int,
    m: tuple[int, ...],
    *,
    correlation_time: float | None = None,
    frequency: float | None = None,
) -> Components:
    """The four linear terms and at most one more.

    Parameters
    ----------
    n : int
        Samples in the record.
    m : tuple of int
        Cluster sizes, increasing, at most n/2.
    correlation_time : float, optional
        Of a Gauss-Markov process, given by its variance. [samples]
    frequency : float, optional
        Of a sinusoid of random phase, given by its squared amplitude. [cycles per sample]
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


def with_sinusoid(linear: Components, frequency: float) -> Components:
    """Beside the linear terms, a sinusoid of random phase, given by its squared amplitude; frequency in cycles per sample.

    A line is no noise; it shows in the covariance only through the noise at its frequency.

    The squared amplitude that a record of n samples shows has the variance 8A²S(f)/n, S two-sided, and every Allan
    variance moves with it.
    """
    column = kernels.sinusoid_avar(1.0, frequency, linear.m, 1.0)
    sine = math.sin(math.pi * frequency)
    densities = (4 * sine**2, 1.0, 0.5 / sine, 0.25 / sine**2)
    outer = np.outer(column, column)
    zero = np.zeros_like(outer)
    matrices = iter(linear.noise)
    terms = len(LINEAR)
    noise = [
        next(matrices) if q < terms else (8 / linear.n * densities[p] * outer if p < terms else zero)
        for p, q in pairs_of_terms(terms + 1)
    ]
    return replace(
        linear,
        names=(*LINEAR, "sinusoid"),
        design=np.column_stack([linear.design, column]),
        noise=np.array(noise),
        slopes=np.concatenate([linear.slopes, zero[None]]),
        spectra=np.vstack([linear.spectra, np.zeros_like(linear.spectra[:1])]),
        powers=None if linear.powers is None else np.concatenate([linear.powers, np.zeros_like(linear.powers[:1])]),
    )


def _made_positive(matrix: Floats) -> Floats:
    """A matrix that should be a covariance; if it is none, with the least eigenvalues of its correlations raised.

    With gaps, what terms have in common at two averaging times is not known well enough where one of them rules alone that
    is hardly there.
    """
    root = np.sqrt(np.diag(matrix))
    correlation = matrix / np.outer(root, root)
    try:
        np.linalg.cholesky(correlation - _LEAST_EIGENVALUE * np.eye(len(root)))
    except np.linalg.LinAlgError:
        values, vectors = np.linalg.eigh(correlation)
        raised = (vectors * np.maximum(values, 2 * _LEAST_EIGENVALUE)) @ vectors.T
        root = root / np.sqrt(np.diag(raised))
        return np.asarray(raised * np.outer(root, root))
    return matrix


def _covariance_or(matrix: Floats, other: Floats) -> Floats:
    """A matrix that should be a covariance; if it is none, one with its variances and the correlations of another.

    With gaps, what a ramp takes along is not known well enough for trial values far from the fit.
    """
    try:
        np.linalg.cholesky(matrix / np.sqrt(np.outer(np.diag(other), np.diag(other))))
    except np.linalg.LinAlgError:
        share = np.sqrt(np.clip(np.diag(matrix) / np.diag(other), _LEAST_LEFT, None))
        return np.asarray(other * np.outer(share, share))
    return matrix


def pairs_of_terms(terms: int) -> list[tuple[int, int]]:
    """All p ≤ q, in the order of `Components.noise`."""
    return [(p, q) for p in range(terms) for q in range(p, terms)]


def _modes(n: int) -> tuple[Floats, Floats]:
    """Angles π k/n of modes of the discrete cosine transform, and how many modes each stands for."""
    low = np.arange(1, min(_LOW_MODES, n - 1) + 1)
    high = np.round(np.geomspace(_LOW_MODES + 1, n - 1, _HIGH_MODES)) if n - 1 > _LOW_MODES else np.empty(0)
    k = np.unique(np.concatenate([low, high]))
    edges = np.concatenate([[0.5], (k[1:] + k[:-1]) / 2, [n - 0.5]])
    return np.pi * k / n, np.diff(edges)
