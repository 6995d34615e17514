"""A depth camera, whose gyro and accelerometer have topics and rates of their own, from the log to the file of a filter."""

import re

import numpy as np
import pytest

from known import seed_of
from sigmatau import Record, analyze
from sigmatau.cli import main

GYRO, ACCEL = 1.887e-4, 2.25e-3  # two-sided densities of the record [rad/s/sqrt(Hz), m/s^2/sqrt(Hz)]


@pytest.fixture
def camera(field_data):
    log = field_data / "cases" / "d435i_36s_two_topics.mcap"
    if not log.is_file():
        pytest.skip(f"{log} is absent")
    return str(log)


def run(*words, capsys):
    code = main([str(word) for word in words])
    return code, *capsys.readouterr()


def density(text, key):
    return float(re.search(rf"^{key}: (\S+)", text, flags=re.MULTILINE)[1])


@pytest.mark.parametrize(
    "more",
    [
        ("--rate", "gyro=400", "accel=200"),
        ("--topic", "gyro/sample", "--topic", "accel/sample"),
        ("--topic", "gyro/sample,accel/sample", "--rate", "accel=200"),
        ("--filter-rate", "200"),
    ],
)
def test_one_command_to_kalibr(camera, more, tmp_path, capsys):
    path = tmp_path / "imu.yaml"
    code, _, err = run("analyze", camera, *more, "--export", f"kalibr={path}", "-q", capsys=capsys)
    assert code == 0, err
    text = path.read_text()
    assert density(text, "accelerometer_noise_density") == pytest.approx(ACCEL, rel=0.04)  # its 95 % interval
    assert density(text, "gyroscope_noise_density") == pytest.approx(GYRO, rel=0.04)
    assert density(text, "update_rate") == pytest.approx(200 if "--filter-rate" in more else 400, rel=2e-3)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--rate", "400"), "one rate, but the log has several (gyro 399.66 Hz, accel 199.83 Hz)"),
        (("--rate", "400", "--export", "kalibr=imu.yaml"), "give --rate gyro=399.7,accel=199.8"),
        (("--export", "vins=imu.yaml"), "(gyro 399.66 Hz, accel 199.83 Hz): give --filter-rate in Hz"),
        (("--rate", "gyros=400"), "no such sensor is read"),
        (("--rate", "gyro_x=400"), "the axes of a sensor have one rate; give gyro"),
    ],
)
def test_what_would_misread_a_sensor_is_refused(camera, words, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sigmatau.cli.analyze.analyze", None)  # nothing is analysed before
    code, out, err = run("analyze", camera, *words, capsys=capsys)
    assert (code, out) == (2, "")
    assert message in err
    assert not list(tmp_path.iterdir())


def test_the_proposed_command_is_right(camera, tmp_path, monkeypatch, capsys):
    """Obeying each message in turn ends in a file with the right density."""
    monkeypatch.chdir(tmp_path)
    _, _, err = run("analyze", camera, "--rate", "400", "--export", "vins=imu.yaml", "-q", capsys=capsys)
    rate = re.search(r"give (--rate) (\S+)", err).groups()
    _, _, err = run("analyze", camera, *rate, "--export", "vins=imu.yaml", "-q", capsys=capsys)
    assert "give --filter-rate in Hz" in err
    assert run("analyze", camera, *rate, "--filter-rate", 200, "--export", "vins=imu.yaml", "-q", capsys=capsys)[0] == 0
    text = (tmp_path / "imu.yaml").read_text()
    assert density(text, "acc_n") == pytest.approx(ACCEL * np.sqrt(2 * 200), rel=0.04)


def test_in_python():
    rng = np.random.default_rng(seed_of("two rates in Python"))
    gyro, accel = 1e-3 * rng.standard_normal((8000, 3)), 1e-2 * rng.standard_normal((4000, 3))
    record = Record.from_arrays(rate={"gyro": 400, "accel": 200}, gyro=gyro, accel=accel)
    assert [stream.grid.rate for stream in record.streams] == [400, 200]
    walks = {name: fitted["random_walk"].value for name, fitted in analyze(record).fits.items()}
    assert walks["gyro_x"] == pytest.approx(1e-3 / np.sqrt(400), rel=0.05)
    assert walks["accel_x"] == pytest.approx(1e-2 / np.sqrt(200), rel=0.05)
