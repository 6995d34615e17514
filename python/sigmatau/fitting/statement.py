"""Results of a fit from its numbers: units, intervals, limits, verdicts."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sigmatau.estimators.allan import DeviationCurve
from sigmatau.findings.kinds.fit import Misfit, Reason
from sigmatau.fitting import gauss_markov
from sigmatau.fitting.attempt import QUANTIZATION, Attempt, Data
from sigmatau.fitting.components import LINEAR, Components, power_of_interval
from sigmatau.fitting.gls import Gls, relative_fit
from sigmatau.fitting.goodness import p_value
from sigmatau.fitting.inference import Evidence, evidence
from sigmatau.fitting.noise_fit import FittedTerm, GaussMarkov, Interval, NoiseFit
from sigmatau.fitting.observed import observed_term
from sigmatau.fitting.selection import LEAST_P
from sigmatau.noise.terms import coefficient_unit

Floats = NDArray[np.float64]

_WALK = LINEAR.index("rate_random_walk")
_EDGE = 0.2  # of the width of an interval: a value nearer to an end is checked without the terms that were not found
_SMALLEST_P = 1e-12  # smaller p-values are rounding errors
_DESCRIPTIVE_ERROR = 0.1  # relative error of a variance in a descriptive fit: 5 % of a deviation


def stated(curve: DeviationCurve, data: Data, best: Attempt, scale: float, level: float) -> NoiseFit:
    """The result for an adequate model: intervals of the observed terms, upper limits of the others. `scale` is the
    variance by which the data were divided.
    """
    gls, theta, tau0 = best.gls, best.theta, curve.tau0
    linear = [p for p in gls.candidates if p < len(LINEAR)]
    found = {p: _evidence(gls, p, theta, level) for p in linear}
    observed = [p for p, e in found.items() if e.p_value < 1 - level]
    undecided = best.ramp is not None and best.ramp.suspicious and not best.ramp.used
    if _WALK in observed and undecided and best.still is not None:
        # The noise may or may not explain the ramp: is the walk significant without it?
        still, theta_still = best.still
        if evidence(still, _WALK, theta_still, level=level).p_value >= 1 - level:
            observed.remove(_WALK)
            found[_WALK] = replace(found[_WALK], low=0.0)
    extra = list(range(len(LINEAR), len(gls.parts.names)))
    selected = gls.fit([*observed, *extra]) if observed or extra else theta
    unclear: list[str] = []
    if p_value(gls, selected) <= LEAST_P or not (observed or extra):
        # Several terms, none of which is significant beside the others, although at least one is needed.
        selected = theta
        unclear = [LINEAR[p] for p in linear if theta[p] > 0 and p not in observed]
        if undecided:
            unclear.append("rate_ramp")
    # Including terms that the record does not distinguish: their sum is known better than each of them.
    covariance = _covariance(gls, selected, [p for p in linear if selected[p] > 0], scale, tau0)
    errors = dict(zip(covariance[0], np.sqrt(np.maximum(np.diag(covariance[1]), 0.0)), strict=True))
    terms = {}
    for p in data.candidates:
        if p not in found:
            unit = coefficient_unit(LINEAR[p], curve.quantity, curve.unit)
            terms[LINEAR[p]] = FittedTerm(term=LINEAR[p], unit=unit, observed=False, level=level)
            continue
        e = found[p]
        value = selected[p] * scale if p in observed else None
        if p in observed and not e.low + _EDGE * (e.high - e.low) <= selected[p] <= e.high - _EDGE * (e.high - e.low):
            # Far from the middle of the interval, which allows for the terms that were not found: the interval without
            # these terms is included.
            without = Gls(gls.parts, gls.avar, [*observed, *extra], tangent=gls.tangent[:, 0] if extra else None)
            alone = _evidence(without, p, selected, level)
            e = replace(e, low=min(e.low, alone.low), high=max(e.high, alone.high))
        terms[LINEAR[p]] = _term(curve, p, value, float(errors.get(LINEAR[p], 0.0)), e, scale, level)
    model = {
        LINEAR[p]: coefficient(selected[p] * scale, LINEAR[p], tau0) for p in range(len(LINEAR)) if selected[p] > 0
    }
    if best.ramp is not None:
        unit = coefficient_unit("rate_ramp", curve.quantity, curve.unit)
        ramp = best.ramp.stated(scale, tau0, unit=unit, level=level)
        terms["rate_ramp"] = ramp
        if ramp.value is not None:
            model["rate_ramp"] = ramp.value
    return NoiseFit(
        channel=curve.channel,
        quantity=curve.quantity,
        rate_unit=curve.unit,
        n=curve.n,
        tau0=tau0,
        terms=terms,
        gauss_markov=_process(curve, data, best, selected, scale, level),
        model=model,
        verdict="adequate",
        reasons=best.reasons(data),
        unclear=tuple(unclear),
        tau_min=data.m[best.first] * tau0,
        tau_max=data.m[-1] * tau0,
        p_value=best.p_value,
        covariance=covariance,
        level=level,
    )


def descriptive(
    curve: DeviationCurve,
    data: Data,
    nearest: Attempt | None,
    scale: float,
    level: float,
    *,
    reason: Reason | None = None,
) -> NoiseFit:
    """The result if no model is adequate: coefficients that describe the curve to a few per cent."""
    first = nearest.first if nearest is not None and nearest.p_value > _SMALLEST_P else data.first or 0
    parts, avar = data.parts().from_index(first), data.avar[first:]
    columns = np.column_stack([parts.design, 0.5 * parts.squares])
    allowed = [*data.candidates, *([len(LINEAR)] if data.with_ramp else [])]
    theta, errors = _descriptive_theta(parts, columns, avar, allowed)
    left_out = theta[QUANTIZATION] * data.parts().design[:first, QUANTIZATION]
    if np.any(left_out > data.avar[:first]) and len(allowed) > 1:
        theta, errors = _descriptive_theta(parts, columns, avar, [p for p in allowed if p != QUANTIZATION])
    expected = columns @ theta
    worst = int(np.argmax(np.abs(np.log(avar / expected)) / errors))
    reason = reason or Misfit(
        p_value=None if nearest is None else nearest.p_value,
        tau_min=data.m[first] * curve.tau0,
        tau=float(parts.m[worst]) * curve.tau0,
        ratio=math.sqrt(avar[worst] / expected[worst]),
    )
    needed = {}
    for p, name in enumerate((*LINEAR, "rate_ramp")):
        if theta[p] > 0 and (theta[p] * columns[:, p] / expected).max() > _DESCRIPTIVE_ERROR:
            sign = math.copysign(1.0, data.ramps[-1]) if name == "rate_ramp" else 1.0
            needed[name] = sign * coefficient(theta[p] * scale, name, curve.tau0)
    terms = {
        name: FittedTerm(
            term=name,
            unit=coefficient_unit(name, curve.quantity, curve.unit),
            observed=None,
            level=level,
            value=needed.get(name),
        )
        for p, name in enumerate((*LINEAR, "rate_ramp"))
        if p in allowed
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
        tau_min=data.m[first] * curve.tau0,
        tau_max=data.m[-1] * curve.tau0,
        level=level,
    )


def _descriptive_theta(parts: Components, columns: Floats, avar: Floats, allowed: list[int]) -> tuple[Floats, Floats]:
    """θ fitted to the variances with errors of at least a tenth, the squared ramp last; and these relative errors."""
    theta = np.zeros(columns.shape[1])
    errors = np.full(len(avar), _DESCRIPTIVE_ERROR)
    for _ in range(4):
        theta[allowed] = relative_fit(columns[:, allowed], avar, errors)
        if theta[:-1].any():
            edf = parts.degrees_of_freedom(theta[:-1], ramp=math.sqrt(theta[-1]))
            errors = np.hypot(_DESCRIPTIVE_ERROR, np.sqrt(2 / edf))
    return theta, errors


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


def _evidence(gls: Gls, term: int, theta: Floats, level: float) -> Evidence:
    """The evidence of one term; if poorly determined other terms leave it without a limit, the limit of the term alone."""
    found = evidence(gls, term, theta, level=level)
    if math.isfinite(found.high):
        return found
    alone = Gls(gls.parts, gls.avar, (term,))
    return replace(found, high=evidence(alone, term, alone.fit(), level=level).high)


def _term(
    curve: DeviationCurve,
    term: int,
    value: float | None,
    error: float,
    e: Evidence,
    scale: float,
    level: float,
) -> FittedTerm:
    """The result for one noise term; `value` is θ if it was observed, and `error` the standard error of its coefficient."""
    name, tau0 = LINEAR[term], curve.tau0
    unit = coefficient_unit(name, curve.quantity, curve.unit)
    high = coefficient(e.high * scale, name, tau0)
    if value is not None:
        amount = coefficient(value, name, tau0)
        low = coefficient(e.low * scale, name, tau0)
        return observed_term(
            term=name, unit=unit, level=level, p_value=e.p_value, value=amount, low=low, high=high, error=error
        )
    return FittedTerm(
        term=name,
        unit=unit,
        observed=False,
        level=level,
        p_value=e.p_value,
        upper_limit=high if math.isfinite(high) else None,
    )


def _covariance(gls: Gls, theta: Floats, used: list[int], scale: float, tau0: float) -> tuple[tuple[str, ...], Floats]:
    """Names and covariance of the coefficients √θ, from the covariance of θ."""
    if not used:
        return (), np.empty((0, 0))
    active = [*used, *(p for p in range(len(LINEAR), len(theta)) if theta[p] > 0)]
    of_theta = gls.covariance_of_theta(theta, active)[: len(used), : len(used)]
    slopes = np.array([coefficient(theta[p] * scale, LINEAR[p], tau0) / (2 * theta[p]) for p in used])
    return tuple(LINEAR[p] for p in used), of_theta * np.outer(slopes, slopes)


def _process(
    curve: DeviationCurve, data: Data, best: Attempt, theta: Floats, scale: float, level: float
) -> tuple[GaussMarkov, ...]:
    if best.time is None or theta[-1] <= 0:
        return ()
    size, time = gauss_markov.intervals(best, data, theta, level=level)
    value, low, high = (math.sqrt(scale) * x for x in size)
    sigma = Interval(value=value, low=low, high=high, unit=curve.unit)
    value, low, high = (curve.tau0 * x for x in time)
    return (GaussMarkov(sigma=sigma, time=Interval(value=value, low=low, high=high, unit="s")),)
