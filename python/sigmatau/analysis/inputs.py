"""Read the input of an export: a model file, a file of another program, or the JSON of an analysis."""

from __future__ import annotations

from pathlib import Path

from sigmatau.analysis.reading import read_analysis
from sigmatau.analysis.result import Analysis
from sigmatau.errors import DataError
from sigmatau.exporting.choices import not_of_a_log
from sigmatau.exporting.source import Source, read_file
from sigmatau.model.noise_model import NoiseModel


def is_result(path: Path) -> bool:
    """Whether the name of a file ends in ``.json``, like the result of an analysis."""
    return path.suffix.lower() == ".json"


def read_model(path: Path) -> NoiseModel:
    """Read the model from a model file or from the JSON of an analysis. Raises `DataError`."""
    return require_model(read_analysis(path), path) if is_result(path) else NoiseModel.read(path)


def require_model(analysis: Analysis, path: Path) -> NoiseModel:
    """Return the model of an analysis that was read from a file. Raises a `DataError` that names the file."""
    try:
        return analysis.model
    except DataError as error:
        raise error.about(str(path)) from None


def read_source(path: str | Path, *, rate: float | None = None) -> Source:
    """Read a model file (.toml), a result of ``sigmatau analyze`` (.json), or a YAML file of Kalibr or imu_utils.

    `rate`: sampling rate of the record [Hz]. Only the YAML files need it, because they do not state it. Raises `OptionError`
    if it is given for a file of another kind, and `DataError` if the file cannot be read.
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
