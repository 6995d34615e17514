"""Sizes that the messages of an Arrow stream declare. The library allocates memory for them before it unpacks."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

_SCHEMA, _DICTIONARY, _BATCH = 1, 2, 3  # kinds of messages
_CONTINUED = 0xFFFFFFFF
_LONGEST_HEAD = 1 << 24  # largest size of the head of a message [bytes]


def next_unpacked(path: Path, start: int) -> int:
    """Declared unpacked size of the next batch and of the dictionaries before it. [bytes]

    The sum stops at an invalid message, which the library refuses. `start`: where the first of these messages begins
    [bytes].
    """
    total = 0
    with path.open("rb") as file:
        file.seek(start)
        try:
            while True:
                kind, size = _message(file)
                total += size
                if kind not in (_SCHEMA, _DICTIONARY):
                    return total
        except (struct.error, EOFError, OverflowError, OSError):
            return total


def _message(file: BinaryIO) -> tuple[int, int]:
    """Kind of the next message and the size that its buffers unpack to. Moves the file to the end of the message."""
    (length,) = struct.unpack("<I", file.read(4))
    if length == _CONTINUED:
        (length,) = struct.unpack("<I", file.read(4))
    if not 0 < length <= _LONGEST_HEAD:
        raise EOFError
    head = _FlatTable(head := file.read(length), struct.unpack_from("<I", head)[0])
    kind, body = head.number(1, "<B"), head.number(3, "<q")
    start = file.tell()
    size = 0
    batch = head.table(2) if kind in (_DICTIONARY, _BATCH) else None
    if kind == _DICTIONARY and batch is not None:
        batch = batch.table(1)
    if batch is not None:
        compressed = batch.place(3) is not None
        for offset, stored in batch.pairs(2):
            size += _declared(file, start + offset, stored) if compressed else max(stored, 0)
    file.seek(start + max(body, 0))
    return kind, size


def _declared(file: BinaryIO, start: int, stored: int) -> int:
    """Size of a compressed buffer, declared by the number before it, where −1 means that it is not compressed."""
    if stored < 8 or start < 0:
        return 0
    file.seek(start)
    (size,) = struct.unpack("<q", file.read(8))
    return stored if size < 0 else size


class _FlatTable:
    """A table of FlatBuffers; raises `struct.error` for an offset outside its bytes."""

    def __init__(self, data: bytes, start: int) -> None:
        self.data, self.start = data, start
        self.offsets = start - self._read("<i", start)

    def place(self, field: int) -> int | None:
        """Offset of a field; None if the field is absent."""
        slot = 4 + 2 * field
        if slot + 2 > self._read("<H", self.offsets):
            return None
        offset = self._read("<H", self.offsets + slot)
        return self.start + offset if offset else None

    def number(self, field: int, form: str) -> int:
        """The number in a field; 0 if the field is absent."""
        position = self.place(field)
        return 0 if position is None else self._read(form, position)

    def table(self, field: int) -> _FlatTable | None:
        position = self.place(field)
        return None if position is None else _FlatTable(self.data, position + self._read("<I", position))

    def pairs(self, field: int) -> Iterator[tuple[int, int]]:
        """The pairs of numbers in a vector field."""
        position = self.place(field)
        if position is not None:
            position += self._read("<I", position)
            for k in range(self._read("<I", position)):
                yield self._read("<q", position + 4 + 16 * k), self._read("<q", position + 12 + 16 * k)

    def _read(self, form: str, place: int) -> int:
        if place < 0:
            raise struct.error
        value: int = struct.unpack_from(form, self.data, place)[0]
        return value
