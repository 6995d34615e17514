"""The page of a comparison of runs: the values of all runs with their intervals, and their repeatability."""

from __future__ import annotations

import math
from datetime import datetime

import numpy as np

from sigmatau._native.distributions import normal_quantile
from sigmatau.lab.lots.comparison import RunComparison
from sigmatau.lab.lots.comparison_text import (
    COMPARED,
    VERDICTS,
    display_unit,
    in_order,
    mean_text,
    remarks,
    spread_texts,
    term_name,
    unused_lines,
)
from sigmatau.lab.lots.runs import SIGNED, ComparedRun
from sigmatau.lab.lots.short_names import short_names
from sigmatau.lab.pages.values_html import Panel, PanelSeries, TextTable, page
from sigmatau.record import stream_name


def comparison_page(comparison: RunComparison, *, command: str | None, date: datetime) -> str:
    """The comparison as HTML."""
    what = COMPARED[comparison.by]
    level = f"{100 * comparison.level:g} %"
    used = [run for run in comparison.runs if not run.problem]
    summary = [*remarks(comparison), *unused_lines(comparison)]
    title = comparison.groups[0] if len(comparison.groups) == 1 and comparison.groups[0] else f"{len(used)} {what}s"
    return page(
        kind="Comparison",
        title=title,
        summary=summary,
        about=f"Points: values, with their {level} intervals. Select a name to hide or show its values.",
        panels=_panels(comparison),
        tables=[_table(comparison)],
        settings=[
            ("Compared", f"{what}s; a group is the same {comparison.by}"),
            ("Confidence level", level),
            (f"Between {what}s", f"spread of the true values, errors removed, with its {level} interval"),
            ("Next ±", f"{level} prediction interval of one more {what}, around the mean"),
        ],
        command=command,
        date=date,
    )


def _panels(comparison: RunComparison) -> list[Panel]:
    """A chart for each sensor and term that has a value; the places are the runs in order."""
    used = [run for run in comparison.runs if not run.problem]
    position = {id(run): k for k, run in enumerate(used)}
    names = tuple(short_names([_run_name(comparison, run) for run in used]))
    z = float(normal_quantile((1 + comparison.level) / 2))
    charts: dict[tuple[str, str], list[int]] = {}
    for row in in_order(comparison, np.flatnonzero(comparison.cells.valued).tolist()):
        label = comparison.key(row)[1]
        charts.setdefault((stream_name(label.channel), label.term), []).append(row)
    panels = []
    for (sensor, term), rows in charts.items():
        first = comparison.key(rows[0])[1]
        unit, size = display_unit(first, [comparison.row(row).mean for row in rows])
        by_channel: dict[str, list[tuple[int, float, float | None, float | None]]] = {}
        for row in rows:
            for run, value, error in comparison.values(row):
                low, high = _ends(term, value / size, error / size if term in SIGNED else error, z)
                entry = (position[id(run)], value / size, low, high)
                by_channel.setdefault(comparison.key(row)[1].channel, []).append(entry)
        series = tuple(
            PanelSeries(name=channel, places=places, values=values, low=lows, high=highs)
            for channel, entries in by_channel.items()
            for places, values, lows, highs in [zip(*sorted(entries), strict=True)]
        )
        panels.append(
            Panel(
                title=f"{sensor} {term_name(first)}",
                unit=unit,
                order=COMPARED[comparison.by],
                places=names,
                series=series,
            )
        )
    return panels


def _ends(term: str, value: float, error: float, z: float) -> tuple[float, float] | tuple[None, None]:
    """Ends of the interval of a value, whose error is relative if the term has no sign; None if the error is unknown."""
    if not math.isfinite(error):
        return None, None
    return (
        (value - z * error, value + z * error)
        if term in SIGNED
        else (value * math.exp(-z * error), value * math.exp(z * error))
    )


def _run_name(comparison: RunComparison, run: ComparedRun) -> str:
    if comparison.by == "run" and run.serial:
        return run.serial
    return f"{run.serial} {run.name}" if len(comparison.groups) > 1 and run.serial else run.name


def _table(comparison: RunComparison) -> TextTable:
    what = COMPARED[comparison.by]
    judgements = comparison.judgements()
    has_groups = len(comparison.groups) > 1
    heads = ("Channel", "Coefficient", "Mean", "Unit", "STD %", f"Between {what}s %", "Next ± %", "Values", "Verdict")
    rows = []
    for row in in_order(comparison, np.flatnonzero(comparison.cells.valued).tolist()):
        group, label = comparison.key(row)
        effects = comparison.row(row)
        unit, size = display_unit(label, [effects.mean])
        counts = f"{int(comparison.cells.valued[row])} of {int(comparison.cells.looked[row])}"
        cells = (
            label.channel, term_name(label), mean_text(effects, size), unit,
            *spread_texts(label, effects), counts, VERDICTS[judgements[row]],
        )  # fmt: skip
        rows.append((group, *cells) if has_groups else cells)
    about = f"Values: {what}s that show the coefficient; if not all show it, the mean of those that do is too large"
    return TextTable(
        title="Repeatability",
        heads=(comparison.by.capitalize(), *heads) if has_groups else heads,
        rows=tuple(rows),
        remarks=(about,),
    )
