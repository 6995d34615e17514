"""`FailedAnalysis`: why a log has no result."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import Any

from sigmatau._version import __version__
from sigmatau.errors import DataError
from sigmatau.frozen import frozen


@frozen
class FailedAnalysis:
    """Why a log has no result.

    Attributes
    ----------
    path : str
        The log.
    message : str
    exit_code : int
    notes : mapping of str to str
        Information about the record from the user.
    version : str
        Version of sigmatau.
    options : mapping
        Options of the run, as results have them.
    """

    path: str
    message: str
    exit_code: int
    notes: Mapping[str, str] = field(default_factory=dict)
    version: str = __version__
    options: Mapping[str, Any] | None = None

    @property
    def reason(self) -> str:
        """The message for a list of many: not longer than two lines or so."""
        return self.message[:500] or "the analysis failed"

    def error(self) -> DataError:
        """The failure as an error."""
        return DataError(f"the analysis failed: {self.reason}")

    def to_dict(self) -> dict[str, Any]:
        """The JSON form: the error, and no channels."""
        from sigmatau.analysis.json import SCHEMA

        return {
            "schema": SCHEMA,
            "sigmatau": self.version,
            "source": {"path": self.path},
            **({"notes": dict(self.notes)} if self.notes else {}),
            "error": {"message": self.message, "exit_code": self.exit_code},
            "findings": [],
            "channels": {},
            **({} if self.options is None else {"options": dict(self.options)}),
        }
