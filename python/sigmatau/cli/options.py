"""What several commands share: options of the form KEY=VALUE, progress, checks of output files."""

from __future__ import annotations

import contextlib
import math
import re
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import get_args

from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.allan import TauGrid
from sigmatau.findings.finding import Finding

__all__ = [
    "averaging_times",
    "bandwidths",
    "check_folder",
    "check_output",
    "finding_lines",
    "key_numbers",
    "key_values",
    "reading",
    "refuse_same",
    "say",
    "working",
]


_EVERY = 0.2  # s
_SMALL = 1 << 24  # bytes: read before anybody looks


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


def check_folder(path: Path | None, option: str) -> None:
    """Make the folder that several results go into, or refuse what is none."""
    if path is None:
        return
    if str(path) == "-" or path.suffix.lower() in (".json", ".png", ".svg", ".pdf") or path.is_file():
        raise OptionError(f"--{option} {path}: there are several logs, so this must be a folder", option=option)
    try:
        path.mkdir(exist_ok=True)
    except OSError as error:
        raise DataError(f"{path}: cannot be made: {error.strerror or error}") from None


def refuse_same(log: Path, /, **outputs: Path | None) -> None:
    """No output may take the place of the log or of another output; by option."""
    seen: dict[Path, str] = {}
    for option, path in outputs.items():
        if path is None:
            continue
        if path.exists() and log.exists() and path.samefile(log):
            raise OptionError(f"--{option} {path} is the file that is read; name another file", option=option)
        if seen.setdefault(path, option) != option:
            raise OptionError(f"--{seen[path]} and --{option} both name {path}; name two files", option=option)


def averaging_times(text: str) -> str | list[float]:
    """The option ``--taus``: the name of a grid, or times in seconds."""
    grids = get_args(TauGrid)
    if text in grids:
        return text
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise OptionError(
            f"--taus {text!r}: want {', '.join(grids)}, or times in s such as 0.1,1,10", option="taus"
        ) from None


_BANDWIDTH = re.compile(r"([0-9.eE+-]+) *(?:Hz)?(?: */ *([1-8]))?")


def bandwidths(values: Sequence[str]) -> dict[str, tuple[float, int | None]]:
    """The option ``--bandwidth``: ``["gyro=30Hz/2"]`` as ``{"gyro": (30.0, 2)}``."""
    found: dict[str, tuple[float, int | None]] = {}
    for name, text in key_values(values, "bandwidth", "gyro=30Hz").items():
        match = _BANDWIDTH.fullmatch(text)
        try:
            hertz = float(match[1]) if match else math.nan
        except ValueError:
            hertz = math.nan
        if match is None or not (0 < hertz < 1e6):
            raise OptionError(
                f"--bandwidth {name}={text}: want hertz, and the order of the filter if it is known, e.g. gyro=30Hz or"
                " gyro=30Hz/2",
                option="bandwidth",
            )
        found[name] = (hertz, int(match[2]) if match[2] else None)
    return found


def finding_lines(findings: Sequence[Finding]) -> list[str]:
    """Findings for a terminal, those of one kind together, with what to do said once for all for whom it is the same."""
    lines = []
    kinds: dict[tuple[str, str], list[Finding]] = {}
    for finding in findings:
        kinds.setdefault((finding.severity, finding.code), []).append(finding)
    for alike in kinds.values():
        lines += [str(replace(finding, remedy="")) for finding in alike]
        remedies = list(dict.fromkeys(finding.remedy for finding in alike if finding.remedy))
        lines += [f"  -> {remedy}" for remedy in remedies]
    return lines


def say(message: str, *, quiet: bool = False) -> None:
    """A message for the person at the terminal."""
    if not quiet:
        sys.stderr.write(message + "\n")


@contextlib.contextmanager
def reading(log: Path, *, quiet: bool = False) -> Iterator[None]:
    """Show that a log is read, with a bar where its bytes are counted; anew each time they are gone through."""
    from sigmatau._native.formats import bytes_read

    try:
        size = log.stat().st_size
    except OSError:  # which the reader says better
        size = 0
    begun, over = bytes_read(), threading.Event()

    with working(f"reading {log}", quiet=quiet) as done:

        def follow() -> None:
            while not over.wait(_EVERY):
                taken = bytes_read() - begun
                if taken:
                    done((taken - 1) % size / size)

        if size > _SMALL and not quiet and sys.stderr.isatty():
            threading.Thread(target=follow, daemon=True).start()
        try:
            yield
        finally:
            over.set()


@contextlib.contextmanager
def working(what: str, *, quiet: bool = False) -> Iterator[Callable[[float], None]]:
    """Show on a terminal that something is going on, and for how long.

    What it yields takes the part that is done, 0 to 1, where that is known: then there is a bar.
    """
    if quiet or not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    with Progress(
        SpinnerColumn(),
        TextColumn("{task.description}"),
        TimeElapsedColumn(),
        console=Console(stderr=True),
        transient=True,
    ) as progress:
        task = progress.add_task(what, total=None)

        def done(part: float) -> None:
            if progress.tasks[0].total is None:
                progress.columns = (*progress.columns, BarColumn())
            progress.update(task, total=1.0, completed=part)

        yield done
