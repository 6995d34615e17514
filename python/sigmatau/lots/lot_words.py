"""The words of a lot: remarks, states, distributions, for the screen and all files alike."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping

from sigmatau.findings.phrases import short_axes
from sigmatau.lots.lot_remark import Remark, State
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.results import printable, two_digits

STATE_WORDS: Mapping[State, str] = {
    "passed": "passed",
    "failed": "failed",
    "not_judged": "not judged",
    "unreadable": "failed to read",
    "missing": "missing",
}

_FAR = 3.0  # ratio from which on a difference is told as a factor: "57 times"


def difference(ratio: float) -> str:
    """A ratio to a reference, whose name follows: ``"12 % above"``, ``"57 times"``, ``"1/57 of"``.

    Examples
    --------
    >>> difference(1.123), difference(0.5), difference(57.3), difference(1 / 57.3)
    ('12 % above', '50 % below', '57 times', '1/57 of')
    """
    if ratio >= _FAR:
        return f"{two_digits(ratio)} times"
    if ratio <= 1 / _FAR:
        return f"1/{two_digits(1 / ratio)} of" if ratio > 0 else "far below"
    percent = 100 * abs(ratio - 1)
    return f"{two_digits(percent)} % {'above' if ratio >= 1 else 'below'}"


def what_text(what: str, quantity: str) -> str:
    """Name of a coefficient: ``"angle random walk"``, ``"STD of 10 s means"``."""
    if what.startswith("means_"):
        return f"STD of {what.removeprefix('means_')} s means"
    return TERMS[what].label(quantity)


def what_unit(what: str, quantity: str, unit: str) -> tuple[str, float]:
    """Unit in which a coefficient is told, and its factor to SI."""
    return display_units("bias_instability" if what.startswith("means_") else what, quantity, unit)[-1]


def remark_text(one: Remark) -> str:
    """A remark in words, one line."""
    about = f"{short_axes(one.channels)}: " if one.channels else ""
    said = _WORDS.get(one.code, _finding)(one)
    return printable(about + said)


def _number(value: float | None, one: Remark) -> str:
    if value is None:
        return "unknown"
    return f"{value / one.factor:.3g} {one.unit}".rstrip()


def _finding(one: Remark) -> str:
    return one.text or one.code.replace("_", " ")


def _above(one: Remark) -> str:
    if one.value is None or one.ratio is None:
        return f"{one.what} is above the maximum {_number(one.limit, one)}"
    return f"{one.what} {_number(one.value, one)} is {difference(one.ratio)} the maximum {_number(one.limit, one)}"


def _undecided(one: Remark) -> str:
    if one.text:
        return f"{one.what}: {one.text}"
    at = "is not observed" if one.value is None else _number(one.value, one)
    return f"{one.what} {at}: the interval contains the maximum {_number(one.limit, one)}; record longer"


def _implausible(one: Remark) -> str:
    near = "" if one.ratio is None else difference(one.ratio)
    return f"implausible: {one.what} is {near} the {one.text} value of the specification; check unit and sensor"


def _other_scale(one: Remark) -> str:
    near = "" if one.ratio is None else difference(one.ratio)
    if one.text:
        return f"{one.text} All curves are {near} the lot's median"
    return f"all curves are {near} the lot's median"


def _outlier(one: Remark) -> str:
    near = "" if one.ratio is None else difference(one.ratio)
    return f"outlier: {one.what} {_number(one.value, one)} is {near} the lot's median"


_WORDS: Mapping[str, Callable[[Remark], str]] = {
    "above_maximum": _above,
    "undecided": _undecided,
    "no_maximum": lambda one: f"no maximum in the specification; state one, or give --factor 1.5: {one.what}",
    "not_measured": lambda one: f"{one.what or 'in the specification'}: not in the result",
    "no_model": lambda one: "no model fits, so that the errors are unknown",
    "not_at_rest": lambda one: one.text,
    "too_short_to_tell": lambda one: one.text,
    "no_specification": lambda one: "no specification; give --spec SPEC.toml",
    "implausible_value": _implausible,
    "other_scale": _other_scale,
    "outlier": _outlier,
    "short_record": lambda one: f"truncated? The record has {one.text}",
    "other_rate": lambda one: f"sampled at {one.text}",
    "other_axes": lambda one: f"channels differ from the lot: {one.text}",
    "same_data": lambda one: f"the data are those of {one.text}; log this unit again",
    "not_expected": lambda one: "not on the list of --expect",
    "unreadable": lambda one: one.text,
    "missing": lambda one: "expected, but there is no file",
}


def count_text(counts: Mapping[State, int], *, spec: str) -> str:
    """``"40 units against Unit 7: 34 passed, 1 failed …"``."""
    total = sum(counts.values())
    parts = [f"{number} {STATE_WORDS[state]}" for state, number in counts.items() if number]
    against = f" against {spec}" if spec else " without a specification"
    return printable(f"{total} {'unit' if total == 1 else 'units'}{against}: {', '.join(parts) or 'none'}")


def percent(ratio: float) -> str:
    """A small relative number in per cent: ``"3.4"``."""
    return two_digits(100 * ratio) if ratio > 0 and math.isfinite(ratio) else "0"


def listed(names: Iterable[str], most: int = 3) -> str:
    """``"a, b, c and 4 more"``."""
    every = [printable(name) for name in names]
    more = f" and {len(every) - most} more" if len(every) > most else ""
    return ", ".join(every[:most]) + more
