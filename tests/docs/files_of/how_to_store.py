"""The files of docs/how-to/store.md: two months of each of 24 units, made in four months, each batch with 2 % more noise."""

from pathlib import Path

import numpy as np
from logs_of_pages import noise, timed

UNITS, MONTHS, RATE, DURATION = 24, 4, 10.0, 400.0

SPEC = """\
name = "HG1700"
maker = "us"
source = "here"

[gyro]
axes = ["x"]
random_walk = { typical = "0.1 deg/sqrt(h)", maximum = "0.16 deg/sqrt(h)" }
"""


def make(folder: Path) -> None:
    """The logs of the bench, named by unit and day, and a specification."""
    walk = np.radians(0.1) / 60  # 0.1 deg/√h
    factors = np.exp(0.02 * noise("units of a store", UNITS, 1)[:, 0])
    for unit in range(UNITS):
        month = unit % MONTHS
        for day in (1, 2):
            name = f"SN{101 + unit}_2026-{month + day:02}-{1 + unit:02}.csv"
            samples = walk * factors[unit] * 1.02**month * np.sqrt(RATE) * noise(name, int(DURATION * RATE), 1)
            timed(folder / "bench" / name, samples, {"gyro_x": "rad/s"}, rate=RATE)
    (folder / "spec.toml").write_text(SPEC)
