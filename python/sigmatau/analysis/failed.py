"""`FailedAnalysis`: the reason why a log has no result."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import Any, Self

from sigmatau._version import SCHEMA, __version__
from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.hints import as_options


@frozen
class FailedAnalysis:
    """Why a log has no result.

    Attributes
    ----------
    path : str
        The log.
    message : str
        The error, without the name of the log.
    exit_code : int
    notes : mapping of str to str
        Information about the record from the user.
    version : str
        Version of sigmatau.
    options : mapping
        Options of the run, as in a result.
    """

    path: str
    message: str
    exit_code: int
    notes: Mapping[str, str] = field(default_factory=dict)
    version: str = __version__
    options: Mapping[str, Any] | None = None

    @property
    def reason(self) -> str:
        """Message for a list of many failures, of about two lines at most."""
        return self.message[:500] or "the analysis failed"

    @classmethod
    def of(
        cls,
        error: Exception,
        log: str,
        *,
        notes: Mapping[str, str] | None = None,
        options: Mapping[str, Any] | None = None,
    ) -> Self:
        """Build the failure from an error about a log, with the options as typed on the command line.

        Parameters
        ----------
        error : Exception
            Error that prevented a result.
        log : str
            Name of the log in the error.
        notes, options : mapping, optional
            See the attributes.

        Returns
        -------
        FailedAnalysis
        """
        message = error.without(log, as_options) if isinstance(error, OptionError | DataError) else str(error)
        code = 2 if isinstance(error, OptionError) else 1
        return cls(path=log, message=message, exit_code=code, notes=notes or {}, options=options)

    def error(self) -> DataError:
        """Build an error with the reason of the failure."""
        return DataError(": ".join(filter(None, ["the analysis failed", self.path, self.reason])))

    def to_dict(self) -> dict[str, Any]:
        """The JSON form: the error, and no channels."""
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
