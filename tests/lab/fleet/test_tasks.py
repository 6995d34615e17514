"""What a worker does with a log: a row for the store, whatever the log."""

import pytest
from fleets import make_logs

from conftest import skip_without
from sigmatau.lab.fleet.logs import Log, find
from sigmatau.lab.fleet.tasks import FleetJob, analyse
from sigmatau.lab.store.naming import Naming

skip_without("sqlalchemy", "fleets need the extra store")
skip_without("fsspec", "URLs need the extra cluster")

READING = {"rate": 100, "channels": {"gyro": "1:3"}, "unit": {"gyro": "rad/s"}}
JOB = FleetJob(reading=READING, settings={"method": "gls"}, naming=Naming(folders=True))


@pytest.fixture
def objects(tmp_path):
    """The same logs as files and as objects."""
    import fsspec

    logs = make_logs(tmp_path / "logs", 2)
    (logs / "unit0" / "bad.npy").write_bytes(b"\x93NUMPY bad")
    memory = fsspec.filesystem("memory")
    memory.put(str(logs), "/tasks", recursive=True)
    yield logs
    memory.rm("/tasks", recursive=True)


def test_an_object_is_analysed_as_a_file(objects):
    files, _ = analyse(find([str(objects)]), JOB)
    found, seconds = analyse(find(["memory://tasks"]), JOB)
    assert seconds > 0
    assert [one.log.place for one in found] == [
        "memory:///tasks/unit0/bad.npy", "memory:///tasks/unit0/log00.npy", "memory:///tasks/unit1/log01.npy",
    ]  # fmt: skip
    for one, other in zip(found[1:], files[1:], strict=True):
        assert (one.code, one.error) == (0, None)
        assert one.rows.unit == other.rows.unit
        assert one.rows.terms == other.rows.terms
        assert one.rows.run["sha256"] == other.rows.run["sha256"]
        assert one.rows.run["path"] == one.log.place
        assert one.rows.run["file_version"] == one.log.version


def test_a_failure_names_the_object_and_not_its_copy(objects):
    (bad, _, _), _ = analyse(find(["memory://tasks"]), JOB)
    assert bad.code == 1
    assert str(bad.error).startswith("memory:///tasks/unit0/bad.npy: is damaged")
    assert "sigmatau-" not in str(bad.error)
    assert bad.rows.run["state"] == "failed"
    assert bad.rows.run["message"] == bad.error.reason
    (gone,), _ = analyse([Log(place="memory:///tasks/none.npy", size=1, changed="")], JOB)
    assert (gone.code, gone.rows.run["state"]) == (1, "failed")
    assert str(gone.error).startswith("memory:///tasks/none.npy: cannot be copied")


def test_a_defect_of_the_program_is_a_failure_of_the_log(objects, monkeypatch):
    import sigmatau

    def broken(*_, **__):
        raise ZeroDivisionError("by zero")

    monkeypatch.setattr(sigmatau, "analyze", broken)
    (_, one, _), _ = analyse(find([str(objects)]), JOB)
    assert (one.code, str(one.error)) == (1, f"{one.log.place}: ZeroDivisionError: by zero")


def test_a_wrong_option_has_its_code(objects):
    (log, *_), _ = analyse(
        find([str(objects / "unit1")]), FleetJob(reading=READING | {"unit": {}}, settings={}, naming=JOB.naming)
    )
    assert log.code == 2
    assert "--unit" in log.error.for_command_line()
