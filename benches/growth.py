"""Growth of time and memory with the number of samples and of averaging times, in two figures.

``python -m benches.growth PARTY SAMPLES COUNT`` prints the rise of the peak memory of a process by one call, beyond the
samples; COUNT 0 is octaves.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from benches import text
from benches.measure import Settings, status_bytes, turns
from benches.peers import PEERS, log_spaced, noise, octaves, ours
from benches.text import Gate

COLOURS = {"ours": "#0072B2", "allantools": "#D55E00", "allan-variance": "#009E73", "numba": "#CC79A7"}
PARTIES: dict[str, Callable[..., Any]] = {**PEERS, "ours": ours}
LENGTHS = (1e5, 1e6, 1e7, 1e8)
LONGEST_OF_PEERS = 1e7
COUNTS = (10, 30, 100, 300, 1000)


def peak(party: str, n: int, count: int) -> int:
    """Bytes that one call needs beyond its samples; called in a separate process."""
    PARTIES[party](noise(1000), octaves(1000))  # imports and compilation at the first use
    rate = noise(n)
    before = status_bytes("VmRSS")
    grid = log_spaced(n, count) if count else octaves(n)
    PARTIES[party](rate, grid)
    return max(0, status_bytes("VmHWM") - before)


def measure(settings: Settings) -> dict[str, Any]:
    """Time of each party, in turns, and its memory."""
    lengths = []
    for length in LENGTHS:
        n = settings.samples(length)
        parties = PARTIES if length <= LONGEST_OF_PEERS else {"ours": ours}
        lengths.append(
            {"samples": n, **_measure_at(n, 0, parties, settings.rounds if length < 1e7 else min(settings.rounds, 3))}
        )
    n = settings.samples(1.44e6)
    counts = [{"samples": n, **_measure_at(n, count, PARTIES, min(settings.rounds, 3))} for count in COUNTS]
    return {"lengths": lengths, "counts": counts}


def _measure_at(n: int, count: int, parties: dict[str, Callable[..., Any]], rounds: int) -> dict[str, Any]:
    rate, grid = noise(n), log_spaced(n, count) if count else octaves(n)
    calls = {name: _call(call, rate, grid) for name, call in parties.items()}
    seconds = turns(calls, rounds)
    del rate, calls
    memory = {}
    for name in parties:
        command = [sys.executable, "-m", "benches.growth", name, str(n), str(count)]
        memory[name] = int(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return {"taus": len(grid.sizes), "seconds": seconds, "memory": memory}


def _call(call: Callable[..., Any], *arguments: Any) -> Callable[[], Any]:
    return lambda: call(*arguments)


def write(measured: dict[str, Any]) -> tuple[list[str], list[Gate]]:
    """Text of the section of the page, and its targets."""
    lines = [
        "## Growth",
        "",
        *text.prose(
            "One axis, one thread. Memory is the peak memory of a call without its input samples. sigmatau needs the phase,",
            "eight bytes per sample. `make bench PARTS=growth`.",
        ),
        "![Time against the number of samples](figures/performance-samples.svg)",
        "",
        *_table("samples", [text.number(row["samples"]) for row in measured["lengths"]], measured["lengths"]),
        "![Time against the number of averaging times](figures/performance-taus.svg)",
        "",
        *text.prose(
            f"{text.number(measured['counts'][0]['samples'])} samples. Averaging times that round to the same number",
            "of samples",
            "count once.",
        ),
        *_table("averaging times", [str(row["taus"]) for row in measured["counts"]], measured["counts"]),
    ]
    return lines, []


def _table(label: str, firsts: Sequence[str], rows: Sequence[dict[str, Any]]) -> list[str]:
    cells = []
    for first, row in zip(firsts, rows, strict=True):
        line = [first]
        for name in ("ours", *PEERS):
            if name in row["seconds"]:
                line.append(f"{text.seconds(row['seconds'][name])}, {text.size(row['memory'][name])}")
            else:
                line.append("not run")
        cells.append(line)
    return text.table([label, "sigmatau", *PEERS], cells)


def draw(measured: dict[str, Any], folder: Path) -> None:
    """Draw both figures."""
    taus = [row["taus"] for row in measured["counts"]]
    samples = [row["samples"] for row in measured["lengths"]]
    _figure(
        samples,
        measured["lengths"],
        "samples, octaves of averaging times",
        folder / "performance-samples.svg",
        growing=True,
    )
    _figure(taus, measured["counts"], "averaging times", folder / "performance-taus.svg", growing=False)


def _figure(x: Sequence[float], rows: Sequence[dict[str, Any]], label: str, path: Path, *, growing: bool) -> None:
    import matplotlib as mpl
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.4, 3.6), layout="constrained")
    panels = figure.subplots(1, 2)
    for ax, key, factor, title in zip(
        panels, ("seconds", "memory"), (1, 1e-6), ("time [s]", "memory beyond the samples [MB]"), strict=True
    ):
        for name, colour in COLOURS.items():
            points = [(a, factor * row[key][name]) for a, row in zip(x, rows, strict=True) if row[key].get(name)]
            if points:
                line = "o--" if name == "numba" else "o-"  # dashed, because its memory equals that of sigmatau
                memory_name = "sigmatau" if name == "ours" else name
                ax.plot(*zip(*points, strict=True), line, color=colour, markersize=4, linewidth=1.2, label=memory_name)
        ax.set_xscale("log")
        if key == "seconds" or growing:
            ax.set_yscale("log")
        else:
            ax.set_ylim(bottom=0)
        ax.set_xlabel(label)
        ax.set_ylabel(title)
        ax.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
    panels[0].legend(fontsize=8.5)
    with mpl.rc_context({"svg.hashsalt": "sigmatau"}):  # makes the file reproducible
        figure.savefig(path, metadata={"Date": None})


if __name__ == "__main__":
    print(peak(sys.argv[1], int(sys.argv[2]), int(sys.argv[3])))
