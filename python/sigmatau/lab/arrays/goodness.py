"""Goodness of fit of the covariance matrices of an array, by range of frequency.

The whitened squares of m frequencies have a Wishart distribution with m degrees of freedom and the unit matrix. Each range
is tested by the likelihood ratio with Bartlett's correction, and all ranges together by the sum.

References
----------
T. W. Anderson, "An Introduction to Multivariate Statistical Analysis," 3rd ed., 2003, section 10.8.
"""

from __future__ import annotations

import math

import numpy as np

from sigmatau._native.distributions import chi2_above
from sigmatau.frozen import frozen
from sigmatau.lab.arrays.covariance_fit import CovarianceFit
from sigmatau.results import plain

# P-value of all ranges together, below which the model does not fit and intervals are widened. [1] Judgement: as in fits of
# a channel.
_MISFIT = 0.01
_RATIO = 1.26  # smallest ratio of the ends of a range. [1] Judgement: a third of an octave
_LEAST_FREQUENCIES = 4  # smallest number of frequencies of a range per channel, for which the correction holds


@frozen
class RangeTest:
    """Test of one range of frequencies.

    Attributes
    ----------
    low, high : float
        [Hz]
    p_value : float
        [1]
    """

    low: float
    high: float
    p_value: float


@frozen
class Goodness:
    """Goodness of fit of an array.

    Attributes
    ----------
    p_value : float
        P-value of all ranges together. [1]
    widening : float
        Factor on the standard errors: 1 if the model fits.
    ranges : tuple of RangeTest
    """

    p_value: float
    widening: float
    ranges: tuple[RangeTest, ...]

    @property
    def is_misfit(self) -> bool:
        """Whether the model does not fit."""
        return self.widening > 1

    @property
    def worst(self) -> RangeTest:
        """The range with the smallest p-value."""
        return min(self.ranges, key=lambda test: test.p_value)

    def to_dict(self) -> dict[str, object]:
        """Plain values."""
        ranges = [{"low_hz": r.low, "high_hz": r.high, "p_value": r.p_value} for r in self.ranges]
        return plain(self, "p_value widening") | {"ranges": ranges}


def judge_goodness(fit: CovarianceFit) -> Goodness:
    """Test the fit in ranges of a third of an octave, and together."""
    bands, spectra = fit.bands, fit.spectra
    n = spectra.shape[1]
    whitening = np.linalg.inv(np.linalg.cholesky(spectra))
    squares = whitening @ fit.residual @ whitening.transpose(0, 2, 1)
    freedom = n * (n + 1) / 2
    tests, total, begin = [], 0.0, 0
    for end in range(len(bands.count)):
        m = float(bands.count[begin : end + 1].sum())
        is_last = end + 1 == len(bands.count)
        if (m < _LEAST_FREQUENCIES * n or bands.high[end] < _RATIO * bands.low[begin]) and not is_last:
            continue
        if m >= n:
            mean = squares[begin : end + 1].sum(axis=0) / m
            ratio = m * (np.trace(mean) - float(np.linalg.slogdet(mean)[1]) - n)
            ratio *= 1 - (2 * n**2 + 3 * n - 1) / (6 * m * (n + 1))
            p = float(chi2_above(freedom, max(ratio, 0.0)))
            tests.append(RangeTest(low=float(bands.low[begin]), high=float(bands.high[end]), p_value=p))
            total += ratio
        begin = end + 1
    total_freedom = max(len(tests) * freedom - fit.theta.size, 1.0)
    p_value = float(chi2_above(total_freedom, max(total, 0.0)))
    widening = math.sqrt(max(total / total_freedom, 1.0)) if p_value < _MISFIT else 1.0
    return Goodness(p_value=p_value, widening=widening, ranges=tuple(tests))
