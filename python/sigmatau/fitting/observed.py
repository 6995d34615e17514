"""Terms whose interval does not exclude 0: a limit."""

from __future__ import annotations

import math
from dataclasses import replace

from sigmatau.fitting.fitted_values import FittedTerm


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
