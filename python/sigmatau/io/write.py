"""Writing: whole files or none, and records as tables."""

from __future__ import annotations

import contextlib
import glob
import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from sigmatau.errors import DataError, OptionError
from sigmatau.io.writers import PARTS, WRITERS, Put, headers_of
from sigmatau.record.record import Record
from sigmatau.record.streams import CHUNK

RECORD_ENDINGS = tuple(WRITERS)  # Endings of a record's file name, each with its format


@contextlib.contextmanager
def atomic(path: str | Path) -> Iterator[Path]:
    """A path beside `path` to write to, which takes its name when the block ends well and vanishes when it does not.

    The file is locked while it is written: what a killed process left behind is not, and is removed by the next one that
    writes the same file. A symbolic link stays, and the file that it names is written.
    """
    try:
        target = Path(os.path.realpath(path))
        temporary, handle = _beside(target)
    except OSError as error:
        raise DataError(f"{path}: cannot be written: {error.strerror or error}") from None
    except (TypeError, ValueError) as error:
        if isinstance(error, DataError):
            raise
        raise DataError(f"{path!r}: no name of a file: {error}") from None
    try:
        yield temporary
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)
        temporary.replace(target)
    except OSError as error:
        raise DataError(f"{target}: cannot be written: {error.strerror or error}") from None
    finally:
        os.close(handle)
        temporary.unlink(missing_ok=True)


def _beside(target: Path) -> tuple[Path, int]:
    """A new file beside another one, and its handle, which is locked."""
    if target.is_dir():
        raise DataError(f"{target}: is a directory; give the name of a file")
    if target.exists() and not target.is_file():
        raise DataError(f"{target}: is no regular file, and would be replaced; give the name of a file")
    if not target.parent.is_dir():
        raise DataError(f"{target}: there is no directory {target.parent}")
    prefix = f".{target.name}.sigmatau-"
    for left in target.parent.glob(f"{glob.escape(prefix)}*"):
        _remove_left(left)
    # The ending stays, because writers choose a format by it.
    ending = "".join(target.suffixes[-2:])
    while True:
        handle, name = tempfile.mkstemp(prefix=prefix, suffix=ending, dir=target.parent)
        _locked(handle)
        if Path(name).exists():  # another process may have removed it before it was locked
            return Path(name), handle
        os.close(handle)


def _remove_left(left: Path) -> None:
    """Remove a file that a killed process left behind, and the folder of its parts; not one that is being written."""
    with contextlib.suppress(OSError):
        if left.is_dir():
            if not left.with_suffix("").exists():  # parts of a file that is removed before or after them
                shutil.rmtree(left, ignore_errors=True)
            return
        handle = os.open(left, os.O_RDWR)
        try:
            if _locked(handle):
                left.unlink()
                shutil.rmtree(left.with_name(left.name + PARTS), ignore_errors=True)
        finally:
            os.close(handle)


def _locked(handle: int) -> bool:
    """Whether the file could be locked; False where there are no locks, and nothing is known of other processes."""
    try:
        import fcntl

        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (ImportError, OSError):
        return False
    return True


@contextlib.contextmanager
def table_writer(path: str | Path, columns: Sequence[tuple[str, str]]) -> Iterator[Put]:
    """What takes a table piece by piece; the file has its name when the block ends well, and is not there otherwise.
    `path`: its ending is one of `RECORD_ENDINGS`.
    """
    target = Path(path)
    ending = ending_of(target)
    _check_names(columns)
    with contextlib.ExitStack() as stack:
        temporary = stack.enter_context(atomic(target))
        yield stack.enter_context(WRITERS[ending](temporary, columns))


def _check_names(columns: Sequence[tuple[str, str]]) -> None:
    """`DataError` for names that the reader would not give back, whatever the format."""
    from sigmatau.io.read.names import LONGEST_NAME, recognise
    from sigmatau.io.read.table import Column

    headers = headers_of(columns)
    taken: dict[str, str] = {}
    for (name, unit), header, match in zip(columns, headers, recognise([Column(name=h) for h in headers]), strict=True):
        if not name.strip():
            raise DataError(f"a channel needs a name to be written, and one has {name!r}")
        if not header.isprintable():
            raise DataError(
                f"the channel {name!r} in {unit!r} cannot be written: its name and unit must be printable text"
            )
        if len(header) > LONGEST_NAME:
            raise DataError(
                f"the channel {name[:20]!r}… cannot be written: with its unit the name has {len(header)} characters, and"
                f" {LONGEST_NAME} are the most"
            )
        means = match[0] if match else name
        if means in taken:
            raise DataError(
                f"the channel {name!r} cannot be written beside {taken[means]!r}: a reader takes both for {means}; give"
                " the channel another name"
            )
        taken[means] = name


def ending_of(path: Path) -> str:
    """Which of `RECORD_ENDINGS` a name has; raises `OptionError` if none."""
    ending = next((e for e in sorted(RECORD_ENDINGS, key=len, reverse=True) if path.name.endswith(e)), None)
    if ending is None:
        raise OptionError(f"{path}: a record is written as {', '.join(RECORD_ENDINGS)}", option="output")
    return ending


def write(record: Record, path: str | Path) -> None:
    """Write a record as a table: time and every channel, rates in SI, each with its unit.

    Parameters
    ----------
    record : Record
        All streams on one grid.
    path : str or Path
        ``.csv``, ``.csv.gz`` (shortest digits that read back to the same bits), ``.npy`` (a structured array, a field a
        channel), ``.npz`` (one array a channel), ``.parquet``, ``.h5`` (one dataset a channel).

    Raises
    ------
    OptionError
        For another ending.
    DataError
        If the streams have different grids, the file cannot be written, or a library is not installed that the format needs.
    """
    target = Path(path)
    ending_of(target)
    grid = record.streams[0].grid
    if any(s.grid.n != grid.n or s.grid.tau0 != grid.tau0 for s in record.streams):
        raise DataError("streams with different grids do not fit in one table; write them one by one")
    columns = [("time", "s"), *((channel, s.unit) for s in record.streams for channel in s.channels)]
    with table_writer(target, columns) as put:
        for start in range(0, grid.n, CHUNK):
            stop = min(start + CHUNK, grid.n)
            # k/rate prints short (0.07) where k·tau0 does not (0.07000000000000001).
            piece = [grid.start + np.arange(start, stop) / grid.rate]
            for stream in record.streams:
                piece += [stream.samples.read(k, start, stop) for k in range(len(stream.channels))]
            put(piece)
