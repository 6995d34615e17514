"""What a fault does to fitted coefficients: the fit with it against the fit without."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sigmatau.findings.finding import Severity
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.noise.terms import TERMS
from sigmatau.results import two_digits

__all__ = ["Change", "compared", "effect_text", "factors", "severity", "vanished", "words"]

_MATTERS = 1.1
"""A coefficient that is so many times too large makes a warning of a finding."""

_SAID = 1.05

_SLOW = ("bias_instability", "rate_random_walk", "rate_ramp")


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """By what factor a coefficient is larger with a fault than without; `at_least` if it is not seen without.

    A factor of 1 and less is then that to the limit which the record sets without the fault, see `vanished`.
    """

    term: str
    factor: float
    at_least: bool


def compared(before: NoiseFit, after: NoiseFit) -> list[Change]:
    """Coefficients of a fit that are larger or smaller than in one without the fault by more than 5 %."""
    changes = []
    for term in TERMS:
        if term not in before or term not in after:
            continue
        value, now = before[term].value, after[term].value
        limit = after[term].upper_limit
        if value is None:
            continue
        if now:
            changes.append(Change(term=term, factor=abs(value / now), at_least=False))
        elif limit:
            changes.append(Change(term=term, factor=abs(value) / limit, at_least=True))
    return [change for change in changes if _worth_saying(change)]


def vanished(before: NoiseFit, after: NoiseFit) -> list[Change]:
    """Slow terms that are stated with an interval in a fit and not seen in one without the fault, though below its limit.

    By what factor they are too large is not known then, but that nothing of them is known to be the sensor's.
    """
    changes = []
    for term in _SLOW:
        if term not in before or term not in after or not before[term].observed or after[term].observed is not False:
            continue
        value, limit = before[term].value, after[term].upper_limit
        if value is not None and limit and abs(value) <= _SAID * limit:
            changes.append(Change(term=term, factor=abs(value) / limit, at_least=True))
    return changes


def factors(changes: Sequence[Change]) -> tuple[tuple[str, float], ...]:
    """By term, of those whose factor is known, or at least known to be above 1."""
    return tuple((c.term, c.factor) for c in changes if not _hidden(c))


def _hidden(change: Change) -> bool:
    return change.at_least and change.factor <= _SAID


def _worth_saying(change: Change) -> bool:
    if change.at_least:
        return change.factor > _SAID
    return max(change.factor, 1 / change.factor) > _SAID


def severity(changes: Sequence[Change]) -> Severity:
    """A warning if any coefficient is more than a tenth too large or too small, or may be nothing but the fault."""
    for change in changes:
        if _hidden(change) or max(change.factor, 1 / change.factor) > _MATTERS:
            return "warning"
    return "info"


def effect_text(changes: Sequence[Change], quantity: str, otherwise: str) -> str:
    """What the changes are, in words; `otherwise` says what the fault is where there are none."""
    if not changes:
        return f"{otherwise}, but changes no coefficient by more than 5 %"
    return "; ".join(words(changes, quantity))


def words(changes: Sequence[Change], quantity: str) -> list[str]:
    """Each change in words."""
    texts = []
    for change in changes:
        label = TERMS[change.term].label(quantity)
        if _hidden(change):
            texts.append(f"{label} not seen without it: all of what is fitted may be this")
        elif change.at_least:
            texts.append(f"{label} at least {two_digits(change.factor)} times too large: not seen without it")
        elif change.factor > 1:
            texts.append(f"{label} {two_digits(change.factor)} times too large")
        else:
            texts.append(f"{label} {two_digits(1 / change.factor)} times too small")
    return texts
