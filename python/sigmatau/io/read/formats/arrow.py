"""Arrow files (Feather version 2) and Arrow streams; Parquet files by `parquet`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.reading import BrokenOff, Damaged, NoEndMark, Place
from sigmatau.io.read.formats.arrow_batches import BatchError, table_of
from sigmatau.io.read.formats.arrow_columns import columns_of
from sigmatau.io.read.formats.library_errors import first_line, library_faults
from sigmatau.io.read.formats.parquet import MARK as PARQUET
from sigmatau.io.read.formats.parquet import parquet
from sigmatau.io.read.formats.trailing_bytes import behind
from sigmatau.io.read.table import Head, Table, need

__all__ = ["read", "sniff"]

_FILE, _STREAM = b"ARROW1\0\0", b"\xff\xff\xff\xff"
_END = b"ARROW1"
_END_OF_STREAM = b"\xff\xff\xff\xff\0\0\0\0"
_LONGEST_SCHEMA = 1 << 24  # a stream begins with its schema [bytes]


def sniff(head: bytes, path: Path) -> bool:
    """Whether the file is Parquet, an Arrow file or an Arrow stream; a stream begins with the length of its schema."""
    return head.startswith((PARQUET, _FILE)) or (
        head.startswith(_STREAM)
        and 0 < (size := int.from_bytes(head[4:8], "little")) < _LONGEST_SCHEMA
        and size % 8 == 0
        and len(head) > 64
        and 4 <= int.from_bytes(head[8:12], "little") < size  # offset of the root of the schema
    )


def read(path: Path, head: Head) -> tuple[Table]:
    """The one table of a file; raises `DataError`."""
    need("pyarrow", "parquet", "a Parquet or Arrow file")
    with library_faults():
        return (parquet(path) if head.data.startswith(PARQUET) else _ipc(path, head),)


def _ipc(path: Path, head: Head) -> Table:
    import pyarrow as pa
    from pyarrow import ipc

    is_file = head.data.startswith(_FILE)
    with path.open("rb") as stream:
        stream.seek(-min(8, path.stat().st_size), 2)
        tail = stream.read()
    notes = [f"Arrow {'file' if is_file else 'stream'}, without checksums: damaged numbers are not detected"]
    ends = tail.endswith(_END) if is_file else tail == _END_OF_STREAM

    def opened(source: Any, options: Any = None) -> Any:  # noqa: ANN401
        source.seek(len(_FILE) if is_file else 0)  # a file is a stream between two marks, followed by a directory
        return ipc.open_stream(source, options=options)

    with pa.memory_map(str(path)) as source, opened(source) as stream:
        schema = stream.schema
    found, others = columns_of(schema)

    def batches(fields: Sequence[str]) -> Iterator[tuple[Place, Any] | Finding]:
        indices = [schema.get_field_index(name) for name in fields]
        options = ipc.IpcReadOptions(included_fields=indices)
        with pa.memory_map(str(path)) as source, opened(source, options) as stream:
            number = 0
            while True:
                place = Place("batch", number + 1)
                try:
                    batch = stream.read_next_batch()
                except StopIteration:
                    yield from _behind(path, source.tell(), is_file=is_file)
                    return
                except MemoryError:  # the declared length of a compressed buffer is not limited
                    raise BatchError(place, reason="it needs more memory than there is, or is damaged") from None
                except Exception as error:
                    raise BatchError(place, reason=first_line(error)) from None
                yield place, batch
                number += 1

    return table_of("arrow", found, others, tuple(notes), batches, None, damage=Damaged if ends else BrokenOff)


def _behind(path: Path, end: int, *, is_file: bool) -> tuple[Finding, ...]:
    """Findings of the bytes after the batches.

    A stream ends with an end mark; a file with a directory, its length and a mark.
    """
    size = path.stat().st_size
    if not is_file:
        with path.open("rb") as stream:
            stream.seek(max(0, end - len(_END_OF_STREAM)))
            mark = stream.read(len(_END_OF_STREAM))
        if mark == _END_OF_STREAM:
            return behind(path, end, "the stream")
        return (Finding(details=NoEndMark(what="stream"), severity="error"),)
    with path.open("rb") as stream:
        stream.seek(end)
        directory = stream.read(min(size - end, _LONGEST_SCHEMA))
    at = directory.find(_END)
    if at < 4 or int.from_bytes(directory[at - 4 : at], "little") > at - 4:
        return (Finding(details=BrokenOff(reason="its end mark is missing"), severity="error"),)
    return behind(path, end + at + len(_END), "the Arrow file")
