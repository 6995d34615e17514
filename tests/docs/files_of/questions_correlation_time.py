"""Files of docs/questions/correlation-time.md."""

from pathlib import Path

from page_records import model_of, write_log

CASE = "questions: correlation time"


def process(time: str) -> dict[str, object]:
    """A gyro with a bias of 20 deg/h and the given correlation time."""
    return {"random_walk": "0.3 deg/sqrt(h)", "gauss_markov": [{"sigma": "20 deg/h", "time": time}]}


def make(folder: Path) -> None:
    """Two hours with a correlation time of a minute, and two hours with one of two hours."""
    accel = {"random_walk": "120 ug/sqrt(Hz)", "bias_instability": "40 ug"}
    write_log(folder / "hump.csv", CASE, model_of(gyro_x=process("60 s"), accel_x=accel), seconds=7200, rate=10)
    write_log(folder / "slow.csv", CASE, model_of(gyro_y=process("2 h")), seconds=7200, rate=10)
