"""The files of README.md: the log of the demo, and logs that do not state everything."""

from pathlib import Path

from logs_of_pages import AXES, demo_log, noise, table, timed


def make(folder: Path) -> None:
    """The files that the page names."""
    demo_log(folder / "static.csv")
    samples = noise("log without units", 3000, 6) * 0.01
    table(folder / "log.csv", samples, ",".join(AXES))
    timed(folder / "imu.csv", samples, dict.fromkeys(AXES, "x"))
    rows = (folder / "imu.csv").read_text().partition("\n")[2]
    (folder / "imu.txt").write_text(rows.replace(",", " "))
