"""Conversion and checks of arguments of the compiled functions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau.errors import NonFiniteError, OptionError

_MAX_THREADS = 1024
_LARGEST_SIZE = 2**53  # integers up to this size are exact in a double
_PIECE = 4096  # number of samples of each column that are copied together


def check_overlap(overlap: str) -> None:
    if overlap not in ("full", "none"):
        raise OptionError(f"{{option}} must be 'full' or 'none', not {overlap!r}", option="overlap")


def check_counting(counting: str) -> None:
    if counting not in ("standard", "paper"):
        raise OptionError(f"{{option}} must be 'standard' or 'paper', not {counting!r}", option="counting")


def check_threads(threads: int | None) -> None:
    if threads is not None and not (isinstance(threads, int | np.integer) and 1 <= threads <= _MAX_THREADS):
        raise OptionError(f"{{option}} must be a number from 1 to {_MAX_THREADS}, not {threads!r}", option="threads")


def non_finite(error: ValueError, arrays: Sequence[NDArray[np.float64]], names: Sequence[str]) -> NonFiniteError:
    channel, index = error.args[1], error.args[2]
    name = names[channel]
    value = float(arrays[channel][index])
    return NonFiniteError(
        f"`{name}` is {value:g} in SI at index {index}: not finite, or too large to be squared; cut it out first",
        channel=name,
        index=index,
    )


def contiguous(columns: Sequence[ArrayLike], names: Sequence[str]) -> list[NDArray[np.float64]]:
    """Return each column as a contiguous float64 array. Columns that are not contiguous are copied together, piece by
    piece.

    Columns of a table that is stored row by row share cache lines. Copying one column after the other would fetch all lines
    again for each.
    """
    arrays = [np.asarray(column) for column in columns]
    for array, name in zip(arrays, names, strict=True):
        if array.ndim != 1:
            raise ValueError(f"`{name}` must have one dimension, got shape {array.shape}")
    ready = [array.dtype == np.float64 and array.flags.c_contiguous and array.dtype.isnative for array in arrays]
    copies = [array if done else np.empty(len(array)) for array, done in zip(arrays, ready, strict=True)]
    apart = [(copy, array) for copy, array, done in zip(copies, arrays, ready, strict=True) if not done]
    for start in range(0, max((len(array) for _, array in apart), default=0), _PIECE):
        for copy, array in apart:
            copy[start : start + _PIECE] = array[start : start + _PIECE]
    return copies


def whole_sizes(m: ArrayLike, *, counted: str = "samples") -> NDArray[np.int64]:
    """Cluster sizes as integers; `OptionError` for text, True, a fraction, or a number that a double cannot count."""
    array = np.atleast_1d(np.asarray(m))
    sizes = array.astype(np.float64) if array.dtype.kind in "iuf" else np.full(1, np.nan)
    if array.dtype.kind == "O" and all(isinstance(size, int) for size in array.ravel()):
        sizes = np.full(1, 2.0 * _LARGEST_SIZE)  # NumPy has no integers of more than 64 bits
    if not np.isfinite(sizes).all() or (sizes != np.rint(sizes)).any():
        raise OptionError(f"{{option}} must be whole numbers of {counted}", option="m")
    if sizes.size and np.abs(sizes).max() > _LARGEST_SIZE:
        raise OptionError(f"{{option}} must be at most {_LARGEST_SIZE:g} {counted}", option="m")
    return np.ascontiguousarray(array.astype(np.int64))
