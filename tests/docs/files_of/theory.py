"""The files of the pages of docs/theory: the model of docs/how-to/README.md."""

from pathlib import Path

from logs_of_pages import index_model


def make(folder: Path) -> None:
    """imu.toml."""
    index_model(folder)
