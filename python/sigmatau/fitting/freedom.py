"""Degrees of freedom of the Allan variances of a fitted model."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import kernels
from sigmatau.arrays import distinct
from sigmatau.fitting.components import LINEAR, densities, power_of_interval
from sigmatau.fitting.noise_fit import NoiseFit

Floats = NDArray[np.float64]
Sizes = NDArray[np.int64]

_MOST_EXACT = 100  # cluster sizes whose degrees of freedom are computed; others are interpolated


def degrees_of_freedom(fitted: NoiseFit, sizes: Sizes) -> Floats | None:
    """See `NoiseFit.degrees_of_freedom`."""
    grid = distinct(sizes)
    if len(grid) > _MOST_EXACT:
        grid = grid[distinct(np.round(np.geomspace(1, len(grid), _MOST_EXACT)).astype(int)) - 1]
    theta = [fitted.model.get(name, 0.0) ** 2 * fitted.tau0 ** (power_of_interval(name) - 2) for name in LINEAR]
    if not any(theta) and not fitted.gauss_markov:  # a line alone has no scatter
        return None
    edf = _complete(fitted, grid, theta)
    return np.asarray(np.exp(np.interp(np.log(sizes), np.log(grid), np.log(edf))))


def _complete(fitted: NoiseFit, m: Sizes, theta: list[float]) -> Floats:
    # The unit does not matter: squares of the largest and the smallest numbers stay in range.
    powers = [one.sigma.value**2 for one in fitted.gauss_markov]
    unit = max(*theta, *powers)
    theta, powers = [one / unit for one in theta], [one / unit for one in powers]
    ramp = fitted.model.get("rate_ramp", 0.0) * fitted.tau0 / math.sqrt(unit)
    times = [one.time.value / fitted.tau0 for one in fitted.gauss_markov]
    variances = kernels.allan_variance_variances(fitted.n, m, theta + powers, correlation_times=times, ramp=ramp)
    avar = 0.5 * (ramp * m) ** 2
    for name, squared in zip(LINEAR, theta, strict=True):
        avar = avar + squared * kernels.term_avar(name, 1.0, m, 1.0)
    for power, time in zip(powers, times, strict=True):
        avar = avar + power * kernels.gauss_markov_avar(1.0, time, m, 1.0)
    for line in fitted.sinusoid:
        frequency = line.frequency.value * fitted.tau0
        shape = kernels.sinusoid_avar(1.0, frequency, m, 1.0)
        density = sum(squared * at for squared, at in zip(theta, densities(frequency), strict=True))
        # The squared amplitude scatters with the noise at its frequency, by 8A²S(f)/n, S two-sided.
        variances = variances + 8 / fitted.n * density * line.amplitude.value**2 / unit * shape**2
        avar = avar + line.amplitude.value**2 / unit * shape
    return 2 * avar**2 / variances
