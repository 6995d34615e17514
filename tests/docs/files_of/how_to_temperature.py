"""Files of docs/how-to/temperature.md."""

import math
from pathlib import Path

import numpy as np

from known import seed_of
from page_records import Imperfections, model_of, simulated, write
from sigmatau.simulation.imperfections import Temperature, WarmUp

_NOISE = {"random_walk": "0.3 deg/sqrt(h)", "bias_instability": "5 deg/h"}
_DEG_PER_H = math.radians(1) / 3600
_SECONDS, _RATE = 5400, 10


def make(folder: Path) -> None:
    """A sensor that warms up, with a thermometer and without; one in a room whose temperature wanders."""
    model = model_of(gyro_x=_NOISE)
    warming = Temperature(start=22, end=34, time=1200, sensitivity={"gyro_x": 10 * _DEG_PER_H})
    warm_up = {"gyro_x": WarmUp(amplitude=100 * _DEG_PER_H, time=600)}
    for name, faults in (("warm", Imperfections(temperature=warming)), ("start", Imperfections(warm_up=warm_up))):
        record = simulated("how-to: temperature", model, seconds=_SECONDS, rate=_RATE, imperfections=faults)
        write(record, folder / f"{name}.csv")
    _in_a_room(folder / "room.csv")


def _in_a_room(path: Path) -> None:
    """A temperature that wanders by 1 K in half an hour, and a gyro that follows it by 20 deg/h/K."""
    model = model_of(gyro_x=_NOISE)
    record = simulated("how-to: temperature of a room", model, seconds=_SECONDS, rate=_RATE)
    rng = np.random.default_rng(seed_of("how-to: temperature of a room"))
    steps = rng.normal(0, math.sqrt(2 * 10 / 1800), _SECONDS // 10)  # of 10 s
    degrees = np.empty(len(steps))
    degrees[0] = rng.normal()
    for k in range(1, len(steps)):
        degrees[k] = degrees[k - 1] * math.exp(-10 / 1800) + steps[k]
    times = np.arange(_SECONDS * _RATE) / _RATE
    shown = np.interp(times, 10.0 * np.arange(len(steps)), 22 + degrees)
    rates = record.stream_of("gyro_x").column("gyro_x") + 20 * _DEG_PER_H * (shown - 22)
    rows = np.column_stack([times, rates, np.round(shown * 16) / 16])
    head = "time [s],gyro_x [rad/s],temperature [degC]"
    np.savetxt(path, rows, fmt=["%.1f", "%.7g", "%.4f"], delimiter=",", header=head, comments="")
