"""Effects of a fault on fitted coefficients: the fit with the fault compared with the fit without."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sigmatau.findings.finding import FitEffect, Severity
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.noise.terms import TERMS

__all__ = ["Change", "compared", "factors", "in_fit", "severity", "vanished"]

FACTOR_WARNED = 1.1  # factor on a coefficient, up or down, above which a finding is a warning
FACTOR_TOLD = 1.05  # factor on a coefficient, up or down, above which it is stated

_SLOW = ("bias_instability", "rate_random_walk", "rate_ramp")


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """Factor by which a coefficient is larger with a fault than without it.

    `at_least`: it is not observed without the fault, and the factor is that to its upper limit, which may be 1 or less.
    """

    term: str
    factor: float
    at_least: bool


def compared(before: NoiseFit, after: NoiseFit) -> list[Change]:
    """Coefficients of a fit that are larger or smaller than in one without the fault by more than 5 %."""
    changes = []
    for term in TERMS:
        value = before[term].value if term in before and term in after else None
        if value is not None and (now := after[term].value):
            changes.append(Change(term=term, factor=abs(value / now), at_least=False))
        elif value is not None and (limit := after[term].upper_limit):
            changes.append(Change(term=term, factor=abs(value) / limit, at_least=True))
    return [c for c in changes if (c.factor if c.at_least else max(c.factor, 1 / c.factor)) > FACTOR_TOLD]


def vanished(before: NoiseFit, after: NoiseFit) -> list[Change]:
    """Slow terms that a fit observes and a fit without the fault does not, with values below the upper limit of the latter.

    The factor by which they are too large is unknown; the fault alone may explain them.
    """
    changes = []
    for term in _SLOW:
        if term not in before or term not in after or not before[term].observed or after[term].observed is not False:
            continue
        value, limit = before[term].value, after[term].upper_limit
        if value is not None and limit and abs(value) <= FACTOR_TOLD * limit:
            changes.append(Change(term=term, factor=abs(value) / limit, at_least=True))
    return changes


def factors(changes: Sequence[Change]) -> tuple[tuple[str, float], ...]:
    """Factors by term, without those of `vanished`."""
    return tuple((c.term, float(c.factor)) for c in changes if not _hidden(c))


def in_fit(
    changes: Sequence[Change],
    before: NoiseFit,
    after: NoiseFit | None,
    *,
    without: tuple[str, ...],
    compared_from: float | None = None,
    hidden: tuple[str, ...] = (),
    lower_bound: bool = False,
) -> dict[str, Any]:
    """The fields of a finding with the effect of its fault on the printed fit `before`.

    `after` is the fit without the fault, None if too little is left to fit, and `compared_from` its shortest averaging
    time, by default that of the printed fit. [s] For the others see `FitEffect`.
    """
    tau_min = before.tau_min or before.tau0
    effect = FitEffect(
        channel=before.channel,
        tau_min_s=tau_min,
        compared_from_s=compared_from or tau_min,
        without=without,
        verdict=before.verdict,
        verdict_without="" if after is None else after.verdict,
        hidden=hidden,
        at_least=tuple(change.term for change in changes if change.at_least),
        lower_bound=lower_bound,
    )
    return {"factors": factors(changes), "fit_effect": effect}


def _hidden(change: Change) -> bool:
    return change.at_least and change.factor <= FACTOR_TOLD


def severity(changes: Sequence[Change]) -> Severity:
    """A warning if any coefficient is wrong by more than a tenth, or may be explained by the fault alone."""
    wrong = any(_hidden(one) or max(one.factor, 1 / one.factor) > FACTOR_WARNED for one in changes)
    return "warning" if wrong else "info"
