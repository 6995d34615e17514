"""Exact likelihood of a short record, by the dense covariance of its samples: slow, without approximations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["TERMS", "Exact", "ExactFit"]

Floats = NDArray[np.float64]

TERMS = ("quantization", "random_walk", "bias_instability", "rate_random_walk")

_STEPS = 50
_STEP_TOLERANCE = 1e-3  # [standard errors] a hundredth of the tolerance of the comparison
_SHORTEST = 1e-3  # shortest step, over the full step
_MIN_SHARE = 0.3  # smallest share of a coefficient after a step


@dataclass(frozen=True)
class ExactFit:
    """Maximum of the restricted likelihood, for squared coefficients."""

    terms: tuple[str, ...]
    theta: Floats
    covariance: Floats  # inverse of the expected information
    deviance: float

    @property
    def errors(self) -> Floats:
        """Standard errors of `theta`."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))


class Exact:
    """Sampled rates of n points: white noise, flicker noise, random walk, quantization of the angle.

    Samples are replaced by their n − 1 contrasts with consecutive means (Helmert), which do not depend on a constant
    rate. Only variograms γ(d) = E (y(t + d) − y(t))²/2 are then needed, and no variance is infinite.
    """

    def __init__(self, n: int, tau0: float) -> None:
        self.contrasts = _helmert(n)
        lag = np.arange(n)
        odd = np.concatenate([[0.0], np.cumsum(1 / (2.0 * np.arange(1, n) - 1))])
        # Variograms for unit coefficients. Flicker: γ(d) = ∫ S (1 − cos 2πf d τ₀) df with S = τ₀/(2 sin πf τ₀) is twice
        # the sum of the first d odd harmonics over π. Quantization: the difference of white angles, Q²(2, −1)/τ₀².
        variograms = {
            "quantization": np.where(lag == 0, 0.0, np.where(lag == 1, 3.0, 2.0)) / tau0**2,
            "random_walk": np.where(lag == 0, 0.0, 1.0) / tau0,
            "bias_instability": 2 / np.pi * odd,
            "rate_random_walk": 0.5 * lag * tau0,
        }
        distance = np.abs(lag[:, None] - lag)
        self.parts = {
            name: self.contrasts @ -variogram[distance] @ self.contrasts.T for name, variogram in variograms.items()
        }

    def information(self, terms: tuple[str, ...], theta: Floats) -> Floats:
        """Expected information of squared coefficients."""
        inverse = np.linalg.inv(self._covariance(terms, theta))
        products = [inverse @ self.parts[name] for name in terms]
        return np.array([[np.sum(a * b.T) / 2 for b in products] for a in products])

    def fit(
        self, y: Floats, terms: tuple[str, ...], start: Floats, information: Floats, *, held: int | None = None
    ) -> ExactFit:
        """Maximise by scoring from squared coefficients, with the information at the start; `held`: index of a fixed
        coefficient.
        """
        z = self.contrasts @ y
        theta = np.array(start, dtype=float)
        free = [k for k in range(len(terms)) if k != held]
        covariance = np.linalg.inv(information[np.ix_(free, free)])
        errors = np.sqrt(np.diag(covariance))
        deviance, gradient = self._slope(z, terms, theta)
        for _ in range(_STEPS):
            step = covariance @ gradient[free]
            if np.abs(step / errors).max() < _STEP_TOLERANCE:
                break
            length = 1.0
            while True:
                tried = theta.copy()
                tried[free] = np.maximum(theta[free] + length * step, _MIN_SHARE * theta[free])
                lower, slope = self._slope(z, terms, tried)
                if lower <= deviance + 1e-9 or length < _SHORTEST:
                    break
                length *= 0.5
            theta, deviance, gradient = tried, lower, slope
        return ExactFit(tuple(terms), theta, np.asarray(covariance, dtype=np.float64), deviance)

    def _covariance(self, terms: tuple[str, ...], theta: Floats) -> Floats:
        return np.asarray(sum(t * self.parts[name] for t, name in zip(theta, terms, strict=True)))

    def _slope(self, z: Floats, terms: tuple[str, ...], theta: Floats) -> tuple[float, Floats]:
        """Deviance, and gradient of the logarithm of the likelihood."""
        from scipy.linalg import lapack

        factor, failed = lapack.dpotrf(self._covariance(terms, theta), lower=1)
        if failed:
            raise ArithmeticError("the covariance is not positive")
        deviance = 2 * np.log(np.diag(factor)).sum()
        inverse, _ = lapack.dpotri(factor, lower=1)
        inverse = np.tril(inverse) + np.tril(inverse, -1).T
        u = inverse @ z
        gradient = [(u @ self.parts[name] @ u - np.sum(inverse * self.parts[name])) / 2 for name in terms]
        return float(deviance + z @ u), np.array(gradient)


def _helmert(n: int) -> Floats:
    """Orthonormal contrasts: each sample minus the mean of the previous samples."""
    rows = np.tril(np.ones((n, n)), -1)[1:]
    k = np.arange(1, n)
    rows[k - 1, k] = -k
    return rows / np.sqrt(k * (k + 1.0))[:, None]
