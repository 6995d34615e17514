"""The report as a PDF to print and sign, typeset by typst.

All texts are passed to typst as data, in JSON, so that text from a file is never interpreted as markup.
"""

from __future__ import annotations

import importlib.util
import json
import re
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from functools import cache
from importlib import resources
from itertools import groupby
from typing import Any

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.frozen import frozen
from sigmatau.plot import printed
from sigmatau.plot.curves import COLOURS
from sigmatau.plot.stability import colour_limit
from sigmatau.plot.svg import power
from sigmatau.reporting.certificate import Certificate
from sigmatau.reporting.certificate_html import MARKS
from sigmatau.reporting.charts import unpacked
from sigmatau.reporting.content import Coefficients, Content, FindingText
from sigmatau.reporting.words import SEVERITIES, VERDICTS, WITHOUT_COEFFICIENTS, explain_trust, length_text
from sigmatau.results import printable
from sigmatau.units import density_text

_TEXT_WIDTH = 174.0  # of a page [mm]
_GUTTER = 6.0  # between two columns of figures [mm]
_HEIGHTS = {"deviation": 58.0, "density": 52.0, "residuals": 44.0}  # [mm]
_ONE_COLUMN = 1.25  # height of a figure as wide as the page, over that of one
_PANEL = 6  # number of channels in a panel, each with a colour
_BINS_PER_MM = 6  # intervals of a time series per millimetre
_MAX_NAME, _MAX_TITLE, _MAX_MESSAGE, _MAX_FACT = 40, 160, 600, 1200  # longest texts [characters]
_NOTES_AT_ONCE = 4  # largest number of notes on the page that is signed; more notes have a separate section
_LARGEST = 1000.0  # largest number at the axis of a time series
# characters outside Libertinus Serif and DejaVu Sans Mono
_BEYOND_FONTS = re.compile("[\u0700-\u1dff\u2c00-\U0010ffff]")
_MARKS = {"o": "●", "s": "■", "^": "▲", "D": "◆", "v": "▼", "+": "✚"}
_MAX_LISTED = 12  # largest number of names in a sentence
_WITH_RESULTS = 2  # largest number of panels of Allan deviations on the page that is signed


def need_typst() -> None:
    """Raise ImportError with the command to install typst if it is missing."""
    if importlib.util.find_spec("typst") is None:
        raise ImportError("a PDF report needs typst: pip install 'sigmatau[pdf]'")


def document(content: Content) -> bytes:
    """The report as a PDF. The same content gives the same bytes."""
    return bytes(typeset(_template(), _values(content), format="pdf", timestamp=_moment(content.date)))


def typeset(template: bytes, values: Mapping[str, Any], **options: Any) -> Any:  # noqa: ANN401  bytes, or those of each page
    """Fill a template with values; the same values and time stamp give the same bytes."""
    need_typst()
    import typst

    data = json.dumps(values, allow_nan=False, ensure_ascii=False)
    # The fonts in typst have no other scripts; those of the system are then searched, which takes time if they are many.
    beyond = _BEYOND_FONTS.search(data) is not None
    return typst.Compiler(template, ignore_system_fonts=not beyond, sys_inputs={"data": data}).compile(**options)


@cache
def _template() -> bytes:
    return resources.files(__package__).joinpath("assets", "report.typ").read_bytes()


def _moment(date: str) -> datetime:
    return datetime.strptime(date[:16], "%Y-%m-%d %H:%M").replace(tzinfo=UTC)


def _values(content: Content) -> dict[str, Any]:
    """Plain values for the template."""
    return {
        "title": _cut(content.title, _MAX_TITLE),
        "foot": _cut(content.title if content.certificate is None else content.certificate.number, _MAX_NAME),
        "level": content.level,
        "recorded": content.recorded[:16],
        "certificate": None if content.certificate is None else _certificate(content.certificate),
        "file": _cut(content.file_name, _MAX_TITLE) if content.file_name != content.title else "",
        "headline": _cut(content.headline, _MAX_MESSAGE),
        "verdict": VERDICTS.get(content.verdict, ("", "")),
        "date": content.date,
        "made_by": content.made_by,
        "given": [[_cut(key, _MAX_NAME), _cut(text, _MAX_TITLE)] for key, text in content.notes],
        "checksum": dict(content.done).get("SHA-256", ""),
        "overview": _overview(content),
        "no_overview": "" if content.overview else _no_coefficients(content),
        "grave": [_finding_values(item) for item in content.findings if item.severity != "info"],
        "notes": [_finding_values(item) for item in content.findings if item.severity == "info"],
        "notes_at_once": _NOTES_AT_ONCE,
        "figures": _figures(content.charts),
        "coefficients": [_table(item) for item in content.coefficients if item.rows or item.notes],
        "legend": content.legend.replace("\n  ", " ").replace("`", "").split("\n"),
        "done": [(_cut(printable(name), 2 * _MAX_NAME), _cut(text, _MAX_FACT)) for name, text in content.done],
        "files": [{"name": f"{item.target}.txt", "text": item.text} for item in content.files],
        "no_files": content.no_files,
    }


def _certificate(certificate: Certificate) -> dict[str, Any]:
    """Page 1 as plain values; the logo as its bytes."""
    logo = certificate.logo
    return {
        "title": certificate.title,
        "number": _cut(certificate.number, _MAX_NAME),
        "laboratory": list(certificate.laboratory),
        "logo": None if logo is None else {"kind": logo.kind, "bytes": list(logo.content)},
        "facts": [
            [title, [[label, _cut(text, _MAX_FACT)] for label, text in rows]] for title, rows in certificate.facts
        ],
        "statements": [list(statement) for statement in certificate.statements],
        "limits": [
            {
                "axis": _name(row.axis),
                "what": row.what,
                "measured": _numbers(row.measured),
                "maximum": _numbers(row.maximum),
                "outcome": row.outcome,
                "kind": MARKS[row.outcome],
                "consumer": row.consumer,
                "producer": row.producer,
            }
            for row in certificate.limits
        ],
        "signatures": [list(signature) for signature in certificate.signatures],
    }


def _cut(text: str, length: int) -> str:
    """Shorten a text to a number of characters, with … in place of its middle."""
    if len(text) <= length:
        return text
    return f"{text[: length - length // 3 - 1]}…{text[-(length // 3) :]}"


def _name(text: str) -> str:
    return _cut(printable(text), _MAX_NAME)


def _numbers(text: str) -> str:
    """A text whose numbers have minus signs and powers of ten.

    Examples
    --------
    >>> _numbers("-1.3e-05 to 2, 2026-11-23")
    '−1.3·10⁻⁵ to 2, 2026-11-23'
    """
    text = re.sub(r"(?<![\w.-])-(?=\d)", "−", text).replace(" = ", "\u00a0=\u00a0")
    return re.sub(r"(?<![\w.])([\d.]+)e([+-]\d+)\b", lambda match: f"{match[1]}·{power(int(match[2]))}", text)


def _overview(content: Content) -> dict[str, Any]:
    if content.overview is None:
        return {}
    return {
        "head": list(content.overview.labels),
        "sensors": [
            {
                "length": length_text(sensor),
                "units": list(sensor.units),
                "axes": [
                    {
                        "name": _name(axis.channel),
                        "cells": [[_numbers(each.value), _numbers(each.interval)] for each in axis.coefficients],
                        "trust": axis.trust,
                    }
                    for axis in sensor.axes
                ],
            }
            for sensor in content.overview.sensors
        ],
        "trust": [list(item) for item in explain_trust(content.overview).items()],
    }


def _no_coefficients(content: Content) -> str:
    if content.verdict in WITHOUT_COEFFICIENTS:
        return f"No coefficients: {WITHOUT_COEFFICIENTS[content.verdict]}."
    read = any(table.rows for table in content.coefficients)
    return "No coefficients were fitted; those read off the curves are below." if read else "No coefficients."


def _finding_values(finding: FindingText) -> dict[str, str]:
    return {
        "kind": finding.severity,
        "word": SEVERITIES[finding.severity],
        "axes": _cut(finding.axes, 2 * _MAX_NAME),
        "message": _numbers(_cut(finding.message, _MAX_MESSAGE)) + ".",
        "action": _cut(finding.action, _MAX_MESSAGE) + "." if finding.action else "",
        "where": f"At {_cut(finding.where, _MAX_MESSAGE)}." if finding.where else "",
    }


def _table(table: Coefficients) -> dict[str, Any]:
    return {
        "name": _name(table.channel),
        "verdict": _numbers(table.verdict),
        "trust": table.trust,
        "rows": [[_numbers(text) for text in row] for row in table.rows],
        "notes": [_numbers(_cut(note, _MAX_MESSAGE)) for note in table.notes],
    }


@frozen
class _Panel:
    """Channels that share a figure."""

    title: str
    units: tuple[tuple[str, float], ...]
    names: tuple[str, ...]


def _panels(sensors: Sequence[Mapping[str, Any]]) -> list[_Panel]:
    """Up to six channels of a sensor each, or of consecutive sensors of one channel in the same unit."""

    def kind(numbered: tuple[int, Mapping[str, Any]]) -> tuple[int, list[str]]:
        k, sensor = numbered
        return k if len(sensor["channels"]) > 1 else -1, [unit["text"] for unit in sensor["units"]]

    panels = []
    for _, numbered in groupby(enumerate(sensors), kind):
        group = [sensor for _, sensor in numbered]
        units = tuple((unit["text"], unit["factor"]) for unit in group[0]["units"])
        names = [name for sensor in group for name in sensor["channels"]]
        for k in range(0, len(names), _PANEL):
            shared = names[k : k + _PANEL]
            title = group[0]["title"] if len(group) == 1 else " … ".join(dict.fromkeys((shared[0], shared[-1])))
            panels.append(_Panel(title=_cut(printable(title), 2 * _MAX_NAME), units=units, names=tuple(shared)))
    return panels


def _figures(charts: Mapping[str, Any]) -> dict[str, Any]:
    """Sections of figures by kind: panels with their picture, unit and legend."""
    channels = {
        name: {kind: _columns(values) for kind, values in charts_by_kind.items()}
        for name, charts_by_kind in charts["channels"].items()
    }
    panels = _panels(charts["sensors"])
    wide = len(panels) == 1
    width = _TEXT_WIDTH if wide else (_TEXT_WIDTH - _GUTTER) / 2
    figures: dict[str, Any] = {"width": width, "left": printed.LEFT_MARGIN, "pitch": printed.PITCH}
    for kind in ("deviation", "density", "residuals"):
        figures[kind] = []
        for panel in panels:
            chart = "deviation" if kind == "residuals" else kind
            curves = {name: channels[name][chart] for name in panel.names if chart in channels[name]}
            if kind == "residuals":
                curves = {name: charts_by_kind for name, charts_by_kind in curves.items() if "model" in charts_by_kind}
            if curves:
                figures[kind].append(_curves(kind, panel, curves, width, _HEIGHTS[kind] * (_ONE_COLUMN if wide else 1)))
    figures["series"] = [
        charts_by_kind for charts_by_kind in (_series(panel, channels, width) for panel in panels) if charts_by_kind
    ]
    figures |= _maps(panels, channels, width)
    figures["fitted"] = bool(figures["residuals"])
    figures["bands"] = all(len(panel.names) <= printed.MAX_BANDS for panel in panels)
    figures["first"] = len(panels) <= _WITH_RESULTS
    figures["interval"] = next(
        (
            charts_by_kind["deviation"]["interval"]
            for charts_by_kind in channels.values()
            if "deviation" in charts_by_kind
        ),
        "",
    )
    return figures


def _columns(values: Mapping[str, Any]) -> dict[str, Any]:
    """A chart with arrays in place of lists and packed numbers; None is NaN."""
    columns: dict[str, Any] = {}
    for key, value in values.items():
        if key == "parts":
            columns["parts"] = {name: np.array(part, dtype=np.float64) for name, part in value.items()}
        elif isinstance(value, Mapping):
            columns[key] = unpacked(value)
        elif isinstance(value, list) and key != "outside":
            columns[key] = np.array(value, dtype=np.float64)
        else:
            columns[key] = value
    return columns


def _legend(kind: str, names: Sequence[str]) -> list[dict[str, str]]:
    marks = printed.MARKERS if kind != "density" else " " * len(printed.MARKERS)
    return [
        {"name": _name(name), "colour": colour, "mark": _MARKS.get(mark, "")}
        for name, colour, mark in zip(names, COLOURS, marks, strict=False)
    ]


def _curves(
    kind: str, panel: _Panel, curves: Mapping[str, Mapping[str, Any]], width: float, height: float
) -> dict[str, Any]:
    """A panel of curves with a shared pair of axes."""
    text, factor = panel.units[0]
    size = {"width": width, "height": height}
    spans = [(curve.get("from") or 0.0, curve.get("to") or 0.0) for curve in curves.values()]
    if kind == "density":
        highest = [curve.get("highest", np.inf) for curve in curves.values()]
        lines = [curve.get("lines", np.empty(0)) for curve in curves.values()]
        scaled = [_scaled(curve, ("density", "low", "high", "model"), factor**2) for curve in curves.values()]
        svg = printed.densities(scaled, highest, lines, **size)
        unit = density_text(text)
    elif kind == "residuals":
        scaled = [_scaled(curve, ("adev", "low", "high", "model"), 1.0) for curve in curves.values()]
        svg, unit = printed.ratios(scaled, spans, **size), ""
    else:
        scaled = [
            _scaled(curve, ("adev", "low", "high", "model"), factor)
            | {name: part / factor for name, part in curve.get("parts", {}).items() if len(curves) == 1}
            for curve in curves.values()
        ]
        svg, unit = printed.deviations(scaled, spans, **size), text
    return {
        "title": panel.title,
        "unit": unit,
        "svg": svg,
        "height": height,
        "legend": _legend(kind, list(curves)),
    }


def _scaled(curve: Mapping[str, Any], names: Sequence[str], factor: float) -> dict[str, Floats]:
    scaled = {name: curve[name] / factor for name in names if name in curve}
    return scaled | {name: curve[name] for name in ("tau", "frequency") if name in curve}


def _series(panel: _Panel, channels: Mapping[str, Mapping[str, Any]], width: float) -> dict[str, Any] | None:
    channels_shown = {name: channels[name]["series"] for name in panel.names if "series" in channels[name]}
    if not channels_shown:
        return None
    shown = {
        name: _fewer(channel["low"], channel["high"], round(width * _BINS_PER_MM))
        for name, channel in channels_shown.items()
    }
    span = max((_span(low, high) for low, high in shown.values()), default=0.0)
    text, factor = next((unit for unit in panel.units if span / unit[1] < _LARGEST), panel.units[-1])
    drawn, labels = [], []
    for name, (low, high) in shown.items():
        zero, written = _zero(low / factor, high / factor)
        drawn.append((low / factor - zero, high / factor - zero))
        labels.append({"name": _name(name), "more": f"zero at {_numbers(written)} {text}" if zero else ""})
    outside = [channel["outside"] for channel in channels_shown.values()]
    times = [(channel["from"], channel["from"] + channel["duration"]) for channel in channels_shown.values()]
    svg = printed.series(drawn, outside, times, width=width)
    height = printed.strips_height(len(channels_shown))
    return {"title": panel.title, "unit": text, "svg": svg, "height": height, "labels": labels}


def _fewer(low: Floats, high: Floats, bins: int) -> tuple[Floats, Floats]:
    """Reduce an envelope to a largest number of bins. Each, except the last, joins the same number of old bins."""
    size = -(-len(low) // bins)
    starts = np.arange(0, len(low), size)
    return np.fmin.reduceat(low, starts), np.fmax.reduceat(high, starts)


def _span(low: Floats, high: Floats) -> float:
    finite = np.isfinite(low)
    return float(high[finite].max() - low[finite].min()) if finite.any() else 0.0


def _zero(low: Floats, high: Floats) -> tuple[float, str]:
    """A round number near the middle of a signal, 0 if the signal is near 0; and its text."""
    finite = np.isfinite(low)
    if not finite.any():
        return 0.0, ""
    middle = float(np.median((low[finite] + high[finite]) / 2))
    span = _span(low, high) or abs(middle)
    if abs(middle) <= span:
        return 0.0, ""
    digits = max(0, 1 - int(np.floor(np.log10(span))))
    return round(middle, digits), f"{middle:.{digits}f}"


def _maps(panels: Sequence[_Panel], channels: Mapping[str, Mapping[str, Any]], width: float) -> dict[str, Any]:
    """Panels of the maps with coloured windows, which share one scale of colours; and the channels of the others."""
    maps: dict[str, printed.Map] = {}
    for name, channel in channels.items():
        if "map" in channel:
            times, tau = channel["map"]["times"], channel["map"]["tau"]
            adev = 10 ** channel["map"]["log10"].reshape(len(times), len(tau))
            maps[name] = printed.Map(times=times, tau=tau, window=channel["map"]["window"], adev=adev)
    plain = {name for name, channel in maps.items() if not channel.beyond.any() and not channel.missing.any()}
    hidden = [
        name for panel in panels if plain.issuperset(maps.keys() & panel.names) for name in panel.names if name in maps
    ]
    limit = colour_limit(np.concatenate([channel.ratio.ravel() for channel in maps.values()])) if maps else 1.0
    drawn = []
    for panel in panels:
        shown = [name for name in panel.names if name in maps and name not in hidden]
        if shown:
            svg = printed.maps([maps[name] for name in shown], limit, width=width)
            labels = [{"name": _name(name), "more": ""} for name in shown]
            height = printed.strips_height(len(shown))
            drawn.append({"title": panel.title, "unit": "", "svg": svg, "height": height, "labels": labels})
    listed = ", ".join(_name(name) for name in hidden[:_MAX_LISTED])
    hidden_words = f" and {len(hidden) - _MAX_LISTED} more" if len(hidden) > _MAX_LISTED else ""
    return {"map": drawn, "limit": limit, "colours": list(printed.MAP_COLOURS), "plain": listed + hidden_words}
