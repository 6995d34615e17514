"""Files of docs/questions/inflation.md."""

from pathlib import Path

from page_records import model_of, write_log

REST = {
    "gyro_x": {"random_walk": "0.3 deg/sqrt(h)", "bias_instability": "6 deg/h"},
    "accel_z": {"random_walk": "120 ug/sqrt(Hz)", "bias_instability": "40 ug"},
}
RUNNING = {
    "gyro_x": {
        "random_walk": "0.9 deg/sqrt(h)",
        "bias_instability": "6 deg/h",
        "sinusoid": [{"amplitude": "0.05 deg/s", "frequency": "13 Hz"}],
    },
    "accel_z": {
        "random_walk": "1200 ug/sqrt(Hz)",
        "bias_instability": "60 ug",
        "sinusoid": [{"amplitude": "0.3 m/s^2", "frequency": "13 Hz"}],
    },
}


def make(folder: Path) -> None:
    """Twenty minutes at rest, and twenty with motors: more white noise, and a line."""
    for name, noise in (("rest", REST), ("running", RUNNING)):
        path = folder / f"{name}.csv"
        write_log(path, f"questions: inflation, {name}", model_of(**noise), seconds=1200, rate=50)
