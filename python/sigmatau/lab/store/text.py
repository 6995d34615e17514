"""Trends and results of a store as text for a terminal."""

from __future__ import annotations

import math
from collections.abc import Mapping
from datetime import datetime
from typing import TYPE_CHECKING, Any

from sigmatau.analysis import FailedAnalysis
from sigmatau.digits import limit_text, round_to_error, two_digits
from sigmatau.lab.lots.comparison_text import usual_unit
from sigmatau.lab.lots.lot_words import change_text
from sigmatau.lab.lots.runs import SIGNED
from sigmatau.results import aligned, duration_text, lines_text

if TYPE_CHECKING:
    from sigmatau import Analysis, NoiseFit
    from sigmatau.lab.lots.order_effect import OrderEffect
    from sigmatau.lab.store.trend import ChannelTrend, Drift, InPeriod, Trend


def cell(value: object) -> str:
    """Text of a value in a table."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, datetime):
        return f"{value:%Y-%m-%d %H:%M}"
    return "" if value is None else str(value)


def trend_text(trend: Trend) -> str:
    """The trend of each channel: a table of periods, then the slopes."""
    lines: list[str] = []
    for channel in trend.channels.values():
        lines += [*_channel(trend, channel), ""]
    if trend.undated:
        lines.append(f"{trend.undated} values without a time are not used")
    return lines_text(lines[:-1] if not lines[-1] else lines)


def _channel(trend: Trend, channel: ChannelTrend) -> list[str]:
    heads, rows, drifts = channel_texts(trend, channel)
    return [f"{channel.channel} {trend.term.replace('_', ' ')}", *aligned([heads, *rows]), *drifts]


def channel_texts(trend: Trend, channel: ChannelTrend) -> tuple[tuple[str, ...], list[tuple[str, ...]], list[str]]:
    """Headings and rows of the table of periods of a channel, and the lines about its drifts."""
    unit, size = usual_unit(
        trend.term, channel.quantity, channel.rate_unit, [period.middle for period in channel.periods]
    )
    signed = trend.term in SIGNED
    level = f"{100 * trend.level:g} %"
    spread = f"spread [{unit}]" if signed else "spread"
    heads = (trend.by, "units", "runs", "limits", f"median [{unit}]", level, spread, level)
    batch = channel.order if channel.order is not None and channel.order.kind != "drift" else None
    drifts = [
        _drift(drift, unit, size, signed=signed, by_batch=batch is not None and drift.kind == "production")
        for drift in channel.drifts
    ]
    if batch is not None:
        drifts.append(_batch_line(batch))
    return heads, [_row(period, size, signed=signed) for period in channel.periods], drifts


def _row(period: InPeriod, size: float, *, signed: bool) -> tuple[str, ...]:
    factor, percent = (1 / size, "") if signed else (100.0, " %")
    counts = (period.name, str(period.units), str(period.runs), str(period.limits))
    if period.middle is None:
        return (*counts, "", "", "", "")
    middle = f"{period.middle / size:.4g}"
    if period.low is None or period.high is None:
        return (*counts, middle, "one unit", "", "")
    middle, interval = round_to_error(period.middle / size, period.low / size, period.high / size).cells
    if period.spread is None or period.spread_low is None or period.spread_high is None:
        return (*counts, middle, interval, "", "")
    spread = round_to_error(*(number * factor for number in (period.spread, period.spread_low, period.spread_high)))
    return (*counts, middle, interval, spread.value + percent, spread.interval + percent)


_WITHOUT_FIT = {
    "not_at_rest": "not at rest: no coefficients",
    "too_short_to_tell": "too short to tell rest from motion: no coefficients",
}
_MONTH = 365.2425 / 12  # shortest observed time for which a drift is stated per month [days]
_DAYS = 2.0  # shortest observed time that is printed in days [days]
_DRIFT_WORDS = {"production": "between units", "ageing": "within units"}


def _drift(drift: Drift, unit: str, size: float, *, signed: bool, by_batch: bool) -> str:
    factor, unit_text = (1 / size, f" {unit}") if signed else (100.0, " %")
    conclusion = "see the batch" if by_batch else "drifts" if drift.drifts else "no drift seen"
    count = f"{drift.units} unit{'s' if drift.units > 1 else ''}"
    if drift.kind == "ageing":
        count += f", {drift.runs} runs"
    short = f"{drift.span:.2g} days" if drift.span >= _DAYS else duration_text(86400 * drift.span)
    time = "per month" if drift.span >= _MONTH else f"over {short}"
    ends = (drift.change, drift.low, drift.high)
    if drift.span >= _MONTH:
        ends = tuple(_per_month(end, drift.span, signed=signed) for end in ends)  # type: ignore[assignment]
    number = round_to_error(*(value * factor for value in ends), sign="+")
    slope = f"{_DRIFT_WORDS[drift.kind]}: {number.value}{unit_text} {time} {number.interval}"
    return f"{slope}, p = {two_digits(drift.p_value)}: {conclusion} ({count})"


def _per_month(change: float, span: float, *, signed: bool) -> float:
    """Convert a change over a span in days to one over a month."""
    share = _MONTH / span
    return change * share if signed else math.expm1(share * math.log1p(change))


def _batch_line(effect: OrderEffect) -> str:
    """The line of a batch or a rise; that of a drift is made by `_drift`."""
    return f"batch {effect.first} to {effect.last} ({effect.units} units): {change_text(effect)}"


def result_text(row: Mapping[str, Any], result: Analysis | FailedAnalysis) -> str:
    """Describe a run in one line, and its coefficients with intervals, one row per channel and term."""
    head = [
        f"{row['unit']}: {row['run']}",
        row["model"] or "",
        "" if row["recorded"] is None else f"{cell(row['recorded'])} UTC",
    ]
    head += [f"{row['temperature']:g} °C"] if row["temperature"] is not None else []
    head += [f"{row['supply']:g} V"] if row["supply"] is not None else []
    head += [f"{row['duration']:g} s"] if row["duration"] is not None else []
    lines = [", ".join(part for part in head if part)]
    if isinstance(result, FailedAnalysis):
        return lines_text([*lines, f"failed: {result.message}"])
    levels = {f"{100 * fitted.level:g} % interval" for fitted in result.fits.values()}
    rows = [("channel", "term", "value", *(levels if len(levels) == 1 else ["interval"]), "unit", "verdict", "trust")]
    for name, fitted in result.fits.items():
        rows += [(name, term, *_number(term, fitted), fitted.verdict, fitted.trust or "") for term in fitted.terms]
    return lines_text([*lines, *(aligned(rows) if len(rows) > 1 else [_WITHOUT_FIT.get(row["state"], "no fit")])])


def _number(name: str, fitted: NoiseFit) -> tuple[str, str, str]:
    """Value, interval and unit of a term."""
    term = fitted.terms[name]
    unit, size = usual_unit(name, fitted.quantity, fitted.rate_unit, (term.value, term.upper_limit))
    if term.value is None:
        return ("" if term.upper_limit is None else limit_text(term.upper_limit / size)), "", unit
    if term.low is None or term.high is None:
        return f"{term.value / size:.4g}", "no interval", unit
    return (*round_to_error(term.value / size, term.low / size, term.high / size).cells, unit)
