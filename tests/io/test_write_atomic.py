"""Files are written beside and renamed: through symbolic links, and without what a killed process left behind."""

import multiprocessing
import os
import signal
import subprocess
import sys

import numpy as np
import pytest

import sigmatau as st
from sigmatau.cli import main
from sigmatau.io.atomic import PARTS, atomic, is_foreign_link
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


def status(*, owner, mode=0):
    return os.stat_result((mode, 0, 0, 1, owner, owner, 0, 0, 0, 0))


@pytest.mark.parametrize(
    ("owner", "mode", "foreign"),
    [
        (1000, 0o41777, False),
        (0, 0o41777, False),
        (1001, 0o41777, True),
        (1001, 0o40777, False),
        (1001, 0o41755, False),
    ],
)
def test_a_link_of_another_user_in_a_shared_folder(owner, mode, foreign):
    """User 1000 in a folder of root: the rule of Linux for files that are opened."""
    assert is_foreign_link(status(owner=owner), status(owner=0, mode=mode), 1000) == foreign


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root can make links of other users")
@pytest.mark.parametrize("links", [["result.json"], ["result.json", "second.json"]])
def test_a_link_of_another_user_does_not_choose_the_file(tmp_path, links, capsys):
    victim, shared, log = tmp_path / "victim", tmp_path / "shared", tmp_path / "log.csv"
    victim.write_text("precious")
    log.write_text("gyro_x [rad/s]\n" + "\n".join(map(str, np.random.default_rng(1).normal(size=300))))
    shared.mkdir()
    shared.chmod(0o1777)
    for name, goal in zip(links, [*links[1:], victim], strict=True):
        (shared / name).symlink_to(goal)
    os.lchown(shared / links[-1], 1001, 1001)
    command = ["analyze", str(log), "--rate", "100", "--at-rest", "--json", str(shared / links[0])]
    assert main(command) == 1
    assert "is a symbolic link of another user in a shared folder" in " ".join(capsys.readouterr().err.split())
    assert victim.read_text() == "precious"
    os.lchown(shared / links[-1], os.geteuid(), os.geteuid())
    assert main(command) == 0
    assert victim.read_text() != "precious"


@needs_locks
def test_links_with_the_name_of_a_temporary_file_are_not_followed(tmp_path):
    """A file with a name like those of killed runs may be a link to any file, folder or pipe: none is changed."""
    goals = [tmp_path / "victim", tmp_path / "folder", tmp_path / "pipe"]
    goals[0].write_text("precious")
    goals[1].mkdir()
    (goals[1] / "inside").write_text("precious")
    os.mkfifo(goals[2])
    links = [tmp_path / f".result.json.sigmatau-{k}.json" for k in range(4)]
    for link, goal in zip(links, [*goals, tmp_path / "nothing"], strict=True):
        link.symlink_to(goal)
    parts = tmp_path / f".result.json.sigmatau-9.json{PARTS}"
    parts.symlink_to(goals[1])
    with atomic(tmp_path / "result.json") as temporary:
        assert not temporary.is_symlink()
        temporary.write_text("new")
    assert (tmp_path / "result.json").read_text() == "new"
    assert goals[0].read_text() == (goals[1] / "inside").read_text() == "precious"
    assert all(link.is_symlink() for link in [*links, parts])


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
