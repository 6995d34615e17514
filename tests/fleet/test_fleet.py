"""A fleet whose parts are killed: every log is once in the store, with the digits of an undisturbed run."""

import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest

import sigmatau
from known import seed_of

pytest.importorskip("distributed", reason="fleets need the extra cluster")
pytest.importorskip("sqlalchemy", reason="fleets need the extra store")

from fleets import DAMAGED, Processes, contents, damage, ended, make_logs

LOGS = 60


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
    assert all(message.startswith(path) for path, message in failed.items())
    assert len({message.removeprefix(path) for path, message in failed.items()}) == DAMAGED
    assert {unit for path, (_, unit, _) in undisturbed.items() if path not in failed} == {f"unit{k}" for k in range(7)}


def test_results_are_those_of_analyze(undisturbed, logs):
    place = str(logs / "unit3" / "log03.npy")
    record = sigmatau.read(place, rate=100, channels={"gyro": "1:3"}, unit={"gyro": "rad/s"})
    expected = sigmatau.analyze(record, threads=1).to_dict()
    found = undisturbed[place][2]
    assert found == expected


def test_a_second_run_analyses_nothing_again(undisturbed, logs, processes):
    (processes.folder / "whole.db").write_bytes((logs.parent / "whole.db").read_bytes())
    out, _ = ended(processes.fleet(logs, "--store", "whole.db", "--workers", 2))
    assert out == f"0 of 0 logs analysed, {LOGS + DAMAGED} were in the store ({DAMAGED} of them failed)\n"
    assert processes.reads() == []
    # A log that changed is analysed again, and its earlier result is history; one that was only touched keeps its row.
    changed, touched = logs / "unit0" / "log00.npy", logs / "unit1" / "log01.npy"
    before = changed.read_bytes()
    try:
        changed.write_bytes((logs / "unit2" / "log02.npy").read_bytes())
        touched.touch()
        out, _ = ended(processes.fleet(logs, "--store", "whole.db", "--workers", 1))
        assert out == f"2 of 2 logs analysed, {LOGS + DAMAGED - 2} were in the store ({DAMAGED} of them failed)\n"
        found = contents(processes.folder / "whole.db")
        assert found.keys() == undisturbed.keys()
        assert found[str(changed)][2]["channels"] == found[str(logs / "unit2" / "log02.npy")][2]["channels"]
        assert found[str(touched)] == undisturbed[str(touched)]
        out, _ = ended(processes.fleet(logs, "--store", "whole.db", "--workers", 1))
        assert out.startswith("0 of 0")
    finally:
        changed.write_bytes(before)


@pytest.mark.parametrize("place", ["postgres"], indirect=True)
def test_a_worker_is_killed(undisturbed, logs, processes, place):
    process = processes.fleet(logs, "--store", place, "--workers", 2, pause=0.05)
    processes.wait_for_reads(15)
    os.kill(int(processes.reads()[-1][0]), signal.SIGKILL)
    ended(process, code=1)
    same(place, undisturbed)


def test_the_client_is_killed(undisturbed, logs, processes):
    process = processes.fleet(logs, "--store", "a.db", "--workers", 2, pause=0.05)
    processes.wait_for_reads(40)
    process.kill()
    process.wait()
    workers = {int(pid) for pid, _ in processes.reads()}
    until = time.monotonic() + 15
    while any(alive(pid) for pid in workers):  # they end by themselves
        assert time.monotonic() < until
        time.sleep(0.05)
    ended(processes.fleet(logs, "--store", "a.db", "--workers", 2), code=1)
    same(processes.folder / "a.db", undisturbed)


def alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


def test_the_scheduler_is_killed(undisturbed, logs, processes):
    scheduler, address = processes.scheduler()
    workers = [processes.worker(address, pause=0.05) for _ in range(2)]
    process = processes.fleet(logs, "--store", "a.db", "--scheduler", address)
    processes.wait_for_reads(30)
    scheduler.kill()
    _, err = ended(process, code=1)
    assert "the scheduler was lost; " in err
    assert f" of {LOGS + DAMAGED} logs are in the store, and the same command goes on with the others" in err
    assert "Traceback" not in err
    scheduler.wait()
    for worker in workers:
        worker.kill()
    _, address = processes.scheduler()
    processes.worker(address)
    ended(processes.fleet(logs, "--store", "a.db", "--scheduler", address), code=1)
    same(processes.folder / "a.db", undisturbed)


def test_a_log_that_kills_its_worker_fails_alone(logs, processes, tmp_path):
    folder = make_logs(tmp_path / "some", 8, rows=500)
    poison = folder / "unit0" / "poison.npy"
    np.save(poison, 1e-3 * np.random.default_rng(seed_of("poison")).standard_normal((500, 3)))
    out, err = ended(processes.fleet(folder, "--store", "a.db", "--workers", 2), code=1)
    assert out == "8 of 9 logs analysed, 1 failed\n"
    found = contents(processes.folder / "a.db")
    assert [path for path, (state, _, _) in found.items() if state == "failed"] == [str(poison)]
    assert "its worker ended each time it was tried" in err
    # It is not tried again unless that is asked for, and then it is there once.
    assert ended(processes.fleet(folder, "--store", "a.db", "--workers", 1))[0].startswith("0 of 0")
    again = processes.fleet(folder, "--store", "a.db", "--workers", 1, "--retry-failed", FLEET_HEALED="yes")
    assert ended(again)[0] == "1 of 1 logs analysed, 8 were in the store\n"
    assert contents(processes.folder / "a.db")[str(poison)][0] == "fitted"


def test_a_record_that_is_too_large_is_divided(processes, tmp_path):
    zarr = pytest.importorskip("zarr", reason="records in chunks need the extra cluster")
    n = 2_100_000
    axes = [f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"]
    logs = make_logs(tmp_path / "some", 6)
    group = zarr.open_group(str(logs / "long.zarr"), mode="w", attributes={"rate": 100.0})
    x = {name: 1e-3 * np.random.default_rng(seed_of(f"fleet, long {name}")).standard_normal(n) for name in axes}
    for name in axes:
        unit = "rad/s" if name.startswith("gyro") else "m/s^2"
        array = group.create_array(name, shape=(n,), chunks=(100_000,), dtype="f8", attributes={"unit": unit})
        array[:] = x[name]
    arguments = ("fleet", "analyze", logs / "long.zarr", "--store", "a.db", "--workers", 2, "--memory", 0.5)
    process = processes.start("-m", "sigmatau", *map(str, arguments), FLEET_VALUES="2000000")
    out, _ = ended(process)
    assert out == "1 of 1 logs analysed\n"
    stretches = [read for _, read in processes.reads() if ":" in read]
    assert len(set(stretches)) == 7  # of 300 000 samples, whole chunks
    assert len(stretches) > 7  # a worker ended, and its stretch was summed again
    ((state, unit, result),) = contents(processes.folder / "a.db").values()
    assert (state, unit) == ("fitted", "some")
    assert "in_stretches" in [one["code"] for one in result["findings"]]
    stream = sigmatau.Accumulator(*axes, rate=100, long="strided")
    stream.push(x)
    for name, curve in stream.snapshot().items():
        found = result["channels"][name]["curve"]
        same = curve.at(np.array(found["m"]))
        np.testing.assert_allclose(np.square(found["adev"]), same.avar, rtol=1e-12)
        assert found["n_pairs"] == same.n_pairs.tolist()


def test_interrupted(logs, processes):
    process = processes.fleet(logs, "--store", "a.db", "--workers", 2, pause=0.05)
    processes.wait_for_reads(20)
    os.killpg(process.pid, signal.SIGINT)
    out, err = ended(process, code=130)
    assert out == ""
    assert err.splitlines()[-1] == "sigmatau: interrupted"
    assert "Traceback" not in err
    done = contents(processes.folder / "a.db")
    assert 0 < len(done) < LOGS + DAMAGED
    out, _ = ended(processes.fleet(logs, "--store", "a.db", "--workers", 2), code=1)
    assert out.endswith(f", {DAMAGED} failed, {len(done)} were in the store\n")
