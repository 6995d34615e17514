"""What several commands share: options of the form KEY=VALUE, progress, checks of output files."""

from __future__ import annotations

import contextlib
import math
import sys
from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path

from sigmatau.errors import DataError, OptionError

__all__ = ["check_output", "key_numbers", "key_values", "say", "working"]


def key_values(values: Sequence[str], option: str, example: str) -> dict[str, str]:
    """``["gyro=deg/s", "accel=g,time=s"]`` as a dictionary."""
    result: dict[str, str] = {}
    for text in values:
        for part in text.split(","):
            key, equals, value = part.partition("=")
            key, value = key.strip(), value.strip()
            if not (key and equals and value):
                raise OptionError(f"--{option} {text!r}: want NAME=VALUE, e.g. --{option} {example}", option=option)
            if result.setdefault(key, value) != value:
                raise OptionError(f"--{option}: {key!r} is given twice, {result[key]!r} and {value!r}", option=option)
    return result


def key_numbers(values: Sequence[str], option: str, example: str) -> dict[str, float]:
    """``["gyro=0.01", "accel=1/16384"]`` as a dictionary of finite numbers."""
    result = {}
    for key, value in key_values(values, option, example).items():
        try:
            number = float(Fraction(value)) if "/" in value else float(value)
        except (ValueError, ZeroDivisionError, OverflowError):
            number = math.nan
        if not math.isfinite(number):
            raise OptionError(f"--{option} {key}={value}: {value!r} is no number, e.g. {example}", option=option)
        result[key] = number
    return result


def check_output(path: Path | None, endings: Sequence[str], option: str) -> None:
    """Refuse an output that could not be written, before hours are spent on computing it."""
    if path is None:
        return
    if endings and not path.name.endswith(tuple(endings)):
        raise OptionError(f"--{option} {path}: the name must end in {', '.join(endings)}", option=option)
    if path.is_dir():
        raise DataError(f"{path}: is a directory; give the name of a file")
    if path.exists() and not path.is_file():
        raise DataError(f"{path}: is no regular file, and would be replaced; give the name of a file")
    if not path.parent.is_dir():
        raise DataError(f"{path}: there is no directory {path.parent}")


def say(message: str, *, quiet: bool = False) -> None:
    """A message for the person at the terminal."""
    if not quiet:
        sys.stderr.write(message + "\n")


@contextlib.contextmanager
def working(what: str, *, quiet: bool = False) -> Iterator[None]:
    """Show on a terminal that something is going on, and for how long."""
    if quiet or not sys.stderr.isatty():
        yield
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        progress.add_task(what, total=None)
        yield
