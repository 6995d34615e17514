"""A fleet whose results keep all curves, none, or those of failed logs; also after it was killed, with another choice."""

import sqlite3
import time
from contextlib import closing

import numpy as np
import pytest
from fleets import Processes, contents, ended, make_logs

from conftest import skip_without
from known import seed_of
from sigmatau.lab.store.choosing import Chosen
from sigmatau.lab.store.store import Store

skip_without("distributed", "fleets need the extra cluster")
skip_without("sqlalchemy", "fleets need the extra store")

LOGS = 12
FAILED = {"coarse.npy", "constant.npy", "moving.npy"}


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    folder = make_logs(tmp_path_factory.mktemp("fleet") / "logs", LOGS, rows=4000)
    x = 1e-3 * np.random.default_rng(seed_of("doubtful logs")).standard_normal((4000, 3))
    np.save(folder / "unit0" / "coarse.npy", np.column_stack([4e-3 * np.round(x[:, 0] / 4e-3), x[:, 1:]]))
    np.save(folder / "unit0" / "constant.npy", np.column_stack([x[:, 0], np.zeros(4000), x[:, 2]]))
    moving = x + np.sin(np.arange(4000) / 200)[:, None]
    np.save(folder / "unit0" / "moving.npy", moving)
    (folder / "unit0" / "empty.npy").touch()
    return folder


@pytest.fixture(scope="module")
def whole(logs):
    """Contents of a store with all curves."""
    with Processes(logs.parent) as processes:
        out, _ = ended(processes.fleet(logs, "--store", "whole.db", "--workers", 1), code=1)
        assert out == f"{LOGS + 3} of {LOGS + 4} logs analysed, 1 not at rest or too short to tell, 1 failed\n"
    return contents(logs.parent / "whole.db")


@pytest.fixture
def processes(tmp_path):
    with Processes(tmp_path) as started:
        yield started


def with_curves(place):
    """Names of the runs that have curves, and of those that have none."""
    with Store(place, create=False) as store:
        runs = store.runs().columns()
        assert set(store.runs(Chosen(history=True)).columns()["revision"]) == {1}
    pairs = list(zip(runs["run"], runs["has_curves"], strict=True))
    return {name for name, has in pairs if has}, {name for name, has in pairs if has is False}


def test_failed_logs_keep_their_curves(processes, logs, whole, tmp_path):
    ended(processes.fleet(logs, "--store", "lab.db", "--workers", 1, "--keep-curves", "failed"), code=1)
    kept, without = with_curves(tmp_path / "lab.db")
    assert kept == FAILED
    assert len(without) == LOGS
    for path, (state, unit, result) in contents(tmp_path / "lab.db").items():
        expected_state, expected_unit, expected = whole[path]
        assert (state, unit) == (expected_state, expected_unit)
        for name, channel in result["channels"].items():  # every number but the curves
            assert {**channel, "curve": None} == {**expected["channels"][name], "curve": None}


def test_a_killed_fleet_goes_on_with_another_choice(processes, logs, whole, tmp_path):
    """After `kill -9` with no curves, then with those of failed logs, then with all: the store is that of one run."""
    place = tmp_path / "lab.db"
    command = (logs, "--store", "lab.db", "--workers", 1)
    killed = processes.fleet(*command, "--keep-curves", "none", pause=0.8)
    processes.wait_for_reads(6)
    with closing(sqlite3.connect(place)) as base:  # results are written after 5 s
        while not base.execute("SELECT count(*) FROM run").fetchone()[0]:
            assert killed.poll() is None, killed.communicate()
            time.sleep(0.1)
    processes.kill(killed)
    count = len(with_curves(place)[1])
    assert 0 < count < LOGS + 3

    _, err = ended(processes.fleet(*command, "--keep-curves", "failed"), code=1)
    assert with_curves(place)[0] == FAILED
    _, err = ended(processes.fleet(*command, "--keep-curves", "all"), code=1)
    assert f"analysed again: {LOGS} logs in the store without the curves that are kept now" in err
    assert contents(place) == whole
    reads = len(processes.reads())
    out, err = ended(processes.fleet(*command, "--keep-curves", "none"), code=1)
    assert (
        out
        == f"0 of 0 logs analysed, {LOGS + 4} were in the store (of them 1 not at rest or too short to tell, 1 failed)\n"
    )
    assert "analysed again" not in err
    assert len(processes.reads()) == reads
    assert contents(place) == whole
