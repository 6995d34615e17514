"""Is a term there, between which values does it lie, and what would a record show: tests, intervals, limits.

All three come from one statistic: the free estimate of a squared coefficient θ minus a trial value, over the standard
error that it has if the trial value is true, with every other term fitted anew for that value (`Gls.score` in
`sigmatau.fitting.gls`). Its law is skewed where few independent stretches of the record carry the term, and is taken as
Pearson's type III, the law of a χ², with the mean, variance and skewness that the model gives.

A value belongs to the interval if the statistic is not in the tails of its law. How a probability 1 − level is shared
between the tails follows G. J. Feldman and R. D. Cousins, Phys. Rev. D 57, 3873 (1998), :doi:`10.1103/PhysRevD.57.3873`:
all of it in the upper tail for a value of 0, half of it in each for values well above their error. So the interval leaves
out 0 exactly if the test says that the term is there, and covers with one probability whether it was found or not.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sigmatau.fitting.gls import Gls, Score

__all__ = ["Evidence", "detectable", "evidence", "skewed_tails"]

Floats = NDArray[np.float64]

_SMALLEST = 1e-300
_X_TOLERANCE = 1e-4  # of a coefficient, relative: below any digit that is printed


@dataclass(frozen=True, slots=True)
class Evidence:
    """What the Allan variances say about one squared coefficient.

    Attributes
    ----------
    p_value : float
        Probability of as large an estimate if the term is absent.
    low, high : float
        Interval of θ; low is 0 if the term was not found.
    null : ndarray
        All θ, fitted without the term.
    """

    p_value: float
    low: float
    high: float
    null: Floats


def skewed_tails(z: float, skewness: float) -> tuple[float, float]:
    """Probabilities below and above z of Pearson's type III law with mean 0, variance 1 and a skewness."""
    from scipy.special import gammainc, gammaincc, ndtr

    if abs(skewness) < 1e-3:
        return float(ndtr(z)), float(ndtr(-z))
    if skewness < 0:
        above, below = skewed_tails(-z, -skewness)
        return below, above
    shape = 4 / skewness**2
    x = shape + z * math.sqrt(shape)
    if x <= 0:
        return 0.0, 1.0
    return float(gammainc(shape, x)), float(gammaincc(shape, x))


def evidence(gls: Gls, term: int, theta: Floats, *, level: float) -> Evidence:
    """Test, interval and limit of one term.

    Parameters
    ----------
    gls : Gls
    term : int
        Its index.
    theta : ndarray
        The fit with all terms, for a start.
    level : float
        Of the interval; the term is found if p < 1 − level.
    """
    estimate = max(float(theta[term]), 0.0)
    try:
        null = gls.score(term, 0.0)
        p_value = skewed_tails(null.z, null.skewness)[1]
    except FloatingPointError:
        # Nothing else could have made the variances.
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
    # An absent term may be limited below one standard error, if the others leave no room for it.
    while below_high(bottom) < 0 and bottom > 1e-3 * math.sqrt(null.sigma):
        bottom /= 3
    top = math.sqrt(estimate + 2 * null.sigma)
    while below_high(top) > 0:
        bottom, top = top, 1.5 * top
        if not math.isfinite(top) or top > 1e6 * math.sqrt(null.sigma + estimate):
            return Evidence(p_value, low, math.inf, null.theta)
    high = _crossing(lambda root: -below_high(root), bottom, top) ** 2
    return Evidence(p_value, min(low, estimate), max(high, estimate), null.theta)


def detectable(gls: Gls, term: int, others: Floats, *, level: float, power: float) -> float:
    """The θ of a term that a record with the other terms' θ shows with probability `power`; inf if none.

    No datum is needed: the Allan variances are those expected, and the test is that of `evidence`.
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
    """Where an increasing f changes sign between `low` and `high`; the nearer end if it does not."""
    from scipy.optimize import brentq

    # An iterated f depends in its last digits on what was asked before: no point is asked twice.
    once = functools.cache(f)
    if once(low) >= 0:
        x = low
    elif once(high) <= 0:
        x = high
    else:
        x = float(brentq(once, low, high, xtol=absolute or _X_TOLERANCE * high, rtol=1e-4))
    return math.exp(x) if as_log else x


def _normal(probability: float) -> float:
    """A probability as a normal deviate, so that a root is sought in something nearly linear."""
    from scipy.special import ndtri

    return float(ndtri(min(max(probability, _SMALLEST), 1 - 1e-16)))


def _critical(skewness: float, probability: float) -> float:
    """Deviate that the skewed law exceeds with a probability."""
    from scipy.optimize import brentq

    return float(brentq(lambda z: skewed_tails(z, skewness)[1] - probability, -1.0, 100.0, xtol=1e-6))


def _upper_share(ratio: float, level: float) -> float:
    """Probability in the upper tail for a true value of `ratio` standard errors."""
    ratios, shares = _feldman_cousins(level)
    return float(np.interp(ratio, ratios, shares))


@functools.lru_cache(maxsize=16)
def _feldman_cousins(level: float) -> tuple[Floats, Floats]:
    """Upper tail of the acceptance interval [μ − b, μ + d] of a normal x about μ ≥ 0, by its ordering.

    Both ends have the same likelihood over the best one, that at max(x, 0): b = d, or (μ² + d²)/(2μ) if x < 0 is in it.
    """
    from scipy.optimize import brentq
    from scipy.special import ndtr

    def covered(d: float, mu: float) -> float:
        below = d if d <= mu else (mu * mu + d * d) / (2 * mu)
        return float(ndtr(d) - ndtr(-below)) - level

    ratios = np.concatenate([[1e-3], np.linspace(0.05, 4, 80)])
    ends = [float(brentq(covered, 0.0, 10.0, args=(float(mu),))) for mu in ratios]
    return ratios, np.array([float(ndtr(-d)) for d in ends])
