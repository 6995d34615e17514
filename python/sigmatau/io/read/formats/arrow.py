"""Arrow files (Feather version 2), Arrow streams, and Parquet files, which may have checksums of their pages."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.reading import BrokenOff, Damaged, NoEndMark, Place
from sigmatau.io.read.formats.arrow_table import BatchError, columns_of, is_list, table_of, with_sizes
from sigmatau.io.read.formats.damage import behind, first_line, library_faults, not_read, places_of
from sigmatau.io.read.table import Head, Table, need

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

    with pa.OSFile(str(path)) as source, opened(source) as stream:
        schema = stream.schema
    found, others = columns_of(schema)

    def batches(fields: Sequence[str]) -> Iterator[tuple[Place, Any] | Finding]:
        indices = [schema.get_field_index(name) for name in fields]
        options = ipc.IpcReadOptions(included_fields=indices)
        with pa.OSFile(str(path)) as source, opened(source, options) as stream:
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
    """Findings of the bytes after the batches. A stream ends with an end mark; a file with a directory, its length and
    a mark.
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


PARQUET = b"PAR1"


def parquet(path: Path) -> Table:
    """The table of a Parquet file, or of several that were joined; raises `DataError`."""
    size = path.stat().st_size
    with path.open("rb") as stream:
        stream.seek(-min(8, size), 2)
        if not stream.read().endswith(PARQUET):
            raise DataError(
                "is truncated: the directory at the end of the Parquet file is missing; copy or record it again"
            )
    findings: tuple[Finding, ...] = ()
    groups: list[tuple[tuple[int, int], int, int]] = []  # bounds of the file, number and rows of the group
    bounds = _files_in(path)
    for k, bound in enumerate(bounds):
        with _opened_part(path, bound) as file:
            meta = file.metadata
            if k == 0:
                schema = file.schema_arrow
                found, others = columns_of(with_sizes(schema, _first_row(file, schema)))
                checked = _has_checksum(path, meta)
            elif not file.schema_arrow.equals(schema):
                findings = (not_read(size - bound[0], bound[0], after="the Parquet file"),)
                break
            rows = [meta.row_group(n).num_rows for n in range(meta.num_row_groups)]
        if sum(rows) != meta.num_rows:
            raise DataError(f"declares {meta.num_rows} rows, but its row groups hold {sum(rows)}; it is damaged")
        groups.extend((bound, n, held) for n, held in enumerate(rows))
    if checked is None:
        protection = "no rows"
    elif checked:
        protection = "pages with checksums, which are verified"
    else:
        protection = "pages without checksums: damaged numbers are not detected"

    def batches(fields: Sequence[str]) -> Iterator[tuple[Place, Any]]:
        for bound in dict.fromkeys(bound for bound, _, _ in groups):
            with _opened_part(path, bound) as file:
                for k, (own, number, rows) in enumerate(groups):
                    if own != bound:
                        continue
                    place = Place("row group", k + 1, of=len(groups))
                    try:
                        held = file.read_row_group(number, columns=list(fields))
                    except MemoryError:
                        raise
                    except Exception as error:
                        raise BatchError(place, reason=first_line(error)) from None
                    if len(held) != rows:
                        raise BatchError(place, got=len(held), expected=rows)
                    yield place, held

    note = f"Parquet, {len(groups)} row groups; {protection}"
    notes = (note,) if len(bounds) == 1 else (note, f"{len(bounds)} Parquet files, one after the other")
    total = sum(rows for _, _, rows in groups)
    return table_of("parquet", found, others, notes, batches, total, damage=Damaged, findings=findings)


def _first_row(file: Any, schema: Any) -> Any:  # noqa: ANN401
    """The first row of the columns of lists; nothing if there are none."""
    names = [field.name for field in schema if is_list(field.type)]
    return (
        next(file.iter_batches(batch_size=1, columns=names), ())
        if names and len(set(schema.names)) == len(schema)
        else ()
    )


def _files_in(path: Path) -> list[tuple[int, int]]:
    """Beginnings and ends of the Parquet files in a file: several, if they were joined by ``cat``. The directory at the
    end is that of the last one, with offsets from its own beginning.
    """
    size = path.stat().st_size
    borders = [0]
    with path.open("rb") as stream:
        for at in places_of(path, PARQUET * 2):
            stream.seek(max(at - 4, 0))
            directory = int.from_bytes(stream.read(4), "little")
            if not 0 < directory < at - borders[-1]:  # the mark is part of the data
                return [(0, size)]
            borders.append(at + len(PARQUET))
    return list(itertools.pairwise([*borders, size]))


def _opened_part(path: Path, bound: tuple[int, int]) -> Any:  # noqa: ANN401
    import pyarrow as pa
    import pyarrow.parquet as pq

    start, end = bound
    whole = start == 0 and end == path.stat().st_size
    source: Any = path
    if not whole:
        with path.open("rb") as stream:
            stream.seek(start)
            source = pa.BufferReader(stream.read(end - start))
    return pq.ParquetFile(source, page_checksum_verification=True)


def _has_checksum(path: Path, meta: Any) -> bool | None:  # noqa: ANN401
    """Whether the first page has a checksum: the fourth field of its header, after three numbers (parquet.thrift)."""
    if not meta.num_row_groups or not meta.num_columns:
        return None
    # The first page follows the mark. The directory has its offset too, but pyarrow aborts the process if the directory is
    # damaged.
    with path.open("rb") as stream:
        stream.seek(len(PARQUET))
        header = stream.read(32)
    at = 0
    for _ in range(3):
        if header[at : at + 1] != b"\x15":  # the next field, an integer of 32 bits
            return False
        at += 1
        while at < len(header) and header[at] & 0x80:
            at += 1
        at += 1
    return header[at : at + 1] == b"\x15"
