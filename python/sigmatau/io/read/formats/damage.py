"""Damage that readers of several formats report: errors of libraries, truncated message chains, bytes after the end.

Formats that declare their length are read up to it. Their libraries ignore the bytes that follow (filler, or another log
that was appended by ``cat``) without a warning.
"""

from __future__ import annotations

import errno
import gzip
import io
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import BytesNotRead, Damaged, Place
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.io.read.table import Head
from sigmatau.record import memory


def first_line(error: Exception) -> str:
    """The first line of an error, or its type if it has no text."""
    return str(error).split("\n")[0].strip("'\"") or type(error).__name__


def damaged(error: Exception, what: str = "damaged or truncated") -> DataError:
    """A `DataError` from the error of a library."""
    return DataError(f"is {what} ({first_line(error)}); copy or record the file again")


@contextmanager
def library_faults(convert: Callable[[Exception], DataError] = damaged) -> Iterator[None]:
    """Turn the errors of a library on a damaged file into `DataError`. `DataError`, `MemoryError` and errors of the
    operating system are not changed.
    """
    try:
        yield
    except (DataError, MemoryError):
        raise
    except OSError as error:
        if error.errno not in (None, errno.EINVAL):  # EINVAL: an offset before the beginning of the file
            raise
        raise convert(error) from None
    except Exception as error:
        raise convert(error) from None


def fault(**fields: Any) -> Finding:  # noqa: ANN401  those of `Damaged`
    """A finding of damage that loses rows."""
    return Finding(details=Damaged(**fields), severity="error")


def broken(scan: Mapping[str, Any], size: int) -> tuple[Finding, ...]:
    """A finding about where the chain of messages is truncated; none if the chain reaches the end of the file.

    `scan`: result of `sigmatau._native.logs`, with ``messages`` and ``broken``; `size`: size of the file [bytes].
    """
    if scan["broken"] is None:
        return ()
    position, reason = scan["broken"]
    cut = reason is None
    inside, place = "message" if cut else "", Place("byte", position, of=size)
    count = scan["messages"]
    return (fault(truncated=cut, inside=inside, place=place, reason=reason or "", kept=count, counted="messages"),)


EXPANSION = 100.0
"""Largest size of unpacked content over that of the file, by default; text logs are compressed to a third or a twentieth."""

_MIN_EXPANDED = 1 << 26  # content up to this size is unpacked whatever its ratio [bytes]
_expansion = ContextVar("expansion", default=EXPANSION)


@contextmanager
def expansion_limit(times: float | None) -> Iterator[None]:
    """Set the largest ratio of unpacked to packed size for the readers that are called within the block."""
    token = _expansion.set(EXPANSION if times is None else times)
    try:
        yield
    finally:
        _expansion.reset(token)


def largest_expansion(stored: int) -> int:
    """Largest size to which a file of this size may be unpacked. [bytes]"""
    return int(min(max(_MIN_EXPANDED, _expansion.get() * stored), 1 << 62))


def refuse_expansion(stored: int, unpacked: int | None, what: str = "") -> None:
    """Raise `DataError`: the content unpacks to more than is allowed. `unpacked` is None if the size is not known."""
    largest = largest_expansion(stored)
    if unpacked is not None and unpacked <= largest:
        return
    size = f"more than {largest / 1e6:.3g} MB" if unpacked is None else f"{unpacked / 1e6:.3g} MB"
    need = "N" if unpacked is None else str(-(-unpacked // max(stored, 1)))
    raise DataError(
        f"{what and f'{what} '}expands from {stored / 1e6:.3g} MB to {size}: it may be damaged or made to fill the memory;"
        f" if it is right, allow N times its size by {Hint('max_expansion', value=need)}"
    )


_CHUNK = 1 << 20
_END_RECORD = b"PK\x05\x06"  # first bytes of the last record of a zip archive
_END_LENGTH = 22  # length of that record [bytes]
_COMMENT = 1 << 16  # largest length of the comment after that record [bytes]


def trailing_bytes(path: Path, end: int, what: str) -> tuple[Finding, ...]:
    """A finding about bytes after the end of the contents; none if the file ends there.

    `end`: where the contents end [bytes]; `what`: name of the contents: ``"the array"``.
    """
    size = path.stat().st_size
    if size <= end:
        return ()
    return (not_read(size - end, end, after=what, padding=_is_padding(path, end)),)


def not_read(number: int, start: int, *, after: str = "", padding: bool = False) -> Finding:
    """A finding of bytes that are not read, see `sigmatau.findings.reading.BytesNotRead`."""
    details = BytesNotRead(bytes=number, place=Place("byte", start), after=after, padding=padding)
    return Finding(details=details, severity="info" if padding else "error")


def find_mark(path: Path, mark: bytes) -> Iterator[int]:
    """Find the places of a mark in a file, in order. [bytes]"""
    with path.open("rb") as stream:
        start, held = 0, b""  # place of the first byte in memory
        while piece := stream.read(_CHUNK):
            held += piece
            place = held.find(mark)
            while place >= 0:
                yield start + place
                place = held.find(mark, place + 1)
            overlap = len(mark) - 1
            start, held = start + len(held) - min(overlap, len(held)), held[len(held) - min(overlap, len(held)) :]


def _is_padding(path: Path, start: int) -> bool:
    """Whether all bytes from a place to the end of the file are 0, or all 0xff."""
    with path.open("rb") as stream:
        stream.seek(start)
        first = stream.read(1)
        if first not in (b"\0", b"\xff"):
            return False
        return not any(piece.strip(first) for piece in iter(lambda: stream.read(_CHUNK), b""))


def archive_ends(path: Path, first: int) -> tuple[Finding, ...]:
    """Findings about bytes before and after a zip archive. If there are several archives, the library reads the last.

    `first`: where the first member begins [bytes].
    """
    findings: tuple[Finding, ...] = ()
    if first > 0:
        findings = (not_read(first, 0),)
    size = path.stat().st_size
    start = max(0, size - _END_LENGTH - _COMMENT)
    with path.open("rb") as stream:
        stream.seek(start)
        tail = stream.read()
    position = tail.rfind(_END_RECORD)
    if position < 0 or position + _END_LENGTH > len(tail):
        return findings
    comment = int.from_bytes(tail[position + 20 : position + 22], "little")
    return (*findings, *trailing_bytes(path, start + position + _END_LENGTH + comment, "the archive"))


@frozen
class Contents:
    """The bytes of a file, and the damage of its compression."""

    data: bytes
    findings: tuple[Finding, ...] = ()


def read_contents(source: Path | bytes, head: Head, *, copies: int) -> Contents:
    """Read and decompress a file, or one that is already in memory.

    Raises `DataError` if the contents are damaged, or if `copies` of them do not fit in memory. If a stream is truncated,
    the part before the damage is returned with a finding.
    """
    if isinstance(source, bytes):
        return Contents(data=source)
    stored = source.stat().st_size
    free = memory.available()
    if not head.gzip:
        if free is not None and copies * stored > free:
            raise _too_large()
        return Contents(data=source.read_bytes())
    largest = largest_expansion(stored)
    allowed = largest if free is None else min(largest, free // copies)
    data = io.BytesIO()
    try:
        with gzip.open(source, "rb") as stream:
            for block in iter(lambda: stream.read1(_CHUNK), b""):
                data.write(block)
                if data.tell() > largest:
                    refuse_expansion(stored, None)
                if data.tell() > allowed:
                    raise _too_large()
    except EOFError:
        lines = data.getvalue().count(b"\n")
        truncated = fault(truncated=True, what="gzip stream", place=Place("line", lines + 1))
        return Contents(data=data.getvalue(), findings=(truncated,))
    except (zlib.error, gzip.BadGzipFile):
        lines = data.getvalue().count(b"\n")
        raise DataError(
            f"the compressed data are damaged after line {lines}, and the lines before may be wrong too;"
            " copy or record the file again"
        ) from None
    return Contents(data=data.getvalue())


def _too_large() -> DataError:
    return DataError("does not fit in memory; cut it, or save it as CSV")
