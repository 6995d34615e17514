"""Files of docs/questions/bias-instability-or-random-walk.md."""

from pathlib import Path

from page_records import index_model, some, write_log


def make(folder: Path) -> None:
    """Two hours of a sensor of the model of the how-to pages."""
    model = some(index_model(folder / "imu.toml"), "gyro_x", "gyro_y", "gyro_z", "accel_z")
    write_log(folder / "static.csv", "questions: bias instability or random walk", model, seconds=7200, rate=10)
