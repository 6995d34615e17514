"""`sigmatau lot` on logs: a simulated lot of 40 units of which six are not good, by default settings."""

import hashlib
import json
import re
import shutil
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from known import interruptible
from lot_logs import BAD, EMPTY, NAMES, SPEC, SPIKES, TRUNCATED, UNITS, WRONG_UNIT, rates, write_log, write_lot
from sigmatau.cli import batch, main

ODD = {BAD: "failed", SPIKES: "not_judged", WRONG_UNIT: "failed", TRUNCATED: "not_judged", EMPTY: "unreadable"}


@pytest.fixture(scope="module")
def lot(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lot") / "shift"
    write_lot(folder)
    return folder


@pytest.fixture(scope="module")
def analysed():
    """Analyses by command, log and its content."""
    return {}


@pytest.fixture
def in_process(monkeypatch, analysed):
    """Logs analysed here, because processes take a second each to start; the same content under the same name once."""

    def run(logs, work, *, jobs, keep=None):
        def once(log):
            if not log.is_file():
                return work(log)
            key = (repr(work), str(log), hashlib.sha256(log.read_bytes()).digest())
            if key not in analysed:
                analysed[key] = work(log)
            return analysed[key]

        for log in logs:
            yield batch._outcome(log, once, keep)

    monkeypatch.setattr(batch, "run", run)


def run(*argv, capsys):
    code = main(["lot", *map(str, argv)])
    return code, *capsys.readouterr()


def check(content, numbers=range(1, UNITS)):
    """Each unit is named for what it is, and one is missing."""
    units = {one["name"]: one for one in content["units"]}
    assert len(units) == len(numbers) + 1
    for k in numbers:
        assert units[f"unit{k:02}.csv"]["state"] == ODD.get(k, "passed"), units[f"unit{k:02}.csv"]["reason"]
    assert units["(missing 1)"]["state"] == "missing"
    codes = {k: [remark["code"] for remark in units[f"unit{k:02}.csv"]["remarks"]] for k in ODD}
    assert codes[BAD][0] == "above_maximum"
    assert "other_scale" in codes[BAD]
    assert codes[SPIKES][0] == "spikes"
    assert codes[WRONG_UNIT][0] == "other_scale"
    assert "deg/s read as rad/s?" in units[f"unit{WRONG_UNIT:02}.csv"]["reason"]
    assert {"short_record", "damaged"} <= set(codes[TRUNCATED])
    assert "truncated" in units[f"unit{TRUNCATED:02}.csv"]["reason"]
    assert units[f"unit{EMPTY:02}.csv"]["reason"] == "is empty"
    assert content["counts"] == {
        "failed": 2,
        "not_judged": 2,
        "unreadable": 1,
        "missing": 1,
        "passed": len(numbers) - 5,
    }
    assert content["exit_code"] == 3


@pytest.mark.usefixtures("in_process")
def test_each_of_40_units_is_named_for_what_it_is_twice_in_a_row(lot, tmp_path, monkeypatch, capsys):
    shutil.copytree(lot, tmp_path / "shift")
    monkeypatch.chdir(tmp_path / "shift")
    (tmp_path / "shift" / "spec.toml").write_text(SPEC, encoding="utf-8")
    files = ("lot.json", "lot.html", "lot.csv", "lot.xml", "lot.pdf")
    options = [part for name in files for part in ("-o", name)]
    before = None
    for _ in range(2):  # the second time beside the files of the first
        code, out, _ = run(".", "--spec", "spec.toml", "--expect", UNITS, *options, "--results", "r", capsys=capsys)
        assert code == 3
        content = json.loads((tmp_path / "shift" / "lot.json").read_text())
        check(content)
        assert before is None or content == before
        before = content
        assert all((tmp_path / "shift" / name).stat().st_size for name in files)
    lines = out.splitlines()
    head = "40 units against Unit 7: 2 failed, 2 not judged, 1 failed to read, 1 missing, 34 passed"
    assert " ".join(lines[:2]).replace("   ", " ") == head
    rows = [line.split()[:2] for line in lines[2:] if line.startswith("failed  ")]  # a long reason has several lines
    assert rows == [["failed", "unit05.csv"], ["failed", "unit18.csv"]]
    above = "gyro x: angle random walk 0.654 [0.624, 0.690] deg/√h is 4.1 times the maximum 0.16 deg/√h"
    assert above in " ".join(out.split())
    assert len(lines) <= 23
    assert max(map(len, lines)) <= 80, out
    suite = ET.parse(tmp_path / "shift" / "lot.xml").getroot()
    assert (suite.get("tests"), suite.get("failures"), suite.get("errors")) == ("40", "2", "4")
    # Of the results alone, the same is said; a log that failed has no result of an earlier run.
    code, out, _ = run("r", "--spec", "spec.toml", "--expect", UNITS, "-o", "again.json", capsys=capsys)
    assert code == 3
    check(json.loads((tmp_path / "shift" / "again.json").read_text()))
    # A unit that passed and whose log is damaged afterwards does not pass by its earlier result.
    (tmp_path / "shift" / "unit01.csv").write_text("time [s],gyro_x [rad/s]\n1,x\n")
    run(".", "--spec", "spec.toml", "--expect", UNITS, "-o", "lot.json", "--results", "r", "-q", capsys=capsys)
    states = {one["name"]: one["state"] for one in json.loads((tmp_path / "shift" / "lot.json").read_text())["units"]}
    assert states["unit01.csv"] == "unreadable"
    assert json.loads((tmp_path / "shift" / "r" / "unit01.csv.json").read_text())["channels"] == {}


@pytest.mark.usefixtures("in_process")
def test_fail_on_warning(lot, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(lot)
    argv = (".", "--spec", lot.parent / "spec.toml", "--fail-on", "warning", "-o", tmp_path / "lot.json", "-q")
    assert run(*argv, capsys=capsys)[0] == 3
    content = json.loads((tmp_path / "lot.json").read_text())
    failed = [one["name"] for one in content["units"] if one["state"] == "failed"]
    assert failed == [f"unit{k:02}.csv" for k in sorted((BAD, SPIKES, WRONG_UNIT, TRUNCATED))]


@pytest.mark.usefixtures("in_process")
def test_without_a_specification_the_odd_ones_are_named(lot, monkeypatch, capsys):
    monkeypatch.chdir(lot)
    code, out, _ = run(".", "--expect", UNITS, capsys=capsys)
    assert code == 4
    assert out.startswith("40 units without a specification: 38 not judged, 1 failed to read, 1 missing")
    for k in (BAD, SPIKES, WRONG_UNIT, TRUNCATED, EMPTY):
        assert f"unit{k:02}.csv" in out
    assert "unit01.csv" not in out


def test_interrupted(lot, tmp_path):
    """After Ctrl-C no output of this run is half written, and none of an earlier run counts; the next run is whole."""
    some = sorted({*range(1, 13), *ODD})
    (tmp_path / "shift").mkdir()
    for k in some:
        shutil.copy(lot / f"unit{k:02}.csv", tmp_path / "shift")
    command = [sys.executable, "-m", "sigmatau", "lot", "shift", "--spec", str(lot.parent / "spec.toml"), "--jobs", "2"]
    outputs = ["-o", "lot.json", "-o", "lot.html", "--results", "r"]
    old = {"lot.json": '{\n "lot": 1,\n "sigmatau": "0.1.0"}\n', "lot.html": _OLD_PAGE}
    for name, text in old.items():
        (tmp_path / name).write_text(text)
    process = subprocess.Popen(
        [*command, *outputs],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=interruptible,
    )
    deadline = time.monotonic() + 60
    while not list((tmp_path / "r").glob("*.json")) and time.monotonic() < deadline:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    assert not (tmp_path / "lot.json").exists()
    assert not (tmp_path / "lot.html").exists()
    for file in (tmp_path / "r").iterdir():
        if not file.name.startswith("."):  # what a worker was writing, which the next run removes and no run reads
            json.loads(file.read_text())  # each is whole
    done = subprocess.run(
        [*command, *outputs, "--expect", str(len(some) + 1)], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 3, done.stderr
    check(json.loads((tmp_path / "lot.json").read_text()), some)


_OLD_PAGE = (
    '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><meta name="generator" content="sigmatau 0.1.0">'
)


@pytest.mark.usefixtures("in_process")
class TestOptions:
    def test_a_missing_option_is_one_error(self, tmp_path, capsys):
        for k in range(5):
            np.savetxt(
                tmp_path / f"u{k}.csv", rates(k, duration=20), delimiter=",", header=",".join(NAMES), comments=""
            )
        code, out, err = run(tmp_path, "-o", tmp_path / "lot.json", capsys=capsys)
        assert (code, out) == (2, "")
        assert err.count("\n") == 1
        assert "u0.csv" in err
        assert "--rate" in err or "--unit" in err
        assert not (tmp_path / "lot.json").exists()

    def test_one_log_that_needs_an_option_is_a_unit_that_failed_to_read(self, tmp_path, capsys):
        for k in (1, 2):
            write_log(tmp_path / f"u{k}.csv", rates(k, duration=60))
        np.savetxt(tmp_path / "u0.csv", rates(3, duration=20), delimiter=",", header=",".join(NAMES), comments="")
        code, out, _ = run(tmp_path, capsys=capsys)
        assert code == 4
        assert re.search(r"^failed to read  u0.csv", out, flags=re.MULTILINE)

    def test_names_of_the_units_expected(self, tmp_path, capsys):
        for k in (1, 2):
            write_log(tmp_path / f"u{k}.csv", rates(k, duration=60))
        (tmp_path / "units.txt").write_text("# shift 3\nu1\nu2\n\nu3\n", encoding="utf-8")
        code, out, _ = run(tmp_path / "u1.csv", tmp_path / "u2.csv", "--expect", tmp_path / "units.txt", capsys=capsys)
        assert code == 4
        assert re.search(r"^missing +u3 ", out, flags=re.MULTILINE)

    def test_units_in_paths(self, tmp_path, capsys):
        dated, logs = ["SN1_2026-05-04.csv", "SN2_2026-05-04.csv"], tmp_path / "logs"
        logs.mkdir()
        for name in dated:
            write_log(logs / name, rates(int(name[2]), duration=60))
        (tmp_path / "units.txt").write_text("SN1\nSN2\nSN3\n", encoding="utf-8")
        options = ("--expect", tmp_path / "units.txt", "--json")
        for choice, names in (
            ((), dated),
            (("--unit-from", r"(SN\d+)"), ["SN1", "SN2"]),
        ):
            _, out, err = run(logs, *options, *choice, capsys=capsys)
            units = json.loads(out)["units"]
            assert [one["name"] for one in units] == [*names, "SN3"]
            assert [one["state"] for one in units][2] == "missing"
            assert not any(remark["code"] == "not_expected" for one in units for remark in one["remarks"])
            assert ("--unit-from" in err) == (not choice)
        code, _, err = run(logs, "--unit-from", "(2026)", capsys=capsys)
        assert (code, "give one log of each unit" in " ".join(err.split())) == (2, True)
        code, _, err = run(logs, "--unit-from", "(absent)", capsys=capsys)
        assert (code, "finds no unit" in " ".join(err.split())) == (2, True)

    def test_a_named_log_that_is_not_there_is_missing(self, tmp_path, capsys):
        write_log(tmp_path / "u1.csv", rates(1, duration=60))
        code, out, _ = run(tmp_path / "u1.csv", tmp_path / "u2.csv", capsys=capsys)
        assert code == 4
        assert re.search(r"^missing +u2.csv", out, flags=re.MULTILINE)

    def test_the_page_links_to_the_reports(self, tmp_path, capsys, monkeypatch):
        """A log that cannot be used has no report, and its unit no link; numbers of the CSV have decimal commas."""
        monkeypatch.chdir(tmp_path)
        (tmp_path / "out").mkdir()
        write_log(Path("u1.csv"), rates(1, duration=60))
        Path("u2.csv").write_text("")
        outputs = ("-o", "out/lot.html", "-o", "out/lot.csv", "--reports", "pages", "--decimal-comma")
        assert run("u1.csv", "u2.csv", *outputs, capsys=capsys)[0] == 4
        assert [file.name for file in Path("pages").iterdir()] == ["u1.csv.html"]
        assert "noise report" in Path("pages/u1.csv.html").read_text()
        assert re.findall(r'href="([^#"]+)"', Path("out/lot.html").read_text()) == ["../pages/u1.csv.html"]
        (walk,) = [line for line in Path("out/lot.csv").read_text().splitlines() if "gyro_x;random_walk" in line]
        assert re.fullmatch(r"u1.csv;.*;gyro_x;random_walk;(\d,\d+e-\d+;){3};rad/sqrt\(s\)", walk)
        code, _, err = run("--store", "lab.db", "--reports", "pages", capsys=capsys)
        assert (code, "a store has only results" in err) == (2, True)

    def test_a_pattern_that_the_shell_left(self, tmp_path, capsys):
        for k in (1, 2, 10):
            write_log(tmp_path / f"u{k}.csv", rates(k, duration=60))
        _, out, _ = run(tmp_path / "u?.csv", tmp_path / "u1[0-9].csv", "--json", capsys=capsys)
        assert [one["name"] for one in json.loads(out)["units"]] == ["u1.csv", "u2.csv", "u10.csv"]

    @pytest.mark.parametrize(
        ("argv", "code", "words"),
        [
            (("*.npy",), 1, "*.npy: no file matches this pattern"),
            ((), 2, "name the logs or results"),
            (("empty",), 1, "empty: no log in this folder"),
            (("u1.csv", "u1.csv"), 2, "u1.csv is given twice"),
            (("u1.csv", "--expect", "0"), 2, "at least 1"),
            (("u1.csv", "--expect", "forty"), 2, "must be a number of units, or the name of a file"),
            (("u1.csv", "--expect", "none.txt"), 1, "names no unit"),
            (("u1.csv", "--spec", "nonesuch"), 2, "unknown datasheet 'nonesuch'"),
            (("u1.csv", "--spec", "none.toml"), 1, "none.toml: No such file"),
            (("u1.csv", "-o", "lot.doc"), 2, "must end in .html"),
            (("u1.csv", "-o", "a.html", "-o", "./a.html"), 2, "names a file twice"),
            (("u1.csv", "-o", "u1.csv"), 2, "is the file that is read"),
            (("u1.csv", "--level", "1.5"), 2, "--level must"),
            (("u1.csv", "--factor", "0.1"), 2, "--factor must"),
            (("u1.csv", "--accept", "nonesuch"), 2, "unknown code 'nonesuch'"),
            (("u1.csv", "--jobs", "0"), 2, "--jobs 0"),
            (("none", "--results", "u1.csv"), 2, "must be a folder"),
        ],
    )
    def test_refusals(self, argv, code, words, tmp_path, monkeypatch, capsys):
        monkeypatch.chdir(tmp_path)
        write_log(tmp_path / "u1.csv", rates(1, duration=20))
        (tmp_path / "empty").mkdir()
        (tmp_path / "none.txt").write_text("# nothing\n")
        found, _, err = run(*argv, capsys=capsys)
        assert found == code
        assert words in err
        assert err.count("\n") == 1

    def test_an_empty_folder_of_which_units_are_expected(self, tmp_path, capsys):
        (tmp_path / "shift").mkdir()
        code, out, _ = run(tmp_path / "shift", "--expect", 3, capsys=capsys)
        assert code == 4
        assert out.startswith("3 units without a specification: 3 missing")

    def test_names_cannot_forge_anything(self, tmp_path, monkeypatch, capsys):
        """Of files whose names hold markup, an escape sequence, and a line end."""
        monkeypatch.chdir(tmp_path)
        names = ["<script>alert(1)<!script>.csv", "x\nu9  passed\x1b[31m.csv", '"]]>&amp;.csv', "#box[x] $y$ *z*.csv"]
        for k, name in enumerate(names):
            write_log(tmp_path / name, rates(k, duration=60))
        outputs = ("lot.html", "lot.pdf", "lot.xml", "lot.csv", "lot.json")
        code, out, _ = run(".", *[part for name in outputs for part in ("-o", name)], "-v", capsys=capsys)
        assert code == 4
        assert "\x1b" not in out
        page = (tmp_path / "lot.html").read_text()
        assert "<script>alert(1)" not in page
        assert "\x1b" not in page
        suite = ET.parse(tmp_path / "lot.xml").getroot()
        assert len(suite.findall("./testsuite/testcase")) == len(names)
        assert [one["name"] for one in json.loads((tmp_path / "lot.json").read_text())["units"]] == sorted(names)
