"""Estimation of factors on the variances of a filter, by the likelihood of its innovations.

The periodogram of whitened innovations is exponentially distributed with their density as mean; for several measurements
its matrix has a Wishart distribution (Whittle). Leakage is small, because the innovations are almost white. Bins of many
frequencies have a gamma distribution with the density at their centre as mean.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.distributions import chi2_above, chi2_quantile_above, digamma
from sigmatau.arrays import Bools, Floats, Ints
from sigmatau.frozen import frozen

Matrices = NDArray[Any]  # complex for several series, real for one

_SINGLE = 16  # number of lowest frequencies, each a separate bin
_BIN_RATIO = 1.1  # ratio of the ends of a bin at higher frequencies
_LARGEST = 2 * math.log(1e3)  # logarithm of the largest factor of a variance: 1000 on a standard deviation
_ITERATIONS = 60
# first step of the logarithm of a variance in the search for the end of an interval
_FIRST_REACH = 0.05
_STEPS = 30  # largest number of interpolations for an end of an interval; usually three suffice
_NARROWEST = 0.02  # smallest share of a bracket that an interpolation removes
_TOLERANCE = 2e-4  # relative tolerance of the distance from the value to an end of its interval
_CONVERGED = 1e-9  # tolerance of the deviance
_DIFFERENCE = 1e-4  # relative step of the difference quotient for the trigamma function
_COARSE = 1.5  # ratio of the ends of a bin in the test of a misfit


@frozen(eq=False)
class Periodogram:
    """Periodogram of whitened series, in bins.

    Attributes
    ----------
    frequency : ndarray, shape (n_bins,)
        Middle of each bin. [cycles per sample]
    power : ndarray, shape (n_bins, n_series, n_series)
        Mean in each bin; the identity matrix for white series with variance 1.
    number : ndarray, shape (n_bins,)
        Number of frequencies in each bin.
    is_used : ndarray, shape (n_bins, n_series)
        Whether a series is used in a bin: a short series has few independent frequencies, so only few are used.
    """

    frequency: Floats
    power: Matrices
    number: Floats
    is_used: Bools

    @classmethod
    def compute(
        cls, series: Floats, *, counts: Ints | None = None, ratio: float = _BIN_RATIO, single: int = _SINGLE
    ) -> Periodogram:
        """Compute and bin the periodogram of series of shape (n, n_series), after subtraction of their means."""
        n = len(series)
        lines = np.fft.rfft(series, axis=0)[1 : (n - 1) // 2 + 1]
        power: Matrices = lines[:, :, None] * lines[:, None].conj() / n
        starts, number = _bins(n, ratio, single)
        power = np.add.reduceat(power, starts) / number[:, None, None]
        samples = np.full(series.shape[1], n) if counts is None else counts
        used = (starts + number)[:, None] <= np.maximum((samples - 1) // 2, 1)
        return cls(
            frequency=(starts + (number + 1) / 2) / n,
            power=np.asarray(power.real if series.shape[1] == 1 else power),
            number=number,
            is_used=used,
        ).restricted()

    def restricted(self) -> Periodogram:
        """Periodogram with unit power where a series is not used."""
        return replace(self, power=self.restrict(self.power))

    def restrict(self, density: Matrices) -> Matrices:
        """Put a unit density where a series is not used."""
        if self.is_used.all():
            return density
        used = self.is_used[:, :, None] & self.is_used[:, None]
        return np.where(used, density, np.eye(self.is_used.shape[1]))

    def deviance(self, density: Matrices) -> float:
        """Minus twice the logarithm of the likelihood, without constants."""
        inverse, logarithm = invert(density)
        return float(2 * np.sum(self.number * (logarithm + trace_of_product(inverse, self.power))))

    def misfit(self, density: Matrices, fitted: int) -> float:
        """P-value of the deviance from the density, after a fit of some parameters."""
        root = np.linalg.inv(np.linalg.cholesky(density))
        ratio = np.diagonal(root @ self.power @ root.conj().swapaxes(1, 2), axis1=1, axis2=2).real
        w, series = self.number, self.is_used.sum(axis=1)
        freedom = digamma(w)
        slope = (digamma(w * (1 + _DIFFERENCE)) - digamma(w * (1 - _DIFFERENCE))) / (2 * w * _DIFFERENCE)
        mean = float(np.sum(2 * series * w * (np.log(w) - freedom))) - fitted
        variance = float(np.sum(4 * series * w**2 * (slope - 1 / w)))
        scale = variance / (2 * mean)  # scale of the χ² with this mean and variance
        deviance = float(np.sum(2 * w[:, None] * (ratio - 1 - np.log(ratio))))
        return float(chi2_above(mean / scale, deviance / scale))


def _bins(n: int, ratio: float, single: int) -> tuple[NDArray[np.int64], Floats]:
    """First frequency of each bin and its number of frequencies, for a series of n samples."""
    last = (n - 1) // 2
    edges = [*range(min(single, last))]
    while edges[-1] < last:
        edges.append(min(max(edges[-1] + 1, round(edges[-1] * ratio)), last))
    return np.array(edges[:-1]), np.diff(edges).astype(np.float64)


def coarse(series: Floats, counts: Ints | None = None) -> Periodogram:
    """Compute the periodogram in wide bins, for the misfit test."""
    return Periodogram.compute(series, counts=counts, ratio=_COARSE, single=2)


def invert(density: Matrices) -> tuple[Matrices, Floats]:
    """Inverses of matrices, and the logarithms of their determinants."""
    if density.shape[-1] == 1:
        return 1 / density, np.log(density[..., 0, 0].real)
    return np.linalg.inv(density), np.linalg.slogdet(density)[1]


def trace_of_product(a: Matrices, b: Matrices) -> Floats:
    """Traces of a·b, which are real for Hermitian matrices."""
    if a.shape[-1] == 1:
        return np.asarray((a * b)[..., 0, 0].real)
    return np.asarray(np.sum(a * b.swapaxes(-1, -2), axis=(-2, -1)).real)


@frozen(eq=False)
class Fit:
    """Logarithms of the factors of the variances, and their deviance.

    Attributes
    ----------
    logs : ndarray, shape (n_parts,)
    deviance : float
    """

    logs: Floats
    deviance: float


@frozen
class FactorInterval:
    """A factor on a standard deviation.

    Attributes
    ----------
    value : float
    low : float
        Lower end of the interval; 0 if the innovations do not show the noise.
    high : float or None
        Upper end of the interval; None if it is unbounded.
    """

    value: float
    low: float
    high: float | None


class Shares:
    """Shares of each noise in the density of the innovations, and the fit of factors on them."""

    def __init__(self, data: Periodogram, shares: Matrices) -> None:
        self.data = data
        used = data.is_used[:, :, None] & data.is_used[:, None]
        self.shares: Matrices = np.where(used, shares.real if shares.shape[-1] == 1 else shares, 0.0)

    def density(self, logs: Floats) -> Matrices:
        """Density of the whitened innovations for factors on the variances."""
        return self.data.restrict(np.asarray(np.tensordot(np.exp(logs), self.shares, 1)))

    def fit(self, free: Sequence[int], start: Floats | None = None) -> Fit:
        """Maximise the likelihood over some factors by Fisher's scoring; the others keep their start values, or 1."""
        logs = np.zeros(len(self.shares)) if start is None else start.copy()
        index = np.array(free, dtype=int)
        best = self.data.deviance(self.density(logs))
        damping = 1e-3
        for _ in range(_ITERATIONS if len(index) else 0):
            slope, curvature = self._derivatives(logs, index)
            size = np.diag(np.diag(curvature) + 1e-9)
            while True:
                step = np.linalg.solve(curvature + damping * size, slope)
                trial = logs.copy()
                trial[index] = np.clip(logs[index] + np.clip(step, -2, 2), -_LARGEST, _LARGEST)
                deviance = self.data.deviance(self.density(trial))
                if deviance <= best or damping > 1e8:
                    break
                damping *= 10
            gain, damping = best - deviance, max(damping / 10, 1e-9)
            if gain > 0:
                logs, best = trial, deviance
            if gain <= _CONVERGED:
                break
        return Fit(logs=logs, deviance=best)

    def _derivatives(self, logs: Floats, index: NDArray[np.int64]) -> tuple[Floats, Floats]:
        """Derivative of half the logarithm of the likelihood by the logarithms of the factors, and Fisher's information."""
        inverse, _ = invert(self.density(logs))
        parts = np.exp(logs[index])[:, None, None, None] * self.shares[index]
        number = self.data.number
        if inverse.shape[-1] == 1:
            relative = (parts * inverse)[..., 0, 0]
            excess = (self.data.power * inverse)[..., 0, 0] - 1
            return relative @ (number * excess), (relative * number) @ relative.T
        turned = inverse @ parts
        excess = inverse @ self.data.power - np.eye(inverse.shape[-1])
        slope = np.array([number @ trace_of_product(part, excess) for part in turned])
        curvature = [[number @ trace_of_product(a, b) for b in turned] for a in turned]
        return slope, np.array(curvature)

    def interval(self, best: Fit, part: int, level: float) -> FactorInterval:
        """Interval of one factor from its profile likelihood, in which the others are fitted at each value."""
        free = [k for k in range(len(self.shares)) if k != part]
        rise = float(chi2_quantile_above(1, 1 - level))

        def distance(value: float) -> float:
            """Root of the rise of the deviance over the rise at the end of the interval; almost linear in the value."""
            start = best.logs.copy()
            start[part] = value
            return math.sqrt(max(self.fit(free, start).deviance - best.deviance, 0.0) / rise)

        _, curvature = self._derivatives(best.logs, np.arange(len(self.shares)))
        variance = float(np.linalg.pinv(curvature)[part, part])
        first = min(max(1.1 * math.sqrt(rise * max(variance, 0.0)), _FIRST_REACH), _LARGEST)

        def end(side: int) -> float | None:
            inner, at_inner, reach = float(best.logs[part]), 0.0, first
            while True:
                outer = float(np.clip(best.logs[part] + side * reach, -_LARGEST, _LARGEST))
                at_outer = distance(outer)
                if at_outer > 1:
                    break
                if abs(outer) >= _LARGEST:
                    return None
                inner, at_inner, reach = outer, at_outer, 2 * reach
            for _ in range(_STEPS):
                share = min(max((1 - at_inner) / (at_outer - at_inner), _NARROWEST), 1 - _NARROWEST)
                middle = inner + share * (outer - inner)
                at_middle = distance(middle)
                if at_middle > 1:
                    outer, at_outer = middle, at_middle
                else:
                    inner, at_inner = middle, at_middle
                if abs(at_middle - 1) < _TOLERANCE:
                    break
            return math.exp(middle / 2)

        return FactorInterval(value=math.exp(best.logs[part] / 2), low=end(-1) or 0.0, high=end(1))
