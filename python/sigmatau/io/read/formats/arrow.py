"""Parquet files and Arrow's own (Feather version 2, and streams): columns with types, read batch by batch."""

from __future__ import annotations

import itertools
import mmap
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.io.read.formats.behind import behind, lost
from sigmatau.io.read.formats.parts import WIDEST, parts, pick, real_columns
from sigmatau.io.read.table import REST_MISSING, Column, Head, Loaded, Table, need
from sigmatau.io.read.time.rows import NO_STAMP
from sigmatau.results import Finding

__all__ = ["ArrowColumn", "columns_of", "numbers", "read", "sniff"]

_PARQUET, _FILE, _STREAM = b"PAR1", b"ARROW1\0\0", b"\xff\xff\xff\xff"
_END = b"ARROW1"
_END_OF_STREAM = b"\xff\xff\xff\xff\0\0\0\0"
_SCHEMA = 1 << 24  # a stream begins with its schema, which is shorter. [bytes]
_INDEX = re.compile(r"^__index_level_\d+__$")  # pandas, of an index without a name


def sniff(head: bytes, path: Path) -> bool:
    """Whether the file is Parquet, an Arrow file, or an Arrow stream, which begins with the length of its schema."""
    return head.startswith((_PARQUET, _FILE)) or (
        head.startswith(_STREAM)
        and 0 < (size := int.from_bytes(head[4:8], "little")) < _SCHEMA
        and size % 8 == 0
        and len(head) > 64
        and 4 <= int.from_bytes(head[8:12], "little") < size  # where the root of the schema is
    )


def read(path: Path, head: Head) -> tuple[Table]:
    """The one table of a file; raises `DataError`."""
    need("pyarrow", "parquet", "a Parquet or Arrow file")
    try:
        return (_parquet(path) if head.data.startswith(_PARQUET) else _ipc(path, head),)
    except (DataError, MemoryError):
        raise
    except Exception as error:
        raise _damaged(error) from None


@dataclass(frozen=True, slots=True, kw_only=True)
class ArrowColumn:
    """A column, and how it is got out of a table.

    Attributes
    ----------
    column : Column
    path : tuple of str
        The field, and the fields in it if that is a struct.
    part : tuple of int
        Which element, if the field is a list of fixed size.
    """

    column: Column
    path: tuple[str, ...]
    part: tuple[int, ...] = ()


def columns_of(schema: Any) -> tuple[list[ArrowColumn], list[str]]:  # noqa: ANN401  pyarrow has no types
    """The columns of numbers of an Arrow schema, and the names of its other fields."""
    import pyarrow as pa

    found: list[ArrowColumn] = []
    others: list[str] = []

    def look(field: Any, above: tuple[str, ...]) -> None:  # noqa: ANN401
        path = (*above, field.name)
        name, kind = ".".join(path), field.type
        if pa.types.is_timestamp(kind) or pa.types.is_duration(kind):
            label = "time" if _INDEX.match(name) else name
            found.append(ArrowColumn(column=Column(name=label, unit=kind.unit), path=path))
        elif pa.types.is_integer(kind) or pa.types.is_floating(kind):
            found.append(ArrowColumn(column=Column(name=name, unit=_unit(field)), path=path))
        elif pa.types.is_struct(kind):
            for inner in kind:
                look(inner, path)
        elif pa.types.is_fixed_size_list(kind) and kind.list_size <= WIDEST and _plain(kind.value_type):
            for label, part in parts(name, (kind.list_size,)):
                found.append(ArrowColumn(column=Column(name=label, unit=_unit(field)), path=path, part=part))
        else:
            others.append(name)

    for field in schema:
        look(field, ())
    return found, others


def numbers(array: Any, column: ArrowColumn, row: int = 0, *, exact: bool = False) -> NDArray[Any]:  # noqa: ANN401
    """A column of an Arrow array of its field; a null is NaN, or the least integer in times and in an exact column."""
    import pyarrow as pa

    if isinstance(array, pa.ChunkedArray):
        array = array.combine_chunks()
        array = array if not isinstance(array, pa.ChunkedArray) else pa.concat_arrays(array.chunks)
    array.validate(full=True)
    for name in column.path[1:]:
        array = (
            array.field(name)
            if not array.null_count and array.offset == 0 and len(array) == len(array.field(name))
            else array.flatten()[array.type.get_field_index(name)]  # which hands on the nulls of the struct
        )
    if pa.types.is_fixed_size_list(array.type) or _is_list(array.type):
        size = _size_of(array, column, row) if _is_list(array.type) else array.type.list_size
        there = array.drop_null()  # what stands in the place of a list that is null is anything
        held: NDArray[Any] = pick(there.flatten().to_numpy(zero_copy_only=False).reshape(-1, size), column.part)
        if not array.null_count:
            return held
        picked = np.full((len(array), *held.shape[1:]), np.nan)
        picked[~array.is_null().to_numpy(zero_copy_only=False)] = held
        return picked
    if pa.types.is_timestamp(array.type) or pa.types.is_duration(array.type):
        array = array.view(pa.int64())
        exact = True
    if exact and array.null_count and pa.types.is_integer(array.type):
        array = array.cast(pa.int64()).fill_null(NO_STAMP)
    plain: NDArray[Any] = array.to_numpy(zero_copy_only=False)
    return plain


def _is_list(kind: Any) -> bool:  # noqa: ANN401
    import pyarrow as pa

    return bool(pa.types.is_list(kind) or pa.types.is_large_list(kind))


def _size_of(array: Any, column: ArrowColumn, row: int) -> int:  # noqa: ANN401
    """How many numbers each list has; raises `DataError` if not all have as many."""
    lengths = np.asarray(array.drop_null().value_lengths())
    size = int(lengths[0]) if len(lengths) else 1
    if (lengths != size).any() or column.part[0] >= size:
        raise DataError(f"column {'.'.join(column.path)!r} holds lists of unequal length, after row {row}")
    return size


def _with_sizes(schema: Any, first: Any) -> Any:  # noqa: ANN401
    """A schema with lists of a fixed size where the first row has so many numbers: pandas writes no fixed sizes."""
    import pyarrow as pa

    for k, field in enumerate(schema):
        if _is_list(field.type) and len(first) and first.column(field.name)[0].is_valid:
            size = len(first.column(field.name)[0])
            if 0 < size <= WIDEST:
                schema = schema.set(k, field.with_type(pa.list_(field.type.value_type, size)))
    return schema


def _plain(kind: Any) -> bool:  # noqa: ANN401
    import pyarrow as pa

    return bool(pa.types.is_integer(kind) or pa.types.is_floating(kind))


def _unit(field: Any) -> str | None:  # noqa: ANN401
    for key, value in (field.metadata or {}).items():
        if key.lower() in (b"unit", b"units"):
            return str(value.decode("utf-8", "replace"))
    return None


def _parquet(path: Path) -> Table:
    size = path.stat().st_size
    with path.open("rb") as stream:
        stream.seek(-min(8, size), 2)
        if not stream.read().endswith(_PARQUET):
            raise DataError(
                "is cut off: Parquet keeps its directory at the end, which is not there; get or make it again"
            )
    findings: tuple[Finding, ...] = ()
    groups: list[tuple[tuple[int, int], int, int]] = []  # of which file, which group, of how many rows
    bounds = _files_in(path)
    for k, bound in enumerate(bounds):
        with _opened_part(path, bound) as file:
            meta = file.metadata
            if k == 0:
                schema = file.schema_arrow
                found, others = columns_of(_with_sizes(schema, _first_row(file, schema)))
                checked = _has_checksum(path, meta)
            elif not file.schema_arrow.equals(schema):
                findings = (lost(f"{size - bound[0]} bytes are another Parquet file with other columns, and not read"),)
                break
            rows = [meta.row_group(n).num_rows for n in range(meta.num_row_groups)]
        if sum(rows) != meta.num_rows:
            raise DataError(f"declares {meta.num_rows} rows, but its row groups hold {sum(rows)}; it is damaged")
        groups.extend((bound, n, held) for n, held in enumerate(rows))
    if checked is None:
        protection = "holds no rows"
    elif checked:
        protection = "pages with checksums, which are verified"
    else:
        protection = "pages without checksums: damaged numbers would not be seen"

    def batches(fields: Sequence[str]) -> Iterator[tuple[str, Any]]:
        for bound in dict.fromkeys(bound for bound, _, _ in groups):
            with _opened_part(path, bound) as file:
                for k, (own, number, rows) in enumerate(groups):
                    if own != bound:
                        continue
                    place = f"row group {k + 1} of {len(groups)}"
                    held = file.read_row_group(number, columns=list(fields))
                    if len(held) != rows:
                        raise _BatchError(f"{place} has {len(held)} of {rows} rows")
                    yield place, held

    note = f"Parquet, {len(groups)} row groups; {protection}"
    notes = (note,) if len(bounds) == 1 else (note, f"{len(bounds)} Parquet files, one after the other")
    total = sum(rows for _, _, rows in groups)
    return _table("parquet", found, others, notes, batches, total, damage="damaged", findings=findings)


def _first_row(file: Any, schema: Any) -> Any:  # noqa: ANN401
    """The first row of the columns that hold lists; nothing if there are none."""
    names = [field.name for field in schema if _is_list(field.type)]
    return (
        next(file.iter_batches(batch_size=1, columns=names), ())
        if names and len(set(schema.names)) == len(schema)
        else ()
    )


def _files_in(path: Path) -> list[tuple[int, int]]:
    """Where the Parquet files begin and end that make up a file: several, if they were joined by ``cat``.

    The directory at the end is that of the last, and its places are those of the numbers of the first.
    """
    size = path.stat().st_size
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        borders = [0]
        while (at := data.find(_PARQUET * 2, borders[-1])) >= 0:
            directory = int.from_bytes(data[at - 4 : at], "little")
            if not 0 < directory < at - borders[-1]:  # the same bytes among the numbers
                return [(0, size)]
            borders.append(at + len(_PARQUET))
    return list(itertools.pairwise([*borders, size]))


def _opened_part(path: Path, bound: tuple[int, int]) -> Any:  # noqa: ANN401
    import pyarrow as pa
    import pyarrow.parquet as pq

    start, end = bound
    whole = start == 0 and end == path.stat().st_size
    source = path if whole else pa.BufferReader(pa.memory_map(str(path)).read_buffer().slice(start, end - start))
    return pq.ParquetFile(source, page_checksum_verification=True)


def _has_checksum(path: Path, meta: Any) -> bool | None:  # noqa: ANN401
    """Whether the first page of the file has one: the fourth field of its header, after three numbers (parquet.thrift)."""
    if not meta.num_row_groups or not meta.num_columns:
        return None
    # It stands behind the mark. The directory says so too, but pyarrow aborts the process when it is asked for the place of
    # a page and the directory is damaged.
    with path.open("rb") as stream:
        stream.seek(len(_PARQUET))
        header = stream.read(32)
    at = 0
    for _ in range(3):
        if header[at : at + 1] != b"\x15":  # the next field, a number of 32 bits
            return False
        at += 1
        while at < len(header) and header[at] & 0x80:
            at += 1
        at += 1
    return header[at : at + 1] == b"\x15"


def _ipc(path: Path, head: Head) -> Table:
    import pyarrow as pa
    from pyarrow import ipc

    is_file = head.data.startswith(_FILE)
    with path.open("rb") as stream:
        stream.seek(-min(8, path.stat().st_size), 2)
        tail = stream.read()
    notes = [f"Arrow {'file' if is_file else 'stream'}, without checksums: a damaged number would not be seen"]
    ends = tail.endswith(_END) if is_file else tail == _END_OF_STREAM

    def opened(source: Any, options: Any = None) -> Any:  # noqa: ANN401
        source.seek(len(_FILE) if is_file else 0)  # a file is a stream between two marks, and a directory
        return ipc.open_stream(source, options=options)

    with pa.memory_map(str(path)) as source, opened(source) as stream:
        schema = stream.schema
    found, others = columns_of(schema)

    def batches(fields: Sequence[str]) -> Iterator[tuple[str, Any] | Finding]:
        indices = [schema.get_field_index(name) for name in fields]
        options = ipc.IpcReadOptions(included_fields=indices)
        with pa.memory_map(str(path)) as source, opened(source, options) as stream:
            number = 0
            while True:
                place = f"batch {number + 1}"
                try:
                    batch = stream.read_next_batch()
                except StopIteration:
                    yield from _behind(path, source.tell(), is_file=is_file)
                    return
                except MemoryError:  # a compressed buffer says how long it will be, and nothing bounds that
                    raise _BatchError(f"{place}: asks for more memory than there is, or is damaged") from None
                except Exception as error:
                    raise _BatchError(f"{place}: {_text(error)}") from None
                yield place, batch
                number += 1

    return _table("arrow", found, others, tuple(notes), batches, None, damage="damaged" if ends else "broken_off")


def _behind(path: Path, end: int, *, is_file: bool) -> tuple[Finding, ...]:
    """What lies behind the batches: their end mark; in a file its directory, with its length and a mark; then nothing."""
    size = path.stat().st_size
    if not is_file:
        with path.open("rb") as stream:
            stream.seek(max(0, end - len(_END_OF_STREAM)))
            mark = stream.read(len(_END_OF_STREAM))
        if mark == _END_OF_STREAM:
            return behind(path, end, "the stream")
        what = "the stream has no end mark: its writer was stopped, or the file is cut off between two batches"
        return (_lost("no_end_mark", what),)
    with path.open("rb") as stream:
        stream.seek(end)
        directory = stream.read(min(size - end, _SCHEMA))
    at = directory.find(_END)
    if at < 4 or int.from_bytes(directory[at - 4 : at], "little") > at - 4:
        return (_lost("broken_off", "the file breaks off: its end mark is missing"),)
    return behind(path, end + at + len(_END), "the Arrow file")


class _BatchError(Exception):
    """A batch cannot be read; the words say which."""


def _table(
    kind: str,
    found: Sequence[ArrowColumn],
    others: Sequence[str],
    notes: tuple[str, ...],
    batches: Callable[[Sequence[str]], Iterator[tuple[str, Any] | Finding]],
    rows: int | None,
    *,
    damage: str,
    findings: tuple[Finding, ...] = (),
) -> Table:
    if not found:
        raise DataError(f"has no column of numbers (columns: {', '.join(others[:12]) or 'none'})")
    twice = sorted({c.path[0] for c in found if sum(o.path == c.path and o.part == c.part for o in found) > 1})
    if twice:
        raise DataError(f"has several columns called {twice[0]!r}; name them apart")
    if others:
        notes = (*notes, f"columns of other types: {', '.join(others[:12])}")

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        pieces: dict[int, list[NDArray[Any]]] = {index: [] for index in wanted}
        fields = list(dict.fromkeys(found[index].path[0] for index in wanted))
        row, fault = 0, ""
        late: list[Finding] = []
        source = batches(fields)
        while True:
            try:
                item = next(source)
                if isinstance(item, Finding):
                    late.append(item)
                    continue
                _, batch = item
                got = {i: numbers(batch.column(found[i].path[0]), found[i], row, exact=i == exact) for i in wanted}
            except StopIteration:
                break
            except MemoryError:
                raise
            except Exception as error:
                fault = _text(error)
                break
            for index, values in got.items():
                # Of a page on disk a copy, for the file is closed; of three columns in one array no more than is wanted.
                pieces[index].append(np.array(values))
            row += batch.num_rows
        if fault:
            declared = "" if rows is None else f" of {rows}"
            late.append(_lost(damage, f"{fault}: {row}{declared} rows are read"))
            if not row:
                raise DataError(f"is damaged or cut off: {fault}; nothing can be read: get or make the file again")
        joined: dict[int, NDArray[Any]] = {}
        for index in wanted:
            held = pieces.pop(index)
            joined[index] = held[0] if len(held) == 1 else np.concatenate(held) if held else np.empty(0)
        labels = {index: repr(found[index].column.name) for index in wanted}
        return Loaded(columns=real_columns(joined, labels, exact), findings=tuple(late))

    return Table(
        format=kind,
        columns=tuple(column.column for column in found),
        notes=notes,
        load=load,
        where=lambda row: f"row {row}",
        rows=rows,
        findings=findings,
    )


def _lost(code: str, message: str) -> Finding:
    return Finding(code=code, severity="error", message=message, effect=REST_MISSING)


def _text(error: Exception) -> str:
    return str(error).split("\n")[0] or type(error).__name__


def _damaged(error: Exception) -> DataError:
    return DataError(f"is damaged or cut off ({_text(error)}); get or make the file again")
