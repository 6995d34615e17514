"""``sigmatau export`` and ``analyze --export`` as a user meets them."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

import vio
from known import seed_of
from sigmatau import DataError, NoiseModel, OptionError, Record, simulate
from sigmatau.analysis.inputs import read_model
from sigmatau.cli import main
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import export
from sigmatau.exporting.targets import NAMES, target
from sigmatau.io.write import write
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import Sinusoid

WALKS = ("--rate-random-walk", "gyro=upper-limit,accel=1e-5 m/s^3/sqrt(Hz)")


@pytest.fixture(scope="module")
def record() -> Record:
    """A minute of white noise: no walk is to be seen."""
    model = NoiseModel(channels={f"{s}_{a}": {"random_walk": 1e-3} for s in ("gyro", "accel") for a in "xy"})
    return simulate(model, duration=60.0, rate=100.0, rng=seed_of("export command"))


@pytest.fixture
def log(record, tmp_path):
    write(record, tmp_path / "log.csv")
    return tmp_path / "log.csv"


@pytest.fixture(scope="module")
def text_of_the_result(record, tmp_path_factory):
    folder = tmp_path_factory.mktemp("result")
    write(record, folder / "log.csv")
    assert main(["analyze", str(folder / "log.csv"), "--json", str(folder / "r.json"), "-q"]) == 0
    return (folder / "r.json").read_text()


@pytest.fixture
def result(text_of_the_result, tmp_path):
    (tmp_path / "r.json").write_text(text_of_the_result)
    return tmp_path / "r.json"


def run(*argv, capsys):
    capsys.readouterr()
    code = main([str(a) for a in argv])
    out, err = capsys.readouterr()
    return code, out, err


def test_list(capsys):
    code, out, err = run("export", "--list", capsys=capsys)
    assert (code, err) == (0, "")
    assert [line.split()[0] for line in out.splitlines()] == list(NAMES)
    assert all(len(line) < 120 for line in out.splitlines())


def test_result_gives_the_rate(result, tmp_path, capsys):
    code, out, err = run("export", result, "--to", "kalibr", *WALKS, capsys=capsys)
    assert (code, err.count("a filter states")) == (0, 2)
    content = vio.parse(out)
    assert content["update_rate"] == 100.0
    assert content["accelerometer_random_walk"] == 1e-5
    model = read_model(result)
    worst = max(model.channels[name].limits["rate_random_walk"] for name in ("gyro_x", "gyro_y"))
    assert content["gyroscope_random_walk"] == worst
    code, to_file, err = run("export", result, "--to", "kalibr", *WALKS, "-o", tmp_path / "imu.yaml", capsys=capsys)
    assert (code, to_file) == (0, "")
    assert err.endswith(f"{tmp_path / 'imu.yaml'}: written for kalibr\n")
    assert (tmp_path / "imu.yaml").read_text() == out
    code, out, _ = run("export", result, "--to", "kalibr", *WALKS, "--filter-rate", 50, capsys=capsys)
    assert vio.parse(out)["update_rate"] == 50.0


def test_options_reach_the_file(result, capsys):
    code, out, _ = run(
        "export", result, "--to", "lio-sam", "--axes", "mean", "--noise-factor", 3, "--walk-factor", 5,
        "--rate-random-walk", "gyro=upper-limit", "--rate-random-walk", "accel=1e-5 m/s^3/sqrt(Hz)",
        "--name", "topic=/imu/raw,gravity=9.81", capsys=capsys,
    )  # fmt: skip
    assert code == 0
    content = vio.parse(out)["lio_sam"]
    assert (content["imuTopic"], content["imuGravity"]) == ("/imu/raw", 9.81)
    assert content["imuAccBiasN"] == pytest.approx(5e-5, rel=1e-12)
    model = read_model(result)
    noise = [model.channels[name]["random_walk"] for name in ("accel_x", "accel_y")]
    assert content["imuAccNoise"] == pytest.approx(3 * np.sqrt(np.mean(np.square(noise))), rel=1e-12)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["--to", "kalibr", "--strict"], "no acceleration random walk observed (below"),
        (["--to", "kalibr", "--strict", "--rate-random-walk", "gyro=upper-limit"], "accelerometers: no"),
        (["--to", "kalibr", "--rate-random-walk", "gyro=1e-6"], "want a value with its unit"),
        (["--to", "kalibr", "--rate-random-walk", "gyro=1 m/s"], "does not fit here"),
        (
            ["--to", "kalibr", "--rate-random-walk", "gyro=lots"],
            "or --rate-random-walk gyro=upper-limit, --rate-random-walk gyro=consistent",
        ),
        (["--to", "kalibr", "--rate-random-walk", "gyros=upper-limit"], "unknown sensor 'gyros'"),
        (["--to", "kalibr", "--rate-random-walk", "gyro=horizon"], "needs --horizon"),
        (["--to", "kalibr", *WALKS, "--horizon", "10"], "want a value with its unit"),
        (["--to", "kalibr", *WALKS, "--axes", "each"], "choose worst or mean"),
        (["--to", "kalibr", *WALKS, "--noise-factor", "0"], "--noise-factor must be a positive number"),
        (["--to", "kalibr", *WALKS, "--name", "gravity=9.8"], "no name 'gravity'; names: topic"),
        (["--to", "vinz"], "unknown target 'vinz', perhaps vins; targets: ardupilot"),
        ([], "--to is missing; targets: ardupilot"),
    ],
)
def test_what_is_refused_with_exit_code_2(result, tmp_path, more, message, capsys):
    code, out, err = run("export", result, *more, "-o", tmp_path / "x.out", capsys=capsys)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1
    assert not (tmp_path / "x.out").exists()


@pytest.mark.parametrize(("typed", "name"), [("vins_mono", "vins"), ("VINS-Fusion", "vins"), ("orbslam3", "orb-slam3")])
def test_a_target_by_the_name_of_its_program(typed, name):
    assert target(typed) is target(name)


def test_a_value_for_what_was_observed_is_not_used_and_said(tmp_path, capsys):
    both = {"random_walk": 1e-3, "rate_random_walk": 1e-5}
    given = NoiseModel(channels={"gyro_x": both, "accel_x": both})
    given.write(tmp_path / "m.toml")
    more = ("--rate-random-walk", "gyro=1e-1 rad/s/sqrt(s)", "--random-walk", "accel=1 m/s/sqrt(s)")
    code, out, err = run("export", tmp_path / "m.toml", "--to", "lio-sam", *more, capsys=capsys)
    assert code == 0
    assert vio.parse(out)["lio_sam"]["imuGyrBiasN"] == 1e-5
    assert "--rate-random-walk gyro not used: it was observed" in out
    assert "warning: --rate-random-walk for gyro not used: the coefficient was observed" in err
    assert "warning: --random-walk for accel not used" in err
    assert run("export", tmp_path / "m.toml", "--to", "lio-sam", *more, "-q", capsys=capsys)[2] == ""
    NoiseModel(channels={"gyro_x": both, "gyro_y": {"random_walk": 1e-3}, "accel_x": both}).write(tmp_path / "m.toml")
    _, out, err = run("export", tmp_path / "m.toml", "--to", "lio-sam", *more[:2], capsys=capsys)
    assert "not used" not in err  # one axis needs it
    assert vio.parse(out)["lio_sam"]["imuGyrBiasN"] == 0.1


def test_a_line_is_no_walk():
    """σ²(T) without the sinusoid; an axis that has nothing slow but a line has no slow noise."""
    b, line = 1e-5, (Sinusoid(amplitude=1e-2, frequency=0.05),)
    flicker = {"random_walk": 1e-3, "bias_instability": b}
    accel = {"random_walk": 1e-3, "bias_instability": b}
    chosen = Choices(walk={"gyro": "horizon", "accel": "horizon"}, horizon=10.0, filter_rate=100.0)

    def gyro(**axes):
        text = export(NoiseModel(channels={**axes, "accel_x": accel}), to="kalibr", choices=chosen)
        assert "no field for sinusoids of the gyros" in text
        return vio.parse(text)["gyroscope_random_walk"]

    wanted = math.sqrt(3 * 2 * math.log(2) / math.pi * b**2 / 10.0)
    with_line = ChannelModel(terms=flicker, sinusoid=line)
    only_line = ChannelModel(terms={"random_walk": 1e-3}, sinusoid=line)
    assert gyro(gyro_x=with_line) == pytest.approx(wanted, rel=1e-5)  # the flicker of samples, τ₀²/τ² off the plateau
    assert gyro(gyro_x=only_line, gyro_y=with_line) == pytest.approx(wanted, rel=1e-5)
    with pytest.raises(OptionError, match="no slow noise except a sinusoid"):
        gyro(gyro_x=only_line)


def test_a_horizon_is_whole_samples_and_the_file_says_which():
    """7 ms at 200 Hz are one sample: matched at 5 ms, and said so."""
    k, q = 1e-3, Choices(walk={"gyro": "horizon", "accel": "horizon"}, horizon=0.007, filter_rate=200.0)
    terms = {"random_walk": 1e-3, "rate_random_walk": k}
    text = export(NoiseModel(channels={"gyro_x": terms, "accel_x": terms}), to="lio-sam", choices=q)
    assert "at 0.005 s, whole samples instead of 0.007 s" in text
    # One sample: K²·τ₀/2 of a walk between samples.
    assert vio.parse(text)["lio_sam"]["imuGyrBiasN"] == pytest.approx(k * math.sqrt(1.5), rel=1e-12)
    even = export(
        NoiseModel(channels={"gyro_x": terms, "accel_x": terms}), to="lio-sam", choices=replace(q, horizon=0.01)
    )
    assert "whole samples" not in even


def test_binary_endings_are_those_of_the_target(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    both = {"random_walk": 1e-3, "rate_random_walk": 1e-5}
    NoiseModel(channels={"gyro_x": both, "accel_x": both}).write("m.toml")
    for name, file in (("kalibr", "x.npz"), ("lio-sam", "x.MAT"), ("state-space", "x.h5")):
        code, _, err = run("export", "m.toml", "--to", name, "--filter-rate", 100, "-o", file, capsys=capsys)
        assert code == 2
        assert f"'{file}': {name} has no form for .{file[2:].lower()}" in err
        assert not (tmp_path / file).exists()
        assert run("analyze", "no-such.csv", "--export", f"{name}={file}", capsys=capsys)[0] == 2
    for file in ("x.npz", "x.yaml"):
        assert run("export", "m.toml", "--to", "state-space", "--filter-rate", 100, "-o", file, capsys=capsys)[0] == 0
    assert (
        "m.toml is the file that is read"
        in run("export", "m.toml", "--to", "lio-sam", "-o", "m.toml", capsys=capsys)[2]
    )


@pytest.mark.parametrize("rate", ["-100.0", "0", "true", '"100"', "null", "[]", "NaN", "1e400"])
def test_a_rate_of_a_result_is_a_positive_number(result, rate, capsys):
    text = re.sub(r'("sample_rate_hz": )[0-9.]+', rf"\g<1>{rate}", result.read_text())
    result.write_text(text)
    code, out, err = run("export", result, "--to", "kalibr", *WALKS, capsys=capsys)
    assert (code, out) == (1, "")
    assert "r.json" in err


def test_a_model_has_no_rate(tmp_path, capsys):
    NoiseModel(channels={s: {"random_walk": 1e-3, "rate_random_walk": 1e-5} for s in ("gyro", "accel")}).write(
        tmp_path / "m.toml"
    )
    code, _, err = run("export", tmp_path / "m.toml", "--to", "vins", capsys=capsys)
    assert code == 2
    assert "the rate of the filter is needed" in err
    assert run("export", tmp_path / "m.toml", "--to", "gtsam", capsys=capsys)[0] == 0
    code, _, err = run("export", tmp_path / "m.toml", "--to", "gtsam", "-o", tmp_path / "m.toml", capsys=capsys)
    assert code == 2
    assert NoiseModel.read(tmp_path / "m.toml")
    assert run("export", capsys=capsys)[0] == 2
    assert run("export", tmp_path / "none.toml", "--to", "gtsam", capsys=capsys)[0] == 1


class TestAnalyze:
    def test_writes_what_export_writes(self, log, result, tmp_path, capsys):
        files = [tmp_path / "imu.yaml", tmp_path / "imu.py"]
        code, out, err = run(
            "analyze", log, "--export", f"kalibr={files[0]}", "--export", f"gtsam={files[1]}", *WALKS, capsys=capsys
        )
        assert code == 0
        assert "random walk" in out
        assert [line for line in err.splitlines() if "written" in line] == [
            f"{files[0]}: written for kalibr",
            f"{files[1]}: written for gtsam",
        ]
        for name, file in zip(("kalibr", "gtsam"), files, strict=True):
            assert file.read_text() == run("export", result, "--to", name, *WALKS, capsys=capsys)[1]

    def test_an_ordinary_log_needs_no_choice(self, log, tmp_path, capsys):
        """What it does not show counts with its mean variance, and the file states what that costs."""
        code, _, err = run("analyze", log, "--export", f"kalibr={tmp_path / 'imu.yaml'}", capsys=capsys)
        assert code == 0
        assert "upper limit" not in err
        text = (tmp_path / "imu.yaml").read_text()
        assert text.count("Terms that were not observed count at 1/sqrt(3) of their upper limits.") == 2
        assert "consistent: a filter with it states its error after 60 s correctly" in text
        assert "# from log.csv, 60 s at 100 Hz, analysed by sigmatau" in text
        assert "# gyro_x, gyro_y, accel_x and accel_y: the model fits\n" in text

    def test_what_has_to_be_chosen_is_said_after_the_results(self, log, tmp_path, capsys):
        code, out, err = run(
            "analyze", log, "--json", tmp_path / "r.json", "--export", f"kalibr={tmp_path / 'imu.yaml'}", "--strict",
            capsys=capsys,
        )  # fmt: skip
        assert code == 2
        assert "random walk" in out
        assert "--export kalibr: gyros: no rate random walk observed" in err
        assert "accelerometers: no acceleration random walk observed" in err
        assert f"sigmatau export {tmp_path / 'r.json'} needs no second analysis" in err
        assert (tmp_path / "r.json").exists()
        assert not (tmp_path / "imu.yaml").exists()

    @pytest.mark.parametrize(
        ("more", "message"),
        [
            (["--export", "vinz=x"], "unknown target"),
            (["--export", "kalibr"], "want TARGET=FILE"),
            (["--export", "kalibr=a", "--export", "kalibr=b"], "given twice"),
            (["--export", "kalibr=a", "--export", "vins=a"], "both name a"),
            (["--export", "kalibr=a", "--axes", "each"], "worst or mean"),
            (["--export", "kalibr=a", "--method", "read-off"], "needs a fit"),
            (["--export", "kalibr=a", "--rate-random-walk", "gyro=horizon"], "needs --horizon"),
            (["--export", "kalibr=a", "--export", "ros=b", "--step", "0.1"], "--step does not apply to kalibr"),
            (["--horizon", "10s"], "--horizon needs --export"),
            (["--noise-factor", "2"], "--noise-factor needs --export"),
        ],
    )
    def test_refused_before_the_log_is_read(self, more, message, tmp_path, monkeypatch, capsys):
        monkeypatch.chdir(tmp_path)
        code, out, err = run("analyze", "no-such-log.csv", *more, capsys=capsys)
        assert (code, out) == (2, "")
        assert message in err

    def test_an_option_needs_a_place_in_one_target_only(self, log, tmp_path, capsys):
        """And each file is written that can be."""
        files = {name: tmp_path / name for name in ("kalibr", "kf-gins")}
        exports = [text for name, path in files.items() for text in ("--export", f"{name}={path}")]
        more = ("--rate-random-walk", "gyro=upper-limit,accel=upper-limit", "--strict")
        code, _, err = run("analyze", log, *exports, *more, "--horizon", "60s", capsys=capsys)
        assert code == 0
        assert all(path.exists() for path in files.values())
        for path in files.values():
            path.unlink()
        code, _, err = run("analyze", log, *exports, *more, capsys=capsys)
        assert code == 2
        assert "--export kf-gins: " in err
        assert {name: path.exists() for name, path in files.items()} == {"kalibr": True, "kf-gins": False}

    @pytest.mark.parametrize(
        ("channels", "target_name", "message"),
        [
            ("gyro_x", "kalibr", "kalibr: the log has no accelerometers"),
            ("accel_x", "vins", "vins: the log has no gyros"),
            ("gyro_x accel_x", "vins", "vins: the channels have several sampling rates (gyro 100 Hz, accel 50 Hz)"),
            ("gyro_x accel_x", "state-space", "state-space: the step of the filter is needed"),
        ],
    )
    def test_what_the_log_lacks_is_said_before_the_analysis(
        self, channels, target_name, message, tmp_path, monkeypatch, capsys
    ):
        monkeypatch.setattr("sigmatau.cli.analyze.analyze", None)
        arrays = {name: np.arange(100.0) for name in channels.split()}
        rates = {"gyro": 100.0, "accel": 50.0}
        record = Record.from_arrays(rate={name.split("_")[0]: rates[name.split("_")[0]] for name in arrays}, **arrays)
        monkeypatch.setattr("sigmatau.cli.analyze.read_log", lambda *_, **__: record)
        code, out, err = run(
            "analyze", tmp_path / "a.csv", "--export", f"{target_name}={tmp_path / 'x'}", capsys=capsys
        )
        assert (code, out) == (2, "")
        assert message in err

    def test_nothing_computed_is_lost(self, log, tmp_path, monkeypatch, capsys):
        """A report that fails, and a target: the table, the numbers, the figure and the other target are written."""

        def failing(*_, **__):
            raise DataError("report: the disk is full")

        monkeypatch.setattr("sigmatau.reporting.report.report", failing)
        names = {"report": "r.html", "json": "r.json", "csv": "r.csv", "plot": "p.svg"}
        outputs = [text for option, name in names.items() for text in (f"--{option}", tmp_path / name)]
        exports = ("--export", f"kf-gins={tmp_path / 'kf'}", "--export", f"kalibr={tmp_path / 'k'}")
        more = ("--rate-random-walk", "gyro=upper-limit", "accel=upper-limit", "--strict")
        code, out, err = run("analyze", log, *outputs, *exports, *more, capsys=capsys)
        assert code == 2  # of the option that kf-gins lacks
        assert "random walk" in out
        assert "sigmatau: report: the disk is full\n" in err
        assert "--export kf-gins: " in err
        written = {path.name for path in tmp_path.iterdir() if path.name != "log.csv"}
        assert written >= {"r.json", "r.csv", "r-curves.csv", "p.svg", "k"}
        assert not written & {"r.html", "kf"}
