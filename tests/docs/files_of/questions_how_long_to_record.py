"""Files of docs/questions/how-long-to-record.md."""

from pathlib import Path

from page_records import index_model


def make(folder: Path) -> None:
    """The model of the how-to pages."""
    index_model(folder / "imu.toml")
