"""The page of a lot as one HTML file that opens offline."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from typing import Any
from urllib.parse import quote

import numpy as np

from sigmatau import __version__
from sigmatau.arrays import Floats
from sigmatau.lab.lots.lot_bands import Band
from sigmatau.lab.lots.lot_findings import CODES
from sigmatau.lab.lots.lot_remark import STATES, State
from sigmatau.lab.lots.lot_result import JudgedUnit, Lot
from sigmatau.lab.lots.lot_screen import drift_lines
from sigmatau.lab.lots.lot_words import STATE_WORDS, count_text, without_curves_text
from sigmatau.lab.lots.pooling import Pooled, pooled
from sigmatau.lab.lots.short_names import common_prefix
from sigmatau.lab.pages.lot_content import (
    DISTRIBUTION_HEADS,
    MARKS,
    Column,
    claim_rows,
    distribution_rows,
    done_rows,
    moment_text,
    number_columns,
    unit_values,
)
from sigmatau.reporting.html import asset, done, frame, scrolled, section
from sigmatau.reporting.markup import Markup, element, joined, name, raised
from sigmatau.results import printable

SCRIPTS = ("page", "numbers", "plot", "theme", "paper")
"""Modules of the report that the pages of the laboratory share."""


def page(lot: Lot, *, title: str, command: str | None, date: datetime, reports: Mapping[str, str]) -> str:
    """The lot as HTML."""
    moment = moment_text(date)
    spec = "" if lot.spec is None else lot.spec.name
    chips = [
        element("span", f"{number} {STATE_WORDS[state]}", class_=f"chip {MARKS[state]}")  # type: ignore[index]
        for state, number in lot.counts.items()
        if number
    ]
    header = element(
        "header",
        element("p", "Lot report", class_="kind"),
        element("h1", name(printable(title) if not spec else f"{printable(title)}: {spec}")),
        element("p", element("span", moment), class_="headline"),
        element("p", chips, class_="chips"),
        element("button", "Dark", type="button", id="theme", class_="quiet", hidden=True),
    )
    return frame(
        title=f"{printable(title)} – {spec or 'lot report'}",
        made_by=f"sigmatau {__version__}",
        date=moment,
        header=header,
        sections=[
            section("summary", "Summary", _summary(lot)),
            section("units", "Units", _units(lot, reports)),
            section("distribution", "Distribution and drift", _distribution(lot)),
            section("curves", "Allan deviation", _curves(lot)),
            section("findings", "Findings of each unit", _findings(lot)),
            section("done", "What was done", done(done_rows(lot, command, moment))),
        ],
        charts=chart_data(lot),
        styles=asset("report.css") + asset("lot.css", __package__),
        scripts=[
            *(asset(f"{module}.js") for module in SCRIPTS),
            *(asset(f, __package__) for f in ("figures.js", "lot.js")),
        ],
    )


def _summary(lot: Lot) -> Markup:
    words = count_text(lot.counts, spec="" if lot.spec is None else lot.spec.name)  # type: ignore[arg-type]
    surplus = [element("p", f"{lot.too_many} more units than the {lot.expected} expected.")] if lot.too_many else []
    drifts = [element("p", raised(line)) for line in drift_lines(lot, width=None)]
    return joined(element("p", f"{words}."), surplus, drifts, _claims(lot))


def _claims(lot: Lot) -> Markup:
    """The table of the claims of the specification."""
    claims = claim_rows(lot)
    if not claims:
        return Markup("")
    rows = (element("tr", (element("td", raised(text)) for text in row)) for row in claims)
    head = (element("th", text, scope="col") for text in ("Sensor", "Value", "Maximum", "Typical", "Convention"))
    table = element("table", element("thead", element("tr", head)), element("tbody", rows), class_="distributions")
    return joined(element("h3", "Specification"), scrolled(table))


def _units(lot: Lot, reports: Mapping[str, str]) -> Markup:
    columns = number_columns(lot)
    heads = [
        element("th", "Unit", scope="col", data_sort="text"),
        element("th", "State", scope="col", data_sort="number"),
        element("th", "Why", scope="col"),
        *(element("th", raised(head), scope="col", data_sort="number") for _, _, head, _ in columns),
    ]
    order = {state: k for k, state in enumerate(STATES)}
    prefix = common_prefix([unit.name for unit in lot.units if unit.state != "missing"])
    rows = [
        _unit(unit, columns, order, prefix, reports.get(unit.name))
        for unit in sorted(lot.units, key=lambda unit: order[unit.state])
    ]
    table = element("table", element("thead", element("tr", heads)), element("tbody", rows), class_="units")
    about = "Coefficients are the largest of the axes. Select the head of a column to sort by it."
    begin = [" Names begin with ", name(printable(prefix)), "."] if prefix else []
    search = element(
        "input", type="search", placeholder="Search units, states and reasons", aria_label="Search the units"
    )
    count = element("output", class_="about")
    return joined(
        element("p", about, begin, class_="about"),
        element("p", search, " ", count, id="search", class_="search", hidden=True),
        scrolled(table),
    )


def _unit(
    unit: JudgedUnit, columns: Sequence[Column], order: Mapping[State, int], prefix: str, report: str | None
) -> Markup:
    chip = element("span", STATE_WORDS[unit.state], class_=f"chip {MARKS[unit.state]}")
    why = unit.brief if unit.state != "passed" else "; ".join(r.text for r in unit.notes if r.code in CODES)
    shown: Markup = name(printable(unit.name.removeprefix(prefix)))
    if report is not None:
        shown = element("a", shown, href=quote(report))
    return element(
        "tr",
        element("th", shown, scope="row", title=printable(unit.name)),
        element("td", chip, data_key=str(order[unit.state])),
        element("td", why, class_="reason"),
        (element("td", cell, class_="value") for cell in unit_values(unit, columns)),
    )


def _distribution(lot: Lot) -> Markup:
    if not lot.distributions:
        return element("p", "No coefficient is shown by half of the units or more.", class_="none")
    rows = [
        element("tr", element("th", name(row[0]), scope="row"), (element("td", raised(cell)) for cell in row[1:]))
        for row in distribution_rows(lot)
    ]
    table = element(
        "table",
        element("thead", element("tr", (element("th", text, scope="col") for text in DISTRIBUTION_HEADS))),
        element("tbody", rows),
        class_="distributions",
    )
    about = (
        "±: robust standard deviation over the units. Drift: change from the first to the last unit, in the order in which"
        " they were given, if significant. In at most 5 % of lots without outliers, a unit is reported as one. Charts:"
        " dashed, maximum; dotted, median; red points, units that failed or differ from the others."
    )
    charts = element("div", class_="charts", data_lot="values")
    return joined(element("p", about, class_="about"), scrolled(table), element("p", ""), charts)


def _curves(lot: Lot) -> Markup:
    text = without_curves_text([unit.remarks for unit in lot.units])
    if text and not any(len(band.tau) for band in lot.bands):
        return element("p", f"{text}.", class_="none")
    about = (
        "Thin: all units. Thick: their median, with the range of the middle 80 %. In colour: units that failed or are unlike"
        " the others. Dashed: maxima of the specification, each for its term alone."
    ) + (f" {text}." if text else "")
    return joined(element("p", about, class_="about"), element("div", class_="charts", data_lot="curves"))


def _findings(lot: Lot) -> Markup:
    units = [unit for unit in lot.units if any(True for _ in _remark_texts(unit))]
    if not units:
        return element("p", "Nothing was found.", class_="none")
    parts = (
        element(
            "details",
            element(
                "summary",
                name(printable(unit.name)),
                " ",
                element("span", STATE_WORDS[unit.state], class_=f"chip {MARKS[unit.state]}"),
            ),
            element("ul", (element("li", raised(text)) for text in _remark_texts(unit)), class_="notes"),
        )
        for unit in units
    )
    return element("div", parts, class_="unit-findings")


def _remark_texts(unit: JudgedUnit) -> Iterator[str]:
    """Remarks on a unit, with the actions of its findings."""
    for remark in unit.remarks:
        if remark.code not in ("no_specification", "curves_not_kept"):  # of the lot, not of the unit
            action = remark.finding.words_of_files().action if remark.kind == "data" else ""
            yield f"{remark.text}." + (f" {action}." if action else "")


_DIGITS = 4  # digits of values
_STEP = 1000  # number of steps per decade of curves


def chart_data(lot: Lot) -> dict[str, Any]:
    """Names of the units without their common prefix, panels of curves by channel, and panels of values by coefficient.

    They are plain values for JSON, short enough for hundreds of units: curves are differences from the median of the lot in
    thousandths of a decade, and values have four digits.
    """
    number = {unit.name: k for k, unit in enumerate(lot.units)}
    prefix = common_prefix([unit.name for unit in lot.units if unit.state != "missing"])
    return {
        "units": [name.removeprefix(prefix) for name in number],
        "curves": [_curve_chart(lot, band, number) for band in lot.bands if len(band.tau)],
        "values": [_value_chart(row, number) for row in pooled(lot)],
    }


def _curve_chart(lot: Lot, band: Band, number: Mapping[str, int]) -> dict[str, Any]:
    panel = lot.curves_of(band)
    rows = {}
    for unit_name, curve in panel.units.items():
        with np.errstate(divide="ignore", invalid="ignore"):
            steps = _STEP * (np.log10(curve) - np.log10(panel.median))
        rows[number[unit_name]] = [None if not math.isfinite(step) else round(step) for step in steps.tolist()]
    return {
        "channel": panel.title,
        "unit": panel.unit,
        "tau": _short(panel.tau),
        "median": _short(panel.median),
        "low": _short(panel.low),
        "high": _short(panel.high),
        "rows": list(rows.values()),
        "of": list(rows),
        "marked": [number[name] for name in lot.marked(band.channel) if name in number],
        "limits": [{"text": f"maximum of {label}", "adev": _short(line)} for label, line in panel.limits],
    }


def _value_chart(row: Pooled, number: Mapping[str, int]) -> dict[str, Any]:
    return {
        "title": row.title,
        "unit": row.unit,
        "limits": _short(row.limits),
        "channels": [
            {
                "name": distribution.channel,
                "at": [number[name] for name in distribution.units],
                "values": _short(distribution.values / row.factor),
                "median": _short([distribution.median / row.factor])[0],
                "outliers": [number[name] for name in distribution.outliers],
            }
            for distribution in row.distributions
        ],
    }


def _short(values: Floats | Sequence[float]) -> list[float]:
    return [float(f"{value:.{_DIGITS}g}") for value in np.asarray(values, dtype=np.float64).tolist()]
