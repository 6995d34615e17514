"""Arrow files (Feather version 2), Arrow streams, and Parquet files, which may have checksums of their pages."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import Place
from sigmatau.io.read.formats.arrow_messages import next_unpacked
from sigmatau.io.read.formats.arrow_table import BatchError, find_numeric_columns, make_table
from sigmatau.io.read.formats.damage import (
    fault,
    find_mark,
    first_line,
    library_faults,
    refuse_expansion,
    trailing_bytes,
)
from sigmatau.io.read.table import Head, Table, need

_FILE = b"ARROW1\0\0"  # first bytes of a file
_STREAM = b"\xff\xff\xff\xff"  # first bytes of a stream
_END = b"ARROW1"
_END_OF_STREAM = b"\xff\xff\xff\xff\0\0\0\0"
_NUMBER = 8  # size of a number in a column [bytes]
_LONGEST_SCHEMA = 1 << 24  # largest size of the schema, with which a stream begins [bytes]


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
        try:
            return ipc.open_stream(source, options=options)
        except MemoryError:  # its declared length is not limited
            raise DataError("is damaged: its schema needs more memory than is free; copy or record it again") from None

    with pa.OSFile(str(path)) as source, opened(source) as stream:
        schema = stream.schema
    chosen, skipped = find_numeric_columns(schema)

    def batches(fields: Sequence[str]) -> Iterator[tuple[Place, Any] | Finding]:
        indices = [schema.get_field_index(name) for name in fields]
        options = ipc.IpcReadOptions(included_fields=indices)
        with pa.OSFile(str(path)) as source, opened(source, options) as stream:
            number, unpacked, stored = 0, 0, path.stat().st_size
            while True:
                place = Place("batch", number + 1)
                unpacked += next_unpacked(path, source.tell())
                refuse_expansion(stored, unpacked, "the table")
                try:
                    batch = stream.read_next_batch()
                except StopIteration:
                    yield from _trailing_bytes(path, source.tell(), is_file=is_file)
                    return
                except MemoryError:  # the declared length of a compressed buffer is not limited
                    raise BatchError(place, "it needs more memory than is free, or is damaged") from None
                except Exception as error:
                    raise BatchError(place, first_line(error)) from None
                yield place, batch
                number += 1

    return make_table("arrow", chosen, skipped, tuple(notes), batches, None, truncated=not ends)


def _trailing_bytes(path: Path, end: int, *, is_file: bool) -> tuple[Finding, ...]:
    """Findings about bytes after the batches.

    A stream ends with an end mark; a file ends with a directory, its length and a mark.
    """
    size = path.stat().st_size
    if not is_file:
        with path.open("rb") as stream:
            stream.seek(max(0, end - len(_END_OF_STREAM)))
            mark = stream.read(len(_END_OF_STREAM))
        if mark == _END_OF_STREAM:
            return trailing_bytes(path, end, "the stream")
        return (fault(truncated=True, what="stream", reason="it has no end mark, so batches may be missing"),)
    with path.open("rb") as stream:
        stream.seek(end)
        directory = stream.read(min(size - end, _LONGEST_SCHEMA))
    position = directory.find(_END)
    if position < 4 or int.from_bytes(directory[position - 4 : position], "little") > position - 4:
        return (fault(truncated=True, reason="its end mark is missing"),)
    return trailing_bytes(path, end + position + len(_END), "the Arrow file")


PARQUET = b"PAR1"


def parquet(path: Path) -> Table:
    """The table of a Parquet file; raises `DataError`."""
    import pyarrow.parquet as pq

    with path.open("rb") as stream:
        stream.seek(-min(8, path.stat().st_size), 2)
        if not stream.read().endswith(PARQUET):
            raise DataError(
                "is truncated: the directory at the end of the Parquet file is missing; copy or record it again"
            )
    if _is_joined(path):
        raise DataError("is several Parquet files, one after the other; give them one by one")

    def opened() -> Any:  # noqa: ANN401
        return pq.ParquetFile(path, page_checksum_verification=True)

    with opened() as file:
        meta = file.metadata
        chosen, skipped = find_numeric_columns(file.schema_arrow)
        groups = [meta.row_group(n).num_rows for n in range(meta.num_row_groups)]
    if sum(groups) != meta.num_rows:
        raise DataError(f"declares {meta.num_rows} rows, but its row groups hold {sum(groups)}; it is damaged")

    def batches(fields: Sequence[str]) -> Iterator[tuple[Place, Any]]:
        refuse_expansion(path.stat().st_size, sum(groups) * _NUMBER * len(fields), "the table")
        with opened() as file:
            for number, rows in enumerate(groups):
                place = Place("row group", number + 1, of=len(groups))
                try:
                    held = file.read_row_group(number, columns=list(fields))
                except MemoryError:
                    raise
                except Exception as error:
                    raise BatchError(place, first_line(error)) from None
                if len(held) != rows:
                    raise BatchError(place, f"{len(held)} of {rows} rows")
                yield place, held

    return make_table("parquet", chosen, skipped, (f"Parquet, {len(groups)} row groups",), batches, meta.num_rows)


def _is_joined(path: Path) -> bool:
    """Whether other Parquet files precede this one. The directory at the end of the file is only that of the last one."""
    with path.open("rb") as stream:
        for place in find_mark(path, PARQUET * 2):
            stream.seek(max(place - 4, 0))
            if (
                0 < int.from_bytes(stream.read(4), "little") < place
            ):  # the length of a directory precedes the mark; otherwise the mark is part of the data
                return True
    return False
