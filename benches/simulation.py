"""Simulation into a file: samples per second and peak memory, with a separate process per run."""

from __future__ import annotations

import statistics
import sys
import tempfile
from pathlib import Path
from typing import Any

from benches import text
from benches.measure import Settings
from benches.processes import launch
from benches.text import Gate

# N + B + K on one channel: samples, file.
_SIMULATION = """
import sys
from sigmatau import NoiseModel, simulate_to
noise = {"random_walk": 1e-4, "bias_instability": 1e-5, "rate_random_walk": 1e-6}
simulate_to(sys.argv[2], NoiseModel(channels={"gyro_x": noise}), duration=int(sys.argv[1]) / 200, rate=200, rng=1)
"""

LENGTHS = {".npy": 1e8, ".npz": 1e7, ".parquet": 1e7, ".csv": 1e7, ".csv.gz": 1e6}


def measure(settings: Settings) -> dict[str, Any]:
    """Measure every format; the long log in fewer rounds."""
    rows = []
    for ending, length in list(LENGTHS.items())[: 2 if settings.is_trial else None]:
        samples = settings.samples(length)
        used = []
        for _ in range(min(settings.rounds, 3)):
            with tempfile.TemporaryDirectory(prefix="sigmatau-bench-") as folder:
                file = Path(folder) / f"log{ending}"
                used.append(launch([sys.executable, "-c", _SIMULATION, str(samples), str(file)]))
                size = file.stat().st_size
        wall, cpu, peak = (statistics.median(column) for column in zip(*used, strict=True))
        rows.append({"ending": ending, "samples": samples, "wall": wall, "cpu": cpu, "peak": peak, "bytes": size})
    return {"rows": rows}


def write(measured: dict[str, Any]) -> tuple[list[str], list[Gate]]:
    """Text of the section of the page, and its targets."""
    rows, reached = [], []
    for row in measured["rows"]:
        speed = row["samples"] / row["wall"]
        cells = [f"**{speed / 1e6:.1f}**", text.seconds(row["wall"]), text.seconds(row["cpu"]), text.size(row["peak"])]
        rows.append([row["ending"], text.number(row["samples"]), *cells, text.size(row["bytes"])])
        if row["ending"] == ".npy":
            label = f"{text.number(row['samples'])} samples into .npy"
            reached += [
                text.at_most(f"{label}, wall time a sample", 1e9 / speed, 200, "ns"),
                text.at_most(f"{label}, peak memory", row["peak"] / 1e6, 300, "MB"),
            ]
    lines = [
        "## Simulation into a file",
        "",
        *text.prose(
            "`simulate_to`: random walk, bias instability (by poles) and rate random walk on one channel, with its stamps,",
            "as whole processes. `make bench PARTS=simulation`.",
        ),
        *text.table(
            ["format", "samples", "10⁶ samples a second", "wall time", "CPU time", "peak memory", "file"], rows
        ),
        *text.gates(reached),
    ]
    return lines, reached
