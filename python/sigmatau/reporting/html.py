"""The report as one HTML file that opens offline: text as HTML, charts drawn by the scripts in ``assets``."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib import resources
from typing import Any

from sigmatau.digits import two_digits
from sigmatau.fitting.overview import MainCoefficient
from sigmatau.reporting.certificate_html import certificate_section
from sigmatau.reporting.content import Coefficients, Content, FindingText
from sigmatau.reporting.markup import Markup, css_string, data, element, joined, name, prose, raised, script, style
from sigmatau.reporting.words import SEVERITIES, TRUST, VERDICTS, WITHOUT_COEFFICIENTS, explain_trust, length_text

Section = tuple[str, str, Markup]
"""Anchor, heading and content of a section."""

_SCRIPTS = (
    *("page", "numbers", "plot", "theme", "paper", "frame", "saving"),
    *("deviation", "density", "residuals", "series", "map", "main"),
)
_MODULE_WORDS = re.compile(r"^(import .*;\n|export )", re.MULTILINE)
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data: blob:"


def page(content: Content) -> str:
    """The report as HTML."""
    sections = [
        *certificate_sections(content),
        section("summary", "Summary", _summary(content)),
        *_charts(content),
        section("coefficients", "Coefficients", _coefficients(content)),
        section("files", "Filter values", _files(content)),
        section("done", "What was done", done(content.done)),
    ]
    return frame(
        title=f"{content.title} – noise report",
        made_by=content.made_by,
        date=content.date,
        header=_head(content),
        sections=sections,
        charts=content.charts,
        styles=asset("report.css") + _margins(content),
        scripts=[asset(f"{module}.js") for module in _SCRIPTS],
    )


def _margins(content: Content) -> str:
    """The margins of printed pages: number of the report, and what ± means; the style sheet has the page number."""
    level = f"± and [low, high] of results: {content.level} intervals" if content.level else ""
    number = content.title if content.certificate is None else content.certificate.number
    texts = {"left": number, "center": level}
    boxes = (
        f"@bottom-{place} {{ content: {css_string(text)}; font: 8pt sans-serif; }}" for place, text in texts.items()
    )
    return f"@page {{ {' '.join(boxes)} }}"


def certificate_sections(content: Content) -> list[Section]:
    """Page 1, if the report has a certificate."""
    if content.certificate is None:
        return []
    return [("certificate", content.certificate.title, certificate_section(content.certificate))]


def frame(
    *,
    title: str,
    made_by: str,
    date: str,
    header: Markup,
    sections: Sequence[Section],
    charts: Mapping[str, Any],
    styles: str,
    scripts: Iterable[str],
) -> str:
    """A page that opens offline: a header, links to its sections, the sections, and the numbers of its charts."""
    links = [element("a", heading, href=f"#{id_}") for id_, heading, _ in sections]
    head = element(
        "head",
        element("meta", charset="utf-8"),
        element("meta", name="generator", content=made_by),
        element("meta", http_equiv="Content-Security-Policy", content=_POLICY),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("meta", name="color-scheme", content="light dark"),
        element("title", title),
        style(asset("uplot/uPlot.min.css") + styles),
    )
    body = element(
        "body",
        element("a", "Skip to the results", href="#summary", class_="skip"),
        header,
        element("nav", links, aria_label="Sections"),
        element(
            "main",
            element("noscript", element("p", "The charts need JavaScript; all numbers are in the tables.")),
            (body for _, _, body in sections),
        ),
        element("footer", f"Analysed by {made_by} on {date}. This file needs no network."),
        data(charts, id_="charts"),
        script(_bundled(scripts)),
    )
    return f"<!DOCTYPE html>\n{element('html', head, body, lang='en')}\n"


@cache
def asset(path: str, package: str = __package__) -> str:
    """A text of a package: script, style, licence."""
    return resources.files(package).joinpath("assets", *path.split("/")).read_text(encoding="utf-8")


def _bundled(scripts: Iterable[str]) -> str:
    """UPlot with its licence, then the scripts of a page: modules without imports and exports, which share one scope."""
    modules = _MODULE_WORDS.sub("", "\n".join(scripts))
    notice = asset("uplot/LICENSE").strip()
    return f'/* uPlot:\n{notice}\n*/\n{asset("uplot/uPlot.iife.min.js")}\n(() => {{\n"use strict";\n{modules}\n}})();'


def section(id_: str, title: str, *children: str | Iterable[str]) -> Section:
    """A section of a page."""
    return id_, title, element("section", element("h2", title), *children, id=id_)


def _head(content: Content) -> Markup:
    word, mark = VERDICTS.get(content.verdict, ("", ""))
    chip = [element("span", word, class_=f"chip {mark}")] if word else []
    has_unit = content.title != content.file_name
    theme = element("button", "Dark", type="button", id="theme", class_="quiet", hidden=True)
    return element(
        "header",
        element("p", "Sensor noise report", [" of ", name(content.file_name)] if has_unit else [], class_="kind"),
        element("h1", name(content.title)),
        element("p", element("span", content.headline), chip, class_="headline"),
        _recorded(content),
        _notes(content),
        theme,
    )


def _recorded(content: Content) -> Markup:
    """When the record was made and when it was analysed, which are two dates."""
    recorded = f"Recorded {content.recorded[:16]}, by the clock of the log. " if content.recorded else ""
    return element("p", f"{recorded}Analysed {content.date}.", class_="dates")


def _notes(content: Content) -> Markup:
    if not content.notes:
        return Markup("")
    rows = (element("div", element("dt", name(key)), element("dd", name(text))) for key, text in content.notes)
    return element("dl", rows, class_="given")


def _summary(content: Content) -> Markup:
    return joined(_overview(content), _findings(content.findings))


def _overview(content: Content) -> Markup:
    if content.overview is None:
        if any(table.rows for table in content.coefficients):
            return element(
                "p", "The coefficients were not fitted but read off the curves; see Coefficients.", class_="none"
            )
        why = WITHOUT_COEFFICIENTS.get(content.verdict, "nothing was fitted")
        return element("p", f"No coefficients: {why}.", class_="none")
    cells = [element("th", text, scope="col") for text in ("Axis", *content.overview.labels, "Trust")]
    groups: list[Markup] = []
    for sensor in content.overview.sensors:
        units = (element("th", raised(text), scope="col") for text in sensor.units)
        length = element("th", length_text(sensor), scope="col")
        groups.append(element("tr", length, units, element("th", ""), class_="units"))
        for axis in sensor.axes:
            values = (element("td", _interval_below(value), class_="value") for value in axis.coefficients)
            trust = element("td", element("span", axis.trust, class_=f"chip {axis.trust}", title=TRUST[axis.trust]))
            groups.append(element("tr", element("th", name(axis.channel), scope="row"), values, trust))
    legend = f"Trust: {'; '.join(f'{word} – {text}' for word, text in explain_trust(content.overview).items())}."
    table = element("table", element("thead", element("tr", cells)), element("tbody", groups), class_="overview")
    about = (
        f"Values with their {content.level} confidence intervals; below: upper limit of a term that is not observed."
    )
    return joined(scrolled(table), element("p", f"{about} {legend}" if content.level else legend, class_="legend"))


def _interval_below(coefficient: MainCoefficient) -> Markup:
    interval = element("span", coefficient.interval, class_="interval") if coefficient.interval else []
    return joined(coefficient.value, " " if coefficient.interval else [], interval)


def scrolled(table: Markup) -> Markup:
    """A table in a region that scrolls separately from the page."""
    return element("div", table, class_="scrolled", tabindex="0", role="region", aria_label="Table")


def _findings(findings: Sequence[FindingText]) -> Markup:
    if not findings:
        return element("p", "Nothing was found wrong with the record.", class_="none")
    grave = [finding for finding in findings if finding.severity != "info"]
    notes = [finding for finding in findings if finding.severity == "info"]
    lists = [element("ul", map(_finding, grave), class_="findings")] if grave else []
    if not grave:
        lists.append(element("p", "No warnings.", class_="none"))
    if notes:
        title = element("summary", f"{len(notes)} note{'s' if len(notes) > 1 else ''} on the record")
        is_short = len(notes) <= 3
        lists.append(element("details", title, element("ul", map(_finding, notes), class_="findings"), open=is_short))
    return joined(element("h3", "Findings"), lists)


def _finding(finding: FindingText) -> Markup:
    axes = [element("strong", name(finding.axes)), " "] if finding.axes else []
    action = [" ", element("em", f"{finding.action}.")] if finding.action else []
    where = [element("span", f"At {finding.where}.", class_="where")] if finding.where else []
    mark = element("span", SEVERITIES[finding.severity], class_=f"chip {finding.severity}")
    return element("li", mark, element("span", axes, raised(f"{finding.message}."), action, where))


_CHARTS = (
    (
        "deviation",
        "Allan deviation",
        "Measured curves with their intervals{model}.",
    ),
    (
        "density",
        "Power spectral density",
        "Two-sided.{model}",
    ),
    (
        "residuals",
        "Residuals",
        "Measured Allan deviation over that of the model, with its interval. A good model stays near 1.{model}",
    ),
    (
        "series",
        "Time series",
        "Every stretch of the whole record from its smallest to its largest sample. Shaded: not analysed, because it is"
        " missing or was left out.",
    ),
    (
        "map",
        "Stability",
        "Dynamic Allan deviation: the deviation in a sliding window over its median of all windows. Coloured: differs by"
        " more than chance explains; a stable record has no colour.",
    ),
)


_MODEL_WORDS = {
    "deviation": ", and the fitted model, dashed where it was fitted and dotted elsewhere",
    "density": " Dashed: the fitted model, behind its filter. Triangles: fitted lines.",
}
_NO_RECORD = "Not drawn: the report was made without the samples of the record."
_MUCH_MISSING = 0.05  # share of missing samples at which the curve visibly lies above the model: by a fortieth
_ABSENT = {
    "density": "Not drawn: no stretch of the record without missing samples is long enough.",
    "map": "Not drawn: the record is too short, or misses too many samples.",
}


def _charts(content: Content) -> list[Section]:
    shown = []
    channels = content.charts["channels"].values()
    with_record = any("series" in channel for channel in channels)
    for id_, title, about in _CHARTS:
        key = "deviation" if id_ == "residuals" else id_
        if any(key in channel and (id_ != "residuals" or "model" in channel[key]) for channel in channels):
            model = _MODEL_WORDS.get(id_, "") if any("model" in channel.get(key, {}) for channel in channels) else ""
            model = _missing_words(content) if id_ == "residuals" else model
            place = element("div", class_="charts", data_chart=id_)
            shown.append(section(id_, title, element("p", about.format(model=model), class_="about"), place))
        elif id_ != "residuals":
            why = _ABSENT[id_] if with_record else _NO_RECORD
            shown.append(section(id_, title, element("p", why, class_="none")))
    return shown


def _missing_words(content: Content) -> str:
    """Why a measured curve lies above a correct model: a cluster with missing samples averages fewer samples."""
    share = max(
        channel["deviation"]["missing"] for channel in content.charts["channels"].values() if "deviation" in channel
    )
    if share < _MUCH_MISSING:
        return ""
    return (
        f" With {two_digits(100 * share)} % of the samples missing, white noise lies up to"
        f" {(1 - share) ** -0.5:.2f} times above the model, and the fit accounts for that."
    )


def _coefficients(content: Content) -> Markup:
    tables = (_channel_table(table) for table in content.coefficients)
    return joined(element("div", tables, class_="channels"), element("p", prose(content.legend), class_="legend"))


def _channel_table(table: Coefficients) -> Markup:
    rows = (
        element(
            "tr",
            element("th", term, scope="row"),
            element("td", value, class_="value"),
            element("td", raised(symbol), class_="value"),
            element("td", interval, class_="interval"),
        )
        for term, value, interval, symbol in table.rows
    )
    chip = [element("span", table.trust, class_=f"chip {table.trust}")] if table.trust else []
    notes = (
        [element("ul", (element("li", raised(note)) for note in table.notes), class_="notes")] if table.notes else []
    )
    return element(
        "article",
        element("h3", name(table.channel), " ", chip),
        element("p", table.verdict, class_="verdict"),
        [scrolled(element("table", element("tbody", rows)))] if table.rows else [],
        notes,
    )


def _files(content: Content) -> Markup:
    if not content.files:
        return element("p", content.no_files, class_="none")
    about = "Where a target has one value for three axes, it is that of the worst. sigmatau export has more choices."
    files = (
        element(
            "details",
            element("summary", file.target),
            element("button", "Copy", type="button", class_="copy quiet", hidden=True),
            element("pre", file.text, tabindex="0"),
            open=k == 0,
        )
        for k, file in enumerate(content.files)
    )
    return joined(element("p", about, class_="about"), element("div", files, class_="files"))


def done(rows: Iterable[tuple[str, str]]) -> Markup:
    """A list of what was done in the analysis, from names and texts."""
    return element("dl", (element("div", element("dt", key), element("dd", name(text))) for key, text in rows))
