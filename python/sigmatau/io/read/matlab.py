"""MATLAB's files: version 5 (and 6, 7), which is read here, and 7.3, which is HDF5; tables and timetables by mat-io.

The layout of version 5 is published (MathWorks, "MAT-File Format", R2023b). Its own reader here checks each declared size
against the bytes that are there before memory is taken; numbers that are not compressed stay on disk until they are used.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.io.read import hdf5
from sigmatau.io.read.parts import Leaf, gather, squeezed
from sigmatau.io.read.table import REST_MISSING, Head, Table, need
from sigmatau.results import Finding

__all__ = ["read", "sniff"]

_HEADER = 128
_HDF5_AT = 512
_MATRIX, _COMPRESSED = 14, 15
_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_CELL, _STRUCT, _OBJECT, _CHAR, _SPARSE = range(1, 6)
_NUMERIC = range(6, 16)
_OPAQUE = 17
_COMPLEX, _LOGICAL = 0x0800, 0x0200
_PEEK = 1 << 12  # holds the header of a variable. [bytes]
_DEEP = 16
_ELEMENTS = 16  # of an array of structs
_TABLES = ("table", "timetable", "duration", "datetime")
_RATES = ("rate", "sample_rate", "samplerate", "sampling_rate", "fs", "freq", "frequency", "dt", "ts")

_CLASSES_73 = frozenset(["double", "single", *(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64))])


class _BrokenError(Exception):
    """A declared size does not fit; the words say which."""


def sniff(head: bytes, path: Path) -> bool:
    """Whether the file is of version 5 or 7.3, by the marks at the end of its header."""
    return head[124:128] in (b"\x00\x01IM", b"\x01\x00MI") or head[_HDF5_AT : _HDF5_AT + 8] == b"\x89HDF\r\n\x1a\n"


def read(path: Path, head: Head) -> tuple[Table, ...]:
    """The tables of a file: the variables of one length together, and each struct, table and timetable by itself."""
    found = _Found()
    if head.data[_HDF5_AT : _HDF5_AT + 8] == b"\x89HDF\r\n\x1a\n":
        version = "7.3"
        _walk_73(path, found)
    else:
        version = "5"
        found.version_5 = True
        _walk_5(path, head.data, found)
    if found.opaque:
        _tables(path, found)
    notes = [f"MATLAB file, version {version}"]
    if version == "5" and found.plain:
        notes.append("without compression there is no checksum: a damaged number would not be seen")
    if found.skipped:
        notes.append(f"not numbers of shape (n,) or (n, k): {', '.join(found.skipped[:12])}")
    if not found.leaves:
        lost = "".join(f"; {finding.message}" for finding in found.findings)
        raise DataError(f"has no variable of numbers of shape (n, 1) or (n, k){lost}")
    return gather(
        found.leaves,
        kind="matlab",
        root="",
        separator=".",
        notes=(*notes, *found.notes),
        findings=tuple(found.findings),
    )


class _Found:
    """What a file holds, as it is found."""

    def __init__(self) -> None:
        self.leaves: list[Leaf] = []
        self.notes: list[str] = []
        self.skipped: list[str] = []
        self.findings: list[Finding] = []
        self.opaque: list[str] = []
        self.version_5 = False
        self.plain = False  # numbers without a checksum

    def add(self, names: tuple[str, ...], dims: tuple[int, ...], load: Callable[[], NDArray[Any]]) -> None:
        """An array of numbers, unless its shape is not that of columns; `load` gives it in the shape `dims`."""
        label = ".".join(names)
        if dims == (1, 1):
            if names[-1].lower() in _RATES:
                self.notes.append(f"{label} = {load().reshape(-1)[0]:g}: noted, not used")
            return
        found = squeezed(dims, lying=True)
        if found is None:
            self.skipped.append(f"{label} {dims}")
            return
        shape, transposed = found
        if transposed and len(shape) == 2:
            self.notes.append(f"{label}, shape {dims}, is read as its transpose")

        def turned() -> NDArray[Any]:
            array = load()
            return (array.T if transposed else array).reshape(shape)

        self.leaves.append(Leaf(group=names[:-1], name=names[-1], shape=shape, load=turned))


# ---- version 5 ----


@dataclass(frozen=True, slots=True)
class _Bytes:
    """Part of a file, or of what a variable is decompressed to; every step past its end is a `_BrokenError`."""

    data: NDArray[np.uint8]
    order: str

    def element(self, at: int) -> tuple[int, _Bytes, int]:
        """Type and data of the element at an offset, and where the next one begins."""
        if at + 8 > len(self.data):
            raise _BrokenError("ends where another element should begin")
        kind, size = struct.unpack_from(f"{self.order}II", self.data.data, at)
        if kind >> 16:  # up to four bytes stand in the tag itself
            kind, size = kind & 0xFFFF, kind >> 16
            start, following = at + 4, at + 8
            if size > 4:
                raise _BrokenError(f"has an element of {size} bytes where 4 have room")
        else:
            start = at + 8
            following = start + size + (-size % 8 if kind != _COMPRESSED else 0)
        if start + size > len(self.data):
            raise _BrokenError(f"has {len(self.data) - start} of {size} bytes")
        return kind, _Bytes(self.data[start : start + size], self.order), following

    def numbers(self, kind: int) -> NDArray[Any]:
        dtype = np.dtype(self.order + _TYPES[kind]) if kind in _TYPES else None
        if dtype is None or len(self.data) % dtype.itemsize:
            raise _BrokenError(f"has {len(self.data)} bytes of numbers of type {kind}")
        return self.data.view(dtype)

    def text(self) -> str:
        return self.data.tobytes().decode("latin-1").rstrip("\0")


@dataclass(frozen=True, slots=True)
class _Matrix:
    """The header of an array and what follows it."""

    kind: int
    flags: int
    dims: tuple[int, ...]
    name: str
    body: _Bytes
    at: int


def _walk_5(path: Path, head: bytes, found: _Found) -> None:
    order = "<" if head[126:128] == b"IM" else ">"
    size = path.stat().st_size
    if size <= _HEADER:
        raise DataError("ends after its header; get or make the file again")
    data = np.memmap(path, dtype=np.uint8, mode="r")
    file = _Bytes(data, order)
    at = _HEADER
    (subsystem,) = struct.unpack_from(f"{order}Q", data.data, 116)  # holds the contents of tables; no variable
    while at < size:
        if at + 8 <= size and (kind := struct.unpack_from(f"{order}I", data.data, at)[0]) not in (_MATRIX, _COMPRESSED):
            found.findings.append(_damage(f"at byte {at} no variable begins (type {kind}); nothing behind it is read"))
            return
        try:
            kind, element, following = file.element(at)
        except _BrokenError as error:
            name = _name_of(data[at:], order)
            found.findings.append(
                Finding(
                    code="broken_off",
                    severity="error",
                    message=f"the file breaks off at byte {size}: variable {name or 'at byte ' + str(at)} {error}",
                    effect=REST_MISSING,
                )
            )
            return
        if at != subsystem:
            try:
                _variable(path, element, compressed=kind == _COMPRESSED, found=found)
            except (_BrokenError, zlib.error, struct.error) as error:
                name = _name_of(data[at : at + 8 + len(element.data)], order)
                found.findings.append(_damage(f"variable {name or f'at byte {at}'} is damaged: it {error}"))
        at = following


def _damage(message: str) -> Finding:
    return Finding(code="damaged", severity="error", message=message, effect=REST_MISSING)


def _variable(path: Path, element: _Bytes, *, compressed: bool, found: _Found) -> None:
    """A variable of a file; of one that is compressed only the header, if it is an array of numbers."""
    if not compressed:
        found.plain = True
        _collect(_matrix(element), (), found, 0)
        return
    beginning = zlib.decompressobj().decompress(element.data[: 4 * _PEEK].tobytes(), _PEEK)
    if len(beginning) < 8:
        raise _BrokenError("is empty")
    kind, size = struct.unpack_from(f"{element.order}II", beginning)
    if kind != _MATRIX:
        raise _BrokenError(f"holds no array (type {kind})")
    if size > len(element.data) * 1100:  # the best that deflate can do
        raise _BrokenError(f"declares {size} bytes, compressed to {len(element.data)}")
    head = _matrix(_Bytes(np.frombuffer(beginning, np.uint8)[8:], element.order))
    if head.kind in _NUMERIC and not head.flags & (_COMPLEX | _LOGICAL) and head.name:
        if int(np.prod(head.dims, dtype=object)) > size:  # a number takes a byte at least
            raise _BrokenError(f"declares {head.dims} numbers in {size} bytes")

        def load() -> NDArray[Any]:
            try:
                return _array(_matrix(_unpacked(element, size)))
            except (_BrokenError, zlib.error) as error:
                raise DataError(f"variable {head.name} is damaged: {error}; get or make the file again") from None

        found.add((head.name,), head.dims, load)
    elif head.kind == _STRUCT:
        _collect(_matrix(_unpacked(element, size)), (), found, 0)
    else:
        _collect(head, (), found, 0)


def _unpacked(element: _Bytes, size: int) -> _Bytes:
    """A compressed variable, its checksum verified."""
    decoder = zlib.decompressobj()
    data = decoder.decompress(element.data.data, size + 8)
    if len(data) == size + 8 and not decoder.eof:
        decoder.decompress(decoder.unconsumed_tail, 1)  # what is left is the checksum
    if len(data) != size + 8 or not decoder.eof:
        raise _BrokenError(f"gives {len(data)} bytes where {size + 8} are declared, or lacks its checksum")
    return _Bytes(np.frombuffer(data, np.uint8)[8:], element.order)


def _matrix(content: _Bytes) -> _Matrix:
    """The header of an array, of which more need not be there."""
    kind, flags, at = content.element(0)
    if kind != 6 or len(flags.data) != 8:
        raise _BrokenError("has no flags")
    word = int(flags.numbers(6)[0])
    if word & 0xFF == _OPAQUE:
        _, name, at = content.element(at)
        return _Matrix(_OPAQUE, word, (), name.text(), content, at)
    kind, sizes, at = content.element(at)
    if kind != 5 or not 2 <= len(sizes.data) // 4 <= 32:
        raise _BrokenError("has no dimensions")
    dims = tuple(int(n) for n in sizes.numbers(5))
    if min(dims) < 0:
        raise _BrokenError(f"has the shape {dims}")
    _, name, at = content.element(at)
    return _Matrix(word & 0xFF, word, dims, name.text(), content, at)


def _array(matrix: _Matrix) -> NDArray[Any]:
    kind, data, _ = matrix.body.element(matrix.at)
    values = data.numbers(kind)
    if len(values) != int(np.prod(matrix.dims, dtype=object)):
        raise _BrokenError(f"has {len(values)} numbers for the shape {matrix.dims}")
    return values.reshape(matrix.dims, order="F")


def _collect(matrix: _Matrix, above: tuple[str, ...], found: _Found, depth: int) -> None:
    """The arrays of numbers of a variable, or of a field of a struct whose name `above` ends with."""
    names = above if depth else (matrix.name,)
    label = ".".join(names)
    if matrix.kind in _NUMERIC and not matrix.flags & (_COMPLEX | _LOGICAL):
        array = _array(matrix)  # a view, so nothing is read yet
        found.add(names, matrix.dims, lambda: array)
    elif matrix.kind == _STRUCT and depth < _DEEP:
        _fields(matrix, names, found, depth)
    elif matrix.kind == _OPAQUE:
        if depth == 0 and _class_name(matrix) in _TABLES:
            found.opaque.append(matrix.name)
        else:
            found.skipped.append(f"{label} ({_class_name(matrix) or 'an object'})")
    elif matrix.kind != _CHAR:
        found.skipped.append(label)


def _fields(matrix: _Matrix, names: tuple[str, ...], found: _Found, depth: int) -> None:
    content, at = matrix.body, matrix.at
    kind, width, at = content.element(at)
    if kind != 5 or len(width.data) != 4 or (length := int(width.numbers(5)[0])) <= 0:
        raise _BrokenError("has a struct without the length of its names")
    _, joined, at = content.element(at)
    if len(joined.data) % length:
        raise _BrokenError("has a struct with names of another length")
    fields = [
        joined.data[k : k + length].tobytes().split(b"\0")[0].decode("latin-1")
        for k in range(0, len(joined.data), length)
    ]
    count = int(np.prod(matrix.dims, dtype=object))
    if not fields or not count:
        return
    if count > _ELEMENTS:
        found.skipped.append(f"{'.'.join(names)} ({count} structs)")
        return
    for number in range(count):
        group = names if count == 1 else (*names[:-1], f"{names[-1]}({number + 1})")
        for field in fields:
            kind, inner, at = content.element(at)
            if kind != _MATRIX:
                raise _BrokenError(f"has no array for {'.'.join((*group, field))}")
            if len(inner.data):
                _collect(_matrix(inner), (*group, field), found, depth + 1)


def _class_name(matrix: _Matrix) -> str:
    """The class of an object: the second of the words after its name."""
    _, _, at = matrix.body.element(matrix.at)
    _, name, _ = matrix.body.element(at)
    return name.text()


def _name_of(data: NDArray[np.uint8], order: str) -> str:
    """The name of a variable of which only the beginning is there; empty if it cannot be told."""
    try:
        content = data[8 : 8 + _PEEK]
        if struct.unpack_from(f"{order}I", data.data)[0] == _COMPRESSED:
            content = np.frombuffer(zlib.decompressobj().decompress(content.tobytes(), _PEEK), np.uint8)[8:]
        return _matrix(_Bytes(content, order)).name
    except (_BrokenError, zlib.error, struct.error):
        return ""


# ---- version 7.3 ----


def _walk_73(path: Path, found: _Found) -> None:
    with hdf5.open_file(path) as file:
        try:
            for name, item in file.items():
                kind = hdf5.word(item, "MATLAB_class")
                if kind in _TABLES and "MATLAB_object_decode" in item.attrs:
                    found.opaque.append(name)
            for names, dataset in hdf5.walk(file):
                if names[0].startswith("#") or names[0] in found.opaque:
                    continue
                kind = hdf5.word(dataset, "MATLAB_class")
                if dataset.shape is None or "MATLAB_empty" in dataset.attrs or kind == "char":
                    continue
                if dataset.dtype.kind not in "iuf" or kind not in (None, *_CLASSES_73):
                    found.skipped.append(".".join(names))
                    continue
                # Of n columns and m rows HDF5 has m columns and n rows.
                dims = tuple(int(n) for n in reversed(dataset.shape))
                found.add(names, dims, hdf5.loader(path, names, transposed=True))
        except DataError:
            raise
        except MemoryError:
            raise
        except Exception as error:
            raise hdf5.damaged(error) from None


# ---- tables and timetables, of both versions ----


def _tables(path: Path, found: _Found) -> None:
    matio = need("matio", "matlab", "a MATLAB file with a table")
    if not found.version_5:
        hdf5.check_heaps(path)
    import warnings

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about time zones and formats of display
            held = matio.load_from_mat(str(path), variable_names=list(found.opaque), add_table_attrs=True)
    except MemoryError:
        raise
    except Exception as error:
        text = str(error).split("\n")[0] or type(error).__name__
        names = ", ".join(found.opaque)
        found.findings.append(_damage(f"{names} cannot be read: {text}"))
        return
    for name in found.opaque:
        value = held.get(name)
        if hasattr(value, "columns") and hasattr(value, "attrs"):
            found.leaves.extend(_of_frame(name, value, found))
        elif isinstance(value, np.ndarray) and value.dtype.kind in "mM" and value.size == max(value.shape):
            found.leaves.append(_leaf((), name, _nanoseconds(value.reshape(-1)), "ns"))
        else:
            found.skipped.append(name)


def _of_frame(name: str, frame: Any, found: _Found) -> Iterator[Leaf]:  # noqa: ANN401  pandas has no types here
    times = frame.index.to_numpy()
    if times.dtype.kind in "mM":
        yield _leaf((name,), str(frame.index.name or "Time"), _nanoseconds(times), "ns")
    variables = _variables([str(column) for column in frame.columns])
    units = [str(unit) for unit in frame.attrs.get("VariableUnits") or frame.attrs.get("varUnits") or ()]
    if units and len(units) != len(set(variables.values())):
        found.notes.append(f"{name}: its units are not used, which are {len(units)} for {len(frame.columns)} columns")
        units = []
    stems = list(dict.fromkeys(variables.values()))
    for k, (column, stem) in enumerate(variables.items()):
        values = frame.iloc[:, k].to_numpy()
        unit = units[stems.index(stem)] if units else ""
        label = column
        if [v for v in variables.values() if v == stem] == [stem] * 3:
            label = f"{stem}_{'xyz'[int(column[-1]) - 1]}"
        if values.dtype.kind in "mM":
            yield _leaf((name,), label, _nanoseconds(values), "ns")
        elif values.dtype.kind in "iuf":
            yield _leaf((name,), label, values, unit or None)
        else:
            found.skipped.append(f"{name}.{column}")


def _variables(columns: list[str]) -> dict[str, str]:
    """The variable that each column is of: mat-io splits one of three columns into ``gyro_1``, ``gyro_2``, ``gyro_3``."""
    variables = {column: column for column in columns}
    for column in columns:
        stem = column.removesuffix("_1")
        if stem != column and f"{stem}_2" in columns:
            k = 1
            while f"{stem}_{k}" in columns:
                variables[f"{stem}_{k}"] = stem
                k += 1
    return variables


def _nanoseconds(values: NDArray[Any]) -> NDArray[np.int64]:
    unit = "timedelta64[ns]" if values.dtype.kind == "m" else "datetime64[ns]"
    return values.astype(unit).astype(np.int64)


def _leaf(group: tuple[str, ...], name: str, values: NDArray[Any], unit: str | None) -> Leaf:
    return Leaf(group=group, name=name, shape=values.shape, load=lambda: values, unit=unit)
