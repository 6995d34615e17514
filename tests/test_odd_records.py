"""Odd records through every command: nothing comes out but results and our own errors."""

import io
import json
import os
import re
import sys

import numpy as np
import pytest

import known
from sigmatau.cli import main

RECORDS = int(os.environ.get("SIGMATAU_ODD_RECORDS", "8"))  # `make fuzz` takes 3000
CODES = range(9)
LENGTHS = (4, 5, 7, 30, 64, 257, 1000, 3000)
RATES = ("100", "100", "100", "1", "2000", "1e-6", "1e9", "0.01")


def walk(rng, n):
    return np.cumsum(rng.normal(size=n))


AXES = {
    "white": lambda rng, n: rng.normal(size=n),
    "offset": lambda rng, n: 9.8 + 0.01 * rng.normal(size=n),
    "constant": lambda rng, n: np.full(n, rng.choice([9.80665, 1e-300, -1e300, 1.0])),
    "dead": lambda rng, n: np.zeros(n),
    "coarse": lambda rng, n: np.round(rng.normal(size=n) * rng.choice([0.1, 0.3, 1, 3])),
    "huge": lambda rng, n: rng.normal(size=n) * rng.choice([1e60, 1e100, 1e130, 1e155, 1e200, 1e307]),
    "tiny": lambda rng, n: rng.normal(size=n) * rng.choice([1e-60, 1e-120, 1e-160, 1e-200, 1e-307, 5e-324]),
    "both": lambda rng, n: rng.normal(size=n) * 10.0 ** rng.integers(-300, 300, n),
    "moving": lambda rng, n: 100 * np.sin(np.arange(n) * rng.uniform(1e-4, 3)) + walk(rng, n),
    "walk": walk,
    "ramp": lambda rng, n: np.arange(n) * rng.choice([1.0, 1e-9, 1e9]),
    "alternating": lambda rng, n: np.arange(n) % 2 * 1.0,
    "held": lambda rng, n: np.repeat(rng.normal(size=n // 7 + 1), 7)[:n],
    "bump": lambda rng, n: rng.normal(size=n) + 1e3 * (np.abs(np.arange(n) - n // 2) < n // 20),
    "knock": lambda rng, n: rng.normal(size=n) + 1e6 * (np.arange(n) == n // 3),
    "one value": lambda rng, n: np.where(np.arange(n) == n - 1, 1.0, 0.0),
    "saturated": lambda rng, n: np.clip(rng.normal(size=n), -0.5, 0.5),
    "line": lambda rng, n: np.sin(np.arange(n) * 0.3),
}
LOSSES = {
    "none": lambda rng, n: np.zeros(n, dtype=bool),
    "few": lambda rng, n: rng.random(n) < 0.01,
    "most": lambda rng, n: rng.random(n) < 0.9,
    "every second": lambda rng, n: np.arange(n) % 2 == 1,
    "first": lambda rng, n: np.arange(n) < n // 2,
    "all": lambda rng, n: np.ones(n, dtype=bool),
}


def axis(rng, n):
    """Numbers of an axis, most of them white noise so that others meet it."""
    kind = rng.choice(list(AXES)) if rng.random() < 0.6 else "white"
    values = AXES[str(kind)](rng, n)
    lost = LOSSES[str(rng.choice(list(LOSSES), p=[0.7, 0.1, 0.05, 0.05, 0.05, 0.05]))](rng, n)
    return np.where(lost, rng.choice([np.nan, np.inf, -np.inf]), values)


def log_of(rng, folder):
    """A log of three or six axes and the options that read it."""
    n = int(rng.choice(LENGTHS))
    names = [f"{sensor}_{a}" for sensor in ("gyro", "accel")[: rng.integers(1, 3)] for a in "xyz"]
    columns = {name: axis(rng, n) for name in names}
    options = ["--rate", str(rng.choice(RATES)), "--unit", f"gyro={rng.choice(['rad/s', 'deg/h'])},accel=g"]
    if len(names) == 3:
        options[-1] = options[-1].split(",")[0]
    if rng.random() < 0.3:
        options[:2] = []
        step = float(rng.choice([0.01, 1e-3, 1.0, 1e-12, 1e6]))
        stamps = np.cumsum(rng.choice([step, step, 1.1 * step, 7 * step, 0.0], n))
        columns = {"time": AXES[str(rng.choice(list(AXES)))](rng, n) if rng.random() < 0.2 else stamps, **columns}
        options[-1] += ",time=s"
    if rng.random() < 0.5:
        path = folder / "log.csv"
        np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="")
    else:
        path = folder / "log.npz"
        if rng.random() < 0.3:  # axes of other lengths
            columns[names[-1]] = columns[names[-1]][: max(n - int(rng.integers(0, 9)), 1)]
        np.savez(path, **columns)
    return path, options


def run(monkeypatch, *argv):
    """Run a command; any exception but those that `main` reports ends the test."""
    out, err = io.StringIO(), io.StringIO()
    monkeypatch.setattr(sys, "stdout", out)
    monkeypatch.setattr(sys, "stderr", err)
    code = main([str(one) for one in argv])
    monkeypatch.undo()
    said = err.getvalue()
    assert code in CODES, said
    if code in (1, 2):
        assert said.splitlines()[-1].startswith("sigmatau: "), said
    if code == 0:
        assert not re.search(r"\bnan\b", out.getvalue()), out.getvalue()
    return code, out.getvalue()


@pytest.mark.parametrize("number", range(RECORDS))
def test_nothing_but_our_own_errors(number, tmp_path, monkeypatch):
    rng = np.random.default_rng(known.seed_of(f"odd record {number}"))
    path, options = log_of(rng, tmp_path)
    result = tmp_path / "result.json"
    run(monkeypatch, "inspect", path, *options, "--json", tmp_path / "i.json")
    code, _ = run(monkeypatch, "analyze", path, *options, "--json", result, "--long", rng.choice(["auto", "strided"]))
    run(monkeypatch, "psd", path, *options, "--method", rng.choice(["welch", "multitaper"]))
    run(
        monkeypatch,
        "deviation",
        path,
        *options,
        "--kind",
        rng.choice(["hadamard", "total", "modified", "tie-rms", "mtie"]),
    )
    if path.suffix == ".csv":
        run(monkeypatch, "watch", path, *options, "--idle", "0.01", "--json", tmp_path / "w.json")
    if result.exists():
        json.loads(result.read_text())
        run(monkeypatch, "compare", result, "--table")
        run(
            monkeypatch,
            "export",
            result,
            "--to",
            rng.choice(["kalibr", "gtsam", "px4", "ieee952"]),
            "-o",
            tmp_path / "e.txt",
        )
        run(monkeypatch, "plan", result, "--term", "bias_instability")
        run(monkeypatch, "predict", result, "--after", "60s")
    else:
        assert code
    assert not [p.name for p in tmp_path.iterdir() if p.name.startswith(".")]
