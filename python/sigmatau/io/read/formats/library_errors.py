"""Errors that libraries raise on damaged files, as `DataError`."""

from __future__ import annotations

import errno
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from sigmatau.errors import DataError

__all__ = ["damaged", "first_line", "library_faults"]


def first_line(error: Exception) -> str:
    """The first line of an error, or its type if it has no text."""
    return str(error).split("\n")[0].strip("'\"") or type(error).__name__


def damaged(error: Exception, what: str = "damaged or truncated") -> DataError:
    """A `DataError` from the error of a library."""
    return DataError(f"is {what} ({first_line(error)}); copy or record the file again")


@contextmanager
def library_faults(convert: Callable[[Exception], DataError] = damaged) -> Iterator[None]:
    """Turn the errors of a library on a damaged file into `DataError`.

    `DataError`, `MemoryError` and errors of the operating system are not changed.
    """
    try:
        yield
    except (DataError, MemoryError):
        raise
    except OSError as error:
        if error.errno not in (None, errno.EINVAL):  # EINVAL: an offset before the beginning of the file
            raise
        raise convert(error) from None
    except Exception as error:
        raise convert(error) from None
