"""A Gauss-Markov process in place of a rate random walk or of bias instability.

Against a walk that is far too high at the longest times, a step from the fit with the walk says nothing: each correlation
time is tried by full fits. They use one averaging time in an octave, because the covariance of a process has to be computed
anew for each correlation time.
"""

from __future__ import annotations

import bisect
import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.distributions import normal_quantile
from sigmatau.fitting.attempt import FAILURES, Attempt, Data
from sigmatau.fitting.components import LINEAR
from sigmatau.fitting.gls import Gls
from sigmatau.fitting.goodness import deviance, octaves
from sigmatau.fitting.ramp import estimate_ramp

Floats = NDArray[np.float64]

PRICE = 7.0
"""Least gain in deviance, as in the likelihood: in 18 cells of 300 ideal records at most 2.3 % had a larger one and
p < 0.3."""

_SHORTEST = 10  # times the shortest averaging time
_LONGEST_SHARE = 4  # of the record: its length over the longest correlation time
_PER_DECADE = 2
_MOST_STEPS = 3  # of the refinement; each computes a covariance
_LONGEST_STEP = 0.6  # of the logarithm of the time: half the distance of two times that were tried
_SMALL_STEP = 0.1  # of the standard error

_REPLACED = (LINEAR.index("rate_random_walk"), LINEAR.index("bias_instability"))


def best_time(data: Data, without: Attempt, *, level: float) -> float | None:
    """Correlation time in samples of a process that improves a fit by more than its price; None if there is none."""
    # Of all averaging times, so that all starts of the fit share the components.
    coarse = data.at(octaves(np.array(data.m)))
    coarse = replace(coarse, first=bisect.bisect_left(coarse.m, data.m[without.first]))
    shortest, longest = math.log(_SHORTEST * coarse.m[0]), math.log(data.n / _LONGEST_SHARE)
    if longest <= shortest:
        return None
    times = np.linspace(shortest, longest, max(2, round((longest - shortest) / math.log(10) * _PER_DECADE) + 1))
    remove = without.ramp is not None and without.ramp.used != 0
    terms = without.gls.candidates
    least = _deviance(coarse, None, terms, remove=remove, level=level)
    found = [_replacing(coarse, math.exp(time), terms, remove=remove, level=level) for time in times]
    k = int(np.argmin(found))
    if not least - found[k] > PRICE:
        return None
    time = _vertex(times[k - 1 : k + 2], found[k - 1 : k + 2]) if 0 < k < len(times) - 1 else float(times[k])
    time = math.log(_refined(coarse, terms, math.exp(time)))
    # A step outside is no process that the record shows.
    return math.exp(time) if shortest - _LONGEST_STEP < time < longest + _LONGEST_STEP else None


def _replacing(data: Data, time: float, terms: tuple[int, ...], *, remove: bool, level: float) -> float:
    """Smallest deviance with a process in place of one of the terms."""
    found = math.inf
    for replaced in _REPLACED:
        if replaced in terms:
            left = tuple(p for p in terms if p != replaced)
            found = min(found, _deviance(data, time, left, remove=remove, level=level))
    return found


def _deviance(data: Data, time: float | None, terms: tuple[int, ...], *, remove: bool, level: float) -> float:
    """Of the fit of some terms and a process, after the removal of a ramp or not; infinite if the fit fails."""
    try:
        first = data.first or 0
        full = data.gls(first, time)
        gls = Gls(full.parts, full.avar, (*terms, *range(len(LINEAR), len(full.parts.names))))
        theta = gls.fit()
        if remove:
            _, gls, theta = estimate_ramp(gls, theta, data.ramps[first:], level=level)
        found = deviance(gls, theta)
    except FAILURES:
        return math.inf
    return found if math.isfinite(found) else math.inf


def _vertex(x: Floats, y: list[float]) -> float:
    """Place of the minimum of a parabola through three points at equal distances, the middle one of which is the lowest."""
    curvature = y[0] - 2 * y[1] + y[2]
    if not (math.isfinite(curvature) and curvature > 0):
        return float(x[1])
    return float(x[1] + (x[1] - x[0]) * 0.5 * (y[0] - y[2]) / curvature)


def _refined(data: Data, terms: tuple[int, ...], time: float) -> float:
    """The correlation time of least squares, by Gauss-Newton steps."""
    first = data.first or 0
    for _ in range(_MOST_STEPS):
        try:
            full = data.gls(first, time)
            gls = Gls(full.parts, full.avar, (*terms, len(LINEAR)))
            theta = gls.fit()
            active = [p for p in gls.candidates if theta[p] > 0]
            if theta[-1] <= 0:
                return time
            tangent = theta[-1] * data.by_time(first, time)
            left = gls.avar - gls.parts.design @ theta
            whitened = gls.weights(theta).whiten(np.column_stack([left, gls.parts.design[:, active], tangent]))
        except FAILURES:
            return time
        scale = np.linalg.norm(whitened[:, 1:], axis=0)
        row = np.linalg.pinv(whitened[:, 1:] / scale)[-1] / scale[-1]
        step = float(row @ whitened[:, 0])
        time *= math.exp(min(max(step, -_LONGEST_STEP), _LONGEST_STEP))
        if abs(step) < _SMALL_STEP * float(np.linalg.norm(row)):
            break
    return time


def intervals(
    found: Attempt, data: Data, theta: Floats, *, level: float
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Value, low and high of the standard deviation and of the correlation time, symmetric in the logarithm. The
    covariance has the time as a free parameter.
    """
    assert found.time is not None
    gls, size = found.gls, float(theta[-1])
    tangent = size * data.by_time(found.first, found.time)
    whitened = gls.weights(theta).whiten(np.column_stack([gls.parts.design[:, list(gls.candidates)], tangent]))
    scale = np.linalg.norm(whitened, axis=0)
    sd = np.sqrt(np.sum(np.linalg.pinv(whitened / scale) ** 2, axis=1)) / scale
    k = float(normal_quantile(0.5 + level / 2))

    def around(value: float, half: float) -> tuple[float, float, float]:
        factor = math.exp(min(half, 50))
        return value, value / factor, value * factor

    return around(math.sqrt(size), k * sd[-2] / (2 * size)), around(found.time, k * sd[-1])
