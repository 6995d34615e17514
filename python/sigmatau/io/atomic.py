"""Writing whole files or none."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from sigmatau.errors import DataError

__all__ = ["atomic"]


@contextlib.contextmanager
def atomic(path: str | Path) -> Iterator[Path]:
    """A path beside `path` to write to, which takes its name when the block ends well and vanishes when it does not."""
    try:
        target = Path(path)
        temporary = _beside(target)
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
        temporary.unlink(missing_ok=True)


def _beside(target: Path) -> Path:
    if target.is_dir():
        raise DataError(f"{target}: is a directory; give the name of a file")
    if target.exists() and not target.is_file():
        raise DataError(f"{target}: is no regular file, and would be replaced; give the name of a file")
    if not target.parent.is_dir():
        raise DataError(f"{target}: there is no directory {target.parent}")
    # The ending stays, because writers choose a format by it.
    ending = "".join(target.suffixes[-2:])
    handle, name = tempfile.mkstemp(prefix=f".{target.name}.", suffix=ending, dir=target.parent)
    os.close(handle)
    return Path(name)
