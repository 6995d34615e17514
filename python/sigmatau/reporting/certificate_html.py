"""The certificate as the first section of an HTML report; printed, it is page 1."""

from __future__ import annotations

from sigmatau.reporting.certificate import Certificate
from sigmatau.reporting.markup import Markup, element, name, raised

_HEAD = ("Axis", "Value", "Measured", "Maximum", "Outcome", "Consumer's risk", "Producer's risk")
MARKS = {"conforms": "good", "does not conform": "poor", "not decided": "partial"}
"""Colour of each outcome, by the trust that has it."""


def certificate_section(certificate: Certificate) -> Markup:
    """The section, with its heading."""
    laboratory, *address = certificate.laboratory
    logo = [] if certificate.logo is None else [element("img", src=certificate.logo.url, alt="Logo", class_="logo")]
    head = element(
        "div",
        element(
            "div",
            element("h2", certificate.title),
            element("p", "No. ", name(certificate.number), class_="number"),
        ),
        element("address", element("strong", name(laboratory)), (element("span", name(line)) for line in address)),
        logo,
        class_="letterhead",
    )
    groups = (
        element(
            "div",
            element("h3", title),
            element("dl", (element("div", element("dt", key), element("dd", name(text))) for key, text in rows)),
        )
        for title, rows in certificate.facts
    )
    statements = (
        element("p", element("strong", f"{heading}. "), name(text), class_="statement")
        for heading, text in certificate.statements
    )
    fields = (
        element("div", element("span", role), element("strong", name(person)), element("span", "Signature, date"))
        for role, person in certificate.signatures
    )
    return element(
        "section",
        head,
        element("div", groups, class_="facts"),
        _limits(certificate),
        statements,
        element("div", fields, class_="signatures"),
        id="certificate",
    )


def _limits(certificate: Certificate) -> Markup:
    if not certificate.limits:
        return Markup("")
    rows = (
        element(
            "tr",
            element("th", name(row.axis), scope="row"),
            element("td", row.what),
            element("td", raised(row.measured), class_="value"),
            element("td", raised(row.maximum), class_="value"),
            element("td", element("span", row.outcome, class_=f"chip {MARKS[row.outcome]}")),
            element("td", row.consumer, class_="value"),
            element("td", row.producer, class_="value"),
        )
        for row in certificate.limits
    )
    head = element("tr", (element("th", text, scope="col") for text in _HEAD))
    table = element("table", element("thead", head), element("tbody", rows), class_="limits")
    return element("div", table, class_="scrolled", tabindex="0", role="region", aria_label="Judged limits")
