"""The files of docs/how-to/reading-back.md: YAML of Kalibr and imu_utils."""

from pathlib import Path

from vio import IMU_UTILS, KALIBR


def make(folder: Path) -> None:
    """The files that the page reads."""
    (folder / "old-imu.yaml").write_text(KALIBR)
    (folder / "imu-utils.yaml").write_text(IMU_UTILS)
