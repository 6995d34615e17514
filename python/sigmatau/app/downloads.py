"""Calls that make files to download: exports, the report, tables and figures."""

from __future__ import annotations

import json
import pickle
import shlex
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from sigmatau.analysis import Analysis
from sigmatau.app.calls import Progress
from sigmatau.app.controls import default_file
from sigmatau.app.faces import finding_content, hints_content
from sigmatau.app.log import LogFile
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import prepare
from sigmatau.exporting.inflation import inflated
from sigmatau.exporting.targets import target as find_target
from sigmatau.exporting.turn_on import with_turn_on
from sigmatau.findings.finding import Finding
from sigmatau.plot.curves import save
from sigmatau.reporting.content import Content, collect_content, filter_files
from sigmatau.reporting.html import page
from sigmatau.results import csv_text, printable
from sigmatau.typed.config import arguments, check_names, option_words


def _loaded(analysis: bytes) -> Analysis:
    loaded: Analysis = pickle.loads(analysis)
    return loaded


def exported(
    *, analysis: bytes, target: str, table: Mapping[str, Any], rest: bytes | None, rest_name: str,
    turn_on: LogFile | None, progress: Progress,
) -> str:  # fmt: skip
    """A preview of the file that an export writes, as JSON.

    `rest`: an analysis of the same sensor at rest; `turn_on`: a model file that ``sigmatau compare --model`` wrote.
    """
    check_names(table, exports=True)
    found_target = find_target(target)
    source, doubt, inflation_words = _loaded(analysis).to_source(), "", []
    if rest is not None:
        source, doubt = inflated(source, _loaded(rest).to_source(), name=rest_name)
        inflation_words = ["--inflate", rest_name]
    turn_on_words = [] if turn_on is None else ["--turn-on", turn_on.name]
    if turn_on is not None:
        source = with_turn_on(source, Path(turn_on.path))
    prepared = prepare(source, to=found_target.name, choices=Choices(**arguments(Choices, table)))
    name = default_file(found_target)
    words = [
        "sigmatau",
        "export",
        "result.json",
        "--to",
        found_target.name,
        *option_words(table),
        *inflation_words,
        *turn_on_words,
        "-o",
        name,
    ]
    warnings = [{"severity": "warning", "text": printable(doubt), "action": "", "hint": None}] if doubt else []
    content = {
        "target": found_target.name,
        "files": [{"name": name, "text": str(prepared.content)}],
        "warnings": warnings + [_warning(finding) for finding in dict.fromkeys(prepared.findings)],
        "command": shlex.join(words),
    }
    return json.dumps(content)


def _warning(finding: Finding) -> dict[str, Any]:
    return {**finding_content(finding), "hint": hints_content("".join(finding.words()))}


def report(*, analysis: bytes, content: bytes | None, form: str, progress: Progress) -> bytes:
    """The report as HTML or PDF. That of a stored result has no densities and time series."""
    result = _loaded(analysis)
    made: Content = collect_content(result, None, targets=()) if content is None else pickle.loads(content)
    if form == "pdf":
        from sigmatau.reporting.pdf import document, need_typst

        need_typst()
        return document(made)
    files, no_files = filter_files(result)
    return page(replace(made, files=files, no_files=no_files)).encode()


def curve_table(*, analysis: bytes, what: str, progress: Progress) -> bytes:
    """The curves or the coefficients as CSV."""
    result = _loaded(analysis)
    return csv_text((result.curves if what == "curve" else result).columns()).encode()


def figure(*, analysis: bytes, form: str, progress: Progress) -> bytes:
    """The figure of the curves as SVG or PNG."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"figure.{form}"
        save(_loaded(analysis).plot(), str(file))
        return file.read_bytes()
