"""`sigmatau curve` and `read_curves`: curves of other programs, and what they do not state."""

import json
import math
import os
from pathlib import Path

import numpy as np
import pytest

import sigmatau as st
from conftest import ROOT
from known import seed_of
from sigmatau.cli import main

RATE, DURATION = 20.0, 1800.0
PHASEDAT = Path(os.environ.get("SIGMATAU_FIELD_DATA", ROOT.parent / "shared" / "data")) / "phasedat"


@pytest.fixture(scope="module")
def curves():
    """Curves of a gyro and an accelerometer."""
    terms = {"random_walk": 1e-4, "bias_instability": 3e-5}
    channels = {"gyro_x": terms, "gyro_y": {"random_walk": 2e-4}, "accel_z": {"random_walk": 1e-3}}
    record = st.simulate(
        st.NoiseModel(channels=channels), duration=DURATION, rate=RATE, rng=seed_of("curves of a table")
    )
    return st.allan(record)


def table(path, columns):
    rows = zip(*columns.values(), strict=True)
    path.write_text("\n".join([",".join(columns), *(",".join(f"{value!r}" for value in row) for row in rows)]) + "\n")
    return path


def numbers(values):
    return [float(value) for value in values]


def test_the_fit_is_that_of_the_curve(curves, tmp_path):
    """In other units, as variances and as deviations, in any order of the columns."""
    degrees = np.degrees(1) * 3600
    file = table(
        tmp_path / "curves.csv",
        {
            "accel_z adev [ug]": numbers(curves["accel_z"].adev / 9.80665e-6),
            "tau [s]": numbers(curves["gyro_x"].tau),
            "gyro_x avar [(deg/h)^2]": numbers(curves["gyro_x"].avar * degrees**2),
            "gyro_y adev [deg/h]": numbers(curves["gyro_y"].adev * degrees),
        },
    )
    read = st.read_curves(file, rate=RATE, duration=DURATION)
    assert [*read] == ["accel_z", "gyro_x", "gyro_y"]
    for name, curve in read.items():
        assert np.allclose(curve.avar, curves[name].avar, rtol=1e-12)
        assert np.array_equal(curve.m, curves[name].m)
        assert np.array_equal(curve.n_pairs, curves[name].n_pairs)
        terms = ("quantization", "random_walk", "bias_instability", "rate_random_walk")
        assert st.fit(curve, terms=terms).model == pytest.approx(st.fit(curves[name], terms=terms).model, rel=1e-9)


def test_the_model_goes_on_to_a_filter(curves, tmp_path, capsys):
    file = table(
        tmp_path / "c.csv", {"tau": numbers(curves["gyro_x"].tau), "adev [rad/s]": numbers(curves["gyro_x"].adev)}
    )
    model, result, figure = (tmp_path / name for name in ("m.toml", "r.json", "c.png"))
    options = ["--rate", "20", "--hours", "0.5", "-o", str(model), "--json", str(result), "--plot", str(figure)]
    assert main(["curve", str(file), *options]) == 0
    out, err = capsys.readouterr()
    assert "gyro   generalised least squares" in out
    assert "the record was not seen" in err
    assert figure.stat().st_size > 5000
    content = json.loads(result.read_text())["channels"]["gyro"]
    term = content["fit"]["terms"]["random_walk"]
    assert term["low"] < 1e-4 < term["high"]
    assert st.NoiseModel.read(model).channels["gyro"]["random_walk"] == pytest.approx(term["value"])
    assert main(["plan", str(model), "--term", "rate_random_walk", "--rate", "20", "--hours", "2"]) == 0
    capsys.readouterr()
    assert main(["curve", str(file), "--rate", "20", "--hours", "0.5", "--read-off"]) == 0
    assert "read off" in capsys.readouterr().out


@pytest.mark.skipif(not PHASEDAT.exists(), reason="needs the data of Stable32")
def test_a_file_of_stable32():
    path = PHASEDAT / "phase_dat_oadev.txt"
    columns = {"tau": "2", "gyro_x": "6"}
    curve = st.read_curves(path, rate=1, duration=1000, columns=columns, unit="rad/s", content="deviation")["gyro_x"]
    assert curve.adev[0] == 0.29223
    assert curve.n_pairs[0] == 999  # as the file states


@pytest.mark.parametrize(
    ("columns", "options", "code", "message"),
    [
        (("x", "y"), {}, 2, "no single column of averaging times: x, y"),
        (("tau", "a", "b"), {}, 2, "no column with the name of a channel: tau, a, b"),
        (("tau", "adev"), {}, 2, "does not state the unit of adev. Give it, e.g. --unit deg/h"),
        (("tau", "gyro_x"), {"--unit": "deg/h"}, 2, "has deviations or variances. Give --content deviation"),
        (("tau", "adev [deg/h]"), {"--unit": "deg/s"}, 2, "is not the unit 'deg/h' of adev"),
        (("tau", "avar [deg/h]"), {"--content": "deviation"}, 2, "contradicts the column avar"),
        (("tau", "adev [deg/sqrt(h)]"), {}, 2, "is not the unit of a rate"),
        (("tau", "gyro_x adev [deg/rtHz]"), {}, 2, "'deg/rtHz' is not the unit of a rate. Give one such as deg/h"),
        (("tau", "gyro_x adev"), {"--unit": "kg"}, 2, "'kg' is not the unit of a rate"),
        (("tau", "adev [kg]"), {}, 2, "m/s^2 or ug. For another signal, name its column, --columns tau=1,signal=2"),
        (("tau", "adev [deg/h]"), {"--columns": "gyro_x=3"}, 2, "no column '3' among tau"),
        (("tau", "adev [m/s^2]"), {"--columns": "gyro_x=2"}, 2, "gyro_x is not a sensor of m/s^2"),
        (("tau", "adev [deg/h]"), {"--rate": "3"}, 1, "line 2: the averaging time is no multiple"),
        (("tau", "adev [deg/h]"), {"--hours": "0.001"}, 1, "exceeds half of the record, 1.8 s"),
        (("tau", "adev [deg/h]"), {"--hours": "-1"}, 2, "--hours -1: must be a positive number"),
        (("tau", "adev [deg/h]"), {"--read-off": None, "-o": "m.toml"}, 2, "--output needs the fit"),
    ],
)
def test_what_is_not_stated_is_asked(tmp_path, capsys, columns, options, code, message):
    tau = [0.1 * 2**k for k in range(12)]
    values = [5.0 / math.sqrt(each) for each in tau]
    file = table(tmp_path / "c.csv", dict(zip(columns, [tau, *[values] * (len(columns) - 1)], strict=True)))
    words = {"--rate": "10", "--hours": "1"} | options
    argv = [word for pair in words.items() for word in pair if word is not None]
    assert main(["curve", str(file), *argv]) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert message in " ".join(err.split())


def test_a_named_signal_has_any_unit(tmp_path, capsys):
    tau = [0.1 * 2**k for k in range(12)]
    file = table(tmp_path / "c.csv", {"tau": tau, "adev [nT]": [5.0 / math.sqrt(each) for each in tau]})
    words = ["--rate", "10", "--hours", "1", "--columns", "tau=1,mag_x=2"]
    assert main(["curve", str(file), *words]) == 0
    assert capsys.readouterr().out.startswith("mag_x ")


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        ((3, 1), "nan", "line 5: adev is not a positive number"),
        ((3, 1), "-1", "line 5: adev is not a positive number"),
        ((3, 0), "0.1", "line 5: the averaging time does not rise"),
        ((0, 0), "0", "line 2: the averaging time is not a positive number"),
        ((11, 0), "x", "line 13"),
    ],
)
def test_values_that_a_curve_cannot_have(tmp_path, place, value, message):
    rows = [[repr(0.1 * 2**k), repr(5.0 / 2 ** (k / 2))] for k in range(12)]
    rows[place[0]][place[1]] = value
    (tmp_path / "c.csv").write_text("tau,adev [deg/h]\n" + "".join(f"{a},{b}\n" for a, b in rows))
    with pytest.raises(st.DataError, match=message):
        st.read_curves(tmp_path / "c.csv", rate=10, duration=3600)


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (("tau [s]", "gyro_x adev [rad/s]", "gyro_x error [rad/s]"), "several columns of gyro_x"),
        (("tau [s]", "gyro_x mdev [rad/s]"), "another deviation"),
        (("tau [h]", "gyro_x adev [rad/s]"), "averaging times in h"),
    ],
)
def test_a_table_with_other_contents_is_refused(curves, tmp_path, capsys, names, message):
    """An error of a deviation, another deviation or hours would give wrong coefficients without a word."""
    curve = curves["gyro_x"]
    columns = dict(zip(names, (curve.tau, curve.adev, curve.adev / 50), strict=False))
    file = table(tmp_path / "other.csv", {name: numbers(values) for name, values in columns.items()})
    assert main(["curve", str(file), "--rate", str(RATE), "--hours", str(DURATION / 3600)]) != 0
    assert message in capsys.readouterr().err


def test_a_wrong_unit_has_a_warning(curves, tmp_path, capsys):
    """deg/h that are read as deg/s have more noise than any gyro; the right unit has no finding."""
    degrees = np.degrees(1) * 3600
    columns = {"tau": numbers(curves["gyro_x"].tau), "gyro_x adev": numbers(curves["gyro_x"].adev * degrees)}
    file, path = table(tmp_path / "curve.csv", columns), tmp_path / "curve.json"
    for unit, codes in (("deg/s", ["beyond_class"]), ("deg/h", [])):
        args = ["--rate", str(RATE), "--hours", str(DURATION / 3600), "--unit", unit, "--json", str(path)]
        assert main(["curve", str(file), *args]) == 0
        assert [finding["code"] for finding in json.loads(path.read_text())["findings"]] == codes
        lines = [line for line in capsys.readouterr().err.splitlines() if line.startswith("warning: gyro_x: noise of")]
        assert len(lines) == len(codes)
        assert all(line.endswith("check the unit") for line in lines)
