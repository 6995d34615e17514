"""``sigmatau bandwidth``: rates of logs without time stamps, exit codes, outputs."""

import json
import re

import numpy as np
import pytest

from known import seed_of
from sigmatau import ChannelModel, LowPass, NoiseModel, simulate
from sigmatau.cli import main


def log(place, rate, *, corner=30.0, n=6000, stamps=False, columns=1, scale=1.0):
    """A log of a sensor of second order, in deg/s."""
    rng = seed_of(f"bandwidth command: {place.name}")
    channels = {
        f"gyro_{axis}": ChannelModel(terms={"random_walk": 1e-4}, bandwidth=LowPass(order=2, corner=corner))
        for axis in "xyz"[:columns]
    }
    record = simulate(NoiseModel(channels=channels), duration=n / rate, rate=rate, rng=rng)
    y = scale * np.degrees(np.column_stack([record.streams[0].column(name) for name in channels]))
    header = [f"{name} [deg/s]" for name in channels]
    if stamps:
        y, header = np.column_stack([np.arange(len(y)) / rate, y]), ["time [s]", *header]
    np.savetxt(place, y, delimiter=",", header=",".join(header), comments="", fmt="%.9g")
    return place


def test_rates_from_names(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, rate in (("10Hz.csv", 10.0), ("run_0.1kHz.csv", 100.0), ("fast 500 hz b.csv", 500.0)):
        log(tmp_path / name, rate)
    names = ["10Hz.csv", "run_0.1kHz.csv", "fast 500 hz b.csv"]
    assert main(["bandwidth", *names, "--json", "b.json", "--plot", "f.png"]) == 0
    out, err = capsys.readouterr()
    assert "10Hz.csv: no time stamps; sampling rate 10 Hz by its name" in err
    assert "run_0.1kHz.csv: no time stamps; sampling rate 100 Hz by its name" in err
    assert "bandwidth, -3 dB" in out
    result = json.loads((tmp_path / "b.json").read_text())["channels"]["gyro_x"]
    assert result["bandwidth"]["low"] < 30 < result["bandwidth"]["high"]
    assert [each["rate_hz"] for each in result["logs"]] == [10, 100, 500]
    assert (tmp_path / "f.png").stat().st_size > 10_000


@pytest.mark.parametrize("rates", [["--rate", "50,400"], ["--rate", "a.csv=50", "--rate", "b.csv=400"]])
def test_rates_of_options(tmp_path, capsys, monkeypatch, rates):
    monkeypatch.chdir(tmp_path)
    log(tmp_path / "a.csv", 50.0)
    log(tmp_path / "b.csv", 400.0)
    assert main(["bandwidth", "a.csv", "b.csv", *rates, "--json", "-"]) == 0
    result = json.loads(capsys.readouterr().out)["channels"]["gyro_x"]
    assert [each["rate_hz"] for each in result["logs"]] == [50, 400]


def test_stamps_go_before_a_name(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    log(tmp_path / "10Hz.csv", 400.0, stamps=True)
    assert main(["bandwidth", "10Hz.csv", "--json", "-"]) == 0
    out, err = capsys.readouterr()
    assert "by its name" not in err
    assert json.loads(out)["channels"]["gyro_x"]["logs"][0]["rate_hz"] == pytest.approx(400, rel=1e-6)


def test_no_rate_at_all(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    log(tmp_path / "a.csv", 50.0)
    log(tmp_path / "b_100Hz_500Hz.csv", 500.0)
    assert main(["bandwidth", "a.csv"]) == 2
    assert "--rate" in capsys.readouterr().err
    assert main(["bandwidth", "b_100Hz_500Hz.csv"]) == 2


def test_one_slow_log(tmp_path, capsys):
    assert main(["bandwidth", str(log(tmp_path / "10Hz.csv", 10.0))]) == 1
    out, _ = capsys.readouterr()
    assert re.search("bandwidth, -3 dB +above", out)
    assert "Record at 100 Hz or more" in " ".join(out.split())


def test_one_log_twice(tmp_path, capsys):
    place = str(log(tmp_path / "500Hz.csv", 500.0))
    assert main(["bandwidth", place, place]) == 2
    assert "is given twice" in capsys.readouterr().err


def test_other_sensors_and_options(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, rate, scale in (("100Hz.csv", 100.0, 1.0), ("500Hz.csv", 500.0, 1.0), ("200Hz.csv", 200.0, 3.0)):
        log(tmp_path / name, rate, scale=scale)
    assert main(["bandwidth", "100Hz.csv", "500Hz.csv", "200Hz.csv"]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert "200Hz.csv: gyro_x is of another sensor or configuration" in err
    for wrong in (["--axes", "gyro_y"], ["--tolerance", "2"], ["--style", "paper"], ["--plot", "f.txt"]):
        assert main(["bandwidth", "100Hz.csv", *wrong]) == 2
        assert wrong[0] in capsys.readouterr().err
    assert main(["bandwidth", "absent.csv"]) == 1


def test_axes_of_a_sensor(tmp_path, capsys):
    place = str(log(tmp_path / "300Hz.csv", 300.0, columns=3))
    assert main(["bandwidth", place, "--axes", "gyro_z,gyro_x", "--json", "-"]) == 0
    assert list(json.loads(capsys.readouterr().out)["channels"]) == ["gyro_z", "gyro_x"]
