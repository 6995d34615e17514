"""Detection of where a text table is truncated: an incomplete last line, or bytes that are not text.

A crash, a full disk or a bad transfer leave such an end, and the rows before it are intact. A line with too few fields among
good rows is a different fault: it is an error that the user must correct.
"""

from __future__ import annotations

import gzip
import re
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from sigmatau.errors import DataError

# Bytes that text does not have; 0x1a is allowed, because it ends files of old systems
BREAK = re.compile(rb"[\x00-\x08\x0b\x0e-\x19\x1b-\x1f\x7f]")
_CHUNK = 1 << 20  # [bytes]
_MIN_NOT_ASCII = 16  # bytes beyond ASCII in a damaged line; they are also at least half of it
_TAIL = 1 << 14  # [bytes]
_SHAPE = re.compile(r"[+-]?\d+(?:\.(\d*))?(?:[eE][+-]?(\d*))?")
_COMPARED = 32  # lines before the last one whose decimals are compared with it


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """A line of a text: its first MiB, whether it has a line end, and whether only blanks follow."""

    text: bytes
    ended: bool
    last: bool


def lines_of(source: Path | bytes, encoding: str) -> Iterator[bytes]:
    """The lines of a text, or of a file that may be compressed, with their ends, in pieces of at most 1 MiB. Damaged
    compressed data end without an error, which was raised before.
    """
    try:
        yield from _lines_of(source, encoding)
    except (EOFError, zlib.error, gzip.BadGzipFile):
        return


def _lines_of(source: Path | bytes, encoding: str) -> Iterator[bytes]:
    if isinstance(source, bytes):
        start = 0
        while start < len(source):
            end = source.find(b"\n", start) + 1 or len(source)
            yield source[start:end]
            start = end
        return
    with source.open("rb") as stream:
        compressed = stream.read(2) == b"\x1f\x8b"
    if encoding != "ascii":
        with (
            gzip.open(source, "rt", encoding=encoding, errors="replace", newline="\n")
            if compressed
            else source.open(encoding=encoding, errors="replace", newline="\n")
        ) as text:
            for piece in iter(lambda: text.readline(_CHUNK), ""):
                yield piece.encode("utf-8", errors="replace")
        return
    with gzip.open(source, "rb") if compressed else source.open("rb") as lines:
        yield from iter(lambda: lines.readline(_CHUNK), b"")


def _blocks_of(source: Path | bytes, encoding: str) -> Iterator[bytes]:
    """The same text in blocks that end anywhere, which is faster."""
    if isinstance(source, bytes) or encoding != "ascii":
        yield from lines_of(source, encoding)
        return
    with source.open("rb") as stream:
        compressed = stream.read(2) == b"\x1f\x8b"
    try:
        with gzip.open(source, "rb") if compressed else source.open("rb") as blocks:
            yield from iter(lambda: blocks.read1(_CHUNK), b"")  # returns data up to the end of a truncated stream
    except (EOFError, zlib.error, gzip.BadGzipFile):
        return


def line_at(source: Path | bytes, number: int, encoding: str) -> Line:
    """A line, counted from 1; raises `DataError` if there is none."""
    left, text, ended = number - 1, b"", False
    for block in _blocks_of(source, encoding):  # line by line, a file of only line ends would take hours
        rest = block
        if left:
            ends = rest.count(b"\n")
            if ends < left:
                left -= ends
                continue
            at = -1
            for _ in range(left):
                at = rest.find(b"\n", at + 1)
            left, rest = 0, rest[at + 1 :]
        if not ended:
            line, end, rest = rest.partition(b"\n")
            text += line[: _CHUNK - len(text)] + end
            ended = bool(end)
        if ended and rest.strip():
            return Line(text=text, ended=ended, last=False)
    if left or not text:
        raise DataError("changed while it was read")
    return Line(text=text, ended=ended, last=True)


def damaged(line: bytes, encoding: str) -> bool:
    """Whether a line that is not a row is not text either."""
    if BREAK.search(line):
        return True
    if encoding != "ascii":  # two random bytes are mostly a valid character
        text = line.decode("utf-8", errors="replace")
        not_ascii = sum(not c.isascii() for c in text)
        return not_ascii >= _MIN_NOT_ASCII and 2 * not_ascii >= len(text)
    not_ascii = len(line.translate(None, bytes(range(128))))
    if not_ascii < _MIN_NOT_ASCII or 2 * not_ascii < len(line):
        return False
    try:
        line.decode("utf-8")
    except UnicodeDecodeError:
        return True
    return False


def cut_number(source: Path | bytes, encoding: str, delimiter: str | None, *, open_end: bool) -> bool | None:
    """Whether the last number of a text without a final line end was cut; None if that is not known, False with a line
    end. It was cut if it has fewer decimals than the last column has in all rows before. A compressed file is read
    again to its end if `open_end` is true: the text may have been cut before it was compressed.
    """
    if isinstance(source, bytes):
        tail = source[-_TAIL:]
    else:
        with source.open("rb") as stream:
            compressed = stream.read(2) == b"\x1f\x8b"
            if compressed and not open_end:
                return False
            if not compressed:
                size = stream.seek(0, 2)
                stream.seek(max(0, size - _TAIL) // 2 * 2)
                tail = stream.read()
        if compressed:
            with gzip.open(source, "rb") as stream:
                tail, block = b"", b""
                for next_block in iter(lambda: stream.read(_CHUNK), b""):
                    tail, block = block, next_block
            tail = (tail + block)[-(_TAIL + len(tail + block) % 2) :]
    text = tail.decode("latin-1" if encoding == "ascii" else encoding, errors="replace")
    if delimiter is not None and text.endswith(delimiter):  # the last field is missing, unless all lines end so
        whole = text.split("\n")[-2:-1]
        return not whole[0].rstrip("\r").endswith(delimiter) if whole else None
    if text[-1:] in set('\n\r\t ";,|'):  # then the number before it is complete
        return False
    lines = [line for line in text.rstrip().split("\n")[1:] if line.strip()][-_COMPARED:]
    *before, last = [_shape(line, delimiter) for line in lines] or [None]
    if last is None or len(before) < 2 or len(set(before)) > 1 or before[0] in (None, (-1, -1)):
        return None
    assert before[0] is not None
    return any(now < then for now, then in zip(last, before[0], strict=True))


def _shape(line: str, delimiter: str | None) -> tuple[int, int] | None:
    """Decimals and digits of the exponent of the last number of a line, -1 for none."""
    fields = line.strip().rstrip(delimiter or "").split(delimiter)
    match = _SHAPE.fullmatch(fields[-1].strip().strip('"').replace(",", "."))
    return None if match is None else (len(match[1] or "") or -1, len(match[2] or "") or -1)
