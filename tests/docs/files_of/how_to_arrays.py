"""The files of docs/how-to/arrays.md: a board with four gyros, and four independent gyros on a table that moves."""

from pathlib import Path

import numpy as np

import sigmatau as st
from known import seed_of

RATE, DURATION = 50, 900


def simulated(model: st.NoiseModel, name: str) -> np.ndarray:
    """Rates of all sensors, shape (n, n_sensors). [deg/s]"""
    record = st.simulate(model, duration=DURATION, rate=RATE, rng=seed_of(f"page of arrays, {name}"))
    return np.degrees(np.stack([record.stream_of(channel).column(channel) for channel in model], axis=1))


def make(folder: Path) -> None:
    """The files that the page names."""
    sizes = {"gyro_1": 1.0, "gyro_2": 1.0, "gyro_3": 1.4, "gyro_4": 2.0}
    channels = {name: {"random_walk": 1e-4 * size, "rate_random_walk": 2e-5} for name, size in sizes.items()}
    pair = {("gyro_1", "gyro_2"): 0.3}
    rates = simulated(st.NoiseModel(channels=channels, correlation={"random_walk": pair}), "board")
    moved = simulated(st.NoiseModel(channels=channels), "table")
    time = np.arange(len(rates)) / RATE
    moved += 0.2 * np.sin(0.7 * time)[:, None]
    for name, columns in (("board.csv", rates), ("table.csv", moved)):
        header = "t [s],g1 [deg/s],g2 [deg/s],g3 [deg/s],g4 [deg/s]"
        np.savetxt(folder / name, np.c_[time, columns], delimiter=",", header=header, comments="", fmt="%.8g")
    for number in (1, 2, 3):
        header = "t [s],gyro_x [deg/s]"
        columns = np.c_[time, rates[:, number - 1]]
        np.savetxt(folder / f"sensor{number}.csv", columns, delimiter=",", header=header, comments="", fmt="%.8g")
