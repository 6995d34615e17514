"""The files of docs/report.md."""

from pathlib import Path

from logs_of_pages import mems_log


def make(folder: Path) -> None:
    """A log."""
    mems_log(folder / "static.csv")
