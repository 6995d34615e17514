"""The whole contents of a file in memory, unpacked if it is compressed by gzip, for readers that need all of it at once."""

from __future__ import annotations

import gzip
import io
import zlib
from dataclasses import dataclass
from pathlib import Path

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import Place
from sigmatau.io.read.formats.damage import fault, largest_expansion, refuse_expansion
from sigmatau.io.read.table import Head
from sigmatau.record import memory

_CHUNK = 1 << 20  # [bytes]


@dataclass(frozen=True, slots=True, kw_only=True)
class Contents:
    """The bytes of a file, and what is wrong with its compression."""

    data: bytes
    findings: tuple[Finding, ...] = ()


def read_contents(source: Path | bytes, head: Head, *, copies: int) -> Contents:
    """The contents of a file, or of one that is in memory already; raises `DataError` if `copies` of them do not fit in
    memory, or if they are damaged. Of a truncated stream, what can be unpacked is returned with a finding.
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
