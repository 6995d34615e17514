"""The files of docs/how-to/repeatability.md: three days of a unit, and Table I of the paper."""

from pathlib import Path

from logs_of_pages import analysed, copied, noise, timed

from paper_tables import csv_of


def make(folder: Path) -> None:
    """The files that the page names."""
    for day in range(1, 4):
        log = folder / f"day{day}.csv"
        timed(log, 0.01 * noise(f"repeatability {log.name}", 3000, 2), {"gyro_x": "deg/s", "accel_x": "g"})
        analysed(log, log.with_suffix(".json"), "--note", "serial number=A123", "--note", f"run=day {day}")
        copied(log.with_suffix(".json"), folder / "results" / f"day{day}.json")
    (folder / "table1.csv").write_text(csv_of("I"))
