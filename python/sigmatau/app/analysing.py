"""Calls that analyse a log: the result as JSON, the text and charts of the page, and lines drawn by hand."""

from __future__ import annotations

import json
import math
import pickle
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from sigmatau.analysis import Analysis, AnalysisOptions, analyze_in_stages, as_analysis, read_result
from sigmatau.app.calls import Progress, cached, number, reading_options, record_size
from sigmatau.app.faces import page_words
from sigmatau.app.log import LogFile
from sigmatau.errors import OptionError
from sigmatau.fitting.read_off import ReadOff
from sigmatau.fitting.read_off_at import ReadOffAt
from sigmatau.io.read import read
from sigmatau.noise.shown import set_shown
from sigmatau.noise.terms import TERMS, check_shown
from sigmatau.plot.curves import require_points
from sigmatau.record.record import Record, channel_quantities
from sigmatau.reporting.content import Content, collect_content, finding_text
from sigmatau.typed.config import arguments, check_names, command_line, notes, to_toml

_MOST_LEFT_OUT = 1000  # largest number of stretches of a channel that are listed
_REACH = 1.5  # factor from an averaging time to the ends of a line through it: two or three points in half octaves


def analyse(*, log: LogFile, table: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Analyse a log; return the analysis for later calls, and the parts of the answer as JSON."""
    check_names(table)
    options = AnalysisOptions(**arguments(AnalysisOptions, table), notes=notes(table))
    _set_shown(table)
    progress("read")
    record = _record(log, table)
    check_shown(channel_quantities(record))
    analysis = analyze_in_stages(record, options, begin=progress)
    return result_parts(analysis, name=log.name, table=table)


def _set_shown(table: Mapping[str, Any]) -> None:
    show = table.get("show")
    set_shown(",".join(show) if isinstance(show, list) else show)


def _record(log: LogFile, table: Mapping[str, Any]) -> Record:
    def make() -> Record:
        record = read(log.path, **reading_options(table))
        return replace(record, provenance=replace(record.provenance, path=log.name))

    return cached("record", log, table, make, size=record_size)  # type: ignore[no-any-return]


def result_parts(
    analysis: Analysis, *, name: str, table: Mapping[str, Any] | None, command: str | None = None
) -> dict[str, Any]:
    """The parts of the answer of ``api/results/ID``.

    `table`: options of the analysis; None for a stored result, which a `command` may show.
    """
    content = collect_content(analysis, None, targets=())
    shown = {
        "name": name,
        "summary": _summary(analysis, content),
        "charts": content.charts,
        "left_out": _left_out(analysis),
        "has_samples": table is not None,
        "options": None if table is None else dict(table),
        "command": command if table is None else command_line(name, table),
        "toml": None if table is None else to_toml(table, log=name),
    }
    return {
        "analysis": pickle.dumps(analysis),
        "result": analysis.to_json(),
        "shown": json.dumps(shown, allow_nan=False, default=str),
    }


def _summary(analysis: Analysis, content: Content) -> dict[str, Any]:
    """The text of a report, in which options are named by the controls of the page."""
    findings = tuple(finding_text(finding, page_words(finding)) for finding in analysis.findings)
    return asdict(replace(content, charts={}, findings=findings))


def _left_out(analysis: Analysis) -> list[dict[str, Any]]:
    """Stretches of each channel that were not analysed, and why."""
    return [
        {
            "id": f"{channel}:{start}:{stop}",
            "channel": channel,
            "from_s": number(start_s, 12),
            "to_s": number(stop_s, 12),
            "samples": stop - start,
            "why": reason,
        }
        for channel, mask in analysis.masks.items()
        for start, stop, start_s, stop_s, reason in zip(
            *(column[:_MOST_LEFT_OUT] for column in mask.columns().values()), strict=True
        )
    ]


def charts(*, analysis: bytes, log: LogFile, table: Mapping[str, Any], progress: Progress) -> tuple[bytes, str]:
    """Collect the content of a report, for which the samples are read again, and its charts as JSON."""
    progress("charts")
    _set_shown(table)
    content = collect_content(
        pickle.loads(analysis),
        _record(log, table),
        notes=notes(table),
        command=command_line(log.name, table),
        targets=(),
    )
    return pickle.dumps(content), json.dumps(content.charts, allow_nan=False)


def read_stored(*, log: LogFile, progress: Progress) -> dict[str, Any]:
    """The parts of a result that ``sigmatau analyze --json`` wrote."""
    return result_parts(as_analysis(read_result(Path(log.path))), name=log.name, table=None)


def read_off_at_tau(
    *, analysis: bytes, channel: str, term: str, tau_s: float | None, from_s: float | None, to_s: float | None,
    force: bool, progress: Progress,
) -> str:  # fmt: skip
    """A line drawn by hand through a curve at one averaging time, or between two, as JSON."""
    result: Analysis = pickle.loads(analysis)
    if channel not in result.curves:
        raise OptionError(f"no channel {channel!r}; channels: {', '.join(result.curves)}", option="channel")
    if term not in TERMS:
        raise OptionError(f"no term {term!r}; terms: {', '.join(TERMS)}", option="term")
    curve = result.curves[channel]
    require_points(curve)
    if tau_s is not None:
        if not (math.isfinite(tau_s) and tau_s > 0):
            raise OptionError("{option} must be a positive number of seconds", option="tau_s")
        nearest = float(curve.tau[abs(curve.tau / tau_s - 1).argmin()])
        from_s, to_s = nearest / _REACH, nearest * _REACH
    if from_s is None or to_s is None:
        raise OptionError("give an averaging time, or the shortest and the longest one", option="tau_s")
    lines = ReadOffAt({term: (from_s, to_s)}, force=force).read(curve, result.fits.get(channel))
    return json.dumps(_line(lines, term), allow_nan=False)


def _line(lines: ReadOff, term: str) -> dict[str, Any]:
    label = TERMS[term].label(lines.quantity)
    refusal = next((each for each in lines.refused if each.by_hand and each.term == term), None)
    if refusal is not None:
        return {
            "term": term, "label": label, "refused": refusal.reason, "slope": number(refusal.slope),
            "slope_error": number(refusal.slope_error), "expected_slope": TERMS[term].slope,
            "from_s": refusal.tau_min, "to_s": refusal.tau_max, "value": None,
        }  # fmt: skip
    coefficient = lines[term]
    text, unit = lines.texts(term)[-1]
    return {
        "term": term,
        "label": label,
        "refused": None,
        "value": coefficient.value,
        "error": coefficient.error,
        "low": coefficient.value - coefficient.error,
        "high": coefficient.value + coefficient.error,
        "unit": coefficient.unit,
        "text": f"{text} {unit}",
        "relative_error": number(coefficient.percentage),
        "slope": number(coefficient.slope),
        "slope_error": number(coefficient.slope_error),
        "expected_slope": TERMS[term].slope,
        "from_s": coefficient.tau_min,
        "to_s": coefficient.tau_max,
        "forced": coefficient.forced,
    }
