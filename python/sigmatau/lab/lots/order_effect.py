"""Change of a coefficient in the order of production: a drift, a batch, or a rise that begins with a unit.

All steps, batches and rises, and the straight line, are fitted by `estimate_effects`. The change is the one with the largest
ratio to its standard error [1]_; its p-value is multiplied by the number of these shapes.

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
_MOST_CUTS = 60  # largest number of change points that are tried; in a longer series they are evenly spaced
_REFINED = 12  # number of shapes that are fitted robustly: those that fit the clipped values best
# A change between two dates is likely in advance: it is chosen unless its log-likelihood is lower than the best one by more
# than this many ln n.
_TOLERANCE = 2.0
_CHANGE_POINTS = 2  # degrees of freedom lost by choosing the first and the last unit
_ADJACENT = 6  # largest distance of change points that are tried for the interval of a size [units]
_CLIP = 3.0  # difference from the median at which values are clipped, in standard deviations


@frozen
class OrderEffect:
    """A change in the order of production.

    Attributes
    ----------
    kind : {"drift", "batch", "rise"}
        A drift from the first to the last unit; a step of the units from `first` to `last`; or a rise that begins with
        `first` and grows from unit to unit.
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
        The change at each unit against a unit before the change; empty without an effect. [ln]
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
        Probability that a change is detected in a series without one.
    dates : sequence of str, optional
        Dates of the units. A change between two dates is preferred if it fits about as well as the best one.

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
    """Whether a shape is of the same kind as another, and its change points are at most a few units away."""
    same_end = (shape.stop == center.stop) or center.stop < len(center.values)
    places = (abs(shape.start - center.start), abs(shape.stop - center.stop))
    return (
        shape.kind == center.kind and same_end and max(places) <= _ADJACENT * max(len(center.values) // _MOST_CUTS, 1)
    )


def _between_units(shape: _Shape) -> list[Floats]:
    """Rises that begin between two units, close to the start of a rise."""
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
            # If more than half of the units differ, the others are the batch, unless the change lasts to the end.
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
    """Positions of the shapes to fit robustly: those that fit the clipped values best by least squares, the best of them
    between two dates, and the straight line, which is the first.
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
    """Choose the straight line, which is the first, or the best change between two dates, if it fits about as well."""
    if likelihoods[best] - likelihoods[0] < tolerance:
        return 0
    if dated.any():
        first = int(np.flatnonzero(dated)[np.argmax(likelihoods[dated])])
        if likelihoods[best] - likelihoods[first] < _TOLERANCE * tolerance:
            return first
    return best
