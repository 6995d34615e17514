"""Which logs a pattern names, and what tells that one has changed."""

import os

import numpy as np
import pytest

from sigmatau.errors import DataError, OptionError
from sigmatau.lab.fleet.logs import find


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("logs/A1/day1.npy", "logs/A1/day2.npy", "logs/A2/day1.npy", "logs/top.npy", "logs/.hidden/x.npy"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        np.save(tmp_path / name, np.zeros(10))
    (tmp_path / "logs/A1/notes.md").write_text("a note")
    (tmp_path / "logs/A1/result.json").write_text("{}")
    (tmp_path / "logs/A1/empty.csv").touch()
    (tmp_path / "logs/A3.zarr/gyro_x/c").mkdir(parents=True)
    (tmp_path / "logs/A3.zarr/zarr.json").write_text("{}")
    (tmp_path / "logs/A3.zarr/gyro_x/c/0").write_bytes(b"chunk")
    return tmp_path / "logs"


EVERY = [
    "logs/A1/day1.npy",
    "logs/A1/day2.npy",
    "logs/A1/empty.csv",
    "logs/A2/day1.npy",
    "logs/A3.zarr",
    "logs/top.npy",
]


@pytest.mark.parametrize("pattern", ["logs", "logs/", "logs/**"])
def test_all_logs_of_a_folder(folder, pattern):
    """Not notes, results and hidden files; a Zarr store is one log. An empty log is a failure to report."""
    assert [log.place for log in find([pattern])] == EVERY


def test_patterns(folder):
    assert [log.place for log in find(["logs/A*/day1.npy", "logs/A1/day1.npy"])] == EVERY[0:4:3]
    assert [log.place for log in find(["logs/**/*.zarr"])] == ["logs/A3.zarr"]
    assert [log.place for log in find(["logs/A1/notes.md"])] == [
        "logs/A1/notes.md"
    ]  # named: the reader says what is wrong


def version(place):
    (log,) = find([place])
    return log.version


@pytest.mark.parametrize(
    ("place", "changed"), [("logs/top.npy", "logs/top.npy"), ("logs/A3.zarr", "logs/A3.zarr/gyro_x/c/0")]
)
def test_versions(folder, place, changed):
    before = version(place)
    assert version(place) == before
    os.utime(changed, ns=(1, 1))
    touched = version(place)
    with open(changed, "ab") as file:  # noqa: PTH123  a path of the test, relative
        file.write(b"more")
    os.utime(changed, ns=(1, 1))
    assert len({before, touched, version(place)}) == 3


def test_refusals(folder):
    with pytest.raises(OptionError, match="name logs, patterns"):
        find([])
    with pytest.raises(DataError, match="no log there"):
        find(["logs/*.bag"])
    with pytest.raises(DataError, match=r"missing\.npy: No such file"):
        find(["missing.npy"])


def test_urls(folder):
    fsspec = pytest.importorskip("fsspec", reason="URLs need the extra cluster")
    memory = fsspec.filesystem("memory")
    for log in find(["logs"]):
        memory.put(log.place, f"/fleet/{log.place}", recursive=True)
    try:
        places = ["memory:///fleet/" + place for place in EVERY]
        assert [log.place for log in find(["memory://fleet/logs"])] == places
        assert [log.place for log in find(["memory://fleet/logs/**"])] == places
        assert [log.place for log in find(["memory://fleet/logs/top.npy"])] == places[-1:]
        assert find(["memory://fleet/logs/A3.zarr"])[0].size == 7
        with pytest.raises(DataError, match=r"memory://fleet/none"):
            find(["memory://fleet/none"])
        with pytest.raises(DataError, match=r"nowhere://x"):
            find(["nowhere://x"])
        with pytest.raises(DataError, match="unpack the archive"):
            find(["zip://*.csv::memory://fleet/all.zip"])
        local = [log.place for log in find([f"file://{folder}/A1/day1.npy"])]
        assert local == [f"file://{folder}/A1/day1.npy"]
    finally:
        memory.rm("/fleet", recursive=True)


def test_links_to_folders_above_are_not_followed(folder):
    """Two such links would lead to every log more often than can be listed."""
    (folder / "A1/up").symlink_to("..")
    (folder / "A2/top").symlink_to(folder)
    for pattern in ("logs", "logs/**", "./logs/**"):
        assert [log.place.removeprefix("./") for log in find([pattern])] == EVERY
    assert [log.place for log in find(["logs/**/day1.npy"])] == ["logs/A1/day1.npy", "logs/A2/day1.npy"]
    assert [log.place for log in find(["**/day1.npy"])] == ["logs/A1/day1.npy", "logs/A2/day1.npy"]


def test_links_to_other_folders_are_followed(folder, tmp_path):
    np.save(tmp_path / "x.npy", np.zeros(10))
    (folder / "A4").symlink_to(folder / "A2")
    (folder / "A2/link.npy").symlink_to(tmp_path / "x.npy")
    found = [log.place for log in find(["logs"])]
    assert found == sorted([*EVERY, "logs/A2/link.npy", "logs/A4/day1.npy", "logs/A4/link.npy"])


def test_what_cannot_be_read_does_not_keep_the_others_back(folder, monkeypatch):
    """It is a log whose reader says why, so that it is a row of the store and not forgotten."""
    (folder / "A1/gone.npy").symlink_to("nowhere.npy")
    listed = os.access
    monkeypatch.setattr("os.access", lambda path, *a, **b: "A2" not in str(path) and listed(path, *a, **b))
    assert [log.place for log in find(["logs"])] == sorted({*EVERY, "logs/A1/gone.npy", "logs/A2"})
    version = {log.place: log.version for log in find(["logs"])}
    np.save(folder / "A1/nowhere.npy", np.zeros(10))
    assert version["logs/A1/gone.npy"] not in [log.version for log in find(["logs/A1/gone.npy"])]
