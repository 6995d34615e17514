"""Several results beside each other."""

from __future__ import annotations

import json
import pickle
from collections.abc import Sequence
from typing import Any

from sigmatau.analysis import Analysis
from sigmatau.app.calls import Progress, number
from sigmatau.lab.lots.comparison import compare_runs
from sigmatau.lab.lots.comparison_text import overview, tables, unused_lines
from sigmatau.lab.lots.differences import term_differences
from sigmatau.reporting.charts import collect_charts
from sigmatau.results import printable


def compared(*, analyses: Sequence[bytes], names: Sequence[str], progress: Progress) -> str:
    """Curves of several results, and the repeatability of every channel and term, as JSON."""
    results: list[Analysis] = [pickle.loads(each) for each in analyses]
    short = [name.replace("\\", "/").rpartition("/")[2] for name in names]
    unique = [name if short.count(name) == 1 else f"{name} ({k})" for k, name in enumerate(short, 1)]
    comparison = compare_runs(results, names=unique)
    if len(comparison.groups) > 1:  # of several units: all results of an axis are compared
        comparison = compare_runs(results, names=unique, by="axis")
    columns = comparison.columns()
    curves: list[dict[str, Any]] = [
        {"name": printable(name), **collect_charts(result, None, None)}
        for name, result in zip(unique, results, strict=True)
    ]
    table = {key: [number(v, 9) if isinstance(v, float) else v for v in values] for key, values in columns.items()}
    sums = [result.source.sha256 for result in results if result.source.sha256 is not None]
    differences = term_differences(*results) if len(results) == 2 else ()
    content = {
        "names": unique,
        "curves": curves,
        "table": table,
        "differences": [each.to_dict() for each in differences],
        "same_log": any(sums.count(checksum) > 1 for checksum in sums),
        "text": overview(comparison),
        "tables": tables(comparison),
        "unused": [printable(line) for line in unused_lines(comparison)],
    }
    return json.dumps(content, default=str)
