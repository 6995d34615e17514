"""Preparation of results of any kind as one table of runs: names them, groups them by unit, and marks copies and values in
another physical unit as unused.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from sigmatau.analysis import as_result
from sigmatau.errors import DataError, OptionError
from sigmatau.lab.lots.conditions import SUPPLY, TEMPERATURE
from sigmatau.lab.lots.reading import gather, read_runs
from sigmatau.lab.lots.runs import ComparedRun, RunsBuilder, RunTable, joined


def collect_runs(
    results: Any,  # noqa: ANN401  what a user gives
    names: Sequence[str] | None,
    units: Sequence[str] | None,
    jobs: int | None,
) -> RunTable:
    """The rows of results: objects, dictionaries and files. Raises `OptionError` for a wrong number of names."""
    inputs = [results] if isinstance(results, str | Path | Mapping) or hasattr(results, "to_dict") else list(results)
    for option, listed in (("names", names), ("units", units)):
        if listed is not None and len(listed) != len(inputs):
            raise OptionError(
                f"{{option}} must have one name per result: {len(listed)} names, {len(inputs)} results",
                option=option,
            )
    if not inputs:
        raise DataError("no results to compare")
    if names is None and units is None and all(isinstance(result, str | Path) for result in inputs):
        return read_runs(gather([Path(result) for result in inputs]), jobs=jobs)
    tables = []
    for k, result in enumerate(inputs):
        name = f"run {k + 1}" if names is None else str(names[k])
        serial = None if units is None else str(units[k])
        if isinstance(result, str | Path):
            part = read_runs(gather([Path(result)]), jobs=jobs)
            has_many = len(part.runs) > 1
            runs = (
                replace(
                    run,
                    name=run.name if names is None else f"{name} {run.name}" if has_many else name,
                    serial=run.serial if serial is None else serial,
                )
                for run in part.runs
            )
            tables.append(replace(part, runs=tuple(runs)))
            continue
        builder = RunsBuilder()
        try:
            builder.add_result(as_result(result), name=name, serial=serial)
        except DataError as error:
            builder.add_run(ComparedRun(name=name, serial=serial or "", problem=str(error)))
        part = builder.table()
        if names is not None:
            part = replace(part, runs=tuple(replace(run, name=name) for run in part.runs))
        tables.append(part)
    return joined(tables)


def mark_copies(table: RunTable) -> tuple[ComparedRun, ...]:
    """Mark results that occur twice as unused, because copies are not independent.

    A copy has the same log, or values equal to the last bit, which two records do not have. Typed values may be equal.
    """
    order = np.argsort(table.run, kind="stable")
    ends = np.searchsorted(table.run[order], np.arange(len(table.runs) + 1))
    first_runs: dict[object, ComparedRun] = {}
    runs = []
    for k, run in enumerate(table.runs):
        run_rows = order[ends[k] : ends[k + 1]]
        if not len(run_rows) and not run.problem:
            runs.append(replace(run, problem="no values"))
            continue
        keys: list[object] = [] if run.sha256 is None else [run.sha256]
        if not run.typed and len(run_rows):
            keys.append(
                (table.label[run_rows].tobytes(), table.value[run_rows].tobytes(), table.limit[run_rows].tobytes())
            )
        first = next((first_runs[key] for key in keys if key in first_runs), None)
        if first is not None and not run.problem:
            runs.append(replace(run, problem=f"of the same log as {first.place or first.name}"))
            continue
        first_runs |= dict.fromkeys(keys, run)
        runs.append(run)
    return tuple(runs)


def split_by_condition(runs: tuple[ComparedRun, ...]) -> tuple[ComparedRun, ...]:
    """Add the temperature and the supply voltage to the serial number of each run, if they differ between runs.

    Runs of a unit at two temperatures are then compared as those of two units, because bias and noise depend on it.
    """
    usable = [run for run in runs if not run.problem and not run.typed]
    for factor, values in (
        (TEMPERATURE, [run.temperature for run in usable]),
        (SUPPLY, [run.supply for run in usable]),
    ):
        labels = dict(zip(map(id, usable), factor.groups(values), strict=True))
        usable_now = []
        result = []
        for run in runs:
            label = labels.get(id(run), "")
            named = replace(run, serial=f"{run.serial} {label}".strip()) if label else run
            result.append(named)
            if id(run) in labels:
                usable_now.append(named)
        runs, usable = tuple(result), usable_now
    return runs


def name_by_place(runs: tuple[ComparedRun, ...]) -> tuple[ComparedRun, ...]:
    """Name units by folder if no note names them and there are several folders; number runs of a unit with equal names."""
    named = any(run.serial for run in runs)
    folders = set() if named else {Path(run.place).parent for run in runs if run.place and not run.problem}
    if len(folders) > 1:
        runs = tuple(replace(run, serial=Path(run.place).parent.name if run.place else "") for run in runs)
    used: set[tuple[str, str]] = set()
    runs_named = []
    for run in runs:
        name, number = run.name, 2
        while (run.serial, name) in used and not run.problem:
            name, number = f"{run.name} ({number})", number + 1
        used.add((run.serial, name))
        runs_named.append(run if name == run.name else replace(run, name=name))
    return tuple(runs_named)


def drop_other_units(table: RunTable) -> RunTable:
    """Remove channels whose physical unit differs from that of most runs, such as rad/s among m/s², and report the runs."""
    kinds: dict[tuple[str, str], list[int]] = {}
    for k, label in enumerate(table.labels):
        kinds.setdefault((label.channel, label.term), []).append(k)
    ambiguous = [same_labels for same_labels in kinds.values() if len(same_labels) > 1]
    if not ambiguous:
        return table
    counts = np.bincount(table.label, minlength=len(table.labels))
    keep = np.ones(len(table.labels), dtype=bool)
    for same_labels in ambiguous:
        usual = max(same_labels, key=lambda k: counts[k])
        keep[[k for k in same_labels if k != usual]] = False
    runs = list(table.runs)
    for run in np.unique(table.run[~keep[table.label]]):
        wrong = sorted({table.labels[k].channel for k in table.label[table.run == run] if not keep[k]})
        if not runs[run].problem:
            runs[run] = replace(runs[run], problem=f"{', '.join(wrong)}: in another unit than in the other results")
    bad = {k for k, run in enumerate(runs) if run.problem}
    rows = np.array(
        [keep[label] and run not in bad for run, label in zip(table.run, table.label, strict=True)], dtype=bool
    )
    arrays = {
        name: getattr(table, name)[rows] for name in ("run", "label", "value", "error", "limit", "delta", "status")
    }
    return replace(table, runs=tuple(runs), **arrays)
