"""Words of findings about files: damage, leftovers, columns, units."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds import reading as kinds
from sigmatau.findings.wording.phrases import Words

__all__ = ["WORDS"]

_REASON = 60  # longest reason in a sentence [characters]


def _damage(verb: str, it: kinds.Damage) -> Words:
    at = "" if it.place is None else f" {'at' if it.place.unit == 'byte' else 'in'} {it.place.unit} {it.place.number}"
    share = "" if it.got is None else f"{it.got} of {it.expected} {it.measured}"
    reason = "; ".join(filter(None, (it.reason[:_REASON], share)))
    return Words(f"the {it.what} {verb}{at}{f': {reason}' if reason else ''}", "Get or make the file again")


WORDS: dict[type, Callable[[Finding, Any], Words]] = {
    kinds.Damaged: lambda _, it: _damage("is damaged", it),
    kinds.BrokenOff: lambda _, it: _damage("breaks off", it),
}
