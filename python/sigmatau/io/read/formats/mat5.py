"""MATLAB files of versions 5, 6 and 7, by the published layout (MathWorks, "MAT-File Format", R2023b).

Each declared size is compared with the bytes of the file before memory is allocated. Numbers that are not compressed are
mapped, so that they stay on disk until they are used. `docs/decisions/0003-own-parsers.md` says why scipy.io is not used.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import Place
from sigmatau.frozen import frozen
from sigmatau.io.read.formats.arrays import Leaf, squeezed
from sigmatau.io.read.formats.damage import fault, refuse_expansion
from sigmatau.record.on_disk import file_bytes

TABLES = ("table", "timetable", "duration", "datetime")  # Classes that mat-io converts to data frames and times
_HEADER = 128
_MATRIX, _COMPRESSED = 14, 15
_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_CELL, _STRUCT, _OBJECT, _CHAR, _SPARSE = range(1, 6)
_NUMERIC = range(6, 16)
_OPAQUE = 17
_COMPLEX = 0x0800
_LOGICAL = 0x0200
_HEADER_OF_VARIABLE = 1 << 12  # sufficient for the header of a variable [bytes]
_BEST_COMPRESSION = 1100  # the largest ratio that deflate reaches is 1032
_DEEPEST = 16  # largest depth of nested structs
_MAX_STRUCTS = 16  # largest number of structs in an array


class _BrokenError(Exception):
    """A variable that cannot be decoded; the text is the reason."""


class MatContents:
    """Contents of a file, collected while it is read."""

    def __init__(self) -> None:
        self.leaves: list[Leaf] = []
        self.notes: list[str] = []
        self.skipped: list[str] = []
        self.findings: list[Finding] = []
        self.opaque: list[str] = []
        self.version_5 = False
        self.plain = False  # whether there are numbers without a checksum

    def add(self, names: tuple[str, ...], dims: tuple[int, ...], load: Callable[[], NDArray[Any]]) -> None:
        """Add an array of numbers if it has the shape of columns; `load` returns it in the shape `dims`."""
        label = ".".join(names)
        if dims == (1, 1):
            return
        squeezed_dims = squeezed(dims, rows_allowed=True)
        if squeezed_dims is None:
            self.skipped.append(f"{label} {dims}")
            return
        shape, transposed = squeezed_dims
        if transposed and len(shape) == 2:
            self.notes.append(f"{label}, shape {dims}, is read as its transpose")

        def transposed_array() -> NDArray[Any]:
            array = load()
            return (array.T if transposed else array).reshape(shape)

        self.leaves.append(Leaf(group=names[:-1], name=names[-1], shape=shape, load=transposed_array))


@frozen(kw_only=False)
class _Bytes:
    """Part of a file or of a decompressed variable; an access past its end raises `_BrokenError`."""

    data: NDArray[np.uint8]
    order: str

    def element(self, offset: int) -> tuple[int, _Bytes, int]:
        """Type and data of the element at an offset, and the offset of the next element."""
        if offset + 8 > len(self.data):
            raise _BrokenError(f"{len(self.data)} of {offset + 8} bytes")
        kind, size = struct.unpack_from(f"{self.order}II", self.data.data, offset)
        if kind >> 16:  # the tag itself contains up to four bytes of data
            kind, size = kind & 0xFFFF, kind >> 16
            start, following = offset + 4, offset + 8
            if size > 4:
                raise _BrokenError(f"a short element of {size} bytes")
        else:
            start = offset + 8
            following = start + size + (-size % 8 if kind != _COMPRESSED else 0)
        if start + size > len(self.data):
            raise _BrokenError(f"{len(self.data) - start} of {size} bytes")
        return kind, _Bytes(self.data[start : start + size], self.order), following

    def numbers(self, kind: int) -> NDArray[Any]:
        dtype = np.dtype(self.order + _TYPES[kind]) if kind in _TYPES else None
        if dtype is None or len(self.data) % dtype.itemsize:
            raise _BrokenError(f"{len(self.data)} bytes of numbers of type {kind}")
        return self.data.view(dtype)

    def text(self) -> str:
        return self.data.tobytes().decode("latin-1").rstrip("\0")


@frozen(kw_only=False)
class _Matrix:
    """The header of an array, and the bytes after it."""

    kind: int
    flags: int
    dims: tuple[int, ...]
    name: str
    body: _Bytes
    offset: int


def walk(path: Path, head: bytes, contents: MatContents) -> None:
    """Collect all variables of a file; a damaged variable is a finding."""
    order = "<" if head[126:128] == b"IM" else ">"
    size = path.stat().st_size
    if size <= _HEADER:
        raise DataError("ends after its header; copy or record the file again")
    data = file_bytes(path)
    file = _Bytes(data, order)
    position = _HEADER
    (subsystem,) = struct.unpack_from(f"{order}Q", data.data, 116)  # contains the data of tables; not a variable
    while position < size:
        if position + 8 <= size and (kind := struct.unpack_from(f"{order}I", data.data, position)[0]) not in (
            _MATRIX,
            _COMPRESSED,
        ):
            contents.findings.append(
                fault(place=Place("byte", position), reason=f"type {kind} where a variable should begin")
            )
            return
        try:
            kind, element, following = file.element(position)
        except _BrokenError as error:
            what = _label(data[position:], order) or "file"
            contents.findings.append(fault(truncated=True, what=what, place=Place("byte", size), reason=str(error)))
            return
        if position != subsystem:
            try:
                _variable(path, element, compressed=kind == _COMPRESSED, contents=contents)
            except (_BrokenError, zlib.error, struct.error) as error:
                what = _label(data[position : position + 8 + len(element.data)], order) or "variable"
                contents.findings.append(fault(what=what, place=Place("byte", position), reason=str(error)))
        position = following


def _variable(path: Path, element: _Bytes, *, compressed: bool, contents: MatContents) -> None:
    """Collect a variable; of a compressed array of numbers only the header is read."""
    if not compressed:
        contents.plain = True
        _collect(_matrix(element), (), contents, 0)
        return
    beginning = zlib.decompressobj().decompress(element.data[: 4 * _HEADER_OF_VARIABLE].tobytes(), _HEADER_OF_VARIABLE)
    if len(beginning) < 8:
        raise _BrokenError(f"{len(beginning)} of 8 bytes")
    kind, size = struct.unpack_from(f"{element.order}II", beginning)
    if kind != _MATRIX:
        raise _BrokenError(f"type {kind} where an array should begin")
    if size > len(element.data) * _BEST_COMPRESSION:
        raise _BrokenError(f"{size} bytes declared, compressed to {len(element.data)}")
    head = _matrix(_Bytes(np.frombuffer(beginning, np.uint8)[8:], element.order))
    if head.kind in _NUMERIC and not head.flags & (_COMPLEX | _LOGICAL) and head.name:
        if int(np.prod(head.dims, dtype=object)) > size:  # a number takes at least one byte
            raise _BrokenError(f"{head.dims} numbers declared in {size} bytes")

        def load() -> NDArray[Any]:
            try:
                return _array(_matrix(_unpacked(element, size)))
            except (_BrokenError, zlib.error) as error:
                raise DataError(f"variable {head.name} is damaged: {error}; copy or record the file again") from None

        contents.add((head.name,), head.dims, load)
    elif head.kind == _STRUCT:
        _collect(_matrix(_unpacked(element, size)), (), contents, 0)
    else:
        _collect(head, (), contents, 0)


def _unpacked(element: _Bytes, size: int) -> _Bytes:
    """Decompress a variable and verify its checksum. Raises `DataError` if it unpacks to more than is allowed."""
    refuse_expansion(len(element.data), size, "a variable")
    decoder = zlib.decompressobj()
    data = decoder.decompress(element.data.data, size + 8)
    if len(data) == size + 8 and not decoder.eof:
        decoder.decompress(decoder.unconsumed_tail, 1)  # only the checksum is left
    if len(data) != size + 8 or not decoder.eof:
        raise _BrokenError(f"decompressed to {len(data)} of {size + 8} bytes, or without its checksum")
    return _Bytes(np.frombuffer(data, np.uint8)[8:], element.order)


def _matrix(content: _Bytes) -> _Matrix:
    """Decode the header of an array; the bytes after it may be missing."""
    kind, flags, offset = content.element(0)
    if kind != 6 or len(flags.data) != 8:
        raise _BrokenError("no flags")
    word = int(flags.numbers(6)[0])
    if word & 0xFF == _OPAQUE:
        _, name, offset = content.element(offset)
        return _Matrix(_OPAQUE, word, (), name.text(), content, offset)
    kind, sizes, offset = content.element(offset)
    if kind != 5 or not 2 <= len(sizes.data) // 4 <= 32:
        raise _BrokenError("no dimensions")
    dims = tuple(int(n) for n in sizes.numbers(5))
    if min(dims) < 0:
        raise _BrokenError(f"shape {dims}")
    _, name, offset = content.element(offset)
    return _Matrix(word & 0xFF, word, dims, name.text(), content, offset)


def _array(matrix: _Matrix) -> NDArray[Any]:
    kind, data, _ = matrix.body.element(matrix.offset)
    values = data.numbers(kind)
    if len(values) != int(np.prod(matrix.dims, dtype=object)):
        raise _BrokenError(f"{len(values)} numbers for the shape {matrix.dims}")
    return values.reshape(matrix.dims, order="F")


def _collect(matrix: _Matrix, above: tuple[str, ...], contents: MatContents, depth: int) -> None:
    """Collect the arrays of numbers of a variable, or of the field of a struct whose names are `above`."""
    names = above if depth else (matrix.name,)
    label = ".".join(names)
    if matrix.kind in _NUMERIC and not matrix.flags & (_COMPLEX | _LOGICAL):
        array = _array(matrix)  # a view: nothing is read yet
        contents.add(names, matrix.dims, lambda: array)
    elif matrix.kind == _STRUCT and depth < _DEEPEST:
        _fields(matrix, names, contents, depth)
    elif matrix.kind == _OPAQUE:
        if depth == 0 and _class_name(matrix) in TABLES:
            contents.opaque.append(matrix.name)
        else:
            contents.skipped.append(f"{label} ({_class_name(matrix) or 'an object'})")
    elif matrix.kind != _CHAR:
        contents.skipped.append(label)


def _fields(matrix: _Matrix, names: tuple[str, ...], contents: MatContents, depth: int) -> None:
    content, offset = matrix.body, matrix.offset
    kind, width, offset = content.element(offset)
    if kind != 5 or len(width.data) != 4 or (length := int(width.numbers(5)[0])) <= 0:
        raise _BrokenError("a struct without the length of its names")
    _, joined, offset = content.element(offset)
    if len(joined.data) % length:
        raise _BrokenError("a struct with names of another length")
    fields = [
        joined.data[k : k + length].tobytes().split(b"\0")[0].decode("latin-1")
        for k in range(0, len(joined.data), length)
    ]
    count = int(np.prod(matrix.dims, dtype=object))
    if not fields or not count:
        return
    if count > _MAX_STRUCTS:
        contents.skipped.append(f"{'.'.join(names)} ({count} structs)")
        return
    for number in range(count):
        group = names if count == 1 else (*names[:-1], f"{names[-1]}({number + 1})")
        for field in fields:
            kind, inner, offset = content.element(offset)
            if kind != _MATRIX:
                raise _BrokenError(f"no array for {'.'.join((*group, field))}")
            if len(inner.data):
                _collect(_matrix(inner), (*group, field), contents, depth + 1)


def _class_name(matrix: _Matrix) -> str:
    """The class of an object: the second text after its name."""
    _, _, offset = matrix.body.element(matrix.offset)
    _, name, _ = matrix.body.element(offset)
    return name.text()


def _label(data: NDArray[np.uint8], order: str) -> str:
    """``"variable NAME"`` by the beginning of a variable; empty if it cannot be decoded."""
    try:
        content = data[8 : 8 + _HEADER_OF_VARIABLE]
        if struct.unpack_from(f"{order}I", data.data)[0] == _COMPRESSED:
            unpacked = zlib.decompressobj().decompress(content.tobytes(), _HEADER_OF_VARIABLE)
            content = np.frombuffer(unpacked, np.uint8)[8:]
        name = _matrix(_Bytes(content, order)).name
    except (_BrokenError, zlib.error, struct.error):
        return ""
    return name and f"variable {name}"
