"""Words about a lot that the screen and all files use: states, coefficients, counts, changes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from sigmatau.digits import round_to_error, significant
from sigmatau.lab.lots.lot_remark import Remark, State
from sigmatau.lab.lots.order_effect import OrderEffect
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.results import printable

STATE_WORDS: Mapping[State, str] = {
    "passed": "passed",
    "failed": "failed",
    "not_judged": "not judged",
    "unreadable": "failed to read",
    "missing": "missing",
}


def what_text(what: str, quantity: str) -> str:
    """Name of a coefficient: ``"angle random walk"``, ``"STD of 10 s means"``."""
    if what.startswith("means_"):
        return f"STD of {what.removeprefix('means_')} s means"
    return TERMS[what].label(quantity)


def what_unit(what: str, quantity: str, unit: str, values: Iterable[float | None]) -> tuple[str, float]:
    """Unit in which values of a coefficient are printed, and its factor to SI."""
    return display_units("bias_instability" if what.startswith("means_") else what, quantity, unit, values)[-1]


def count_text(counts: Mapping[State, int], *, spec: str) -> str:
    """Count of the units by state: ``"40 units against Unit 7: 34 passed, 1 failed …"``."""
    total = sum(counts.values())
    parts = [f"{number} {STATE_WORDS[state]}" for state, number in counts.items() if number]
    against = f" against {spec}" if spec else " without a specification"
    return printable(f"{total} {'unit' if total == 1 else 'units'}{against}: {', '.join(parts) or 'none'}")


def without_curves_text(remarks: Sequence[Sequence[Remark]]) -> str:
    """How many units lack their curves, from the remarks of each unit; empty if none does."""
    lacking = sum(any(remark.code == "curves_not_kept" for remark in unit_remarks) for unit_remarks in remarks)
    if not lacking:
        return ""
    what = f"{lacking} of {len(remarks)} units"
    return f"Curves are not compared: the Allan deviations of {what} were not kept in the store"


def percent(ratio: float) -> str:
    """A relative number in per cent, with two digits: ``"3.4"``."""
    return significant(100 * ratio, 2, zeros=True) if ratio > 0 and math.isfinite(ratio) else "0"


def listed(names: Iterable[str], max_names: int = 3) -> str:
    """The first names, and the number of the others: ``"a, b, c and 4 more"``."""
    all_names = [printable(name) for name in names]
    suffix = f" and {len(all_names) - max_names} more" if len(all_names) > max_names else ""
    return ", ".join(all_names[:max_names]) + suffix


def change_text(effect: OrderEffect) -> str:
    """The size of a change in the order of production: ``"+3.0 % [+2.5, +3.5] from unit to unit"``."""
    number = round_to_error(*(100 * value for value in (effect.change, effect.low, effect.high)), sign="+")
    against = {
        "drift": "from the first to the last unit",
        "rise": "from unit to unit",
        "batch": "against the other units",
    }
    return f"{number.value} % {number.interval} {against[effect.kind]}"


def order_text(effect: OrderEffect) -> str:
    """A change in the order of production, with its units."""
    if effect.kind == "drift":
        return change_text(effect)
    return f"{change_text(effect)}, {printable(effect.first)} to {printable(effect.last)}"
