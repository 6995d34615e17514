"""Effect of time on a coefficient: a robust regression in which upper limits are censored values.

The model is y = a + b·x + σ·e, where e follows Student's t distribution with four degrees of freedom, so that outliers have
little weight [1]_. An upper limit contributes the probability that y is below it [2]_. The standard error is
that of Huber's M-estimators [3]_, which is valid for normal errors too.

References
----------
.. [1] K. L. Lange, R. J. A. Little, J. M. G. Taylor, "Robust statistical modeling using the t distribution," J. Am. Stat.
   Assoc., vol. 84, 1989, :doi:`10.1080/01621459.1989.10478852`.
.. [2] J. Tobin, "Estimation of relationships for limited dependent variables," Econometrica, vol. 26, 1958,
   :doi:`10.2307/1907382`.
.. [3] P. J. Huber, E. M. Ronchetti, Robust Statistics, 2nd ed., Wiley, 2009, section 7.6.
.. [4] S. Heritier, E. Ronchetti, "Robust bounded-influence tests in general parametric models," J. Am. Stat. Assoc.,
   vol. 89, 1994, :doi:`10.1080/01621459.1994.10476822`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from sigmatau._native.distributions import student_below, student_quantile
from sigmatau.arrays import SIGMA_OF_MAD, Bools, Floats
from sigmatau.frozen import frozen

_FREEDOM = 4.0  # degrees of freedom of the errors: the efficiency for normal errors is then 93 %
_ROUNDS = 200  # largest number of iterations
_PRECISION = 1e-6  # change of a coefficient, in standard deviations, at which the iteration ends
_LEAST_PROBABILITY = 1e-12  # smallest probability of a value below its limit, so that its logarithm is finite
_LEAST_WEIGHT = 1e-6  # smallest weight of an upper limit [1]
_LARGEST_RATIO = 2.0  # largest ratio of the variances of two rounds [1]


@frozen(eq=False)
class Effects:
    """Effects of several shapes x, each of which is fitted without the others.

    Attributes
    ----------
    value, error : ndarray, shape (m,)
        Coefficient of each x, and its standard error; NaN if it cannot be estimated.
    start : ndarray, shape (m,)
        Value at x = 0.
    likelihood : ndarray, shape (m,)
        Log-likelihood without a constant, scaled so that twice a difference is about χ² also for normal errors [4]_.
    freedom : int
        Degrees of freedom: number of values minus two.
    """

    value: Floats
    error: Floats
    start: Floats
    likelihood: Floats
    freedom: int

    @property
    def p_value(self) -> Floats:
        """Two-sided p-value of no effect, shape (m,)."""
        with np.errstate(invalid="ignore", divide="ignore"):
            ratio = -np.abs(self.value / self.error)
        return np.asarray(np.minimum(2 * student_below(self.freedom, ratio), 1.0), dtype=np.float64)

    def interval(self, level: float) -> tuple[Floats, Floats]:
        """Ends of the interval of each effect.

        Parameters
        ----------
        level : float
            Confidence level.

        Returns
        -------
        low, high : ndarray, shape (m,)
        """
        half = float(student_quantile(self.freedom, (1 + level) / 2)) * self.error
        return self.value - half, self.value + half


def estimate_effects(x: ArrayLike, y: Floats, limited: Bools | None = None) -> Effects:
    """Estimate the effect of each row of x on y.

    Parameters
    ----------
    x : array_like, shape (n,) or (m, n)
        Time, or shapes such as a step; each row is one regression.
    y : ndarray, shape (n,)
        Values, or upper limits.
    limited : ndarray of bool, shape (n,), optional
        Which of y are upper limits. Default: none.

    Returns
    -------
    Effects
    """
    shapes = np.atleast_2d(np.asarray(x, dtype=np.float64))
    limits = np.zeros(len(y), dtype=bool) if limited is None else limited
    values = int((~limits).sum())
    unknown = np.full(len(shapes), np.nan)
    if values < 3:
        return Effects(value=unknown, error=unknown, start=unknown, likelihood=unknown, freedom=max(values - 2, 1))
    middle = shapes.mean(axis=1, keepdims=True)
    centered = shapes - middle
    size = np.sqrt((centered**2).mean(axis=1, keepdims=True))
    varies = size[:, 0] > 0
    scaled = np.where(size > 0, centered / np.where(size > 0, size, 1.0), 0.0)
    location, slope, sigma = _iterate(scaled, y, limits)
    u = (y - location - slope * scaled) / sigma
    error = _standard_error(u, limits) * sigma[:, 0]
    value = np.where(varies, slope[:, 0] / np.where(varies, size[:, 0], 1.0), np.nan)
    error = np.where(varies, error / np.where(varies, size[:, 0], 1.0), np.nan)
    return Effects(
        value=value,
        error=error,
        start=location[:, 0] - value * middle[:, 0],
        likelihood=_likelihood(u, sigma[:, 0], limits),
        freedom=values - 2,
    )


def _iterate(scaled: Floats, y: Floats, limits: Bools) -> tuple[Floats, Floats, Floats]:
    """Location, slope and scale of each shape, (m, 1) each, by reweighted least squares."""
    rows = (len(scaled), 1)
    center = float(np.median(y))
    spread = SIGMA_OF_MAD * float(np.median(np.abs(y - center))) or float(np.std(y)) or 1.0
    location, slope, sigma = np.full(rows, center), np.zeros(rows), np.full(rows, spread)
    values = int((~limits).sum())
    for _ in range(_ROUNDS):
        u = (y - location - slope * scaled) / sigma
        score, weight, _ = _scores(u, limits)
        total, first = weight.sum(axis=1, keepdims=True), (weight * scaled).sum(axis=1, keepdims=True)
        second = (weight * scaled**2).sum(axis=1, keepdims=True)
        to_location = score.sum(axis=1, keepdims=True)
        to_slope = (score * scaled).sum(axis=1, keepdims=True)
        determinant = np.maximum(total * second - first**2, 1e-12 * total**2)
        step = (second * to_location - first * to_slope) / determinant
        turn = (total * to_slope - first * to_location) / determinant
        turn = np.where(np.any(scaled != 0, axis=1, keepdims=True), turn, 0.0)
        location, slope = location + sigma * step, slope + sigma * turn
        ratio = np.clip((score * u).sum(axis=1, keepdims=True) / values, 1 / _LARGEST_RATIO, _LARGEST_RATIO)
        sigma = np.maximum(sigma * np.sqrt(ratio), 1e-12 * spread)
        if max(float(np.abs(step).max()), float(np.abs(turn).max()), float(np.abs(ratio - 1).max())) < _PRECISION:
            break
    return location, slope, sigma


def _scores(u: Floats, limits: Bools) -> tuple[Floats, Floats, Floats]:
    """Score, weight in the next round, and derivative of the score, for each residual."""
    score = (_FREEDOM + 1) * u / (_FREEDOM + u**2)
    weight = (_FREEDOM + 1) / (_FREEDOM + u**2)
    slope = (_FREEDOM + 1) * (_FREEDOM - u**2) / (_FREEDOM + u**2) ** 2
    if limits.any():
        inner = 1 + u[:, limits] ** 2 / _FREEDOM
        ratio = 0.375 * inner**-2.5 / _probability_below(u[:, limits])
        score[:, limits] = -ratio
        slope[:, limits] = ratio * (ratio + 1.25 * u[:, limits] / inner)
        weight[:, limits] = np.maximum(slope[:, limits], _LEAST_WEIGHT)
    return score, weight, slope


def _probability_below(u: Floats) -> Floats:
    """Probability that an error is below u: Student's distribution with four degrees of freedom in closed form."""
    part = u / np.sqrt(1 + u**2 / _FREEDOM)
    return np.maximum(0.5 + 0.375 * part * (1 - part**2 / 12), _LEAST_PROBABILITY)


def _standard_error(u: Floats, limits: Bools) -> Floats:
    """Standard error of each slope, divided by the scale, for columns of x with mean 0 and variance 1."""
    n = len(limits)
    score, _, slope = _scores(u, limits)
    mean = slope.mean(axis=1)
    variance = (score**2).sum(axis=1) / max(n - 2, 1)
    factor = 1 + 2 / n * slope.var(axis=1) / np.maximum(mean**2, 1e-12)
    return np.asarray(factor * np.sqrt(variance) / np.maximum(mean, 1e-12) / np.sqrt(n), dtype=np.float64)


def _likelihood(u: Floats, sigma: Floats, limits: Bools) -> Floats:
    """Log-likelihood of each shape, times the ratio of information to variance of the score for the best shape."""
    values = ~limits
    logs = -(_FREEDOM + 1) / 2 * np.log1p(u[:, values] ** 2 / _FREEDOM) - np.log(sigma)[:, None]
    total = logs.sum(axis=1) + np.log(_probability_below(u[:, limits])).sum(axis=1)
    best = [int(np.argmax(total))]
    score, _, slope = _scores(u[best], limits)
    return np.asarray(total * max(float(slope.mean()), 0.0) / float((score**2).mean()), dtype=np.float64)
