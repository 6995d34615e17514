"""Comparison of several results: their curves, the changes between two results, and the equivalent commands."""

from __future__ import annotations

import json
import pickle
import shlex
from collections.abc import Sequence
from statistics import NormalDist
from typing import Any

from sigmatau.analysis import Analysis
from sigmatau.app.calls import Progress, number
from sigmatau.lab.lots.comparison import compare_runs
from sigmatau.lab.lots.comparison_text import overview, tables, unused_lines
from sigmatau.lab.lots.differences import TermDifference, term_differences
from sigmatau.reporting.charts import collect_charts
from sigmatau.results import printable

Source = tuple[str, str | None]
"""Name of a result and the command that makes it; the command of a JSON file is None."""

_CHANCE = (
    0.05  # probability that any coefficient is called changed although none has. [1] Judgement: 1 minus the usual level
)


def compared(*, analyses: Sequence[bytes], sources: Sequence[Source], progress: Progress) -> str:
    """Curves of several results, and the repeatability of every channel and term, as JSON."""
    results: list[Analysis] = [pickle.loads(each) for each in analyses]
    short = [_file_name(name) for name, _ in sources]
    unique = [name if short.count(name) == 1 else f"{name} ({k})" for k, name in enumerate(short, 1)]
    comparison = compare_runs(results, names=unique)
    is_mixed = len(comparison.groups) > 1  # results of several units: all results of an axis are compared
    if is_mixed:
        comparison = compare_runs(results, names=unique, by="axis")
    columns = comparison.columns()
    curves: list[dict[str, Any]] = [
        {"name": printable(name), **collect_charts(result, None, None)}
        for name, result in zip(unique, results, strict=True)
    ]
    table = {key: [number(v, 9) if isinstance(v, float) else v for v in values] for key, values in columns.items()}
    sums = [result.source.sha256 for result in results if result.source.sha256 is not None]
    differences = term_differences(*results) if len(results) == 2 else ()
    compared_values = sum(each.value is not None for each in differences)
    without_curves = [
        f"no curve of {name}: its Allan deviations were not kept in the store"
        for name, result in zip(unique, results, strict=True)
        if not any(len(curve.tau) for curve in result.curves.values())
    ]
    content = {
        "names": unique,
        "curves": curves,
        "table": table,
        "differences": [
            {**each.to_dict(), "changed": has_changed(each, compared_values=compared_values)} for each in differences
        ],
        "same_log": any(sums.count(checksum) > 1 for checksum in sums),
        "text": overview(comparison),
        "tables": tables(comparison),
        "unused": [printable(line) for line in (*unused_lines(comparison), *without_curves)],
        "command": "\n".join(map(printable, commands(sources, by="axis" if is_mixed else None))),
    }
    return json.dumps(content, default=str)


def has_changed(difference: TermDifference, *, compared_values: int) -> bool:
    """Whether a difference is significant, corrected for the number of comparisons (Bonferroni).

    Among many intervals of 95 %, some exclude 0 by chance. The interval is therefore widened, as one of a normal
    distribution, until the probability that any of them excludes 0 is 5 %. A difference from an upper limit is not
    corrected.
    """
    value, low, high = difference.value, difference.low, difference.high
    if difference.verdict != "differs" or value is None or low is None or high is None:
        return difference.verdict == "differs"
    half = value - low if value > 0 else high - value
    usual = NormalDist().inv_cdf((1 + difference.level) / 2)
    return abs(value) * usual > half * NormalDist().inv_cdf(1 - _CHANCE / 2 / compared_values)


def commands(sources: Sequence[Source], *, by: str | None) -> list[str]:
    """The commands that write the results, followed by the command that compares them."""
    lines, files = [], list[str]()
    for name, command in sources:
        if command is None:
            files.append(name)
            continue
        stem = _file_name(name).replace(" ", "-").removesuffix(".gz").rpartition(".")
        file = f"{stem[0] or stem[2]}.json"
        while file in files:
            file = f"{file.removesuffix('.json')}-{len(files) + 1}.json"
        files.append(file)
        lines.append(f"{command} --json {shlex.quote(file)}")
    return [*lines, shlex.join(["sigmatau", "compare", *files, *(["--by", by] if by else [])])]


def _file_name(path: str) -> str:
    return path.replace("\\", "/").rpartition("/")[2]
