"""Symbols on a screen that does not have them."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from known import seed_of

UNSET = ("LC_ALL", "LC_CTYPE", "LANG", "PYTHONIOENCODING", "PYTHONUTF8")


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    path = tmp_path_factory.mktemp("symbols") / "log.csv"
    y = np.random.default_rng(seed_of("symbols")).standard_normal((20_000, 2)) * [0.01, 0.1]
    np.savetxt(path, y, delimiter=",", header="gyro_x [rad/s],accel_x [m/s^2]", comments="")
    return path


def printed(log, *options, **environment):
    """Standard output and standard error, as bytes."""
    kept = {key: value for key, value in os.environ.items() if key not in UNSET}
    command = [sys.executable, "-m", "sigmatau", "analyze", str(log), "--rate", "100", *options]
    done = subprocess.run(command, capture_output=True, check=True, env=kept | environment)
    return done.stdout, done.stderr


def columns(text):
    """Where the last column of a table begins."""
    return {line.rindex("  ") for line in text.splitlines() if line.startswith(("gyro", "accel"))}


@pytest.mark.parametrize("environment", [{"PYTHONIOENCODING": "ascii"}, {"LC_ALL": "POSIX", "LANG": "de_DE"}])
def test_ascii(log, environment):
    for options in ((), ("-v",)) if "PYTHONIOENCODING" in environment else ((),):
        out, err = printed(log, *options, **environment)
        assert out.isascii()
        assert err.isascii()
        text = out.decode("ascii")
        assert "deg/sqrt(h)" in text
        assert "+-" in text
        assert "?" not in text
        assert "\\u" not in text
        assert options or len(columns(text)) == 1


def test_windows_has_some_symbols(log):
    text = printed(log, PYTHONIOENCODING="cp1252")[0].decode("cp1252")
    assert "deg/sqrt(h)" in text
    assert "±" in text
    assert "µg" in text


@pytest.mark.parametrize("environment", [{}, {"LANG": "C", "PYTHONUTF8": "1"}])
def test_symbols_where_the_screen_has_them(log, environment):
    assert "deg/√h" in printed(log, **environment)[0].decode("utf-8")


def test_json_keeps_its_characters(log):
    ascii_, unicode_ = (printed(log, "--json", "-", PYTHONIOENCODING=name)[0] for name in ("ascii", "utf-8"))
    assert ascii_.isascii()
    assert json.loads(ascii_) == json.loads(unicode_.decode("utf-8"))
