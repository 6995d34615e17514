"""The files of docs/how-to/certificate.md: a log with dates and a thermometer, specification and logo, and three units."""

from pathlib import Path

import numpy as np

from known import seed_of

RATE, SECONDS = 10, 1200
LOGO = """\
<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 120 60"><rect width="120" height="60" rx="6" fill="#0b5cad"/>
<path d="M10 45 L45 15 L60 34 L75 22 L110 45" fill="none" stroke="#fff" stroke-width="5"/></svg>
"""
SPEC = """\
name = "Unit 7"
maker = "us"
source = "specification 12, revision C"

[gyro]
random_walk = { maximum = "0.16 deg/sqrt(h)" }
bias_stability = { maximum = "20 deg/h", average = "10 s" }

[accel]
noise_density = { maximum = "70 ug/sqrt(Hz)", sided = "one" }
"""


def make(folder: Path) -> None:
    """Twenty minutes of a unit; the third gyro is near its maximum."""
    rng = np.random.default_rng(seed_of("certificate"))
    n = RATE * SECONDS
    gyro = rng.standard_normal((n, 3)) * np.array([2.9e-5, 3.0e-5, 4.65e-5]) * np.sqrt(RATE)
    accel = rng.standard_normal((n, 3)) * 3.0e-4 * np.sqrt(RATE) + [0, 0, 9.80665]
    degrees = 24.6 + 0.4 * (1 - np.exp(-np.arange(n) / n * 3)) + 0.02 * rng.standard_normal(n)
    begin = np.datetime64("2026-05-07T09:30:00", "ms")
    names = [f"gyro_{axis} [rad/s]" for axis in "xyz"] + [f"accel_{axis} [m/s^2]" for axis in "xyz"]
    lines = ["time," + ",".join(names) + ",temperature [degC]"]
    step = 1000 // RATE
    for k, (w, f, t) in enumerate(zip(gyro, accel, degrees, strict=True)):
        values = ",".join(f"{value:.7g}" for value in (*w, *f))
        lines.append(f"{begin + np.timedelta64(step * k, 'ms')},{values},{t:.5g}")
    (folder / "static.csv").write_text("\n".join([*lines, ""]))
    (folder / "logo.svg").write_text(LOGO)
    (folder / "spec.toml").write_text(SPEC)
    (folder / "shift").mkdir()
    head = f"time [s],{','.join(names)}"
    for unit, rows in (("SN1007", slice(0, n // 2)), ("SN1008", slice(n // 2, n))):
        numbers = np.column_stack([np.arange(n // 2) / RATE, gyro[rows] * [1, 1, 0.7], accel[rows]])
        lines = [",".join(f"{value:.7g}" for value in row) for row in numbers]
        (folder / "shift" / f"{unit}_2026-05-07.csv").write_text("\n".join([head, *lines, ""]))
    (folder / "shift" / "SN1009_2026-05-07.csv").write_text("")
