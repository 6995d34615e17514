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
        Where it is.
    name : str
        What the user calls it: the path, or the name of an uploaded file.
    """

    path: str
    name: str

    def key(self) -> tuple[object, ...]:
        """Size and time of the file, which show whether it is still the same."""
        status = Path(self.path).stat()
        return self.path, self.name, status.st_mtime_ns, status.st_size, status.st_ino


@dataclass(frozen=True, kw_only=True)
class LiveSource:
    """What is recorded while the page is open.

    Attributes
    ----------
    source : str
        The name of a serial port, of a file that grows, or ``-`` for standard input.
    baud : int or None
        Speed of the port; None for another source. [bit/s]
    save : str or None
        The new file to which the samples are written.
    table : dict
        Options of reading as they were typed.
    at_rest : bool
        Whether all samples count as at rest.
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
        """The log that has all samples: the saved one, or the file that is followed; None if nothing is kept."""
        return self.save if self.save is not None or self.source == "-" or self.baud is not None else self.source
