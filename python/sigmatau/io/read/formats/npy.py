"""NumPy files: .npy, an array that stays in the file, and .npz, a zip archive of arrays."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import IO, Any, Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError, printable
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import UnreadArrays
from sigmatau.frozen import frozen
from sigmatau.io.read.formats.arrays import parts, pick, table_of_columns
from sigmatau.io.read.formats.damage import (
    archive_ends,
    damaged,
    fault,
    library_faults,
    refuse_expansion,
    trailing_bytes,
)
from sigmatau.io.read.table import Column, Head, Table
from sigmatau.record.on_disk import FileRows
from sigmatau.record.record import MIN_SAMPLES

_NPY = b"\x93NUMPY"
_ZIP = b"PK\x03\x04"
_LONGEST_HEADER = 10_000  # largest header, as in NumPy [bytes]
_MAX_COLUMNS = 64  # an array with more columns than this and than rows is probably transposed


def sniff(head: bytes, path: Path) -> bool:
    """Whether the file is .npy, or a zip archive of .npy files."""
    if head.startswith(_NPY):
        return True
    if not head.startswith(_ZIP):
        return False
    # The header of the first member has its name; the directory at the end of the archive is read later.
    length = int.from_bytes(head[26:28], "little")
    return head[30 : 30 + length].endswith(b".npy") or path.suffix == ".npz"


def read(path: Path, head: Head) -> tuple[Table]:
    """The columns of an array of shape (n, C), of a structured array, or of the arrays of an archive. In an archive an
    array of shape (n,) is a column, and an array of shape (n, 3) is three: ``gyro`` gives ``gyro_x``, ``gyro_y`` and
    ``gyro_z``.
    """
    return (_npz(path) if head.data.startswith(_ZIP) else _npy(path),)


@frozen
class _Array:
    """An array in a file."""

    path: Path
    shape: tuple[int, ...]
    order: Literal["C", "F"]
    dtype: np.dtype[Any]
    start: int  # offset of the first number [bytes]

    @classmethod
    def read_header(cls, path: Path, stream: IO[bytes]) -> _Array:
        shape, order, dtype = _header(stream)
        return cls(path=path, shape=shape, order=order, dtype=dtype, start=stream.tell())

    @property
    def row(self) -> int:
        """Size of a row. [bytes]"""
        return self.dtype.itemsize * int(np.prod(self.shape[1:], dtype=object))

    @property
    def end(self) -> int:
        return self.start + self.row * (self.shape[0] if self.shape else 1)

    def columns(self) -> Callable[[str | None, tuple[int, ...]], NDArray[Any]]:
        """The columns by field and part; they stay in the file."""
        count = self.shape[0]
        if self.order == "F" and len(self.shape) == 2:
            step = count * self.dtype.itemsize
            return lambda _, part: FileRows(self.path, self.dtype, count, self.start + part[0] * step).column()
        row = np.dtype((self.dtype, self.shape[1:])) if len(self.shape) == 2 else self.dtype
        rows = FileRows(self.path, row, count, self.start)
        return lambda field, part: rows.column(field, part[0] if part else None)


def _npy(path: Path) -> Table:
    arrays, findings = _series(path)
    array = arrays[0]
    if array.dtype.hasobject:
        raise DataError(f"{path.name} holds Python objects, which are refused; save plain numbers")
    _refuse_shape(array.shape)
    places: list[tuple[str | None, tuple[int, ...]]] = []
    names: list[str] = []
    if array.dtype.names:
        if len(array.shape) != 1:
            raise DataError(f"has a structured array of shape {array.shape}; (n,) is needed, one element per sample")
        for name in array.dtype.names:
            for label, part in parts(name, array.dtype[name].shape):
                names.append(label)
                places.append((name, part))
    else:
        for _, part in parts("", array.shape[1:]):
            names.append("")
            places.append((None, part))
    column_loaders = [each.columns() for each in arrays]
    loaders = [lambda place=place: _joined([column(*place) for column in column_loaders]) for place in places]
    note = f"array of {array.dtype.base.name if not array.dtype.names else 'records'}, shape {array.shape}"
    if len(arrays) > 1:
        rows = sum(each.shape[0] for each in arrays)
        note = f"{len(arrays)} arrays, one after the other, {rows} rows in all; the first an {note}"
    return _table("npy", [Column(name=name) for name in names], loaders, (note,), findings)


def _series(path: Path) -> tuple[list[_Array], tuple[Finding, ...]]:
    """Read the arrays of a file, all of one type. ``np.save`` to an open file appends arrays; `np.load` returns only the
    first.
    """
    size = path.stat().st_size
    with path.open("rb") as stream:
        with library_faults(_damaged):
            first = _Array.read_header(path, stream)
        if first.dtype.hasobject:
            return [first], ()
        if first.end > size:
            return _keep_whole_rows(first, size)
        arrays = [first]
        with contextlib.suppress(ValueError):  # raised by NumPy if no header follows
            while arrays[-1].end < size:
                stream.seek(arrays[-1].end)
                array = _Array.read_header(path, stream)
                alike = array.dtype == first.dtype and array.shape and array.shape[1:] == first.shape[1:]
                if not alike or array.end > size or array.end == arrays[-1].end:
                    break
                arrays.append(array)
    what = "the array" if len(arrays) == 1 else f"the {len(arrays)} arrays"
    return arrays, trailing_bytes(path, arrays[-1].end, what)


def _keep_whole_rows(array: _Array, size: int) -> tuple[list[_Array], tuple[Finding, ...]]:
    """Cut a truncated array to its complete rows. Raises `DataError` if there are none, or if it is stored by columns."""
    rows = (size - array.start) // max(array.row, 1)
    if not array.shape or (array.order == "F" and len(array.shape) > 1) or not MIN_SAMPLES <= rows < array.shape[0]:
        raise _damaged(ValueError(f"{size} bytes, but {array.end} are declared"))
    cut = fault(truncated=True, what="array", kept=rows, declared=array.shape[0])
    return [replace(array, shape=(rows, *array.shape[1:]))], (cut,)


def _joined(pieces: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Join the pieces of a column. A single piece stays in its file."""
    return pieces[0] if len(pieces) == 1 else np.concatenate(pieces)


def _npz(path: Path) -> Table:
    columns: list[Column] = []
    loaders: list[Callable[[], NDArray[Any]]] = []
    refused: list[str] = []
    with library_faults(_damaged):
        import zipfile  # in the call, to keep the reading of text fast

        with zipfile.ZipFile(path) as archive:
            first = min((m.header_offset for m in archive.infolist()), default=0)
            names = [n for n in archive.namelist() if n.endswith(".npy")]
            unread = tuple(
                printable(member.orig_filename.replace("\0", ""))
                for member in archive.infolist()
                if not (member.filename.endswith(".npy") or member.filename.endswith("/"))
            )
            for name in names:
                with archive.open(name) as member:
                    shape, _, dtype = _header(member)
                key = name.removesuffix(".npy")
                if dtype.hasobject or dtype.names or dtype.kind not in "iufb":
                    refused.append(key)
                elif 1 <= len(shape) <= 2 and shape[0] > 1:
                    for label, part in parts(key, shape[1:]):
                        columns.append(Column(name=label))
                        loaders.append(partial(_read_member, path, name, part))
    if not names:
        raise DataError("is a zip archive without .npy arrays, not a format that is read: text tables, .npy, .npz")
    if not columns:
        why = f" ({', '.join(refused)} hold objects or words, which are refused)" if refused else ""
        raise DataError(f"has no array of numbers of shape (n,) or (n, 3){why}")
    return _table(
        "npz",
        columns,
        loaders,
        (f"archive of {', '.join(n.removesuffix('.npy') for n in names)}",),
        (
            *archive_ends(path, first),
            *((Finding(details=UnreadArrays(names=unread), severity="warning"),) if unread else ()),
        ),
    )


def _read_member(path: Path, name: str, part: tuple[int, ...]) -> NDArray[Any]:
    """Read one column of a member of an archive. The array is decompressed again for each column and not kept in memory."""
    import zipfile

    with zipfile.ZipFile(path) as archive, archive.open(name) as member:
        refuse_expansion(path.stat().st_size, archive.getinfo(name).file_size, name)
        # The member is read to its end, where zipfile verifies the checksum; read_array stops before the end.
        array: NDArray[Any] = np.lib.format.read_array(io.BytesIO(member.read()), allow_pickle=False)
    return np.ascontiguousarray(pick(array, part))


def _table(
    kind: str,
    columns: Sequence[Column],
    loaders: Sequence[Callable[[], NDArray[Any]]],
    notes: tuple[str, ...],
    findings: tuple[Finding, ...],
) -> Table:
    return table_of_columns(kind, columns, [library_faults(_damaged)(load) for load in loaders], notes, findings)


def _header(member: IO[bytes]) -> tuple[tuple[int, ...], Literal["C", "F"], np.dtype[Any]]:
    """Shape, order and type of the array that begins here."""
    version = np.lib.format.read_magic(member)
    count = int.from_bytes(member.read(2 if version == (1, 0) else 4), "little")
    text = member.read(min(count, _LONGEST_HEADER + 1))
    if len(text) > _LONGEST_HEADER:
        raise DataError(f"has a header of {count} bytes, and at most {_LONGEST_HEADER} are read; save plain numbers")
    # Version 3 is version 2 in UTF-8, which is the same if no name is beyond Latin-1.
    head = text.decode("utf-8" if version == (3, 0) else "latin-1").encode("latin-1", "backslashreplace")
    shape, fortran, dtype = np.lib.format.read_array_header_2_0(io.BytesIO(len(head).to_bytes(4, "little") + head))
    if min(shape, default=0) < 0:
        raise ValueError(f"shape {shape}")
    return shape, "F" if fortran else "C", dtype


def _refuse_shape(shape: tuple[int, ...]) -> None:
    if len(shape) not in (1, 2):
        raise DataError(f"has an array of shape {shape}; (n,) or (n, columns) is needed")
    if 0 in shape[1:]:
        raise DataError(f"has an array of shape {shape}, without numbers")
    if len(shape) == 2 and shape[1] > max(shape[0], _MAX_COLUMNS):
        raise DataError(
            f"has an array of shape {shape}, more columns than rows; save its transpose, one row per sample"
        )


def _damaged(error: Exception) -> DataError:
    if "allow_pickle" in str(error) or "Object arrays" in str(error):
        return DataError("holds Python objects, which are refused; save plain numbers")
    return damaged(error)
