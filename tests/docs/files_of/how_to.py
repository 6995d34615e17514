"""The files of the pages of targets: a log, its result, and the model of the index."""

from pathlib import Path

from logs_of_pages import analysed, index_model, mems_log


def make(folder: Path) -> None:
    """A minute of a MEMS unit, and imu.toml."""
    mems_log(folder / "static.csv")
    analysed(folder / "static.csv", folder / "result.json")
    index_model(folder)
