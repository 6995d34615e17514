"""The page of a trend: the median of a coefficient in each period, with its interval, and its drift."""

from __future__ import annotations

from datetime import datetime

from sigmatau.lab.lots.comparison_text import usual_unit
from sigmatau.lab.pages.values_html import Panel, PanelSeries, TextTable, page
from sigmatau.lab.store.text import channel_texts
from sigmatau.lab.store.trend import ChannelTrend, Trend
from sigmatau.record import stream_name


def trend_page(trend: Trend, *, store: str, command: str | None, date: datetime) -> str:
    """The trend as HTML. `store`: file or URL of the store, without a password."""
    level = f"{100 * trend.level:g} %"
    term = trend.term.replace("_", " ")
    texts = {name: channel_texts(trend, channel) for name, channel in trend.channels.items()}
    summary = [f"{name}, {line}" for name, (_, _, drifts) in texts.items() for line in drifts]
    if trend.undated:
        summary.append(f"{trend.undated} values without a time are not used")
    return page(
        kind="Trend",
        title=f"{term.capitalize()} by {trend.by}",
        summary=summary or ["Too few units and times for a drift"],
        about=f"Points: median over the units, with its {level} interval. Select a name to hide or show its values.",
        panels=_panels(trend, term),
        tables=[TextTable(title=name, heads=heads, rows=tuple(rows)) for name, (heads, rows, _) in texts.items()],
        settings=[
            ("Store", store),
            ("Confidence level", f"{level} for each interval, and for all tests of drift together"),
            ("Median", "for fewer than six units their geometric mean, or the mean of a value with a sign"),
        ],
        command=command,
        date=date,
    )


def _panels(trend: Trend, term: str) -> list[Panel]:
    """A chart for each sensor and temperature; the places are the periods in order of time."""
    places = tuple(sorted({period.name for channel in trend.channels.values() for period in channel.periods}))
    charts: dict[tuple[str, str, str], list[ChannelTrend]] = {}
    for channel in trend.channels.values():
        axis, _, conditions = channel.channel.partition(" ")
        charts.setdefault((stream_name(axis), conditions, channel.rate_unit), []).append(channel)
    panels = []
    for (sensor, conditions, _), channels in sorted(charts.items(), key=lambda chart: chart[0][0] != "gyro"):
        middles = [period.middle for channel in channels for period in channel.periods]
        unit, size = usual_unit(trend.term, channels[0].quantity, channels[0].rate_unit, middles)
        series = []
        for channel in channels:
            shown = [period for period in channel.periods if period.middle is not None]
            scaled = [
                [None if end is None else end / size for end in (period.middle, period.low, period.high)]
                for period in shown
            ]
            series.append(
                PanelSeries(
                    name=channel.channel.partition(" ")[0],
                    places=tuple(places.index(period.name) for period in shown),
                    values=tuple(row[0] for row in scaled if row[0] is not None),
                    low=tuple(row[1] for row in scaled),
                    high=tuple(row[2] for row in scaled),
                )
            )
        title = " ".join(filter(None, [sensor, term, conditions]))
        panels.append(Panel(title=title, unit=unit, order=trend.by, places=places, series=tuple(series)))
    return panels
