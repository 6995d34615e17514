"""First values and a coarse picture of each column of a table, for a user who must choose columns."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import Floats
from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.io.read.table import Loaded, Table

BINS = 64
"""Number of stretches in the picture of a column."""

_FIRST = 5  # number of first values of a column
_MAX_COLUMNS = 128  # largest number of columns that are loaded although they are not channels
_MISSING = np.iinfo(np.int64).min


@frozen(eq=False)
class ColumnSamples:
    """Numbers of a column, unconverted; NaN where one is missing.

    Attributes
    ----------
    first : tuple of float
        Values in the first rows. [unit of the file]
    low, high : ndarray, shape (n,)
        Smallest and largest value in `BINS` stretches, or in each row of a shorter table. [unit of the file]
    """

    first: tuple[float, ...]
    low: Floats
    high: Floats


class SampledTable:
    """A table that keeps a picture of each column that is loaded from it.

    Parameters
    ----------
    table : Table
    """

    def __init__(self, table: Table) -> None:
        self._samples: dict[int, ColumnSamples] = {}
        self._load = table.load
        self.table: Table = replace(table, load=self._loaded)

    def samples(self) -> Mapping[int, ColumnSamples]:
        """The pictures by column, counted from 0; remaining columns are loaded first, if possible."""
        number = len(self.table.columns)
        absent = [k for k in range(number) if k not in self._samples]
        if self._samples and absent and number <= _MAX_COLUMNS:
            with contextlib.suppress(DataError):  # a column of words
                self._loaded(absent, None)
        return self._samples

    def _loaded(self, wanted: Sequence[int], exact: int | None) -> Loaded:
        loaded = self._load(wanted, exact)
        for k, column in loaded.columns.items():
            if k not in self._samples and len(column) and np.asarray(column[:1]).dtype.kind in "fiu":
                self._samples[k] = _picture(column)
        return loaded


def _picture(column: NDArray[Any]) -> ColumnSamples:
    edges = np.unique(np.linspace(0, len(column), BINS + 1).round().astype(np.int64))
    stretches = np.asarray(column)
    low, high = np.fmin.reduceat(stretches, edges[:-1]), np.fmax.reduceat(stretches, edges[:-1])
    first, low, high = (_as_floats(part) for part in (stretches[:_FIRST], low, high))
    return ColumnSamples(first=tuple(first.tolist()), low=low, high=high)


def _as_floats(values: NDArray[Any]) -> Floats:
    numbers = np.asarray(values, dtype=np.float64)
    if values.dtype.kind == "i":
        numbers = np.where(values == _MISSING, np.nan, numbers)
    return numbers
