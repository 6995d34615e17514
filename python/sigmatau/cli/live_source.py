"""Source of the live samples of ``watch`` and ``app``: standard input, a growing file or a serial port."""

from __future__ import annotations

import sys
from pathlib import Path

from sigmatau.errors import DataError, OptionError


def live_source(source: str, *, serial: str | None, baud: int | None, save: Path | None) -> str:
    """Select the source: standard input, a file or a serial port. Raises `OptionError` for contradictory options."""
    if serial is None:
        if baud is not None:
            raise OptionError("{option} is the speed of a port: give --serial PORT too", option="baud")
        if save is not None and source != "-":
            raise OptionError(f"{{option}} is for a port or standard input; {source} is a log already", option="save")
        return source
    if source != "-":
        raise OptionError(f"{{option}} is read in place of a file; leave out {source}", option="serial")
    if baud is not None and baud < 1:
        raise OptionError(f"{{option}} {baud}: must be a positive number of bits per second", option="baud")
    return serial


def check_standard_input(remedy: str) -> None:
    """Raise an error if standard input is not a pipe."""
    if sys.stdin is None or sys.stdin.closed:
        raise DataError("standard input is closed")
    if sys.stdin.isatty():
        raise OptionError(f"no input is piped in: {remedy}", option="source")
