"""A lot on a terminal of 80 columns: counts, units that did not pass, distributions."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np

from sigmatau.digits import round_to_error, significant
from sigmatau.hints import Hint, worded
from sigmatau.lab.lots.capability import LEAST_UNITS_OF_CPK
from sigmatau.lab.lots.lot_findings import MixedLot
from sigmatau.lab.lots.lot_remark import STATES
from sigmatau.lab.lots.lot_result import JudgedUnit, Lot
from sigmatau.lab.lots.lot_statistics import Distribution
from sigmatau.lab.lots.lot_words import (
    STATE_WORDS,
    change_text,
    count_text,
    listed,
    percent,
    what_text,
    without_curves_text,
)
from sigmatau.lab.lots.order_effect import OrderEffect
from sigmatau.lab.lots.pooling import Pooled, pooled
from sigmatau.noise.terms import TERMS
from sigmatau.results import WIDTH, aligned, printable, wrapped

_MOST_UNITS = 10  # largest number of units that are listed, each with its reason
_MOST_LINES = 3  # largest number of lines per unit
_ALIKE = 3  # smallest number of units with the same reason that share a line
_MOST_OUTLIERS = 4  # largest number of outliers that are listed
_LONGEST_NAME = 24  # longest name of a unit [characters]


def screen(lot: Lot, *, max_units: int = _MOST_UNITS, width: int = WIDTH) -> str:
    """Counts, the units that did not pass with their reasons, and the distribution of each coefficient.

    Parameters
    ----------
    lot : Lot
    max_units : int
        Largest number of units that are listed; the others are only counted.
    width : int
        Width of the terminal.
    """
    head = count_text(lot.counts, spec="" if lot.spec is None else lot.spec.name)  # type: ignore[arg-type]
    lines = wrapped([head], width=width)
    if lot.too_many:
        lines.append(f"{lot.too_many} more than the {lot.expected} expected")
    rows_shown = _groups(lot)
    names = max((len(name) for _, name, _ in rows_shown[:max_units]), default=0)
    states = max((len(state) for state, _, _ in rows_shown[:max_units]), default=0)
    for state, name, reason in rows_shown[:max_units]:
        lines += _wrap_reason(f"{state.ljust(states)}  {name.ljust(names)}  ", reason, width)
    if len(rows_shown) > max_units:
        lines.append(f"… and {len(rows_shown) - max_units} more; see -v or the files of -o")
    lines += _orientations(lot, width)
    if text := without_curves_text([unit.remarks for unit in lot.units]):
        lines += wrapped([f"{text}."], width=width)
    lines += _only_described(lot, width)
    rows = pooled(lot)
    lines += _only_typical(lot, rows, width)
    if rows:
        lines += ["", *table(rows, width=width)]
    lines += drift_lines(lot)
    return "\n".join(lines)


def _orientations(lot: Lot, width: int) -> list[str]:
    """The orientations of the units, if no orientation has most of them, so that no unit is an exception."""
    notes = (remark for unit in lot.units for remark in unit.remarks if remark.kind == "note")
    mixed = next((remark for remark in notes if isinstance(remark.details, MixedLot)), None)
    return [] if mixed is None else wrapped([f"{mixed.text}."], width=width)


def _only_described(lot: Lot, width: int) -> list[str]:
    """Number of units without a remark, if there is no specification."""
    shown = {unit.name for unit in listed_units(lot)}
    fit = sum(unit.state == "not_judged" and unit.name not in shown for unit in lot.units)
    if lot.spec is not None or not fit:
        return []
    spec = worded(str(Hint("spec", value="SPEC.toml")))
    sentence = f"{fit} {'unit' if fit == 1 else 'units'}: nothing found. Give {spec} to judge"
    return wrapped([f"{sentence} {'it' if fit == 1 else 'them'}."], width=width)


def _only_typical(lot: Lot, rows: Sequence[Pooled], width: int) -> list[str]:
    """Explanation why no unit passes, if the specification has no maximum."""
    if lot.spec is None or not rows or any(row.limits for row in rows):
        return []
    if any(claim.maximum is not None for claim in lot.spec.claims):
        return []
    factor = worded(str(Hint("factor", value=1.5)))
    text = f"{lot.spec.name} has typical values only, so that no unit passes. {factor} makes 1.5 times these values maxima."
    return wrapped([text], width=width)


def listed_units(lot: Lot) -> list[JudgedUnit]:
    """The units that did not pass and have a remark, the worst state first."""
    order = {state: k for k, state in enumerate(STATES)}
    shown = [
        unit
        for unit in lot.units
        if unit.state != "passed" and any(remark.code != "no_specification" for remark in unit.reasons)
    ]
    kinds = {"limit": 0, "lot": 0, "data": 0, "judging": 1, "note": 2}
    return sorted(shown, key=lambda unit: (order[unit.state], kinds[unit.reasons[0].kind]))


def _groups(lot: Lot) -> list[tuple[str, str, str]]:
    """State, name and reason of each listed unit. Many units with the same reason share a row."""
    shown = listed_units(lot)
    alike: dict[tuple[str, str], int] = {}
    for unit in shown:
        alike[unit.state, unit.reason] = alike.get((unit.state, unit.reason), 0) + 1
    rows = []
    for unit in shown:
        number = alike.pop((unit.state, unit.reason), 0)
        if number >= _ALIKE:
            rows.append((STATE_WORDS[unit.state], f"{number} units", unit.reason))
        elif number:
            same = [
                same_unit for same_unit in shown if (same_unit.state, same_unit.reason) == (unit.state, unit.reason)
            ]
            rows += [(STATE_WORDS[unit.state], _short(same_unit.name), same_unit.reason) for same_unit in same]
    return rows


def _short(name: str) -> str:
    name = printable(name)
    return name if len(name) <= _LONGEST_NAME else f"{name[: _LONGEST_NAME // 2 - 1]}…{name[-_LONGEST_NAME // 2 :]}"


def _wrap_reason(head: str, reason: str, width: int) -> list[str]:
    """Wrap a reason next to its unit, or below it in a narrow terminal. Only the files have the whole of a long reason."""
    indent = " " * (len(head) if len(head) <= width // 2 else 4)
    return textwrap.wrap(
        head + reason, width, subsequent_indent=indent, max_lines=_MOST_LINES, placeholder=" …", break_on_hyphens=False
    )


def _cut(line: str, width: int) -> str:
    """Cut a line of a table that does not fit in this width."""
    return line if len(line) <= width else f"{line[: width - 1]}…"


_HEAD = ("", "units", "median", "±%", "min", "max", "limit", "unit", "outliers")
_OPTIONAL_COLUMNS = (4, 5)  # indices of the columns that are dropped in a narrow terminal
_OUTLIER_COLUMN = 8  # index of the column that is shown only if there are outliers
_NOTE = "±%: robust standard deviation over the units, median of the axes"


def table(rows: list[Pooled], *, width: int = WIDTH) -> list[str]:
    """One row per coefficient of a sensor."""
    cells: list[tuple[str, ...]] = [
        _HEAD,
        *(
            (
                f"{row.sensor} {_abbreviated(row)}",
                str(row.units),
                significant(float(np.median(row.values)), zeros=True),
                percent(row.spread) if row.units > 1 else "–",
                significant(float(row.values.min()), zeros=True),
                significant(float(row.values.max()), zeros=True),
                " or ".join(f"{limit:.3g}" for limit in row.limits) or "–",
                row.unit,
                str(len({name for name, _ in row.outliers})) if row.outliers else "",
            )
            for row in rows
        ),
    ]
    if not any(row[_OUTLIER_COLUMN] for row in cells[1:]):
        cells = [row[:_OUTLIER_COLUMN] for row in cells]
    lines = aligned(cells)
    if max(map(len, lines)) > width:
        lines = aligned([tuple(cell for k, cell in enumerate(row) if k not in _OPTIONAL_COLUMNS) for row in cells])
    note = [_NOTE] if any(row.units > 1 for row in rows) else []
    return [_cut(line, width) for line in [*lines, *note]]


_MEANS = {"means_10": "10 s means", "means_100": "100 s means"}
_SHORT_NAMES = _MEANS | {name: term.short_name for name, term in TERMS.items()}


def _abbreviated(row: Pooled) -> str:
    return _SHORT_NAMES.get(row.what, row.label)


_OUTLYING = ("slow_noise", "outlier", "other_scale", "other_mean")  # codes of the remarks that are listed as outliers


def drift_lines(lot: Lot, *, width: int | None = WIDTH) -> list[str]:
    """Outliers, batches and drifts in words."""
    lines = _yield_lines(lot)
    lines += [f"Outlier {_short(unit.name)}: {text}" for unit, text in _outliers(lot)[:_MOST_OUTLIERS]]
    surplus = len(_outliers(lot)) - _MOST_OUTLIERS
    if surplus > 0:
        lines.append(f"… and {surplus} more outliers; see the files of -o")
    lines += _order_lines(lot)
    return lines if width is None else wrapped(lines, width=width)


def _yield_lines(lot: Lot) -> list[str]:
    """Yield, and the smallest capability of the coefficients with a maximum, in a line."""
    parts = []
    if lot.passing is not None and len(lot.units) >= LEAST_UNITS_OF_CPK:
        share = round_to_error(*(100 * end for end in (lot.passing.value, lot.passing.low, lot.passing.high)))
        parts.append(f"yield {share.value} % {share.interval}")
    numbers = [(number, part) for part in lot.distributions if (number := lot.capability(part)) is not None]
    if numbers:
        number, part = min(numbers, key=lambda entry: entry[0].value)
        rounded = round_to_error(number.value, number.low, number.high)
        parts.append(f"least Cpk {rounded.value} {rounded.interval}: {part.channel} {what_text(part.what, '')}")
    text = "; ".join(parts)
    return [text[:1].upper() + text[1:]] if text else []


def _outliers(lot: Lot) -> list[tuple[JudgedUnit, str]]:
    """Units with notes about outliers, and the most important note; notes that are reasons of a state are omitted."""
    results = []
    for unit in lot.units:
        notes = [remark for remark in unit.remarks if remark.code in _OUTLYING and remark not in unit.reasons]
        if notes:
            first = min(notes, key=lambda remark: _OUTLYING.index(remark.code))
            results.append((unit, first.text.replace("outlier: ", "")))
    return results


def _order_lines(lot: Lot) -> list[str]:
    """Batches and drifts. Coefficients that change with the same units share a line, the most significant one first."""
    groups: dict[tuple[str, str], list[Distribution]] = {}
    sensors = {part.channels for part in lot.drifts if len(part.channels) > 1}
    pooled_whats = {(channel, part.what) for part in lot.drifts for channel in part.channels if len(part.channels) > 1}
    for part in sorted(lot.drifts, key=lambda part: part.p_value or 0.0):
        if part.order is None or (part.channels not in sensors and (part.channel, part.what) in pooled_whats):
            continue
        first_unit = "" if part.order.kind == "drift" else part.order.first
        groups.setdefault(("up" if part.order.change > 0 else "down", first_unit), []).append(part)
    lines = []
    for members in groups.values():
        first = members[0]
        if first.order is None:
            continue
        head = "Drift" if first.order.kind == "drift" else _batch_text(lot, first.order)
        rest = [_series_text(part) for part in members[1:]]
        also = f"; also {listed(rest)}" if rest else ""
        lines.append(f"{head}: {_series_text(first)} {change_text(first.order)}{also}")
    return lines


def _series_text(part: Distribution) -> str:
    what = f"Allan deviation at {part.tau:.3g} s" if part.what == "adev" else what_text(part.what, "")
    return f"{part.channel} {what}"


def _batch_text(lot: Lot, effect: OrderEffect) -> str:
    """The units of a batch, with their dates if their names do not state them."""
    days = [lot[name].result.day for name in (effect.first, effect.last)]
    shown = [] if any(day in name for day, name in zip(days, (effect.first, effect.last), strict=True)) else [*{*days}]
    counted = ", ".join([f"{effect.units} units", " to ".join(sorted(shown))] if shown else [f"{effect.units} units"])
    return f"Batch from {_short(effect.first)} to {_short(effect.last)} ({counted})"
