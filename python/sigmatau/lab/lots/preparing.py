"""Results of any kind as one table of runs: named, grouped by unit, without copies and without other physical units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from sigmatau.analysis import as_result
from sigmatau.errors import DataError, OptionError
from sigmatau.lab.lots.reading import gather, read_runs
from sigmatau.lab.lots.runs import Run, RunsBuilder, RunTable, joined


def table_of(
    results: Any,  # noqa: ANN401  what a user gives
    names: Sequence[str] | None,
    units: Sequence[str] | None,
    jobs: int | None,
) -> RunTable:
    """The rows of results: objects, dictionaries and files. Raises `OptionError` for a wrong number of names."""
    given = [results] if isinstance(results, str | Path | Mapping) or hasattr(results, "to_dict") else list(results)
    for option, of in (("names", names), ("units", units)):
        if of is not None and len(of) != len(given):
            raise OptionError(
                f"{{option}} must have one name per result: {len(of)} names, {len(given)} results", option=option
            )
    if not given:
        raise DataError("no results to compare")
    if names is None and units is None and all(isinstance(one, str | Path) for one in given):
        return read_runs(gather([Path(one) for one in given]), jobs=jobs)
    tables = []
    for k, one in enumerate(given):
        name = f"run {k + 1}" if names is None else str(names[k])
        serial = None if units is None else str(units[k])
        if isinstance(one, str | Path):
            own = read_runs(gather([Path(one)]), jobs=jobs)
            many = len(own.runs) > 1
            runs = (
                replace(
                    run,
                    name=run.name if names is None else f"{name} {run.name}" if many else name,
                    serial=run.serial if serial is None else serial,
                )
                for run in own.runs
            )
            tables.append(replace(own, runs=tuple(runs)))
            continue
        builder = RunsBuilder()
        try:
            builder.add_result(as_result(one), name=name, serial=serial)
        except DataError as error:
            builder.add_run(Run(name=name, serial=serial or "", problem=str(error)))
        own = builder.table()
        if names is not None:
            own = replace(own, runs=tuple(replace(run, name=name) for run in own.runs))
        tables.append(own)
    return joined(tables)


def without_copies(table: RunTable) -> tuple[Run, ...]:
    """Results that are there twice are named, because copies are not independent: of the same log, or with the same values
    to the last bit, which two records do not have. Values that were typed may be equal.
    """
    order = np.argsort(table.run, kind="stable")
    ends = np.searchsorted(table.run[order], np.arange(len(table.runs) + 1))
    seen: dict[object, Run] = {}
    found = []
    for k, run in enumerate(table.runs):
        own = order[ends[k] : ends[k + 1]]
        if not len(own) and not run.problem:
            found.append(replace(run, problem="no values"))
            continue
        keys: list[object] = [] if run.sha256 is None else [run.sha256]
        if not run.typed and len(own):
            keys.append((table.label[own].tobytes(), table.value[own].tobytes(), table.limit[own].tobytes()))
        first = next((seen[key] for key in keys if key in seen), None)
        if first is not None and not run.problem:
            found.append(replace(run, problem=f"of the same log as {first.place or first.name}"))
            continue
        seen |= dict.fromkeys(keys, run)
        found.append(run)
    return tuple(found)


def with_places(runs: tuple[Run, ...]) -> tuple[Run, ...]:
    """Units by folder if no note names them and there are several folders; names that tell the runs of a unit apart."""
    named = any(run.serial for run in runs)
    folders = set() if named else {Path(run.place).parent for run in runs if run.place and not run.problem}
    if len(folders) > 1:
        runs = tuple(replace(run, serial=Path(run.place).parent.name if run.place else "") for run in runs)
    used: set[tuple[str, str]] = set()
    found = []
    for run in runs:
        name, number = run.name, 2
        while (run.serial, name) in used and not run.problem:
            name, number = f"{run.name} ({number})", number + 1
        used.add((run.serial, name))
        found.append(run if name == run.name else replace(run, name=name))
    return tuple(found)


def of_one_unit(table: RunTable) -> RunTable:
    """Without channels that are in another physical unit than in most runs, such as rad/s among m/s²: the runs are named."""
    kinds: dict[tuple[str, str], list[int]] = {}
    for k, label in enumerate(table.labels):
        kinds.setdefault((label.channel, label.term), []).append(k)
    several = [of for of in kinds.values() if len(of) > 1]
    if not several:
        return table
    counts = np.bincount(table.label, minlength=len(table.labels))
    keep = np.ones(len(table.labels), dtype=bool)
    for of in several:
        most = max(of, key=lambda k: counts[k])
        keep[[k for k in of if k != most]] = False
    runs = list(table.runs)
    for at in np.unique(table.run[~keep[table.label]]):
        wrong = sorted({table.labels[k].channel for k in table.label[table.run == at] if not keep[k]})
        if not runs[at].problem:
            runs[at] = replace(runs[at], problem=f"{', '.join(wrong)}: in another unit than in the other results")
    bad = {k for k, run in enumerate(runs) if run.problem}
    rows = np.array(
        [keep[label] and run not in bad for run, label in zip(table.run, table.label, strict=True)], dtype=bool
    )
    arrays = {
        name: getattr(table, name)[rows] for name in ("run", "label", "value", "error", "limit", "delta", "status")
    }
    return replace(table, runs=tuple(runs), **arrays)
