"""Logs of docs/how-to/live.md: lines of an IMU without a header, and a table of a gyro."""

from pathlib import Path

from logs_of_pages import noise, table

from sigmatau import NoiseModel, simulate
from sigmatau.io.write import write

SUBSTITUTED = {
    "--serial /dev/ttyUSB0 --baud 115200": "- < port.txt",  # a file in place of the port
    "sigmatau app": "sigmatau app --help",  # it would wait for a page
}


def make(folder: Path) -> None:
    """Two minutes each."""
    lines = noise("lines of a port", 12_000, 6) * 0.01
    table(folder / "port.txt", lines, "")
    model = NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    write(simulate(model, duration=120, rate=100, rng=1), folder / "log.csv")
