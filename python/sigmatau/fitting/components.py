"""The noise terms of a fit to Allan variances; their numbers are in `sigmatau._native.gls`.

Times are in samples: the sample interval is 1, and a squared coefficient θ is for this interval.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from sigmatau.noise.terms import NOISE, TERMS

_POWERS = {name: term.interval_power for name, term in TERMS.items()}
# smallest ratio of the record to an averaging time; longer times have about two degrees of freedom
LONGEST_SHARE = 3
MIN_TIMES = 8  # smallest number of averaging times: four terms, and four degrees of freedom for the goodness of fit


def power_of_interval(name: str) -> int:
    """Power p of a term: θ in samples is θ in SI times tau0^(p − 2); 2 for processes given by their variance."""
    return _POWERS.get(name, 2)


def linear_powers(model: Mapping[str, float], tau0: float) -> list[float]:
    """Squares θ of the coefficients of `NOISE` in samples; 0 for a term that is not in the model."""
    return [model.get(name, 0.0) ** 2 * tau0 ** (power_of_interval(name) - 2) for name in NOISE]


def coefficient(theta: float, name: str, tau0: float) -> float:
    """Convert θ in samples to a coefficient in SI."""
    return float(math.sqrt(max(theta, 0.0)) * tau0 ** (1 - power_of_interval(name) / 2))


def half_octaves(smallest: int, largest: int) -> Sequence[int]:
    """The cluster sizes among 1, 2, 3, 4, 6, 8, 12 … that lie between two sizes."""
    sizes = {seed << j for seed in (1, 3) for j in range(largest.bit_length())}
    return tuple(sorted(size for size in sizes if smallest <= size <= largest))
