"""Checks of arguments that all fits share."""

from __future__ import annotations

from collections.abc import Iterable

from sigmatau.errors import OptionError
from sigmatau.model.processes import real
from sigmatau.noise.synonyms import unknown_term
from sigmatau.noise.terms import NOISE, TERMS

_LEVELS = (0.5, 0.999)


def wanted_terms(terms: object) -> set[str]:
    """Select the terms that may be present; None means all. Raises `OptionError` for unknown terms, or if no noise term is
    left.
    """
    if terms is None:
        return set(TERMS)
    if isinstance(terms, str) or not isinstance(terms, Iterable):
        raise OptionError(f'{{option}} must be a list, e.g. ["random_walk"], not {terms!r}', option="terms")
    listed = list(terms)
    wanted = {name for name in listed if isinstance(name, str)}
    if unknown := [name for name in listed if name in wanted - set(TERMS)]:
        raise OptionError(f"{{option}}: {unknown_term(unknown[0])}", option="terms")
    if len(wanted) < len(listed) or not wanted & set(NOISE):
        names = ", ".join(TERMS)
        raise OptionError(
            f"{{option}} must be some of {names}, at least one of them a noise term, not {', '.join(map(str, listed))}",
            option="terms",
        )
    return wanted


def check_level(level: object) -> None:
    """Raise `OptionError` for a confidence level that is not supported."""
    low, high = _LEVELS
    if not low <= real(level) <= high:
        raise OptionError(f"{{option}} must lie in {low:g} … {high:g}, not {level!r}", option="level")
