"""A ramp and runs of the pages about temperature."""

import math
from pathlib import Path

import numpy as np

from page_records import model_of, simulated

_NOISE = {"random_walk": "0.3 deg/sqrt(h)", "bias_instability": "3 deg/h"}
_DEG_PER_H = math.radians(1) / 3600
_RATE = 2
_NAMES = [f"gyro_{axis}" for axis in "xyz"]


def write_cycle(folder: Path, seconds: int = 10800) -> None:
    """A ramp from -40 to 85 °C and back with a hysteresis, and runs of three units at four temperatures."""
    model = model_of(**dict.fromkeys(_NAMES, _NOISE))
    n = seconds * _RATE
    times = np.arange(n) / _RATE
    degrees = -40 + 125 * (1 - np.abs(2 * (np.arange(n) + 0.5) / n - 1))
    loop = 30 * (times > seconds / 2) * (1 - ((degrees - 22.5) / 62.5) ** 2)
    record = simulated("how-to: temperature calibration", model, seconds=seconds, rate=_RATE)
    columns = [times]
    for k, name in enumerate(_NAMES, 1):
        drift = 20 * k + 4 * (degrees - 25) + 0.02 * (degrees - 25) ** 2 - 3e-4 * (degrees - 25) ** 3 + loop
        columns.append(record.stream_of(name).column(name) + _DEG_PER_H * drift)
    _write(folder / "ramp.csv", [*columns, np.round(degrees * 16) / 16], temperature=True)
    for unit in (1, 2, 3):
        for t in (-40, 0, 40, 80):
            short = simulated(f"how-to: unit {unit} at {t}", model, seconds=300, rate=_RATE)
            size = 1 + 0.05 * unit + 0.002 * t
            rates = [size * short.stream_of(name).column(name) + _DEG_PER_H * (30 + 4 * t) for name in _NAMES]
            (folder / "runs" / f"T{t}").mkdir(parents=True, exist_ok=True)
            _write(
                folder / "runs" / f"T{t}" / f"SN{unit}.csv", [np.arange(300 * _RATE) / _RATE, *rates], temperature=False
            )


def _write(path: Path, columns: list[np.ndarray], *, temperature: bool) -> None:
    head = ["time [s]", *(f"{name} [rad/s]" for name in _NAMES), *(["temperature [degC]"] if temperature else [])]
    formats = ["%.1f", *["%.7g"] * 3, *(["%.4f"] if temperature else [])]
    np.savetxt(path, np.column_stack(columns), fmt=formats, delimiter=",", header=",".join(head), comments="")
