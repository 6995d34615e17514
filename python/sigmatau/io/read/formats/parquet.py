"""Parquet files: row groups, with checksums of pages if they have them."""

from __future__ import annotations

import itertools
import mmap
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.reading import Damaged, Place
from sigmatau.io.read.formats.arrow_batches import BatchError, table_of
from sigmatau.io.read.formats.arrow_columns import columns_of, is_list, with_sizes
from sigmatau.io.read.formats.library_errors import first_line
from sigmatau.io.read.formats.trailing_bytes import not_read
from sigmatau.io.read.table import Table

__all__ = ["MARK", "parquet"]

MARK = b"PAR1"


def parquet(path: Path) -> Table:
    """The table of a Parquet file, or of several that were joined; raises `DataError`."""
    size = path.stat().st_size
    with path.open("rb") as stream:
        stream.seek(-min(8, size), 2)
        if not stream.read().endswith(MARK):
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
    """Beginnings and ends of the Parquet files in a file: several, if they were joined by ``cat``.

    The directory at the end is that of the last one, with offsets from its own beginning.
    """
    size = path.stat().st_size
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        borders = [0]
        while (at := data.find(MARK * 2, borders[-1])) >= 0:
            directory = int.from_bytes(data[at - 4 : at], "little")
            if not 0 < directory < at - borders[-1]:  # the mark is part of the data
                return [(0, size)]
            borders.append(at + len(MARK))
    return list(itertools.pairwise([*borders, size]))


def _opened_part(path: Path, bound: tuple[int, int]) -> Any:  # noqa: ANN401
    import pyarrow as pa
    import pyarrow.parquet as pq

    start, end = bound
    whole = start == 0 and end == path.stat().st_size
    source = path if whole else pa.BufferReader(pa.memory_map(str(path)).read_buffer().slice(start, end - start))
    return pq.ParquetFile(source, page_checksum_verification=True)


def _has_checksum(path: Path, meta: Any) -> bool | None:  # noqa: ANN401
    """Whether the first page has a checksum: the fourth field of its header, after three numbers (parquet.thrift)."""
    if not meta.num_row_groups or not meta.num_columns:
        return None
    # The first page follows the mark. The directory has its offset too, but pyarrow aborts the process if the directory is
    # damaged.
    with path.open("rb") as stream:
        stream.seek(len(MARK))
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
