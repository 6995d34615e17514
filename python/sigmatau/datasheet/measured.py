"""What a result says of a term, or of the minimum of its Allan deviation: a value, or what it is below."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.datasheet.claims import MINIMUM
from sigmatau.errors import DataError
from sigmatau.model import ChannelModel
from sigmatau.terms import BIAS_LEVEL

__all__ = ["Measured", "measured"]

Floats = NDArray[np.float64]

_SLOW = ("bias_instability", "rate_random_walk", "rate_ramp")
_RISING = ("rate_random_walk", "rate_ramp")
_TAU = (-6.0, 12.0)  # decades that are searched for a minimum; a random walk alone has none in any range [log10 s]


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """What a result says. [unit of the claim]

    Attributes
    ----------
    value : float or None
        None if it was not observed.
    low, high : float or None
        Its interval, if it has one.
    upper_limit : float or None
        What it is below, if it was not observed.
    level : float
        Probability of the interval.
    words : str
        Why there is nothing, or what was not seen and may be there.
    """

    value: float | None = None
    low: float | None = None
    high: float | None = None
    upper_limit: float | None = None
    level: float = 0.95
    words: str = ""

    @property
    def anything(self) -> bool:
        """Whether there is a value or a limit."""
        return self.value is not None or self.upper_limit is not None

    def to_dict(self) -> dict[str, Any]:
        known = {"value": self.value, "low": self.low, "high": self.high, "upper_limit": self.upper_limit}
        kept = {key: value for key, value in known.items() if value is not None}
        return {**kept, **({"level": self.level} if kept else {}), **({"words": self.words} if self.words else {})}


def measured(model: ChannelModel, of: str) -> Measured:
    """What a model says of one of its terms, or of the minimum of its Allan deviation; a ramp without its sign."""
    if of == MINIMUM:
        return _minimum(model)
    if of in model and of not in model.limits:
        low, high = model.intervals.get(of, (None, None))
        value = abs(model[of])
        if low is not None and high is not None:
            if not (math.isfinite(low) and math.isfinite(high) and low <= high):
                raise DataError(f"{of}: {low!r} to {high!r} is no interval")
            low, high = (0.0 if low < 0 < high else min(abs(low), abs(high))), max(abs(low), abs(high))
            low, high = min(low, value), max(high, value)
        return Measured(value=value, low=low, high=high, level=model.level)
    if of in model.limits:
        return Measured(upper_limit=model.limits[of], level=model.level)
    return Measured(words="the result says nothing of it")


def _minimum(model: ChannelModel) -> Measured:
    """The least Allan deviation at any time, of the model's own curve: σ² = 3Q²/τ² + N²/τ + 0.44 B² + K²τ/3 + R²τ²/2.

    That is what a maker reads off a record that is long enough. Terms that were not seen can make it larger, so the upper
    end is that of the curve with all of them at their limits.
    """
    if model.gauss_markov or model.sinusoid:
        return Measured(words="a Gauss-Markov process or a sinusoid leaves the curve more than one minimum")
    seen = {term: abs(value) for term, value in model.terms.items() if term not in model.limits}
    unseen = {term: limit for term, limit in model.limits.items() if term in _SLOW}
    if "bias_instability" not in seen and "bias_instability" not in unseen:
        # A model may be silent of it, which does not make it zero.
        return Measured(words="the result says nothing of it")
    if not any(term in seen for term in _SLOW):
        # What was seen is taken at the upper end of its interval, what was not at its limit.
        ends = {term: max(map(abs, model.intervals.get(term, (value,)))) for term, value in seen.items()}
        limit, _ = _least({**ends, **unseen})
        return Measured(upper_limit=limit, level=model.level)
    value, tau = _least(seen)
    low, high = _interval(model, seen, value, tau)
    if high is not None and unseen:
        high = max(high, _least({**seen, **unseen})[0])
    words = f"with {' and '.join(sorted(unseen)).replace('_', ' ')} at the limit up to the upper end" if unseen else ""
    return Measured(value=value, low=low, high=high, level=model.level, words=words if high is not None else "")


def _interval(
    model: ChannelModel, seen: dict[str, float], value: float, tau: float
) -> tuple[float, float] | tuple[None, None]:
    if not any(term in seen for term in _RISING):
        # A plateau alone: its own interval, which need not be symmetrical.
        plateau = measured(model, "bias_instability")
        if plateau.low is None or plateau.high is None:
            return None, None
        return BIAS_LEVEL * plateau.low, BIAS_LEVEL * plateau.high
    names, covariance = model.covariance
    if not set(seen) <= set(names):
        return None, None
    # At a minimum the time has no first-order effect: dσ²/dc = 2·c·a(τ).
    gradient = np.array([2 * seen[n] * float(_share(n, np.array(tau))) if n in seen else 0.0 for n in names])
    variance = float(gradient @ covariance @ gradient)
    if not (math.isfinite(variance) and variance >= 0):
        return None, None
    relative = math.sqrt(variance) / (2 * value**2)
    reach = NormalDist().inv_cdf((1 + model.level) / 2) * relative
    return value * math.exp(-reach), value * math.exp(reach)


def _least(coefficients: dict[str, float]) -> tuple[float, float]:
    """The least of the Allan deviation, and where; relative error below 1e-6."""
    low, high = _TAU
    for points in (721, 201):  # the second grid is within a step of the first's least point
        log_tau = np.linspace(low, high, points)
        avar = sum(value**2 * _share(term, 10.0**log_tau) for term, value in coefficients.items())
        k = int(np.argmin(avar))
        step = float(log_tau[1] - log_tau[0])
        low, high = float(log_tau[k]) - step, float(log_tau[k]) + step
    return math.sqrt(float(np.asarray(avar)[k])), 10.0 ** float(log_tau[k])


def _share(term: str, tau: Floats) -> Floats:
    """σ²(τ) of a term with coefficient 1, eqs. (15), (17), (19), (21), (23) of the paper."""
    shares = {
        "quantization": 3 / tau**2,
        "random_walk": 1 / tau,
        "bias_instability": np.full_like(tau, BIAS_LEVEL**2),
        "rate_random_walk": tau / 3,
        "rate_ramp": tau**2 / 2,
    }
    return np.asarray(shares[term])
