"""The files of docs/how-to/fleet.md: logs of three units, of which one is damaged."""

from pathlib import Path

from logs_of_pages import AXES, noise, table

SUBSTITUTED = {
    "s3://lab/night-2026-05-01/": "night/",
    "s3://lab/night/": "night/",
    "postgresql://lab@db/results": "lab.db",
    " --scheduler tcp://10.0.0.5:8786": " --rate 100",
    " --scheduler tcp://FIRST-HOST:8786": "",
    " --scheduler tcp://127.0.0.1:8786": " --rate 100",
}


def make(folder: Path) -> None:
    """The logs."""
    for unit in ("A1", "A2", "A3"):
        for day in range(1, 5):
            name = f"{unit}/day{day}.csv"
            table(folder / "logs" / name, noise(name, 1000, 6), ",".join(AXES))
        table(
            folder / "night" / f"{unit}.csv",
            noise(f"night {unit}", 1000, 3),
            "gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]",
        )
    (folder / "logs/A3/day4.csv").write_text("gyro_x,gyro_y\n")
