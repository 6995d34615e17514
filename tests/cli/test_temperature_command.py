"""``sigmatau temperature``: a ramp, runs in files and in a store, outputs and refusals."""

import json
import re

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, Record, read, simulate, write
from sigmatau.cli import main

RATE = 2.0


def columns(name, n):
    model = NoiseModel.from_dict({"channels": {f"gyro_{axis}": {"random_walk": "0.3 deg/sqrt(h)"} for axis in "xyz"}})
    (stream,) = simulate(model, duration=n / RATE, rate=RATE, rng=seed_of(name)).streams
    return {channel: stream.column(channel) for channel in stream.channels}


@pytest.fixture(scope="module")
def ramp(tmp_path_factory):
    n = 7_200
    temperature = -20 + 80 * (1 - np.abs(2 * np.arange(n) / n - 1))
    rates = {name: x + 2e-5 * (temperature - 25) for name, x in columns("ramp of the command", n).items()}
    path = tmp_path_factory.mktemp("ramp") / "ramp.csv"
    write(Record.from_arrays(rate=RATE, temperature=temperature, **rates), path)
    return path


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    for unit in (1, 2):
        for t in (-40, 0, 40, 80):
            place = folder / f"SN{unit}" / f"T{t}.csv"
            place.parent.mkdir(exist_ok=True)
            rates = {name: x + 1e-3 + 2e-5 * t for name, x in columns(f"run {unit} {t}", 600).items()}
            write(Record.from_arrays(rate=RATE, **rates), place)
    return folder


def test_the_thermometer_survives_the_reader(ramp):
    (stream,) = (stream for stream in read(ramp).streams if stream.quantity == "temperature")
    assert np.ptp(stream.column("temperature")) == pytest.approx(80, abs=0.1)


def test_all_outputs_of_a_ramp(ramp, tmp_path, capsys):
    names = {"report": "r.html", "plot": "p.png", "json": "r.json", "csv": "r.csv"}
    places = {option: tmp_path / name for option, name in names.items()}
    words = [word for option, place in places.items() for word in (f"--{option}", str(place))]
    exports = ["--export", f"px4={tmp_path / 'tc.params'}", "--export", f"ardupilot={tmp_path / 'tcal.parm'}"]
    given = ["--axes", "gyro", "--degree", "1", "--mean=-20,25,60", "--instance", "1", "--device-id", "77"]
    assert main(["temperature", str(ramp), *given, *words, *exports]) == 0
    out = capsys.readouterr().out
    assert "rising and falling, ramp" in out
    assert re.search(r"gyro_x \[deg/h\] +-18\d", out)  # 2e-5 rad/s/K · 45 K is 186 deg/h
    assert all(place.exists() for place in places.values())
    found = json.loads(places["json"].read_text())
    slope = found["channels"]["gyro_x"]["polynomial"]["coefficients"][1]
    assert slope == pytest.approx(2e-5, rel=0.02)
    assert "TC_G1_ID\t77\t6" in (tmp_path / "tc.params").read_text()
    assert "INS_TCAL1_GYR1_X," in (tmp_path / "tcal.parm").read_text()
    assert places["csv"].read_text().startswith("channel,run,temperature_degc")
    assert "sigmatau temperature" in places["report"].read_text() or "pytest" in places["report"].read_text()


def test_a_matrix_of_units(runs, tmp_path, capsys):
    given = ["--temperature-from", r"T(-?\d+)", "--unit-from", r"(SN\d+)", "--quiet"]
    csv, page = tmp_path / "m.csv", tmp_path / "m.html"
    assert main(["temperature", str(runs), *given, "--csv", str(csv), "--report", str(page)]) == 0
    out = capsys.readouterr().out
    assert "2 units at -40, 0, 40, 80 °C" in out
    assert re.search(r"SN1 +0\.\d+", out)
    assert len(csv.read_text().splitlines()) == 1 + 2 * 4 * 3 * 4  # units, temperatures, axes, coefficients
    assert "Gyro random walk" in page.read_text()
    assert main(["temperature", str(runs), *given, "--mean", "25"]) == 2
    assert "choose one by --serial" in capsys.readouterr().err


def test_runs_of_one_unit_and_a_store(runs, tmp_path, capsys):
    unit = str(runs / "SN1")
    assert main(["temperature", unit, "--temperature-from", r"T(-?\d+)", "--degree", "1", "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["channels"]["gyro_y"]["polynomial"]["coefficients"][1] == pytest.approx(2e-5, rel=0.05)
    results = tmp_path / "results"
    results.mkdir()
    for t in (-40, 0, 40, 80):
        log = str(runs / "SN2" / f"T{t}.csv")
        note = ["--note", "serial number=SN2", "--note", f"temperature={t}"]
        assert main(["analyze", log, "--quiet", "--json", str(results / f"{t}.json"), *note]) == 0
    assert main(["store", "add", str(results), "--store", str(tmp_path / "lab.db")]) == 0
    capsys.readouterr()
    for source in (["--store", str(tmp_path / "lab.db"), "--serial", "SN*"], [str(results)]):
        assert main(["temperature", *source, "--degree", "1", "--mean", "20"]) == 0
        out = capsys.readouterr().out
        assert "4 runs" in out
        assert "gyro_z [deg/h]" in out


def refused(capsys, code, words, *given):
    assert main(["temperature", *map(str, given)]) == code
    error = capsys.readouterr().err
    assert re.search(words, error), error


def test_refusals(ramp, runs, tmp_path, capsys):
    refused(capsys, 2, "--mean 90 °C is outside the observed", ramp, "--mean", "90")
    refused(capsys, 2, "--mean 'x'", ramp, "--mean", "x")
    refused(capsys, 2, "px4=FILE", ramp, "--export", "px4")
    refused(capsys, 2, "given twice", ramp, "--export", "px4=a", "--export", "px4=b")
    refused(capsys, 2, "--degree must be 1 to 5", ramp, "--degree", "7")
    refused(capsys, 2, "--degree must be 1 to 5", ramp, "--degree", "0")
    refused(capsys, 2, "--degree must be 1 to 5", runs / "SN1", "--temperature-from", r"T(-?\d+)", "--degree", "0")
    refused(capsys, 2, "--device-id needs --export px4=FILE", ramp, "--device-id", "0")
    refused(capsys, 2, "--device-id needs --export px4", ramp, "--device-id", "7", "--export", "ardupilot=x.parm")
    refused(capsys, 2, "--instance needs --export", ramp, "--instance", "1")
    refused(capsys, 2, "--axes takes the log of a ramp", runs / "SN1", "--axes", "gyro")
    refused(capsys, 2, "name a log")
    refused(capsys, 2, "not both", ramp, "--store", "lab.db")
    refused(capsys, 2, "--serial needs --store", ramp, "--serial", "A")
    refused(capsys, 2, "finds nothing", runs / "SN1", "--temperature-from", r"X(\d+)")
    refused(capsys, 2, "value in parentheses", runs / "SN1", "--temperature-from", "(a")
    refused(capsys, 1, "temperature is not known", runs / "SN1")
    refused(capsys, 1, "T0.csv: the log has no temperature column", runs / "SN1" / "T0.csv")
    n = 7_200
    shaken = {name: x + 0.5 * np.sin(np.arange(n) / 9) for name, x in columns("shaken", n).items()}
    write(Record.from_arrays(rate=RATE, temperature=np.linspace(0, 50, n), **shaken), tmp_path / "moving.csv")
    refused(capsys, 5, "at rest", tmp_path / "moving.csv")


def test_two_outputs_in_one_file_are_refused(ramp, tmp_path, capsys):
    """The second would replace the first."""
    file = tmp_path / "both.json"
    assert main(["temperature", str(ramp), "--json", str(file), "--export", f"px4={file}"]) == 2
    assert "name two files" in capsys.readouterr().err


def test_a_real_log_at_room_temperature_is_refused(field_data, tmp_path, capsys):
    """Ten minutes of an MPU-6050, whose thermometer shows half a kelvin."""
    log = np.load(field_data / "mpu6050_10min.npz")
    rows = np.column_stack([np.arange(len(log["temp_c"])) / 99.32, log["gyro_dps"], log["temp_c"]])[:20_000]
    names = "time [s],gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s],temperature [degC]"
    np.savetxt(tmp_path / "mpu.csv", rows, delimiter=",", header=names, comments="")
    refused(capsys, 1, r"the temperature varies by 0\.\d+ K", tmp_path / "mpu.csv")


def test_a_file_that_cannot_be_used_is_named_and_the_others_are_used(runs, tmp_path, capsys):
    for t in (0, 40):
        (tmp_path / f"T{t}.csv").write_bytes((runs / "SN1" / f"T{t}.csv").read_bytes())
    (tmp_path / "T80.csv").write_text("")
    assert (
        main(["temperature", str(tmp_path), "--temperature-from", r"T(-?\d+)\.", "--csv", str(tmp_path / "m.csv")]) == 1
    )
    out, err = capsys.readouterr()
    assert "1 unit at 0, 40 °C" in out
    assert re.search(r"not used: \S+T80\.csv", err)
    assert "no polynomial: " in err
    assert main(["temperature", str(tmp_path / "T0.csv"), str(tmp_path / "T40.csv"), "--temperature-from", r"T(-?\d+)\.",
                 "--export", f"px4={tmp_path / 'tc.params'}"]) == 1  # fmt: skip
    assert "Add runs" in capsys.readouterr().err
    assert not (tmp_path / "tc.params").exists()
