"""Files that are not logs, with random changes: each command ends with a result or an error in words."""

import json
import random
import re
import sqlite3
import time
from contextlib import closing

import numpy as np
import pytest

import known
import sigmatau as st
from conftest import ROOT
from container_damage import SECONDS, mutants, mutated, mutated_text
from sigmatau.cli import main
from sigmatau.errors import DataError, OptionError
from sigmatau.reporting.certificate_file import read_certificate

MODEL = """
[channels.gyro_x]
random_walk = "0.3 deg/sqrt(h)"
bias_instability = "12 deg/h"
rate_random_walk = "20 deg/h/sqrt(h)"
gauss_markov = [{ sigma = "5 deg/h", time = "300 s" }]
sinusoid = [{ amplitude = "0.01 deg/s", frequency = "0.55 Hz" }]
bandwidth = { order = 1, corner = "30 Hz" }
[channels.accel_x]
random_walk = "0.1 m/s/sqrt(h)"
rate_random_walk = "100 ug/sqrt(h)"
"""
SHEET = """
name = "ISM330DHCX"
maker = "STMicroelectronics"
source = "DS13012 revision 6, table 2"
[gyro]
axes = ["x", "y", "z"]
noise_density = { typical = "5 mdeg/s/sqrt(Hz)", maximum = "90 mdeg/s/sqrt(Hz)", sided = "one" }
bias_instability = { typical = "3 deg/h", as = "minimum" }
bias_stability = { maximum = "0.05 deg/h", average = "10 s" }
full_scale = ["125 deg/s", "2000 deg/s"]
output_rate = ["12.5 Hz to 6.66 kHz"]
"""
PAGE = (ROOT / "docs" / "how-to" / "certificate.md").read_text(encoding="utf-8")
CERTIFICATE = re.search(r"<!-- save: lab.toml -->\n```toml\n(.*?)```", PAGE, re.DOTALL)[1]
LOGO = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 2 1"><rect width="2" height="1" fill="#0b5cad"/></svg>'
CONFIG = """
log = "log.csv"
rate = 100
unit = { gyro = "rad/s" }
method = "gls"
taus = "octave"
"""
KALIBR = "accelerometer_noise_density: 1.5e-3\naccelerometer_random_walk: 1e-4\ngyroscope_noise_density: 2e-4\n" + (
    "gyroscope_random_walk: 1e-5\nrostopic: /imu0\nupdate_rate: 200.0\n"
)
RATES = 1e-3 * np.random.default_rng(known.seed_of("mutated files")).standard_normal((2000, 3))


def table(head, rows):
    return head + "\n" + "\n".join(",".join(f"{x:.6g}" for x in row) for row in rows) + "\n"


def curve(folder):
    taus = 0.01 * 2.0 ** np.arange(12)
    return table("tau [s],gyro_x adev [deg/h]", zip(taus, 20 / np.sqrt(taus), strict=True))


def density(folder):
    frequencies = np.geomspace(0.01, 50, 40)
    return table(
        "frequency [Hz],psd one-sided [(deg/s)^2/Hz]", zip(frequencies, 1e-4 + 1e-6 / frequencies, strict=True)
    )


def innovations(folder):
    return table("time,nu_gyro_x,S_gyro_x", [(k, x, 1e-6) for k, x in enumerate(RATES[:200, 0])])


def result(folder, rates=RATES):
    return st.analyze(st.Record.from_arrays(rate=100, gyro=rates, unit={"gyro": "rad/s"})).to_json()


def store(folder):
    with st.Store(folder / "made.db") as made:
        made.add(st.analyze(st.Record.from_arrays(rate=100, gyro=RATES, unit={"gyro": "rad/s"})), unit="A1")
    with closing(sqlite3.connect(folder / "made.db")) as base:
        base.execute("PRAGMA journal_mode=DELETE")
        base.execute("VACUUM")
    return (folder / "made.db").read_bytes()


def certificate(path):
    try:
        read_certificate(path)
    except (DataError, OptionError):
        return 1
    return 0


KINDS = {  # the file, and what reads it
    "specification.toml": (SHEET, ["lot", "result.json", "--spec", "specification.toml", "-q"]),
    "datasheet.toml": (
        SHEET,
        ["datasheet", "show", "datasheet.toml", "--model", "--sided", "one", "--bias", "minimum"],
    ),
    "model.toml": (MODEL, ["predict", "model.toml", "--after", "60s"]),
    "exported.toml": (MODEL, ["export", "exported.toml", "--to", "kalibr", "--filter-rate", "100", "-o", "imu.yaml"]),
    "compared.json": (result, ["compare", "compared.json", "result.json", "--table"]),
    "imported.json": (
        result,
        ["export", "imported.json", "--to", "state-space", "--filter-rate", "100", "-o", "m.json"],
    ),
    "config.toml": (CONFIG, ["analyze", "log.csv", "--config", "config.toml", "-q"]),
    "curve.csv": (curve, ["curve", "curve.csv", "--rate", "100", "--hours", "1"]),
    "density.csv": (density, ["density", "density.csv", "--averages", "50"]),
    "innovations.csv": (innovations, ["tune", "innovations.csv"]),
    "kalibr.yaml": (KALIBR, ["tune", "innovations.csv", "--model", "kalibr.yaml"]),
    "store.db": (store, ["store", "list", "--store", "store.db"]),
    "certificate.toml": (CERTIFICATE, certificate),
    "logo.svg": (LOGO, lambda path: certificate(path.with_name("lab.toml"))),
}


@pytest.mark.parametrize("name", KINDS)
def test_mutants(tmp_path, monkeypatch, capsys, name):
    if name == "store.db":
        pytest.importorskip("sqlalchemy")
    monkeypatch.chdir(tmp_path)
    content, reader = KINDS[name]
    content = content if isinstance(content, str) else content(tmp_path)
    raw = content.encode() if isinstance(content, str) else content
    (tmp_path / "result.json").write_text(result(tmp_path, RATES[::-1]))
    (tmp_path / "innovations.csv").write_text(innovations(tmp_path))
    (tmp_path / "log.csv").write_text(table("gyro_x,gyro_y,gyro_z", RATES))
    (tmp_path / "lab.toml").write_text(CERTIFICATE)
    (tmp_path / "logo.svg").write_text(LOGO)
    (tmp_path / "spec.toml").write_text(SHEET)
    path, rng = tmp_path / name, random.Random(known.seed_of(f"mutated {name}"))
    change = mutated if isinstance(content, bytes) else mutated_text
    path.write_bytes(raw)
    codes = [reader(path) if callable(reader) else main(reader)]
    assert codes[0] in (0, 3, 4, 5), capsys.readouterr().err
    for number in mutants(100):
        path.write_bytes(change(raw, rng))
        capsys.readouterr()
        begun = time.process_time()
        codes.append(reader(path) if callable(reader) else main(reader))
        printed = capsys.readouterr()
        assert codes[-1] in range(6), (number, printed.err)
        assert "Traceback" not in printed.err, number
        assert all(c.isprintable() or c == "\n" for c in printed.out + printed.err), number
        assert time.process_time() - begun < SECONDS, number
    assert {1, 2} & {*codes}


@pytest.mark.parametrize(
    ("name", "row", "words"),
    [
        ("curve.csv", "0.02,1e200", "the variance of gyro_x adev is not a positive number"),
        ("curve.csv", "1e308,1", "the averaging time exceeds half of the record"),
        ("density.csv", "0.02,1e300", "`density` is beyond 1e+250 at index"),
        ("density.csv", "0.02,1e100", "`density` has values from"),
    ],
)
def test_numbers_whose_squares_are_not_doubles(tmp_path, monkeypatch, capsys, name, row, words):
    """NumPy's warnings of overflows reached the user."""
    monkeypatch.chdir(tmp_path)
    make, reader = KINDS[name]
    rows = [line for line in make(tmp_path).splitlines() if not line.startswith("0.02,")]
    head, *rest = rows
    (tmp_path / name).write_text("\n".join([head, *sorted([*rest, row], key=lambda r: float(r.split(",")[0]))]) + "\n")
    assert main(reader) in (1, 2)
    assert words in " ".join(capsys.readouterr().err.split())


def test_a_deviation_of_a_result_whose_square_is_not_a_double(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    form = json.loads(result(tmp_path))
    form["channels"]["gyro_x"]["curve"]["adev"][0] = 1e200
    (tmp_path / "huge.json").write_text(json.dumps(form))
    assert main(["export", "huge.json", "--to", "state-space", "--filter-rate", "100", "-o", "m.json"]) == 1
    assert "adev has a value beyond 1e+150" in " ".join(capsys.readouterr().err.split())
