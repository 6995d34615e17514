"""Files of docs/questions/falling-tail.md."""

from pathlib import Path

from page_records import model_of, write_log

NOISE = {"random_walk": "0.3 deg/sqrt(h)", "gauss_markov": [{"sigma": "20 deg/h", "time": "60 s"}]}


def make(folder: Path) -> None:
    """A bias with a correlation time of a minute: the curve rises, and then falls."""
    write_log(folder / "static.csv", "falling tail", model_of(gyro_x=NOISE), seconds=7200, rate=10)
