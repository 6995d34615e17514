"""The workbench against `sigmatau analyze` on the same log: time to the first page and picture, CPU time, and memory.

    python -m benches.workbench                        # a simulated log of two hours, six axes at 100 Hz
    python -m benches.workbench static.csv --rate 100  # another log

Prints its measurements as JSON. Memory is the largest sum of the proportional set sizes of a program's processes.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sigmatau import NoiseModel, simulate_to

_WINDOW = "0s:1200s"
_POLLED = 0.02  # interval of the memory measurements, and of questions for the state of an analysis [s]
_TICKS = os.sysconf("SC_CLK_TCK")
_PROGRAM = [sys.executable, "-m", "sigmatau"]


class Watched:
    """A program and its processes: CPU time, and the largest memory while it is watched."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self.process = process
        self.peak = 0.0  # [MB]
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._watch)
        self._thread.start()

    def end(self) -> None:
        """Stop watching, and the program."""
        self._ended.set()
        self._thread.join()
        self.process.terminate()
        self.process.wait()

    def cpu(self) -> float:
        """CPU time of the processes that run. [s]"""
        total = 0
        for pid in self._processes(self.process.pid):
            fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
            total += int(fields[11]) + int(fields[12])
        return total / _TICKS

    def _watch(self) -> None:
        while not self._ended.wait(_POLLED):
            self.peak = max(self.peak, sum(map(_memory, self._processes(self.process.pid))))

    def _processes(self, pid: int) -> list[int]:
        pids = [pid]
        try:
            for task in Path(f"/proc/{pid}/task").iterdir():
                for child in (task / "children").read_text(encoding="utf-8").split():
                    pids += self._processes(int(child))
        except OSError:  # the process has ended
            pass
        return pids


def _memory(pid: int) -> float:
    """Proportional set size of a process; 0 if it has ended. [MB]"""
    try:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text(encoding="utf-8").splitlines()
    except OSError:
        return 0.0
    return next((int(line.split()[1]) / 1000 for line in lines if line.startswith("Pss:")), 0.0)


def analyze(log: Path, options: dict[str, str], *further: str) -> tuple[float, float]:
    """CPU time and memory of ``sigmatau analyze``. [s, MB]"""
    words = [word for name, value in options.items() for word in (f"--{name}", value)]
    before = os.times()
    process = subprocess.Popen(
        [*_PROGRAM, "analyze", str(log), *words, *further, "-q"],
        stdout=subprocess.DEVNULL,
        text=True,
    )
    watched = Watched(process)
    if process.wait():
        raise SystemExit(f"analyze ends with exit code {process.returncode}")
    watched.end()
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system, watched.peak


def measure(log: Path, options: dict[str, str]) -> dict[str, float]:
    """The measurements of a log: wall times and CPU ratios [s, 1], and the ratio of the memory [1]."""
    _, alone = analyze(log, options)
    window_cpu, _ = analyze(log, options, "--window", _WINDOW)
    begun = time.monotonic()
    process = subprocess.Popen(
        [*_PROGRAM, "app", str(log.parent), "--no-browser", "-q"], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    address = process.stdout.readline().strip()
    urllib.request.urlopen(address).read()
    made = {"first page [s]": time.monotonic() - begun}
    watched = Watched(process)

    def ask(path: str, body: object = None, raw: bytes | None = None) -> Any:
        data = raw if raw is not None else None if body is None else json.dumps(body).encode()
        with urllib.request.urlopen(urllib.request.Request(f"{address}api/{path}", data=data)) as answer:
            return json.loads(answer.read())

    def picture(source: Callable[[], dict[str, Any]]) -> float:
        begun = time.monotonic()
        body = {**source(), "options": options}
        ask("open", body)
        ask("envelope", {**body, "width": 1200})
        return time.monotonic() - begun

    try:
        made["first picture by path [s]"] = picture(lambda: {"path": str(log)})
        _analysed(ask, log, options)
        made["memory [of analyze]"] = watched.peak / alone
        before = watched.cpu()
        _analysed(ask, log, {**options, "window": _WINDOW})
        made["CPU of a part of 20 min [of analyze]"] = (watched.cpu() - before) / window_cpu
        raw = log.read_bytes()
        name = f"log{log.suffix}"
        made["first picture uploaded [s]"] = picture(lambda: {"file": ask(f"upload?name={name}", raw=raw)["file"]})
    finally:
        watched.end()
    return {name: round(value, 3) for name, value in made.items()}


def _analysed(ask: Callable[..., Any], log: Path, options: dict[str, str]) -> None:
    job = ask("analyze", {"path": str(log), "options": options})["job"]
    while ask(f"jobs/{job}")["state"] in ("waiting", "running"):
        time.sleep(_POLLED)


def main() -> None:
    """Measure a log and print the measurements."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    parser.add_argument("log", type=Path, nargs="?")
    parser.add_argument("--rate")
    arguments = parser.parse_args()
    options = {} if arguments.rate is None else {"rate": arguments.rate}
    with tempfile.TemporaryDirectory() as folder:
        log = arguments.log
        if log is None:
            log = Path(folder) / "two_hours.csv"
            channels = {f"gyro_{axis}": {"random_walk": 1e-4} for axis in "xyz"}
            channels |= {f"accel_{axis}": {"random_walk": 1e-3} for axis in "xyz"}
            simulate_to(log, NoiseModel(channels=channels), duration=7200, rate=100, rng=1)
        print(json.dumps(measure(log.resolve(), options), indent=1))


if __name__ == "__main__":
    main()
