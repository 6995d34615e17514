"""Files of docs/how-to/voltage-reference.md."""

from pathlib import Path

from other_sensors import write_log


def make(folder: Path) -> None:
    """A reference of 10 V, read once a second for a day; it drifts by 20 µV a day."""
    noise = {"random_walk": 1.5e-6, "bias_instability": 1.2e-7, "rate_ramp": 20e-6 / 86400}
    write_log(folder / "reference.csv", {"voltage": (noise, 9.9999871)}, unit="V", seconds=86400, rate=1)
