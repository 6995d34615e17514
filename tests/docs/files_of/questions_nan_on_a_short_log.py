"""Files of docs/questions/nan-on-a-short-log.md."""

from pathlib import Path

from page_records import index_model, some, write_log


def make(folder: Path) -> None:
    """A log of 2.4 s, and its first 19 rows."""
    model = some(index_model(folder / "imu.toml"), "gyro_x", "gyro_y", "gyro_z", "accel_z")
    write_log(folder / "short.csv", "questions: nan on a short log", model, seconds=2.4, rate=350)
    lines = (folder / "short.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    (folder / "tiny.csv").write_text("".join(lines[:20]), encoding="utf-8")
