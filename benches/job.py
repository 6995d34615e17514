"""The main job: `sigmatau analyze` of a log, as a whole process, and where its time goes."""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benches import text
from benches.measure import Settings
from benches.processes import bare_curves, compiled, launch
from benches.text import Gate
from sigmatau import NoiseModel, Record, simulate
from sigmatau.io.write import write as write_log

RATE = 100.0

_NOISE = {
    "gyro": {"random_walk": 2e-3, "bias_instability": 5e-5, "rate_random_walk": 1e-6},
    "accel": {"random_walk": 1e-3, "bias_instability": 2e-4, "rate_random_walk": 3e-6},
}

# Prints wall and CPU time of each part in order. The parts of `analyze` are functions of its module.
_PARTS = """
import json, sys, time
def now():
    return time.perf_counter(), time.process_time()
spent, last = {}, now()
def lap(what):
    global last
    here = now()
    spent[what] = [here[0] - last[0], here[1] - last[1]]
    last = here
def timed(name, what):
    function = getattr(analysis, name)
    def call(*args, **options):
        global last
        lap("the rest of it")
        before = spent.pop("the rest of it")
        rest[0] += before[0]
        rest[1] += before[1]
        found = function(*args, **options)
        lap(what)
        return found
    setattr(analysis, name, call)
import sigmatau.cli.analyze
from sigmatau import analysis
from sigmatau.io.read import read
lap("start of Python, imports")
record = read(sys.argv[1])
lap("reading")
rest = [0.0, 0.0]
timed("rest_of", "whether the sensor rests")
timed("examine", "checks of samples and spectra")
timed("curves_of", "Allan deviations")
timed("in_threads", "fits")
timed("check_fits", "checks with the fits")
found = analysis.analyze(record)
lap("the rest of it")
spent["the rest of it"] = [a + b for a, b in zip(spent["the rest of it"], rest)]
found.overview(), json.dumps(found.to_dict())
lap("table, checksum, JSON")
print(json.dumps(spent))
"""


def log(samples: int, *, disturbed: bool) -> Record:
    """Six axes at rest; with a knock and spikes, as most logs have."""
    model = NoiseModel(channels={f"{sensor}_{axis}": noise for sensor, noise in _NOISE.items() for axis in "xyz"})
    record = simulate(model, duration=samples / RATE, rate=RATE, rng=1)
    rng = np.random.default_rng(2)
    axes: dict[str, Any] = {name: np.array(record.stream_of(name).column(name)) for name in model.channels}
    at = rng.integers(samples // 4, samples, 20)
    for name, x in axes.items():
        if disturbed:
            x[at] += 40 * float(x.std()) * rng.standard_normal(len(at))
            x[samples // 5 : samples // 5 + 30] += 60 * float(x.std()) * np.exp(-np.arange(30) / 8)
        if name == "accel_z":
            x += 9.80665
    return Record.from_arrays(rate=RATE, **axes)


def measure(settings: Settings) -> dict[str, Any]:
    """Whole processes and their parts, of a clean log and of one with disturbances; six bare curves of other packages."""
    compiled()
    n, rounds = settings.samples(720_000), min(settings.rounds, 5)
    found: dict[str, Any] = {"samples": n, "processes": {}}
    with tempfile.TemporaryDirectory(prefix="sigmatau-bench-") as folder:
        commands = {}
        for name in ("clean", "disturbed"):
            path = str(Path(folder) / f"{name}.csv")
            write_log(log(n, disturbed=name == "disturbed"), path)
            output = ["--json", str(Path(folder) / f"{name}.json"), "--quiet"]
            commands[name] = ["-m", "sigmatau", "analyze", path, *output]
        commands["curves"] = bare_curves(str(Path(folder) / "clean.csv"))
        runs: dict[str, list[list[float]]] = {name: [] for name in commands}
        parts: dict[str, list[dict[str, list[float]]]] = {"clean": [], "disturbed": []}
        for _ in range(rounds):
            for name, arguments in commands.items():
                runs[name].append(launch([sys.executable, *arguments]))
            for name, each in parts.items():
                command = [sys.executable, "-c", _PARTS, str(Path(folder) / f"{name}.csv")]
                each.append(json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout))
    for name, rows in runs.items():
        found["processes"][name] = [statistics.median(column) for column in zip(*rows, strict=True)]
    found["parts"] = {
        name: {part: [statistics.median(one[part][k] for one in each) for k in (0, 1)] for part in each[0]}
        for name, each in parts.items()
    }
    return found


_NAMES = {
    "clean": "`sigmatau analyze`, a clean log",
    "disturbed": "the same, with a knock and 20 spikes",
    "curves": "pandas + allantools, six bare curves of the clean log",
}


def write(found: dict[str, Any]) -> tuple[list[str], list[Gate]]:
    """The section of the page."""
    processes, parts = found["processes"], found["parts"]
    rows = [
        [_NAMES[name], text.seconds(wall), text.seconds(cpu), text.size(peak)]
        for name, (wall, cpu, peak) in processes.items()
    ]
    cells = [[part, *(text.seconds(value) for name in parts for value in parts[name][part])] for part in parts["clean"]]
    reached = [
        text.at_most("`sigmatau analyze`, two hours of six axes", processes["clean"][0], 1.0, "s"),
        text.at_most("the same over six bare curves", processes["clean"][0] / processes["curves"][0], 1.0, "times"),
    ]
    return [
        "## The main job",
        "",
        *text.prose(
            f"A text log of {text.number(found['samples'])} rows of 7 columns at {RATE:g} Hz to the table and the JSON file",
            "of `sigmatau analyze`, as whole processes. `make bench PARTS=job`.",
        ),
        *text.table(["", "wall time", "CPU time", "peak memory"], rows),
        "Parts of it, in the order of the work:",
        "",
        *text.table(["", "clean: wall time", "CPU time", "disturbed: wall time", "CPU time"], cells),
        *text.gates(reached),
    ], reached
