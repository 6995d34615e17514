"""Statistics of a lot: distribution over units, outliers, drift over the order of production, scale of a whole unit.

Values are coefficients, which are positive: all computations use their logarithms, and results are printed in per cent.

References
----------
.. [1] B. Rosner, "Percentage points for a generalized ESD many-outlier procedure," Technometrics, vol. 25, no. 2, 1983,
   :doi:`10.1080/00401706.1983.10487848`.
.. [2] P. K. Sen, "Estimates of the regression coefficient based on Kendall's tau," J. Am. Stat. Assoc., vol. 63, 1968,
   :doi:`10.1080/01621459.1968.10480934`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import Any

import numpy as np

from sigmatau._native.distributions import student_below, student_quantile
from sigmatau.arrays import SIGMA_OF_MAD, Floats
from sigmatau.frozen import frozen
from sigmatau.results import plain
from sigmatau.units import STANDARD_GRAVITY

FALSE_ALARMS = 0.05
"""Probability that a lot without a fault gets any remark of its comparison: the sum of the shares below (Bonferroni)."""

COEFFICIENT_SHARE, ORDER_SHARE, MEAN_SHARE = 0.025, 0.015, 0.01
"""Shares of the outliers of coefficients and curves, of drifts and batches, and of orientation, means and gravity."""

LEAST_UNITS = 6
"""Smallest number of units for an outlier: the scale of fewer is too uncertain."""

LEAST_DIFFERENCE = math.log(1.1)
"""Smallest difference of an outlier from the median, 10 %: less does not matter in production, however significant it is."""

LEAST_IN_ORDER = 10
"""Smallest number of units in which a drift is searched."""

_MOST_OUTLIERS = 0.25  # largest share of the units that may be outliers
_ERRORS = 3.0  # smallest difference of an outlier in standard errors of its measurement
_MOST_SLOPES = 600  # number of units whose slopes are taken in pairs; of more units, evenly spaced ones are used


@frozen(eq=False)
class Distribution:
    """Values of one coefficient of one channel over the units of a lot.

    Attributes
    ----------
    channel, what : str
        Channel; and term, or ``"means_10"``.
    units : tuple of str
        Names of the units that show it, in their order.
    values : ndarray, shape (n,)
        [SI]
    median, low, high : float
        Median, smallest and largest value. [SI]
    spread : float
        Standard deviation of the logarithms, from their median absolute deviation: about a relative one.
    below : int
        Units that do not show the coefficient.
    outliers : mapping of str to float
        Outlying units, and their ratio to the median.
    drift : float or None
        Change over all units in their order, as a ratio minus 1; None unless it is significant.
    p_value : float or None
        P-value of the drift.
    """

    channel: str
    what: str
    units: tuple[str, ...]
    values: Floats
    median: float
    low: float
    high: float
    spread: float
    below: int = 0
    outliers: Mapping[str, float] = field(default_factory=dict)
    drift: float | None = None
    p_value: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        fields = "channel what median low high spread below outliers"
        return plain(self, fields, drift=self.drift, p_value=self.p_value, units=len(self.units))


def distribution(
    channel: str,
    what: str,
    values: Mapping[str, tuple[float, float]],
    *,
    below: int = 0,
    families: int = 1,
) -> Distribution:
    """The distribution of a coefficient over units.

    Parameters
    ----------
    channel, what : str
    values : mapping of str to (float, float)
        By unit, in the order of production: value in SI and relative standard error, 0 if not known.
    below : int
        Number of units that do not show it.
    families : int
        Number of distributions of the lot, which share the false alarms.
    """
    x = np.array([value for value, _ in values.values()])
    errors = np.array([error for _, error in values.values()])
    names, logs = tuple(values), np.log(x)
    middle = float(np.median(logs))
    ratios = {}
    for k in outliers(logs, errors, probability=COEFFICIENT_SHARE / families):
        ratios[names[k]] = math.exp(logs[k] - middle)
    change, p_value = trend(logs, probability=ORDER_SHARE / families)
    return Distribution(
        channel=channel,
        what=what,
        units=names,
        values=x,
        median=math.exp(middle),
        low=float(x.min()),
        high=float(x.max()),
        spread=SIGMA_OF_MAD * float(np.median(np.abs(logs - middle))),
        below=below,
        outliers=ratios,
        drift=None if change is None else math.expm1(change),
        p_value=p_value,
    )


def outliers(logs: Floats, errors: Floats, *, probability: float) -> list[int]:
    """Indices of the values that do not belong to a normal distribution of the others, by the generalised extreme
    studentised deviate test [1]_.

    Parameters
    ----------
    logs : ndarray, shape (n,)
        Logarithms.
    errors : ndarray, shape (n,)
        Standard errors of the logarithms: who was measured badly is not an outlier for it.
    probability : float
        That a lot without outliers has one.
    """
    middle = float(np.median(logs))
    return [
        k
        for k in extreme_values(logs, probability=probability)
        if abs(logs[k] - middle) >= max(LEAST_DIFFERENCE, _ERRORS * float(errors[k]))
    ]


def extreme_values(values: Floats, *, probability: float) -> list[int]:
    """Indices of the values that do not belong to a normal distribution, by the test of `outliers`, whatever their size.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Values; of fewer than `LEAST_UNITS`, none is extreme.
    probability : float
        That values of one normal distribution have an extreme one.
    """
    n = len(values)
    if n < LEAST_UNITS:
        return []
    remaining, removed, last = list(range(n)), [], 0
    for k in range(max(int(_MOST_OUTLIERS * n), 1)):
        x = values[remaining]
        scale = float(np.std(x, ddof=1))
        if not scale > 0:
            # If all others are equal, any other value is far from them.
            break
        worst = int(np.argmax(np.abs(x - x.mean())))
        ratio = abs(float(x[worst] - x.mean())) / scale
        removed.append(remaining.pop(worst))
        freedom = n - k - 2
        t = float(student_quantile(freedom, 1 - probability / (2 * (n - k))))
        if ratio > (n - k - 1) * t / math.sqrt((freedom + t * t) * (n - k)):
            last = len(removed)
    return sorted(removed[:last])


def trend(logs: Floats, *, probability: float) -> tuple[float | None, float | None]:
    """Change over all values in their order (median slope of all pairs [2]_ times n − 1) and its p-value, by the rank
    correlation with the order; the change is None unless it is significant.
    """
    n = len(logs)
    if n < LEAST_IN_ORDER or not np.ptp(logs) > 0:
        return None, None
    order = np.arange(n)
    rho = float(np.corrcoef(_ranks(logs), order)[0, 1])
    t = abs(rho) * math.sqrt((n - 2) / max(1 - rho * rho, 1e-300))
    p_value = min(2 * (1 - float(student_below(n - 2, t))), 1.0)
    if p_value >= probability:
        return None, p_value
    picked = np.unique(np.linspace(0, n - 1, min(n, _MOST_SLOPES)).round().astype(int))
    i, j = np.triu_indices(len(picked), 1)
    slopes = (logs[picked[j]] - logs[picked[i]]) / (picked[j] - picked[i])
    return float(np.median(slopes)) * (n - 1), p_value


def _ranks(x: Floats) -> Floats:
    """Ranks; tied values have their mean rank."""
    _, inverse, counts = np.unique(x, return_inverse=True, return_counts=True)
    ends = np.cumsum(counts)
    return np.asarray((ends - (counts - 1) / 2)[inverse], dtype=np.float64)


@frozen(eq=False)
class Band:
    """The curves of a channel over the units: median, and the range of the middle four fifths of them.

    Attributes
    ----------
    channel : str
    quantity, unit : str
        Quantity and unit of the rate; SI.
    tau : ndarray, shape (n_tau,)
        Averaging times of most units. [s]
    median, low, high : ndarray, shape (n_tau,)
        Median, 10 % and 90 % quantile of the units. [unit]
    curves : mapping of str to ndarray, shape (n_tau,)
        By unit, at these times; NaN where it has none. [unit]
    """

    channel: str
    quantity: str
    unit: str
    tau: Floats
    median: Floats
    low: Floats
    high: Floats
    curves: Mapping[str, Floats]


def band(channel: str, curves: Mapping[str, tuple[Floats, Floats]], *, quantity: str, unit: str) -> Band:
    """The band of a channel, from averaging times and deviations by unit."""
    grids: dict[bytes, int] = {}
    for tau, _ in curves.values():
        grids[tau.tobytes()] = grids.get(tau.tobytes(), 0) + 1
    grid = np.frombuffer(max(grids, key=lambda grid_bytes: (grids[grid_bytes], len(grid_bytes))), dtype=np.float64)
    by_unit: dict[str, Floats] = {}
    for name, (tau, adev) in curves.items():
        positive = adev > 0
        if not positive.any():
            continue
        logs = np.interp(np.log(grid), np.log(tau[positive]), np.log(adev[positive]), left=np.nan, right=np.nan)
        by_unit[name] = np.exp(logs)
    table = np.array(list(by_unit.values())) if by_unit else np.full((1, len(grid)), np.nan)
    enough = 2 * np.isfinite(table).sum(axis=0) >= len(table)
    enough_table = table[:, enough]
    low, median, high = np.nanquantile(enough_table, (0.1, 0.5, 0.9), axis=0) if enough.any() else np.empty((3, 0))
    return Band(
        channel=channel,
        quantity=quantity,
        unit=unit,
        tau=grid[enough],
        median=median,
        low=low,
        high=high,
        curves={name: curve[enough] for name, curve in by_unit.items()},
    )


def scale(band_: Band, name: str) -> float | None:
    """Logarithm of the ratio of a unit's curve to the median of the lot, by the median over averaging times; None if they
    have no averaging time in common.
    """
    curve = band_.curves.get(name)
    if curve is None:
        return None
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = np.log(curve / band_.median)
    finite = ratios[np.isfinite(ratios)]
    return float(np.median(finite)) if len(finite) else None


FACTORS: Mapping[str, Sequence[tuple[float, str, str]]] = {
    "angular_rate": (
        (180 / math.pi, "deg/s", "rad/s"),
        (3600.0, "deg/h", "deg/s"),
        (3600.0 * 180 / math.pi, "deg/h", "rad/s"),
        (1000.0, "mdeg/s", "deg/s"),
    ),
    "acceleration": (
        (STANDARD_GRAVITY, "m/s^2", "g"),
        (1000.0, "mg", "g"),
        (1000.0 / STANDARD_GRAVITY, "mg", "m/s^2"),
    ),
}
"""Factors of mistaken units by quantity: the numbers are in the first unit and were read in the second one."""

_SAME_FACTOR = math.log(1.1)


def mistaken_units(quantity: str, ratio: float) -> tuple[str, str] | None:
    """The unit of the numbers and the one that they were read in, if a mistaken unit explains the ratio."""
    for factor, written_in, read_as in FACTORS.get(quantity, ()):
        if abs(math.log(ratio / factor)) < _SAME_FACTOR:
            return written_in, read_as
        if abs(math.log(ratio * factor)) < _SAME_FACTOR:
            return read_as, written_in
    return None
