"""Logs of temperature cycles for the tests."""

import numpy as np

from known import seed_of
from sigmatau import NoiseModel, Record, simulate

DEG_H = np.pi / 180 / 3600
AXES = [f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"]


def ramp(n, low=-40.0, high=85.0):
    """Temperature up and down. [°C]"""
    return low + (high - low) * (1 - np.abs(2 * (np.arange(n) + 0.5) / n - 1))


def steps(n, held=(-40.0, 0.0, 40.0, 85.0, 40.0, 0.0, -40.0)):
    """Temperature in steps that are held, with transitions. [°C]"""
    place = (np.arange(n) + 0.5) / n * len(held)
    step = np.minimum(place.astype(int), len(held) - 1)
    before = np.array(held)[np.maximum(step - 1, 0)]
    share = np.where(step == 0, 1.0, np.clip((place - step) / 0.2, 0, 1))
    return before + (np.array(held)[step] - before) * share


def noise(case, n, rate, *, channels=("gyro_x",), walk="0.3 deg/sqrt(h)", **terms):
    """Columns of noise by channel. [rad/s, m/s²]"""
    accel = {"random_walk": "0.05 m/s/sqrt(h)"}
    model = {name: {"random_walk": walk, **terms} if name.startswith("gyro") else accel for name in channels}
    record = simulate(NoiseModel.from_dict({"channels": model}), duration=n / rate, rate=rate, rng=seed_of(case))
    return {name: record.stream_of(name).column(name) for name in channels}


def log(case, temperature, *, rate=5.0, mean=(50.0, 5.0, 0.02, -4e-4), loop=0.0, channels=("gyro_x",), **terms):
    """A log whose mean is a polynomial in T - 25 °C [deg/h, and 1e-5 m/s²], with a hysteresis of `loop` at 22.5 °C."""
    n = len(temperature)
    columns = noise(case, n, rate, channels=channels, **terms)
    falling = np.gradient(temperature) < 0
    u = (temperature - (temperature.min() + temperature.max()) / 2) / (np.ptp(temperature) / 2)
    drift = np.polynomial.polynomial.polyval(temperature - 25, mean) + loop * (falling - 0.5) * (1 - u * u)
    for name in columns:
        size = DEG_H if name.startswith("gyro") else 1e-5
        columns[name] = columns[name] + size * drift + (9.80665 if name == "accel_z" else 0.0)
    return Record.from_arrays(rate=rate, temperature=temperature, **columns)
