"""Downloads: files of other programs, the report, tables and figures."""

from __future__ import annotations

import json
import pickle
import shlex
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sigmatau.analysis import Analysis
from sigmatau.app.calls import Progress
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import prepare
from sigmatau.exporting.targets import target as find_target
from sigmatau.findings.finding import Finding
from sigmatau.plot.curves import save
from sigmatau.reporting.content import Content, collect_content
from sigmatau.reporting.html import page
from sigmatau.results import csv_text, printable
from sigmatau.typed.config import arguments, check_names, option_words


def _loaded(analysis: bytes) -> Analysis:
    loaded: Analysis = pickle.loads(analysis)
    return loaded


def exported(*, analysis: bytes, target: str, table: Mapping[str, Any], progress: Progress) -> str:
    """The file of a target as it would be written, as JSON."""
    check_names(table, exports=True)
    wanted = find_target(target)
    prepared = prepare(_loaded(analysis), to=wanted.name, choices=Choices(**arguments(Choices, table)))
    name = f"{wanted.name}{wanted.ending}"
    words = ["sigmatau", "export", "result.json", "--to", wanted.name, *option_words(table), "-o", name]
    content = {
        "target": wanted.name,
        "files": [{"name": name, "text": str(prepared.content)}],
        "warnings": [_warning(finding) for finding in prepared.findings],
        "command": shlex.join(words),
    }
    return json.dumps(content)


def _warning(finding: Finding) -> dict[str, str]:
    message, action = finding.words_of_files()
    return {"severity": finding.severity, "text": printable(message), "action": printable(action)}


def report_page(*, analysis: bytes, content: bytes | None, progress: Progress) -> bytes:
    """The report as HTML; without densities and time series for a result that was read."""
    made: Content = collect_content(_loaded(analysis), None) if content is None else pickle.loads(content)
    return page(made).encode()


def curve_table(*, analysis: bytes, what: str, progress: Progress) -> bytes:
    """The curves or the coefficients as CSV."""
    result = _loaded(analysis)
    return csv_text((result.curves if what == "curve" else result).columns()).encode()


def figure(*, analysis: bytes, form: str, progress: Progress) -> bytes:
    """The figure of the curves: SVG or PNG."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"figure.{form}"
        save(_loaded(analysis).plot(), str(file))
        return file.read_bytes()
