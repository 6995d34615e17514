"""Many tiny logs through one scheduler: whether the time per log and the memory of the command stay bounded.

    python -m benches.fleet_tiny --logs 10000             # logs of one axis, 600 samples at 10 Hz, analysed by two workers
    python -m benches.fleet_tiny --logs 100000 --canned   # the same files; a worker analyses one and repeats its result

With ``--canned`` the workers cost nothing, so that the command (list of logs, scheduler, client and store) is the limit.
Takes ``--folder`` for its files, which remain, and prints its measurements as JSON.
"""

from __future__ import annotations

import argparse
import io
import json
import os
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import psutil

SAMPLES, UNITS = 600, 1000
OPTIONS = ("--rate", "10", "--channels", "gyro_x=1", "--unit", "gyro=rad/s")
CANNED = '''
import sys

def repeat_results():
    """Analyse the first log of each worker; others get its result under their own names."""
    from dataclasses import replace
    from pathlib import Path
    from sigmatau.lab.fleet import tasks
    from sigmatau.lab.store.rows import identity
    analysed, results = tasks._analysed, []
    def repeated(log, job):
        if not results:
            results.append(analysed(log, job))
        place = Path(log.place)
        run = {**results[0].rows.run, "path": log.place, "name": place.name, "file_version": log.version, "sha256": None}
        unit = place.parent.name
        rows = replace(results[0].rows, unit=unit, run=run, identity=identity(unit, run))
        return replace(results[0], log=log, rows=rows)
    tasks._analysed = repeated

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == "sigmatau.lab.fleet.worker":
            sys.meta_path.remove(self)
            repeat_results()

sys.meta_path.insert(0, Finder())
'''


def make_logs(folder: Path, count: int) -> Path:
    """Write logs of white noise; existing logs are reused."""
    buffer = io.BytesIO()
    np.save(buffer, np.zeros((SAMPLES, 1), dtype=np.float32))
    head = buffer.getvalue()[: -4 * SAMPLES]
    for k in range(count):
        log = folder / f"unit{k % UNITS:03}" / f"log{k:06}.npy"
        if not log.exists():
            log.parent.mkdir(parents=True, exist_ok=True)
            x = 1e-3 * np.random.default_rng(k).standard_normal(SAMPLES)
            log.write_bytes(head + x.astype(np.float32).tobytes())
    return folder


def command(folder: Path, count: int, keep: str, *, canned: bool) -> tuple[list[str], dict[str, str]]:
    """Return the words and the environment of a command that analyses the logs into an empty store, ``tiny.db``."""
    logs, store = make_logs(folder / f"tiny{count}", count), folder / "tiny.db"
    for file in folder.glob("tiny.db*"):
        file.unlink()
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    if canned:
        (folder / "sitecustomize.py").write_text(CANNED)
        environment["PYTHONPATH"] = os.pathsep.join([str(folder), *sys.path])
    words = [sys.executable, "-m", "sigmatau", "fleet", "analyze", str(logs), "--store", str(store), *OPTIONS]
    return [*words, "--workers", "2", "--keep-curves", keep, "-q"], environment


def measure(folder: Path, count: int, keep: str, *, canned: bool) -> dict[str, Any]:
    """Run the command on an empty store, then again."""
    words, environment = command(folder, count, keep, canned=canned)
    store = folder / "tiny.db"
    result: dict[str, Any] = {"logs": count, "canned": canned, "keep_curves": keep}
    for name in ("first", "again"):
        begun = time.perf_counter()
        process = subprocess.Popen(words, env=environment)
        parent, cpu, memory, workers = psutil.Process(process.pid), 0.0, 0, 0.0
        by_worker: dict[int, float] = {}
        while process.poll() is None:
            try:
                used = parent.cpu_times()
                cpu, memory = used.user + used.system, max(memory, parent.memory_info().rss)
                for child in parent.children(recursive=True):
                    times = child.cpu_times()
                    by_worker[child.pid] = times.user + times.system
            except psutil.Error:
                pass
            time.sleep(0.2)
        workers = sum(by_worker.values())
        wall = time.perf_counter() - begun
        result[name] = {
            "exit_code": process.returncode,
            "wall": round(wall, 1),
            "wall a log, ms": round(1e3 * wall / count, 3),
            "CPU of the command": round(cpu, 1),
            "CPU of the command a log, ms": round(1e3 * cpu / count, 3),
            "CPU of the workers a log, ms": round(1e3 * workers / count, 3),
            "largest memory of the command, MB": round(memory / 1e6),
        }
    with closing(sqlite3.connect(store)) as base:
        result["runs"] = base.execute("SELECT count(*) FROM run WHERE current").fetchone()[0]
    result["store, kB a log"] = round(store.stat().st_size / 1e3 / count, 2)
    return result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--logs", type=int, default=1000)
    parser.add_argument("--keep-curves", default="all", choices=["all", "failed", "none"])
    parser.add_argument("--canned", action="store_true")
    parser.add_argument("--folder", type=Path, default=Path(".bench") / "fleet")
    options = parser.parse_args()
    folder = options.folder.absolute()
    folder.mkdir(parents=True, exist_ok=True)
    print(json.dumps(measure(folder, options.logs, options.keep_curves, canned=options.canned), indent=1))


if __name__ == "__main__":
    main()
