"""Writing whole files or none."""

from __future__ import annotations

import contextlib
import glob
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

from sigmatau.errors import DataError

PARTS = ".parts"
"""Ending of the folder beside a temporary file in which a writer keeps parts of it."""


@contextlib.contextmanager
def atomic(path: str | Path) -> Iterator[Path]:
    """A path beside `path` to write to, which takes its name when the block ends well and vanishes when it does not.

    The file is locked while it is written: what a killed process left behind is not, and is removed by the next one that
    writes the same file. A symbolic link stays, and the file that it names is written.
    """
    try:
        target = Path(os.path.realpath(path))
        temporary, handle = _make_temporary(target)
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
        raise DataError(f"{path}: cannot be written: {error.strerror or error}") from None
    finally:
        os.close(handle)
        temporary.unlink(missing_ok=True)


def _make_temporary(target: Path) -> tuple[Path, int]:
    """A new file beside another one, and its handle, which is locked."""
    if target.is_dir():
        raise DataError(f"{target}: is a directory; give the name of a file")
    if target.exists() and not target.is_file():
        raise DataError(f"{target}: is not a regular file, and would be replaced; give the name of a file")
    if not target.parent.is_dir():
        raise DataError(f"{target}: there is no directory {target.parent}")
    prefix = f".{target.name}.sigmatau-"
    for abandoned in target.parent.glob(f"{glob.escape(prefix)}*"):
        _remove_abandoned(abandoned)
    # The ending stays, because writers choose a format by it.
    ending = "".join(target.suffixes[-2:])
    while True:
        handle, name = tempfile.mkstemp(prefix=prefix, suffix=ending, dir=target.parent)
        _locked(handle)
        if Path(name).exists():  # another process may have removed it before it was locked
            return Path(name), handle
        os.close(handle)


def _remove_abandoned(path: Path) -> None:
    """Remove a file that a killed process left behind, and the folder of its parts; not one that is being written."""
    with contextlib.suppress(OSError):
        if path.is_dir():
            if not path.with_suffix("").exists():  # parts of a file that is removed before or after them
                shutil.rmtree(path, ignore_errors=True)
            return
        handle = os.open(path, os.O_RDWR)
        try:
            if _locked(handle):
                path.unlink()
                shutil.rmtree(path.with_name(path.name + PARTS), ignore_errors=True)
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
