"""Files are written beside and renamed: through symbolic links, and without what a killed process left behind."""

import multiprocessing
import signal
import subprocess
import sys

import numpy as np
import pytest

import sigmatau as st
from sigmatau.io.atomic import atomic
from sigmatau.io.write import write

needs_locks = pytest.mark.skipif(sys.platform == "win32", reason="no locks of files")
LEFT = """
import os, signal, sys
import sigmatau as st
import numpy as np
from sigmatau.io.write import table_writer
with table_writer(sys.argv[1], [("gyro_x", "rad/s")]) as put:
    put([np.ones(10)])
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_symbolic_link_is_followed(tmp_path):
    (tmp_path / "kept").mkdir()
    link = tmp_path / "result.json"
    link.symlink_to(tmp_path / "kept" / "real.json")
    for text in ("one", "two"):
        with atomic(link) as temporary:
            temporary.write_text(text)
        assert link.is_symlink()
        assert (tmp_path / "kept" / "real.json").read_text() == text
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["kept", "real.json", "result.json"]


def test_nothing_is_left_of_a_failed_write(tmp_path):
    def fail():
        with atomic(tmp_path / "a.txt") as path:
            path.write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert list(tmp_path.iterdir()) == []


@needs_locks
@pytest.mark.parametrize("name", ["log.csv", "log.npz", "log[1].npy"])
def test_the_next_run_removes_what_a_killed_one_left(tmp_path, name):
    killed = subprocess.run([sys.executable, "-c", LEFT, str(tmp_path / name)], check=False)
    assert killed.returncode == -signal.SIGKILL
    assert len(list(tmp_path.iterdir())) == (2 if name.endswith(".npz") else 1)
    others = [tmp_path / f".{name}.settings", tmp_path / f"{name}.sigmatau-x"]
    for other in others:
        other.touch()
    write(st.Record.from_arrays(rate=100, unit={"gyro": "rad/s"}, gyro=np.ones((10, 3))), tmp_path / name)
    assert sorted(tmp_path.iterdir()) == sorted([tmp_path / name, *others])


def _writes(path, ready, go):
    with atomic(path) as temporary:
        temporary.write_text("slow")
        ready.set()
        go.wait(60)


@needs_locks
def test_a_file_that_is_being_written_is_left_alone(tmp_path):
    path = tmp_path / "result.json"
    context = multiprocessing.get_context("spawn")
    ready, go = context.Event(), context.Event()
    slow = context.Process(target=_writes, args=(path, ready, go))
    slow.start()
    assert ready.wait(60)
    with atomic(path) as temporary:
        temporary.write_text("fast")
    assert path.read_text() == "fast"
    go.set()
    slow.join(60)
    assert slow.exitcode == 0
    assert path.read_text() == "slow"
    assert [p.name for p in tmp_path.iterdir()] == ["result.json"]
