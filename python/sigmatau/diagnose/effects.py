"""What a fault does to fitted coefficients: the fit with it against the fit without."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sigmatau.fitting import NoiseFit
from sigmatau.results import Severity, two_digits
from sigmatau.terms import TERMS

__all__ = ["Change", "compared", "effect_text", "severity", "words"]

_MATTERS = 1.1
"""A coefficient that is so many times too large makes a warning of a finding."""

_SAID = 1.05


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """By what factor a coefficient is larger with a fault than without; `at_least` if it is not seen without."""

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


def _worth_saying(change: Change) -> bool:
    if change.at_least:
        return change.factor > _SAID
    return max(change.factor, 1 / change.factor) > _SAID


def severity(changes: Sequence[Change]) -> Severity:
    """A warning if any coefficient is more than a tenth too large or too small."""
    return "warning" if any(max(change.factor, 1 / change.factor) > _MATTERS for change in changes) else "info"


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
        if change.at_least:
            texts.append(f"{label} at least {two_digits(change.factor)} times too large: not seen without it")
        elif change.factor > 1:
            texts.append(f"{label} {two_digits(change.factor)} times too large")
        else:
            texts.append(f"{label} {two_digits(1 / change.factor)} times too small")
    return texts
