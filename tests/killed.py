"""Ends of processes by SIGKILL: ``python tests/killed.py KIND FOLDER COUNT`` ends so many, and prints what it left as JSON.

The processes are forks of this one, which has imported what they need, so that the time until the end is that of the work.
Half of them end at any time, the others soon after they changed the folder.
"""

import contextlib
import importlib
import io
import json
import os
import random
import signal
import sqlite3
import sys
import time
import zipfile
from contextlib import closing
from pathlib import Path

import numpy as np

from sigmatau.cli import main

FROZEN = Path(__file__).parent / "lab" / "store" / "frozen" / "store-0003.sql"
COPIES = 40  # of each run of the frozen store
AFTER_CHANGE = 0.01  # longest time between a change of the folder and the end [s]
ANALYZE = ("analyze", "log.csv", "--rate", "100", "--unit", "gyro=rad/s", "-q")
MODEL = '[channels.gyro_x]\nrandom_walk = "0.3 deg/sqrt(h)"\n'


class Json:
    """A result that replaces an older one."""

    def __init__(self, folder):
        table = np.random.default_rng(1).standard_normal((4000, 3))
        np.savetxt(folder / "log.csv", table, header="gyro_x,gyro_y,gyro_z", comments="", delimiter=",")
        (folder / "out.json").write_text("old")

    def run(self):
        return main([*ANALYZE, "--json", "out.json"])

    def outcome(self, folder):
        text = (folder / "out.json").read_text()
        if text == "old":
            return "old"
        result = json.loads(text)
        assert set(result["channels"]) == {"gyro_x", "gyro_y", "gyro_z"}
        (folder / "out.json").write_text("old")
        return "new"


class Report(Json):
    """A page that replaces an older one."""

    def __init__(self, folder):
        super().__init__(folder)
        (folder / "out.html").write_text("old")

    def run(self):
        return main([*ANALYZE, "--report", "out.html"])

    def outcome(self, folder):
        text = (folder / "out.html").read_text()
        if text == "old":
            return "old"
        assert text.lower().startswith("<!doctype html>")
        assert text.rstrip().endswith("</html>")
        (folder / "out.html").write_text("old")
        return "new"


class Archive:
    """A log in parts, which are joined at its end."""

    def __init__(self, folder):
        (folder / "model.toml").write_text(MODEL)

    def run(self):
        return main(["simulate", "model.toml", "--rate", "100", "--hours", "0.5", "-q", "-o", "out.npz"])

    def outcome(self, folder):
        path = folder / "out.npz"
        if not path.exists():
            return "old"
        with zipfile.ZipFile(path) as archive:
            assert archive.testzip() is None
        path.unlink()
        return "new"


class Migration:
    """A store of the previous version, which is updated when it is opened."""

    def __init__(self, folder):
        with closing(sqlite3.connect(folder / "first.db")) as base:
            base.executescript(FROZEN.read_text("utf-8"))
            for table in ("run", "result"):
                names = [row[1] for row in base.execute(f"PRAGMA table_info({table})")]
                changed = {"id": "id + 1000 * {0}", "run_id": "run_id + 1000 * {0}", "identity": "identity || '-{0}'"}
                columns = ", ".join(changed.get(name, f'"{name}"') for name in names)
                for copy in range(1, COPIES):
                    base.execute(
                        f"INSERT INTO {table} SELECT {columns.format(copy)} FROM {table} WHERE {names[0]} < 1000"
                    )
            base.commit()
            self.runs = base.execute("SELECT count(*) FROM run").fetchone()[0]
        self.renew(folder)

    def renew(self, folder):
        for path in folder.glob("store.db*"):
            path.unlink()
        (folder / "store.db").write_bytes((folder / "first.db").read_bytes())

    def run(self):
        from sigmatau.lab.store.store import Store

        Store("store.db").close()
        return 0

    def outcome(self, folder):
        from sigmatau.lab.store.store import Store

        with closing(sqlite3.connect(folder / "store.db")) as base:
            assert base.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
            (version,) = base.execute("SELECT version_num FROM alembic_version").fetchone()
            columns = {row[1] for row in base.execute("PRAGMA table_info(run)")}
            assert base.execute("SELECT count(*) FROM run").fetchone()[0] == self.runs
        outcome = {"0003": "old", "0004": "new"}[version]
        assert ({"supply", "has_curves"} <= columns) == (outcome == "new")
        with Store(folder / "store.db") as store, store._engine.connect() as connection:
            assert connection.exec_driver_sql("SELECT count(*) FROM run").scalar() == self.runs
        self.renew(folder)
        return outcome


KINDS = {"json": Json, "report": Report, "archive": Archive, "migration": Migration}


def names(folder):
    """Names and sizes of the files, which change when the work writes."""
    with contextlib.suppress(OSError):
        return {(entry.name, entry.stat(follow_symlinks=False).st_size) for entry in os.scandir(folder)}
    return set()


def started(work, modules=None):
    """Start the work in a fork, which writes the names of its modules to a file."""
    pid = os.fork()
    if pid == 0:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            code = work.run()
        if modules:
            modules.write_text("\n".join(sys.modules))
        os._exit(code)
    return pid


def completed(work, modules=None):
    """Let the work end by itself; returns its duration. [s]"""
    begun = time.monotonic()
    assert os.waitstatus_to_exitcode(os.waitpid(started(work, modules), 0)[1]) == 0
    return time.monotonic() - begun


def end(kind, folder, count):
    """End `count` processes; returns how often the output was the old one and the new one, and what was left beside it."""
    os.chdir(folder)
    work, rng = KINDS[kind](folder), random.Random(f"{kind} {count}")
    modules = folder / "modules.txt"
    completed(work, modules)
    for name in modules.read_text().split("\n"):
        with contextlib.suppress(Exception):
            importlib.import_module(name)
    assert work.outcome(folder) == "new"
    duration = completed(work)
    assert work.outcome(folder) == "new"
    outcomes, clean = {"old": 0, "new": 0, "left": 0}, len(names(folder))
    for number in range(count):
        before, pid = names(folder), started(work)
        begun = time.monotonic()
        if number % 2:
            while names(folder) == before and time.monotonic() < begun + 2 * duration:
                pass
            time.sleep(AFTER_CHANGE * rng.random())
        else:
            time.sleep(1.2 * duration * rng.random())
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
        outcomes["left"] += len(names(folder)) > clean
        outcomes[work.outcome(folder)] += 1
    completed(work)
    assert work.outcome(folder) == "new"
    assert len(names(folder)) == clean, names(folder)
    return outcomes


if __name__ == "__main__":
    print(json.dumps(end(sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]))))
