"""One rule for foreign, empty and unreadable files in folders of logs: `analyze`, `lot` and `fleet` treat them alike."""

import sqlite3

import numpy as np
import pytest

from known import seed_of
from sigmatau.cli import main

UNITS = ("SN1.csv", "SN2.csv", "SN3.csv")
FOREIGN = ("README.txt", "datasheet.toml", "photo.jpg", "lab.db")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Three logs beside everything that is no log."""
    monkeypatch.chdir(tmp_path)
    place = tmp_path / "logs"
    place.mkdir()
    rng = np.random.default_rng(seed_of("folder of logs"))
    for name in UNITS:
        values = rng.normal(0, 1e-4, (2000, 1))
        np.savetxt(place / name, values, header="gyro_x [rad/s]", comments="", fmt="%.6g")
    (place / "README.txt").write_text("Logs of the first shift.\nThe lid was open.\n")
    (place / "datasheet.toml").write_text('name = "Unit 7"\n')
    (place / "photo.jpg").write_bytes(b"\xff\xd8\xff\xe0" + bytes(60))
    (place / ".DS_Store").write_bytes(bytes(60))
    (place / "result.json").write_text('{"schema": 1, "sigmatau": "0.1.0", "channels": {}}')
    with sqlite3.connect(place / "lab.db") as base:
        base.execute("CREATE TABLE run (id INTEGER)")
    return place


COMMANDS = {
    "analyze": ["analyze", "logs", "--rate", "10"],
    "lot": ["lot", "logs", "--rate", "10"],
    "fleet": ["fleet", "analyze", "logs", "--rate", "10", "--store", "results.db", "--workers", "1"],
}


def run(command, capsys):
    code = main(COMMANDS[command])
    return code, *capsys.readouterr()


@pytest.mark.parametrize("command", COMMANDS)
class TestEveryCommand:
    def test_foreign_files_are_named_and_change_nothing(self, command, folder, capsys):
        code, out, err = run(command, capsys)
        assert code == {"analyze": 0, "lot": 4, "fleet": 0}[command]  # lot: no unit is judged without a specification
        (line,) = (line for line in err.splitlines() if "skipped, not a log: " in line)
        named = line.partition("skipped, not a log: ")[2].split(", ")
        assert sorted(place.rpartition("/")[2] for place in named) == sorted(FOREIGN)
        assert "result.json" not in err
        assert "skipped, written by sigmatau: 1 file" in err
        assert ".DS_Store" not in err + out
        assert "failed" not in out

    def test_an_empty_a_damaged_and_a_missing_log_fail(self, command, folder, capsys):
        (folder / "SN4.csv").touch()
        (folder / "SN5.csv").symlink_to("nowhere.csv")
        (folder / "SN6.npy").write_bytes(b"\x93NUMPY bad")
        code, out, err = run(command, capsys)
        assert code == {"analyze": 1, "lot": 4, "fleet": 1}[command]
        for name, reason in (("SN4.csv", "empty"), ("SN5.csv", ""), ("SN6.npy", "")):
            assert name in out + err
            assert reason in out + err

    def test_nothing_but_foreign_files(self, command, folder, capsys):
        for name in UNITS:
            (folder / name).unlink()
        (folder / "result.json").unlink()
        code, _, err = run(command, capsys)
        assert code == 1
        assert "no log" in err


@pytest.mark.parametrize("command", COMMANDS)
def test_a_file_that_is_named_is_read(command, folder, capsys):
    words = [word if word != "logs" else "logs/README.txt" for word in COMMANDS[command]]
    assert main(words) == {"analyze": 1, "lot": 4, "fleet": 1}[command]
    out, err = capsys.readouterr()
    assert "README.txt" in out + err
    assert "skipped" not in err


def test_of_a_pattern_in_quotes_foreign_files_are_skipped(folder, capsys):
    assert main(["analyze", "logs/*", "--rate", "10", "--jobs", "1"]) == 0
    assert "README.txt" in capsys.readouterr().err
