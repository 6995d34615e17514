"""A fleet of logs, and a record too large for one process: what the distribution costs, and that it loses nothing.

    python -m benches.fleet overhead --logs 3000      # one process, two, and two workers: wall and CPU time
    python -m benches.fleet kill --logs 3000          # kill -9 of a worker, the scheduler and the client; ten damaged files
    python -m benches.fleet long --samples 1e9        # a Zarr record over workers of 600 MB, against the stream
    python -m benches.fleet cost                      # bytes, CPU and messages of a sample and of a log

Each takes ``--folder`` for its files, which are kept, and prints what it measured as JSON. Logs are six axes at 100 Hz.
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
    """Logs of units with noise and a slow walk; those that are there are kept."""
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
    """Ten files that cannot be used."""
    folder.mkdir(parents=True, exist_ok=True)
    for k in range(DAMAGED):
        (folder / f"damaged{k}.npy").write_bytes(b"\x93NUMPY" + bytes([k]) * (50 + k))


def one_process(logs: Path, store: Path, *, share: int = 0, of: int = 1) -> None:
    """What a fleet does, in a loop over all logs, or over every `of`-th one."""
    from sigmatau.lab.fleet.logs import find
    from sigmatau.lab.fleet.stored import Stored
    from sigmatau.lab.fleet.tasks import FleetJob, analyse
    from sigmatau.lab.store.connect import open_engine
    from sigmatau.lab.store.naming import Naming

    job = FleetJob(reading=READING, settings={}, naming=Naming(folders=True))
    stored = Stored(open_engine(store), job.options)
    found = find([str(logs)])[share::of]
    for at in range(0, len(found), 200):
        outcomes = [one for log in found[at : at + 200] for one in analyse([log], job)[0]]
        stored.add([one.rows for one in outcomes], [one.log for one in outcomes])


def fleet(logs: Path, store: Path, *more: object, **settings: str) -> subprocess.Popen[str]:
    """`sigmatau fleet analyze` in a process of its own."""
    command = [sys.executable, "-m", "sigmatau", "fleet", "analyze", str(logs), "--store", str(store), *OPTIONS]
    return start(*command, *map(str, more), **settings)


def start(*command: str, **settings: str) -> subprocess.Popen[str]:
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", **settings}
    pipe = subprocess.PIPE
    return subprocess.Popen(command, env=environment, text=True, stdout=pipe, stderr=pipe, start_new_session=True)


@contextmanager
def timed(into: dict[str, Any], name: str) -> Iterator[None]:
    """Wall time, and CPU time of the processes that ended within. [s]"""
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
    """Two workers against one process, and against two processes that share the logs by hand; all from an empty store.

    Two busy cores are slower than one that is alone, by what they share: the second comparison leaves that out.
    """
    logs = make_logs(folder / f"logs{count}", count)
    said: dict[str, Any] = {"logs": count}
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

    with timed(said, "one process"):
        ended(loop("one", 0, 1))
    with timed(said, "two processes"):
        for process in [loop(f"half{k}", k, 2) for k in range(2)]:
            ended(process)
    with timed(said, "two workers"):
        ended(fleet(logs, folder / "two.db", "--workers", 2))
    one, apart, two = said["one process"], said["two processes"], said["two workers"]
    said["workers over one process, CPU"] = two["cpu"] / one["cpu"] - 1
    said["workers over one process, wall"] = 2 * two["wall"] / one["wall"] - 1
    said["workers over two processes, CPU"] = two["cpu"] / apart["cpu"] - 1
    said["workers over two processes, wall"] = two["wall"] / apart["wall"] - 1
    said["differences"] = differences(folder / "one.db", folder / "two.db")
    return said


def results(store: Path) -> dict[str, Any]:
    from sigmatau.lab.store.store import Store

    found: dict[str, Any] = {}
    with Store(store, create=False) as opened:
        for row, _ in opened.results():
            result = opened.content(row["id"])
            path = result["source"]["path"]
            if path in found:
                raise AssertionError(f"{path} is there twice")
            found[path] = result
    return found


def differences(one: Path, other: Path) -> int:
    """Logs whose results differ in any digit, or that only one store has."""
    a, b = results(one), results(other)
    return sum(a.get(path) != b.get(path) for path in a.keys() | b.keys())


def rows(store: Path) -> int:
    if not store.exists():
        return 0
    with sqlite3.connect(f"file:{store}?mode=ro", uri=True) as connection:
        try:
            return int(connection.execute("SELECT count(*) FROM run").fetchone()[0])
        except sqlite3.OperationalError:  # not made yet
            return 0


def until(store: Path, count: int, process: subprocess.Popen[str]) -> None:
    """Wait until a store has so many runs."""
    while rows(store) < count:
        if process.poll() is not None:
            raise RuntimeError("".join(process.communicate()))
        time.sleep(0.1)


def kill(folder: Path, count: int) -> dict[str, Any]:
    """A run whose worker, scheduler and client are killed in turn, against an undisturbed one."""
    logs = make_logs(folder / f"logs{count}", count)
    said: dict[str, Any] = {"logs": count + DAMAGED}
    make_damaged(logs / "damaged")
    whole, store = folder / "whole.db", folder / "killed.db"
    for place in (whole, store):
        for file in place.parent.glob(f"{place.name}*"):
            file.unlink()
    ended(fleet(logs, whole, "--workers", 2), 1)
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{one.getsockname()[1]}"
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
    said["worker killed at"] = rows(store)
    until(store, count // 3, process)
    scheduler.kill()
    said["scheduler killed at"] = rows(store)
    said["client said"] = process.communicate()[1].strip().splitlines()[-1]
    for one_of in (*workers, scheduler):
        os.killpg(one_of.pid, signal.SIGKILL)
        one_of.communicate()
    process = fleet(logs, store, "--workers", 2)
    until(store, 2 * count // 3, process)
    process.kill()
    said["client killed at"] = rows(store)
    process.communicate()
    said["last run said"] = ended(fleet(logs, store, "--workers", 2), 0, 1).strip()
    said["runs in the store"] = rows(store)
    said["differences"] = differences(whole, store)
    said["failed"] = sum("error" in result for result in results(store).values())
    return said


def make_long(place: Path, samples: int) -> None:
    """A Zarr record of one axis, float32, in chunks of 10⁶ samples."""
    import zarr

    if place.exists():
        return
    group = zarr.open_group(str(place), mode="w", attributes={"rate": 2000.0})
    array = group.create_array(
        "gyro_x", shape=(samples,), chunks=(min(10**6, samples),), dtype="f4", attributes={"unit": "rad/s"}
    )
    for k, at in enumerate(range(0, samples, 10**7)):
        rng = np.random.default_rng(k)
        n = min(10**7, samples - at)
        array[at : at + n] = 1e-3 * rng.standard_normal(n, dtype=np.float32)


def long(folder: Path, samples: int) -> dict[str, Any]:
    """A record over two workers of 600 MB, against the stream over the same chunks in one process."""
    place, store = folder / f"long{samples}.zarr", folder / "long.db"
    said: dict[str, Any] = {"samples": samples}
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

    with timed(said, "fleet"):
        command = ["fleet", "analyze", str(place), "--store", str(store), "--workers", "2", "--memory", "0.6"]
        process = start(sys.executable, "-m", "sigmatau", *command)
        threading.Thread(target=watch, args=(process.pid,), daemon=True).start()
        said["said"] = ended(process, 0, 5).strip()
        over.set()
    said["largest worker [MB]"] = largest / 1e6
    ((_, result),) = results(store).items()
    found = result["channels"]["gyro_x"]["curve"]
    import zarr

    array = zarr.open_array(str(place), path="gyro_x", mode="r")
    stream = Accumulator("gyro_x", rate=2000.0, long="strided")
    begun = time.perf_counter()
    for at in range(0, samples, 10**7):
        stream.push(np.asarray(array[at : at + 10**7], dtype=np.float64))
    said["stream, wall"] = time.perf_counter() - begun
    curve = stream.snapshot()["gyro_x"].at(np.array(found["m"]))
    said["largest relative difference"] = float(np.abs(np.square(found["adev"]) / curve.avar - 1).max())
    said["stretches"] = next(one["details"] for one in result["findings"] if one["code"] == "in_stretches")
    return said


def cost(folder: Path) -> dict[str, Any]:
    """Of a log: bytes of its rows, CPU of the worker and of the client; of a stretch: CPU and bytes of a sample."""
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
    stored, found = Stored(open_engine(store), job.options), find([str(logs)])
    analyse(found[:2], job)  # what is loaded once
    begun = time.process_time()
    outcomes = analyse(found, job)[0]
    worker = (time.process_time() - begun) / len(found)
    message = len(pickle.dumps(outcomes)) / len(found)
    begun = time.process_time()
    for _ in range(10):
        pickle.loads(pickle.dumps(outcomes))
    pickled = (time.process_time() - begun) / 10 / len(found)
    begun = time.process_time()
    stored.add([one.rows for one in outcomes], [one.log for one in outcomes])
    written = (time.process_time() - begun) / len(found)
    size = sum(file.stat().st_size for file in folder.glob("cost.db*")) / len(found)
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
        said = calls[chosen.what](chosen.folder, chosen.logs)
    else:
        said = long(chosen.folder, int(chosen.samples)) if chosen.what == "long" else cost(chosen.folder)
    print(json.dumps(said, indent=1))


if __name__ == "__main__":
    main()
