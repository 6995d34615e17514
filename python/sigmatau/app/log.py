"""A log that the page names, and the source of live samples."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True, kw_only=True)
class LogFile:
    """A log that the page names.

    Attributes
    ----------
    path : str
        Path of the file, which is temporary if it was uploaded.
    name : str
        Name for the user: the path, or the name of the uploaded file.
    """

    path: str
    name: str

    def key(self) -> tuple[object, ...]:
        """Path, name, size and time of the file, which differ if it has changed."""
        status = Path(self.path).stat()
        return self.path, self.name, status.st_mtime_ns, status.st_size, status.st_ino


@dataclass(frozen=True, kw_only=True)
class LiveSource:
    """Source of live samples.

    Attributes
    ----------
    source : str
        Name of a serial port, path of a file to which another program writes, or ``-`` for standard input.
    baud : int or None
        Speed of the port; None for other sources. [bit/s]
    save : str or None
        New file to which the samples are written; None if they are not saved.
    table : dict
        Reading options as typed.
    at_rest : bool
        Whether all samples are taken as at rest.
    command : str
        The command that does the same in a terminal.
    """

    source: str
    baud: int | None
    save: str | None
    table: Mapping[str, Any]
    at_rest: bool
    command: str

    @property
    def log(self) -> str | None:
        """File with all samples: the saved file, or the followed one; None if the samples are not saved."""
        return self.save if self.save is not None or self.source == "-" or self.baud is not None else self.source
