"""Tables of docs/paper, from the printed numbers and the seven simulated days."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from sigmatau.lab.lots.repeatability import JUDGEMENTS, RandomEffects, random_effects
from sigmatau.noise.terms import TERMS, aliasing_inflation
from sigmatau.units import to_si
from studies.paper.days import FIG_12, NAVIGATION, Recovered, cell_name
from studies.paper.decoding import (
    decoded,
    expected_hits,
    reproducing_share,
    reproducing_sizes,
    reproducing_times,
    significant_digits,
    undecoded,
)
from studies.paper.tables import DAYS, NAMES, PRINTED, RATES, STD, TITLES, Cell, truth

__all__ = ["MIN_INSIDE", "TABLES", "Counted", "covered", "laid_within", "std_rows", "table"]

Days = Mapping[str, Any]
"""Content of docs/paper/days.json."""

MIN_INSIDE = 0.91
"""Share of the cells whose 95 % interval must contain the simulated value: 0.95 minus 3 standard errors of 238 cells."""

ALL_DAYS = range(1, 8)


@dataclass(frozen=True, slots=True)
class Counted:
    """A count out of a total."""

    good: int
    total: int

    def __str__(self) -> str:
        return f"{self.good} of {self.total}"


def recovered_on(days: Days, cell: Cell, day: int) -> Recovered:
    recovered: Recovered = days[cell_name(cell.unit, day)][cell.channel][cell.term]
    return recovered


def inside(recovered: Recovered, true: float) -> bool:
    """Whether the interval, or the range below the upper limit, contains the true value; in SI."""
    return bool((recovered["low"] is None or recovered["low"] <= true) and true <= recovered["high"])


def covered(days: Days, cells: Iterable[Cell] = PRINTED, on: Iterable[int] = ALL_DAYS) -> Counted:
    """Days and coefficients whose 95 % interval contains the simulated value."""
    hits = [inside(recovered_on(days, c, day), truth(c, day) * c.si_factor) for c in cells for day in on]
    return Counted(sum(hits), len(hits))


def laid_within(days: Days, cell: Cell, on: Iterable[int] = ALL_DAYS) -> Counted:
    """Days on which the line drawn by hand gives the simulated value within the ± of the paper."""
    hits = []
    for day in on:
        laid = recovered_on(days, cell, day)["laid"]
        hits.append(laid is not None and abs(laid[0] / cell.si_factor - truth(cell, day)) <= cell.error)
    return Counted(sum(hits), len(hits))


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table of Markdown."""
    head = list(head)
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in rows)])


def decimals(spread: float) -> int:
    """Decimals that show a spread with two significant digits, at most 8."""
    return min(max(1 - math.floor(math.log10(spread)), 0), 8) if spread > 0 else 8


def fit_text(recovered: Recovered, cell: Cell) -> str:
    """``"0.972 [0.970, 0.975]"`` in the printed unit, or ``"below 0.12"``."""
    high = recovered["high"] / cell.si_factor
    if recovered["value"] is None:
        return f"below {high:.2g}"
    value, low = recovered["value"] / cell.si_factor, recovered["low"] / cell.si_factor
    d = decimals((high - low) / 2)
    return f"{value:.{d}f} [{low:.{d}f}, {high:.{d}f}]"


def read_text(read: list[float] | None, cell: Cell) -> str:
    """``"0.973 ± 0.074"`` in the printed unit; a dash if no line was fitted."""
    if read is None:
        return "–"
    value, error = read[0] / cell.si_factor, read[1] / cell.si_factor
    d = decimals(error)
    return f"{value:.{d}f} ± {error:.{d}f}"


def name_of(cell: Cell) -> str:
    sensor, axis = cell.channel.split("_")
    return f"{sensor} {axis.upper()}, {TERMS[cell.term].label('angular_rate' if sensor == 'gyro' else 'acceleration')}"


def unit_text(cell: Cell) -> str:
    return cell.printed_unit.replace("sqrt(h)", "√h").replace("h^(3/2)", "h^1.5").replace("h^2", "h²")


def unit_table(days: Days, unit: str) -> str:
    """Tables II, IV and V: printed and recovered values of day 1."""
    head = (
        "coefficient",
        "unit as printed",
        "the paper",
        "fit, 95 % interval",
        "read off by the rules",
        "line by hand",
        "its τ [s]",
    )
    rows = []
    for cell in (cell for cell in PRINTED if cell.unit == unit):
        recovered = recovered_on(days, cell, 1)
        laid = recovered["laid"]
        span = "–" if laid is None else f"{laid[2]:.3g} … {laid[3]:.4g}"
        rows.append(
            (
                name_of(cell),
                unit_text(cell),
                f"{cell.printed} ± {cell.printed_error}",
                fit_text(recovered, cell) + ("" if inside(recovered, truth(cell, 1) * cell.si_factor) else ", misses"),
                read_text(recovered["read"], cell),
                read_text(laid, cell),
                span,
            )
        )
    return table(head, rows)


def plus_minus_table() -> str:
    """Every ± of Tables II, IV and V with its cluster size."""
    head = (
        "table",
        "coefficient",
        "value",
        "printed ±",
        "n",
        "τ [s]",
        "δ, eq. (26)",
        "rounded first",
        "value · δ",
        "by chance",
    )
    rows: list[tuple[str, ...]] = []
    for cell in PRINTED:
        explanation = decoded(cell)
        start = (TITLES[cell.unit], name_of(cell), cell.printed, cell.printed_error)
        chance = f"{100 * reproducing_share(cell, rounding=True):.0f} %"
        if explanation is None:
            rows.append((*start, "–", "–", "–", "–", "not explained", chance))
            continue
        size, delta, text = explanation
        rounded = f"to {round(100 * delta, 1):g} %" if size.rounded else "no"
        tau = f"{size.size / RATES[cell.unit]:.6g}"
        rows.append((*start, f"2^{math.log2(size.size):.0f}", tau, f"{100 * delta:.3g} %", rounded, text, chance))
    explained = [cell for cell in PRINTED if decoded(cell)]
    agreeing = sum(
        explanation[2] == cell.printed_error for cell in explained if (explanation := decoded(cell)) is not None
    )
    assert all(not reproducing_sizes(cell) for cell in undecoded())
    return (
        f"{agreeing} of {len(PRINTED)} printed errors are eq. (26) at a power of 2, to the printed digit.\n\n"
        f"{table(head, rows)}"
    )


def chance_table() -> str:
    """Number of ± that powers of 2 explain, and that octaves from a random start would explain."""
    plain = [cell for cell in PRINTED if significant_digits(cell) > 1]
    coarse = [cell for cell in PRINTED if significant_digits(cell) == 1]
    groups = (
        ("all, δ as it is", PRINTED, False),
        ("all, δ as it is or rounded to 0.1 %", PRINTED, True),
        ("± with two or three digits, as it is or rounded", plain, True),
        ("± with one digit, as it is or rounded", coarse, True),
    )
    rows = []
    for name, cells, rounding in groups:
        expected = expected_hits(cells, rounding=rounding)
        chance = f"{expected.mean:.1f} ± {expected.std:.1f}"
        rows.append((name, f"{expected.hits} of {expected.cells}", chance, f"{expected.p_value:.1g}"))
    rest = [cell for cell in PRINTED if not any(not decoded.rounded for decoded in reproducing_sizes(cell))]
    further = [cell for cell in rest if any(not decoded.rounded for decoded in reproducing_sizes(cell, per_octave=2))]
    between = sum(reproducing_share(cell, rounding=False) for cell in rest)
    text = (
        f"The sizes halfway between the powers of 2 give {len(further)} further cell without rounding "
        f"({', '.join(f'{TITLES[cell.unit]}, {name_of(cell)}' for cell in further)}); by chance {between:.1f} are expected."
    )
    return f"{table(('cells', 'reproduced', 'by chance', 'probability of as many by chance'), rows)}\n\n{text}"


def unexplained_table() -> str:
    """The ± that no power of 2 explains."""
    head = ("table", "coefficient", "printed", "τ that would give it [s]", "n there")
    rows = []
    for cell in undecoded():
        low, high = reproducing_times(cell)
        sizes = range(math.ceil(low * RATES[cell.unit]), math.floor(high * RATES[cell.unit]) + 1)
        n = f"{sizes[0]} … {sizes[-1]}" if len(sizes) > 1 else f"{sizes[0]}" if sizes else "no whole number"
        printed = f"{cell.printed} ± {cell.printed_error}"
        rows.append((TITLES[cell.unit], name_of(cell), printed, f"{low:.4g} … {high:.4g}", n))
    return table(head, rows)


def days_table(days: Days, unit: str) -> str:
    """Tables I and III: coefficients by day, and recovered values."""
    head = ("axis", "day", "printed, simulated", "fit, 95 % interval", "contains it", "line by hand")
    rows = []
    for cell in (cell for cell in PRINTED if cell.unit == unit and cell.channel in DAYS[unit]):
        if cell.term != "quantization":
            continue
        for day in ALL_DAYS:
            recovered, true = recovered_on(days, cell, day), truth(cell, day)
            laid = recovered["laid"][0] / cell.si_factor
            contains = "yes" if inside(recovered, true * cell.si_factor) else "**no**"
            axis = cell.channel[-1].upper() if day == 1 else ""
            rows.append((axis, f"{day}", f"{true:.3f}", fit_text(recovered, cell), contains, f"{laid:.4f}"))
    return table(head, rows)


@dataclass(frozen=True, slots=True)
class Spread:
    """Standard deviations of seven days of a gyro. [arcsec]"""

    unit: str
    channel: str
    printed: str
    used: float  # of the printed values, with which the days are simulated; ddof = 1
    ddof_0: float
    fits: float
    laid: float  # of the lines drawn by hand


def std_rows(days: Days, on: Iterable[int] = ALL_DAYS) -> list[Spread]:
    """The columns of Tables I and III."""
    rows = []
    on = list(on)
    arcsec = to_si(1, "arcsec")
    for unit, axes in DAYS.items():
        for channel, values in axes.items():
            recovered = [days[cell_name(unit, day)][channel]["quantization"] for day in on]
            used = [values[day - 1] for day in on]
            fits = [value_of_day["value"] / arcsec for value_of_day in recovered]
            laid = [value_of_day["laid"][0] / arcsec for value_of_day in recovered]
            spreads = [float(np.std(x, ddof=ddof)) for x, ddof in ((used, 1), (used, 0), (fits, 1), (laid, 1))]
            rows.append(Spread(unit, channel, STD[unit][channel], *spreads))
    return rows


LAST_DIGIT = 0.001
"""Last digit of the printed STD rows. [arcsec]"""


def std_table(days: Days) -> str:
    """The STD rows of Tables I and III."""
    head = (
        "unit",
        "axis",
        "printed STD",
        "of the printed values, ddof = 1",
        "ddof = 0",
        "of the fits",
        "of the lines by hand",
    )
    rows = std_rows(days)
    lines = [
        (NAMES[r.unit], r.channel[-1].upper(), r.printed, *(f"{x:.4f}" for x in (r.used, r.ddof_0, r.fits, r.laid)))
        for r in rows
    ]
    fits = sum(abs(r.fits - r.used) <= LAST_DIGIT for r in rows)
    hand = sum(abs(r.laid - r.used) <= LAST_DIGIT for r in rows)
    text = (
        f"The standard deviation of the fits is within one last digit ({LAST_DIGIT:g} arcsec) of that of the simulated "
        f"values in {fits} of {len(rows)} columns, that of the lines by hand in {hand}."
    )
    return f"{table(head, lines)}\n\n{text}"


def coverage_table(days: Days) -> str:
    """Cells whose interval contains the simulated value, by unit and term, and the gate."""
    rows = []
    for unit in NAMES:
        kinds = dict.fromkeys((c.channel.split("_")[0], c.term) for c in PRINTED if c.unit == unit)
        for sensor, term in kinds:
            cells = [c for c in PRINTED if (c.unit, c.term) == (unit, term) and c.channel.startswith(sensor)]
            good = covered(days, cells)
            values = [recovered_on(days, c, day)["value"] for c in cells for day in ALL_DAYS]
            limits = sum(value is None for value in values)
            laid = [laid_within(days, c) for c in cells]
            within = Counted(sum(c.good for c in laid), sum(c.total for c in laid))
            label = TERMS[term].label("angular_rate" if sensor == "gyro" else "acceleration")
            rows.append((NAMES[unit], f"{sensor}, {label}", str(good), f"{limits}", str(within)))
    every = covered(days)
    share = every.good / every.total
    verdict = "met" if share >= MIN_INSIDE else "NOT met"
    hand = [laid_within(days, cell) for cell in PRINTED]
    always = sum(counted.good == counted.total for counted in hand)
    head = (
        "unit",
        "coefficient",
        "95 % interval contains the day's value",
        "of them upper limits",
        "line by hand within the paper's ±",
    )
    return (
        f"{table(head, rows)}\n\n"
        f"All: **{every}** intervals ({100 * share:.1f} %) contain the value that was simulated on the day. "
        f"Gate: at least {100 * MIN_INSIDE:.0f} %, {verdict}.\n\n"
        f"Lines by hand: within the paper's own ± in {sum(c.good for c in hand)} of {sum(c.total for c in hand)} "
        f"cells; on all seven days for {always} of {len(hand)} coefficients."
    )


def aliasing_table(days: Days) -> str:
    """Table with the numbers of Fig. 12."""
    head = ("rate [Hz]", "rate over 30 Hz", "N grows by, first order", "second order", "fitted N over the sensor's")
    rows, hits = [], 0
    for text, (value, low, high) in days[FIG_12].items():
        rate = float(text)
        laws = (f"{aliasing_inflation(rate=rate, bandwidth=30, order=order):.3f}" for order in (1, 2))
        rows.append((text, f"{rate / 30:.3g}", *laws, f"{value:.3f} [{low:.3f}, {high:.3f}]"))
        hits += low <= aliasing_inflation(rate=rate, bandwidth=30) <= high
    return f"{table(head, rows)}\n\n{hits} of {len(rows)} intervals contain the value for the first order."


def repeated(days: Days, unit: str, channel: str) -> dict[str, RandomEffects]:
    """Quantization noise of a gyro on seven days: printed values with the ± of the paper, and with the error of the
    coefficient and of the rounding to 0.001; fits with their errors.
    """
    printed = np.array(DAYS[unit][channel])
    cell = next(c for c in PRINTED if (c.unit, c.channel, c.term) == (unit, channel, "quantization"))
    rounding = 0.001 / math.sqrt(12)
    exact = np.hypot(printed / math.sqrt(2 * cell.samples), rounding)
    recovered = [recovered_on(days, cell, day) for day in ALL_DAYS]
    fits = np.array([value_of_day["value"] for value_of_day in recovered]) / cell.si_factor
    errors = (
        np.array([value_of_day["high"] - value_of_day["low"] for value_of_day in recovered]) / cell.si_factor / 2 / 1.96
    )
    return {
        "printed, the paper's ±": random_effects(printed, np.full(7, cell.error)),
        "printed, error of Q": random_effects(printed, exact),
        "recovered, error of the fit": random_effects(fits, errors),
    }


_SMALLEST_P = 1e-300


def random_effects_table(days: Days) -> str:
    """Result of `random_effects` for Tables I and III, compared with the rule of the paper."""
    head = (
        "unit",
        "axis",
        "values and errors",
        "error",
        "homogeneity",
        "between days",
        "next day",
        "test",
        "paper's rule",
    )
    rows = []
    for unit, axes in DAYS.items():
        for channel in axes:
            for k, (label, effects) in enumerate(repeated(days, unit, channel).items()):
                assert effects.error is not None
                assert effects.p_value is not None
                p = f"p = {effects.p_value:.2g}" if effects.p_value > _SMALLEST_P else f"p < {_SMALLEST_P:.0e}"
                sizes = (effects.tau, effects.tau_low, effects.tau_high)
                tau, low, high = (f"{100 * (x or 0):.2f}" for x in sizes)
                rule = "repeatable" if effects.accepted_by_paper() else "not"
                first = (NAMES[unit], channel[-1].upper()) if k == 0 else ("", "")
                spread = f"{tau} [{low}, {high}] %"
                next_day = f"±{100 * (effects.next_error or 0):.1f} %"
                judgement = JUDGEMENTS[effects.judgement].partition(":")[0].format(run=(effects.outlier or 0) + 1)
                rows.append((*first, label, f"{100 * effects.error:.2f} %", p, spread, next_day, judgement, rule))
    return table(head, rows)


def navigation_text(days: Days) -> str:
    """Result of further records for the intervals of the random walk of the CIMU."""
    total, low, high = days[NAVIGATION]
    inside = total - low - high
    error = math.sqrt(0.05 * 0.95 / total)
    return (
        f"The CIMU's random walk in {total} axes of {total // 3} more records: {inside} intervals "
        f"({100 * inside / total:.1f} %) contain the value; 95 ± {100 * 1.96 * error:.1f} % is expected. {low} lie "
        f"below it and {high} above."
    )


def _tables() -> Iterator[tuple[str, Callable[[Days], str]]]:
    for unit in NAMES:
        yield f"unit {unit}", lambda days, unit=unit: unit_table(days, unit)  # type: ignore[misc]
    for unit in DAYS:
        yield f"days {unit}", lambda days, unit=unit: days_table(days, unit)  # type: ignore[misc]
    yield "std", std_table
    yield "random effects", random_effects_table
    yield "aliasing", aliasing_table
    yield "navigation", navigation_text
    yield "coverage", coverage_table
    yield "plus-minus", lambda _: plus_minus_table()
    yield "chance", lambda _: chance_table()
    yield "unexplained", lambda _: unexplained_table()


TABLES: Mapping[str, Callable[[Days], str]] = dict(_tables())
"""Tables of the pages, by the names in their marks."""
