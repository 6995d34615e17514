"""Factors on the variances of a filter by the likelihood of its innovations.

The periodogram of the normalised innovations is exponential about their density (Whittle). As they are almost white, its
leakage is small. Bins of many frequencies are gamma distributed about the density in their middle.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sigmatau._native.distributions import chi2_above, chi2_quantile_above, digamma
from sigmatau.arrays import Floats
from sigmatau.frozen import frozen

_SINGLE = 16  # lowest frequencies, each a bin
_BIN_RATIO = 1.1  # of the ends of the bins above
_LARGEST = 2 * math.log(1e3)  # logarithm of the largest factor of a variance: 1000 on a standard deviation
_ITERATIONS = 60
_STEPS = 12  # bisections of an end of an interval, to 1/4000 of its length
_CONVERGED = 1e-9  # of the deviance
_DIFFERENCE = 1e-4  # relative step of the trigamma function
_COARSE = 1.5  # ratio of the ends of the bins of the test of a misfit


@frozen(eq=False)
class Periodogram:
    """Periodogram of a white series with variance 1, in bins.

    Attributes
    ----------
    frequency : ndarray, shape (n_bins,)
        Middle of each bin. [cycles a sample]
    power : ndarray, shape (n_bins,)
        Mean in each bin; 1 for white noise with variance 1.
    number : ndarray, shape (n_bins,)
        Frequencies in each bin.
    """

    frequency: Floats
    power: Floats
    number: Floats

    @classmethod
    def of(cls, series: Floats, *, ratio: float = _BIN_RATIO, single: int = _SINGLE) -> Periodogram:
        """Compute and bin it; the mean of the series is not in it."""
        n = len(series)
        last = (n - 1) // 2
        power = np.abs(np.fft.rfft(series)[1 : last + 1]) ** 2 / n
        edges = [*range(min(single, last))]
        while edges[-1] < last:
            edges.append(min(max(edges[-1] + 1, round(edges[-1] * ratio)), last))
        starts = np.array(edges[:-1])
        number = np.diff(edges).astype(np.float64)
        return cls(
            frequency=(starts + (number + 1) / 2) / n, power=np.add.reduceat(power, starts) / number, number=number
        )

    def deviance(self, density: Floats) -> float:
        """Minus twice the logarithm of the likelihood, without constants."""
        return float(2 * np.sum(self.number * (np.log(density) + self.power / density)))

    def misfit(self, density: Floats, fitted: int) -> float:
        """p-value of the deviance from the density, after a fit of some parameters."""
        w, ratio = self.number, self.power / density
        freedom = digamma(w)
        slope = (digamma(w * (1 + _DIFFERENCE)) - digamma(w * (1 - _DIFFERENCE))) / (2 * w * _DIFFERENCE)
        mean = float(np.sum(2 * w * (np.log(w) - freedom))) - fitted
        variance = float(np.sum(4 * w**2 * (slope - 1 / w)))
        scale = variance / (2 * mean)  # of the χ² with this mean and variance
        deviance = float(np.sum(2 * w * (ratio - 1 - np.log(ratio))))
        return float(chi2_above(mean / scale, deviance / scale))


def coarse(series: Floats) -> Periodogram:
    """The periodogram in wide bins, for a test of a misfit."""
    return Periodogram.of(series, ratio=_COARSE, single=2)


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
        0 if the innovations do not show the noise.
    high : float or None
        None if it is not bounded.
    """

    value: float
    low: float
    high: float | None


class Shares:
    """Shares of each noise in the density of the innovations, and the fit of factors on them."""

    def __init__(self, data: Periodogram, shares: Sequence[Floats]) -> None:
        self.data = data
        self.shares: Floats = np.array(shares)

    def density(self, logs: Floats) -> Floats:
        """Density of the normalised innovations for factors on the variances."""
        return np.asarray(np.exp(logs) @ self.shares)

    def fit(self, free: Sequence[int], start: Floats | None = None) -> Fit:
        """Maximise the likelihood over some factors, by Fisher's scoring; the others are those of the start, or 1."""
        logs = np.zeros(len(self.shares)) if start is None else start.copy()
        index = np.array(free, dtype=int)
        best = self.data.deviance(self.density(logs))
        damping = 1e-3
        for _ in range(_ITERATIONS if len(index) else 0):
            density = self.density(logs)
            jacobian = np.exp(logs[index])[:, None] * self.shares[index] / density
            slope = jacobian @ (self.data.number * (self.data.power / density - 1))
            curvature = (jacobian * self.data.number) @ jacobian.T
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

    def interval(self, best: Fit, part: int, level: float) -> FactorInterval:
        """Profile likelihood of one factor: the others are fitted anew at each value."""
        others = [k for k in range(len(self.shares)) if k != part]
        rise = float(chi2_quantile_above(1, 1 - level))

        def excess(value: float) -> float:
            start = best.logs.copy()
            start[part] = value
            return self.fit(others, start).deviance - best.deviance - rise

        def end(side: int) -> float | None:
            inner, reach = float(best.logs[part]), 0.05
            while True:
                outer = float(np.clip(best.logs[part] + side * reach, -_LARGEST, _LARGEST))
                if excess(outer) > 0:
                    break
                if abs(outer) >= _LARGEST:
                    return None
                inner, reach = outer, 2 * reach
            for _ in range(_STEPS):
                middle = (inner + outer) / 2
                inner, outer = (inner, middle) if excess(middle) > 0 else (middle, outer)
            return math.exp((inner + outer) / 4)

        return FactorInterval(value=math.exp(best.logs[part] / 2), low=end(-1) or 0.0, high=end(1))
