"""analyze with several logs: one process, one JSON each; a summary; an exit code that says if any failed."""

import json
from pathlib import Path

import numpy as np
import pytest
from doomed import ended, killed, refused

import known
import sigmatau as st
from sigmatau.cli import batch, main
from sigmatau.errors import DataError, OptionError
from sigmatau.io.folders import gather


def write(path, seed, n=2000):
    columns = np.c_[np.arange(n) / 100, np.random.default_rng(known.seed_of(seed)).standard_normal(n)]
    header = "time [s],gyro_x [deg/s]"
    np.savetxt(path, columns, delimiter=",", header=header, comments="", fmt="%.6f")
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("logs")
    for name in ("b", "a"):
        write(path / f"{name}.csv", name)
    (path / "bad.csv").write_text("time [s],gyro_x [deg/s]\n1,2\nx,3\n")
    (path / "notes.md").write_text("# what was done")
    (path / ".hidden").write_text("x")
    return path


def run(*argv, capsys):
    code = main([str(a) for a in argv])
    return code, *capsys.readouterr()


@pytest.fixture
def in_process(monkeypatch):
    """Logs analysed here, one after the other, where the processes are not what is tested: each takes a second to start."""

    def run(logs, work, *, jobs, keep=None):
        for log in logs:
            yield batch._outcome(log, work, keep)

    monkeypatch.setattr(batch, "run", run)


@pytest.mark.usefixtures("in_process")
class TestSummary:
    def test_read_off_order_and_figures(self, folder, tmp_path, capsys):
        logs = [folder / "b.csv", folder / "a.csv"]
        code, out, _ = run("analyze", *logs, "--plot", tmp_path / "p", "--method", "read-off", "-q", capsys=capsys)
        assert code == 0
        assert sorted(f.name for f in (tmp_path / "p").iterdir()) == ["a.csv.png", "b.csv.png"]
        assert out.index("b.csv") < out.index("a.csv")
        assert out.count("read off") == 2
        assert " ± " in out

    def test_curves_in_one_figure(self, folder, tmp_path, capsys):
        logs, figure = [folder / "b.csv", folder / "bad.csv", folder / "a.csv"], tmp_path / "all.svg"
        code, _, _ = run("analyze", *logs, "--overlay", figure, "--method", "read-off", "-q", capsys=capsys)
        assert code == 1  # bad.csv
        text = figure.read_text()
        assert "<!-- b.csv -->" in text
        assert "<!-- a.csv -->" in text
        assert "bad.csv" not in text
        for argv, words in (
            ((folder / "a.csv", "--overlay", figure), "--overlay takes several logs"),
            ((*logs, "--overlay", tmp_path / "all.txt"), "must end in"),
        ):
            code, _, err = run("analyze", *argv, capsys=capsys)
            assert code == 2
            assert words in err

    def test_what_is_only_told_needs_verbose(self, tmp_path, capsys):
        """A spike that is left out."""
        for name in "ab":
            path = write(tmp_path / f"{name}.csv", name)
            lines = path.read_text().splitlines()
            path.write_text("\n".join([*lines[:1001], "10.000000,50", *lines[1002:], ""]))
        logs = (tmp_path / "a.csv", tmp_path / "b.csv")
        _, _, short = run("analyze", *logs, capsys=capsys)
        _, _, whole = run("analyze", *logs, "--verbose", capsys=capsys)
        assert "info: " in whole
        assert short.splitlines() == [line for line in whole.splitlines() if "info: " not in line]

    def test_length_rate_and_damage(self, tmp_path, capsys):
        for name, seed in (("a.csv", "a"), ("b.csv", "b")):
            write(tmp_path / name, seed)
        text = (tmp_path / "b.csv").read_text().rpartition(",")[0]
        (tmp_path / "b.csv").write_text(text)  # broken off
        code, out, _ = run("analyze", tmp_path, "-q", "--method", "read-off", capsys=capsys)
        assert code == 4
        whole, broken = (
            next(line for line in out.splitlines() if line.startswith(name)) for name in ("a.csv", "b.csv")
        )
        assert "20 s" in whole
        assert "100 Hz" in whole
        assert "DAMAGED" not in whole
        assert broken.endswith("DAMAGED")


class TestCommand:
    def test_a_folder(self, folder, tmp_path, capsys):
        results = tmp_path / "r"
        code, out, err = run("analyze", folder, "--jobs", 2, "--json", results, "--method", "read-off", capsys=capsys)
        assert code == 1
        assert [line.split()[0] for line in out.splitlines() if line and line[0] != " "] == [
            "log", "a.csv", "b.csv", "bad.csv", "2",
        ]  # fmt: skip
        assert "2 of 3 logs analysed" in out
        assert "bad.csv, line 3: column time [s] has 'x'" in err
        assert f"skipped, not a log: {folder / 'notes.md'}" in err
        assert sorted(f.name for f in results.iterdir()) == ["a.csv.json", "b.csv.json", "bad.csv.json"]
        failed = json.loads((results / "bad.csv.json").read_text())
        assert (failed["error"]["exit_code"], failed["channels"]) == (1, {})
        assert "line 3: column time [s] has 'x'" in failed["error"]["message"]
        alone = st.analyze(st.read(folder / "a.csv"), method="read-off").to_dict()
        assert json.loads((results / "a.csv.json").read_text()) == json.loads(json.dumps(alone))

    def test_one_in_a_pattern(self, folder, tmp_path, capsys):
        options = ("--jobs", 4, "--json", tmp_path, "--method", "read-off", "-q")
        assert run("analyze", folder / "a.csv", *options, capsys=capsys)[0] == 0
        assert (tmp_path / "a.csv.json").exists()

    @pytest.mark.parametrize(
        ("argv", "words"),
        [
            (["a.csv", "b.csv", "--json", "x.json"], "must be a folder"),
            (["a.csv", "b.csv", "--json", "-"], "must be a folder"),
            (["a.csv", "b.csv", "--csv", "x.csv"], "must be a folder"),
            (["a.csv", "a.csv"], "given twice"),
            (["a.csv", "b.csv", "--jobs", "0"], "--jobs 0"),
            (["a.csv", "--unit", "gyro", "deg/s"], "--unit 'gyro': must be NAME=VALUE"),
            (["a.csv", "b.csv", "--channels", "gyro=wx,wy,wz"], "'gyro=wx,wy,wz': 'wy' must be NAME=VALUE"),
            ([], "name a log"),
        ],
    )
    def test_wrong_options(self, folder, monkeypatch, capsys, argv, words):
        monkeypatch.chdir(folder)
        code, out, err = run("analyze", *argv, capsys=capsys)
        assert (code, out) == (2, "")
        assert words in err


class TestProcesses:
    def test_one_that_dies_does_not_end_the_others(self, folder):
        (outcome,) = batch.run([folder / "a.csv"], killed, jobs=1)
        assert "ended by SIGKILL" in str(outcome.error)
        assert outcome.code == 1
        assert [one.code for one in batch.run([folder / "a.csv", folder / "b.csv"], killed, jobs=1)] == [1, 1]
        (outcome,) = batch.run([folder / "a.csv"], ended, jobs=1)
        assert "exit code 7" in str(outcome.error)

    def test_an_option(self, folder):
        outcomes = list(batch.run([folder / "a.csv", folder / "b.csv"], refused, jobs=2))
        assert [(o.code, str(o.error)) for o in outcomes] == [(2, "no such unit")] * 2


class TestNames:
    def test_short_but_distinct(self):
        assert batch.names([Path("/d/a.csv"), Path("/d/b.csv")]) == ["a.csv", "b.csv"]
        assert batch.names([Path("/d/1/a.csv"), Path("/d/2/a.csv")]) == ["1_a.csv", "2_a.csv"]
        assert batch.names([Path("/d/1/a"), Path("/d/1_a"), Path("/d/2/a")]) == ["1_a-1", "1_a-2", "2_a"]

    def test_gather(self, folder, tmp_path):
        logs, skipped = gather([folder])
        assert [log.name for log in logs] == ["a.csv", "b.csv", "bad.csv"]
        assert [file.name for file in skipped] == ["notes.md"]
        assert gather([folder, folder / "a.csv"])[0] == logs
        with pytest.raises(OptionError, match="given twice"):
            gather([folder / "a.csv", folder / "a.csv"])
        empty = tmp_path / "none"
        empty.mkdir()
        with pytest.raises(DataError, match="no log"):
            gather([empty])

    def test_folders_in_folders(self, tmp_path, monkeypatch):
        (tmp_path / "d" / "day 1").mkdir(parents=True)
        (tmp_path / "d" / ".cache").mkdir()
        write(tmp_path / "d" / ".cache" / "x.csv", "c", n=10)
        write(tmp_path / "d" / "b.csv", "b", n=10)
        write(tmp_path / "d" / "day 1" / "a.csv", "a", n=10)
        (tmp_path / "d" / "day 1" / "up").symlink_to(tmp_path / "d")
        (tmp_path / "d" / "notes.txt").write_text("Night 1: the lid was open.\nTemperature 21 degrees.\n")
        (tmp_path / "d" / "photo").write_bytes(b"\xff\xd8\xff\xe0" + bytes(50))
        (tmp_path / "d" / "empty").write_bytes(b"")
        (tmp_path / "d" / "header.csv").write_text("time,gyro_x\n")
        logs, skipped = gather([tmp_path / "d"])
        assert [log.name for log in logs] == ["b.csv", "empty", "header.csv", "a.csv"]
        assert [file.name for file in skipped] == ["notes.txt", "photo"]
        # What is named is read, whatever it is; and once, however it is named.
        assert gather([tmp_path / "d" / "notes.txt"]) == ([tmp_path / "d" / "notes.txt"], [])
        monkeypatch.chdir(tmp_path / "d")
        assert gather([Path("b.csv"), tmp_path / "d" / "b.csv"])[0] == [Path("b.csv")]


@pytest.fixture(scope="module")
def one_unit(tmp_path_factory):
    """Four logs of one unit; the stamps of one are of a clock that is 3 % slow."""
    path = tmp_path_factory.mktemp("unit")
    for k, rate in enumerate((100, 100, 97, 100)):
        rng = np.random.default_rng(known.seed_of(f"log of a clock {k}"))
        t = np.arange(30_000) / 100
        lines = 0.2 * np.sin(2 * np.pi * 11.3 * t) + 0.2 * np.sin(2 * np.pi * 31.7 * t)
        axes = {f"gyro_{axis}": lines + rng.standard_normal(len(t)) for axis in "xyz"}
        np.savez(path / f"log{k}.npz", time=t * 100 / rate, **axes)
    return path


def test_a_clock_that_is_off(one_unit, tmp_path, in_process, capsys):
    """analyze names the log, compare its result."""
    options = ("--unit", "gyro=deg/s,time=s", "--json", tmp_path)
    code, _, err = run("analyze", one_unit, *options, capsys=capsys)
    assert code == 0
    (line,) = (line for line in err.splitlines() if "its clock is off" in line)
    assert line.startswith(f"{one_unit / 'log2.npz'}: warning: its clock is off: ")
    _, out, err = run("compare", *sorted(tmp_path.glob("*.json")), "--json", "-", capsys=capsys)
    assert "log2.npz: warning: its clock is off" in err
    (off,) = json.loads(out)["clocks_off"].values()
    assert off["details"]["factor"] == pytest.approx(0.97, abs=0.003)
