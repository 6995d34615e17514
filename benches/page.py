"""The page docs/performance.md, from the measurements."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from benches import checks, curves, fits, growth, job, kernels, peers, processes, simulation, stream, text
from benches.reasons import REASONS

SECTIONS = {
    module.__name__.split(".")[-1]: module
    for module in (job, peers, kernels, processes, stream, simulation, growth, curves, fits, checks)
}


def write(measured: dict[str, Any], folder: Path) -> None:
    """Write performance.md and its figures into a folder; sections without measurements are omitted."""
    body: list[str] = []
    reached: list[text.Gate] = []
    for name, module in SECTIONS.items():
        if name in measured["sections"]:
            lines, gates = module.write(measured["sections"][name]["found"])
            body += lines
            reached += gates
    figures = folder / "figures"
    figures.mkdir(parents=True, exist_ok=True)
    for module in (growth, curves):
        name = module.__name__.split(".")[-1]
        if name in measured["sections"]:
            module.draw(measured["sections"][name]["found"], figures)
    page = "\n".join([*_head(measured), *_summary(reached), *body]).rstrip() + "\n"
    (folder / "performance.md").write_text(page, encoding="utf-8")


def _head(measured: dict[str, Any]) -> list[str]:
    runs = list(measured["sections"].values())
    dates = sorted({run["date"] for run in runs})
    commands = [f"`{command}`" for command in dict.fromkeys(run["command"] for run in runs)]
    rounds = " or ".join(str(number) for number in sorted({run["rounds"] for run in runs}))
    loads = [float(run["load"]) for run in runs]
    m = runs[-1]["machine"]
    versions = ", ".join(f"{name} {m[name]}" for name in m if name not in ("processor", "cores", "system"))
    return [
        "# Performance",
        "",
        *text.prose(
            f"Made by {', '.join(commands)} on {' and '.join(dates)}: {m['processor']}, {m['cores']} cores, {m['system']};",
            f"{versions}.",
        ),
        *text.prose(
            f"Medians of {rounds} rounds, or fewer for runs of seconds. The programs run alternately in one process,",
            "after a check that their results agree to 10⁻⁹. Average number of running processes in the minute before each",
            f"part, including the benchmark: {min(loads):.1f} to {max(loads):.1f}.",
        ),
    ]


def _summary(reached: list[text.Gate]) -> list[str]:
    if not reached:
        return []
    passed = sum(gate.passed for gate in reached)
    rows = [[g.what, g.aim, f"**{g.got}**", "reached" if g.passed else "not reached"] for g in reached]
    head = ["## Targets", "", f"{passed} of {len(reached)} targets are reached.", ""]
    table = text.table(["", "target", "measured", ""], rows)
    why = [f"- {g.what}: {REASONS[g.what]}" for g in reached if not g.passed and g.what in REASONS]
    return [*head, *table, *(["Why the others are not:", "", *why, ""] if why else [])]
