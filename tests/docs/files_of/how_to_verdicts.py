"""Files of docs/how-to/verdicts.md."""

from pathlib import Path

import numpy as np

from known import seed_of
from page_records import bench, write_table


def make(folder: Path) -> None:
    """Ten minutes on a bench, whole and cut off; with noise that changes, and with a wrong unit."""
    times, columns = bench()
    write_table(folder / "good.csv", times, columns)
    data = (folder / "good.csv").read_bytes()
    (folder / "cut.csv").write_bytes(data[: data.index(b",", len(data) // 2)])  # in the middle of a row
    rng = np.random.default_rng(seed_of("how-to: verdicts"))
    louder = 1.5 * columns["gyro_x"].std() * rng.standard_normal(len(times))
    write_table(folder / "changing.csv", times, columns | {"gyro_x": columns["gyro_x"] + (times > 300) * louder})
    degrees = {name: np.degrees(column) for name, column in columns.items() if name.startswith("gyro")}
    write_table(folder / "unit.csv", times, columns | degrees)
