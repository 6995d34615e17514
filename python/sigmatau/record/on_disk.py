"""Columns that stay in their file, and are read piece by piece.

A mapped file that another process shortens ends the program without a word. Here every read is checked instead, and the
file counts for nothing in the process's limit of memory.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.record.memory import available
from sigmatau.record.streams import Stream

_PIECE = 1 << 16  # rows read at a time, if a row is short
_PIECE_BYTES = 1 << 22  # bytes read at a time, at most, if they are more than a row
_SPARSE = 1 << 14  # rows that are read one by one where steps are long
_LOADED = 0.2  # share of the free memory that columns may take: an analysis needs three times as much as its samples


_CHANGED = "the file changed while it was being read; wait until it is written, or copy it first"


def file_bytes(path: Path) -> NDArray[np.uint8]:
    """All bytes of a file, which must not be changed; raises `DataError` if they do not fit in memory."""
    size, free = path.stat().st_size, available()
    if free is not None and size > free:
        raise DataError(f"has {size / 1e9:.3g} GB, but {free / 1e9:.3g} GB of memory are free")
    found = np.fromfile(path, np.uint8)
    if len(found) < size:
        raise DataError(_CHANGED)
    found.flags.writeable = False
    return found


def loaded(stream: Stream) -> Stream:
    """The stream with its columns in memory, if they stay in their file and are a small part of the free memory.

    The columns of a row share its bytes: one column after the other would read the whole file for each.
    """
    columns = stream.samples.raw
    size, free = sum(len(column) * column.dtype.itemsize for column in columns), available()
    if not all(isinstance(column, FileColumn) for column in columns) or (free is not None and size > _LOADED * free):
        return stream
    arrays = tuple(np.empty(len(column), column.dtype) for column in columns)
    at = 0
    for pieces in zip(*(cast("FileColumn", column).pieces() for column in columns), strict=True):
        for array, piece in zip(arrays, pieces, strict=True):
            array[at : at + len(piece)] = piece
        at += len(pieces[0])
    return replace(stream, samples=replace(stream.samples, raw=arrays))


class FileRows:
    """Rows of one size in a file, open as long as one of its columns is in use.

    Parameters
    ----------
    path : Path
    dtype : dtype
        Of a row.
    count : int
        Number of rows.
    offset : int
        Where the first one begins. [bytes]
    """

    def __init__(self, path: Path, dtype: np.dtype[Any], count: int, offset: int) -> None:
        self.path, self.dtype, self.count, self.offset = path, dtype, count, offset
        self._handle = os.open(path, os.O_RDONLY | getattr(os, "O_BINARY", 0))
        self._lock = threading.Lock()
        self._last: tuple[int, int, NDArray[Any]] | None = None

    def __del__(self) -> None:
        if hasattr(self, "_handle"):
            os.close(self._handle)

    def column(self, field: str | None = None, part: int | None = None) -> NDArray[Any]:
        """A column: a field of a row, or its part of a given number. It is a `FileColumn`, which acts as an array does."""
        return cast("NDArray[Any]", FileColumn(self, field, part, 0, self.count))

    def rows(self, start: int, stop: int) -> NDArray[Any]:
        """Rows, as an array that must not be changed; the last ones are kept, because columns are read one by one."""
        last = self._last
        if last is not None and last[0] <= start and stop <= last[1]:
            return last[2][start - last[0] : stop - last[0]]
        size = self.dtype.itemsize
        found = np.frombuffer(self._bytes(self.offset + start * size, (stop - start) * size), self.dtype)
        if len(found) * size <= 2 * _PIECE_BYTES:
            self._last = start, stop, found
        return found

    def _bytes(self, at: int, count: int) -> bytes:
        pieces = []
        while count > 0:
            try:
                if hasattr(os, "pread"):
                    piece = os.pread(self._handle, count, at)
                else:
                    with self._lock:
                        os.lseek(self._handle, at, os.SEEK_SET)
                        piece = os.read(self._handle, count)
            except OSError as error:
                raise DataError(f"cannot be read any more: {error.strerror or error}").about(str(self.path)) from None
            if not piece:
                raise DataError(_CHANGED).about(str(self.path))
            pieces.append(piece)
            at, count = at + len(piece), count - len(piece)
        return pieces[0] if len(pieces) == 1 else b"".join(pieces)


class FileColumn(np.lib.mixins.NDArrayOperatorsMixin):
    """A column of rows in a file. A slice of it is one too; anything else that is done with it reads it into an array."""

    __slots__ = ("_field", "_part", "_rows", "_start", "_stop")

    def __init__(self, rows: FileRows, field: str | None, part: int | None, start: int, stop: int) -> None:
        self._rows, self._field, self._part, self._start, self._stop = rows, field, part, start, stop

    @property
    def key(self) -> tuple[object, ...]:
        """What tells it from any other column, as long as it is in use."""
        return id(self._rows), self._field, self._part, self._start, self._stop

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

    def pieces(self) -> Iterator[NDArray[Any]]:
        """The numbers, a part of them at a time."""
        step = max(min(_PIECE, _PIECE_BYTES // max(self._rows.dtype.itemsize, 1)), 1)
        for start in range(self._start, self._stop, step):
            yield self._read(start, min(start + step, self._stop))

    def _read(self, start: int, stop: int) -> NDArray[Any]:
        found = self._rows.rows(start, stop)
        found = found if self._field is None else found[self._field]
        return np.ascontiguousarray(found if self._part is None else found[:, self._part], dtype=self.dtype)

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
            places = range(start, stop, step)
            if len(places) <= _SPARSE:
                return np.array([self[place] for place in places], dtype=self.dtype)
        return np.asarray(self)[key]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:  # noqa: ANN401, FBT001
        if copy is False:
            raise ValueError("a column in a file cannot be an array without being read")
        found = np.empty(len(self), self.dtype)
        at = 0
        for piece in self.pieces():
            found[at : at + len(piece)] = piece
            at += len(piece)
        return found if dtype is None else found.astype(dtype, copy=False)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:  # noqa: ANN401
        arrays = (np.asarray(one) if isinstance(one, FileColumn) else one for one in inputs)
        return getattr(ufunc, method)(*arrays, **options)

    def astype(self, dtype: Any, *, copy: bool = True) -> NDArray[Any]:  # noqa: ANN401
        return np.asarray(self).astype(dtype, copy=copy)

    def __reduce__(self) -> tuple[Any, ...]:
        return np.array, (np.asarray(self),)
