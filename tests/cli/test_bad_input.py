"""Logs that cannot be read, and outputs that cannot be written: one line and an exit code."""

import gzip
import json
import os
import subprocess
import sys

import pytest
from small_log import run, table


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(table())
    return path


def _gz(text):
    return gzip.compress(text.encode())


ROWS = table().splitlines()
NO_UNITS = table(header="gyro_x,gyro_y,accel_z").encode()


def _with(line, text):
    rows = list(ROWS)
    rows[line] = text
    return "\n".join(rows) + "\n"


# name: (bytes of the file or None for a directory, options, exit code, words that the line must have)
BAD = {
    "empty": (b"", [], 1, ["empty"]),
    "text only": (b"once upon a time\nthere was a gyro\n", [], 1, []),
    "one row": ((ROWS[0] + "\n" + ROWS[1] + "\n").encode(), ["--rate", "100"], 1, ["4"]),
    "three rows": (("\n".join(ROWS[:4]) + "\n").encode(), ["--rate", "100"], 1, ["3", "4"]),
    "short row": (_with(18, "1.0,2.0").encode(), ["--rate", "100"], 1, ["line 19", "2", "3"]),
    "word": (_with(18, "1.0,oops,2.0").encode(), ["--rate", "100"], 1, ["line 19", "oops"]),
    "time backwards": (
        b"time [s],gyro_x [deg/s]\n" + b"".join(b"%.2f,%d\n" % (0.01 * (k if k != 30 else 20), k % 7) for k in range(50)),
        [],
        1,
        ["line 32", "back"],
    ),
    "unknown unit": (NO_UNITS, ["--rate", "100", "--unit", "gyro=furlong,accel=g"], 2, ["furlong"]),
    "no unit": (NO_UNITS, ["--rate", "100"], 2, ["--unit", "gyro"]),
    "no rate": (table().encode(), [], 2, ["--rate"]),
    "wrong column": (table().encode(), ["--rate", "100", "--channels", "gyro_x=omega"], 2, ["omega", "gyro_y"]),
    "directory": (None, ["--rate", "100"], 1, ["directory"]),
    "damaged gzip": (_gz(table(4000))[:-8] + bytes(8), ["--rate", "100"], 1, ["gzip", "compressed"]),
    "one column twice": (table().encode(), ["--rate", "100", "--channels", "gyro_x=1,gyro_y=1"], 2, ["column 1", "twice"]),
    "output no file": (table().encode(), ["--rate", "100", "--plot", "pipe.png"], 1, ["pipe.png", "not a regular file"]),
    "unknown option": (table().encode(), ["--ratte", "100"], 2, ["ratte"]),
    "rate no number": (table().encode(), ["--rate", "fast"], 2, ["fast"]),
    "rate zero": (table().encode(), ["--rate", "0"], 2, ["rate"]),
    "unit without =": (table().encode(), ["--rate", "100", "--unit", "deg/s"], 2, ["--unit"]),
    "taus no number": (table().encode(), ["--rate", "100", "--taus", "often"], 2, ["often"]),
    "tau too long": (table().encode(), ["--rate", "100", "--taus", "100"], 2, ["half the record"]),
    "rate unit for increments": (table().encode(), ["--rate", "100", "--input", "increments"], 2, ["deg/s", "increments"]),
    "figure of unknown kind": (table().encode(), ["--rate", "100", "--plot", "a.bmp"], 2, [".png"]),
    "figure nowhere": (table().encode(), ["--rate", "100", "--plot", "absent/a.png"], 1, ["absent"]),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_input(name, tmp_path, monkeypatch, capsys):
    """One clear line that names the file or option, the documented exit code, and no output but a JSON that says so."""
    content, options, code, words = BAD[name]
    monkeypatch.chdir(tmp_path)
    path = tmp_path / ("log.csv.gz" if name == "damaged gzip" else "log.csv")
    if content is None:
        path.mkdir()
    else:
        path.write_bytes(content)
    outputs = [] if "--plot" in options else ["--plot", "out.png"]
    if name == "output no file":
        os.mkfifo("pipe.png")
    got, out, err = run("analyze", path, *options, *outputs, "--json", "out.json", capsys=capsys)
    assert got == code, err
    assert out == ""
    assert len(err.splitlines()) == 1, err
    assert err.startswith("sigmatau: ")
    assert any(word in err for word in words) if name == "damaged gzip" else all(word in err for word in words), err
    left = {p.name for p in tmp_path.iterdir()} - {"pipe.png", path.name}
    assert left <= {"out.json"}
    if left:  # not for an option that is refused before the log is read
        content = json.loads((tmp_path / "out.json").read_text())
        assert (content["error"]["exit_code"], content["channels"]) == (code, {})


def test_a_log_that_is_cut_off_is_analysed_and_said_so(tmp_path, capsys):
    path = tmp_path / "log.csv.gz"
    path.write_bytes(_gz(table(4000))[:20000])
    code, out, err = run("analyze", path, "--rate", "100", capsys=capsys)
    assert code == 4
    assert "gyro_x" in out
    assert "!! the gzip stream is truncated in line" in err


def test_the_log_is_never_overwritten(log, tmp_path, capsys):
    before = log.read_bytes()
    for option in ("--json", "--plot"):
        name = log if option == "--json" else tmp_path / "log.png"
        if option == "--plot":
            name.hardlink_to(log)
        code, out, err = run("analyze", log, "--rate", 100, option, name, capsys=capsys)
        assert (code, out) == (2, "")
        assert "is the file that is read" in err
    assert log.read_bytes() == before


def test_the_log_is_not_overwritten_by_the_curves_beside_a_csv(tmp_path, capsys):
    log = tmp_path / "run-curves.csv"
    log.write_text(table())
    code, out, err = run("analyze", log, "--rate", 100, "--csv", tmp_path / "run.csv", capsys=capsys)
    assert (code, out) == (2, "")
    assert "run-curves.csv is the file that is read" in err
    assert log.read_text() == table()
    files = ("--csv", tmp_path / "r.csv", "--json", tmp_path / "r-curves.csv")
    code, out, err = run("analyze", log, "--rate", 100, *files, capsys=capsys)
    assert (code, out) == (2, "")
    assert "both name" in err


def test_full_disk(log):
    with open("/dev/full", "w") as full:  # noqa: PTH123
        done = subprocess.run(
            [sys.executable, "-m", "sigmatau", "analyze", str(log), "--rate", "100", "--method", "read-off"],
            stdout=full, stderr=subprocess.PIPE, text=True, check=False,
        )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr.startswith("sigmatau: standard output cannot be written")
    assert len(done.stderr.splitlines()) == 1
