"""Observed terms: an interval that excludes 0 and has the estimate inside. A term without one is a limit."""

from __future__ import annotations

import math
from dataclasses import replace

from sigmatau._native.distributions import normal_quantile
from sigmatau.fitting.noise_fit import FittedTerm

_NOT_KNOWN = 700.0  # logarithm of a ratio that is as good as infinite


def observed_term(
    *, term: str, unit: str, level: float, p_value: float, value: float, low: float, high: float, error: float
) -> FittedTerm:
    """A significant term, from its estimate and its interval, which come from models with different other terms.

    Parameters
    ----------
    value : float
        Estimate, in the model that describes the record. [unit]
    low, high : float
        Interval, with all terms free. [unit]
    error : float
        Standard error of the estimate in its model; joined to an interval that has the estimate not inside. [unit]
    """
    if value > 0 and low > 0 and not low < value < high:
        away = -float(normal_quantile((1 - level) / 2)) * max(error, 0.0) / value
        ratio = math.exp(away) if away < _NOT_KNOWN else math.inf
        low, high = min(low, value / ratio), max(high, value * ratio)
    found = FittedTerm(
        term=term, unit=unit, observed=True, level=level, value=value, low=low, high=high, p_value=p_value
    )
    return found if 0 < low < value < high else limit_of(found)


def limit_of(found: FittedTerm) -> FittedTerm:
    """A term whose interval does not exclude 0: its upper limit, or that of the magnitude of a ramp."""
    ends = [abs(end) for end in (found.low, found.high, found.value) if end is not None]
    limit = max(ends, default=math.inf)
    return replace(
        found,
        observed=False,
        value=None,
        low=None,
        high=None,
        upper_limit=limit if math.isfinite(limit) and limit > 0 else None,
        p_value=None if found.p_value is None else max(found.p_value, 1 - found.level),
    )
