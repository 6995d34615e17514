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


_MODEL = NoiseModel(channels={f"{sensor}_{axis}": noise for sensor, noise in _NOISE.items() for axis in "xyz"})

_LOGS, _LOGS_APART = 40, 4  # number of logs in a folder, and of those with separate samples; the others are links
_REAL = Path("adis16405_static.csv.gz")  # log of the field data
_DAY, _DAY_RATE = 17_280_000, 200.0  # samples of 24 hours [Hz]

# Options of `read` for logs that need them; the parts of these are timed too.
_OPTIONS: dict[str, dict[str, Any]] = {
    "real": {"rate": RATE},
    "day": {
        "rate": _DAY_RATE,
        "channels": {"gyro": "1:3", "accel": "4:6"},
        "unit": {"gyro": "rad/s", "accel": "m/s^2"},
    },
}


def log(samples: int, *, disturbed: bool) -> Record:
    """Six axes at rest; if `disturbed`, with a knock and spikes as in most logs."""
    rng = np.random.default_rng(2)
    axes = _axes(samples, seed=1)
    places = rng.integers(samples // 4, samples, 20)
    for name, x in axes.items():
        if disturbed:
            x[places] += 40 * float(x.std()) * rng.standard_normal(len(places))
            x[samples // 5 : samples // 5 + 30] += 60 * float(x.std()) * np.exp(-np.arange(30) / 8)
        if name == "accel_z":
            x += 9.80665
    return Record.from_arrays(rate=RATE, **axes)


def _axes(samples: int, seed: int, rate: float = RATE) -> dict[str, Any]:
    record = simulate(_MODEL, duration=samples / rate, rate=rate, rng=seed)
    return {name: np.array(record.stream_of(name).column(name)) for name in _MODEL.channels}


def moving(samples: int) -> Record:
    """Six axes with a rotation for some time, spikes, and a step of the mean."""
    rng = np.random.default_rng(4)
    axes = _axes(samples, seed=3)
    start, stop = samples // 4, samples // 4 + samples // 16
    t = np.arange(stop - start) / RATE
    for name, x in axes.items():
        spread = float(x.std())
        x[rng.integers(samples // 4, samples, 15)] += 40 * spread * rng.standard_normal(15)
        size = 0.5 if name.startswith("gyro") else 1.0
        x[start:stop] += size * np.sin(2 * np.pi * (0.4 + 0.1 * rng.random()) * t)
        x[samples // 10 * 7 :] += 3 * spread
        if name == "accel_z":
            x += 9.80665
    return Record.from_arrays(rate=RATE, **axes)


def _other_logs(folder: Path, settings: Settings) -> dict[str, list[str]]:
    """Write further logs; return their arguments of `sigmatau analyze`."""
    write_log(moving(settings.samples(50_000)), str(folder / "moving.csv"))
    logs = folder / "logs"
    logs.mkdir()
    (folder / "results").mkdir()
    for k in range(_LOGS):
        if k < _LOGS_APART:
            record = Record.from_arrays(rate=RATE, **_axes(settings.samples(360_000), seed=10 + k))
            write_log(record, str(logs / f"{k:02}.csv"))
        else:
            os.link(logs / f"{k % _LOGS_APART:02}.csv", logs / f"{k:02}.csv")
    day = folder / "day.npy"
    n = settings.samples(_DAY)
    table = np.lib.format.open_memmap(day, mode="w+", dtype=np.float64, shape=(n, 6))
    for k, x in enumerate(_axes(n, seed=20, rate=_DAY_RATE).values()):
        table[:, k] = x
    table.flush()
    columns = [f"--{option}={_pairs(_OPTIONS['day'][option])}" for option in ("channels", "unit")]
    arguments_of_logs = {
        "moving": [str(folder / "moving.csv")],
        "folder, one": [str(logs), "--jobs", "1", "--threads", "1"],
        "folder, two": [str(logs), "--jobs", "2"],
        "day": [str(day), "--rate", f"{_DAY_RATE:g}", *columns],
    }
    real = Path(os.environ.get("SIGMATAU_FIELD_DATA", Path(__file__).parents[2] / "shared" / "data")) / _REAL
    return arguments_of_logs | ({"real": [str(real), "--rate", "100"]} if real.exists() else {})


def _pairs(options: dict[str, str]) -> str:
    return ",".join(f"{name}={value}" for name, value in options.items())


def measure(settings: Settings) -> dict[str, Any]:
    """Measure whole processes and their parts for a clean and a disturbed log, and six bare curves of other packages."""
    compiled()
    n, rounds = settings.samples(720_000), min(settings.rounds, 5)
    measured: dict[str, Any] = {"samples": n, "processes": {}}
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
                each.append(_measure_parts(str(Path(folder) / f"{name}.csv"), {}))
        for name, arguments in _other_logs(Path(folder), settings).items():
            output = [
                "--json",
                str(Path(folder) / "results" / f"{name}{'' if 'folder' in name else '.json'}"),
                "--quiet",
            ]
            command = [sys.executable, "-m", "sigmatau", "analyze", *arguments, *output]
            # A few seconds of motion are not at rest.
            runs[name] = [launch(command, codes=(0, 5)) for _ in range(min(rounds, 3))]
            if name in _OPTIONS:
                parts[name] = [_measure_parts(arguments[0], _OPTIONS[name]) for _ in range(min(rounds, 3))]
    for name, rows in runs.items():
        measured["processes"][name] = [statistics.median(column) for column in zip(*rows, strict=True)]
    measured["parts"] = {
        name: {part: [statistics.median(times[part][k] for times in each) for k in (0, 1)] for part in each[0]}
        for name, each in parts.items()
    }
    return measured


def _measure_parts(log: str, options: dict[str, Any]) -> dict[str, list[float]]:
    command = [sys.executable, "-c", _PARTS, log, json.dumps(options)]
    spent_ = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return {part: [float(value) for value in spent] for part, spent in spent_.items()}


_NAMES = {
    "clean": "`sigmatau analyze`, a clean log",
    "disturbed": "the same, with a knock and 20 spikes",
    "curves": "pandas + allantools, six bare curves of the clean log",
    "real": "2.8 hours of an ADIS16405, 100 Hz, compressed text",
    "moving": "50 000 rows with motion, a step and spikes",
    "folder, one": f"a folder of {_LOGS} logs of an hour, `--jobs 1 --threads 1`",
    "folder, two": "the same, `--jobs 2`",
    "day": "24 hours, six axes, 200 Hz, NPY",
}


# Number of logs, and longest time of one log. [s]
_LIMITS = {"real": (1, 1.5), "moving": (1, 1.0), "folder, two": (_LOGS, 0.35), "day": (1, 8.0)}
_ONE_LOG = {"folder, two": "a log of a folder, `--jobs 2`"}


def write(measured: dict[str, Any]) -> tuple[list[str], list[Gate]]:
    """Text of the section of the page, and its targets."""
    processes, parts = measured["processes"], measured["parts"]
    limits = [(name, count, limit) for name, (count, limit) in _LIMITS.items() if name in processes]
    rows = [
        [_NAMES[name], text.seconds(wall), text.seconds(cpu), text.size(peak)]
        for name, (wall, cpu, peak) in processes.items()
    ]
    cells = [
        [part, *(" / ".join(text.seconds(value) for value in parts[name][part]) for name in parts)]
        for part in parts["clean"]
    ]
    reached = [
        text.at_most("`sigmatau analyze`, two hours of six axes", processes["clean"][0], 1.0, "s"),
        text.at_most("the same over six bare curves", processes["clean"][0] / processes["curves"][0], 1.0, "times"),
        *(
            text.at_most(_ONE_LOG.get(name, _NAMES[name]), processes[name][0] / count, limit, "s")
            for name, count, limit in limits
        ),
        text.at_least("`--jobs 2` over `--jobs 1`", processes["folder, one"][0] / processes["folder, two"][0], 1.8),
        text.at_most("24 hours, memory", processes["day"][2] / 1e9, 2.5, "GB"),
    ]
    samples = text.number(measured["samples"])
    return [
        "## The main job",
        "",
        *text.prose(
            f"A text log of {samples} rows of 7 columns at {RATE:g} Hz to the table and the JSON file",
            "of `sigmatau analyze`, as whole processes. `make bench PARTS=job`.",
        ),
        *text.table(["", "wall time", "CPU time", "peak memory"], rows),
        "Parts of it, in the order of the work, as wall time / CPU time:",
        "",
        *text.table(["", *parts], cells),
        *text.gates(reached),
    ], reached
