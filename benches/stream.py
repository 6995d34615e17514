"""Accumulator: CPU time per sample and growth of memory, in a separate process.

``python -m benches.stream SAMPLES GRID`` prints both.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import time
from typing import Any

import numpy as np

from benches import text
from benches.measure import Settings, status_bytes
from benches.text import Gate
from sigmatau import Accumulator
from sigmatau.estimators.deviation_kinds import TauGrid

CHUNK = 1 << 16
GRIDS: tuple[TauGrid, ...] = ("octave", "half")


def push(samples: int, grid: TauGrid) -> dict[str, float]:
    """CPU time of pushing alone, and growth of memory that is not mapped from files."""
    rng = np.random.default_rng(samples)
    chunk = rng.standard_normal(CHUNK)
    sums = Accumulator("gyro_x", rate=200, taus=grid, long="strided")
    sums.push(chunk)  # excludes imports and first allocations
    sums = Accumulator("gyro_x", rate=200, taus=grid, long="strided")
    before = largest = status_bytes("RssAnon")
    used = 0.0
    for k, start in enumerate(range(0, samples, CHUNK)):
        rng.standard_normal(out=chunk)
        piece = chunk[: samples - start]
        begun = time.process_time()
        sums.push(piece)
        used += time.process_time() - begun
        if k % 64 == 0:
            largest = max(largest, status_bytes("RssAnon"))
    largest = max(largest, status_bytes("RssAnon"))
    if sums.n != samples:
        raise AssertionError(f"{sums.n} samples of {samples} arrived")
    return {"cpu": used, "growth": largest - before}


def measure(settings: Settings) -> dict[str, Any]:
    """Every length with every grid."""
    # What is quick has more rounds; all take turns.
    rounds = {1e7: settings.rounds}
    if not settings.is_trial:
        rounds |= {1e8: min(settings.rounds, 3)} | ({1e9: 1} if settings.billion else {})
    runs: dict[tuple[TauGrid, float], list[dict[str, float]]] = {(g, length): [] for g in GRIDS for length in rounds}
    for k in range(settings.rounds):
        for (grid, length), done in runs.items():
            if k < rounds[length]:
                command = [sys.executable, "-m", "benches.stream", str(settings.samples(length)), grid]
                output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
                done.append(json.loads(output))
    rows = []
    for (grid, length), done in runs.items():
        cpu, growth = statistics.median(run["cpu"] for run in done), max(run["growth"] for run in done)
        rows.append({"samples": settings.samples(length), "grid": grid, "cpu": cpu, "growth": growth})
    return {"rows": rows}


def write(measured: dict[str, Any]) -> tuple[list[str], list[Gate]]:
    """Text of the section of the page, and its targets."""
    rows, reached = [], []
    first: dict[str, float] = {}
    names = {"octave": "octaves", "half": "half octaves"}
    for row in measured["rows"]:
        grid, each = names[row["grid"]], 1e9 * row["cpu"] / row["samples"]
        change = each / first.setdefault(grid, each) - 1
        rows.append(
            [text.number(row["samples"]), grid, f"**{each:.2f} ns**", f"{change:+.1%}", text.size(row["growth"])]
        )
    longest = max(row["samples"] for row in measured["rows"])
    for row in measured["rows"]:
        if row["samples"] == longest:
            each, label = 1e9 * row["cpu"] / longest, f"{text.number(longest)} samples, {names[row['grid']]}"
            change = max(each / first[names[row["grid"]]] - 1, 0.0)
            reached += [
                text.at_most(f"{label}, CPU time per sample", each, 8, "ns"),
                text.at_most(f"{label}, memory", row["growth"] / 1e6, 200, "MB"),
                text.at_most(f"{label}, growth of the time per sample", 100 * change, 10, "%"),
            ]
    lines = [
        "## A stream in bounded memory",
        "",
        *text.prose(
            f'`Accumulator(…, long="strided")`, one channel, pushed in chunks of {text.number(CHUNK)} samples. The time to',
            "simulate them is not included. Memory is the growth of the process without mapped files. `make",
            "bench PARTS=stream`, with 10⁹ samples",
            "`BILLION=1`.",
        ),
        *text.table(["samples", "averaging times", "CPU time per sample", "change", "memory"], rows),
        *text.gates(reached),
    ]
    return lines, reached


if __name__ == "__main__":
    print(json.dumps(push(int(sys.argv[1]), sys.argv[2])))  # type: ignore[arg-type]
