"""Files of docs/how-to/moving.md."""

from pathlib import Path

import numpy as np

from known import seed_of
from page_records import bench, write_table

_SIZES = {"gyro_x": 0.2, "gyro_y": 0.3, "accel_z": 0.5}  # sizes of the motion of a drive [SI]


def make(folder: Path) -> None:
    """A sensor that is picked up for 10 s, one in a vehicle that drives and then stops, and one that never rests."""
    times, columns = bench()
    up = (times > 200) & (times < 210)
    handled = {name: column.copy() for name, column in columns.items()}
    handled["gyro_x"][up] += 0.8 * np.sin(2 * np.pi * (times[up] - 200) / 5)
    handled["accel_z"][up] += 1.5 * np.sin(2 * np.pi * (times[up] - 200) / 3)
    write_table(folder / "handled.csv", times, handled)
    for name, end in (("drive", 500), ("flight", 600)):
        rng = np.random.default_rng(seed_of(f"how-to: moving, {name}"))
        moved = {
            channel: column + (times < end) * _SIZES[channel] * _motion(rng) for channel, column in columns.items()
        }
        write_table(folder / f"{name}.csv", times, moved)


def _motion(rng: np.random.Generator) -> np.ndarray:
    """Motion within seconds, of the size 1."""
    return np.convolve(rng.standard_normal(30_200), np.hanning(200) / 10, "same")[:30_000]
