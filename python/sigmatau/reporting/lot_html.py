"""The page of a lot as one HTML file that opens offline."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from functools import cache

from sigmatau._version import __version__
from sigmatau.lots.lot_remark import CODES, STATES, Remark
from sigmatau.lots.lot_result import JudgedUnit, Lot, pooled
from sigmatau.lots.lot_screen import drift_lines
from sigmatau.lots.lot_words import STATE_WORDS, count_text, listed, percent, remark_text, what_text, what_unit
from sigmatau.record.record import stream_name
from sigmatau.reporting.html import POLICY, asset
from sigmatau.reporting.lot_charts import charts_of
from sigmatau.reporting.markup import Markup, data, element, joined, name, raised, script, style
from sigmatau.results import printable

_SCRIPTS = ("page", "numbers", "plot", "lot")
MARKS = {"passed": "good", "failed": "poor", "not_judged": "partial", "unreadable": "error", "missing": "error"}
"""Colours of the states, as those of trust."""

_COLUMNS = ("random_walk", "bias_instability")  # coefficients with a column of their own, the largest of the axes
_MOST_COLUMNS = 6


def page(lot: Lot, *, title: str, command: str | None, date: datetime) -> str:
    """The lot as HTML."""
    moment = date.strftime("%Y-%m-%d %H:%M UTC" if date.tzinfo is UTC else "%Y-%m-%d %H:%M")
    spec = "" if lot.spec is None else lot.spec.name
    made_by = f"sigmatau {__version__}"
    sections = [
        ("summary", "Summary", _summary(lot)),
        ("units", "Units", _units(lot)),
        ("distribution", "Distribution and drift", _distribution(lot)),
        ("curves", "Allan deviation", _curves()),
        ("findings", "Findings of each unit", _findings(lot)),
        ("done", "What was done", _done(lot, command, moment)),
    ]
    links = [element("a", heading, href=f"#{id_}") for id_, heading, _ in sections]
    head = element(
        "head",
        element("meta", charset="utf-8"),
        element("meta", name="generator", content=made_by),
        element("meta", http_equiv="Content-Security-Policy", content=POLICY),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("meta", name="color-scheme", content="light dark"),
        element("title", f"{printable(title)} – {spec or 'lot report'}"),
        style(asset("uplot/uPlot.min.css") + asset("report.css") + asset("lot.css")),
    )
    chips = [
        element("span", f"{number} {STATE_WORDS[state]}", class_=f"chip {MARKS[state]}")  # type: ignore[index]
        for state, number in lot.counts.items()
        if number
    ]
    body = element(
        "body",
        element("a", "Skip to the results", href="#summary", class_="skip"),
        element(
            "header",
            element("p", "Lot report", class_="kind"),
            element("h1", name(printable(title) if not spec else f"{printable(title)}: {spec}")),
            element("p", element("span", moment), class_="headline"),
            element("p", chips, class_="chips"),
            element("button", "Dark", type="button", id="theme", class_="quiet", hidden=True),
        ),
        element("nav", links, aria_label="Sections"),
        element(
            "main",
            element("noscript", element("p", "The charts need JavaScript; all numbers are in the tables.")),
            (element("section", element("h2", heading), inside, id=id_) for id_, heading, inside in sections),
        ),
        element("footer", f"Made by {made_by} on {moment}. This file needs no network."),
        data(charts_of(lot), id_="charts"),
        script(_scripts()),
    )
    return f"<!DOCTYPE html>\n{element('html', head, body, lang='en')}\n"


@cache
def _scripts() -> str:
    own = "\n".join(asset(f"{module}.js") for module in _SCRIPTS)
    notice = asset("uplot/LICENSE").strip()
    return f'/* uPlot:\n{notice}\n*/\n{asset("uplot/uPlot.iife.min.js")}\n(() => {{\n"use strict";\n{own}\n}})();'


def _summary(lot: Lot) -> Markup:
    words = count_text(lot.counts, spec="" if lot.spec is None else lot.spec.name)  # type: ignore[arg-type]
    more = [element("p", f"{lot.too_many} more units than the {lot.expected} expected.")] if lot.too_many else []
    drifts = [element("p", raised(line)) for line in drift_lines(lot, pooled(lot), width=None)]
    return joined(element("p", f"{words}."), more, drifts, _claims(lot))


def _claims(lot: Lot) -> Markup:
    """The specification, number by number, with how it is judged."""
    if lot.spec is None or not lot.spec.claims:
        return Markup("")
    factor = lot.settings.factor
    rows = []
    for claim in lot.spec.claims:
        maximum = claim.maximum_text
        if not maximum:
            maximum = "none: not judged" if factor is None else f"{factor:g} × {claim.usual}"
        usual = f"{claim.typical_text} ({claim.usual})" if claim.typical_text else "–"
        cells = (claim.sensor, claim.label, maximum, usual, claim.convention)
        rows.append(element("tr", (element("td", raised(text)) for text in cells)))
    head = (element("th", text, scope="col") for text in ("Sensor", "Value", "Maximum", "Typical", "Convention"))
    table = element("table", element("thead", element("tr", head)), element("tbody", rows), class_="distributions")
    return joined(element("h3", "Specification"), _scrolled(table))


def _scrolled(table: Markup) -> Markup:
    return element("div", table, class_="scrolled", tabindex="0", role="region", aria_label="Table")


def _units(lot: Lot) -> Markup:
    columns = _columns(lot)
    heads = [
        element("th", "Unit", scope="col", data_sort="text"),
        element("th", "State", scope="col", data_sort="number"),
    ]
    if lot.spec is not None:
        heads.append(element("th", "of maximum, %", scope="col", data_sort="number", title="Largest share of a maximum"))
    heads += [
        element("th", raised(f"{sensor} {_SHORT[what]} [{text}]"), scope="col", data_sort="number")
        for sensor, what, text, _ in columns
    ]
    heads.append(element("th", "Why", scope="col"))
    order = {state: k for k, state in enumerate(STATES)}
    rows = [_unit(one, lot, columns, order) for one in sorted(lot.units, key=lambda one: order[one.state])]
    table = element("table", element("thead", element("tr", heads)), element("tbody", rows), class_="units")
    about = "Of coefficients, the largest of the axes. A head of the table sorts it."
    return joined(element("p", about, class_="about"), _scrolled(table))


_SHORT = {"random_walk": "N", "bias_instability": "B", "means_10": "10 s means", "means_100": "100 s means"}


def _columns(lot: Lot) -> list[tuple[str, str, str, float]]:
    """Sensor, coefficient, unit and factor of the columns."""
    found = {}
    for one in lot.distributions:
        if one.what in (*_COLUMNS, "means_10"):
            text, factor = what_unit(one.what, *lot.quantity_of(one.channel))
            found.setdefault((stream_name(one.channel), one.what), (text, factor))
    return [(*key, *value) for key, value in found.items()][:_MOST_COLUMNS]


def _unit(
    one: JudgedUnit, lot: Lot, columns: list[tuple[str, str, str, float]], order: Mapping[str, int]
) -> Markup:
    chip = element("span", STATE_WORDS[one.state], class_=f"chip {MARKS[one.state]}")
    cells = [
        element("th", name(printable(one.name)), scope="row", title=printable(one.name)),
        element("td", chip, data_key=str(order[one.state])),
    ]
    if lot.spec is not None:
        share = worst_share(one)
        cells.append(element("td", "" if share is None else f"{100 * share:.3g}", class_="value"))
    for sensor, what, _, factor in columns:
        values = [
            coefficient.value
            for channel, part in one.result.channels.items()
            if stream_name(channel) == sensor and (coefficient := part.coefficients.get(what)) is not None
            if coefficient.value is not None
        ]
        cells.append(element("td", f"{max(values) / factor:.3g}" if values else "", class_="value"))
    why = one.reason if one.state != "passed" else "; ".join(remark_text(r) for r in one.notes if r.code in CODES)
    return element("tr", cells, element("td", why, class_="reason"))


def worst_share(one: JudgedUnit) -> float | None:
    """The largest share of a maximum that a value of a unit has; None without any."""
    shares = [
        (reading.measured.value if reading.measured.value is not None else reading.measured.upper_limit or 0.0)
        / reading.maximum.limit
        for judged in (one.verdict.judged if one.verdict is not None else ())
        for reading in judged.readings
        if reading.maximum is not None and reading.measured.anything and reading.maximum.limit > 0
    ]
    return max(shares) if shares else None


def _distribution(lot: Lot) -> Markup:
    if not lot.distributions:
        return element("p", "No coefficient is shown by half of the units or more.", class_="none")
    heads = ("Axis", "Coefficient", "Units", "Median", "± %", "Smallest", "Largest", "Maximum", "Unit", "Drift, %", "Outliers")
    rows = []
    for one in lot.distributions:
        quantity, unit = lot.quantity_of(one.channel)
        text, factor = what_unit(one.what, quantity, unit)
        limits = " or ".join(f"{limit / factor:.3g}" for limit in lot.limits(one.channel, one.what)) or "–"
        cells = (
            what_text(one.what, quantity),
            f"{len(one.units)}" + (f" of {len(one.units) + one.below}" if one.below else ""),
            f"{one.median / factor:.3g}",
            percent(one.spread),
            f"{one.low / factor:.3g}",
            f"{one.high / factor:.3g}",
            limits,
            text,
            "–" if one.drift is None else f"{100 * one.drift:+.2g}",
            listed(one.outliers) or "–",
        )
        head = element("th", name(printable(one.channel)), scope="row")
        rows.append(element("tr", head, (element("td", raised(cell)) for cell in cells)))
    table = element(
        "table",
        element("thead", element("tr", (element("th", text, scope="col") for text in heads))),
        element("tbody", rows),
        class_="distributions",
    )
    about = (
        "±: standard deviation over the units, robust, in per cent. Drift: change from the first to the last unit, in the"
        " order in which they were given, where it is significant. Outliers: found in 5 % of lots without any."
    )
    charts = element("div", class_="charts", data_lot="values")
    return joined(element("p", about, class_="about"), _scrolled(table), element("p", ""), charts)


def _curves() -> Markup:
    about = (
        "Thin: all units. Thick: their median, with the range of the middle 80 %. In colour: units that failed or are unlike"
        " the others. Dashed: maxima of the specification; each term alone has to lie below its line."
    )
    return joined(element("p", about, class_="about"), element("div", class_="charts", data_lot="curves"))


def _findings(lot: Lot) -> Markup:
    units = [one for one in lot.units if any(True for _ in _told(one))]
    if not units:
        return element("p", "Nothing was found.", class_="none")
    parts = (
        element(
            "details",
            element(
                "summary",
                name(printable(one.name)),
                " ",
                element("span", STATE_WORDS[one.state], class_=f"chip {MARKS[one.state]}"),
            ),
            element("ul", (element("li", raised(text)) for text in _told(one)), class_="notes"),
        )
        for one in units
    )
    return element("div", parts, class_="unit-findings")


def _told(one: JudgedUnit) -> Iterator[str]:
    """Remarks of a unit, with what to do about its findings."""
    actions = {finding.code: finding.action for finding in one.result.findings}
    for remark in one.remarks:
        if remark.code != "no_specification":
            yield f"{remark_text(remark)}.{_action(remark, actions)}"


def _action(remark: Remark, actions: Mapping[str, str]) -> str:
    action = actions.get(remark.code, "") if remark.kind == "data" else ""
    return f" {action}." if action else ""


def _done(lot: Lot, command: str | None, moment: str) -> Markup:
    settings = lot.settings
    shown = {
        "Specification": "none" if lot.spec is None else f"{lot.spec.name} ({lot.spec.maker}); {lot.spec.source}",
        "Expected": "not stated" if lot.expected is None else f"{lot.expected} units",
        "Confidence level": f"{100 * settings.level:g} % of above and of below a maximum, each",
        "Without a maximum": "not judged" if settings.factor is None else f"{settings.factor:g} × typical or 1 σ value",
        "Undecided": settings.undecided.replace("-", " "),
        "Warnings": "fail a unit" if settings.fail_on else "a unit is not judged",
        "Accepted": ", ".join(settings.accept) or "nothing",
        "Exit code": str(lot.exit_code),
        "Command": command or "",
        "Date": moment,
        "Version": f"sigmatau {__version__}",
    }
    rows = (element("div", element("dt", key), element("dd", name(printable(text)))) for key, text in shown.items() if text)
    return element("dl", rows)
