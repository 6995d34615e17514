"""Tables written piece by piece, so that what is written need not fit in memory: one writer a format.

Each takes the columns' names and units, then pieces of all columns; the number of rows is not known before the end.
"""

from __future__ import annotations

import contextlib
import gzip
import io
import shutil
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import formats
from sigmatau.errors import DataError
from sigmatau.io.hdf5 import Hdf5Table

__all__ = ["WRITERS", "Piece", "Put", "headers_of"]

Piece = Sequence[NDArray[np.float64]]
"""A piece of every column, each of shape (n,)."""

Put = Callable[[Piece], None]
"""What takes the next piece."""

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
    with (
        tempfile.TemporaryDirectory(prefix=f"{path.name}.", dir=path.parent) as folder,
        contextlib.ExitStack() as open_,
    ):
        parts = [Path(folder) / str(k) for k in range(len(headers))]
        streams = [open_.enter_context(part.open("wb")) for part in parts]

        def put(piece: Piece) -> None:
            nonlocal rows
            for stream, values in zip(streams, piece, strict=True):
                stream.write(np.ascontiguousarray(values, dtype=dtype).data)
            rows += len(piece[0])

        yield put
        open_.close()
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
