"""The files of docs/how-to/datasheets.md: a log, and results of units that meet the specification of the page or do not."""

from pathlib import Path

from logs_of_pages import copied, mems_log

from lot_logs import results_of_units

# 0.9 of the typical values of the ICM-42688-P, if these are one-sided
GOOD = {"gyro": {"random_walk": 3.1e-5}, "accel": {"random_walk": 4.4e-4}}


def make(folder: Path) -> None:
    """The files that the page names."""
    mems_log(folder / "static.csv", unit=GOOD)
    for name, content in results_of_units().items():
        (folder / f"{name}.json").write_text(content, encoding="utf-8")
    for name in ("good", "bad"):
        copied(folder / f"{name}.json", folder / "results" / f"{name}.json")
