"""The file of docs/index.md: the log of the demo."""

from pathlib import Path

from logs_of_pages import demo_log


def make(folder: Path) -> None:
    demo_log(folder / "static.csv")
