"""Seven days of two hours of the three units: simulated, analysed and read off; kept in .study/ and docs/paper/days.json."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import sigmatau as st
from studies.paper.tables import HOURS, NAMES, PRINTED, RATES, day_model
from studies.runner import run, seed_of

__all__ = ["FILE", "analysed_day", "cell_name", "load", "results"]

FILE = Path(__file__).resolve().parents[2] / "docs" / "paper" / "days.json"
_DIGITS = 10  # significant, of the numbers in the file

Found = dict[str, Any]


def cell_name(unit: str, day: int) -> str:
    """Name of a unit's day, from which its seed follows."""
    return f"paper {unit} day {day}"


def analysed_day(seed: int, unit: str, day: int, hours: float = HOURS) -> dict[str, dict[str, Found]]:
    """By channel and term: what the fit says (value, low, high, or upper limit), and what is read off."""
    record = st.simulate(day_model(unit, day), duration=hours * 3600, rate=RATES[unit], rng=seed)
    analysis = st.analyze(record, threads=1)
    found: dict[str, dict[str, Found]] = {}
    for cell in (cell for cell in PRINTED if cell.unit == unit):
        fitted = analysis.fits[cell.channel][cell.term]
        read = analysis.read_off[cell.channel].get(cell.term)
        found.setdefault(cell.channel, {})[cell.term] = {
            "value": _rounded(fitted.value if fitted.observed else None),
            "low": _rounded(fitted.low if fitted.observed else None),
            "high": _rounded(fitted.high if fitted.observed else fitted.upper_limit),
            "read": None if read is None else [_rounded(x) for x in (read.value, read.error, read.tau_min, read.tau_max)],
        }
    return found


def _rounded(value: float | None) -> float | None:
    return None if value is None else float(f"{value:.{_DIGITS}g}")


def results() -> dict[str, dict[str, dict[str, Found]]]:
    """All days of all units, by `cell_name`; computed as far as they are not in the cache."""
    cells = {cell_name(unit, day): (analysed_day, (unit, day)) for unit in NAMES for day in range(1, 8)}
    return run("paper", cells, settings=repr((HOURS, RATES, "fit and read-off")))


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
