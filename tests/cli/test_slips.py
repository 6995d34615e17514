"""Slips in typing a command: the message says what to type, and what it says works."""

import os
import re
import shlex

import numpy as np
import pytest

from known import seed_of
from sigmatau.cli import main


@pytest.fixture
def log(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cells = np.random.default_rng(seed_of("slips")).normal(0, 1e-3, (2000, 3))
    for name in ("log.csv", "day2.csv"):
        np.savetxt(name, cells, delimiter=",", header="gyro_x,gyro_y,gyro_z", comments="", fmt="%.6f")
    return tmp_path


RIGHT = ("--rate", "100", "--unit", "gyro=rad/s")
SLIPS = {
    "a unit behind the rate": (("--rate", "100Hz", *RIGHT[2:]), "in Hz, e.g. --rate 100"),
    "a unit behind the rate of a sensor": (("--rate", "gyro=100 Hz", *RIGHT[2:]), "in Hz, e.g. --rate gyro=100"),
    "a decimal comma": (("--rate", "100,5", *RIGHT[2:]), "a decimal one with a point: --rate 100.5"),
    "a swapped unit": (("--rate", "100", "--unit", "rad/s=gyro"), "the name comes first. Give --unit gyro=rad/s"),
    "swapped columns": ((*RIGHT, "--channels", "1:3=gyro"), "the name comes first. Give --channels gyro=1:3"),
}


@pytest.mark.parametrize("case", SLIPS)
def test_what_the_message_says_works(log, case, capsys):
    words, said = SLIPS[case]
    assert main(["analyze", "log.csv", *words, "-q"]) == 2
    err = capsys.readouterr().err
    assert said in err
    option, value = shlex.split(re.search(r"--[a-z]+ \S+$", said)[0])
    mended = list(words)
    mended[mended.index(option) + 1] = value
    assert main(["analyze", "log.csv", *mended, "-q"]) == 0, capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("analyze", "log.csv", "--rate", "100", "Hz"), "Write a rate in Hz without the unit, e.g. --rate 100"),
        (("analyze", "log.csv", *RIGHT, "--scale", "gyro=0,01"), "Write a decimal number with a point, e.g. gyro=0.01"),
        (("analyze", "-"), "live samples: … | sigmatau watch"),
        (("inspect", "log.csv", "day2.csv"), "takes one file, and day2.csv is one more. Run it once for each file"),
        (("fleet", "log.csv"), "the logs follow the word analyze: sigmatau fleet analyze log.csv"),
        (("fleet", "analyze", "log.csv", "--export", "kalibr=a.yaml"), "sigmatau analyze LOG --export TARGET=FILE"),
        (("analyze", "log.csv", "--export", "kalib=a.yaml"), "unknown target 'kalib', perhaps kalibr; targets:"),
    ],
)
def test_slips_are_named(log, words, said, capsys):
    assert main(list(words)) == 2
    assert said in capsys.readouterr().err


def test_a_column_may_have_the_name_of_a_sensor(log, capsys):
    assert main(["analyze", "log.csv", *RIGHT, "--channels", "x=gyro_x", "--unit", "x=1", "-q"]) in (0, 2)
    assert "comes first" not in capsys.readouterr().err


def test_a_folder_that_is_read_only_is_told_before_the_log_is_read(log, monkeypatch, capsys):
    real = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.W_OK and real(path, mode))
    monkeypatch.setattr("sigmatau.cli.analyze.read_log", None)
    assert main(["analyze", "log.csv", *RIGHT, "--json", "r.json"]) == 1
    assert "r.json: the directory . is read-only; give another place" in capsys.readouterr().err
