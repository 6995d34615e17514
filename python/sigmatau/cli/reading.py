"""Reading of logs with the options of the command line, with progress."""

from __future__ import annotations

import contextlib
import sys
import threading
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

from sigmatau.cli.declared import DeclaredOptions, typed_options
from sigmatau.cli.options import working
from sigmatau.cli.rates import assign_rates
from sigmatau.io.read import read
from sigmatau.io.read.options import ReadOptions
from sigmatau.record.record import Record

_PROGRESS_INTERVAL = 0.2  # [s]
# size of a log above which progress is shown; smaller logs are read within a second [bytes]
_MIN_PROGRESS = 1 << 24


@typed_options(ReadOptions)
class ReadingOptions(DeclaredOptions):
    """Options of reading."""

    rate: list[str] | None

    def at_rate(self, rate: list[str] | None) -> ReadingOptions:
        """Replace the rate by that of one log."""
        return cast("ReadingOptions", replace(cast("Any", self), rate=rate))


def assign_readings(
    reading: ReadingOptions | None, logs: Sequence[Path], places: Sequence[Path]
) -> dict[Path, ReadingOptions]:
    """Build the reading options of each log. Raises `OptionError` for a wrong option. `places`: see `assign_rates`."""
    reading = reading or ReadingOptions()
    rates = assign_rates(reading.rate or [], logs, places)
    readings = {log: reading.at_rate(rates[log] or None) for log in logs}
    for options in readings.values():
        options.arguments()  # checked once, so that a wrong option is one error
    return readings


def read_log(log: Path, how: ReadingOptions | None, *, quiet: bool) -> Record:
    """Read the record, with progress on the terminal."""
    options = (how or ReadingOptions()).arguments()
    with reading_shown(log, quiet=quiet):
        return read(log, **options)


@contextlib.contextmanager
def reading_shown(log: Path, *, quiet: bool = False) -> Iterator[None]:
    """Show the progress of reading a log, with a bar if its bytes are counted. It starts again for each pass."""
    from sigmatau._native.formats import bytes_read

    try:
        size = log.stat().st_size
    except OSError:  # the reader reports the error
        size = 0
    begun, over = bytes_read(), threading.Event()

    with working(f"reading {log}", quiet=quiet) as done:

        def follow() -> None:
            while not over.wait(_PROGRESS_INTERVAL):
                taken = bytes_read() - begun
                if taken:
                    done((taken - 1) % size / size)

        if size > _MIN_PROGRESS and not quiet and sys.stderr.isatty():
            threading.Thread(target=follow, daemon=True).start()
        try:
            yield
        finally:
            over.set()
