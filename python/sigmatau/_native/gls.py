"""Compiled least squares on Allan variances. Times are in samples; θ are squared coefficients of samples."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from sigmatau import _core
from sigmatau._core import CurveFit as CurveFit
from sigmatau._core import fit_curve as fit_curve
from sigmatau.arrays import Floats


class Components:
    """The four noise terms and at most one process, at the cluster sizes `m` of a record of `n` samples.

    Parameters
    ----------
    correlation_time : float, optional
        Correlation time of a Gauss-Markov process, whose θ is the variance. [samples]
    frequency : float, optional
        Frequency of a sinusoid of random phase, in place of a process; its θ is the squared amplitude. [cycles per
        sample]
    """

    __slots__ = ("_native", "m", "n", "terms")

    def __init__(
        self, n: int, m: Sequence[int], *, correlation_time: float | None = None, frequency: float | None = None
    ) -> None:
        self.n, self.m = n, np.array(m, dtype=np.int64)
        self.terms = 4 if correlation_time is None and frequency is None else 5
        self._native = _core.GlsComponents(n, self.m, correlation_time, frequency)

    @property
    def design(self) -> Floats:
        """Expected Allan variances for θ = 1, shape (n_tau, n_terms)."""
        return self._native.design().reshape(self.terms, -1).T

    @property
    def slopes(self) -> Floats:
        """Covariance, for θ = 1, of the ramps estimated from the mean second differences: (n_terms, n_tau, n_tau)."""
        return self._native.slopes().reshape(self.terms, len(self.m), len(self.m))

    @property
    def spectra(self) -> Floats:
        """Power of a mode of the record for θ = 1, divided by n; shape (n_terms, n_modes)."""
        return self._native.spectra().reshape(self.terms, -1)

    @property
    def modes(self) -> Floats:
        """Number of modes of the record that each computed mode represents, shape (n_modes,)."""
        return self._native.modes()

    def covariance(self, theta: ArrayLike) -> Floats:
        """Covariance of the Allan variances, if θ is true."""
        return Gls(self, np.ones(len(self.m))).covariance(theta)

    def degrees_of_freedom(self, theta: ArrayLike, *, ramp: float) -> Floats:
        """Degrees of freedom of every Allan variance, 2·AVAR²/Var, for θ and a ramp per sample."""
        return self._native.degrees_of_freedom(_numbers(theta), ramp)

    def detectable(self, term: int, background: ArrayLike, *, level: float, power: float) -> float:
        """Smallest θ of a term that a test at `level` detects with probability `power` in a background; inf if none."""
        return self._native.detectable(term, _numbers(background), level, power)

    def least_ramp(self, theta: ArrayLike, *, level: float, power: float) -> float:
        """The ramp per sample that a test at `level` detects with probability `power` in noise θ."""
        return self._native.least_ramp(_numbers(theta), level, power)


class Gls:
    """Least squares problem: Allan variances and their components. `candidates` are the indices of the fitted terms.

    Methods raise FloatingPointError if a covariance is not positive definite.
    """

    __slots__ = ("_native", "candidates", "parts")

    def __init__(self, parts: Components, avar: ArrayLike, candidates: Sequence[int] | None = None) -> None:
        self.parts = parts
        self.candidates = tuple(range(parts.terms) if candidates is None else candidates)
        values = np.ascontiguousarray(avar, dtype=np.float64)
        self._native = _core.Gls(parts._native, values, list(self.candidates))

    @property
    def avar(self) -> Floats:
        """The Allan variances; without the ramp, if it was removed."""
        return self._native.avar

    def expected(self, theta: ArrayLike) -> Floats:
        """The variances expected for θ."""
        return self._native.expected(_numbers(theta))

    def covariance(self, theta: ArrayLike) -> Floats:
        """Covariance of the variances, if θ is true."""
        return self._native.covariance(_numbers(theta)).reshape(len(self.parts.m), -1)

    def fit(self, active: Sequence[int] | None = None, *, start: ArrayLike | None = None) -> Floats:
        """Non-negative θ of the active terms (default: all candidates); the others are 0."""
        begin = None if start is None else _numbers(start)
        return np.array(self._native.fit(None if active is None else list(active), begin))

    def covariance_of_theta(self, theta: ArrayLike, active: Sequence[int]) -> Floats:
        """Covariance of unconstrained estimates of the active terms, if θ is true."""
        return self._native.covariance_of_theta(_numbers(theta), list(active)).reshape(len(active), -1)

    def score(self, term: int, trial: float) -> tuple[float, float, float, Floats]:
        """Distribution of the estimate of a term if a trial value is true and the other terms are fitted for that
        value.

        Returns the probability of a larger estimate, its standard error and skewness, and the weights of the variances
        in it.
        """
        return self._native.score(term, trial)

    def evidence(self, term: int, theta: ArrayLike, *, level: float) -> tuple[float, float, float]:
        """P-value of a term and the interval of its θ. `theta`: the fit with all terms."""
        return self._native.evidence(term, _numbers(theta), level)

    def p_value(self, theta: ArrayLike) -> float:
        """P-value of the goodness of fit."""
        return self._native.p_value(_numbers(theta))

    def deviance(self, theta: ArrayLike) -> float:
        """−2 ln of the probability density of the variances at the octaves, apart from a constant."""
        return self._native.deviance(_numbers(theta))

    def ramp_weights(self, theta: ArrayLike) -> Floats:
        """Weights of the ramps of all sizes, with sum 1 and the smallest variance of the weighted mean, for noise θ."""
        return self._native.ramp_weights(_numbers(theta))

    def without_ramp(self, weights: Floats, ramps: Floats) -> Gls:
        """The problem after the removal of the ramp Σ weights·ramps."""
        detrended = object.__new__(Gls)
        detrended.parts, detrended.candidates = self.parts, self.candidates
        detrended._native = self._native.without_ramp(np.ascontiguousarray(weights), np.ascontiguousarray(ramps))
        return detrended


def non_negative(columns: Floats, target: Floats) -> Floats:
    """Non-negative coefficients x with the smallest ‖columns·x − target‖, for at most six columns."""
    return _core.non_negative(np.ascontiguousarray(columns.T).ravel(), np.ascontiguousarray(target))


def _numbers(theta: ArrayLike) -> list[float]:
    return [float(x) for x in np.asarray(theta, dtype=np.float64)]
