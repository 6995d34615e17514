"""Tests, intervals and detection limits of single terms.

All of them use one statistic: the unconstrained estimate of a squared coefficient θ minus a trial value, over its
standard error if the trial value is true, with every other term fitted for that value (`Gls.score` in
`sigmatau.fitting.gls`). Its distribution is skewed if few independent stretches of the record determine the term. It is
approximated by Pearson's type III, the distribution of a χ², with the mean, variance and skewness of the model.

A value belongs to the interval if the statistic is not in the tails of its distribution. The probability 1 − level is
divided between the tails as in G. J. Feldman and R. D. Cousins, Phys. Rev. D 57, 3873 (1998),
:doi:`10.1103/PhysRevD.57.3873`: all of it is in the upper tail for a value of 0, half of it in each tail for values well
above their error. The interval therefore excludes 0 exactly if the test finds the term, and has the same coverage whether
the term is found or not.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.distributions import (
    gamma_above,
    gamma_below,
    gamma_quantile,
    gamma_quantile_above,
    normal_below,
    normal_quantile,
)
from sigmatau.fitting.gls import Gls, Score
from sigmatau.fitting.roots import root
from sigmatau.frozen import frozen

Floats = NDArray[np.float64]

_SMALLEST_PROBABILITY = 1e-300
_HALVINGS = 50  # of an interval of 10
_SYMMETRIC = 1e-3  # skewness below which the normal distribution is used
_TOLERANCE = 1e-4  # relative error of a coefficient, below the printed digits


@frozen(kw_only=False)
class Evidence:
    """Test and interval of one squared coefficient."""

    p_value: float  # Probability of such an estimate or a larger one if the term is absent
    low: float  # Interval of θ; low is 0 if the term is not found
    high: float
    null: Floats  # All θ, fitted without the term


def skewed_tails(z: float, skewness: float) -> tuple[float, float]:
    """Probabilities below and above z of Pearson's type III distribution with mean 0, variance 1 and a skewness."""
    if abs(skewness) < _SYMMETRIC:
        return float(normal_below(z)), float(normal_below(-z))
    if skewness < 0:
        above, below = skewed_tails(-z, -skewness)
        return below, above
    shape = 4 / skewness**2
    x = shape + z * math.sqrt(shape)
    if x <= 0:
        return 0.0, 1.0
    return float(gamma_below(shape, x)), float(gamma_above(shape, x))


def evidence(gls: Gls, term: int, theta: Floats, *, level: float) -> Evidence:
    """Test, interval and limit of one term. `theta`: the fit with all terms: the starting point; `level`: of the
    interval; the term is found if p < 1 − level.
    """
    estimate = max(float(theta[term]), 0.0)
    try:
        null = gls.score(term, 0.0)
        p_value = skewed_tails(null.z, null.skewness)[1]
    except FloatingPointError:
        # The other terms alone cannot be fitted.
        null, p_value = gls.score(term, estimate), 0.0
    found = p_value < 1 - level
    last = [null.theta]

    def statistic(root: float) -> tuple[Score, float]:
        score = gls.score(term, root * root, start=last[0])
        last[0] = score.theta
        return score, _upper_share(root * root / score.sigma, level)

    def above_low(root: float) -> float:
        score, share = statistic(root)
        return _normal(skewed_tails(score.z, score.skewness)[1]) - _normal(share)

    def below_high(root: float) -> float:
        score, share = statistic(root)
        return _normal(skewed_tails(score.z, score.skewness)[0]) - _normal(1 - level - share)

    low = 0.0
    if found and estimate > 0:
        top = math.sqrt(estimate)
        low = _crossing(above_low, 1e-4 * top, top) ** 2
    last[0] = theta if estimate > 0 else null.theta
    bottom = math.sqrt(estimate) if estimate > 0 else 0.1 * math.sqrt(null.sigma)
    # The limit of an absent term may be below one standard error, if the other terms explain all of the variances.
    while below_high(bottom) < 0 and bottom > 1e-3 * math.sqrt(null.sigma):
        bottom /= 3
    top = math.sqrt(estimate + 2 * null.sigma)
    while below_high(top) > 0:
        bottom, top = top, 1.5 * top
        if not math.isfinite(top) or top > 1e6 * math.sqrt(null.sigma + estimate):
            return Evidence(p_value, low, math.inf, null.theta)
    high = _crossing(lambda root: -below_high(root), bottom, top) ** 2
    return Evidence(p_value, min(low, estimate), max(high, estimate), null.theta)


def detectable_theta(gls: Gls, term: int, others: Floats, *, level: float, power: float) -> float:
    """The smallest θ of a term that the test of `evidence` finds with probability `power`; inf if there is none. No
    data are needed: the Allan variances are those expected for the other terms' θ.
    """

    def excess(theta_of_term: float) -> float:
        true = others.copy()
        true[term] = theta_of_term
        score = Gls(gls.parts, gls.parts.design @ true, gls.candidates).score(term, 0.0)
        critical = _critical(score.skewness, 1 - level)
        covariance = gls.covariance(true)
        sd = math.sqrt(float(score.weights @ covariance @ score.weights)) / score.sigma
        skewness, _ = gls.parts.skewness(score.weights, true)
        return skewed_tails((critical - score.z) / sd, skewness)[1] - power

    sigma = Gls(gls.parts, gls.parts.design @ others, gls.candidates).score(term, 0.0).sigma
    low, high = 0.1 * sigma, 4 * sigma
    while excess(high) < 0:
        low, high = high, 4 * high
        if high > 1e12 * sigma:
            return math.inf
    return float(_crossing(lambda x: excess(math.exp(x)), math.log(low), math.log(high), absolute=1e-3, as_log=True))


def _crossing(
    f: Callable[[float], float], low: float, high: float, *, absolute: float | None = None, as_log: bool = False
) -> float:
    """Root of an increasing f between `low` and `high`; the nearer end if f does not change sign."""
    at_low, at_high = f(low), f(high)
    if at_low >= 0:
        x = low
    elif at_high <= 0:
        x = high
    else:
        x = root(f, (low, at_low), (high, at_high), absolute=absolute or _TOLERANCE * high, relative=_TOLERANCE)
    return math.exp(x) if as_log else x


def _normal(probability: float) -> float:
    """A probability as a normal deviate, which is nearly linear in the root that is sought."""
    return float(normal_quantile(min(max(probability, _SMALLEST_PROBABILITY), 1 - 1e-16)))


def _critical(skewness: float, probability: float) -> float:
    """Deviate that the skewed distribution exceeds with a probability."""
    if abs(skewness) < _SYMMETRIC:
        return float(-normal_quantile(probability))
    shape = 4 / skewness**2
    x = gamma_quantile_above(shape, probability) if skewness > 0 else gamma_quantile(shape, probability)
    return math.copysign(1.0, skewness) * (float(x) - shape) / math.sqrt(shape)


def _upper_share(ratio: float, level: float) -> float:
    """Probability in the upper tail for a true value of `ratio` standard errors."""
    ratios, shares = _feldman_cousins(level)
    return float(np.interp(ratio, ratios, shares))


@functools.lru_cache(maxsize=16)
def _feldman_cousins(level: float) -> tuple[Floats, Floats]:
    """Upper tail of the acceptance interval [μ − b, μ + d] of a normal x with mean μ ≥ 0, by the likelihood ratio. Both
    ends have the same ratio of the likelihood to that of max(x, 0): b = d, or (μ² + d²)/(2μ) if the interval contains x
    < 0.
    """
    mu = np.concatenate([[1e-3], np.linspace(0.05, 4, 80)])
    low, high = np.zeros_like(mu), np.full_like(mu, 10.0)
    for _ in range(_HALVINGS):
        d = 0.5 * (low + high)
        below = np.where(d <= mu, d, (mu * mu + d * d) / (2 * mu))
        short = normal_below(d) - normal_below(-below) < level
        low, high = np.where(short, d, low), np.where(short, high, d)
    return mu, np.asarray(normal_below(-high))
