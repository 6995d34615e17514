"""Writing: whole files or none, and records as tables."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from sigmatau import _formats
from sigmatau.errors import DataError, OptionError
from sigmatau.record import Record

__all__ = ["RECORD_ENDINGS", "atomic", "write_record"]

RECORD_ENDINGS = (".csv", ".csv.gz", ".npz")
"""Endings of a record's file name, each with its format."""


@contextlib.contextmanager
def atomic(path: str | Path) -> Iterator[Path]:
    """A path beside `path` to write to, which takes its name when the block ends well and vanishes when it does not.

    Raises
    ------
    DataError
        If the file cannot be written there; the message says why.
    """
    target = Path(path)
    if target.is_dir():
        raise DataError(f"{target}: is a directory; give the name of a file")
    if target.exists() and not target.is_file():
        raise DataError(f"{target}: is no regular file, and would be replaced; give the name of a file")
    if not target.parent.is_dir():
        raise DataError(f"{target}: there is no directory {target.parent}")
    # The ending stays, because writers choose a format by it.
    ending = "".join(target.suffixes[-2:])
    try:
        handle, name = tempfile.mkstemp(prefix=f".{target.name}.", suffix=ending, dir=target.parent)
        os.close(handle)
    except OSError as error:
        raise DataError(f"{target}: cannot be written: {error.strerror or error}") from None
    temporary = Path(name)
    try:
        yield temporary
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)
        temporary.replace(target)
    except OSError as error:
        raise DataError(f"{target}: cannot be written: {error.strerror or error}") from None
    finally:
        temporary.unlink(missing_ok=True)


def write_record(record: Record, path: str | Path) -> None:
    """Write a record as a table: time and every channel, rates in SI, units in the header.

    Parameters
    ----------
    record : Record
        All streams on one grid.
    path : str or Path
        ``.csv``, ``.csv.gz`` (shortest digits that read back to the same bits) or ``.npz`` (one array a channel, named
        with its unit).

    Raises
    ------
    OptionError
        For another ending.
    DataError
        If the streams have different grids, or the file cannot be written.
    """
    target = Path(path)
    ending = next((e for e in sorted(RECORD_ENDINGS, key=len, reverse=True) if target.name.endswith(e)), None)
    if ending is None:
        raise OptionError(f"{target}: a record is written as {', '.join(RECORD_ENDINGS)}", option="output")
    grid = record.streams[0].grid
    if any(s.grid.n != grid.n or s.grid.tau0 != grid.tau0 for s in record.streams):
        raise DataError("streams with different grids do not fit in one table; write them one by one")
    # k/rate prints short (0.07) where k·tau0 does not (0.07000000000000001).
    columns = {"time [s]": grid.start + np.arange(grid.n) / grid.rate}
    for stream in record.streams:
        for channel in stream.channels:
            columns[f"{channel} [{stream.unit}]"] = stream.column(channel)
    with atomic(target) as temporary:
        if ending == ".npz":
            np.savez(temporary, allow_pickle=False, **columns)
        else:
            _formats.write_text(
                str(temporary), ",".join(columns), ",", list(columns.values()), gzip=ending == ".csv.gz"
            )
