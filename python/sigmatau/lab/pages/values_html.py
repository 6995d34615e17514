"""Pages of values with their intervals at ordered places: runs of a comparison, or periods of a trend."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from typing import Any

from sigmatau import __version__
from sigmatau.frozen import frozen
from sigmatau.lab.pages.lot_content import moment_text
from sigmatau.lab.pages.lot_html import SCRIPTS
from sigmatau.reporting.html import asset, done, frame, scrolled, section
from sigmatau.reporting.markup import Markup, element, joined, name, raised
from sigmatau.results import printable


@frozen
class PanelSeries:
    """Values of a channel: places from 0, values, and ends of their intervals, which may be unknown."""

    name: str
    places: tuple[int, ...]
    values: tuple[float, ...]
    low: tuple[float | None, ...]
    high: tuple[float | None, ...]


@frozen
class Panel:
    """A chart: the series of the channels of a sensor, and the names of the places."""

    title: str
    unit: str
    order: str  # label of the axis of places, such as "run"
    places: tuple[str, ...]
    series: tuple[PanelSeries, ...]

    def chart(self) -> dict[str, Any]:
        """Plain values for the script of the page; numbers have six digits."""
        return {
            "title": self.title,
            "unit": self.unit,
            "order": self.order,
            "places": [printable(place) for place in self.places],
            "series": [
                {
                    "name": printable(series.name),
                    "at": series.places,
                    "values": [_short(value) for value in series.values],
                    "low": [_short(end) for end in series.low],
                    "high": [_short(end) for end in series.high],
                }
                for series in self.series
            ],
        }


@frozen
class TextTable:
    """A table of texts below a heading, and remarks below the table."""

    title: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    remarks: tuple[str, ...] = ()


def page(
    *,
    kind: str,
    title: str,
    summary: Sequence[str],
    about: str,
    panels: Sequence[Panel],
    tables: Sequence[TextTable],
    settings: Sequence[tuple[str, str]],
    command: str | None,
    date: datetime,
) -> str:
    """The page as HTML that opens offline."""
    moment = moment_text(date)
    header = element(
        "header",
        element("p", kind, class_="kind"),
        element("h1", name(printable(title))),
        element("p", element("span", moment), class_="headline"),
        element("button", "Dark", type="button", id="theme", class_="quiet", hidden=True),
    )
    charts = [element("p", "There are no values to draw.", class_="none")]
    if panels:
        charts = [element("p", about, class_="about"), element("div", class_="charts", data_values="")]
    rows = [
        *settings,
        ("Command", command or ""),
        ("Date of this page", moment),
        ("Version", f"sigmatau {__version__}"),
    ]
    return frame(
        title=f"{printable(title)} – {kind.lower()}",
        made_by=f"sigmatau {__version__}",
        date=moment,
        header=header,
        sections=[
            section(
                "summary", "Summary", (element("p", raised(f"{printable(line).rstrip('.')}.")) for line in summary)
            ),
            section(
                "values",
                "Values",
                *charts,
            ),
            section("tables", "Tables", [_table(table) for table in tables]),
            section("done", "What was done", done([(key, printable(text)) for key, text in rows if text])),
        ],
        charts={"panels": [panel.chart() for panel in panels]},
        styles=asset("report.css") + asset("lot.css", __package__),
        scripts=[
            *(asset(f"{module}.js") for module in SCRIPTS),
            *(asset(file, __package__) for file in ("figures.js", "values.js")),
        ],
    )


def _table(table: TextTable) -> Markup:
    heads = (element("th", raised(text), scope="col") for text in table.heads)
    rows = (
        element(
            "tr",
            element("th", name(printable(row[0])), scope="row"),
            (element("td", raised(printable(cell))) for cell in row[1:]),
        )
        for row in table.rows
    )
    body = element("table", element("thead", element("tr", heads)), element("tbody", rows), class_="distributions")
    remarks = (element("p", raised(f"{printable(line)}.")) for line in table.remarks)
    return joined(element("h3", name(printable(table.title))), scrolled(body), remarks)


def _short(value: float | None) -> float | None:
    return None if value is None else float(f"{value:.6g}")
