"""Files of docs/how-to/barometer.md."""

from pathlib import Path

from other_sensors import write_log


def make(folder: Path) -> None:
    """A barometer in hectopascals; the weather is a rate random walk of its pressure."""
    noise = {"random_walk": 6e-3, "rate_random_walk": 2.5e-4}
    write_log(folder / "baro.csv", {"pressure": (noise, 1013.2)}, unit="hPa", seconds=7200, rate=10)
