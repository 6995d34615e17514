"""Cost curves: CPU time against the numbers of samples, channels, disturbances, findings and logs, in one figure.

The power of a decade is the slope of the curve between a number and ten times as much, on logarithmic scales. A cost
proportional to the number has the power 1; a Fourier transform of n numbers, n log n, has 1 + 1/ln n, 1.06 for 10⁷.
"""

from __future__ import annotations

import itertools
import math
import resource
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benches import fleet_tiny, text
from benches.measure import Settings
from benches.text import Gate
from sigmatau import Accumulator, Analysis, Record, analyze
from sigmatau.findings.finding import Findings

LARGEST_POWER = 1.15  # n log n has 1.07 from 10⁶ to 10⁷; CPU times on a busy machine scatter by a tenth
ENOUGH = 1.0  # a quick call is repeated until its calls took so long together [s]
CHUNK = 1 << 20  # samples pushed into a stream at once
ROWS_OF_CHANNEL = 600
ROWS_OF_SPIKES = 2_000_000
TITLES = {
    "analyze": ("samples", "`sigmatau.analyze`, one channel in memory"),
    "stream": ("samples", "`Accumulator.push`, one channel"),
    "channels": ("channels", f"`sigmatau.analyze`, {ROWS_OF_CHANNEL} samples of each channel"),
    "spikes": ("spikes", f"`sigmatau.analyze`, {text.number(ROWS_OF_SPIKES)} samples with spikes"),
    "findings": ("findings", "a result with findings to JSON, back, and to text"),
    "logs": ("logs", "`sigmatau fleet analyze` without the analyses"),
}
COLOURS = ("#0072B2", "#D55E00")


def measure(settings: Settings) -> dict[str, Any]:
    """CPU time of each call at each number. [s]"""
    top = 5 if settings.is_trial else 7
    works: dict[str, tuple[list[int], Callable[[int, int], float]]] = {
        "analyze": (_decades(3, top + settings.billion), _analyze),
        "stream": (_decades(3, top + 1 + settings.billion), _push),
        "channels": (_decades(0, 3 if top == 7 else 1), _channels),
        "spikes": ([0, *_decades(0, 5 if top == 7 else 2)], _spikes),
        "findings": ([0, *_decades(0, 5 if top == 7 else 2)], _findings),
        "logs": (_decades(0, 4 + settings.billion if top == 7 else 1), _logs),
    }
    return {
        name: [{"number": number, "cpu": work(number, settings.rounds)} for number in numbers]
        for name, (numbers, work) in works.items()
    }


def _decades(first: int, last: int) -> list[int]:
    return [10**k for k in range(first, last + 1)]


def _cpu(call: Callable[[], Any], rounds: int) -> float:
    """Median CPU time of calls that take a second together; a single call may take longer. [s]"""
    used: list[float] = []
    while len(used) < rounds and sum(used) < ENOUGH:
        begun = time.process_time()
        call()
        used.append(time.process_time() - begun)
    return statistics.median(used)


def _noise(*seed_and_shape: int) -> NDArray[np.float64]:
    return 1e-3 * np.random.default_rng(seed_and_shape).standard_normal(seed_and_shape)


def _analyze(samples: int, rounds: int) -> float:
    record = Record.from_arrays(rate=100, gyro_x=_noise(samples))
    return _cpu(lambda: analyze(record), rounds)


def _push(samples: int, rounds: int) -> float:
    chunk = _noise(min(CHUNK, samples))

    def pushed() -> None:
        sums = Accumulator("gyro_x", rate=100, long="strided")
        for start in range(0, samples, CHUNK):
            sums.push(chunk[: samples - start])

    return _cpu(pushed, rounds)


def _channels(count: int, rounds: int) -> float:
    record = Record.from_arrays(rate=10, **{f"c{k}": x for k, x in enumerate(_noise(count, ROWS_OF_CHANNEL))})
    result: list[Analysis] = []
    used = _cpu(lambda: result.append(analyze(record)), rounds)
    if len(result[0].fits) != count:
        raise AssertionError(f"{len(result[0].fits)} channels of {count} are fitted")
    return used


def _spikes(count: int, rounds: int) -> float:
    x, rng = _noise(ROWS_OF_SPIKES), np.random.default_rng(count)
    places = 2 * rng.choice(x.size // 2, count, replace=False)
    x[places] += rng.choice([-1, 1], count) * rng.uniform(0.1, 1.0, count)
    record = Record.from_arrays(rate=100, gyro_x=x)
    result: list[Analysis] = []
    used = _cpu(lambda: result.append(analyze(record)), rounds)
    left_out = sum(finding.left_out or 0 for finding in result[0].findings)
    if not 0.99 * count <= left_out <= 1.01 * count + 10:
        raise AssertionError(f"{left_out} samples left out for {count} spikes")
    return used


def _findings(count: int, rounds: int) -> float:
    x = _noise(20_000)
    x[5000] = 1.0
    result = analyze(Record.from_arrays(rate=100, gyro_x=x))
    finding = result.findings[0]
    spans = (((k / 10, k / 10 + 0.01),) for k in range(count))
    result = replace(result, findings=Findings(replace(finding, spans=span) for span in spans))

    def written() -> None:
        if len(Analysis.from_json(result.to_json()).findings) != count:
            raise AssertionError(f"the JSON has not {count} findings")
        str(result)

    return _cpu(written, rounds)


def _logs(count: int, _rounds: int) -> float:
    """All processes of the command, whose workers analyse a log and repeat its result."""
    memory = Path("/dev/shm")  # some disks take minutes to remove 10⁵ files
    with tempfile.TemporaryDirectory(dir=memory if memory.is_dir() else None) as folder:
        words, environment = fleet_tiny.command(Path(folder), count, "none", canned=True)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(words, env=environment, check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def largest_power(rows: list[dict[str, Any]]) -> float:
    """Largest power of all decades of a curve."""
    pairs = [(a, b) for a, b in itertools.pairwise(rows) if a["number"] and a["cpu"] and b["cpu"]]
    return max(math.log(b["cpu"] / a["cpu"]) / math.log(b["number"] / a["number"]) for a, b in pairs)


def write(measured: dict[str, Any]) -> tuple[list[str], list[Gate]]:
    """Text of the section of the page, and its targets."""
    numbers = sorted({row["number"] for rows in measured.values() for row in rows})
    cells = []
    for name, rows in measured.items():
        of_number = {row["number"]: text.seconds(row["cpu"]) for row in rows}
        unit, title = TITLES[name]
        cells.append([title, unit, *(of_number.get(n, "") for n in numbers), f"**{largest_power(rows):.2f}**"])
    reached = [
        Gate(f"largest power of the cost, {title}", f"≤ {LARGEST_POWER}", f"{power:.2f}", power <= LARGEST_POWER)
        for name, (_, title) in TITLES.items()
        if name in measured
        for power in [largest_power(measured[name])]
    ]
    lines = [
        "## Cost curves",
        "",
        *text.prose(
            "CPU time of whole calls, in a warm process except for the fleet. The power is the largest slope between a",
            "number and ten times as much: 1 is a cost in proportion, and a Fourier transform of n numbers has 1 + 1/ln n,",
            "1.06 for 10⁷. In the fleet each worker analyses one log and repeats its result: the curve is that of the list",
            "of logs, the scheduler, the client and the store. `make bench PARTS=curves`; `BILLION=1` adds a decade of",
            "samples and of logs.",
        ),
        "![CPU time against samples, channels, findings and logs](figures/performance-curves.svg)",
        "",
        *text.table(["", "number of", *(_short(n) for n in numbers), "power"], cells),
        *text.gates(reached),
    ]
    return lines, reached


def _short(number: int) -> str:
    exponent = round(math.log10(number)) if number else 0
    return str(number) if number < 1000 else "10" + str(exponent).translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))


def draw(measured: dict[str, Any], folder: Path) -> None:
    """Draw a panel for each kind of number, with a line of power 1."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    panels = (("analyze", "stream"), ("channels",), ("spikes", "findings"), ("logs",))
    labels = ("samples", "channels", "spikes, findings", "logs")
    shown = {"analyze": "analysis", "stream": "stream", "spikes": "spikes", "findings": "findings of a result"}
    figure = Figure(figsize=(8.4, 6.0), layout="constrained")
    for ax, names, label in zip(figure.subplots(2, 2).flat, panels, labels, strict=True):
        for name, colour in zip(names, COLOURS, strict=False):
            rows = [row for row in measured[name] if row["number"]]
            x, y = [row["number"] for row in rows], [row["cpu"] for row in rows]
            ax.loglog(x, y, "o-", color=colour, markersize=4, linewidth=1.2, label=shown.get(name))
        x, y = [row["number"] for row in measured[names[0]] if row["number"]], measured[names[0]][-1]["cpu"]
        ax.loglog([x[0], x[-1]], [y * x[0] / x[-1], y], "--", color="#777777", linewidth=1.0, label="power 1")
        lowest = min(row["cpu"] for name in names for row in measured[name])
        ax.set_ylim(bottom=min(lowest / 2, y / 100))
        ax.set_xlabel(label)
        ax.set_ylabel("CPU time [s]")
        ax.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
        ax.legend(fontsize=8.5)
    with mpl.rc_context({"svg.hashsalt": "sigmatau"}):  # makes the file reproducible
        figure.savefig(folder / "performance-curves.svg", metadata={"Date": None})
