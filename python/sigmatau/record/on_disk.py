"""Columns that stay in their file, and are read piece by piece.

If another process shortens a mapped file, the program ends without a message. Here every read is checked instead, and the
file does not count in the process's memory limit.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.record.memory import available
from sigmatau.record.streams import Stream

_PIECE = 1 << 16  # rows read at a time if rows are short; columns that are read one by one share them
_PIECE_BYTES = 1 << 19  # bytes read at a time if they are more than a row: a part of a processor's cache
_KEPT_BYTES = 1 << 23  # largest size of the rows that are kept for the next column
_SPARSE = 1 << 14  # distance of rows above which each is read separately [bytes]
_PART = 1 << 20  # rows that a thread reads
_READERS = 4  # largest number of threads
# share of the free memory that columns may use, because an analysis needs three times as much as its samples
_LOADED = 0.2


_CHANGED = "the file changed while it was being read; wait until it is written, or copy it first"


def file_bytes(path: Path) -> NDArray[np.uint8]:
    """All bytes of a file, which must not be changed; raises `DataError` if they do not fit in memory."""
    size, free = path.stat().st_size, available()
    if free is not None and size > free:
        raise DataError(f"has {size / 1e9:.3g} GB, but {free / 1e9:.3g} GB of memory are free")
    data = np.fromfile(path, np.uint8)
    if len(data) < size:
        raise DataError(_CHANGED)
    data.flags.writeable = False
    return data


def loaded(streams: Sequence[Stream], threads: int | None = None) -> tuple[Stream, ...]:
    """Load the columns that are still in their files, if they take a small part of the free memory.

    Columns share rows: loading one column after the other would read the whole file for each.
    """
    columns = [column for stream in streams for column in stream.samples.raw]
    on_file = [column for column in columns if isinstance(column, FileColumn)]
    size, free = sum(len(column) * column.dtype.itemsize for column in on_file), available()
    if not on_file or (free is not None and size > _LOADED * free):
        return tuple(streams)
    arrays = [np.empty(len(column), column.dtype) if isinstance(column, FileColumn) else column for column in columns]
    by_extent: dict[tuple[int, int, int], list[tuple[FileColumn, NDArray[Any]]]] = {}
    for column, array in zip(columns, arrays, strict=True):
        if isinstance(column, FileColumn):
            by_extent.setdefault(column.extent, []).append((column, array))
    parts = [
        (group, start, min(start + _PART, len(group[0][1])))
        for group in by_extent.values()
        for start in range(0, len(group[0][1]), _PART)
    ]

    def fill(part: tuple[list[tuple[FileColumn, NDArray[Any]]], int, int]) -> None:
        group, start, stop = part
        for first, rows in group[0][0].rows_between(start, stop):
            for column, array in group:
                array[first : first + len(rows)] = column.take(rows)

    workers = min(threads or os.cpu_count() or 1, len(parts), _READERS)
    if workers > 1:
        from concurrent.futures import ThreadPoolExecutor

        with ThreadPoolExecutor(workers) as pool:
            list(pool.map(fill, parts))
    else:
        for part in parts:
            fill(part)
    for_streams = iter(arrays)
    return tuple(
        replace(stream, samples=replace(stream.samples, raw=tuple(next(for_streams) for _ in stream.channels)))
        for stream in streams
    )


class StoredRows:
    """Rows of one size that are read when they are needed, from a file or another storage.

    Parameters
    ----------
    dtype : dtype
        Type of a row.
    count : int
        Number of rows.
    """

    def __init__(self, dtype: np.dtype[Any], count: int) -> None:
        self.dtype = dtype
        self.count = count
        self._last: tuple[int, int, int, NDArray[Any]] | None = None

    @property
    def step(self) -> int:
        """Rows that are stored together."""
        return 1

    def read(self, start: int, stop: int) -> NDArray[Any]:
        """Read rows without keeping them; several threads may call it."""
        raise NotImplementedError

    def column(self, field: str | None = None, part: int | None = None) -> NDArray[Any]:
        """A column: a field of a row, or an element of a field. It is a `FileColumn`, which behaves like an array."""
        return cast("NDArray[Any]", FileColumn(self, field, part, 0, self.count))

    def rows(self, start: int, stop: int) -> NDArray[Any]:
        """Rows, as an array that must not be changed; the last ones are kept, because columns are read one by one."""
        last = self._last
        if last is not None and last[0] <= start and stop <= last[1] and last[2] == 1:
            return last[3][start - last[0] : stop - last[0]]
        # Released before the next read, so that the same memory is used again: new pages take longer than the reading.
        self._last = last = None
        return self._keep(start, stop, 1, self.read(start, stop))

    def every(self, start: int, stop: int, step: int) -> NDArray[Any]:
        """Every `step`-th row from `start` to `stop`, kept for the next call."""
        last = self._last
        if last is not None and last[:3] == (start, stop, step):
            return last[3]
        if step * self.dtype.itemsize > _SPARSE:
            pieces = [self.read(place, place + 1) for place in range(start, stop, step)]
        else:
            ahead = max(_PIECE_BYTES // (self.dtype.itemsize * step), 1) * step
            pieces = [self.read(first, min(first + ahead, stop))[::step] for first in range(start, stop, ahead)]
        return self._keep(start, stop, step, np.concatenate([self.read(0, 0), *pieces]))

    def _keep(self, start: int, stop: int, step: int, rows: NDArray[Any]) -> NDArray[Any]:
        if rows.nbytes <= _KEPT_BYTES:
            self._last = start, stop, step, rows
        return rows


class FileRows(StoredRows):
    """Rows of one size in a file, open as long as one of its columns is in use.

    Parameters
    ----------
    path : Path
    dtype : dtype
        Type of a row.
    count : int
        Number of rows.
    offset : int
        Where the first one begins. [bytes]
    """

    def __init__(self, path: Path, dtype: np.dtype[Any], count: int, offset: int) -> None:
        super().__init__(dtype, count)
        self.path = path
        self.offset = offset
        self._handle = os.open(path, os.O_RDONLY | getattr(os, "O_BINARY", 0))
        self._lock = threading.Lock()

    def __del__(self) -> None:
        if hasattr(self, "_handle"):
            os.close(self._handle)

    def read(self, start: int, stop: int) -> NDArray[Any]:
        """Rows, which are not kept."""
        size = self.dtype.itemsize
        return np.frombuffer(self._bytes(self.offset + start * size, (stop - start) * size), self.dtype)

    def _bytes(self, offset: int, count: int) -> bytes:
        pieces = []
        while count > 0:
            try:
                if hasattr(os, "pread"):
                    piece = os.pread(self._handle, count, offset)
                else:
                    with self._lock:
                        os.lseek(self._handle, offset, os.SEEK_SET)
                        piece = os.read(self._handle, count)
            except OSError as error:
                raise DataError(f"cannot be read any more: {error.strerror or error}").about(str(self.path)) from None
            if not piece:
                raise DataError(_CHANGED).about(str(self.path))
            pieces.append(piece)
            offset, count = offset + len(piece), count - len(piece)
        return pieces[0] if len(pieces) == 1 else b"".join(pieces)


class FileColumn(np.lib.mixins.NDArrayOperatorsMixin):
    """A column of rows in a file. A slice of it is a `FileColumn` too; any other operation reads it into an array."""

    __slots__ = ("_field", "_part", "_rows", "_start", "_stop")

    def __init__(self, rows: StoredRows, field: str | None, part: int | None, start: int, stop: int) -> None:
        self._rows, self._field, self._part, self._start, self._stop = rows, field, part, start, stop

    @property
    def key(self) -> tuple[object, ...]:
        """A key that no other column has while this one is in use."""
        return id(self._rows), self._field, self._part, self._start, self._stop

    @property
    def step(self) -> int:
        """Rows that are stored together."""
        return self._rows.step

    @property
    def dtype(self) -> np.dtype[Any]:
        dtype = self._rows.dtype if self._field is None else self._rows.dtype[self._field]
        return dtype.base.newbyteorder("=")

    @property
    def shape(self) -> tuple[int]:
        return (len(self),)

    @property
    def ndim(self) -> int:
        return 1

    def __len__(self) -> int:
        return self._stop - self._start

    @property
    def extent(self) -> tuple[int, int, int]:
        """Identifies the rows that contain the column."""
        return id(self._rows), self._start, self._stop

    def rows_between(self, start: int, stop: int) -> Iterator[tuple[int, NDArray[Any]]]:
        """Rows of a part of the column, a few at a time, and where they begin; they are not kept for other columns."""
        step = max(min(_PIECE, _PIECE_BYTES // max(self._rows.dtype.itemsize, 1)), 1)
        for first in range(start, stop, step):
            yield first, self._rows.read(self._start + first, self._start + min(first + step, stop))

    def take(self, rows: NDArray[Any]) -> NDArray[Any]:
        """The numbers of this column in some rows."""
        values = rows if self._field is None else rows[self._field]
        return values if self._part is None else values[:, self._part]

    def _read(self, start: int, stop: int) -> NDArray[Any]:
        return np.ascontiguousarray(self.take(self._rows.rows(start, stop)), dtype=self.dtype)

    def __getitem__(self, key: Any) -> Any:  # noqa: ANN401  as of an array
        if isinstance(key, int | np.integer):
            place = int(key) + (len(self) if key < 0 else 0)
            if not 0 <= place < len(self):
                raise IndexError(f"index {key} of {len(self)}")
            return self._read(self._start + place, self._start + place + 1)[0]
        if isinstance(key, slice):
            start, stop, step = key.indices(len(self))
            if step == 1:
                stop = max(stop, start)
                return FileColumn(self._rows, self._field, self._part, self._start + start, self._start + stop)
            if step > 1:
                rows = self._rows.every(self._start + start, self._start + max(stop, start), step)
                return np.ascontiguousarray(self.take(rows), dtype=self.dtype)
        return np.asarray(self)[key]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:  # noqa: ANN401, FBT001
        if copy is False:
            raise ValueError("a column in a file cannot be an array without being read")
        values = np.empty(len(self), self.dtype)
        if len(self) <= _PIECE:
            values[:] = self.take(self._rows.rows(self._start, self._stop))
        else:
            for first, rows in self.rows_between(0, len(self)):
                values[first : first + len(rows)] = self.take(rows)
        return values if dtype is None else values.astype(dtype, copy=False)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:  # noqa: ANN401
        arrays = (np.asarray(each) if isinstance(each, FileColumn) else each for each in inputs)
        return getattr(ufunc, method)(*arrays, **options)

    def astype(self, dtype: Any, *, copy: bool = True) -> NDArray[Any]:  # noqa: ANN401
        return np.asarray(self).astype(dtype, copy=copy)

    def __reduce__(self) -> tuple[Any, ...]:
        return np.array, (np.asarray(self),)
