"""Results of an earlier run: none stays in place of that of a run that failed, and none is read as a log."""

import shutil

import numpy as np
import pytest

from known import seed_of
from sigmatau import Choices, NoiseModel, export
from sigmatau.cli import main
from sigmatau.exporting.targets import NAMES, target
from sigmatau.io.written import is_result

OUTPUTS = {"--json": "r.json", "--csv": "r.csv", "--plot": "r.png", "--stability": "r.pdf", "--export": "kalibr=r.yaml"}
WRITTEN = {"r.json", "r.csv", "r-curves.csv", "r.png", "r.pdf", "r.yaml"}


def run(*argv, capsys):
    code = main([str(a) for a in argv])
    return code, *capsys.readouterr()


def write_log(path, *, rows=3000, moving=False):
    y = np.random.default_rng(seed_of("earlier")).standard_normal((rows, 6)) * [*[0.01] * 3, *[0.1] * 3]
    y[:, 5] += 9.8
    if moving:
        y[:, 0] += 2 * np.sin(np.arange(rows) / 30)
    header = ",".join([*(f"gyro_{a} [rad/s]" for a in "xyz"), *(f"accel_{a} [m/s^2]" for a in "xyz")])
    np.savetxt(path, y, delimiter=",", header=header, comments="")


@pytest.fixture(scope="module")
def analysed(tmp_path_factory):
    """A log, and all results of it."""
    folder = tmp_path_factory.mktemp("analysed")
    write_log(folder / "log.csv")
    options = [part for pair in OUTPUTS.items() for part in pair]
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert main(["analyze", "log.csv", "--rate", "100", *options]) == 0
    assert {file.name for file in folder.iterdir()} == {"log.csv", *WRITTEN}
    return folder


@pytest.fixture
def folder(analysed, tmp_path, monkeypatch):
    """A copy of them, where the command runs."""
    shutil.copytree(analysed, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def again(log, capsys):
    options = [part for pair in OUTPUTS.items() for part in pair]
    return run("analyze", log, "--rate", "100", *options, capsys=capsys)


class TestFailure:
    def test_leaves_no_result_of_before(self, folder, capsys):
        (folder / "bad.csv").write_text("gyro_x [rad/s]\n1\n")
        code, _, err = again("bad.csv", capsys)
        assert code == 1
        removed = next(
            line for line in err.splitlines() if line.startswith("removed, because an earlier run wrote it: ")
        )
        assert set(removed.partition(": ")[2].split(", ")) == WRITTEN - {"r.json"}
        assert {file.name for file in folder.iterdir()} == {"log.csv", "bad.csv", "r.json"}
        assert '"error"' in (folder / "r.json").read_text()

    def test_files_of_others_stay(self, folder, capsys):
        (folder / "bad.csv").write_text("gyro_x [rad/s]\n1\n")
        for name in WRITTEN - {"r.json"}:
            (folder / name).write_bytes(b"mine, not written by another program\n")
        assert again("bad.csv", capsys)[0] == 1
        assert {file.name for file in folder.iterdir()} == {"log.csv", "bad.csv", *WRITTEN}

    def test_by_a_missing_option(self, folder, capsys):
        code, _, err = run("analyze", "log.csv", "--plot", "r.png", capsys=capsys)
        assert code == 2
        assert "removed, because an earlier run wrote it: r.png" in err
        assert not (folder / "r.png").exists()

    def test_before_the_run_removes_nothing(self, folder, capsys):
        for options in (
            ("--csv", "r.csv", "--json", "r.csv"),
            ("--json", "r.json", "--taus", "x"),
            ("--jsn", "r.json"),
        ):
            code, _, err = run("analyze", "log.csv", *options, capsys=capsys)
            assert code == 2
            assert "removed" not in err
        assert {file.name for file in folder.iterdir()} == {"log.csv", *WRITTEN}

    def test_no_export_of_motion(self, folder, capsys):
        write_log(folder / "moving.csv", moving=True)
        code, _, err = run("analyze", "moving.csv", "--rate", "100", "--export", "kalibr=r.yaml", capsys=capsys)
        assert code == 5
        assert "nothing to export" in err
        assert not (folder / "r.yaml").exists()

    def test_of_one_of_several_logs(self, folder, capsys):
        write_log(folder / "other.csv")
        options = ("--rate", "100", "--csv", "t", "--plot", "p", "--json", "j")
        assert run("analyze", "log.csv", "other.csv", *options, capsys=capsys)[0] == 0
        (folder / "other.csv").write_text("gyro_x [rad/s]\n1\n")
        code, _, err = run("analyze", "log.csv", "other.csv", *options, capsys=capsys)
        assert code == 1
        assert "removed, because an earlier run wrote it: other.csv.png, other.csv.csv, other.csv-curves.csv" in err
        assert sorted(file.name for file in (folder / "t").iterdir()) == ["log.csv-curves.csv", "log.csv.csv"]
        assert '"error"' in (folder / "j" / "other.csv.json").read_text()

    @pytest.mark.parametrize(
        "command",
        [
            ("export", "bad.json", "--to", "kalibr", "-o", "r.yaml"),
            ("psd", "bad.json", "--plot", "r.png"),
            ("deviation", "bad.json", "--kind", "hadamard", "--json", "r.json"),
            ("predict", "bad.json", "--after", "1s", "--plot", "r.png"),
            ("inspect", "bad.json", "--json", "r.json"),
        ],
    )
    def test_of_other_commands(self, folder, command, capsys):
        (folder / "bad.json").write_text("{}")
        assert run(*command, capsys=capsys)[0] == 1
        assert not (folder / command[-1]).exists()


def test_a_folder_with_results_has_one_log(folder, capsys):
    code, out, err = run("analyze", folder, "--rate", "100", "--jobs", "1", capsys=capsys)
    assert code == 0
    assert "1 of 1 logs analysed" in out
    assert "skipped, written by sigmatau: 6 files" in err


@pytest.mark.parametrize("name", NAMES)
def test_every_export_is_recognised(tmp_path, name):
    terms = {"random_walk": 1e-4, "rate_random_walk": 1e-6}
    model = NoiseModel(channels={f"{sensor}_{axis}": terms for sensor in ("gyro", "accel") for axis in "xyz"})
    choices = (
        Choices(filter_rate=100, horizon=10)
        if name in ("kf-gins", "gnss-ins-sim", "gazebo")
        else Choices(filter_rate=100)
    )
    for ending in (target(name).ending, *target(name).binary):
        path = tmp_path / f"x{ending}"
        export(model, to=name, path=path, choices=choices)
        assert is_result(path), ending


@pytest.mark.parametrize("ending", [".png", ".svg", ".pdf"])
def test_every_figure_is_recognised(folder, ending, capsys):
    assert run("psd", "log.csv", "--rate", "100", "--plot", f"a{ending}", capsys=capsys)[0] == 0
    assert is_result(folder / f"a{ending}")


def test_a_simulated_log_is_none(tmp_path, capsys):
    (tmp_path / "m.toml").write_text('[channels.gyro_x]\nrandom_walk = "0.3 deg/sqrt(h)"\n')
    for name in ("a.csv", "a.npz"):
        command = ("simulate", tmp_path / "m.toml", "--hours", "0.01", "--rate", "50", "-o", tmp_path / name)
        assert run(*command, capsys=capsys)[0] == 0
        assert not is_result(tmp_path / name)
