"""Faults that libraries raise on damaged archives, told as ours."""

from __future__ import annotations

import errno
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from sigmatau.errors import DataError

__all__ = ["archive_faults"]


@contextmanager
def archive_faults(damaged: Callable[[Exception], DataError]) -> Iterator[None]:
    """Whatever NumPy, zipfile and zlib raise on a damaged archive, a dozen kinds, becomes the error that `damaged` makes.

    Errors of ours, a lack of memory, and what the system says pass as they are.
    """
    try:
        yield
    except (DataError, MemoryError):
        raise
    except OSError as error:
        if error.errno != errno.EINVAL:  # a place before the beginning of the file
            raise
        raise damaged(error) from None
    except Exception as error:
        raise damaged(error) from None
