"""A log that the page names."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


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
