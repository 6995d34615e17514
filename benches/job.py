"""The main job: `sigmatau analyze` of logs as whole processes, and the time of its parts."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from benches import text
from benches.job_logs import LOGS, OPTIONS, RATE, write_logs
from benches.measure import Settings
from benches.processes import bare_curves, compiled, launch
from benches.text import Gate

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
        others[0] += before[0]
        others[1] += before[1]
        found = function(*args, **options)
        lap(what)
        return found
    setattr(analysis, name, call)
import sigmatau.cli.analyze
from sigmatau import analyze
from sigmatau.analysis import stages as analysis
from sigmatau.io.read import read
lap("start of Python, imports")
record = read(sys.argv[1], **json.loads(sys.argv[2]))
lap("reading")
others = [0.0, 0.0]
timed("rest", "whether the sensor rests")
timed("examine", "checks of samples and spectra")
timed("compute_curves", "Allan deviations")
timed("in_threads", "fits")
timed("check_fits", "checks with the fits")
found = analyze(record)
lap("the rest of it")
spent["the rest of it"] = [a + b for a, b in zip(spent["the rest of it"], others)]
found.overview(), json.dumps(found.to_dict())
lap("table, checksum, JSON")
print(json.dumps(spent))
"""


def measure(settings: Settings) -> dict[str, Any]:
    """Measure whole processes in turns, and the parts of some, beside the bare curves of other packages.

    The environment variable EARLIER names the Python of another checkout, whose `analyze` takes its turns too.
    """
    compiled()
    rounds, earlier = min(settings.rounds, 5), os.environ.get("EARLIER")
    measured: dict[str, Any] = {"samples": settings.samples(720_000), "processes": {}}
    runs: dict[str, list[list[float]]] = {}
    parts: dict[str, list[dict[str, list[float]]]] = {}
    with tempfile.TemporaryDirectory(prefix="sigmatau-bench-") as folder:
        arguments_of_logs = write_logs(Path(folder), settings)
        curves = {"clean": bare_curves(arguments_of_logs["clean"][0])}
        if "real" in arguments_of_logs:
            curves["real"] = bare_curves(arguments_of_logs["real"][0], has_time=False)
        for name, arguments in arguments_of_logs.items():
            place = Path(folder) / "results" / (name if "folder" in name else f"{name}.json")
            words = ["-m", "sigmatau", "analyze", *arguments, "--json", str(place), "--quiet"]
            commands = {name: [sys.executable, *words]}
            if earlier:
                commands[f"{name}, earlier"] = [earlier, *words]
            if name in curves:
                commands[f"{name}, curves"] = [sys.executable, *curves[name]]
            for _ in range(rounds if name in ("clean", "disturbed") else min(rounds, 3)):
                for key, command in commands.items():
                    # A few seconds of motion are not at rest.
                    runs.setdefault(key, []).append(launch(command, codes=(0, 5)))
                if name in _WITH_PARTS:
                    parts.setdefault(name, []).append(_measure_parts(arguments[0], OPTIONS.get(name, {})))
    for name, rows in runs.items():
        measured["processes"][name] = [statistics.median(column) for column in zip(*rows, strict=True)]
    measured["parts"] = {
        name: {part: [statistics.median(times[part][k] for times in each) for k in (0, 1)] for part in each[0]}
        for name, each in parts.items()
    }
    measured["earlier"] = _commit(earlier) if earlier else None
    return measured


def _commit(python: str) -> str:
    """Short name of the commit of the checkout that the Python at this path belongs to."""
    command = ["git", "-C", str(Path(python).absolute().parent), "log", "-1", "--format=%h of %as"]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def _measure_parts(log: str, options: dict[str, Any]) -> dict[str, list[float]]:
    command = [sys.executable, "-c", _PARTS, log, json.dumps(options)]
    spent_ = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return {part: [float(value) for value in spent] for part, spent in spent_.items()}


_WITH_PARTS = ("clean", "disturbed", "day", "real")  # logs whose parts are timed

_NAMES = {
    "clean": "`sigmatau analyze`, a clean log",
    "clean, curves": "pandas + allantools, six bare curves of the clean log",
    "disturbed": "the log with a knock and 20 spikes",
    "real": "2.8 hours of an ADIS16405, 100 Hz, compressed text",
    "real, curves": "pandas + allantools, six bare curves of the ADIS16405",
    "moving": "50 000 rows with motion, a step and spikes",
    "people": "185 000 rows of a navigation-grade gyro, nudged 30 times",
    "channels": "60 channels of 600 samples",
    "folder, one": f"a folder of {LOGS} logs of an hour, `--jobs 1 --threads 1`",
    "folder, two": "the same folder, `--jobs 2`",
    "day": "24 hours, six axes, 200 Hz, NPY",
}


def write(measured: dict[str, Any]) -> tuple[list[str], list[Gate]]:
    """Text of the section of the page, and its targets."""
    processes, parts, earlier = measured["processes"], measured["parts"], measured["earlier"]
    cells = [
        [part, *(" / ".join(text.seconds(value) for value in parts[name][part]) for name in parts)]
        for part in parts["clean"]
    ]
    reached = _targets(processes)
    samples = text.number(measured["samples"])
    return [
        "## The main job",
        "",
        *text.prose(
            f"A text log of {samples} rows of 7 columns at {RATE:g} Hz to the table and the JSON file",
            "of `sigmatau analyze`, as whole processes. `make bench PARTS=job`.",
            f"Earlier is commit {earlier}, in turns with today's (`EARLIER=…/.venv/bin/python`)." if earlier else "",
        ),
        *_table(processes, with_earlier=earlier is not None),
        "Parts of it, in the order of the work, as wall time / CPU time:",
        "",
        *text.table(["", *parts], cells),
        *text.gates(reached),
    ], reached


def _table(processes: dict[str, list[float]], *, with_earlier: bool) -> list[str]:
    head = ["", "wall time", "CPU time", "peak memory", *(["CPU time, earlier", "today/earlier"] * with_earlier)]
    rows = []
    for name, title in _NAMES.items():
        if name in processes:
            wall, cpu, peak = processes[name]
            row = [title, text.seconds(wall), text.seconds(cpu), text.size(peak)]
            if f"{name}, earlier" in processes:
                before = processes[f"{name}, earlier"][1]
                row += [text.seconds(before), f"**{cpu / before:.2f}**"]
            rows.append(row + [""] * (len(head) - len(row)))
    return text.table(head, rows)


def _targets(processes: dict[str, list[float]]) -> list[Gate]:
    """Targets as ratios of wall time to the bare curves of other packages and of CPU time to an earlier commit."""

    def of_wall(name: str, base: str) -> float:
        return processes[name][0] / processes[base][0]

    targets = [
        text.at_most("main job over six bare curves", of_wall("clean", "clean, curves"), 0.2, "times"),
        text.at_most("with a knock and 20 spikes, the same", of_wall("disturbed", "clean, curves"), 0.4, "times"),
    ]
    if "real" in processes:
        targets.append(
            text.at_most("ADIS16405 over its six bare curves", of_wall("real", "real, curves"), 0.3, "times")
        )
    targets.append(text.at_most("60 channels of 600 samples, CPU time", processes["channels"][1], 1.5, "s"))
    for name, title in (("moving", "50 000 rows with motion"), ("people", "185 000 rows with people")):
        if f"{name}, earlier" in processes:
            ratio = processes[name][1] / processes[f"{name}, earlier"][1]
            targets.append(text.at_most(f"{title}, CPU time over earlier", ratio, 0.5, "times"))
    return [
        *targets,
        text.at_most("a log of a folder, `--jobs 2`", processes["folder, two"][0] / LOGS, 0.35, "s"),
        text.at_least("`--jobs 2` over `--jobs 1`", of_wall("folder, one", "folder, two"), 1.7),
        text.at_most("24 hours, six axes, 200 Hz, NPY", processes["day"][0], 8.0, "s"),
        text.at_most("24 hours, memory", processes["day"][2] / 1e9, 1.2, "GB"),
    ]
