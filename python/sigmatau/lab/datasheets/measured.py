"""Value, interval or limits of a term of a result, or of the minimum of its Allan deviation."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import kernels
from sigmatau.errors import DataError
from sigmatau.fitting.mean_stability import MeanStability
from sigmatau.lab.datasheets.claims import MINIMUM
from sigmatau.lab.datasheets.doubts import Doubt, DoubtKind
from sigmatau.model.channel import ChannelModel
from sigmatau.model.covariance import exponential_less
from sigmatau.noise.terms import BIAS_LEVEL

Floats = NDArray[np.float64]

_SLOW = ("bias_instability", "rate_random_walk", "rate_ramp")
_SAME_AVERAGE = 0.05  # relative difference of averaging times, which are whole samples
_NEGLIGIBLE = 0.01  # share of a variance; 0.5 % of a deviation
_TAU = (-6.0, 12.0)  # search range for a minimum; a random walk alone has none [log10 s]


@dataclass(frozen=True, slots=True, kw_only=True)
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
        Lower bound if only a part is known. [unit of the claim]
    level : float
        Confidence level of the interval or the limits; 1 for a limit from a model without intervals.
    doubt : Doubt or None
        Why nothing is known, or terms that were not observed and may contribute.
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
        known = {name: getattr(self, name) for name in names}
        kept = {key: value for key, value in known.items() if value is not None}
        return {
            **kept,
            **({"level": self.level} if kept else {}),
            **({"words": self.doubt.words} if self.doubt else {}),
        }


def measured(model: ChannelModel, of: str) -> Measured:
    """A term of a model, or the minimum of its Allan deviation; the absolute value of a ramp."""
    if of == MINIMUM:
        return _minimum(model)
    if of in model and of not in model.limits:
        low, high = model.intervals.get(of, (None, None))
        value = abs(model[of])
        if low is not None and high is not None:
            if not (math.isfinite(low) and math.isfinite(high) and low <= high):
                raise DataError(f"{of}: {low!r} to {high!r} is not an interval")
            low, high = (0.0 if low < 0 < high else min(abs(low), abs(high))), max(abs(low), abs(high))
            low, high = min(low, value), max(high, value)
        return Measured(value=value, low=low, high=high, level=model.level)
    if of in model.limits:
        return Measured(upper_limit=model.limits[of], level=model.level)
    return Measured(doubt=Doubt(kind="not_in_result"))


def measured_means(rows: Iterable[MeanStability]) -> dict[float, Measured]:
    """Standard deviations of means by averaging time in s."""
    found = {}
    for row in rows:
        ends: tuple[float | None, float | None] = (None, None)
        if row.low is not None and row.high is not None:
            ends = min(row.low, row.value), max(row.high, row.value)
        found[row.average] = Measured(value=row.value, low=ends[0], high=ends[1], level=row.level)
    return found


def stability(means: Mapping[float, Measured], average: float) -> Measured:
    """The standard deviation of means of an averaging time."""
    near = (found for at, found in means.items() if math.isclose(at, average, rel_tol=_SAME_AVERAGE))
    return next(near, Measured(doubt=Doubt(kind="no_means", average=average)))


def _minimum(model: ChannelModel) -> Measured:
    """The minimum of the Allan deviation of the model: σ² = 3Q²/τ² + N²/τ + 0.44 B² + K²τ/3 + R²τ²/2 + … A maker reads
    it from a sufficiently long record. Every term adds to it, so that the observed terms give a lower bound, and the
    observed terms with the limits of the others give an upper bound.
    """
    seen = {term: abs(value) for term, value in model.terms.items() if term not in model.limits}
    unseen = {term: limit for term, limit in model.limits.items() if term in _SLOW}
    # A term that is not in the model need not be zero.
    silent = "bias_instability" not in seen and "bias_instability" not in unseen
    if not any(term in seen for term in _SLOW):
        return Measured(doubt=Doubt(kind="not_in_result")) if silent else _below(model, seen, unseen)
    floor, _ = _least(seen)
    low, high = _interval(model, seen)
    if silent:
        return _above(model, low, seen, "no_bias_instability")
    value, tau = _least(seen, model, cancelled=True)
    if low is None or high is None:
        return Measured(value=value, level=model.level)
    if _extra(model, np.array(tau)) > _NEGLIGIBLE * value**2:
        return _above(model, low, seen, "processes")
    high *= value / floor
    if unseen:
        high = max(high, _least({**seen, **unseen}, model)[0])
    doubt = Doubt(kind="terms_at_limit", terms=tuple(sorted(unseen))) if unseen else None
    return Measured(value=value, low=low, high=high, level=model.level, doubt=doubt)


def _below(model: ChannelModel, seen: dict[str, float], unseen: dict[str, float]) -> Measured:
    """Upper limit without observed slow noise: observed terms at their upper ends, the others at their limits."""
    ends = {term: max(map(abs, model.intervals.get(term, (value,)))) for term, value in seen.items()}
    limit, tau = _least({**ends, **unseen}, model)
    if _extra(model, np.array(tau)) > _NEGLIGIBLE * limit**2:
        return Measured(doubt=Doubt(kind="no_interval"))
    return Measured(upper_limit=limit, level=model.level)


def _above(model: ChannelModel, low: float | None, seen: dict[str, float], why: DoubtKind) -> Measured:
    """A lower bound: the lower end for the observed terms, or the value of a model without intervals."""
    if low is None:
        return Measured(lower_limit=_least(seen, model, cancelled=True)[0], level=1.0, doubt=Doubt(kind=why))
    return Measured(lower_limit=low, level=(1 + model.level) / 2, doubt=Doubt(kind=why))


def _interval(model: ChannelModel, seen: dict[str, float]) -> tuple[float, float] | tuple[None, None]:
    """Interval of the minimum of the five terms: all at their lower ends, and all at their upper ends. The covariance
    of the chosen terms would give a narrower interval, but if a rate random walk is found by chance, the error of the
    minimum is larger: of 183 simulated records of N and B exactly at the limit, 3.8 % were out at 99 % instead of 1 %.
    """
    found = {term: measured(model, term) for term in seen}
    if all(one.low is None for one in found.values()):
        return None, None
    lows = {term: seen[term] if one.low is None else one.low for term, one in found.items()}
    highs = {term: seen[term] if one.high is None else one.high for term, one in found.items()}
    return _least(lows)[0], _least(highs)[0]


def _extra(model: ChannelModel, tau: Floats, *, cancelled: bool = False) -> Floats:
    """σ²(τ) of Gauss-Markov processes and sinusoids (IEEE Std 952-2020, annex C) and resonances, with lines at the maxima of
    their ripple; or at the minima if they are `cancelled`, because a line cancels after whole periods.
    """
    total = np.zeros_like(tau)
    for process in model.gauss_markov:
        at_each = (kernels.gauss_markov_avar(process.sigma, process.time, 1, t, averaged=True)[0] for t in tau.flat)
        total += np.fromiter(at_each, dtype=np.float64).reshape(tau.shape)
    for one in model.resonance:
        x = np.asarray((one.damping - 1j * one.turning) * tau, dtype=np.complex128)
        means = 2 * exponential_less(x) / x**2 - (np.expm1(-x) / x) ** 2  # variance of a mean, less that with the next
        total += one.sigma**2 * ((1 + 1j * one.damping / one.turning) * means).real
    for line in model.sinusoid:
        periods = line.frequency * tau
        ripple = np.sin(math.pi * np.minimum(periods, 1.0)) ** 4
        at = np.where(periods >= 1, 0.0, ripple) if cancelled else np.where(periods >= 0.5, 1.0, ripple)
        total += line.amplitude**2 * at / (math.pi * periods) ** 2
    return total


def _least(
    coefficients: dict[str, float], model: ChannelModel | None = None, *, cancelled: bool = False
) -> tuple[float, float]:
    """Minimum of the Allan deviation and its averaging time; relative error below 1e-6. `model`: adds its processes."""
    low, high = _TAU
    for points in (721, 201):  # the second grid is around the minimum of the first
        log_tau = np.linspace(low, high, points)
        tau = 10.0**log_tau
        avar = sum(value**2 * _share(term, tau) for term, value in coefficients.items())
        avar = avar if model is None else avar + _extra(model, tau, cancelled=cancelled)
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
