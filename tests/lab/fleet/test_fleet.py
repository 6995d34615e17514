"""A fleet whose parts are killed: every log is once in the store, with the digits of an undisturbed run."""

import contextlib
import os
import shutil
import signal
import sqlite3
import time
from pathlib import Path

import numpy as np
import pytest
from fleets import DAMAGED, READING, Processes, contents, damage, ended, make_logs, make_tables

import sigmatau
from conftest import skip_without
from known import seed_of
from sigmatau.cli import main

skip_without("distributed", "fleets need the extra cluster")
skip_without("sqlalchemy", "fleets need the extra store")

LOGS = 44


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    folder = make_logs(tmp_path_factory.mktemp("fleet") / "logs", LOGS)
    damage(folder / "without")
    return folder


@pytest.fixture(scope="module")
def undisturbed(logs):
    """The store of a run in one process."""
    with Processes(logs.parent) as processes:
        process = processes.fleet(logs, "--store", "whole.db", "--workers", 1)
        out, err = ended(process, code=1)
        assert out == f"{LOGS} of {LOGS + DAMAGED} logs analysed, {DAMAGED} failed\n"
        assert err.count("sigmatau: ") == DAMAGED
        assert "Traceback" not in err
    return contents(logs.parent / "whole.db")


@pytest.fixture
def processes(tmp_path):
    with Processes(tmp_path) as found:
        yield found


def same(place, expected):
    found = contents(place)
    assert found.keys() == expected.keys()
    for path, one in found.items():
        assert one == expected[path], path


def test_damaged_files_fail_alone_with_a_reason(undisturbed, logs):
    failed = {path: result["error"]["message"] for path, (state, _, result) in undisturbed.items() if state == "failed"}
    assert {Path(path).parent for path in failed} == {logs / "without"}
    assert len(failed) == DAMAGED
    assert not any(path in message for path, message in failed.items())  # the path is a field of its own
    assert len({*failed.values()}) == DAMAGED
    assert {unit for path, (_, unit, _) in undisturbed.items() if path not in failed} == {f"unit{k}" for k in range(7)}


def test_results_are_those_of_analyze(undisturbed, logs):
    place = str(logs / "unit3" / "log03.npy")
    record = sigmatau.read(place, rate=100, channels={"gyro": "1:3"}, unit={"gyro": "rad/s"})
    expected = sigmatau.analyze(record, threads=1).to_dict()
    found = undisturbed[place][2]
    assert found == expected


@pytest.fixture
def here(monkeypatch):
    """Workers that are threads of this process, and how often they were started."""
    from distributed import Client, LocalCluster

    started = []

    @contextlib.contextmanager
    def cluster(**options):
        started.append(options)
        with (
            LocalCluster(processes=False, n_workers=1, threads_per_worker=1, dashboard_address="127.0.0.1:0") as local,
            Client(local) as client,
        ):
            yield client

    monkeypatch.setattr("sigmatau.lab.fleet.run.cluster", cluster)
    return started


def test_a_second_run_analyses_nothing_again(undisturbed, logs, here, tmp_path, capsys):
    place = tmp_path / "whole.db"
    place.write_bytes((logs.parent / "whole.db").read_bytes())

    def run():
        assert main(["fleet", "analyze", str(logs), "--store", str(place), *READING]) == 1
        out, err = capsys.readouterr()
        # A log that failed in an earlier run is named again, with its reason.
        reasons = {
            path: result["error"]["message"] for path, (state, _, result) in undisturbed.items() if state == "failed"
        }
        assert all(path in err for path in reasons)
        assert all(" ".join(reason.split()) in " ".join(err.split()) for reason in reasons.values())
        return out

    assert run() == f"0 of 0 logs analysed, {LOGS + DAMAGED} were in the store (of them {DAMAGED} failed)\n"
    assert here == []
    # A log that changed is analysed again, and its earlier result is history; one that was only touched keeps its row.
    changed, touched = logs / "unit0" / "log00.npy", logs / "unit1" / "log01.npy"
    before = changed.read_bytes()
    try:
        changed.write_bytes((logs / "unit2" / "log02.npy").read_bytes())
        touched.touch()
        known = f"{LOGS + DAMAGED - 2} were in the store (of them {DAMAGED} failed)"
        assert run() == f"2 of 2 logs analysed, {known}\n"
        found = contents(place)
        assert found.keys() == undisturbed.keys()
        assert found[str(changed)][2]["channels"] == found[str(logs / "unit2" / "log02.npy")][2]["channels"]
        assert found[str(touched)] == undisturbed[str(touched)]
        assert run().startswith("0 of 0")
        assert len(here) == 1
    finally:
        changed.write_bytes(before)


def test_a_copy_of_a_log_is_one_run_that_no_later_command_analyses_again(here, tmp_path, capsys):
    logs, place = make_tables(tmp_path / "logs", 3), tmp_path / "lab.db"

    def run():
        assert main(["fleet", "analyze", str(logs), "--store", str(place), "--unit-from", "(logs)", "-q"]) == 0
        return capsys.readouterr().out

    (logs / "first").mkdir()
    shutil.copy2(logs / "log0.csv", logs / "first" / "log0.csv")
    assert run() == "4 of 4 logs analysed\n"
    assert count(place) == 3
    log = str(logs / "log2.csv")
    assert contents(place)[log][2] == sigmatau.analyze(sigmatau.read(log), threads=1).to_dict()
    assert run() == "0 of 0 logs analysed, 4 were in the store\n"
    shutil.copy(logs / "log1.csv", logs / "again.csv")  # a later copy, and one that is moved
    assert run() == "1 of 1 logs analysed, 4 were in the store\n"
    assert run() == "0 of 0 logs analysed, 5 were in the store\n"
    (logs / "again.csv").rename(logs / "moved.csv")
    assert run() == "1 of 1 logs analysed, 4 were in the store\n"
    assert run() == "0 of 0 logs analysed, 5 were in the store\n"
    assert count(place) == 3
    shutil.copy(logs / "log2.csv", logs / "moved.csv")  # a copy that becomes another log
    assert run().startswith("1 of 1")
    assert run() == "0 of 0 logs analysed, 5 were in the store\n"
    assert count(place) == 3


def test_moving_and_cut_logs_are_counted_and_a_second_run_keeps_their_exit_code(here, tmp_path, capsys):
    """Equal failures are one line; the largest reason determines the exit code."""
    logs, place = make_logs(tmp_path / "logs", 2, rows=4000), tmp_path / "lab.db"
    x = 1e-3 * np.random.default_rng(seed_of("moving log")).standard_normal((4000, 3))
    np.save(logs / "unit0" / "moving.npy", x + np.sin(np.arange(4000) / 200)[:, None])
    np.save(logs / "unit0" / "short.npy", x[:300])

    def run(code, *further):
        assert main(["fleet", "analyze", str(logs), "--store", str(place), *READING, "-q", *further]) == code
        return capsys.readouterr()

    assert run(5).out == "4 of 4 logs analysed, 2 not at rest or too short to tell\n"
    assert run(5).out == "0 of 0 logs analysed, 4 were in the store (of them 2 not at rest or too short to tell)\n"
    for k in range(3):
        (logs / "unit1" / f"empty{k}.npy").touch()
    first = run(1)
    assert (
        first.out
        == "0 of 3 logs analysed, 3 failed, 4 were in the store (of them 2 not at rest or too short to tell)\n"
    )
    assert first.err == f"sigmatau: {logs / 'unit1' / 'empty0.npy'}: is empty; the same for 2 more logs\n"
    second = run(1)
    assert second.out.endswith("7 were in the store (of them 2 not at rest or too short to tell, 3 failed)\n")
    assert second.err == first.err


def test_the_same_relative_path_in_two_folders_is_two_logs(here, tmp_path, monkeypatch):
    """The logs of the second night do not make those of the first one history; the file alone has all results."""
    place = tmp_path / "lab.db"
    for night in ("night1", "night2"):
        make_tables(tmp_path / night / "logs", 1, rows=1100 if night == "night1" else 1200)
        monkeypatch.chdir(tmp_path / night)
        assert main(["fleet", "analyze", "logs", "--store", str(place), "-q"]) == 0
    assert not [*tmp_path.glob("lab.db-*")]
    assert sorted(contents(place)) == [str(tmp_path / night / "logs" / "log0.csv") for night in ("night1", "night2")]


def test_the_client_is_killed_then_interrupted_then_a_worker_is_killed(undisturbed, logs, processes):
    """Three runs of one command; the last one completes although it loses a worker."""
    arguments = (logs, "--store", "a.db", "--workers")
    process = processes.fleet(*arguments, 1, pause=0.3)
    until = time.monotonic() + 60
    while count(processes.folder / "a.db") == 0:  # what is finished is written every 5 s
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < until
        time.sleep(0.05)
    processes.kill(process)
    first = count(processes.folder / "a.db")
    workers = {int(pid) for pid, _ in processes.reads()}
    until = time.monotonic() + 15
    while any(alive(pid) for pid in workers):  # they end by themselves
        assert time.monotonic() < until
        time.sleep(0.05)

    process = processes.fleet(*arguments, 1, pause=0.05)
    processes.wait_for_reads(len(processes.reads()) + 12)
    os.killpg(process.pid, signal.SIGINT)
    out, err = ended(process, code=130)
    assert out == ""
    assert err.splitlines()[-1] == "sigmatau: interrupted"
    assert "Traceback" not in err
    processes.running.remove(process)
    done = contents(processes.folder / "a.db")
    assert first < len(done) < LOGS

    process = processes.fleet(*arguments, 2, pause=0.05)
    processes.wait_for_reads(len(processes.reads()) + 8)
    os.kill(int(processes.reads()[-1][0]), signal.SIGKILL)
    out, _ = ended(process, code=1)
    known = f"{DAMAGED} failed, {len(done)} were in the store"  # the damaged ones come last
    assert out == f"{LOGS - len(done)} of {LOGS + DAMAGED - len(done)} logs analysed, {known}\n"
    same(processes.folder / "a.db", undisturbed)


def count(place):
    """Runs in a store, which may not be made yet."""
    try:
        with contextlib.closing(sqlite3.connect(f"file:{place}?mode=ro", uri=True)) as connection:
            return connection.execute("SELECT count(*) FROM run").fetchone()[0]
    except sqlite3.OperationalError:
        return 0


def alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


@pytest.mark.parametrize("place", ["postgres"], indirect=True)
def test_the_scheduler_is_killed(logs, processes, place):
    scheduler, address = processes.scheduler()
    for _ in range(2):
        processes.worker(address, pause=0.05)
    process = processes.fleet(logs, "--store", place, "--scheduler", address)
    processes.wait_for_reads(20)
    processes.kill(scheduler)
    _, err = ended(process, code=1)
    processes.running.remove(process)
    assert "the scheduler was lost; " in err
    assert f" of {LOGS + DAMAGED} logs are in the store, and the same command continues" in err
    assert "Traceback" not in err


def test_a_log_that_kills_its_worker_beside_a_record_that_is_divided(processes, tmp_path):
    zarr = pytest.importorskip("zarr", reason="records in chunks need the extra cluster")
    n = 1_800_000
    axes = [f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"]
    folder = make_tables(tmp_path / "some", 8)
    poison, long = folder / "poison.csv", folder / "long.zarr"
    poison.write_bytes((folder / "log0.csv").read_bytes() + b"11.0,0.001,0.002,0.003\n")
    group = zarr.open_group(str(long), mode="w", attributes={"rate": 100.0})
    x = {name: 1e-3 * np.random.default_rng(seed_of(f"fleet, long {name}")).standard_normal(n) for name in axes}
    for name in axes:
        unit = "rad/s" if name.startswith("gyro") else "m/s^2"
        options = {"chunks": (100_000,), "compressors": None, "attributes": {"unit": unit}}
        group.create_array(name, shape=(n,), dtype="f8", **options)[:] = x[name]
    arguments = (folder, "--store", "a.db", "--workers", 2, "--memory", 0.5)
    out, err = ended(processes.fleet(*arguments, reading=(), FLEET_VALUES="2000000"), code=1)
    assert out == "9 of 10 logs analysed, 1 failed\n"
    found = contents(processes.folder / "a.db")
    assert [path for path, (state, _, _) in found.items() if state == "failed"] == [str(poison)]
    assert "its worker was killed at each attempt" in err

    stretches = [read for _, read in processes.reads() if ":" in read]
    assert len(set(stretches)) == 6  # of 300 000 samples, whole chunks
    assert len(stretches) > 6  # a worker ended, and its stretch was summed again
    state, unit, result = found[str(long)]
    assert (state, unit) == ("fitted", "some")
    assert "in_stretches" in [one["code"] for one in result["findings"]]
    stream = sigmatau.Accumulator(*axes, rate=100, long="strided")
    stream.push(x)
    for name, curve in stream.snapshot().items():
        of_fleet = result["channels"][name]["curve"]
        of_stream = curve.at(np.array(of_fleet["m"]))
        np.testing.assert_allclose(np.square(of_fleet["adev"]), of_stream.avar, rtol=1e-12)
        assert of_fleet["n_pairs"] == of_stream.n_pairs.tolist()

    # The log is not tried again unless that is asked for, and then it is there once.
    assert ended(processes.fleet(*arguments, reading=()), code=1)[0].startswith("0 of 0")
    again = processes.fleet(*arguments[:3], "--workers", 1, "--retry-failed", reading=(), FLEET_HEALED="yes")
    assert ended(again)[0] == "1 of 1 logs analysed, 9 were in the store\n"
    assert contents(processes.folder / "a.db")[str(poison)][0] == "fitted"


def test_an_option_that_is_wrong_for_every_log_stores_nothing(tmp_path, monkeypatch, capsys):
    """`lot --store` would take the failures for the latest results. A log without a unit is named."""
    monkeypatch.chdir(tmp_path)
    make_logs(tmp_path / "logs", 2)
    start = ["fleet", "analyze", "logs/**", "--store", "a.db", "--workers", "1", *READING]
    assert main([*start[:-1], "gyro=deg/q"]) == 2
    out, err = capsys.readouterr()
    assert out == "0 of 2 logs analysed, 2 failed\n"
    assert "nothing is stored: an option is wrong or missing for 2 logs, and no log was analysed" in " ".join(
        err.split()
    )
    assert count("a.db") == 0
    assert main([*start, "--unit-from", "(none[0-9])"]) == 1
    err = capsys.readouterr().err
    assert "--unit-from '(none[0-9])' finds no unit in the path of the log" in err
    assert "the same for 1 more logs" in err
    assert count("a.db") == 0


def test_a_log_without_a_unit_or_a_date_stops_no_other(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    make_logs(tmp_path / "logs", 2)
    (tmp_path / "logs" / "other").mkdir()
    shutil.copy(tmp_path / "logs" / "unit0" / "log00.npy", tmp_path / "logs" / "other" / "log.npy")
    start = ["fleet", "analyze", "logs/**", "--store", "a.db", "--workers", "1", *READING]
    assert main([*start, "--unit-from", "logs/(unit[0-9])"]) == 1
    out, err = capsys.readouterr()
    assert out == "2 of 2 logs analysed\n"
    said = " ".join(err.split())
    assert "other/log.npy" in said
    assert "not analysed: 1 log without a unit or a date" in said
    assert count("a.db") == 2
