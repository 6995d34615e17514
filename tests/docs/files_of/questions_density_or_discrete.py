"""Files of docs/questions/density-or-discrete.md."""

from pathlib import Path

from page_records import index_model


def make(folder: Path) -> None:
    """The model of the how-to pages."""
    index_model(folder / "imu.toml")
