"""``sigmatau simulate`` with what a real log has: values with units in, the record of `simulate` out."""

import math

import numpy as np
import pytest

from sigmatau import Imperfections, NoiseModel, read, simulate
from sigmatau.cli import main
from sigmatau.simulation.imperfections import Outage, Temperature, WarmUp
from sigmatau.units import to_si

MODEL = """\
[channels.gyro_x]
random_walk = "0.3 deg/sqrt(h)"
bias_instability = "12 deg/h"
[channels.accel_z]
random_walk = "0.1 m/s/sqrt(h)"
"""
ALWAYS = ["--hours", "0.05", "--rate", "50", "--seed", "7", "-q"]


@pytest.fixture
def model(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.toml").write_text(MODEL)
    return NoiseModel.read(tmp_path / "m.toml")


def test_every_option_reaches_the_log(model):
    argv = [
        *("--level", "accel_z=1g", "--warm-up", "gyro=20deg/h:1min,accel_z=-1mg:30s"),
        *("--temperature", "start=20degC,end=35degC,time=1min,swing=3K,resolution=0.5K"),
        *("--sensitivity", "gyro=5deg/h/K", "--saturation", "gyro=0.05deg/s", "--lsb", "gyro=0.01deg/s,accel=1mg"),
        *("--gaps", "0.5%,20s:2s", "--gaps", "1min:1s", "--jitter", "20us"),
    ]
    assert main(["simulate", "m.toml", *ALWAYS, *argv, "-o", "a.csv"]) == 0
    given = Imperfections(
        level={"accel_z": to_si(1, "g")},
        warm_up={
            "gyro": WarmUp(amplitude=to_si(20, "deg/h"), time=60.0),
            "accel_z": WarmUp(amplitude=to_si(-1, "mg"), time=30.0),
        },
        temperature=Temperature(
            start=20.0, end=35.0, time=60.0, swing=3.0, resolution=0.5, sensitivity={"gyro": to_si(5, "deg/h")}
        ),
        saturation={"gyro": to_si(0.05, "deg/s")},
        lsb={"gyro": to_si(0.01, "deg/s"), "accel": to_si(1, "mg")},
        lost=0.005,
        outages=(Outage(start=20.0, length=2.0), Outage(start=60.0, length=1.0)),
        jitter=20e-6,
    )
    expected = simulate(model, duration=180.0, rate=50.0, rng=7, imperfections=given, flicker="poles")
    got = read("a.csv")
    assert got.channels == (*model.channels, "temperature")
    for channel in got.channels:
        np.testing.assert_array_equal(
            got.stream_of(channel).column(channel), expected.stream_of(channel).column(channel)
        )
    assert np.nanmax(np.abs(got.stream_of("gyro_x").column("gyro_x"))) == pytest.approx(to_si(0.05, "deg/s"))


@pytest.mark.parametrize("output", ["increments", "accumulated"])
def test_other_output(model, output):
    assert main(["simulate", "m.toml", *ALWAYS, "--input", output, "--lsb", "gyro=0.1arcsec", "-o", "a.npz"]) == 0
    given = Imperfections(output=output, lsb={"gyro": to_si(0.1, "arcsec")})
    expected = simulate(model, duration=180.0, rate=50.0, rng=7, imperfections=given, flicker="poles")
    got = read("a.npz", input=output)
    for channel in model.channels:
        column, wanted = (record.stream_of(channel).column(channel) for record in (got, expected))
        np.testing.assert_allclose(column, wanted, rtol=1e-12, atol=0)


@pytest.mark.parametrize(
    ("text", "start"),
    [("300K", 26.85), ("0K", -273.15), ("2e1degC", 20.0), ("2.5e+1 °C", 25.0), (".5C", 0.5), ("2931.5e-1 K", 20.0)],
)
def test_kelvin_and_degrees(model, text, start):
    """Of temperatures kelvins count from absolute zero; of a swing and a step both are the same."""
    given = f"start={text},end=3e2K,swing=0degC,resolution=0.01K"
    assert main(["simulate", "m.toml", *ALWAYS, "--temperature", given, "-o", "a.npz"]) == 0
    shown = np.load("a.npz")["temperature [degC]"]
    # Of the step of 0.01 K, and what has changed by the last of 180 s with a time of 20 min.
    assert shown[0] == pytest.approx(start, abs=0.0051)
    assert shown[-1] == pytest.approx(26.85 + (start - 26.85) * math.exp(-180 / 1200), abs=0.01)


def test_exact_flicker_noise(model):
    assert main(["simulate", "m.toml", *ALWAYS, "--flicker", "exact", "-o", "a.npy"]) == 0
    expected = simulate(model, duration=180.0, rate=50.0, rng=7)
    assert np.array_equal(np.load("a.npy")["gyro_x [rad/s]"], expected.stream_of("gyro_x").column("gyro_x"))


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (["--level", "accel_z=1"], "--level accel_z '1': want a value with its unit"),
        (["--level", "accel_z=1deg/s"], "deg/s"),
        (["--level", "gyro_y=1deg/s"], "--level: the model has no 'gyro_y'"),
        (["--level", "accel_z"], "--level 'accel_z': must be NAME=VALUE"),
        (["--warm-up", "gyro=1deg/s"], "must be amplitude:time"),
        (["--warm-up", "gyro=1deg/s:1deg"], "--warm-up gyro: the unit"),
        (["--temperature", "start=20degC"], "must have start and end"),
        (["--temperature", "start=20degC,end=30"], "--temperature end=30"),
        (["--temperature", "start=20degC,end=1.2.3K"], "--temperature end=1.2.3K"),
        (["--temperature", "start=20degC,end=30degC,top=40degC"], "must have start and end"),
        (["--sensitivity", "gyro=1deg/h/K"], "needs --temperature"),
        (["--temperature", "start=20degC,end=30degC", "--sensitivity", "gyro=1deg/h"], "5deg/h/K"),
        (["--lsb", "gyro=0.1arcsec"], "arcsec"),
        (["--input", "increments", "--lsb", "gyro=0.1deg/s"], "deg/s"),
        (["--gaps", "0.1"], "--gaps 0.1"),
        (["--gaps", "1%,2%"], "once"),
        (["--gaps", "70%"], "0 to 0.5"),
        (["--gaps", "10s:5m"], "--gaps 10s:5m: unknown unit"),
        (["--temperature", "start=-300degC,end=20degC"], "at the start must be above -273.15 °C"),
        (["--gaps", "2h:5s"], "7200 s begins after the end of the record, 180 s"),
        (["--gaps", "0s:200s"], "covers the whole record"),
        (["--jitter", "20"], "--jitter"),
        (["--jitter", "-1us"], "the jitter of the stamps must be 0 or a positive number"),
        (["--temperature", "start=20degC,end=30degC,swing=3"], "swing=3: must be degrees, e.g. 3K"),
        (["--temperature", "start=-1K,end=30degC"], "at the start must be above -273.15 °C, not -274.15"),
        (["--jitter", "5ms"], "tenth of the sample interval"),
    ],
)
def test_wrong_options(model, tmp_path, argv, words, capsys):
    assert main(["simulate", "m.toml", *ALWAYS, *argv, "-o", "a.csv"]) == 2
    captured = capsys.readouterr()
    assert words in captured.err
    assert len(captured.err.splitlines()) == 1
    assert len(captured.err) < 250
    assert [p.name for p in tmp_path.iterdir()] == ["m.toml"]


def test_a_length_beyond_all_measure_is_said_in_a_line(model, capsys):
    assert main(["simulate", "m.toml", "--hours", "1e300", "--rate", "100", "-q", "-o", "a.csv"]) == 2
    said = capsys.readouterr().err
    assert "are 3.6e+305 samples; at most" in said
    assert len(said) < 200


def test_what_was_lost_is_said(model, capsys):
    assert main(["simulate", "m.toml", *ALWAYS[:-1], "--gaps", "10s:2s", "-o", "a.npy"]) == 0
    assert "9000 samples of 2 channels, 100 rows lost, seed 7" in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["rate", "increments", "accumulated"])
def test_no_number_of_an_instrument_is_minus_zero(model, kind):
    """Steps so coarse that most numbers are 0, of either sign before they are rounded."""
    lsb = {"rate": "0.1deg/s", "increments": "0.01deg", "accumulated": "0.01deg"}[kind]
    argv = ["--input", kind, "--lsb", f"gyro={lsb}", "-o", "z.csv"]
    assert main(["simulate", "m.toml", *ALWAYS, *argv]) == 0
    column = np.loadtxt("z.csv", delimiter=",", skiprows=1)[:, 1]
    zeros = column[column == 0]
    assert len(zeros) > 10
    assert not np.signbit(zeros).any()
