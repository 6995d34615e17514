"""Seven days of two hours of the three units: simulated, analysed and read off; kept in .study/ and docs/paper/days.json."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import sigmatau as st
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.fitting.read_off import Coefficient
from sigmatau.noise.terms import TERMS
from studies.paper.decoding import longest_time
from studies.paper.tables import HOURS, NAMES, PRINTED, RATES, TABLES, Cell, day_model
from studies.runner import run, seed_of

__all__ = ["FILE", "analysed_day", "cell_name", "load", "results"]

FILE = Path(__file__).resolve().parents[2] / "docs" / "paper" / "days.json"
_DIGITS = 10  # significant, of the numbers in the file

Found = dict[str, Any]


def cell_name(unit: str, day: int) -> str:
    """Name of a unit's day, from which its seed follows."""
    return f"paper {unit} day {day}"


def analysed_day(seed: int, unit: str, day: int, hours: float = HOURS) -> dict[str, dict[str, Found]]:
    """By channel and term: what the fit says (value, low, high, or upper limit), and what is read off, by the rules of
    `sigmatau.read_off` and with lines laid by hand where the authors laid theirs.
    """
    record = st.simulate(day_model(unit, day), duration=hours * 3600, rate=RATES[unit], rng=seed)
    analysis = st.analyze(record, threads=1)
    found: dict[str, dict[str, Found]] = {}
    cells = [cell for cell in PRINTED if cell.unit == unit]
    laid = {channel: _laid(unit, curve) for channel, curve in analysis.curves.items()}
    for cell in cells:
        fitted = analysis.fits[cell.channel][cell.term]
        read = analysis.read_off[cell.channel].get(cell.term)
        found.setdefault(cell.channel, {})[cell.term] = {
            "value": _rounded(fitted.value if fitted.observed else None),
            "low": _rounded(fitted.low if fitted.observed else None),
            "high": _rounded(fitted.high if fitted.observed else fitted.upper_limit),
            "read": _numbers(read),
            "laid": _numbers(laid[cell.channel].get(cell.term)),
        }
    return found


def hand_range(cell: Cell) -> tuple[float, float]:
    """Averaging times through which a line is laid by hand: to the time that the printed error stands for, from the
    shortest one, or, for the term at longer times, from where the lines of the printed coefficients cross. [s]
    """
    pair = {other.term: other for other in PRINTED if (other.unit, other.channel) == (cell.unit, cell.channel)}
    first, second = sorted(pair.values(), key=lambda one: TERMS[one.term].slope)
    if cell.term == first.term:
        return 1 / RATES[cell.unit], longest_time(cell)
    heights = [_log_height(one) for one in (first, second)]
    slopes = [TERMS[one.term].slope for one in (first, second)]
    return math.exp((heights[0] - heights[1]) / (slopes[1] - slopes[0])), longest_time(cell)


def _log_height(cell: Cell) -> float:
    """Logarithm of the line of a cell at τ = 1 s, in SI."""
    term = TERMS[cell.term]
    level = math.log(TABLES[cell.unit][cell.channel, cell.term][0] * cell.si_factor * term.level)
    return level if term.read_at is None else level - term.slope * math.log(term.read_at)


def _laid(unit: str, curve: DeviationCurve) -> Mapping[str, Coefficient]:
    longest = float(curve.tau[-1])
    ranges = {c.term: hand_range(c) for c in PRINTED if (c.unit, c.channel) == (unit, curve.channel)}
    kept = {term: (low, min(high, longest)) for term, (low, high) in ranges.items() if low < longest / 2}
    return st.read_off(curve, rules={}, **kept)  # type: ignore[arg-type]


def _numbers(read: Coefficient | None) -> list[float | None] | None:
    """Value, error by eq. (26), and the range of averaging times, for a file."""
    return None if read is None else [_rounded(x) for x in (read.value, read.error, read.tau_min, read.tau_max)]


def _rounded(value: float | None) -> float | None:
    return None if value is None else float(f"{value:.{_DIGITS}g}")


def results() -> dict[str, dict[str, dict[str, Found]]]:
    """All days of all units, by `cell_name`; computed as far as they are not in the cache."""
    cells = {cell_name(unit, day): (analysed_day, (unit, day)) for unit in NAMES for day in range(1, 8)}
    return run("paper", cells, settings=repr((HOURS, RATES, "fit, read-off, lines by hand")))


def load() -> Mapping[str, Mapping[str, Mapping[str, Found]]]:
    """What docs/paper/days.json holds."""
    return json.loads(FILE.read_text(encoding="utf-8"))  # type: ignore[no-any-return]


def save(found: Mapping[str, Any]) -> None:
    """Write docs/paper/days.json."""
    FILE.parent.mkdir(exist_ok=True)
    FILE.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def again(unit: str, day: int) -> dict[str, dict[str, Found]]:
    """One day anew, with the same seed."""
    return analysed_day(seed_of(cell_name(unit, day)), unit, day)
