"""Seven days of the three units, and the logs of Fig. 12: simulated, analysed and read off; docs/paper/days.json."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import sigmatau as st
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.fitting.read_off import ReadOffCoefficient
from sigmatau.noise.terms import TERMS
from studies.paper.decoding import longest_time
from studies.paper.figures import fig_12_logs, fig_12_sensor
from studies.paper.tables import HOURS, NAMES, PRINTED, RATES, TABLES, Cell, day_model, model
from studies.runner import run, seed_of

__all__ = ["FIG_12", "FILE", "NAVIGATION", "again", "analysed_day", "cell_name", "load", "results", "save"]

FILE = Path(__file__).resolve().parents[2] / "docs" / "paper" / "days.json"
_DIGITS = 10  # significant digits of the numbers in the file

Recovered = dict[str, Any]


def cell_name(unit: str, day: int) -> str:
    """Name of a day of a unit, which determines the seed."""
    return f"paper {unit} day {day}"


def analysed_day(seed: int, unit: str, day: int, hours: float = HOURS) -> dict[str, dict[str, Recovered]]:
    """Results by channel and term: from the fit (value, low, high, or upper limit), and read off by the rules of
    `sigmatau.read_off` and with lines drawn by hand in the ranges of the authors.
    """
    record = st.simulate(day_model(unit, day), duration=hours * 3600, rate=RATES[unit], rng=seed)
    analysis = st.analyze(record, threads=1)
    recovered: dict[str, dict[str, Recovered]] = {}
    cells = [cell for cell in PRINTED if cell.unit == unit]
    by_rule = {channel: st.read_off(curve) for channel, curve in analysis.curves.items()}
    laid = {channel: _laid(unit, curve) for channel, curve in analysis.curves.items()}
    for cell in cells:
        fitted = analysis.fits[cell.channel][cell.term]
        read = by_rule[cell.channel].get(cell.term)
        recovered.setdefault(cell.channel, {})[cell.term] = {
            "value": _rounded(fitted.value if fitted.observed else None),
            "low": _rounded(fitted.low if fitted.observed else None),
            "high": _rounded(fitted.high if fitted.observed else fitted.upper_limit),
            "read": _numbers(read),
            "laid": _numbers(laid[cell.channel].get(cell.term)),
        }
    return recovered


def hand_range(cell: Cell) -> tuple[float, float]:
    """Averaging times of a line drawn by hand: up to the time of the printed error; from the shortest time, or for the
    second term from the crossing of the lines of the printed coefficients. [s]
    """
    pair = {c.term: c for c in PRINTED if (c.unit, c.channel) == (cell.unit, cell.channel)}
    first, second = sorted(pair.values(), key=lambda line: TERMS[line.term].slope)
    if cell.term == first.term:
        return 1 / RATES[cell.unit], longest_time(cell)
    heights = [_log_height(line) for line in (first, second)]
    slopes = [TERMS[line.term].slope for line in (first, second)]
    return math.exp((heights[0] - heights[1]) / (slopes[1] - slopes[0])), longest_time(cell)


def _log_height(cell: Cell) -> float:
    """Logarithm of the line of a cell at τ = 1 s, in SI."""
    term = TERMS[cell.term]
    level = math.log(TABLES[cell.unit][cell.channel, cell.term][0] * cell.si_factor * term.level)
    return level if term.read_at is None else level - term.slope * math.log(term.read_at)


def _laid(unit: str, curve: DeviationCurve) -> Mapping[str, ReadOffCoefficient]:
    longest = float(curve.tau[-1])
    ranges = {c.term: hand_range(c) for c in PRINTED if (c.unit, c.channel) == (unit, curve.channel)}
    usable: Any = {term: (low, min(high, longest)) for term, (low, high) in ranges.items() if low < longest / 2}
    return st.read_off(curve, rules={}, **usable)


def _numbers(read: ReadOffCoefficient | None) -> list[float | None] | None:
    """Value, error by eq. (26), and the range of averaging times, for a file."""
    return None if read is None else [_rounded(x) for x in (read.value, read.error, read.tau_min, read.tau_max)]


def _rounded(value: float | None) -> float | None:
    return None if value is None else float(f"{value:.{_DIGITS}g}")


FIG_12 = "paper figure 12"
NAVIGATION = "paper random walk of the CIMU"
_RECORDS, _PARTS = 100, 10


def sampling(_seed: int) -> dict[str, list[float | None]]:
    """Random walk and its interval over that of the sensor, by rate of the log, with the seed of the figure."""
    true = fig_12_sensor().channels["gyro_x"]["random_walk"]
    ratios = {}
    for rate, record in fig_12_logs().items():
        walk = st.analyze(record, threads=1).fits["gyro_x"]["random_walk"]
        ratios[str(rate)] = [_rounded(x / true) for x in (walk.value, walk.low, walk.high) if x is not None]
    return ratios


def navigation(seed: int) -> list[int]:
    """Intervals of the random walk of the CIMU gyros in further records: total number, too low, too high."""
    rng = np.random.default_rng(seed)
    gyros = model("cimu").of([f"gyro_{axis}" for axis in "xyz"])
    low = high = total = 0
    for _ in range(_RECORDS // _PARTS):
        fits = st.analyze(st.simulate(gyros, duration=3600 * HOURS, rate=RATES["cimu"], rng=rng), threads=1).fits
        for channel, fitted in fits.items():
            walk, true = fitted["random_walk"], gyros.channels[channel]["random_walk"]
            total += 1
            upper = walk.high if walk.observed else walk.upper_limit
            low += upper is not None and upper < true
            high += walk.low is not None and walk.low > true
    return [total, low, high]


def results() -> dict[str, Any]:
    """All days of all units, by `cell_name`, and the other cells; those missing in the cache are computed."""
    cells: dict[str, tuple[Any, tuple[Any, ...]]] = {
        cell_name(unit, day): (analysed_day, (unit, day)) for unit in NAMES for day in range(1, 8)
    }
    cells |= {f"{NAVIGATION} {k}": (navigation, ()) for k in range(_PARTS)}
    cells[FIG_12] = (sampling, ())
    computed = run("paper", cells, settings=repr((HOURS, RATES, _RECORDS, _PARTS, "fit, rules, hand")))
    parts = [computed.pop(f"{NAVIGATION} {k}") for k in range(_PARTS)]
    return computed | {NAVIGATION: [sum(column) for column in zip(*parts, strict=True)]}


def load() -> Mapping[str, Any]:
    """Content of docs/paper/days.json."""
    content: dict[str, Any] = json.loads(FILE.read_text(encoding="utf-8"))
    return content


def save(content: Mapping[str, Any]) -> None:
    """Write docs/paper/days.json."""
    FILE.parent.mkdir(exist_ok=True)
    lines = ",\n".join(f"{json.dumps(name)}: {json.dumps(day)}" for name, day in content.items())
    FILE.write_text(f"{{\n{lines}\n}}\n", encoding="utf-8")


def again(unit: str, day: int) -> dict[str, dict[str, Recovered]]:
    """Repeat one day with the same seed."""
    return analysed_day(seed_of(cell_name(unit, day)), unit, day)
