"""Errors that libraries raise on damaged archives, as `DataError`."""

from __future__ import annotations

import errno
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from sigmatau.errors import DataError

__all__ = ["archive_faults"]


@contextmanager
def archive_faults(damaged: Callable[[Exception], DataError]) -> Iterator[None]:
    """Turn the errors of NumPy, zipfile and zlib on a damaged archive into the `DataError` that `damaged` returns.

    `DataError`, `MemoryError` and errors of the operating system are not changed.
    """
    try:
        yield
    except (DataError, MemoryError):
        raise
    except OSError as error:
        if error.errno != errno.EINVAL:  # EINVAL: an offset before the beginning of the file
            raise
        raise damaged(error) from None
    except Exception as error:
        raise damaged(error) from None
