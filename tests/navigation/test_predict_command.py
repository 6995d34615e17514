"""``sigmatau predict`` as a user meets it."""

import json
import math

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, analyze, predict, simulate
from sigmatau.cli import main
from sigmatau.model.parameters import Covariance

MODEL = """
[channels.gyro_y]
random_walk = "0.3 deg/sqrt(h)"
bias_instability = "12 deg/h"
[channels.gyro_z]
random_walk = "0.3 deg/sqrt(h)"
[channels.accel_x]
noise_density = "100 ug/sqrt(Hz)"
sided = "two"
"""


@pytest.fixture
def toml(tmp_path):
    path = tmp_path / "imu.toml"
    path.write_text(MODEL, encoding="utf-8")
    return path


def run(*argv, capsys):
    code = main([str(a) for a in argv])
    out, err = capsys.readouterr()
    return code, out, err


def test_table(toml, capsys):
    code, out, err = run("predict", toml, "--after", "60s,10min", "--calibration", "5min", capsys=capsys)
    assert (code, err) == (0, "")
    heading = next(line for line in out.splitlines() if line.startswith("heading"))
    # 0.3 deg/√h over 60 s, and the mean of 300 s before: 0.3·√(1/60 + 1/60·60/300)
    value = 0.3 * math.sqrt((1 / 60) * (1 + 60 / 300))
    assert heading.split()[1:5] == ["60", "s", f"{value:.3g}", "deg"]
    assert "gyro_z angle random walk 100 %" in heading
    assert "The mean rates of the 5 min before the start" in out
    names = [line.split()[0] for line in out.splitlines()[2:] if not line.startswith((" ", "The", "Roll and", "Bias"))]
    assert names == ["heading", "pitch", "velocity_x", "position_x"]


def test_json_and_options(toml, tmp_path, capsys):
    figure = tmp_path / "errors.svg"
    argv = ["predict", toml, "--after", "1min", "--rate", 50, "--earth", "flat", "--channels", "gyro_z"]
    code, out, _ = run(*argv, "--turn-on", "gyro=10 deg/h", "--json", "--plot", figure, capsys=capsys)
    assert code == 0
    content = json.loads(out)
    assert (content["rate_hz"], content["earth"], content["calibration_s"]) == (50.0, "flat", None)
    assert content["turn_on"] == {"gyro_z": pytest.approx(math.radians(10) / 3600)}
    assert list(content["errors"]) == ["heading"]
    expected = math.hypot(math.radians(0.3) * math.sqrt(1 / 60), math.radians(10) / 60)
    assert content["errors"]["heading"]["rms"] == [pytest.approx(expected, rel=1e-9)]
    assert figure.read_bytes().startswith(b"<?xml")


def test_result_of_analyze_is_read_with_its_rate_and_its_errors(tmp_path, capsys):
    model = NoiseModel(channels={"gyro_z": {"random_walk": 1e-4, "bias_instability": 2e-5}})
    analysis = analyze(simulate(model, duration=2000.0, rate=20.0, rng=seed_of("predict result")))
    path = tmp_path / "result.json"
    path.write_text(json.dumps(analysis.to_dict()), encoding="utf-8")
    code, out, _ = run("predict", path, "--after", "100s", "--calibration", "100s", "--json", capsys=capsys)
    assert code == 0
    content = json.loads(out)
    assert content["rate_hz"] == 20.0
    heading = content["errors"]["heading"]
    assert heading["low"][0] < heading["rms"][0] < heading["high"][0]
    truth = predict(model, after=100.0, calibration=100.0, rate=20.0)["heading"].rms[0]
    # Three standard errors of the logarithm; the interval has 1.96 of them to either side.
    half = math.log(heading["high"][0] / heading["rms"][0]) / 1.96
    assert abs(math.log(heading["rms"][0] / truth)) < 3 * half
    _, out, _ = run("predict", path, "--after", "100s", capsys=capsys)
    assert "steps of 0.05 s" in out
    assert "95 % interval by the errors of the coefficients" in out


def test_figure_is_a_curve_up_to_the_last_time(toml, tmp_path, capsys, monkeypatch):
    """Of one time too, from a thousandth of it on, with a dot where it was asked for."""
    drawn = []
    monkeypatch.setattr("sigmatau.plot.curves.save", lambda figure, path: drawn.append(figure))
    assert run("predict", toml, "--after", "60s", "--plot", tmp_path / "x.png", capsys=capsys)[0] == 0
    line = drawn[0].axes[0].lines[0]
    times = line.get_xdata()
    assert len(times) >= 40
    assert (times[0], times[-1]) == (pytest.approx(0.06), 60.0)
    assert line.get_markevery() == [len(times) - 1]


def test_limits_of_a_result_reach_the_table(tmp_path, capsys):
    """K was not seen, and its limit is in the interval, which holds the truth; a limit of its own would say the same."""
    model = NoiseModel(channels={"gyro_z": {"random_walk": 1e-3, "rate_random_walk": 1e-6}})
    analysis = analyze(simulate(model, duration=2000.0, rate=20.0, rng=seed_of("predict limits")))
    path = tmp_path / "result.json"
    path.write_text(json.dumps(analysis.to_dict()), encoding="utf-8")
    code, out, _ = run("predict", path, "--after", "100h", capsys=capsys)
    assert code == 0
    assert max(map(len, out.splitlines())) <= 80
    assert "rate random walk" in out[out.index("Not observed") :]
    assert "beyond the record of 33 min" in " ".join(out.split())
    found = predict(analysis.model, after=36000.0, rate=20.0)["heading"]
    truth = predict(model, after=36000.0, rate=20.0)["heading"].rms[0]
    assert found.low[0] < truth < found.high[0]
    assert found.high[0] == found.at_most[0]
    assert "at most" not in out
    assert "95 % limits of terms that were not observed" in " ".join(out.split())


@pytest.mark.parametrize(
    ("argv", "code", "words"),
    [
        (["--after", "60"], 2, "--after '60': must be a time with its unit"),
        (["--after", "60s,"], 2, "--after ''"),
        (["--after", "1s", "--calibration", "1 deg"], 2, "--calibration '1 deg'"),
        (["--after", "1s", "--channels", "gyro_q"], 2, "--channels gyro_q"),
        (["--after", "1s", "--turn-on", "gyro_q=1 deg/h"], 2, "--turn-on gyro_q"),
        (["--after", "1s", "--turn-on", "accel=1 deg/h"], 2, "--turn-on accel"),
        (["--after", "1s", "--turn-on", "gyro=1 deg/h", "--calibration", "1s"], 2, "--turn-on: a calibration"),
        (["--after", "1s", "--rate", "0"], 2, "--rate must"),
        (["--after", "1s", "--plot", "x.doc"], 2, "--plot"),
    ],
)
def test_wrong_options(toml, capsys, argv, code, words):
    found, _, err = run("predict", toml, *argv, capsys=capsys)
    assert found == code
    assert words in err


@pytest.mark.parametrize("order", [1, -1])
def test_turn_on_bias_of_one_channel_overrules_that_of_its_sensor(toml, capsys, order):
    given = ["gyro=10 deg/h", "gyro_z=5 deg/h"][::order]
    argv = [word for text in given for word in ("--turn-on", text)]
    code, out, _ = run("predict", toml, "--after", "60s", *argv, "--json", capsys=capsys)
    assert code == 0
    deg_per_h = math.radians(1) / 3600
    assert json.loads(out)["turn_on"] == pytest.approx({"gyro_y": 10 * deg_per_h, "gyro_z": 5 * deg_per_h})


def test_turn_on_bias_of_a_signal(tmp_path, capsys):
    path = tmp_path / "imu.toml"
    path.write_text(MODEL + '[channels.pressure_a]\nunit = "Pa"\nrandom_walk = "0.2 Pa*sqrt(s)"\n', encoding="utf-8")
    code, _, err = run("predict", path, "--after", "60s", "--turn-on", "pressure_a=1 Pa", capsys=capsys)
    assert code == 2
    assert "--turn-on pressure_a: pressure_a is neither a gyro nor an accelerometer" in err


def test_files_that_are_no_models(tmp_path, capsys):
    for name, text in {"a.json": '{"x": 1}', "b.toml": "x = 1", "c.json": '{"channels": {"gyro_x": {}}}'}.items():
        (tmp_path / name).write_text(text)
        code, _, err = run("predict", tmp_path / name, "--after", "1s", capsys=capsys)
        assert code == 1
        assert name in err


def test_covariance_of_an_analysis_reaches_the_interval():
    """Twice as sure a coefficient, half as wide: nothing else is in the interval."""
    widths = []
    for factor in (1.0, 0.25):
        covariance = Covariance.of(["random_walk"], factor * np.array([[1e-10]]))
        model = NoiseModel.from_dict({"channels": {"gyro_z": {"random_walk": "0.3 deg/sqrt(h)"}}})
        channel = model.channels["gyro_z"]
        known = type(channel)(terms=channel.terms, covariance=covariance)
        found = predict(NoiseModel(channels={"gyro_z": known}), after=10.0, rate=10.0)["heading"]
        widths.append(float(np.log(found.high / found.low)[0]))
    assert widths[0] == pytest.approx(2 * widths[1], rel=1e-9)
