"""A fleet of logs, and a record too large for one process: costs of the distribution, and check that no result is lost.

    python -m benches.fleet overhead --logs 3000      # one process, two, and two workers: wall and CPU time
    python -m benches.fleet kill --logs 3000          # kill -9 of a worker, the scheduler and the client; ten damaged files
    python -m benches.fleet long --samples 1e9        # a Zarr record over workers of 600 MB, against the stream
    python -m benches.fleet cost                      # bytes, CPU and messages of a sample and of a log

Each takes ``--folder`` for its files, which remain, and prints its measurements as JSON. Logs are six axes at 100 Hz.
"""

from __future__ import annotations

import argparse
import json
import os
import pickle
import resource
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import psutil

from sigmatau import Accumulator

ROWS, RATE, UNITS = 60_000, 100.0, 50
AXES = tuple(f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz")
READING = {"rate": RATE, "channels": {"gyro": "1:3", "accel": "4:6"}, "unit": {"gyro": "rad/s", "accel": "m/s^2"}}
OPTIONS = ("--rate", "100", "--channels", "gyro=1:3,accel=4:6", "--unit", "gyro=rad/s,accel=m/s^2")
DAMAGED = 10


def make_logs(folder: Path, count: int) -> Path:
    """Write logs of units with noise and a slow walk; existing logs are reused."""
    for k in range(count):
        log = folder / f"unit{k % UNITS:02}" / f"log{k:05}.npy"
        if not log.exists():
            log.parent.mkdir(parents=True, exist_ok=True)
            rng = np.random.default_rng(k)
            x = 1e-3 * rng.standard_normal((ROWS, 6)) + np.cumsum(1e-6 * rng.standard_normal((ROWS, 6)), axis=0)
            x[:, 5] += 9.81
            np.save(log, x.astype(np.float32))
    return folder


def make_damaged(folder: Path) -> None:
    """Write ten unusable files."""
    folder.mkdir(parents=True, exist_ok=True)
    for k in range(DAMAGED):
        (folder / f"damaged{k}.npy").write_bytes(b"\x93NUMPY" + bytes([k]) * (50 + k))


def one_process(logs: Path, store: Path, *, share: int = 0, of: int = 1) -> None:
    """The work of a fleet, in a loop over all logs or over every `of`-th log."""
    from sigmatau.lab.fleet.logs import find
    from sigmatau.lab.fleet.stored import Stored
    from sigmatau.lab.fleet.tasks import FleetJob, analyse
    from sigmatau.lab.store.connect import open_engine
    from sigmatau.lab.store.naming import Naming

    job = FleetJob(reading=READING, settings={}, naming=Naming(folders=True))
    stored = Stored(open_engine(store), job.options)
    chosen_logs = find([str(logs)])[share::of]
    for first in range(0, len(chosen_logs), 200):
        outcomes = [outcome for log in chosen_logs[first : first + 200] for outcome in analyse([log], job)[0]]
        stored.add([outcome.rows for outcome in outcomes], [outcome.log for outcome in outcomes])


def fleet(logs: Path, store: Path, *further: object, **settings: str) -> subprocess.Popen[str]:
    """Start `sigmatau fleet analyze` in a separate process."""
    command = [sys.executable, "-m", "sigmatau", "fleet", "analyze", str(logs), "--store", str(store), *OPTIONS]
    return start(*command, *map(str, further), **settings)


def start(*command: str, **settings: str) -> subprocess.Popen[str]:
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", **settings}
    pipe = subprocess.PIPE
    return subprocess.Popen(command, env=environment, text=True, stdout=pipe, stderr=pipe, start_new_session=True)


@contextmanager
def timed(into: dict[str, Any], name: str) -> Iterator[None]:
    """Measure wall time, and CPU time of the processes that end meanwhile. [s]"""
    begun, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    yield
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    into[name] = {
        "wall": time.perf_counter() - begun,
        "cpu": after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime,
    }


def ended(process: subprocess.Popen[str], *codes: int) -> str:
    out, err = process.communicate()
    if process.returncode not in (codes or (0,)):
        raise RuntimeError(f"exit code {process.returncode}: {out}{err}")
    return out


def overhead(folder: Path, count: int) -> dict[str, Any]:
    """Compare two workers with one process, and with two processes that share the logs by hand; all from an empty store.

    Two busy cores are slower than one because of shared resources; the second comparison excludes this.
    """
    logs = make_logs(folder / f"logs{count}", count)
    result: dict[str, Any] = {"logs": count}
    for place in ("one", "half0", "half1", "two"):
        for file in folder.glob(f"{place}.db*"):
            file.unlink()

    def loop(place: str, share: int, of: int) -> subprocess.Popen[str]:
        words = (
            "one",
            "--folder",
            folder,
            "--logs",
            count,
            "--store",
            folder / f"{place}.db",
            "--share",
            share,
            "--of",
            of,
        )
        return start(sys.executable, "-m", "benches.fleet", *map(str, words))

    with timed(result, "one process"):
        ended(loop("one", 0, 1))
    with timed(result, "two processes"):
        for process in [loop(f"half{k}", k, 2) for k in range(2)]:
            ended(process)
    with timed(result, "two workers"):
        ended(fleet(logs, folder / "two.db", "--workers", 2))
    single, apart, two = result["one process"], result["two processes"], result["two workers"]
    result["workers over one process, CPU"] = two["cpu"] / single["cpu"] - 1
    result["workers over one process, wall"] = 2 * two["wall"] / single["wall"] - 1
    result["workers over two processes, CPU"] = two["cpu"] / apart["cpu"] - 1
    result["workers over two processes, wall"] = two["wall"] / apart["wall"] - 1
    result["differences"] = differences(folder / "one.db", folder / "two.db")
    return result


def results(store: Path) -> dict[str, Any]:
    from sigmatau.lab.store.store import Store

    content: dict[str, Any] = {}
    with Store(store, create=False) as opened:
        for row, _ in opened.results():
            result = opened.content(row["id"])
            path = result["source"]["path"]
            if path in content:
                raise AssertionError(f"{path} is there twice")
            content[path] = result
    return content


def differences(first: Path, second: Path) -> int:
    """Number of logs whose results differ in any digit, or that are missing in a store."""
    a, b = results(first), results(second)
    return sum(a.get(path) != b.get(path) for path in a.keys() | b.keys())


def rows(store: Path) -> int:
    if not store.exists():
        return 0
    with sqlite3.connect(f"file:{store}?mode=ro", uri=True) as connection:
        try:
            return int(connection.execute("SELECT count(*) FROM run").fetchone()[0])
        except sqlite3.OperationalError:  # not created yet
            return 0


def until(store: Path, count: int, process: subprocess.Popen[str]) -> None:
    """Wait until a store has `count` runs."""
    while rows(store) < count:
        if process.poll() is not None:
            raise RuntimeError("".join(process.communicate()))
        time.sleep(0.1)


def kill(folder: Path, count: int) -> dict[str, Any]:
    """Compare a run whose worker, scheduler and client are killed in turn with an undisturbed run."""
    logs = make_logs(folder / f"logs{count}", count)
    summary: dict[str, Any] = {"logs": count + DAMAGED}
    make_damaged(logs / "damaged")
    whole, store = folder / "whole.db", folder / "killed.db"
    for place in (whole, store):
        for file in place.parent.glob(f"{place.name}*"):
            file.unlink()
    ended(fleet(logs, whole, "--workers", 2), 1)
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{probe.getsockname()[1]}"
    scheduler = start(
        sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", address.rpartition(":")[2],
        "--no-dashboard", "--no-show",
    )  # fmt: skip
    workers = [
        start(sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-dashboard")
        for _ in range(2)
    ]
    process = fleet(logs, store, "--scheduler", address)
    until(store, count // 8, process)
    child = psutil.Process(workers[0].pid).children()[-1]
    child.kill()
    summary["worker killed at"] = rows(store)
    until(store, count // 3, process)
    scheduler.kill()
    summary["scheduler killed at"] = rows(store)
    summary["client said"] = process.communicate()[1].strip().splitlines()[-1]
    for victim in (*workers, scheduler):
        os.killpg(victim.pid, signal.SIGKILL)
        victim.communicate()
    process = fleet(logs, store, "--workers", 2)
    until(store, 2 * count // 3, process)
    process.kill()
    summary["client killed at"] = rows(store)
    process.communicate()
    summary["last run said"] = ended(fleet(logs, store, "--workers", 2), 0, 1).strip()
    summary["runs in the store"] = rows(store)
    summary["differences"] = differences(whole, store)
    summary["failed"] = sum("error" in result for result in results(store).values())
    return summary


def make_long(place: Path, samples: int) -> None:
    """Write a Zarr record of one axis, float32, in chunks of 10⁶ samples."""
    import zarr

    if place.exists():
        return
    group = zarr.open_group(str(place), mode="w", attributes={"rate": 2000.0})
    array = group.create_array(
        "gyro_x", shape=(samples,), chunks=(min(10**6, samples),), dtype="f4", attributes={"unit": "rad/s"}
    )
    for k, first in enumerate(range(0, samples, 10**7)):
        rng = np.random.default_rng(k)
        n = min(10**7, samples - first)
        array[first : first + n] = 1e-3 * rng.standard_normal(n, dtype=np.float32)


def long(folder: Path, samples: int) -> dict[str, Any]:
    """Compare a record on two workers of 600 MB with the stream over the same chunks in one process."""
    place, store = folder / f"long{samples}.zarr", folder / "long.db"
    summary: dict[str, Any] = {"samples": samples}
    make_long(place, samples)
    store.unlink(missing_ok=True)
    largest, over = 0, threading.Event()

    def watch(pid: int) -> None:
        nonlocal largest
        while not over.wait(0.05):
            try:
                memory = [child.memory_info().rss for child in psutil.Process(pid).children(recursive=True)]
            except psutil.Error:
                continue
            largest = max([largest, *memory])

    with timed(summary, "fleet"):
        command = ["fleet", "analyze", str(place), "--store", str(store), "--workers", "2", "--memory", "0.6"]
        process = start(sys.executable, "-m", "sigmatau", *command)
        threading.Thread(target=watch, args=(process.pid,), daemon=True).start()
        summary["said"] = ended(process, 0, 5).strip()
        over.set()
    summary["largest worker [MB]"] = largest / 1e6
    ((_, result),) = results(store).items()
    stored_curve = result["channels"]["gyro_x"]["curve"]
    import zarr

    array = zarr.open_array(str(place), path="gyro_x", mode="r")
    stream = Accumulator("gyro_x", rate=2000.0, long="strided")
    begun = time.perf_counter()
    for first in range(0, samples, 10**7):
        stream.push(np.asarray(array[first : first + 10**7], dtype=np.float64))
    summary["stream, wall"] = time.perf_counter() - begun
    curve = stream.snapshot()["gyro_x"].at(np.array(stored_curve["m"]))
    summary["largest relative difference"] = float(np.abs(np.square(stored_curve["adev"]) / curve.avar - 1).max())
    summary["stretches"] = next(
        finding["details"] for finding in result["findings"] if finding["code"] == "in_stretches"
    )
    return summary


def cost(folder: Path) -> dict[str, Any]:
    """Costs of a log (bytes of its rows, CPU of worker and client) and of a stretch (CPU and bytes per sample)."""
    from sigmatau.analysis import stretches
    from sigmatau.lab.fleet.logs import find
    from sigmatau.lab.fleet.stored import Stored
    from sigmatau.lab.fleet.tasks import FleetJob, analyse
    from sigmatau.lab.store.connect import open_engine
    from sigmatau.lab.store.naming import Naming

    logs = make_logs(folder / "logs30", 30)
    job = FleetJob(reading=READING, settings={}, naming=Naming(folders=True))
    store = folder / "cost.db"
    store.unlink(missing_ok=True)
    stored, logs_ = Stored(open_engine(store), job.options), find([str(logs)])
    analyse(logs_[:2], job)  # excludes imports
    begun = time.process_time()
    outcomes = analyse(logs_, job)[0]
    worker = (time.process_time() - begun) / len(logs_)
    message = len(pickle.dumps(outcomes)) / len(logs_)
    begun = time.process_time()
    for _ in range(10):
        pickle.loads(pickle.dumps(outcomes))
    pickled = (time.process_time() - begun) / 10 / len(logs_)
    begun = time.process_time()
    stored.add([outcome.rows for outcome in outcomes], [outcome.log for outcome in outcomes])
    written = (time.process_time() - begun) / len(logs_)
    size = sum(file.stat().st_size for file in folder.glob("cost.db*")) / len(logs_)
    place, n = folder / "long20000000.zarr", 20_000_000
    make_long(place, n)
    begun = time.process_time()
    sums = stretches.sum_stretch(str(place), {}, 0, n)
    summed = (time.process_time() - begun) / n
    state = pickle.dumps(sums)
    return {
        "log: CPU of the worker [s]": worker,
        "log: message [bytes]": message,
        "log: CPU of pickling both ways [s]": pickled,
        "log: CPU of the client for the store [s]": written,
        "log: store [bytes]": size,
        "log: file [bytes]": (ROWS * 6 * 4),
        "stretch: CPU a sample [s]": summed,
        "stretch: message of a channel [bytes]": len(state),
        "stretch: samples": n,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("one", "overhead", "kill", "long", "cost"))
    parser.add_argument("--folder", type=Path, default=Path("target/fleet"))
    parser.add_argument("--logs", type=int, default=3000)
    parser.add_argument("--samples", type=float, default=1e9)
    parser.add_argument("--store", type=Path, help="of one")
    parser.add_argument("--share", type=int, default=0, help="of the logs, for one")
    parser.add_argument("--of", type=int, default=1, help="shares, for one")
    chosen = parser.parse_args()
    chosen.folder.mkdir(parents=True, exist_ok=True)
    if chosen.what == "one":
        store = chosen.store or chosen.folder / "one.db"
        one_process(chosen.folder / f"logs{chosen.logs}", store, share=chosen.share, of=chosen.of)
        return
    if shutil.disk_usage(chosen.folder).free < 10e9:
        raise SystemExit("less than 10 GB are free")
    calls = {"overhead": overhead, "kill": kill}
    if chosen.what in calls:
        output = calls[chosen.what](chosen.folder, chosen.logs)
    else:
        output = long(chosen.folder, int(chosen.samples)) if chosen.what == "long" else cost(chosen.folder)
    print(json.dumps(output, indent=1))


if __name__ == "__main__":
    main()
