"""Results of a fit from its numbers: units, intervals, limits, verdicts."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.likelihood import significant_term
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.findings.kinds.fit import Misfit, NoCovariance, Reason, ShortTimesDeviate
from sigmatau.fitting.components import LINEAR, power_of_interval
from sigmatau.fitting.noise_fit import FittedTerm, GaussMarkov, Interval, NoiseFit, fitted_term
from sigmatau.noise.terms import coefficient_unit

_FITTED = (*LINEAR, "rate_ramp")  # order of a descriptive fit


def stated(
    curve: DeviationCurve,
    found: dict[str, Any],
    m: NDArray[np.int64],
    candidates: list[int],
    scale: float,
    level: float,
) -> NoiseFit:
    """The result for an adequate model: intervals of the observed terms, upper limits of the others. `found` is of
    `sigmatau._native.gls.fit_curve`, and `scale` the variance by which the data were divided.
    """
    tau0, theta = curve.tau0, found["theta"]
    model = {name: coefficient(theta[p] * scale, name, tau0) for p, name in enumerate(LINEAR) if theta[p] > 0}
    covariance = _covariance(model, theta, found["covariance"])
    errors = dict(zip(covariance[0], np.sqrt(np.maximum(covariance[1].diagonal(), 0.0)).tolist(), strict=True))
    terms = {}
    for p in candidates:
        name = LINEAR[p]
        value = model.get(name, 0.0) if p in found["observed"] else None
        terms[name] = _term(curve, name, found["evidence"][p], value, errors.get(name, 0.0), scale, level)
    unclear = [LINEAR[p] for p in found["unclear"] or ()]
    if found["ramp"] is not None:
        *ramp, undecided = found["ramp"]
        terms["rate_ramp"] = _ramp(curve, ramp, scale, level)
        if terms["rate_ramp"].value is not None:
            model["rate_ramp"] = terms["rate_ramp"].value
        if undecided and found["unclear"] is not None:
            unclear.append("rate_ramp")
    reasons: tuple[Reason, ...] = ()
    if found["left_out"] is not None:
        worst, ratio = found["left_out"]
        reasons = (ShortTimesDeviate(cluster_size=int(m[worst]), ratio=ratio),)
    return NoiseFit(
        channel=curve.channel,
        quantity=curve.quantity,
        rate_unit=curve.unit,
        n=curve.n,
        tau0=tau0,
        terms=terms,
        gauss_markov=_process(curve, found["process"], scale),
        model=model,
        verdict="adequate",
        reasons=reasons,
        unclear=tuple(unclear),
        tau_min=int(m[found["first"]]) * tau0,
        tau_max=int(m[-1]) * tau0,
        p_value=found["p_value"],
        covariance=covariance,
        level=level,
    )


def descriptive(
    curve: DeviationCurve,
    found: dict[str, Any],
    m: NDArray[np.int64],
    allowed: Collection[str],
    ramp: float,
    scale: float,
    level: float,
) -> NoiseFit:
    """The result if no model is adequate: coefficients that describe the curve to a few per cent. `allowed`: terms that were
    fitted; `ramp`: that of the longest averaging time, whose sign it gives to the term.
    """
    worst, ratio = found["worst"]
    tau_min = int(m[found["first"]]) * curve.tau0
    reason: Reason = NoCovariance()
    if not found["no_covariance"]:
        reason = Misfit(p_value=found["p_value"], tau_min=tau_min, tau=float(m[worst]) * curve.tau0, ratio=ratio)
    needed = {_FITTED[p]: coefficient(found["theta"][p] * scale, _FITTED[p], curve.tau0) for p in found["needed"]}
    if "rate_ramp" in needed:
        needed["rate_ramp"] = math.copysign(needed["rate_ramp"], ramp)
    terms = {
        name: FittedTerm(
            term=name,
            unit=coefficient_unit(name, curve.quantity, curve.unit),
            observed=None,
            level=level,
            value=needed.get(name),
        )
        for name in _FITTED
        if name in allowed
    }
    return NoiseFit(
        channel=curve.channel,
        quantity=curve.quantity,
        rate_unit=curve.unit,
        n=curve.n,
        tau0=curve.tau0,
        terms=terms,
        model=needed,
        verdict="descriptive",
        reasons=(reason,),
        tau_min=tau_min,
        tau_max=int(m[-1]) * curve.tau0,
        level=level,
    )


def no_fit(curve: DeviationCurve, level: float, reason: Reason) -> NoiseFit:
    """The result for a curve that cannot be fitted."""
    return NoiseFit(
        channel=curve.channel,
        quantity=curve.quantity,
        rate_unit=curve.unit,
        n=curve.n,
        tau0=curve.tau0,
        terms={},
        model={},
        verdict="too_short",
        reasons=(reason,),
        level=level,
    )


def coefficient(theta: float, name: str, tau0: float) -> float:
    """A coefficient in SI from its θ in samples."""
    power = 4 if name == "rate_ramp" else power_of_interval(name)
    return float(math.sqrt(max(theta, 0.0)) * tau0 ** (1 - power / 2))


def _term(
    curve: DeviationCurve,
    name: str,
    evidence: tuple[float, float, float] | None,
    value: float | None,
    error: float,
    scale: float,
    level: float,
) -> FittedTerm:
    """The result for one noise term; `value` is its coefficient if it was observed, with a standard `error`. Without
    evidence: it was not fitted.
    """
    unit = coefficient_unit(name, curve.quantity, curve.unit)
    if evidence is None:
        return FittedTerm(term=name, unit=unit, observed=False, level=level)
    p_value, low, high = evidence
    high = coefficient(high * scale, name, curve.tau0)
    if value is not None:
        low = coefficient(low * scale, name, curve.tau0)
        return fitted_term(name, unit, significant_term(value, low, high, error, p_value, level), level=level)
    limit = high if math.isfinite(high) else None
    return FittedTerm(term=name, unit=unit, observed=False, level=level, p_value=p_value, upper_limit=limit)


def _ramp(curve: DeviationCurve, ramp: list[float], scale: float, level: float) -> FittedTerm:
    """The ramp, from its value, half the width of its interval and its p-value."""
    unit = coefficient_unit("rate_ramp", curve.quantity, curve.unit)
    factor = math.sqrt(scale) / curve.tau0
    value, half, p_value = ramp
    low, high = (value - half) * factor, (value + half) * factor
    if p_value < 1 - level:
        return FittedTerm(
            term="rate_ramp",
            unit=unit,
            observed=True,
            level=level,
            p_value=p_value,
            value=value * factor,
            low=low,
            high=high,
        )
    limit = max(abs(low), abs(high))
    return FittedTerm(term="rate_ramp", unit=unit, observed=False, level=level, p_value=p_value, upper_limit=limit)


def _covariance(
    model: dict[str, float], theta: list[float], of_theta: list[float]
) -> tuple[tuple[str, ...], NDArray[np.float64]]:
    """Names and covariance of the coefficients √θ, from the covariance of θ."""
    if not model:
        return (), np.empty((0, 0))
    slopes = np.array([value / (2 * theta[LINEAR.index(name)]) for name, value in model.items()])
    return tuple(model), np.array(of_theta).reshape(len(model), -1) * np.multiply.outer(slopes, slopes)


def _process(
    curve: DeviationCurve, process: tuple[list[float], list[float]] | None, scale: float
) -> tuple[GaussMarkov, ...]:
    if process is None:
        return ()
    size, time = process
    value, low, high = (math.sqrt(scale) * x for x in size)
    sigma = Interval(value=value, low=low, high=high, unit=curve.unit)
    value, low, high = (curve.tau0 * x for x in time)
    return (GaussMarkov(sigma=sigma, time=Interval(value=value, low=low, high=high, unit="s")),)
