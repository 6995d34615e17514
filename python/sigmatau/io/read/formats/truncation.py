"""Detection of where a text table is truncated: an incomplete last line, or bytes that are not text.

A crash, a full disk or a bad transfer leaves such an end, and the rows before it are intact. A line with too few fields
among good rows is a different fault: it is an error that the user must correct.
"""

from __future__ import annotations

import codecs
import gzip
import re
import zlib
from collections.abc import Iterator
from pathlib import Path

from sigmatau.errors import DataError
from sigmatau.frozen import frozen

# Bytes that text does not have; 0x1a is allowed, because it ends files of old systems
BREAK = re.compile(rb"[\x00-\x08\x0b\x0e-\x19\x1b-\x1f\x7f]")
_CHUNK = 1 << 20  # [bytes]
_TAIL = 1 << 14  # end of a text that is searched for its last line [bytes]
_MIN_NOT_ASCII = 16  # smallest number of non-ASCII bytes in a damaged line; they must also be at least half of it


@frozen
class FileLine:
    """A line of a text: its first MiB, whether it has a line end, and whether only blanks follow."""

    text: bytes
    ended: bool
    last: bool


def iterate_lines(source: Path | bytes, encoding: str) -> Iterator[bytes]:
    """The lines of a text, or of a file that may be compressed, with their ends. Long lines come in pieces of some MiB."""
    rest = b""
    for block in _iterate_blocks(source, encoding):
        *lines, rest = (rest + block).split(b"\n")
        yield from (line + b"\n" for line in lines)
        if len(rest) > _CHUNK:
            yield rest
            rest = b""
    if rest:
        yield rest


def _iterate_blocks(source: Path | bytes, encoding: str) -> Iterator[bytes]:
    """The same text in blocks of any length, in UTF-8. Damaged compressed data end silently here; the error has been raised
    before.
    """
    if isinstance(source, bytes):
        yield source
        return
    decoder = None if encoding == "ascii" else codecs.getincrementaldecoder(encoding)("replace")
    with source.open("rb") as stream:
        compressed = stream.read(2) == b"\x1f\x8b"
    try:
        with gzip.open(source, "rb") if compressed else source.open("rb") as blocks:
            for block in iter(lambda: blocks.read1(_CHUNK), b""):  # returns data up to the end of a truncated stream
                yield block if decoder is None else decoder.decode(block).encode("utf-8", "replace")
    except (EOFError, zlib.error, gzip.BadGzipFile):
        return


def last_line(source: Path | bytes, encoding: str) -> str | None:
    """The last line with a line end; None if it is the only one, or for compressed text, which would need unpacking."""
    if isinstance(source, Path):
        with source.open("rb") as stream:
            if stream.read(2) == b"\x1f\x8b":
                return None
            stream.seek(max(stream.seek(0, 2) - _TAIL, 0))
            source = stream.read()
    # In UTF-16 the tail begins at an even byte, because the size of the file is even unless it was cut.
    text = source[-_TAIL:].decode("latin-1" if encoding == "ascii" else encoding, "replace")
    lines = [line.rstrip("\r") for line in text.split("\n")[:-1] if line.strip()]
    return lines[-1] if len(lines) > 1 else None


def beginning_below(source: Path | bytes, skip: int, encoding: str, size: int) -> bytes:
    """The first `size` bytes of the text below `skip` lines, in UTF-8, and one more byte if the text continues."""
    text, lines = b"", skip
    for block in _iterate_blocks(source, encoding):
        rest = block
        if lines:
            ends = rest.count(b"\n")
            if ends < lines:
                lines -= ends
                continue
            rest = rest.split(b"\n", lines)[lines]
            lines = 0
        text += rest
        if len(text) > size:
            break
    return text[: size + 1]


def find_line(source: Path | bytes, number: int, encoding: str) -> FileLine:
    """Find a line, counted from 1. Raises `DataError` if it does not exist."""
    line, end, rest = beginning_below(source, number - 1, encoding, _CHUNK).partition(b"\n")
    if not line + end:
        raise DataError("changed while it was read")
    return FileLine(text=line + end, ended=bool(end), last=not rest.strip())


def damaged(line: bytes, encoding: str) -> bool:
    """Whether a line that is not a row is damaged, because it is not text."""
    if BREAK.search(line):
        return True
    if encoding != "ascii":  # two random bytes often form a valid character
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
