"""Change of a coefficient in the order of production: a drift, a batch, or a rise that begins with a unit.

The change point is that of the shape with the largest ratio to its standard error [1]_, among all steps, batches, rises and
the straight line; the p-value is multiplied by their number. Each shape is fitted by `estimate_effects`.

References
----------
.. [1] A. B. Olshen, E. S. Venkatraman, R. Lucito, M. Wigler, "Circular binary segmentation for the analysis of array-based
   DNA copy number data," Biostatistics, vol. 5, 2004, :doi:`10.1093/biostatistics/kxh008`.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np

from sigmatau._native.distributions import student_below, student_quantile
from sigmatau.arrays import SIGMA_OF_MAD, Bools, Floats, Ints
from sigmatau.frozen import frozen
from sigmatau.lab.lots.robust_effect import estimate_effects
from sigmatau.results import plain

EffectKind = Literal["drift", "batch", "rise"]

LEAST_IN_ORDER = 10
"""Smallest number of units in which a drift or a batch is searched."""

LEVEL = 0.95
"""Confidence level of the size of a drift or a batch."""

_LEAST_BATCH = 4  # smallest number of units of a batch: the scale of fewer is too uncertain
_MOST_CUTS = 60  # largest number of change points that are tried; of more units, evenly spaced ones
_REFINED = 12  # number of shapes that are fitted robustly, the best ones of the fit to clipped values
_TOLERANCE = (
    2.0  # difference of the likelihood that a change between two dates may have, in ln n: it is likely before the test
)
_CHANGE_POINTS = 2  # degrees of freedom that the choice of the first and the last unit takes
_ADJACENT = 6  # largest distance of change points that are tried for the interval of a size [units]
_CLIP = 3.0  # largest difference from the median in that fit, in standard deviations


@frozen
class OrderEffect:
    """A change in the order of production.

    Attributes
    ----------
    kind : {"drift", "batch", "rise"}
        From the first to the last unit; of the units from `first` to `last`; or from `first` on, from unit to unit.
    first, last : str
        First and last unit that differ.
    units : int
        Number of these units.
    change, low, high : float
        Change with its 95 % interval, as a ratio minus 1: of a drift from the first to the last unit, of a batch against the
        other units, of a rise from unit to unit.
    p_value : float
        P-value of no change, corrected for the number of shapes that were tried.
    """

    kind: EffectKind
    first: str
    last: str
    units: int
    change: float
    low: float
    high: float
    p_value: float

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return plain(self, "kind first last units change low high p_value")


@frozen(eq=False)
class FittedOrder:
    """The change of a series in the order of production, if there is one.

    Attributes
    ----------
    effect : OrderEffect or None
        None if no change is significant.
    p_value : float or None
        P-value of no change; None for a series that is too short.
    changes : mapping of str to float
        The change at each unit, without the value before it; empty without an effect. [ln]
    """

    effect: OrderEffect | None
    p_value: float | None
    changes: Mapping[str, float]


@frozen(eq=False)
class _Shape:
    kind: EffectKind
    start: int
    stop: int
    values: Floats


def fit_order(
    names: Sequence[str], logs: Floats, limited: Bools, *, probability: float, dates: Sequence[str] = ()
) -> FittedOrder:
    """Find the change of a series of logarithms in its order.

    Parameters
    ----------
    names : sequence of str
        Units in the order of production.
    logs : ndarray, shape (n,)
        Logarithms of the values, or of upper limits.
    limited : ndarray of bool, shape (n,)
        Which are upper limits.
    probability : float
        That a series without a change has one.
    dates : sequence of str, optional
        Dates of the units. Of change points that fit about as well, one between two dates is chosen.

    Returns
    -------
    FittedOrder
    """
    n = len(logs)
    nothing = FittedOrder(effect=None, p_value=None, changes={})
    if n < LEAST_IN_ORDER or 2 * int(limited.sum()) > n or not np.ptp(logs) > 0:
        return nothing
    shapes = _shapes(n)
    table = np.array([shape.values for shape in shapes])
    between = [k for k, shape in enumerate(shapes) if _is_between_dates(shape, dates)]
    picked = _best(table, logs, between)
    effects = estimate_effects(table[picked], logs, limited)
    ratios = np.nan_to_num(np.abs(effects.value / effects.error))
    best = int(np.argmax(ratios))
    freedom = max(effects.freedom - _CHANGE_POINTS, 1)
    p_value = min(2 * len(shapes) * float(student_below(freedom, -ratios[best])), 1.0)
    if p_value >= probability:
        return FittedOrder(effect=None, p_value=p_value, changes={})
    best = _simplest(effects.likelihood, int(np.argmax(effects.likelihood)), np.isin(picked, between), math.log(n))
    shape = shapes[int(picked[best])]
    change = float(effects.value[best])
    adjacent = [shape_.values for shape_ in shapes if _is_adjacent(shape_, shape)]
    low, high = _interval(shape.values, [*adjacent, *_between_units(shape)], logs, limited)
    effect = OrderEffect(
        kind=shape.kind,
        first=names[shape.start],
        last=names[shape.stop - 1],
        units=shape.stop - shape.start,
        change=math.expm1(change),
        low=math.expm1(low),
        high=math.expm1(high),
        p_value=p_value,
    )
    changes = dict(zip(names, (change * shape.values).tolist(), strict=True))
    return FittedOrder(effect=effect, p_value=p_value, changes=changes)


def _is_adjacent(shape: _Shape, center: _Shape) -> bool:
    """Whether a shape is of the same kind, with change points within a few units of those of another one."""
    same_end = (shape.stop == center.stop) or center.stop < len(center.values)
    places = (abs(shape.start - center.start), abs(shape.stop - center.stop))
    return (
        shape.kind == center.kind and same_end and max(places) <= _ADJACENT * max(len(center.values) // _MOST_CUTS, 1)
    )


def _between_units(shape: _Shape) -> list[Floats]:
    """Rises that begin between two units, about the same place."""
    if shape.kind != "rise":
        return []
    order = np.arange(len(shape.values))
    return [np.maximum(order - shape.start + 1 - offset, 0.0) for offset in np.arange(0.5 - _ADJACENT, _ADJACENT)]


def _interval(center: Floats, adjacent: Sequence[Floats], logs: Floats, limited: Bools) -> tuple[float, float]:
    """Interval of the size by profile likelihood over the change points, because these are estimated too."""
    effects = estimate_effects(np.array([center, *adjacent]), logs, limited)
    quantile = float(student_quantile(effects.freedom, (1 + LEVEL) / 2))
    deficit = effects.likelihood.max() - effects.likelihood
    deficit[0] = 0.0
    half = effects.error * np.sqrt(np.maximum(quantile**2 - 2 * deficit, 0.0))
    inside = 2 * deficit < quantile**2
    return float((effects.value - half)[inside].min()), float((effects.value + half)[inside].max())


@functools.lru_cache(maxsize=16)
def _shapes(n: int) -> tuple[_Shape, ...]:
    """The straight line, then all rises and batches."""
    order = np.arange(n, dtype=np.float64)
    shapes = [_Shape(kind="drift", start=0, stop=n, values=order / (n - 1))]
    cuts = np.unique(np.linspace(0, n, min(n, _MOST_CUTS) + 1).round().astype(int)).tolist()
    for start in cuts:
        if _LEAST_BATCH <= start <= n - _LEAST_BATCH:
            shapes.append(_Shape(kind="rise", start=start, stop=n, values=np.maximum(order - start + 1, 0.0)))
        for stop in cuts:
            inside = stop - start
            # A batch of more than half of the units is the others' change, unless it is the end.
            small = _LEAST_BATCH <= inside <= n / 2 or (stop == n and _LEAST_BATCH <= inside <= n - _LEAST_BATCH)
            if small and not (start == 0 and 2 * inside == n):
                values = ((order >= start) & (order < stop)).astype(np.float64)
                shapes.append(_Shape(kind="batch", start=start, stop=stop, values=values))
    return tuple(shapes)


def _is_between_dates(shape: _Shape, dates: Sequence[str]) -> bool:
    """Whether a batch or a rise begins and ends with a date, or with the lot."""
    n = len(dates)
    cuts = [cut for cut in (shape.start, shape.stop) if 0 < cut < n]
    return bool(cuts) and all(dates[cut] and dates[cut] != dates[cut - 1] for cut in cuts)


def _best(table: Floats, logs: Floats, between: Sequence[int]) -> Ints:
    """Positions of the shapes that fit clipped values best by least squares; of the straight line, which is the first; and
    of the best ones between two dates.
    """
    middle = float(np.median(logs))
    scale = SIGMA_OF_MAD * float(np.median(np.abs(logs - middle)))
    clipped = np.clip(logs, middle - _CLIP * scale, middle + _CLIP * scale) if scale > 0 else logs
    centered = table - table.mean(axis=1, keepdims=True)
    product = np.abs(centered @ (clipped - clipped.mean())) / np.sqrt((centered**2).sum(axis=1))
    every = np.argsort(-product, kind="stable")[:_REFINED]
    dated = sorted(between, key=lambda k: -float(product[k]))[:_REFINED]
    return np.unique(np.concatenate([[0], every, np.array(dated, dtype=np.int64)])).astype(np.int64)


def _simplest(likelihoods: Floats, best: int, dated: Bools, tolerance: float) -> int:
    """The straight line, which is the first, or the best change between two dates, if it fits about as well as the best."""
    if likelihoods[best] - likelihoods[0] < tolerance:
        return 0
    if dated.any():
        first = int(np.flatnonzero(dated)[np.argmax(likelihoods[dated])])
        if likelihoods[best] - likelihoods[first] < _TOLERANCE * tolerance:
            return first
    return best
