"""Logs for the tests of the workbench."""

import numpy as np

from known import seed_of
from sigmatau import Record, write

AXES = [f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"]


def write_log(path, *, rows=6000, rate=100.0, units=("rad/s", "m/s^2"), header=True):
    """A log of six axes at rest."""
    noise = np.random.default_rng(seed_of(path.name)).standard_normal((rows, 6)) * np.repeat([1e-3, 1e-2], 3)
    noise[:, 5] += 9.81
    names = [f"{axis} [{units[axis.startswith('accel')]}]" if units else axis for axis in AXES]
    text = ",".join(["time [s]", *names]) if header else ""
    table = np.column_stack([np.arange(rows) / rate, noise])
    np.savetxt(path, table, delimiter=",", header=text, comments="", fmt="%.9g")
    return path


def write_long(path):
    """Write a log that takes a second to analyse, but little time to read."""
    white = np.random.default_rng(seed_of(path.name)).standard_normal((400_000, 3)) * 1e-3
    write(Record.from_arrays(rate=100, unit={"gyro": "rad/s"}, gyro=white), path)
    return path
