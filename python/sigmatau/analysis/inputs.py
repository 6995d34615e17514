"""Models and sources of exports from files: a model file, another program's file, or the JSON of an analysis."""

from __future__ import annotations

from pathlib import Path

from sigmatau.analysis.reading import read_analysis
from sigmatau.analysis.result import Analysis
from sigmatau.errors import DataError
from sigmatau.exporting.choices import not_of_a_log
from sigmatau.exporting.source import Source, read_file
from sigmatau.model.noise_model import NoiseModel


def is_result(path: Path) -> bool:
    """Whether a file is taken for the JSON of an analysis, by its name."""
    return path.suffix.lower() == ".json"


def read_model(path: Path) -> NoiseModel:
    """The model of a model file, or of the JSON of an analysis; raises `DataError`."""
    return require_model(read_analysis(path), path) if is_result(path) else NoiseModel.read(path)


def require_model(analysis: Analysis, path: Path) -> NoiseModel:
    """The model of an analysis that was read from a file; raises `DataError`, which names the file."""
    try:
        return analysis.model
    except DataError as error:
        raise error.about(str(path)) from None


def read_source(path: str | Path, *, rate: float | None = None) -> Source:
    """Read a model file (.toml), a result of ``sigmatau analyze`` (.json), or a YAML file of Kalibr or imu_utils.

    `rate`: sampling rate of the record, for a YAML file, which does not state it [Hz]. Raises `OptionError` for a rate of
    another file, and `DataError` for a file that cannot be read.
    """
    path = Path(path)
    if not is_result(path):
        return read_file(path, rate=rate)
    if rate is not None:
        raise not_of_a_log(rate).about(str(path))
    analysis = read_analysis(path)
    try:
        return analysis.to_source()
    except DataError as error:
        raise error.about(str(path)) from None
