"""Yield of a lot, and the process capability of a coefficient against its maximum, with intervals.

References
----------
.. [1] L. D. Brown, T. T. Cai, A. DasGupta, "Interval estimation for a binomial proportion," Stat. Sci., vol. 16, 2001,
   :doi:`10.1214/ss/1009213286`; the interval of Wilson.
.. [2] A. F. Bissell, "How reliable is your capability index?" Appl. Stat., vol. 39, 1990, :doi:`10.2307/2347383`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sigmatau._native.distributions import normal_quantile
from sigmatau.arrays import Floats
from sigmatau.frozen import frozen
from sigmatau.results import plain

LEAST_UNITS_OF_CPK = 10
"""Smallest number of units for a capability: with fewer, its interval is wider than a third of its value."""


@frozen
class BoundedNumber:
    """A number with its interval.

    Attributes
    ----------
    value, low, high : float
        The number, and the ends of its interval. [1]
    """

    value: float
    low: float
    high: float

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return plain(self, "value low high")


def estimate_yield(passed: int, units: int, *, level: float = 0.95) -> BoundedNumber:
    """Share of the units that passed, with Wilson's interval [1]_.

    Parameters
    ----------
    passed, units : int
        Units that passed, and all units.
    level : float
        Confidence level.

    Returns
    -------
    BoundedNumber
    """
    z = float(normal_quantile((1 + level) / 2))
    share = passed / units
    middle = (share + z * z / (2 * units)) / (1 + z * z / units)
    half = z / (1 + z * z / units) * math.sqrt(share * (1 - share) / units + z * z / (4 * units**2))
    low = max(middle - half, 0.0) if passed else 0.0
    return BoundedNumber(value=share, low=low, high=min(middle + half, 1.0) if passed < units else 1.0)


def estimate_capability(values: Floats, maximum: float, *, level: float = 0.95) -> BoundedNumber | None:
    """Capability Cpk of logarithms: distance of their mean from that of the maximum, in units of three standard deviations.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Values of the units, outliers included. [SI]
    maximum : float
        [SI]
    level : float
        Confidence level of the interval [2]_.

    Returns
    -------
    BoundedNumber or None
        None for fewer than ten units, or without a spread.
    """
    n, logs = len(values), np.log(values)
    spread = float(np.std(logs, ddof=1)) if n > 1 else 0.0
    if n < LEAST_UNITS_OF_CPK or not spread > 0:
        return None
    value = (math.log(maximum) - float(logs.mean())) / (3 * spread)
    half = float(normal_quantile((1 + level) / 2)) * math.sqrt(1 / (9 * n) + value**2 / (2 * (n - 1)))
    return BoundedNumber(value=value, low=value - half, high=value + half)
