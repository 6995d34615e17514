"""HDF5 files written piece by piece, such that neither a full disk nor an interruption harms the process.

The HDF5 library does not survive a write that fails: it keeps what it could not write and crashes when it lets go of it. And
an exception of a signal is lost when it falls into one of h5py's callbacks. So the library writes to a file that never fails
it and tells us of the error, and lives in a thread of its own, which signals do not reach.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

__all__ = ["Hdf5Table"]

_CHUNK = 1 << 13  # of a dataset


class _Patient(io.RawIOBase):
    """A file that takes every write; what does not go to the disk any more is kept in memory, so that reads are right."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._kept: list[tuple[int, bytes]] = []
        self._at = 0
        self.error: OSError | None = None

    def readable(self) -> bool:
        return True

    def writable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = 0, /) -> int:
        if whence == io.SEEK_END:
            ends = [start + len(data) for start, data in self._kept]
            self._at = max([self._file.seek(0, io.SEEK_END), *ends]) + offset
        else:
            self._at = offset + (self._at if whence == io.SEEK_CUR else 0)
        return self._at

    def tell(self) -> int:
        return self._at

    def readinto(self, buffer: Any, /) -> int:  # noqa: ANN401  any buffer
        wanted = memoryview(buffer).cast("B")
        there = bytearray(len(wanted))
        self._file.seek(self._at)
        stored = self._file.read(len(wanted)) or b""
        there[: len(stored)] = stored
        for start, data in self._kept:
            low, high = max(start, self._at), min(start + len(data), self._at + len(wanted))
            if low < high:
                there[low - self._at : high - self._at] = data[low - start : high - start]
        wanted[:] = there
        self._at += len(wanted)
        return len(wanted)

    def write(self, data: Any, /) -> int:  # noqa: ANN401  any buffer
        rest = memoryview(data).cast("B")
        size, done = len(rest), 0
        if self.error is None:
            try:
                self._file.seek(self._at)
                while done < size:
                    done += self._file.write(rest[done:])
            except OSError as error:
                self.error = error
        if done < size:
            self._kept.append((self._at + done, bytes(rest[done:])))
        self._at += size
        return size

    def truncate(self, size: int | None = None, /) -> int:
        end = self._at if size is None else size
        if self.error is None:
            try:
                self._file.truncate(end)
            except OSError as error:
                self.error = error
        return end

    def check(self) -> None:
        """Raise what the disk said."""
        if self.error is not None:
            raise self.error


class Hdf5Table:
    """A dataset a column, with its unit as an attribute and checksums."""

    def __init__(self, library: Any, path: Path, columns: Sequence[tuple[str, str]]) -> None:  # noqa: ANN401  no types
        self._library = library
        self._path = path
        self._columns = columns
        self._datasets: list[Any] = []
        self._open: Any = None

    @contextlib.contextmanager
    def writing(self) -> Iterator[Callable[[Sequence[NDArray[np.float64]]], None]]:
        """What takes the next piece; raises `OSError` where the disk takes no more, at the latest at the end."""
        with self._path.open("r+b", buffering=0) as file, ThreadPoolExecutor(1) as thread:
            patient = _Patient(file)
            try:
                thread.submit(self._begin, patient).result()

                def put(piece: Sequence[NDArray[np.float64]]) -> None:
                    thread.submit(self._add, piece).result()
                    patient.check()

                yield put
            finally:
                # Also after an interruption, and waited for: the thread ends before the file is closed.
                thread.submit(self._end).result()
            patient.check()

    def _begin(self, patient: _Patient) -> None:
        self._open = self._library.File(patient, "w")
        for name, unit in self._columns:
            dataset = self._open.create_dataset(
                name, shape=(0,), maxshape=(None,), dtype="<f8", chunks=(_CHUNK,), fletcher32=True
            )
            dataset.attrs["unit"] = unit
            self._datasets.append(dataset)

    def _add(self, piece: Sequence[NDArray[np.float64]]) -> None:
        for dataset, values in zip(self._datasets, piece, strict=True):
            there = dataset.shape[0]
            dataset.resize((there + len(values),))
            dataset[there:] = values

    def _end(self) -> None:
        # Let go here, so that the callbacks of what vanishes do not run where signals arrive.
        self._datasets.clear()
        if self._open is not None:
            self._open.close()
        self._open = None
