"""Estimate and test of the rate ramp, a deterministic term with a sign, for given noise.

A rate random walk looks like a ramp of about K/√T: the test is whether the ramp of the record is larger than its noise
explains. The mean second difference at every averaging time is an estimate of the ramp; the covariance of these estimates is
known for any noise, and their weighted mean with the smallest variance is used. The noise is fitted to the variances after
the removal of that ramp, so that it does not contain the ramp with which it is compared.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.distributions import normal_quantile, student_below, student_quantile
from sigmatau.fitting.gls import Gls, relative_fit
from sigmatau.fitting.noise_fit import FittedTerm
from sigmatau.frozen import frozen

Floats = NDArray[np.float64]

_RIDGE = 1e-9  # added to correlations
_MOST_FREEDOM = 1e9
_LEAST_FREEDOM = 1.5
"""If the rate random walk is hardly known: then t = 6.2, which weak walks exceed in fewer than 5 % of records."""


@frozen(kw_only=False)
class Ramp:
    """Estimate of a ramp per sample."""

    value: float  # Estimate and standard error for the fitted noise
    error: float
    freedom: float  # Degrees of freedom of the squared error
    p_value: float  # Two-sided p-value of the ramp
    used: float  # The ramp removed from the Allan variances: the value, or 0 if it is not significant

    @property
    def suspicious(self) -> bool:
        """Whether the ramp would be significant if the noise were known exactly."""
        return abs(self.value) > 1.96 * self.error

    def stated(self, scale: float, tau0: float, *, unit: str, level: float) -> FittedTerm:
        """The term in SI, for data that were divided by a variance `scale`."""
        factor = math.sqrt(scale) / tau0
        half = float(student_quantile(self.freedom, 0.5 + level / 2)) * self.error
        low, high = (self.value - half) * factor, (self.value + half) * factor
        if self.p_value < 1 - level:
            return FittedTerm(
                term="rate_ramp", unit=unit, observed=True, level=level, p_value=self.p_value,
                value=self.value * factor, low=low, high=high,
            )  # fmt: skip
        return FittedTerm(
            term="rate_ramp", unit=unit, observed=False, level=level, p_value=self.p_value,
            upper_limit=max(abs(low), abs(high)),
        )  # fmt: skip


def estimate_ramp(gls: Gls, theta: Floats, ramps: Floats, *, level: float = 0.95) -> tuple[Ramp, Gls, Floats]:
    """The ramp, the least squares problem after its removal, and the θ of that problem. `theta`: its fit: the weights
    start from it if no better start is found; `ramps`: mean second differences over m².
    """
    parts = gls.parts
    # A fit without the ramp is useless if the ramp is large; a rough fit with a ramp is good enough for the weights.
    drift = 0.5 * parts.squares
    begin = relative_fit(np.column_stack([parts.design, drift]), gls.avar, np.full(len(drift), 0.1))[:-1]
    absent = [p for p in range(len(begin)) if p not in gls.candidates]
    begin[absent] = 0
    theta = begin if begin.any() else theta
    tangent = gls.tangent[:, 0] if gls.tangent.size else None
    for _ in range(2):
        weights = least_variance(np.einsum("p,pij->ij", theta, parts.slopes))
        value = float(weights @ ramps)
        still = Gls(parts.without_ramp(weights), parts.remove_ramp(gls.avar, ramps, value), gls.candidates, tangent)
        if still.avar.min() <= 0:
            raise FloatingPointError("the record is a ramp without noise")
        theta = still.fit()
    error, freedom = _error(still, theta, weights)
    p_value = 2 * float(student_below(freedom, -abs(value) / error))
    used = value if p_value < 1 - level else 0.0
    return Ramp(value, error, freedom, p_value, used), still, theta


def least_ramp(gls: Gls, theta: Floats, *, level: float, power: float) -> float:
    """The ramp per sample that the test finds with probability `power` in a record with noise θ."""
    parts = gls.parts
    weights = least_variance(np.einsum("p,pij->ij", theta, parts.slopes))
    still = Gls(parts.without_ramp(weights), gls.avar, gls.candidates)
    error, freedom = _error(still, theta, weights)
    return float((student_quantile(freedom, 0.5 + level / 2) + normal_quantile(power)) * error)


def _error(still: Gls, theta: Floats, weights: Floats) -> tuple[float, float]:
    """Standard error of the ramp for θ, and the degrees of freedom of its square, from the covariance of θ."""
    by_term = np.einsum("i,pij,j->p", weights, still.parts.slopes, weights)
    variance = float(by_term @ theta)
    terms = list(still.candidates)
    scatter = float(by_term[terms] @ still.covariance_of_theta(theta, terms) @ by_term[terms])
    freedom = 2 * variance**2 / scatter if scatter > 0 else _MOST_FREEDOM
    return math.sqrt(variance), min(max(freedom, _LEAST_FREEDOM), _MOST_FREEDOM)


def least_variance(covariance: Floats) -> Floats:
    """Weights with sum 1 and the smallest variance of the weighted mean."""
    if not covariance.diagonal().min() > 0:
        raise FloatingPointError("there is no noise with which a ramp can be compared")
    sd = np.sqrt(covariance.diagonal())
    correlation = covariance / np.outer(sd, sd)
    correlation.flat[:: len(sd) + 1] += _RIDGE
    solved = np.linalg.solve(correlation, 1 / sd) / sd
    return np.asarray(solved / solved.sum())
