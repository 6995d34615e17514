"""Files that are written completely or not at all."""

from __future__ import annotations

import contextlib
import glob
import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path

from sigmatau.errors import DataError

_MAX_LINKS = 40  # largest number of links that Linux follows in a path
PARTS = ".parts"
"""Ending of the folder in which a writer keeps parts of its temporary file."""


@contextlib.contextmanager
def atomic(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path beside `path`. It replaces `path` if the block succeeds, and is removed if the block fails.

    The temporary file is locked while it is written. One left behind by a killed process is not locked, and the next writer
    of the same file removes it. A symbolic link stays a link: the file that it points to is replaced, unless another user
    made the link in a folder that all users share.
    """
    try:
        _refuse_foreign_links(Path(path))
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


def _refuse_foreign_links(path: Path) -> None:
    """Raise `DataError` for a link that another user made in a shared folder, such as ``/tmp``: it would choose the file to
    be replaced. The rule is that of Linux for files that are opened (proc_sys_fs(5), protected_symlinks), which does not
    cover files that are renamed.
    """
    user = os.geteuid() if hasattr(os, "geteuid") else None
    for _ in range(_MAX_LINKS):
        if user is None or not path.is_symlink():
            return
        if is_foreign_link(path.lstat(), path.absolute().parent.stat(), user):
            raise DataError(
                f"{path}: is a symbolic link of another user in a shared folder; give another name, or remove the link"
            )
        path = path.parent / path.readlink()


def is_foreign_link(link: os.stat_result, folder: os.stat_result, user: int) -> bool:
    """Whether a link in a folder with the sticky bit that all may write is of neither this user nor the folder's owner."""
    is_shared = bool(folder.st_mode & stat.S_ISVTX and folder.st_mode & stat.S_IWOTH)
    return is_shared and link.st_uid not in (user, folder.st_uid)


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
        handle = os.open(path, os.O_RDWR | getattr(os, "O_NOFOLLOW", 0))  # a writer makes no links
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
