"""Files of docs/questions/memory-and-time.md."""

from pathlib import Path

from page_records import index_model, some, write_log


def make(folder: Path) -> None:
    """Two hours of one axis, in a file that is read from the disk."""
    model = some(index_model(folder / "imu.toml"), "gyro_x")
    write_log(folder / "static.npy", "questions: memory and time", model, seconds=7200, rate=10)
