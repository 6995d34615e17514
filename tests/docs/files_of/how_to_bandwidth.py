"""Files of docs/how-to/bandwidth.md."""

from pathlib import Path

import numpy as np
from logs_of_pages import filtered

from sigmatau.io.write import write


def make(folder: Path) -> None:
    """Logs of one sensor at several rates, and of another one."""
    for rate in (20.0, 50.0, 500.0):
        write(filtered(f"how-to: {rate:g} Hz", rate, ["gyro_x"], samples=30_000), folder / f"{rate:g}Hz.csv")
    foreign = filtered("how-to: foreign", 200.0, ["gyro_x"], samples=30_000)
    stream = foreign.streams[0]
    columns = np.column_stack([np.arange(stream.grid.n) / 200.0, 1.3 * stream.column("gyro_x")])
    np.savetxt(folder / "foreign.csv", columns, delimiter=",", header="time [s],gyro_x [rad/s]", comments="")
    for name, rate in (("slow.txt", 50.0), ("fast.txt", 500.0)):
        record = filtered(f"how-to: {name}", rate, ["gyro_x"], samples=30_000)
        np.savetxt(folder / name, np.degrees(record.streams[0].column("gyro_x")))
