"""Adjustments of a fit: applied in one place, to intervals, covariance, verdict and reasons alike."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from sigmatau.findings.reasons import UnmodelledBand
from sigmatau.fitting.adjustment import Adjustment, Cause, Change, Part
from sigmatau.fitting.fitted_values import FittedTerm
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.model.parameters import Covariance, Parameter

FitCheck = Callable[[NoiseFit], Adjustment | None]
"""A check of the record: takes the fit after the previous checks, and returns an adjustment or None."""

_EMPTY_PARTS: Mapping[Part, Any] = {
    **dict.fromkeys(("gauss_markov", "sinusoid", "resonance", "second", "unclear", "discrepancy", "reasons"), ()),
    **dict.fromkeys(("response", "warm_up", "highest", "alike_from", "alike_sigma")),
    "covariance": Covariance(),
}
# checks whose reasons are listed last, because the other reasons hide more of the noise
_LISTED_LAST: tuple[Cause, ...] = ("rounding", "changing_level")


def adjusted(fitted: NoiseFit, *checks: FitCheck) -> NoiseFit:
    """Apply the adjustments of all checks to a fit, in order."""
    for check in checks:
        adjustment = check(fitted)
        if adjustment is not None:
            fitted = _apply(fitted, adjustment)
    return fitted


def _apply(fitted: NoiseFit, adjustment: Adjustment) -> NoiseFit:
    values: dict[str, Any] = {part: _EMPTY_PARTS[part] for part in adjustment.without}
    terms = dict(fitted.terms)
    kinds = ("gauss_markov", "resonance", "sinusoid")
    processes: dict[str, list[Any]] = {kind: [*getattr(fitted, kind)] for kind in kinds}
    for change in adjustment.changes:
        parameter = change.parameter
        if parameter.number is None or parameter.quantity is None:
            terms[parameter.part] = _changed_term(terms[parameter.part], change)
        else:
            process = processes[parameter.part][parameter.number - 1]
            interval = replace(getattr(process, parameter.quantity), low=change.after.low, high=change.after.high)
            processes[parameter.part][parameter.number - 1] = replace(process, **{parameter.quantity: interval})
    hidden = [  # terms that a wider interval hides; they remain in the model
        change.parameter.part
        for change in adjustment.changes
        if change.kind == "widen"
        and change.parameter.number is None
        and fitted.terms[change.parameter.part].observed
        and not terms[change.parameter.part].observed
    ]
    if hidden:
        values["unclear"] = tuple(dict.fromkeys((*fitted.unclear, *hidden)))
    if adjustment.verdict == "disturbed":
        walk = terms["random_walk"].upper_limit if "random_walk" in terms else None
        values["model"] = {} if walk is None else {"random_walk": walk}
    limited = {change.parameter for change in adjustment.changes if change.kind == "limit"}

    def remaining(parameter: Parameter) -> Parameter | None:
        return None if parameter in limited or parameter.part in adjustment.without else parameter

    covariance = fitted.covariance.scaled({change.parameter: change.scale for change in adjustment.changes})
    return replace(
        fitted,
        **{
            "terms": terms,
            **{kind: tuple(items) for kind, items in processes.items()},
            "verdict": adjustment.verdict or fitted.verdict,
            "tau_min": fitted.tau_min if adjustment.tau_min is None else adjustment.tau_min,
            "covariance": covariance.select(remaining),
            "adjustments": (*fitted.adjustments, replace(adjustment, reason=None)),
            **values,
            "reasons": _reasons(fitted, adjustment),
        },
    )


def _reasons(fitted: NoiseFit, adjustment: Adjustment) -> tuple[Any, ...]:
    """Reasons of the fit; that which hides most comes first."""
    reasons = () if "reasons" in adjustment.without else fitted.reasons
    if "highest" in adjustment.without:
        reasons = tuple(reason for reason in reasons if not isinstance(reason, UnmodelledBand))
    if adjustment.reason is None or adjustment.reason in reasons:
        return reasons
    return (*reasons, adjustment.reason) if adjustment.cause in _LISTED_LAST else (adjustment.reason, *reasons)


def _changed_term(term: FittedTerm, change: Change) -> FittedTerm:
    """Replace the interval or limit of a term. A term whose interval contains 0 gets a limit."""
    after = change.after
    if change.kind == "limit":
        return FittedTerm(
            term=term.term, unit=term.unit, observed=False, level=term.level, upper_limit=after.upper_limit
        )
    if not term.observed or (after.low or 0.0) * (after.high or 0.0) > 0:
        return replace(term, low=after.low, high=after.high, upper_limit=after.upper_limit)
    limit = max((abs(end) for end in (after.low, after.high, term.value) if end is not None), default=math.inf)
    return FittedTerm(
        term=term.term,
        unit=term.unit,
        observed=False,
        level=term.level,
        upper_limit=limit if 0 < limit < math.inf else None,
        p_value=None if term.p_value is None else max(term.p_value, 1 - term.level),
    )
