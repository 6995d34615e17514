"""Covariance of Allan variances added by white noise behind a low-pass filter.

With C(l) the covariance of the second differences z_j(n) and z_{j+l}(m) of the phase, that of two Allan variances is
Σ w(l)·[C(l)² + 2·R²n²m²τ₀⁴·C(l)]/(2n²m²τ₀⁴·M(n)·M(m)), w(l) the number of pairs at the lag l and R a ramp. C is that of
filtered noise, F, and of all else, E: the kernels have Σ w·E², and here are Σ w·(F² + 2FE) and the ramp's Σ w·F, from the
generalised autocovariances of the phase (`sigmatau.model.covariance`).

F is smooth except at the nine lags at which ends of the two clusters coincide, and is negligible beyond the memory of the
filter. So sums include all lags near those nine, and Gauss points of panels in between, whose lengths grow with the distance
but not beyond an oscillation of the filter.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sigmatau.model import covariance as covariances
from sigmatau.model.processes import LowPass

__all__ = ["filtered_covariance"]

Floats = NDArray[np.float64]
Phase = Callable[[Floats], Floats]

_SECOND_DIFFERENCE = np.array([1.0, -2.0, 1.0])

_FILTER_MEMORY = 20.0
"""Time constants of the slowest pole after which the memory of a filter, e^−20 = 2e-9, is neglected."""

_WHOLE_LAGS = 24
"""Lags on either side of a coincidence of cluster ends that are summed one by one."""

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(8)


def filtered_covariance(
    *,
    n: int,
    m: NDArray[np.int64],
    tau0: float,
    random_walk: float,
    bandwidth: LowPass,
    beside: Phase,
    ramp: float,
    together: NDArray[np.bool_],
) -> Floats:
    """Covariance of Allan variances minus the covariance without the filtered noise.

    `tau0`: [s]; `beside`: generalised autocovariance of the phase of all other noise, at lags that need not be whole;
    `together`: sizes whose covariances with each other are asked for; of all others only the variances, the rest is
    0; Returns to 1e-4 of the whole; at averaging times far below those of the filter, to what the autocovariances
    have lost (`ChannelModel.phase_autocovariance`).
    """

    def filtered(lags: Floats) -> Floats:
        return covariances.phase_of_band_limited(random_walk, bandwidth.order, bandwidth.corner, lags, tau0)

    turn = 2 * math.pi * bandwidth.corner * tau0
    memory = math.ceil(_FILTER_MEMORY / (turn * math.sin(math.pi / (2 * bandwidth.order))))
    panels = _panels(n, memory=min(memory, 2 * n), swing=math.pi / turn)
    total = np.zeros((len(m), len(m)))
    for i, first in enumerate(m.tolist()):
        for j, second in enumerate(m[: i + 1].tolist()):
            if i == j or (together[i] and together[j]):
                pairs = float(n - 2 * first + 1), float(n - 2 * second + 1)
                lags, weights = _lags(first, second, pairs, memory, panels)
                own = _differences(filtered, first, second, lags)
                square = own * (own + 2 * _differences(beside, first, second, lags))
                scale = 2.0 * (float(first) * second * tau0**2) ** 2
                found = weights @ (square / scale + ramp**2 * own) / (pairs[0] * pairs[1])
                total[i, j] = total[j, i] = found
    return total


def _differences(phase: Phase, first: int, second: int, lags: Floats) -> Floats:
    """C at lags, which may be fractions."""
    total = np.zeros(lags.shape)
    for a, left in enumerate(_SECOND_DIFFERENCE):
        for b, right in enumerate(_SECOND_DIFFERENCE):
            total += left * right * phase(np.abs(lags + float(b * second - a * first)))
    return total


def _lags(first: int, second: int, pairs: tuple[float, float], memory: int, panels: Floats) -> tuple[Floats, Floats]:
    """Lags, and the number of pairs of pairs of clusters of each."""
    meetings = (np.subtract.outer(np.arange(3) * first, np.arange(3) * second)).ravel()
    low = max(-int(pairs[0]), int(meetings.min()) - memory)
    high = min(int(pairs[1]), int(meetings.max()) + memory)
    ends = np.unique(np.concatenate([meetings[(meetings > low) & (meetings < high)], [low, high]]))
    at, standing = [np.array([float(high)])], [np.ones(1)]
    for left, right in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True):
        up = (right - left) // 2
        for start, sign, inside in ((left, 1.0, up), (right, -1.0, right - left - 1 - up)):
            distance, count = _outwards(inside, panels)
            at.append(start + sign * distance)
            standing.append(count)
        at.append(np.array([float(left)]))
        standing.append(np.ones(1))
    lags, weights = np.concatenate(at), np.concatenate(standing)
    number = np.minimum(pairs[0], pairs[1] - lags) - np.maximum(0.0, -lags)
    return lags, weights * np.maximum(number, 0.0)


def _panels(longest: int, *, memory: int, swing: float) -> Floats:
    """Ends of the panels of distances: growing with the distance, but at most one oscillation of the filter long."""
    ends = [min(_WHOLE_LAGS, longest)]
    while ends[-1] < longest:
        width = ends[-1] / 2
        if ends[-1] < memory:
            width = min(width, swing)
        ends.append(min(ends[-1] + max(math.floor(width), 1), longest))
    return np.array(ends, dtype=np.float64)


def _outwards(inside: int, panels: Floats) -> tuple[Floats, Floats]:
    """Distances 1 … `inside`, whole or Gauss points, and the number of distances that each stands for."""
    whole = np.arange(1.0, min(inside, panels[0]) + 1)
    ends = np.minimum(panels[: np.searchsorted(panels, inside) + 1], inside)
    begin, width = ends[:-1], np.diff(ends)
    short = (width <= len(_POINTS)) & (width > 0)
    steps = np.arange(1.0, len(_POINTS) + 1)
    each = (begin[short, None] + steps)[steps <= width[short, None]]
    long = width > len(_POINTS)
    middle = begin[long] + 0.5 + width[long] / 2
    points = (middle[:, None] + width[long, None] / 2 * _POINTS).ravel()
    counts = (width[long, None] / 2 * _WEIGHTS).ravel()
    return np.concatenate([whole, each, points]), np.concatenate([np.ones(len(whole) + len(each)), counts])
