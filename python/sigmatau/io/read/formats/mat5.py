"""Version 5 of MATLAB's files, and 6 and 7: its published layout (MathWorks, "MAT-File Format", R2023b).

Each declared size is checked against the bytes that are there before memory is taken; numbers that are not compressed stay
on disk until they are used.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.io.read.formats.arrays import Leaf, squeezed
from sigmatau.io.read.table import REST_MISSING

__all__ = ["TABLES", "Found", "damage", "walk"]

TABLES = ("table", "timetable", "duration", "datetime")
"""Classes that mat-io turns into frames and times."""

_HEADER = 128
_MATRIX, _COMPRESSED = 14, 15
_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_CELL, _STRUCT, _OBJECT, _CHAR, _SPARSE = range(1, 6)
_NUMERIC = range(6, 16)
_OPAQUE = 17
_COMPLEX, _LOGICAL = 0x0800, 0x0200
_PEEK = 1 << 12  # holds the header of a variable. [bytes]
_DEEP = 16
_ELEMENTS = 16  # of an array of structs
_RATES = ("rate", "sample_rate", "samplerate", "sampling_rate", "fs", "freq", "frequency", "dt", "ts")


class _BrokenError(Exception):
    """A declared size does not fit; the words say which."""


class Found:
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


def walk(path: Path, head: bytes, found: Found) -> None:
    """All variables of a file; what is damaged is noted as a finding."""
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
            found.findings.append(damage(f"at byte {at} no variable begins (type {kind}); nothing behind it is read"))
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
                found.findings.append(damage(f"variable {name or f'at byte {at}'} is damaged: it {error}"))
        at = following


def damage(message: str) -> Finding:
    """A variable that cannot be read."""
    return Finding(code="damaged", severity="error", message=message, effect=REST_MISSING)


def _variable(path: Path, element: _Bytes, *, compressed: bool, found: Found) -> None:
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


def _collect(matrix: _Matrix, above: tuple[str, ...], found: Found, depth: int) -> None:
    """The arrays of numbers of a variable, or of a field of a struct whose name `above` ends with."""
    names = above if depth else (matrix.name,)
    label = ".".join(names)
    if matrix.kind in _NUMERIC and not matrix.flags & (_COMPLEX | _LOGICAL):
        array = _array(matrix)  # a view, so nothing is read yet
        found.add(names, matrix.dims, lambda: array)
    elif matrix.kind == _STRUCT and depth < _DEEP:
        _fields(matrix, names, found, depth)
    elif matrix.kind == _OPAQUE:
        if depth == 0 and _class_name(matrix) in TABLES:
            found.opaque.append(matrix.name)
        else:
            found.skipped.append(f"{label} ({_class_name(matrix) or 'an object'})")
    elif matrix.kind != _CHAR:
        found.skipped.append(label)


def _fields(matrix: _Matrix, names: tuple[str, ...], found: Found, depth: int) -> None:
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
