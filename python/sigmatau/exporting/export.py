"""`export`: write a noise model as the file that a filter or a simulator reads."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from sigmatau.exporting.choices import Axes, Choices
from sigmatau.exporting.prepare import Prepared, check_all, check_choices, check_path, prepare, prepare_all
from sigmatau.exporting.source import Source, read_source
from sigmatau.exporting.target import Target
from sigmatau.exporting.targets import NAMES, target
from sigmatau.exporting.values import Number, Numbers
from sigmatau.model.noise_model import NoiseModel

if TYPE_CHECKING:
    from typing import Protocol

    class HasSource(Protocol):
        """An `Analysis`, which this package cannot import."""

        def to_source(self) -> Source: ...


__all__ = [
    "NAMES",
    "Axes",
    "Choices",
    "Number",
    "Numbers",
    "Prepared",
    "Source",
    "Target",
    "check_all",
    "check_choices",
    "check_path",
    "export",
    "prepare",
    "prepare_all",
    "read_source",
    "target",
]


def export(
    model: NoiseModel | Source | HasSource, *, to: str, path: str | Path | None = None, choices: Choices | None = None
) -> str | bytes:
    """Write the parameters of a noise model for another program.

    Parameters
    ----------
    model : NoiseModel, Analysis or Source
        `read_source` reads a source from a file.
    to : str
        The target, one of `NAMES`, in any case.
    path : str or Path, optional
        File to write, atomically. Its extension selects the form if the target has several.
    choices : Choices, optional
        Options of the export.

    Returns
    -------
    str or bytes
        The content of the file, with unit and origin of each number in comments. `prepare` returns findings about it
        too.

    Raises
    ------
    OptionError
        For an unknown target, or a missing choice, such as the value of a rate random walk that was not observed.
    DataError
        If the model lacks data that the target needs, or the file cannot be written.
    """
    prepared = prepare(model, to=to, path=path, choices=choices)
    if prepared.path is not None:
        prepared.write()
    return prepared.content
