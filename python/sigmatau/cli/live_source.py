"""Source of the live samples of ``watch`` and ``app``: standard input, a growing file or a serial port."""

from __future__ import annotations

import sys
from pathlib import Path

from sigmatau.errors import DataError, OptionError
from sigmatau.io.read.options import Options, ReadOptions


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


def check_live_options(options: ReadOptions, *, command: str) -> Options:
    """Check the options for reading live lines. Raises `OptionError` for options of saved logs."""
    checked = options.checked()
    if options.input == "accumulated":
        raise OptionError(
            f"{command} reads rates or increments; accumulated values are for a saved log", option="input"
        )
    if options.interleaved not in (None, 1):
        raise OptionError(
            f"{command} follows one sensor: {{option}} {options.interleaved} is for a saved log, sigmatau analyze FILE",
            option="interleaved",
        )
    return checked
