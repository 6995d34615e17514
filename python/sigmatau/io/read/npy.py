"""NumPy's own files: .npy, an array on disk that is not loaded whole, and .npz, several of them in a zip archive."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.io.read.parts import parts, pick
from sigmatau.io.read.table import Column, Head, Loaded, Table, refuse_infinite, whole_stamps

__all__ = ["read", "sniff"]

_NPY = b"\x93NUMPY"
_ZIP = b"PK\x03\x04"
_MANY = 64  # more columns than rows, and than this: the array lies on its side


def sniff(head: bytes, path: Path) -> bool:
    """Whether the file is .npy, or a zip archive of such."""
    if head.startswith(_NPY):
        return True
    if not head.startswith(_ZIP):
        return False
    # The name of the first member stands in its header; the directory of all, at the end, is read later.
    length = int.from_bytes(head[26:28], "little")
    return head[30 : 30 + length].endswith(b".npy") or path.suffix == ".npz"


def read(path: Path, head: Head) -> tuple[Table]:
    """The columns of an array of shape (n, C), of a structured array, or of the arrays of an archive.

    In an archive each one-dimensional array is a column, and each of shape (n, 3) three: ``gyro`` gives ``gyro_x``,
    ``gyro_y`` and ``gyro_z``.

    Parameters
    ----------
    path : Path
    head : Head

    Raises
    ------
    DataError
        If the file is damaged, or holds no columns of numbers; by ``load``: for arrays of unequal length;
        `NonFiniteError` for an infinity.
    """
    return (_npz(path) if head.data.startswith(_ZIP) else _npy(path),)


def _npy(path: Path) -> Table:
    try:
        array = np.load(path, mmap_mode="r", allow_pickle=False)
    except (OSError, MemoryError):
        raise
    except Exception as error:  # NumPy, zipfile and zlib raise a dozen kinds on damaged files
        raise _damaged(error) from None
    _refuse_objects(array.dtype, path.name)
    loaders: list[Callable[[], NDArray[Any]]] = []
    if array.dtype.names:
        if array.ndim != 1:
            raise DataError(f"has a structured array of shape {array.shape}; one dimension is wanted, a sample each")
        columns = []
        for name in array.dtype.names:
            for label, part in parts(name, array.dtype[name].shape):
                columns.append(Column(name=label))
                loaders.append(lambda name=name, part=part: pick(array[name], part))  # type: ignore[misc]
    else:
        columns = []
        _refuse_shape(array.shape)
        for _, part in parts("", array.shape[1:]):
            columns.append(Column(name=""))
            loaders.append(lambda part=part: pick(array, part))  # type: ignore[misc]
    note = f"array of {array.dtype.base.name if not array.dtype.names else 'records'}, shape {array.shape}"
    return _table("npy", columns, loaders, (note,))


def _npz(path: Path) -> Table:
    columns: list[Column] = []
    loaders: list[Callable[[], NDArray[Any]]] = []
    refused: list[str] = []
    try:
        import zipfile  # in the call, for those who read text

        with zipfile.ZipFile(path) as archive:
            names = [n for n in archive.namelist() if n.endswith(".npy")]
            for name in names:
                with archive.open(name) as member:
                    shape, dtype = _header(member)
                key = name.removesuffix(".npy")
                if dtype.hasobject or dtype.names or dtype.kind not in "iufb":
                    refused.append(key)
                elif 1 <= len(shape) <= 2 and shape[0] > 1:
                    for label, part in parts(key, shape[1:]):
                        columns.append(Column(name=label))
                        loaders.append(_Member(path, name, part))
    except (OSError, MemoryError):
        raise
    except Exception as error:  # NumPy, zipfile and zlib raise a dozen kinds on damaged files
        raise _damaged(error) from None
    if not names:
        raise DataError("is a zip archive without .npy arrays, not a format that is read: text tables, .npy, .npz")
    if not columns:
        why = f" ({', '.join(refused)} hold objects or words, which are refused)" if refused else ""
        raise DataError(f"has no array of numbers of shape (n,) or (n, 3){why}")
    return _table("npz", columns, loaders, (f"archive of {', '.join(n.removesuffix('.npy') for n in names)}",))


class _Member:
    """One column of an archive; an array of three columns is decompressed once for each, and not kept."""

    def __init__(self, path: Path, name: str, part: tuple[int, ...]) -> None:
        self.path, self.name, self.part = path, name, part

    def __call__(self) -> NDArray[Any]:
        import zipfile

        with zipfile.ZipFile(self.path) as archive, archive.open(self.name) as member:
            array: NDArray[Any] = np.lib.format.read_array(_Whole(member), allow_pickle=False)
        return np.ascontiguousarray(pick(array, self.part))


class _Whole(io.RawIOBase):
    """A member of an archive whose checksum is verified: read_array stops before the end, where zipfile looks."""

    def __init__(self, member: IO[bytes]) -> None:
        self._data = io.BytesIO(member.read())

    def read(self, size: int = -1, /) -> bytes:
        return self._data.read(size)


def _table(
    kind: str, columns: Sequence[Column], loaders: Sequence[Callable[[], NDArray[Any]]], notes: tuple[str, ...]
) -> Table:
    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        raw: dict[int, NDArray[Any]] = {}
        for index in wanted:
            name = columns[index].name or f"number {index + 1}"
            try:
                array = loaders[index]()
            except (OSError, MemoryError):
                raise
            except Exception as error:  # NumPy, zipfile and zlib raise a dozen kinds on damaged files
                raise _damaged(error) from None
            if array.dtype.kind not in "iuf":
                raise DataError(f"column {name} holds {array.dtype}, not real numbers")
            refuse_infinite(array, name)
            raw[index] = array
        lengths = {len(array) for array in raw.values()}
        if len(lengths) > 1:
            listed = ", ".join(f"{columns[i].name} {len(a)}" for i, a in raw.items())
            raise DataError(f"its arrays are of unequal length ({listed}); cut them alike, or choose by --channels")
        if exact is not None:
            raw[exact] = whole_stamps(raw[exact])
        return Loaded(columns=raw)

    return Table(format=kind, columns=tuple(columns), notes=notes, load=load, where=lambda row: f"row {row}")


def _header(member: IO[bytes]) -> tuple[tuple[int, ...], np.dtype[Any]]:
    version = np.lib.format.read_magic(member)
    if version == (1, 0):
        shape, _, dtype = np.lib.format.read_array_header_1_0(member)
    else:
        shape, _, dtype = np.lib.format.read_array_header_2_0(member)
    return shape, dtype


def _refuse_objects(dtype: np.dtype[Any], name: str) -> None:
    if dtype.hasobject:
        raise DataError(f"{name} holds Python objects, which are refused; save plain numbers")


def _refuse_shape(shape: tuple[int, ...]) -> None:
    if len(shape) not in (1, 2):
        raise DataError(f"has an array of shape {shape}; (n,) or (n, columns) is wanted")
    if len(shape) == 2 and shape[1] > max(shape[0], _MANY):
        raise DataError(f"has an array of shape {shape}, more columns than rows; save its transpose, a sample a row")


def _damaged(error: Exception) -> DataError:
    text = str(error).split("\n")[0]
    if "allow_pickle" in text or "Object arrays" in text:
        return DataError("holds Python objects, which are refused; save plain numbers")
    return DataError(f"is damaged or cut off ({text or type(error).__name__}); get or make the file again")
