"""A simulated lot of 40 units from a production line: most are good, six are not; and results of three units."""

import functools
import json

import numpy as np

from known import seed_of
from sigmatau import NoiseModel, Record, analyze, simulate

UNITS, RATE, DURATION = 40, 5, 600
BAD, SPIKES, WRONG_UNIT, TRUNCATED, EMPTY, MISSING = 5, 12, 18, 25, 30, 40

SPEC = """\
name = "Unit 7"
maker = "us"
source = "specification 12, revision C"

[gyro]
random_walk = { typical = "0.1 deg/sqrt(h)", maximum = "0.16 deg/sqrt(h)" }
bias_stability = { maximum = "20 deg/h", average = "10 s" }

[accel]
noise_density = { maximum = "70 ug/sqrt(Hz)", sided = "one" }
"""

NAMES = [f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"]


def rates(unit, *, kind="lot", duration=DURATION):
    """Angular rates and accelerations of a unit at rest, shape (n, 6); units differ by 4 %."""
    rng = np.random.default_rng(seed_of(f"{kind} unit {unit}"))
    factors = np.exp(0.04 * rng.standard_normal(6)) * (6 if unit == BAD else 1)
    walks = [3e-5] * 3 + [3e-4] * 3
    model = {name: {"random_walk": walk * f} for name, walk, f in zip(NAMES, walks, factors, strict=True)}
    record = simulate(NoiseModel(channels=model), duration=duration, rate=RATE, rng=rng)
    x = np.column_stack([record.stream_of(name).column(name) for name in NAMES])
    x[:, 5] += 9.80665
    if unit == SPIKES:
        places = rng.choice(len(x), 20, replace=False)
        x[places, 1] += rng.choice([-1, 1], 20) * 0.01
    if unit == WRONG_UNIT:
        x[:, :3] = np.degrees(x[:, :3])
    return x


def write_log(path, x, *, rate=RATE):
    """A log with time stamps; the file states that the gyros are in rad/s."""
    head = ",".join(f"{name} [{'rad/s' if name.startswith('gyro') else 'm/s^2'}]" for name in NAMES)
    time = np.arange(len(x)) / rate
    np.savetxt(path, np.column_stack([time, x]), delimiter=",", header=f"time [s],{head}", comments="", fmt="%.8g")


def write_lot(folder):
    """Write the lot and its specification."""
    folder.mkdir(exist_ok=True)
    for unit in range(1, UNITS + 1):
        path = folder / f"unit{unit:02}.csv"
        if unit == MISSING:
            continue
        if unit == EMPTY:
            path.write_bytes(b"")
            continue
        write_log(path, rates(unit))
        if unit == TRUNCATED:
            raw = path.read_bytes()
            path.write_bytes(raw[: int(0.55 * len(raw)) + 3])
    (folder.parent / "spec.toml").write_text(SPEC, encoding="utf-8")


# Random walks of about a sixth of the maxima of docs/how-to/datasheets.md, and the same ten times larger; B cannot be
# determined from the short record.
GYRO, ACCEL = 2.3e-5, 2.5e-4
_UNITS = {"good": (1.0, 1 << 15), "bad": (10.0, 1 << 15), "short": (1.0, 500)}


@functools.cache
def results_of_units():
    """Results of a good, a bad and a short record, as JSON."""
    results = {}
    for name, (factor, n) in _UNITS.items():
        noise = np.random.default_rng(seed_of(f"unit {name}")).standard_normal((n, 6)) * factor * 10
        record = Record.from_arrays(
            rate=100.0, gyro=GYRO * noise[:, :3], accel=ACCEL * noise[:, 3:], unit={"gyro": "rad/s", "accel": "m/s^2"}
        )
        results[name] = json.dumps(analyze(record, at_rest=name == "short").to_dict())
    return results
