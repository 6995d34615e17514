"""analyze --joint: one table and one result of several logs; a log that cannot be used is named."""

import json

import jsonschema
import numpy as np
import pytest

import known
from conftest import ROOT
from sigmatau.analysis import Analysis
from sigmatau.cli import main

SCHEMA = json.loads((ROOT / "python" / "sigmatau" / "schema" / "result-2.schema.json").read_text())


def write(path, seed, n=4000, rate=10.0, channels=("gyro_x", "gyro_y"), slow=0.0, change=None):
    rng = np.random.default_rng(known.seed_of(seed))
    x = rng.standard_normal((n, len(channels))) + slow * np.cumsum(rng.standard_normal((n, len(channels))), axis=0)
    if change is not None:
        change(x)
    unit = "deg/h" if channels[0].startswith("gyro") else "mm/s^2"
    header = "time [s]," + ",".join(f"{name} [{unit}]" for name in channels)
    np.savetxt(path, np.c_[np.arange(n) / rate, x], delimiter=",", header=header, comments="", fmt="%.9g")
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("runs")
    for k in range(4):
        write(path / f"day{k}.csv", f"cli joint {k}", slow=0.02)
    write(path / "odd.csv", "cli joint odd", slow=0.5)
    write(path / "fast.csv", "cli joint fast", rate=20.0)
    write(path / "other.csv", "cli joint other", channels=("accel_x",))
    write(path / "short.csv", "cli joint short", n=100)

    def stops(x):
        x[:, 0] = 0.25

    def turns(x):
        x[:, 0] += 2e5 * np.sin(np.arange(len(x)) / 30)

    write(path / "constant.csv", "cli joint constant", change=stops)
    write(path / "moving.csv", "cli joint moving", change=turns)
    (path / "bad.csv").write_text("junk\n")
    (path / "copy.csv").write_bytes((path / "day0.csv").read_bytes())
    return path


@pytest.fixture
def run(folder, capsys):
    def call(*argv):
        code = main(["analyze", *(str(folder / one) if str(one).endswith(".csv") else str(one) for one in argv)])
        return code, *capsys.readouterr()

    return call


DAYS = [f"day{k}.csv" for k in range(4)]


def test_one_result_of_all_logs(run, tmp_path):
    result = tmp_path / "unit.json"
    code, out, err = run(*DAYS, "--joint", "--json", result, "--csv", tmp_path / "unit", "--plot", tmp_path / "u.png")
    assert code == 2
    assert "--csv" in err  # as for one log: NAME.csv
    code, out, err = run(
        *DAYS, "--joint", "--json", result, "--plot", tmp_path / "u.png", "--export", f"ieee952={tmp_path / 'p.md'}"
    )
    assert code == 0, err
    assert "joint fit of 4 runs: 2 channels at 10 Hz, 27 min together" in out
    assert "[joint]" in out
    content = json.loads(result.read_text())
    jsonschema.validate(content, SCHEMA)
    for channel in content["channels"].values():
        assert [one["name"] for one in channel["joint"]["runs"]] == DAYS
        assert channel["fit"]["runs_s"] == [400.0] * 4
        assert all(one["belongs"] for one in channel["joint"]["runs"])
    model = Analysis.from_dict(content).model
    assert set(model.channels) == {"gyro_x", "gyro_y"}
    assert (tmp_path / "u.png").stat().st_size > 0
    assert (tmp_path / "p.md").stat().st_size > 0


def test_the_run_that_differs_is_named(run):
    code, _, err = run(*DAYS, "odd.csv", "--joint")
    assert code == 0
    assert "odd.csv: rate random walk is" in err
    assert "times that of the other runs" in err
    assert "day0.csv: " not in err


def test_all_coefficients(run):
    code, out, _ = run(*DAYS, "--joint", "-v")
    assert code == 0
    assert "4 runs, 27 min together" in out
    assert "  day2.csv: angle random walk" in out


@pytest.mark.parametrize(
    ("log", "code", "told"),
    [
        ("bad.csv", 1, "bad.csv: "),
        ("short.csv", 5, "short.csv: "),
        ("moving.csv", 5, "moving.csv is not in the joint fit: the sensor is not at rest"),
        ("absent.csv", 1, "absent.csv: there is no such file"),
    ],
)
def test_a_log_that_cannot_be_used_is_named_and_the_others_go_on(run, log, code, told):
    got, out, err = run(*DAYS, log, "--joint")
    assert got == code
    assert told in err
    assert "joint fit of 4 runs" in out


def test_a_constant_channel_is_left_out_of_that_run(run, tmp_path):
    code, _, err = run(*DAYS[:2], "constant.csv", "--joint", "--json", tmp_path / "r.json")
    assert code == 0
    assert "constant.csv" in err
    channels = json.loads((tmp_path / "r.json").read_text())["channels"]
    assert [len(channels[name]["joint"]["runs"]) for name in ("gyro_x", "gyro_y")] == [2, 3]


@pytest.mark.parametrize(
    ("argv", "code", "told"),
    [
        (["day0.csv", "--joint"], 2, "--joint needs two or more logs. For the axes of one log, use --joint-axes"),
        (["day0.csv", "day0.csv", "--joint"], 2, "is given twice"),
        (["day0.csv", "copy.csv", "--joint"], 1, "copy.csv: gyro_x has the same samples as day0.csv"),
        (["day0.csv", "fast.csv", "--joint"], 1, "fast.csv: gyro_x has 20 Hz, in day0.csv it has 10 Hz"),
        (["day0.csv", "other.csv", "--joint"], 2, "--joint needs at least two logs with the same channel"),
        (["day0.csv", "bad.csv", "--joint"], 1, "--joint needs two or more logs that can be used: 1 of 2 can"),
        ([*DAYS, "--joint", "--report", "r.html"], 2, "--report applies to single logs"),
        ([*DAYS, "--joint", "--overlay", "o.png"], 2, "--overlay applies to single logs"),
        ([*DAYS, "--joint", "--read-off-at", "random_walk=1s:10s"], 2, "--read-off-at applies to single logs"),
        ([*DAYS, "--joint", "--jobs", "2"], 2, "--jobs applies to single logs"),
        ([*DAYS, "--joint", "--method", "gls"], 2, "--joint needs --method likelihood, not gls"),
        ([*DAYS, "--joint", "--common", "foo"], 2, "--common: 'foo' cannot be common to runs"),
        ([*DAYS, "--common", "none"], 2, "--common needs --joint"),
    ],
)
def test_what_is_refused(run, tmp_path, monkeypatch, argv, code, told):
    monkeypatch.chdir(tmp_path)
    result = [] if "--report" in argv or "--jobs" in argv else ["--json", str(tmp_path / "r.json")]
    got, _, err = run(*argv, *(result if "--joint" in argv else []))
    assert (got, told in err) == (code, True), err
    assert not (tmp_path / "r.json").exists()


def test_axes_of_one_log(run):
    code, out, _ = run("day0.csv", "--joint-axes", "--common", "none")
    assert code == 0
    assert "joint fit of 2 axes of each sensor: 1 channel at 10 Hz" in out
    assert "gyro " in out
