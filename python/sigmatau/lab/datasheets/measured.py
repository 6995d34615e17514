"""Measured values to compare with a claim: of a term, or of the minimum of the Allan deviation."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from sigmatau import ChannelModel
from sigmatau.errors import DataError
from sigmatau.fitting import MeanStability
from sigmatau.frozen import frozen
from sigmatau.lab.datasheets.claims import MINIMUM
from sigmatau.lab.datasheets.doubts import Doubt, DoubtKind
from sigmatau.model import min_adev, processes_avar
from sigmatau.noise.terms import SLOW

_SAME_AVERAGE = (
    0.05  # relative difference up to which averaging times count as equal: they are rounded to whole samples
)
_NEGLIGIBLE = 0.01  # share of a variance up to which processes are ignored: 0.5 % of a deviation [1]


@frozen
class Measured:
    """A measured quantity, in the unit of the claim.

    Attributes
    ----------
    value : float or None
        None if it was not observed. [unit of the claim]
    low, high : float or None
        Its interval, if known. [unit of the claim]
    upper_limit : float or None
        Upper limit if it was not observed. [unit of the claim]
    lower_limit : float or None
        Lower bound, from the terms that are known. [unit of the claim]
    level : float
        Confidence level of the interval or the limits; 1 for a bound from a model without intervals.
    doubt : Doubt or None
        Reason why there is no value, or what restricts it, such as terms that were not observed and may contribute.
    """

    value: float | None = None
    low: float | None = None
    high: float | None = None
    upper_limit: float | None = None
    lower_limit: float | None = None
    level: float = 0.95
    doubt: Doubt | None = None

    @property
    def anything(self) -> bool:
        """Whether there is a value or a limit."""
        return not (self.value is None and self.upper_limit is None and self.lower_limit is None)

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        names = ("value", "low", "high", "upper_limit", "lower_limit")
        values = {name: getattr(self, name) for name in names}
        numbers = {key: value for key, value in values.items() if value is not None}
        return {
            **numbers,
            **({"level": self.level} if numbers else {}),
            **({"words": self.doubt.words} if self.doubt else {}),
        }


def measured(model: ChannelModel, quantity: str) -> Measured:
    """Measured value of a term of a model, or of the minimum of its Allan deviation; of a ramp, its absolute value."""
    if quantity == MINIMUM:
        return _minimum(model)
    if quantity in model and quantity not in model.limits:
        low, high = model.intervals.get(quantity, (None, None))
        value = abs(model[quantity])
        if low is not None and high is not None:
            if not (math.isfinite(low) and math.isfinite(high) and low <= high):
                raise DataError(f"{quantity}: {low!r} to {high!r} is not an interval")
            low, high = (0.0 if low < 0 < high else min(abs(low), abs(high))), max(abs(low), abs(high))
            low, high = min(low, value), max(high, value)
        return Measured(value=value, low=low, high=high, level=model.level)
    if quantity in model.limits:
        return Measured(upper_limit=model.limits[quantity], level=model.level)
    return Measured(doubt=Doubt(kind="not_in_result"))


def measured_means(rows: Iterable[MeanStability]) -> dict[float, Measured]:
    """Standard deviations of means by averaging time in s."""
    by_average = {}
    for row in rows:
        ends: tuple[float | None, float | None] = (None, None)
        if row.low is not None and row.high is not None:
            ends = min(row.low, row.value), max(row.high, row.value)
        by_average[row.average] = Measured(value=row.value, low=ends[0], high=ends[1], level=row.level)
    return by_average


def stability(means: Mapping[float, Measured], average: float) -> Measured:
    """Find the standard deviation of means over an averaging time."""
    matching = (std for time, std in means.items() if math.isclose(time, average, rel_tol=_SAME_AVERAGE))
    return next(matching, Measured(doubt=Doubt(kind="no_means", average=average)))


def _minimum(model: ChannelModel) -> Measured:
    """Minimum of the Allan deviation of the model: σ² = 3Q²/τ² + N²/τ + 0.44 B² + K²τ/3 + R²τ²/2 + …

    Makers read it from a sufficiently long record. Every term increases it: the observed terms alone give a lower bound,
    and together with the limits of the others an upper bound.
    """
    observed = {term: abs(value) for term, value in model.terms.items() if term not in model.limits}
    limited = {term: limit for term, limit in model.limits.items() if term in SLOW}
    # A term that the model does not have need not be zero.
    lacks_bias = "bias_instability" not in observed and "bias_instability" not in limited
    if not any(term in observed for term in SLOW):
        return Measured(doubt=Doubt(kind="not_in_result")) if lacks_bias else _below(model, observed, limited)
    floor, _ = min_adev(observed)
    low, high = _interval(model, observed)
    if lacks_bias:
        return _above(model, low, observed, "no_bias_instability")
    value, tau = min_adev(observed, model, cancelled=True)
    if low is None or high is None:
        return Measured(value=value, level=model.level)
    if processes_avar(model, np.array(tau)) > _NEGLIGIBLE * value**2:
        return _above(model, low, observed, "processes")
    high *= value / floor
    if limited:
        high = max(high, min_adev({**observed, **limited}, model)[0])
    doubt = Doubt(kind="terms_at_limit", terms=tuple(sorted(limited))) if limited else None
    return Measured(value=value, low=low, high=high, level=model.level, doubt=doubt)


def _below(model: ChannelModel, observed: dict[str, float], limited: dict[str, float]) -> Measured:
    """Upper limit if no slow noise is observed: observed terms at their upper ends, the others at their limits."""
    ends = {term: max(map(abs, model.intervals.get(term, (value,)))) for term, value in observed.items()}
    limit, tau = min_adev({**ends, **limited}, model)
    if processes_avar(model, np.array(tau)) > _NEGLIGIBLE * limit**2:
        return Measured(doubt=Doubt(kind="no_interval"))
    return Measured(upper_limit=limit, level=model.level)


def _above(model: ChannelModel, low: float | None, observed: dict[str, float], why: DoubtKind) -> Measured:
    """Lower bound: the lower end for the observed terms; for a model without intervals, the value."""
    if low is None:
        return Measured(lower_limit=min_adev(observed, model, cancelled=True)[0], level=1.0, doubt=Doubt(kind=why))
    return Measured(lower_limit=low, level=(1 + model.level) / 2, doubt=Doubt(kind=why))


def _interval(model: ChannelModel, observed: dict[str, float]) -> tuple[float, float] | tuple[None, None]:
    """Interval of the minimum of the five terms: all at their lower ends, and all at their upper ends.

    The covariance of the chosen terms would give a narrower interval. It would be too narrow if a rate random walk is
    observed by chance: 3.8 % of 183 simulated records with N and B exactly at the limit were out at 99 %, instead of 1 %.
    """
    values = {term: measured(model, term) for term in observed}
    if all(value.low is None for value in values.values()):
        return None, None
    lows = {term: observed[term] if value.low is None else value.low for term, value in values.items()}
    highs = {term: observed[term] if value.high is None else value.high for term, value in values.items()}
    return min_adev(lows)[0], min_adev(highs)[0]
