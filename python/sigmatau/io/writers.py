"""Tables written piece by piece, so that what is written need not fit in memory: one writer a format.

Each takes the columns' names and units, then pieces of all columns; the number of rows is not known before the end.
"""

from __future__ import annotations

import contextlib
import gzip
import io
import shutil
import zipfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import IO, Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import formats
from sigmatau.errors import DataError
from sigmatau.io.atomic import PARTS

Piece = Sequence[NDArray[np.float64]]  # A piece of every column, each of shape (n,)
Put = Callable[[Piece], None]  # What takes the next piece
_ROWS = 1 << 16  # of a group of rows


def _lacking(extra: str, ending: str) -> DataError:
    return DataError(f"writing {ending} takes a library that is not installed: pip install 'sigmatau[{extra}]'")


def _refuse(columns: Sequence[tuple[str, str]], marks: str) -> None:
    """Names and units must not hold what has a meaning in the format."""
    for name, unit in columns:
        for mark in marks:
            if mark in name or mark in unit:
                where = "name" if mark in name else "unit"
                raise DataError(
                    f"the channel {name!r} cannot be written in this format, because of {mark!r} in its {where}"
                )


def headers_of(columns: Sequence[tuple[str, str]]) -> list[str]:
    """Names as columns have them: ``"gyro_x [rad/s]"``."""
    return [f"{name} [{unit}]" for name, unit in columns]


def _lines(stream: IO[bytes], columns: Sequence[tuple[str, str]]) -> Put:
    _refuse(columns, ',"\n')
    stream.write((",".join(headers_of(columns)) + "\n").encode())

    def put(piece: Piece) -> None:
        stream.write(formats.format_text(None, ",", piece))

    return put


@contextlib.contextmanager
def _csv(path: Path, columns: Sequence[tuple[str, str]]) -> Iterator[Put]:
    """Text, each number with as few digits as read back to the same bits."""
    with path.open("wb") as stream:
        yield _lines(stream, columns)


@contextlib.contextmanager
def _csv_gz(path: Path, columns: Sequence[tuple[str, str]]) -> Iterator[Put]:
    """The same, compressed; without a time, so that the same numbers give the same bytes."""
    with (
        path.open("wb") as stream,
        gzip.GzipFile("", "wb", compresslevel=6, fileobj=stream, mtime=0) as packed,
        io.BufferedWriter(packed, 1 << 20) as buffer,
    ):
        yield _lines(buffer, columns)


@contextlib.contextmanager
def _npy(path: Path, columns: Sequence[tuple[str, str]]) -> Iterator[Put]:
    """A structured array, a field a column named with its unit."""
    dtype = np.dtype([(header, "<f8") for header in headers_of(columns)])
    rows = 0

    def put(piece: Piece) -> None:
        nonlocal rows
        table = np.empty(len(piece[0]), dtype=dtype)
        for name, values in zip(dtype.names or (), piece, strict=True):
            table[name] = values
        stream.write(table.data)
        rows += len(table)

    with path.open("wb") as stream:
        stream.write(_npy_head(dtype, 0))
        yield put
        stream.seek(0)
        stream.write(_npy_head(dtype, rows))


def _npy_head(dtype: np.dtype[Any], rows: int) -> bytes:
    """The head of an array of so many rows; as long for any number, since NumPy leaves room for it."""
    memory = io.BytesIO()
    np.save(memory, np.empty(0, dtype=dtype), allow_pickle=False)
    empty = memory.getvalue()
    before, mark, _ = empty.rpartition(b"(0,)")
    written = before + mark.replace(b"0", str(rows).encode()) + b", }"
    if len(written) >= len(empty):
        raise OverflowError(f"the head of an array has no room for {rows} rows")
    return written + b" " * (len(empty) - len(written) - 1) + b"\n"


@contextlib.contextmanager
def _npz(path: Path, columns: Sequence[tuple[str, str]]) -> Iterator[Put]:
    """One array a column, named with its unit; they lie in files of their own until all rows are there."""
    headers = headers_of(columns)
    dtype = np.dtype("<f8")
    rows = 0
    folder = path.with_name(path.name + PARTS)
    folder.mkdir()
    with contextlib.ExitStack() as open_:
        open_.callback(shutil.rmtree, folder, ignore_errors=True)
        parts = [folder / str(k) for k in range(len(headers))]
        streams = [open_.enter_context(part.open("wb")) for part in parts]

        def put(piece: Piece) -> None:
            nonlocal rows
            for stream, values in zip(streams, piece, strict=True):
                stream.write(np.ascontiguousarray(values, dtype=dtype).data)
            rows += len(piece[0])

        yield put
        for stream in streams:
            stream.close()
        with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
            for header, part in zip(headers, parts, strict=True):
                member = zipfile.ZipInfo(f"{header}.npy")  # of 1980: the same numbers give the same bytes
                with archive.open(member, "w", force_zip64=True) as packed, part.open("rb") as stored:
                    packed.write(_npy_head(dtype, rows))
                    shutil.copyfileobj(stored, packed, 1 << 20)
                part.unlink()


@contextlib.contextmanager
def _parquet(path: Path, columns: Sequence[tuple[str, str]]) -> Iterator[Put]:
    """Columns named with their unit, pages with checksums."""
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise _lacking("parquet", ".parquet") from None
    schema = pa.schema([pa.field(header, pa.float64(), nullable=False) for header in headers_of(columns)])
    with pq.ParquetWriter(path, schema, use_dictionary=False, compression="snappy", write_page_checksum=True) as writer:

        def put(piece: Piece) -> None:
            writer.write_batch(pa.record_batch([pa.array(values) for values in piece], schema=schema), _ROWS)

        yield put


@contextlib.contextmanager
def _hdf5(path: Path, columns: Sequence[tuple[str, str]]) -> Iterator[Put]:
    """A dataset a column, with its unit as an attribute and checksums."""
    try:
        import h5py
    except ImportError:
        raise _lacking("hdf5", ".h5") from None
    _refuse([(name, "") for name, _ in columns], "/")
    if "." in (name for name, _ in columns):  # the group itself
        raise DataError("the channel '.' cannot be written in this format, because of its name")
    with Hdf5Table(h5py, path, columns).writing() as put:
        yield put


WRITERS: dict[str, Callable[[Path, Sequence[tuple[str, str]]], contextlib.AbstractContextManager[Put]]] = {
    ".csv": _csv,
    ".csv.gz": _csv_gz,
    ".npy": _npy,
    ".npz": _npz,
    ".parquet": _parquet,
    ".h5": _hdf5,
}
"""By the ending of the file's name. Columns are named with their units, as ``"gyro_x [rad/s]"``; in HDF5 by attributes."""


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
