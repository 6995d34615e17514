"""The generalised method of wavelet moments, written from its definition without the fits of the package.

S. Guerrier, J. Skaloud, Y. Stebler, M.-P. Victoria-Feser, "Wavelet-variance-based estimation for composite stochastic
processes," J. Am. Stat. Assoc. 108, 2013, doi 10.1080/01621459.2013.799920. The estimate minimises (ν̂ − ν(θ))ᵀ Ω (ν̂ − ν(θ)),
where ν̂ are the Haar wavelet variances of the octaves, and Ω is the inverse of their covariance. The covariance is that of
long records at the estimate of the step before (A. Serroukh, A. T. Walden, D. B. Percival, J. Am. Stat. Assoc. 95, 2000, doi
10.1080/01621459.2000.10473913); Ω of the first step is diagonal.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

Floats = NDArray[np.float64]

_STEPS = 3  # estimates with the covariance at the estimate before
_LONGEST_SHARE = 4  # samples of the record over those of the longest half of a wavelet
_POINTS = 16_000  # frequencies of the integral of the covariance
_LOWEST = 1e-4  # lowest frequency, over that of one cycle per record


def wavelet_variances(x: Floats, halves: Sequence[int]) -> Floats:
    """Variances of the Haar coefficients of all shifts (MODWT): half the difference of two neighbouring means."""
    sums = np.concatenate([[0.0], np.cumsum(x - x.mean())])
    found = []
    for n in halves:
        coefficients = (sums[2 * n :] - 2 * sums[n:-n] + sums[: -2 * n]) / (2 * n)
        found.append(np.mean(coefficients**2))
    return np.array(found)


def expected_variances(term: str, halves: Floats, tau0: float) -> Floats:
    """Wavelet variance of a term with the coefficient 1, half of its Allan variance; of the sampled processes."""
    n = np.asarray(halves, dtype=float)
    tau = n * tau0
    if term == "quantization":
        return 1.5 / tau**2
    if term == "random_walk":
        return 0.5 / tau
    if term == "rate_random_walk":
        return tau / 6 * (1 + 0.5 / n**2)
    # Filtered white noise (1 − z⁻¹)^(−1/2): sums of odd harmonics h, see docs/theory/bias-instability.md.
    double = np.array([_twice_summed(int(k)) - _twice_summed(int(2 * k)) / 4 for k in n])
    return double / (math.pi * n**2)


def _twice_summed(l: int) -> float:  # noqa: E741  the lag
    """A function whose second difference is −4 Σ 1/(2j − 1), j = 1 … l."""
    if l == 0:
        return 0.0
    odd = (math.log(l - 1) + np.euler_gamma) / 2 + math.log(2) + 1 / (48 * (l - 1) ** 2) if l > _EXACT else _odd(l - 1)
    return -(4 * l * l - 1) / 2 * odd + 2 * l * (l - 1) - (l - 1) ** 2 / 2


_EXACT = 10_000  # lag above which the sum is its asymptotic series, to 1e-17


@functools.cache
def _odd(count: int) -> float:
    return float(np.sum(1 / (2 * np.arange(1, count + 1) - 1)))


def _density(term: str, f: Floats, tau0: float) -> Floats:
    """Two-sided density of the samples, f in cycles per sample."""
    sine = 2 * np.sin(np.pi * f)
    if term == "quantization":
        return sine**2 / tau0
    power = {"random_walk": 0, "bias_instability": 1, "rate_random_walk": 2}[term]
    return (tau0 / sine) ** power


@functools.cache
def _grid(samples: int, halves: tuple[int, ...]) -> tuple[Floats, Floats, Floats]:
    """Frequencies, evenly spaced in the logarithm, their widths, and the squared gains of the wavelets."""
    edges = np.geomspace(_LOWEST / samples, 0.5, _POINTS + 1)
    f = np.sqrt(edges[1:] * edges[:-1])
    gains = np.stack([np.sin(np.pi * f * n) ** 4 / (n * np.sin(np.pi * f)) ** 2 for n in halves])
    return f, np.diff(edges), gains


def _covariance(density: Floats, samples: int, halves: tuple[int, ...], tau0: float) -> Floats:
    """Covariance of the variances, 2/M ∫ Gᵢ Gⱼ S² df over both signs of f; M shifts of the shorter wavelet."""
    _, widths, gains = _grid(samples, halves)
    weighted = gains * (density / tau0)
    integral = 2 * (weighted * widths) @ weighted.T
    count = samples - 2 * np.array(halves) + 1
    return np.asarray(2 * integral / np.maximum.outer(count, count))


def gmwm(x: Floats, terms: Sequence[str], tau0: float) -> dict[str, float]:
    """Coefficients of the terms of a record, 0 or more. [SI]"""
    halves = tuple(2**j for j in range(int(math.log2(len(x) // _LONGEST_SHARE)) + 1))
    measured = wavelet_variances(x, halves)
    design = np.stack([expected_variances(term, np.array(halves), tau0) for term in terms], axis=1)
    f, _, _ = _grid(len(x), halves)
    densities = np.stack([_density(term, f, tau0) for term in terms], axis=1)
    theta = _least_squares(design, measured, np.diag(measured**2))
    for _ in range(_STEPS):
        theta = _least_squares(design, measured, _covariance(densities @ theta, len(x), halves, tau0))
    return dict(zip(terms, np.sqrt(theta).tolist(), strict=True))


def _least_squares(design: Floats, measured: Floats, covariance: Floats) -> Floats:
    scale = np.sqrt(np.diag(covariance))
    root = np.linalg.cholesky(covariance / np.outer(scale, scale))
    columns = np.linalg.solve(root, design / scale[:, None])
    size = np.linalg.norm(columns, axis=0)
    solution, _ = nnls(columns / size, np.linalg.solve(root, measured / scale))
    return np.asarray(solution / size)
