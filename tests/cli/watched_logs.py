"""Logs that are watched: lines of numbers, and the options that read them."""

import os

import numpy as np

from conftest import ROOT
from known import seed_of
from sigmatau import NoiseModel, simulate
from sigmatau.io.read.options import TableOptions
from sigmatau.io.write import write

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT / "python")}


def options(**given):
    defaults = {"rate": None, "unit": {}, "channels": {}, "input": "rate", "scale": {}, "offset": {}}
    return TableOptions(**{**defaults, **given}).checked()


def write_log(path):
    """Ten minutes of a gyroscope and an accelerometer at rest."""
    model = NoiseModel(
        channels={"gyro_x": {"random_walk": 1e-4, "rate_random_walk": 1e-6}, "accel_x": {"random_walk": 1e-3}}
    )
    write(simulate(model, duration=600, rate=100, rng=1), path)
    return path


def moving_rows(moving, *, n=12_000, rate=100):
    """Two minutes of gyros; they are turned by hand where `moving`. [deg/s]"""
    rng = np.random.default_rng(seed_of("watched motion"))
    t = np.arange(n) / rate
    x = 0.05 * rng.standard_normal((n, 3))
    x[:, 0] += np.where(moving(t), 40 * np.sin(2 * np.pi * 0.4 * t), 0.0)
    return x
