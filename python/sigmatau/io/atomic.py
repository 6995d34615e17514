"""Files that are written completely or not at all."""

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
"""Ending of the folder in which a writer keeps parts of its temporary file."""


@contextlib.contextmanager
def atomic(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path beside `path`. It replaces `path` if the block succeeds, and is removed if the block fails.

    The temporary file is locked while it is written. One left behind by a killed process is not locked, and the next writer
    of the same file removes it. A symbolic link stays a link: the file that it points to is replaced.
    """
    try:
        target = Path(os.path.realpath(path))
        temporary, handle = _make_temporary(target)
    except OSError as error:
        raise DataError(f"{path}: cannot be written: {error.strerror or error}") from None
    except (TypeError, ValueError) as error:
        if isinstance(error, DataError):
            raise
        raise DataError(f"{path!r}: not a valid file name: {error}") from None
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
    """Create a locked temporary file beside `target`; return its path and its handle."""
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
        _try_to_lock(handle)
        if Path(name).exists():  # another process may have removed it before it was locked
            return Path(name), handle
        os.close(handle)


def _remove_abandoned(path: Path) -> None:
    """Remove the temporary file of a killed process, and the folder of its parts, unless the file is still being written."""
    with contextlib.suppress(OSError):
        if path.is_dir():
            if not path.with_suffix("").exists():  # the file may be removed before its parts or after them
                shutil.rmtree(path, ignore_errors=True)
            return
        handle = os.open(path, os.O_RDWR)
        try:
            if _try_to_lock(handle):
                path.unlink()
                shutil.rmtree(path.with_name(path.name + PARTS), ignore_errors=True)
        finally:
            os.close(handle)


def _try_to_lock(handle: int) -> bool:
    """Lock a file; False if another process holds the lock, or if the system has no locks."""
    try:
        import fcntl

        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (ImportError, OSError):
        return False
    return True
