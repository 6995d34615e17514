"""Logs, processes and stores for the tests of a fleet."""

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from conftest import ROOT
from known import seed_of

READING = ("--rate", "100", "--channels", "gyro=1:3", "--unit", "gyro=rad/s")
DAMAGED = 10

# Code that every worker runs at its start: it records the logs that it reads, waits, and ends at logs named "poison";
# the second stretch of a record ends its worker once.
HOOK = '''
import os, signal, sys, time

def told():
    import sigmatau.io.read as module
    original = module.read
    def read(path, **options):
        with open(os.environ["FLEET_SEEN"], "a") as seen:
            seen.write(f"{os.getpid()} {os.path.basename(path)}\\n")
        time.sleep(float(os.environ.get("FLEET_PAUSE", "0")))
        if "poison" in os.path.basename(path) and os.environ.get("FLEET_HEALED") is None:
            os.kill(os.getpid(), signal.SIGKILL)
        return original(path, **options)
    module.read = read
    if "FLEET_VALUES" in os.environ:
        import sigmatau.analysis.stretches as stretches
        stretches._VALUES = int(os.environ["FLEET_VALUES"])
        whole = stretches._unread
        def unread(place, reading):
            caller = sys._getframe(1)
            if caller.f_code.co_name == "sum_stretch":
                with open(os.environ["FLEET_SEEN"], "a") as seen:
                    seen.write(f"{os.getpid()} {caller.f_locals['start']}:{caller.f_locals['stop']}\\n")
                if caller.f_locals["start"] and not os.path.exists("killed"):
                    open("killed", "w").close()
                    os.kill(os.getpid(), signal.SIGKILL)
            return whole(place, reading)
        stretches._unread = unread

class Finder:
    """Patches the reader when it is imported."""
    def find_spec(self, name, path=None, target=None):
        if name != "sigmatau.lab.fleet.tasks":
            return None
        sys.meta_path.remove(self)
        told()
        return None

sys.meta_path.insert(0, Finder())
'''


def make_logs(folder, count=60, rows=1000):
    for k in range(count):
        unit = folder / f"unit{k % 7}"
        unit.mkdir(parents=True, exist_ok=True)
        rng = np.random.default_rng(seed_of(f"fleet log {k}"))
        np.save(unit / f"log{k:02}.npy", 1e-3 * rng.standard_normal((rows, 3)))
    return folder


def make_tables(folder, count, rows=1100):
    """Logs that need no option."""
    folder.mkdir(parents=True, exist_ok=True)
    for k in range(count):
        x = 1e-3 * np.random.default_rng(seed_of(f"fleet table {k}")).standard_normal((rows, 3))
        head = ",".join(f"gyro_{axis} [rad/s]" for axis in "xyz")
        table = np.column_stack([np.arange(rows) / 100, x])
        np.savetxt(folder / f"log{k}.csv", table, delimiter=",", header=f"time [s],{head}", comments="", fmt="%.9g")
    return folder


def damage(folder):
    """Write ten unusable files, each with a different fault."""
    folder.mkdir(parents=True, exist_ok=True)
    whole = (folder.parent / "unit0" / "log00.npy").read_bytes()
    (folder / "cut.npy").write_bytes(whole[:100])
    (folder / "flipped.npy").write_bytes(whole[:10] + bytes(b ^ 255 for b in whole[10:80]) + whole[80:])
    (folder / "words.csv").write_text("time,gyro_x\n1,2\nx,y\n")
    (folder / "other.bin").write_bytes(bytes(range(256)) * 40)
    (folder / "page.csv").write_text("<!DOCTYPE html><html>not found</html>")
    (folder / "lfs.csv").write_text("version https://git-lfs.github.com/spec/v1\n")
    np.save(folder / "few.npy", np.zeros((2, 3)))
    np.save(folder / "gone.npy", np.full((2000, 3), np.nan))
    np.save(folder / "narrow.npy", np.zeros((2000, 1)))
    np.save(folder / "words.npy", np.full((2000, 3), "a"))
    assert len(list(folder.iterdir())) == DAMAGED


class Processes:
    """Processes of a test, which end with it."""

    def __init__(self, folder):
        self.folder = Path(folder)
        self.seen = self.folder / "seen"
        self.seen.touch()
        (self.folder / "sitecustomize.py").write_text(HOOK)
        self.running = []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in self.running:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.communicate()

    def start(self, *arguments, pause=0.0, prefix=(), **settings):
        environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join([str(self.folder), str(ROOT / "python"), *sys.path]),
            "OPENBLAS_NUM_THREADS": "1",
            "FLEET_SEEN": str(self.seen),
            "FLEET_PAUSE": str(pause),
            **settings,
        }
        process = subprocess.Popen(
            [*prefix, sys.executable, *arguments], cwd=self.folder, env=environment, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True, preexec_fn=interruptible,
        )  # fmt: skip
        self.running.append(process)
        return process

    def fleet(self, *arguments, reading=READING, **options):
        """Start `sigmatau fleet analyze` in a separate process."""
        return self.start("-m", "sigmatau", "fleet", "analyze", *map(str, arguments), *reading, **options)

    def kill(self, process):
        """Kill a process that was started here."""
        process.kill()
        process.communicate()
        self.running.remove(process)

    def scheduler(self, *, host="127.0.0.1", port=None, **options):
        """A scheduler, and its address."""
        port = port or free_port()
        settings = {
            "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1",
            "DASK_DISTRIBUTED__SCHEDULER__WORKER_SATURATION": "1.0",
        } | options.pop("settings", {})
        process = self.start(
            "-m", "distributed.cli.dask_scheduler", "--host", host, "--port", str(port), "--no-dashboard", "--no-show",
            **options, **settings,
        )  # fmt: skip
        return process, f"tcp://{host}:{port}"

    def worker(self, address, *, pause=0.0, **options):
        settings = options.pop("settings", {})
        return self.start(
            "-m", "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-dashboard", "--no-nanny",
            "--death-timeout", "30", pause=pause, **options, **settings,
        )  # fmt: skip

    def reads(self):
        """Process and log of each reading so far."""
        return [tuple(line.split(" ", 1)) for line in self.seen.read_text().splitlines()]

    def wait_for_reads(self, count, *, seconds=60):
        """Wait until `count` logs were read; raise an error if it takes too long."""
        until = time.monotonic() + seconds
        while len(self.reads()) < count:
            ended = [process for process in self.running if process.poll() not in (None, 0)]
            assert not ended, ended[0].communicate()
            assert time.monotonic() < until, self.reads()
            time.sleep(0.02)


def interruptible():
    """Make a process interruptible: children of a background shell would ignore Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def ended(process, *, code=0, seconds=100):
    """Standard output and error of a process that ends with an exit code."""
    out, err = process.communicate(timeout=seconds)
    assert process.returncode == code, (process.returncode, out, err)
    return out, err


def contents(place):
    """Content of a store by path of the log: state, message and the whole result, without values that differ between
    runs.
    """
    from sigmatau.lab.store.store import Store

    rows_by_path = {}
    with Store(place, create=False) as store:
        paths = {row["id"]: row for row in rows(store)}
        for row, _ in store.results():
            result = store.content(row["id"])
            path = result["source"]["path"]
            assert path not in rows_by_path, f"{path} is there twice"
            rows_by_path[path] = (paths[row["id"]]["state"], row["unit"], result)
    return rows_by_path


def rows(store):
    columns = store.runs().columns()
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
