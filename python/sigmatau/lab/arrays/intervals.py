"""Intervals of variances and correlations that were estimated by a likelihood or from clusters.

An estimate with the relative variance 2/ν is treated as that of ν independent squares (Satterthwaite): a variance has the
interval of χ², and a correlation r that of the ratio (1 + r)/(1 − r), which has the F distribution for equal variances.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from sigmatau._native.distributions import gamma_quantile, normal_quantile, student_below, student_quantile
from sigmatau.arrays import Floats
from sigmatau.frozen import frozen
from sigmatau.lab.arrays.covariance_fit import CovarianceFit, Profile
from sigmatau.results import plain

# Degrees of freedom above which the interval of a variance is that of χ²; below, it is read off the profile of the
# likelihood. Hats need more, because their variances are differences and do not follow χ². [1] Study: arrays.md.
_CHI2_FREEDOM, _CHI2_FREEDOM_OF_HATS = 30.0, 300.0
_SEARCH_STEPS = 40  # largest number of steps of a search for the end of a profile; 10 are usual
_TOLERANCE = 0.02  # relative error of √loss at the end of a profile. [1] Judgement: below the printed digits


@frozen
class Estimate:
    """A value with its interval, or the upper limit of a value that is not significant.

    Attributes
    ----------
    value : float or None
        None if it is not observed. [unit]
    low, high : float or None
        Its interval. [unit]
    upper_limit : float or None
        Limit of a value that is not observed. [unit]
    unit : str
        SI; ``"1"`` for numbers without unit.
    """

    value: float | None
    low: float | None = None
    high: float | None = None
    upper_limit: float | None = None
    unit: str = "1"

    @property
    def observed(self) -> bool:
        """Whether there is a value."""
        return self.value is not None

    def to_dict(self) -> dict[str, object]:
        """Plain values in SI; unknown values are omitted."""
        content = plain(self, "value low high upper_limit")
        return {key: number for key, number in content.items() if number is not None} | {"unit": self.unit}


def satterthwaite(variance: float, error: float) -> float:
    """Degrees of freedom of a variance with a standard error."""
    return 2 * variance**2 / error**2 if error > 0 else math.inf


def variance_interval(variance: ArrayLike, freedom: ArrayLike, level: float) -> tuple[Floats, Floats]:
    """Interval of variances with degrees of freedom, by χ². [unit of the variance]"""
    half = np.maximum(np.asarray(freedom, dtype=float), 1e-3) / 2
    low, high = (half / gamma_quantile(half, 0.5 + side * level / 2) for side in (1, -1))
    return np.asarray(np.multiply(variance, low)), np.asarray(np.multiply(variance, high))


def correlation_interval(correlation: ArrayLike, freedom: ArrayLike, level: float) -> tuple[Floats, Floats]:
    """Interval of correlations with degrees of freedom; −1 to 1 for two or fewer."""
    r = np.clip(np.asarray(correlation, dtype=float), -1.0, 1.0)
    nu = np.asarray(freedom, dtype=float) - 1
    enough = np.maximum(nu, 1.0)
    t = student_quantile(enough, 0.5 + level / 2) / np.sqrt(enough)
    root = t + np.sqrt(1 + t**2)  # root of the quantile of F with ν and ν degrees of freedom
    with np.errstate(divide="ignore"):
        ratio = np.sqrt((1 + r) / (1 - r))
    low, high = (1 - 2 / (1 + (ratio * factor) ** 2) for factor in (1 / root, root))
    return np.where(nu > 1, low, -1.0), np.where(nu > 1, high, 1.0)


def difference_interval(
    first: Floats, first_interval: tuple[Floats, Floats], second: Floats, second_interval: tuple[Floats, Floats]
) -> tuple[Floats, Floats]:
    """Interval of the difference of two independent variances, from their intervals; G. Y. Zou, :doi:`10.1002/sim.3095`."""
    below = np.sqrt((first - first_interval[0]) ** 2 + (second_interval[1] - second) ** 2)
    above = np.sqrt((first_interval[1] - first) ** 2 + (second - second_interval[0]) ** 2)
    return first - second - below, first - second + above


def variance_estimate(fit: CovarianceFit, t: int, p: int, *, level: float, widening: float, unit: str) -> Estimate:
    """The coefficient of a component, which is the root of its variance, with its interval; or its upper limit.

    `p`: index of a channel, or of a parameter of a structure without matrices. `widening`: factor on standard errors.
    """
    index = p * (p + 3) // 2 if fit.structure.semidefinite else p  # place of the diagonal element in the lower triangle
    value = float(fit.theta[t, index])
    error = widening * math.sqrt(max(float(fit.component_covariance(t)[index, index]), 0.0))
    nu = satterthwaite(value, error)
    if nu > (_CHI2_FREEDOM if fit.structure.semidefinite else _CHI2_FREEDOM_OF_HATS):
        ends = [float(end) for end in variance_interval(value, nu, level)]
        return Estimate(value=math.sqrt(value), low=math.sqrt(ends[0]), high=math.sqrt(ends[1]), unit=unit)

    curve = Profile(fit, t, p)

    def loss(variance: float) -> float:
        return curve.loss(variance) / widening**2

    threshold = float(normal_quantile(0.5 + level / 2)) ** 2
    if loss(0.0) < threshold:
        limit = _crossing(loss, value, value + 2 * error, float(normal_quantile(level)) ** 2)
        return Estimate(value=None, upper_limit=math.sqrt(limit), unit=unit)
    low = _crossing(loss, value, max(value - 2 * error, 0.1 * value), threshold)
    high = _crossing(loss, value, value + 2.5 * error, threshold)
    return Estimate(value=math.sqrt(value), low=math.sqrt(low), high=math.sqrt(high), unit=unit)


def _crossing(loss: Callable[[float], float], start: float, guess: float, threshold: float) -> float:
    """Search from `start` in the direction of `guess` for the value at which the loss reaches a threshold.

    The secant method is applied to √loss, which is nearly linear.
    """
    target = math.sqrt(threshold)
    inner, inner_root = start, 0.0
    outer, outer_root = guess, 0.0
    for _ in range(_SEARCH_STEPS):
        outer_root = math.sqrt(max(loss(outer), 0.0))
        if outer_root >= target:
            break
        inner, inner_root = outer, outer_root
        outer = outer + 1.5 * abs(outer - start) if guess > start else 0.5 * outer
    for _ in range(_SEARCH_STEPS):
        share = (target - inner_root) / max(outer_root - inner_root, 1e-12)
        new = inner + min(max(share, 0.02), 0.98) * (outer - inner)
        root = math.sqrt(max(loss(new), 0.0))
        if abs(root - target) < _TOLERANCE * target:
            return new
        if root < target:
            inner, inner_root = new, root
        else:
            outer, outer_root = new, root
    return outer


@frozen
class Correlation(Estimate):
    """Correlation of a noise component in two sensors.

    Attributes
    ----------
    value : float or None
        None if the component is too weak in either sensor. [1]
    low, high : float or None
        Its interval. [1]
    upper_limit : float or None
        1 if there is no value. [1]
    unit : str
        ``"1"``
    p_value : float or None
        Probability that independent sensors show a correlation of this size or larger. [1]
    correlated : bool
        Whether it is significant among all pairs and components of the array (Holm, 5 %).
    """

    p_value: float | None = None
    correlated: bool = False

    def to_dict(self) -> dict[str, object]:
        """Plain values; unknown values are omitted."""
        extra = {} if self.p_value is None else {"p_value": self.p_value}
        return {**Estimate.to_dict(self), **extra, "correlated": self.correlated}


def correlation_estimate(fit: CovarianceFit, t: int, i: int, j: int, *, level: float, widening: float) -> Correlation:
    """Correlation of a component in two channels, with its interval and its p-value."""
    r, error = correlation_error(fit, t, i, j)
    nu = max((1 - r**2) ** 2 / max(widening * error, 1e-12) ** 2 - 1, 1e-3)
    low, high = correlation_interval(r, nu + 1, level)
    size = abs(r) * math.sqrt(nu / max(1 - r**2, 1e-12))
    p_value = 2 * float(student_below(nu, -size))
    return Correlation(value=r, low=float(low), high=float(high), p_value=p_value)


def correlation_error(fit: CovarianceFit, t: int, i: int, j: int) -> tuple[float, float]:
    """Correlation of a component in two channels, and its standard error by the Fisher information."""
    matrix = fit.matrices[t]
    size = math.sqrt(matrix[i, i] * matrix[j, j])
    r = float(matrix[i, j] / size)
    gradient = np.zeros(fit.theta.shape[1])
    a, b = max(i, j), min(i, j)
    gradient[a * (a + 1) // 2 + b] = 1 / size
    gradient[i * (i + 3) // 2] = -r / (2 * matrix[i, i])
    gradient[j * (j + 3) // 2] = -r / (2 * matrix[j, j])
    return r, math.sqrt(max(float(gradient @ fit.component_covariance(t) @ gradient), 0.0))
