"""Calls that open a log before its analysis: columns with statistics of their values, and envelopes of the samples."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from sigmatau._version import __version__
from sigmatau.analysis import STAGE_NAMES
from sigmatau.app.calls import Progress, cached, cached_record, error_content, number, reading_options, record_size
from sigmatau.app.controls import default_file, export_controls, labels, target_content
from sigmatau.app.faces import finding_content
from sigmatau.app.kinds import file_kind
from sigmatau.app.log import LogFile
from sigmatau.errors import OptionError
from sigmatau.exporting.targets import NAMES
from sigmatau.exporting.targets import target as find_target
from sigmatau.findings.finding import Finding
from sigmatau.hints import worded
from sigmatau.io.read import inspection
from sigmatau.io.read.inspection import Inspection, TableInfo
from sigmatau.io.read.options import ReadOptions
from sigmatau.io.read.table import FORMATS
from sigmatau.noise.terms import TERMS
from sigmatau.quality.first_look import SensorMean, first_look
from sigmatau.quality.selection.exclusion import from_the_start
from sigmatau.record.record import Record, stream_name
from sigmatau.record.summary import ChannelSummary, summarise
from sigmatau.reporting.envelope import envelope
from sigmatau.results import printable
from sigmatau.typed.config import EXPORT, check_names, command_line, from_toml, split_exports, to_toml
from sigmatau.units import FIGURE_UNITS

_MOST_COLUMNS = 512  # largest number of columns of a table that are listed
_LARGEST_WHOLE = 2.0**63  # smaller whole numbers are shown with all digits
_SPARK_DIGITS = 12  # digits of a sparkline: time stamps in ns since 1970 differ only after the seventh
_MOST_STRETCHES = 4000  # largest number of points of an envelope


def about(*, progress: Progress) -> str:
    """Formats, targets, options, terms and units, for a page that is opened."""
    content = {
        "version": __version__,
        "formats": worded(FORMATS),
        "targets": [
            target_content(find_target(name))
            for name in NAMES
        ],
        "choices": export_controls(),
        "labels": labels(),
        "terms": [{"name": name, "label": term.label("angular_rate"), "slope": term.slope} for name, term in TERMS.items()],
        "units": {quantity: list(names) for quantity, names in FIGURE_UNITS.items()},
        "stages": ["read", *STAGE_NAMES],
        "no_pdf": "" if find_spec("typst") else "needs typst: pip install 'sigmatau[pdf]'",
    }  # fmt: skip
    return json.dumps(content)


def configured(
    *, table: Mapping[str, Any] | None, toml: str | None, log_name: str | None, target: str | None,
    choices: Mapping[str, Any], progress: Progress,
) -> str:  # fmt: skip
    """Convert options to a configuration file and a command, or a configuration file to options.

    With a `target`, the file and the command also export its file, with the options `choices`.
    """
    if toml is not None:
        return json.dumps(_session(toml), default=str)
    check_names(table or {})
    check_names(choices, exports=True)
    options = dict(table or {})
    if target is not None:
        found_target = find_target(target)
        options |= {EXPORT: [f"{found_target.name}={default_file(found_target)}"], **choices}
    return json.dumps({"toml": to_toml(options, log=log_name), "command": command_line(log_name or "LOG", options)})


def kind_of_file(*, log: LogFile, progress: Progress) -> str | None:
    """The kind of a file."""
    return file_kind(Path(log.path))


def opened_session(*, log: LogFile, progress: Progress) -> str:
    """A saved session as JSON: the log, the options of the analysis, the target of the export and its options."""
    session = _session(Path(log.path).read_text(encoding="utf-8-sig", errors="replace"))
    if session["log"] is None:
        raise OptionError('the session names no log: it needs a line log = "…"', option="config")
    return json.dumps({"kind": "session", **session}, default=str)


def _session(toml: str) -> dict[str, Any]:
    """Parse a configuration file: options of the analysis, log, and the first target of the export with its options."""
    stated, named = from_toml(toml)
    options, exports, choices = split_exports(stated)
    check_names(options)
    return {"options": options, "log": named, "target": next(iter(exports), None), "choices": choices}


def open_log(*, log: LogFile, table: Mapping[str, Any], progress: Progress) -> str:
    """The columns of a log with statistics of their values, as JSON; see the documentation of ``api/open``."""
    check_names(table)
    contents = inspected(log, table)
    info = _shown_table(contents)
    shown = [each for each in contents.tables if each.chosen] or [info]
    question = contents.question or next((each.question for each in shown if each.question is not None), None)
    record = contents.record
    streams = () if record is None else record.streams
    duration = max((stream.grid.lead + stream.grid.duration for stream in streams), default=None)
    content = {
        "kind": "log",
        "source": log.name,
        "format": contents.format,
        "rows": info.rows,
        "duration_s": number(duration),
        "rate_hz": number(info.rate, 9),
        "rate_how": "" if info.rate_source is None else str(info.rate_source),
        "columns": [row for each in shown for row in _columns(each, record, reading_options(table))],
        "topics": _topics(contents.tables),
        "channels": [
            {
                "channel": channel, "sensor": stream.name, "quantity": stream.quantity, "unit": stream.unit,
                "rate_hz": number(stream.grid.rate, 9), "samples": stream.grid.n, "from_s": number(stream.grid.lead, 9),
            }
            for stream in streams
            for channel in stream.channels
        ],
        "means": [] if record is None else [_mean(mean) for mean in first_look(record)],
        "notes": list(map(printable, info.notes)),
        "findings": [_finding(finding) for finding in contents.findings],
        "command": command_line(log.name, table),
        "question": None if question is None else error_content(question, log),
    }  # fmt: skip
    return json.dumps(content, allow_nan=False)


def inspected(log: LogFile, table: Mapping[str, Any]) -> Inspection:
    """Inspect a log. It is read once, for the columns and for the envelopes."""

    def look() -> Inspection:
        return inspection.inspect(log.path, ReadOptions(**reading_options(table)), sampled=True)

    return cached("look", log, table, look, size=lambda contents: record_size(contents.record))  # type: ignore[no-any-return]


def _shown_table(contents: Inspection) -> TableInfo:
    """The table whose columns are shown: one that is read, otherwise one with a question, otherwise one with a sensor."""
    ranks = [
        (
            table.chosen,
            table.question is not None,
            any(column.channel not in (None, "time") for column in table.columns),
        )
        for table in contents.tables
    ]
    return contents.tables[ranks.index(max(ranks))]


def _columns(info: TableInfo, record: Record | None, reading: Mapping[str, Any]) -> list[dict[str, Any]]:
    channels = {place: channel for channel, place in info.places.items()}
    channels = channels or {k: column.channel for k, column in enumerate(info.columns) if column.channel}
    remarks = {each.channels[0]: finding_content(each)["text"] for each in info.findings if len(each.channels) == 1}
    rows = []
    for k, column in enumerate(info.columns[:_MOST_COLUMNS]):
        channel = channels.get(k)
        samples = info.samples.get(k)
        bounds = () if samples is None else zip(samples.low.tolist(), samples.high.tolist(), strict=True)
        summary = None
        if record is not None and channel in record.channels:
            summary = summarise(record.stream_of(channel), channel)
        stream = None if summary is None or record is None or channel is None else record.stream_of(channel)
        unit, how = _unit(column.unit, channel, reading)
        rows.append(
            {
                "topic": info.topic,
                "number": k + 1,
                "name": printable(column.name),
                "values": [_first_value(value) for value in samples.first]
                if samples
                else [column.first]
                if column.first
                else [],
                "spark": [[number(low, _SPARK_DIGITS), number(high, _SPARK_DIGITS)] for low, high in bounds],
                "role": _role(channel),
                "channel": channel,
                "recognised": column.channel,
                "quantity": None if stream is None else stream.quantity,
                "unit": unit,
                "unit_how": how if channel else None,
                "unit_si": None if stream is None else stream.unit,
                "rate_hz": None if stream is None else number(stream.grid.rate, 9),
                **_summary(summary),
                "remark": remarks.get(channel or ""),
            }
        )
    return rows


def _first_value(value: float) -> float | int | None:
    """Round a value, but show whole numbers, such as time stamps, with all digits."""
    return int(value) if value.is_integer() and abs(value) < _LARGEST_WHOLE else number(value, 9)


def _summary(summary: ChannelSummary | None) -> dict[str, Any]:
    """Statistics of the values, in SI."""
    if summary is None:
        return {"gaps": None, "missing": None, "mean_si": None, "peak_to_peak": None}
    return {
        "gaps": summary.gaps,
        "missing": summary.missing,
        "mean_si": number(summary.mean),
        "peak_to_peak": number(summary.peak_to_peak),
    }


def _mean(mean: SensorMean) -> dict[str, Any]:
    """The mean vector of a sensor, in SI."""
    return {
        "sensor": mean.sensor,
        "quantity": mean.quantity,
        "length": number(mean.length),
        "expected": number(mean.expected),
        "unit": mean.unit,
        "verdict": mean.verdict,
        "likely": mean.likely,
    }


def _role(channel: str | None) -> str:
    if channel is None:
        return "ignored"
    return channel if channel in ("time", "temperature") else "channel"


def _unit(stated: str | None, channel: str | None, reading: Mapping[str, Any]) -> tuple[str | None, str]:
    """The unit of a column as it was typed, and who stated it: the user or the file."""
    stated_units: Mapping[str, str] = reading.get("unit") or {}
    if channel is not None:
        for key in (channel, stream_name(channel)):
            if key in stated_units:
                return stated_units[key], "given"
    return stated, "stated" if stated else "missing"


def _topics(tables: Iterable[TableInfo]) -> list[dict[str, Any]]:
    tables = tuple(tables)
    if len(tables) < 2:
        return []
    return [
        {
            "name": table.topic,
            "rows": table.rows,
            "rate_hz": number(table.rate, 9),
            "chosen": table.chosen,
            "channels": [column.channel for column in table.columns if column.channel],
            "question": None if table.question is None else table.wanting,
        }
        for table in tables
    ]


def _finding(finding: Finding) -> dict[str, Any]:
    return {
        **finding_content(finding),
        "code": finding.code,
        "channel": finding.channels[0] if len(finding.channels) == 1 else None,
        "channels": list(finding.channels),
        "spans": [[number(a, 9), number(b, 9)] for a, b in finding.spans],
    }


def envelopes(
    *, log: LogFile, table: Mapping[str, Any], channel: str | None, from_s: float | None, to_s: float | None, width: int,
    may_read: bool, progress: Progress,
) -> str | None:  # fmt: skip
    """Smallest and largest sample of each of `width` intervals of the record, or of a part of it, as JSON.

    None if the record is not cached and `may_read` is false.
    """
    check_names(table)
    if not 1 <= width <= _MOST_STRETCHES:
        raise OptionError(
            f"{{option}} must be a number of intervals, 1 to {_MOST_STRETCHES}, not {width}", option="width"
        )
    record = cached_record(log, table)
    if record is None and not may_read:
        return None
    record = from_the_start(record or _require_record(log, table))
    if channel is not None and channel not in record.channels:
        raise OptionError(f"no channel {channel!r}; channels: {', '.join(record.channels)}", option="channel")
    drawn: dict[str, Any] = {}
    for stream in record.streams:
        grid = stream.grid
        first = 0 if from_s is None else min(max(grid.sample(from_s), 0), grid.n)
        stop = grid.n if to_s is None else min(max(grid.sample(to_s), 0), grid.n)
        if stop <= first:
            continue
        part = stream.cut(first, stop) if (first, stop) != (0, grid.n) else stream
        for name in part.channels:
            if channel in (None, name):
                low, high, edges = envelope(part, name, width)
                middles = (edges[:-1] + edges[1:] - 1) / 2
                drawn[name] = {
                    "t": [number(part.grid.time(x), 9) for x in middles.tolist()],
                    "low": [number(x) for x in low.tolist()],
                    "high": [number(x) for x in high.tolist()],
                    "unit": part.unit,
                    "quantity": part.quantity,
                }
    ends = [(stream.grid.lead, stream.grid.lead + stream.grid.duration) for stream in record.streams]
    content = {
        "channels": drawn,
        "start_s": number(min(start for start, _ in ends), 9),
        "end_s": number(max(end for _, end in ends), 9),
    }
    return json.dumps(content, allow_nan=False)


def _require_record(log: LogFile, table: Mapping[str, Any]) -> Record:
    """The record of a log; raises the `OptionError` that asks for a missing option."""
    contents = inspected(log, table)
    if contents.record is None:
        question = contents.question or _shown_table(contents).question
        raise question or OptionError(
            "the samples cannot be read yet: choose columns, units or a rate", option="channels"
        )
    return contents.record
