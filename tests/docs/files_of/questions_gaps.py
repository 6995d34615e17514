"""Files of docs/questions/gaps.md."""

from pathlib import Path

from page_records import index_model, lossy, some


def make(folder: Path) -> None:
    """An hour with 5 % of the rows lost, and 90 s in one piece."""
    lossy(folder / "gaps.csv", "how-to: gaps", some(index_model(folder / "imu.toml"), "gyro_x"), seconds=3600, rate=50)
