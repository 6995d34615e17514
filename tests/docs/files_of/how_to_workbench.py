"""The files of docs/how-to/workbench.md."""

from pathlib import Path

from logs_of_pages import mems_log

SUBSTITUTED = {"sigmatau app logs": "sigmatau app logs --help"}  # it would wait for a page


def make(folder: Path) -> None:
    """A log of the MEMS unit."""
    (folder / "logs").mkdir()
    mems_log(folder / "logs" / "static.csv", duration=120.0)
