"""Where a text table breaks off: a last line without its end, or bytes that are no text.

A line with too few fields in the middle of good ones is a mistake that somebody must mend, and is refused. A last line that
stops short, and a line of bytes that no logger writes, are what a crash, a full disk or a bad transfer leave: what stands
before them is as it was written.
"""

from __future__ import annotations

import gzip
import re
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from sigmatau.errors import DataError

__all__ = ["BREAK", "Line", "cut_number", "damaged", "line_at", "lines_of"]

BREAK = re.compile(rb"[\x00-\x08\x0b\x0e-\x19\x1b-\x1f\x7f]")
"""Bytes that are in no text; 0x1a ends files of old systems."""

_LONGEST = 1 << 20
_STRANGE = 16  # bytes beyond ASCII that are no UTF-8, and at least half of a line
_TAIL = 1 << 14
_SHAPE = re.compile(r"[+-]?\d+(?:\.(\d*))?(?:[eE][+-]?(\d*))?")
_LOOKED_AT = 32  # lines before the last one


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """A line of a text: its first MiB, whether it has a line end, and whether nothing but blanks follows."""

    text: bytes
    ended: bool
    last: bool


def lines_of(source: Path | bytes, encoding: str) -> Iterator[bytes]:
    """The lines of a text, or of a file that may be compressed, with their ends, in pieces of at most 1 MiB.

    Compressed data that break off end there: this is asked for after it has been found what is wrong.
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
            for piece in iter(lambda: text.readline(_LONGEST), ""):
                yield piece.encode("utf-8", errors="replace")
        return
    with gzip.open(source, "rb") if compressed else source.open("rb") as lines:
        yield from iter(lambda: lines.readline(_LONGEST), b"")


def _blocks_of(source: Path | bytes, encoding: str) -> Iterator[bytes]:
    """The same text in blocks that end anywhere, which is quicker."""
    if isinstance(source, bytes) or encoding != "ascii":
        yield from lines_of(source, encoding)
        return
    with source.open("rb") as stream:
        compressed = stream.read(2) == b"\x1f\x8b"
    try:
        with gzip.open(source, "rb") if compressed else source.open("rb") as blocks:
            yield from iter(lambda: blocks.read1(_LONGEST), b"")  # what there is before compressed data break off
    except (EOFError, zlib.error, gzip.BadGzipFile):
        return


def line_at(source: Path | bytes, number: int, encoding: str) -> Line:
    """A line, counted from 1; raises `DataError` if there is none."""
    left, text, ended = number - 1, b"", False
    for block in _blocks_of(source, encoding):  # a line by itself would take hours where there are only line ends
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
            text += line[: _LONGEST - len(text)] + end
            ended = bool(end)
        if ended and rest.strip():
            return Line(text=text, ended=ended, last=False)
    if left or not text:
        raise DataError("changed while it was being read")
    return Line(text=text, ended=ended, last=True)


def damaged(line: bytes, encoding: str) -> bool:
    """Whether a line that is no row is no text either."""
    if BREAK.search(line):
        return True
    if encoding != "ascii":  # two bytes of rubbish are mostly some character
        text = line.decode("utf-8", errors="replace")
        strange = sum(not c.isascii() for c in text)
        return strange >= _STRANGE and 2 * strange >= len(text)
    strange = len(line.translate(None, bytes(range(128))))
    if strange < _STRANGE or 2 * strange < len(line):
        return False
    try:
        line.decode("utf-8")
    except UnicodeDecodeError:
        return True
    return False


def cut_number(source: Path | bytes, encoding: str, delimiter: str | None, *, open_end: bool) -> bool | None:
    """Whether the last number of a text without a last line end was cut: None if that cannot be told.

    A column that had as many decimals in every row, and has fewer in a last line without an end, was cut there. False if
    there is a last line end. A compressed file is gone through again for its end, if `open_end` says that it has none: its
    checksum is right then, but the text may have been cut before it was compressed.
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
                for next_block in iter(lambda: stream.read(_LONGEST), b""):
                    tail, block = block, next_block
            tail = (tail + block)[-(_TAIL + len(tail + block) % 2) :]
    text = tail.decode("latin-1" if encoding == "ascii" else encoding, errors="replace")
    if delimiter is not None and text.endswith(delimiter):  # the last field is not there, unless all lines end so
        whole = text.split("\n")[-2:-1]
        return not whole[0].rstrip("\r").endswith(delimiter) if whole else None
    if text[-1:] in set('\n\r\t ";,|'):  # then the number before is whole
        return False
    lines = [line for line in text.rstrip().split("\n")[1:] if line.strip()][-_LOOKED_AT:]
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
