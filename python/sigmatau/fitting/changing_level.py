"""Test for a white level that changes during the record, and the interval of the random walk with a random effect.

The level is modelled as a random process in time. The error of its mean over the record is the difference from the mean
of the next record of the same length, divided by √2. For independent eighths this is their standard deviation over √8; if
the level wanders, it is the Allan deviation of the level at the length of the record. Three laws are possible for the
logarithm of the level: white, flicker and random walk.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sigmatau._native.distributions import chi2_above, normal_below
from sigmatau.arrays import Floats
from sigmatau.findings.reasons import ChangingRandomWalk
from sigmatau.fitting.adjustment import Adjustment, Change, Ends
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.frozen import frozen
from sigmatau.model.parameters import Parameter

Levels = Sequence[tuple[int, float, float]]
"""Eighths of a record that have samples: number, white level over that of the fit, and its variance by chance."""

_EIGHTHS = 8
_MIN_EIGHTHS = 4  # smallest number of eighths with samples: half of the eighths, as in the test of segments
_SLOW_WAVES = 2  # number of half cycles of a level that wanders over the whole record
_WALK = Parameter("random_walk")

# Tested sizes of a law, relative to the scatter of the eighths, on a logarithmic grid. Beyond both ends the likelihood
# is below 10⁻³ of its peak, or has the constant value of chance alone.
_SIZES = np.geomspace(0.03, 60.0, 80)
_HALVINGS = 40  # halvings of the interval of a quantile


# P-value of an equal level in all eighths below which the level counts as changing. [1] Study:
# docs/theory/likelihood.md measures the false alarms, and the coverage of intervals below this p-value.
UNSTEADY = 0.003


def unsteadiness(levels: Levels) -> float:
    """P-value of an equal level in all eighths; 1 with fewer than four eighths.

    Two statistics are tested: the scatter of the eighths, and two slow waves. The smaller p-value is doubled.
    """
    if len(levels) < _MIN_EIGHTHS:
        return 1.0
    eighths, logs, variances = _columns(levels)
    waves = np.cos(np.pi * np.outer(eighths + 0.5, np.arange(_SLOW_WAVES + 1)) / _EIGHTHS)
    errors = np.sqrt(variances)
    weighted, scaled = waves / errors[:, None], logs / errors
    constant = _residual(weighted[:, :1], scaled)
    together = float(chi2_above(len(levels) - 1, constant))
    slow = float(chi2_above(_SLOW_WAVES, max(constant - _residual(weighted, scaled), 0.0)))
    return min(2 * min(together, slow), 1.0)


def changing_level(fitted: NoiseFit, *, levels: Levels, p_value: float) -> Adjustment | None:
    """Widen the interval of the random walk for a level that is a random process in time, if the eighths have different
    levels.

    `p_value`: see `unsteadiness`.
    """
    walk = fitted.terms.get("random_walk")
    if p_value >= UNSTEADY or walk is None:
        return None
    if walk.value is None or walk.low is None or walk.high is None:
        return None
    errors = level_errors(levels, level=walk.level)
    sides = _log_ratio(walk.value, walk.low), _log_ratio(walk.high, walk.value)
    low, high = _ends(walk.value, sides, errors.mean)
    next_low, next_high = _ends(walk.value, [math.sqrt(2) * side for side in sides], errors.following)
    sizes = [walk.value * math.sqrt(size) for _, size, _ in levels]
    return Adjustment(
        cause="changing_level",
        findings=("changing_level",),
        changes=(Change.widening(_WALK, Ends.of(walk), Ends(low, high, None)),),
        reason=ChangingRandomWalk(
            lowest=min(sizes), highest=max(sizes), next_lowest=next_low, next_highest=next_high, p_value=p_value
        ),
    )


def _log_ratio(larger: float, smaller: float) -> float:
    return math.log(larger / smaller) if smaller > 0 else math.inf


def _ends(value: float, sides: Sequence[float], error: float) -> tuple[float, float]:
    """Ends of the interval of a random walk whose logarithm has a two-sided interval and an error of the squared
    logarithm.
    """
    below, above = (math.hypot(side, 0.5 * error) for side in sides)
    return value * math.exp(-below), value * math.exp(above)


@frozen
class LevelErrors:
    """Half widths of the intervals of ln N² under a changing level.

    Attributes
    ----------
    mean : float
        Error of the mean of this record, whose eighths are measured.
    following : float
        Difference between the means of the next record and of this one, without the measured scatter.
    """

    mean: float
    following: float


def level_errors(levels: Levels, *, level: float) -> LevelErrors:
    """Compute the intervals at a confidence `level`, with the law and its size integrated out.

    Each law has the same prior, and ln of its size is uniform. With one law and no scatter by chance, the interval is
    that of Student's t with one degree of freedom fewer than eighths; an unknown law has wider tails.
    """
    eighths, logs, variances = _columns(levels)
    contrasts = np.linalg.svd(np.ones((1, len(eighths))))[2][1:].T
    observed, chance = logs @ contrasts, (contrasts.T * variances) @ contrasts
    sizes = _SIZES * max(float(np.std(logs, ddof=1)), math.sqrt(float(variances.mean())))
    squared_sizes = sizes[:, None] ** 2
    error = _error_of_mean(eighths)
    likelihoods, means, squares, remaining = [], [], [], []
    for law in _laws():
        expected = contrasts.T @ law[np.ix_(eighths, eighths)] @ contrasts
        covariance = squared_sizes[..., None] * expected + chance
        inverse = np.linalg.inv(covariance)
        shared = squared_sizes * (contrasts.T @ law[eighths] @ error)  # covariance of contrasts and the error
        distance = np.einsum("i,sij,j->s", observed, inverse, observed)
        likelihoods.append(-0.5 * (np.linalg.slogdet(covariance)[1] + distance))
        means.append(np.einsum("si,sij,j->s", shared, inverse, observed))
        squares.append(squared_sizes[:, 0] * (error @ law @ error))
        remaining.append(squares[-1] - np.einsum("si,sij,sj->s", shared, inverse, shared))
    weights = np.exp(np.concatenate(likelihoods) - np.max(likelihoods))
    weights /= weights.sum()
    deviations = np.sqrt(np.concatenate(squares))
    return LevelErrors(
        mean=_half_width(np.concatenate(means), np.sqrt(np.concatenate(remaining)), weights, level),
        following=math.sqrt(2) * _half_width(np.zeros_like(deviations), deviations, weights, level),
    )


def _columns(levels: Levels) -> tuple[np.ndarray, Floats, Floats]:
    eighths, sizes, variances = (np.array(column) for column in zip(*levels, strict=True))
    return eighths.astype(int), np.log(sizes), variances / sizes**2


def _residual(curves: Floats, values: Floats) -> float:
    """Sum of squares of values after a fit of curves."""
    remainder = values - curves @ np.linalg.lstsq(curves, values, rcond=None)[0]
    return float(remainder @ remainder)


def _laws() -> list[Floats]:
    """Covariances of the eighths of this record and of the next one, of size 1: white, flicker and random walk.

    The last two are generalised covariances, valid for contrasts only.
    """
    lag = np.abs(np.subtract.outer(np.arange(2 * _EIGHTHS), np.arange(2 * _EIGHTHS))).astype(float)
    flicker = lag**2 * np.log(np.maximum(lag, 1)) - 0.5 * sum(
        np.abs(lag + step) ** 2 * np.log(np.maximum(np.abs(lag + step), 1)) for step in (-1, 1)
    )
    return [np.eye(2 * _EIGHTHS), flicker, np.where(lag > 0, -0.5 * lag, -1 / 6)]


def _error_of_mean(eighths: np.ndarray) -> Floats:
    """Mean of the next record minus that of this one, over √2, as a combination of the eighths of both."""
    difference = np.zeros(2 * _EIGHTHS)
    difference[eighths] = -1 / len(eighths)
    difference[_EIGHTHS:] = 1 / _EIGHTHS
    return difference / math.sqrt(2)


def _half_width(means: Floats, deviations: Floats, weights: Floats, level: float) -> float:
    """Distance from 0 that a mixture of normal laws exceeds with the probability 1 − `level`."""
    below, above = 0.0, float(np.max(np.abs(means) + 10 * deviations))
    for _ in range(_HALVINGS):
        middle = 0.5 * (below + above)
        inside = normal_below((middle - means) / deviations) - normal_below((-middle - means) / deviations)
        below, above = (below, middle) if float(weights @ inside) > level else (middle, above)
    return above
