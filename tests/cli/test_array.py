"""``sigmatau array`` on the command line."""

import csv
import json

import numpy as np
import pytest

import sigmatau as st
from known import seed_of
from sigmatau.cli import main

READING = ("--channels", "gyro_1=2,gyro_2=3,gyro_3=4", "--unit", "gyro=rad/s", "--rate", "50")


@pytest.fixture(scope="module")
def board(tmp_path_factory):
    """A log of three gyros, the first with half of the noise."""
    path = tmp_path_factory.mktemp("array") / "board.csv"
    x = 1e-3 * np.array([[1.0], [2.0], [2.0]]) * np.random.default_rng(seed_of("board")).standard_normal((3, 12_000))
    np.savetxt(path, np.c_[np.arange(12_000), x.T], delimiter=",", header="row,w1,w2,w3", comments="", fmt="%.9g")
    return path


def run(capsys, *argv):
    code = main(["array", *map(str, argv)])
    out = capsys.readouterr()
    return code, out.out, out.err


def test_table(board, capsys):
    code, out, _ = run(capsys, board, *READING)
    assert code == 0
    assert out.startswith("3 gyros at 50 Hz, 4 min\n")
    assert "gyro_virtual: weights for the least angle random walk" in out
    assert "times better than the best sensor, gyro_1." in out
    assert "Fused log: " in out
    assert all(len(line) <= 80 for line in out.splitlines())


def test_outputs(board, tmp_path, capsys):
    files = {name: tmp_path / name for name in ("a.json", "a.csv", "fused.csv", "v.toml", "joint.json", "a.png")}
    code, _, err = run(
        capsys, board, *READING, "--json", files["a.json"], "--csv", files["a.csv"], "--write", files["fused.csv"],
        "--export", f"model={files['v.toml']}", "--plot", files["a.png"], "--virtual", "gyro_x",
    )  # fmt: skip
    assert code == 0, err
    content = json.loads(files["a.json"].read_text())
    assert content["array"]["channels"] == ["gyro_1", "gyro_2", "gyro_3"]
    weights = [each["value"] for each in content["virtual"]["weights"]["values"]]
    assert sum(weights) == pytest.approx(1)
    fused = st.read(files["fused.csv"])
    samples = np.loadtxt(board, delimiter=",", skiprows=1)[:, 1:].T
    assert fused.stream_of("gyro_x").column("gyro_x") == pytest.approx(np.array(weights) @ samples, rel=1e-9)
    model = st.NoiseModel.read(files["v.toml"])
    assert model["gyro_x"].terms["random_walk"] == content["virtual"]["coefficients"]["random_walk"]["value"]
    with files["a.csv"].open() as table:
        rows = list(csv.DictReader(table))
    assert {row["kind"] for row in rows} == {"coefficient", "correlation", "weight", "allan covariance"}
    assert files["a.png"].stat().st_size > 10_000


def test_correlated_sensors_are_exported(tmp_path, capsys):
    """The joint state space has the correlation of the white noise off its diagonal."""
    n, log, file = 12_000, tmp_path / "pair.csv", tmp_path / "joint.json"
    x = np.random.default_rng(seed_of("pair")).standard_normal((2, n))
    x[1] = 0.6 * x[0] + 0.8 * x[1]
    np.savetxt(log, 1e-3 * x.T, delimiter=",", header="w1,w2", comments="", fmt="%.9g")
    code, _, err = run(
        capsys, log, "--channels", "gyro_1=1,gyro_2=2", "--unit", "gyro=rad/s", "--rate", "50",
        "--export-sensors", f"state-space={file}", "--name", "form=joint", "--filter-rate", "50",
    )  # fmt: skip
    assert code == 0, err
    noise = np.array(json.loads(file.read_text())["systems"]["joint"]["R"])
    assert noise[0, 1] / np.sqrt(noise[0, 0] * noise[1, 1]) == pytest.approx(0.6, abs=0.03)


def test_common_disturbance(board, tmp_path, capsys):
    code, out, _ = run(capsys, board, *READING, "--common", "--json", "-")
    assert code == 0
    content = json.loads(out)
    assert content["array"]["common"] is True
    assert [each["channel"] for each in content["hat"]] == ["gyro_1", "gyro_2", "gyro_3"]


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        (("--axes", "gyro_1,gyro_9"), 2, "--axes names 'gyro_9'"),
        (("--target", "soon"), 2, "--target 'soon'"),
        (("--target", "1e6s"), 2, "--target 1e+06 s"),
        (("--axes", "gyro_1,gyro_2", "--common"), 2, "--common needs three sensors"),
        (("--style", "paper"), 2, "--style paper needs a figure"),
        (("--write", "fused.doc"), 2, "--write fused.doc"),
    ],
)
def test_wrong_options(board, capsys, options, code, words):
    got, out, err = run(capsys, board, *READING, *options)
    assert got == code
    assert out == ""
    assert words in err


def test_moving_log(tmp_path, capsys):
    log = tmp_path / "moving.csv"
    t = np.arange(20_000)
    x = 1e-3 * np.random.default_rng(seed_of("moving log")).standard_normal((20_000, 2))
    x += (0.2 * np.sin(t / 300) * (t % 7000 > 3500))[:, None]
    np.savetxt(log, x, delimiter=",", header="w1,w2", comments="", fmt="%.9g")
    code, _, err = run(capsys, log, "--channels", "gyro_1=1,gyro_2=2", "--unit", "gyro=rad/s", "--rate", "50")
    assert code == 5
    assert "An array needs a record at rest" in err
