"""Calls that list the runs of a results store and read the result of a run."""

from __future__ import annotations

import json
import shlex
from typing import Any

from sigmatau.analysis import as_analysis, result_of_dict
from sigmatau.app.analysing import result_parts
from sigmatau.app.calls import Progress, number
from sigmatau.app.log import LogFile
from sigmatau.errors import DataError
from sigmatau.lab.store.choosing import Chosen
from sigmatau.lab.store.store import Store
from sigmatau.results import printable

_MOST_RUNS = 300  # largest number of runs that are listed


def listed_runs(*, log: LogFile, unit: str | None, progress: Progress) -> str:
    """The latest runs of each unit of a store, as JSON; a ``*`` in `unit` matches any text."""
    chosen = Chosen(units=(unit,)) if unit else None
    with Store(log.path, create=False) as store:
        rows = _rows(store, chosen)
    rows.reverse()  # the latest run of a unit comes first
    rows.sort(key=lambda row: str(row["unit"]))
    listed = [
        {
            "run": row["id"],
            "unit": printable(row["unit"]),
            "name": printable(row["run"]),
            "model": printable(row["model"] or ""),
            "recorded": None if row["recorded"] is None else row["recorded"].isoformat(sep=" ", timespec="minutes"),
            "temperature_degc": number(row["temperature"]),
            "duration_s": number(row["duration"]),
            "state": row["state"],
        }
        for row in rows[:_MOST_RUNS]
    ]
    return json.dumps({"kind": "store", "source": log.name, "runs": listed, "more": max(len(rows) - _MOST_RUNS, 0)})


def stored_run(*, log: LogFile, run: int, progress: Progress) -> dict[str, Any]:
    """The parts of the result of a run, and its name, made of the unit, the run and the day."""
    with Store(log.path, create=False) as store:
        row = next((row for row in _rows(store, None) if row["id"] == run), None)
        if row is None:
            raise DataError(f"the store has no run with the number {run}; list its runs again")
        content = store.content(run)
    day = "" if row["recorded"] is None else row["recorded"].date().isoformat()
    names = dict.fromkeys(printable(str(part)) for part in (row["unit"], row["run"], day) if part)
    name = " ".join(names)
    command = shlex.join(["sigmatau", "store", "show", str(row["unit"]), "--store", log.name, "--run", str(row["run"])])
    parts = result_parts(as_analysis(result_of_dict(content)), name=name, table=None, command=command)
    return {**parts, "name": name}


def _rows(store: Store, chosen: Chosen | None) -> list[dict[str, Any]]:
    columns = store.runs(chosen).columns()
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
