"""Statistics of a lot: distribution of a coefficient over the units, its change in the order of production, and outliers.

Coefficients are positive, so that all computations use their logarithms; results are printed in per cent.

References
----------
.. [1] B. Rosner, "Percentage points for a generalized ESD many-outlier procedure," Technometrics, vol. 25, no. 2, 1983,
   :doi:`10.1080/00401706.1983.10487848`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import field
from typing import Any

import numpy as np

from sigmatau._native.distributions import student_quantile
from sigmatau.arrays import SIGMA_OF_MAD, Bools, Floats
from sigmatau.frozen import frozen
from sigmatau.lab.lots.order_effect import FittedOrder, OrderEffect, fit_order
from sigmatau.results import plain

FALSE_ALARMS = 0.05
"""Probability that comparing a lot without a fault results in any remark: the sum of the shares below (Bonferroni)."""

COEFFICIENT_SHARE, ORDER_SHARE, MEAN_SHARE = 0.025, 0.015, 0.01
"""Shares of the outliers of coefficients and curves, of drifts and batches, and of orientation, means and gravity."""

LEAST_UNITS = 6
"""Smallest number of units for an outlier: the scale of fewer is too uncertain."""

LEAST_DIFFERENCE = math.log(1.1)
"""Smallest difference of an outlier from the median, 10 %: less does not matter in production, even if it is significant."""

_MOST_OUTLIERS = 0.25  # largest share of the units that may be outliers
_ERRORS = 3.0  # smallest difference of an outlier in standard errors of its measurement


@frozen(eq=False)
class Series:
    """Values of a coefficient by unit, in the order of production.

    Attributes
    ----------
    channels : tuple of str
        The channel; or all axes of a sensor, if values are geometric means over them.
    what : str
        Term, ``"means_10"``, or ``"adev"``: the Allan deviation at the averaging time `tau`.
    units : tuple of str
        Names.
    logs : ndarray, shape (n,)
        Logarithms of the values, or of upper limits. [ln SI]
    errors : ndarray, shape (n,)
        Standard errors of the logarithms; 0 if unknown.
    limited : ndarray of bool, shape (n,)
        Which are upper limits.
    tau : float
        Averaging time of an Allan deviation. [s]
    dates : tuple of str
        Dates of the units, ``"2026-05-07"``; empty if not known.
    """

    channels: tuple[str, ...]
    what: str
    units: tuple[str, ...]
    logs: Floats
    errors: Floats
    limited: Bools
    tau: float = 0.0
    dates: tuple[str, ...] = ()


@frozen(eq=False)
class Distribution:
    """Values of one coefficient of one channel over the units of a lot.

    Attributes
    ----------
    channel, what : str
        Channel or sensor, and the coefficient: a term, ``"means_10"`` or ``"adev"``.
    units : tuple of str
        Names of the units that show it, in their order.
    values : ndarray, shape (n,)
        [SI]
    median, low, high : float
        Median, smallest and largest value. [SI]
    spread : float
        Standard deviation of the logarithms, from their median absolute deviation: about the relative standard deviation.
    below : int
        Units that do not show the coefficient.
    outliers : mapping of str to float
        Outlying units with their ratio to the median, or to the median after the change in the order is removed.
    order : OrderEffect or None
        Drift or batch; None unless it is significant.
    p_value : float or None
        P-value of no drift and no batch.
    channels : tuple of str
        The channel; or all axes of a sensor, if values are geometric means over them.
    tau : float
        Averaging time of an Allan deviation, otherwise 0. [s]
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
    order: OrderEffect | None = None
    p_value: float | None = None
    channels: tuple[str, ...] = ()
    tau: float = 0.0

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        fields = "channel what median low high spread below outliers"
        return plain(self, fields, order=self.order, p_value=self.p_value, units=len(self.units))


def distribution(channel: str, series: Series, *, families: int, order: FittedOrder | None = None) -> Distribution:
    """Compute the distribution of a coefficient over units, its change in their order, and its outliers.

    Parameters
    ----------
    channel : str
        Its channel or sensor.
    series : Series
    families : int
        Number of series of the lot, by which the false-alarm rate is divided.
    order : FittedOrder, optional
        Change of the sensor. It is removed before outliers are searched, if the series itself has no significant change.

    Returns
    -------
    Distribution
    """
    fitted = series_order(series, families=families)
    removed = fitted if fitted.effect is not None or order is None else order
    shown = ~series.limited
    logs, names = series.logs[shown], [name for name, is_shown in zip(series.units, shown, strict=True) if is_shown]
    rest = logs - np.array([removed.changes.get(name, 0.0) for name in names])
    rest = rest - float(np.median(rest))
    middle = float(np.median(logs))
    # Only slow noise above that of the lot is reported, so that the probability of both tails is given to one.
    sides = 2 if series.what == "adev" else 1
    picked = outliers(rest, series.errors[shown], probability=sides * COEFFICIENT_SHARE / families)
    picked = [k for k in picked if sides == 1 or rest[k] > 0]
    return Distribution(
        channel=channel,
        what=series.what,
        units=tuple(names),
        values=np.exp(logs),
        median=math.exp(middle),
        low=math.exp(float(logs.min())),
        high=math.exp(float(logs.max())),
        spread=SIGMA_OF_MAD * float(np.median(np.abs(logs - middle))),
        below=int(series.limited.sum()),
        outliers={names[k]: math.exp(float(rest[k])) for k in picked},
        order=fitted.effect,
        p_value=fitted.p_value,
        channels=series.channels,
        tau=series.tau,
    )


def series_order(series: Series, *, families: int) -> FittedOrder:
    """Fit the change of a series in the order of production, with the false-alarm rate of one of several series."""
    return fit_order(series.units, series.logs, series.limited, probability=ORDER_SHARE / families, dates=series.dates)


def outliers(logs: Floats, errors: Floats, *, probability: float) -> list[int]:
    """Indices of the values that do not belong to a normal distribution of the others, by the generalised extreme
    studentised deviate test [1]_.

    Parameters
    ----------
    logs : ndarray, shape (n,)
        Logarithms.
    errors : ndarray, shape (n,)
        Standard errors of the logarithms. A value within three standard errors is not an outlier.
    probability : float
        Probability that an outlier is reported in a lot without outliers.
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
        Values; if they are fewer than `LEAST_UNITS`, none is extreme.
    probability : float
        Probability that an extreme value is reported in a sample of one normal distribution.
    """
    n = len(values)
    if n < LEAST_UNITS:
        return []
    remaining, removed, last = list(range(n)), [], 0
    for k in range(max(int(_MOST_OUTLIERS * n), 1)):
        x = values[remaining]
        scale = float(np.std(x, ddof=1))
        if not scale > 0:
            # All remaining values are equal, and any other value is extreme.
            break
        worst = int(np.argmax(np.abs(x - x.mean())))
        ratio = abs(float(x[worst] - x.mean())) / scale
        removed.append(remaining.pop(worst))
        freedom = n - k - 2
        t = float(student_quantile(freedom, 1 - probability / (2 * (n - k))))
        if ratio > (n - k - 1) * t / math.sqrt((freedom + t * t) * (n - k)):
            last = len(removed)
    return sorted(removed[:last])
