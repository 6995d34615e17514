"""Numeric columns of Arrow tables, read batch by batch up to the first batch that cannot be read."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import Place
from sigmatau.findings.wording import sentence
from sigmatau.frozen import frozen
from sigmatau.io.read.formats.arrays import MAX_COLUMNS, parts, pick, real_columns
from sigmatau.io.read.formats.damage import fault, first_line
from sigmatau.io.read.table import Column, Loaded, Table
from sigmatau.io.read.time.dates import NO_STAMP

_INDEX = re.compile(r"^__index_level_\d+__$")  # pandas' name of an index without a name


@frozen
class ArrowColumn:
    """A numeric column of an Arrow table."""

    column: Column
    path: tuple[str, ...]  # The field, and the fields within it if it is a struct
    part: tuple[int, ...] = ()  # Index of the element, if the field is a list of fixed size


def find_numeric_columns(schema: Any) -> tuple[list[ArrowColumn], list[str]]:  # noqa: ANN401  pyarrow has no types
    """The numeric columns of an Arrow schema, and the names of its other fields."""
    import pyarrow as pa

    chosen: list[ArrowColumn] = []
    skipped: list[str] = []

    def look(field: Any, above: tuple[str, ...]) -> None:  # noqa: ANN401
        path = (*above, field.name)
        name, kind = ".".join(path), field.type
        if pa.types.is_timestamp(kind) or pa.types.is_duration(kind):
            label = "time" if _INDEX.match(name) else name
            chosen.append(ArrowColumn(column=Column(name=label, unit=kind.unit), path=path))
        elif pa.types.is_integer(kind) or pa.types.is_floating(kind):
            chosen.append(ArrowColumn(column=Column(name=name, unit=_unit(field)), path=path))
        elif pa.types.is_struct(kind):
            for inner in kind:
                look(inner, path)
        elif (
            pa.types.is_fixed_size_list(kind)
            and kind.list_size <= MAX_COLUMNS
            and (pa.types.is_integer(kind.value_type) or pa.types.is_floating(kind.value_type))
        ):
            for label, part in parts(name, (kind.list_size,)):
                chosen.append(ArrowColumn(column=Column(name=label, unit=_unit(field)), path=path, part=part))
        else:
            skipped.append(name)

    for field in schema:
        look(field, ())
    return chosen, skipped


def numbers(array: Any, column: ArrowColumn, *, exact: bool = False) -> NDArray[Any]:  # noqa: ANN401
    """Read the numbers of a column. A null becomes NaN, or the smallest integer in times and in an exact column."""
    import pyarrow as pa

    if isinstance(array, pa.ChunkedArray):
        array = array.combine_chunks()
        array = array if not isinstance(array, pa.ChunkedArray) else pa.concat_arrays(array.chunks)
    array.validate(full=True)
    for name in column.path[1:]:
        array = (
            array.field(name)
            if not array.null_count and array.offset == 0 and len(array) == len(array.field(name))
            else array.flatten()[array.type.get_field_index(name)]  # with the nulls of the struct
        )
    if pa.types.is_fixed_size_list(array.type):
        lists = array.drop_null().flatten()  # the values of a null list are undefined
        held: NDArray[Any] = pick(lists.to_numpy(zero_copy_only=False).reshape(-1, array.type.list_size), column.part)
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


def _unit(field: Any) -> str | None:  # noqa: ANN401
    for key, value in (field.metadata or {}).items():
        if key.lower() in (b"unit", b"units"):
            return str(value.decode("utf-8", "replace"))
    return None


class BatchError(Exception):
    """A batch that cannot be read: its place and the reason."""


def make_table(
    kind: str,
    chosen: Sequence[ArrowColumn],
    skipped: Sequence[str],
    notes: tuple[str, ...],
    batches: Callable[[Sequence[str]], Iterator[tuple[Place, Any] | Finding]],
    rows: int | None,
    *,
    truncated: bool = False,
) -> Table:
    """Build the table of these columns, read batch by batch. `truncated`: whether truncation explains an unreadable
    batch.
    """
    if not chosen:
        raise DataError(f"has no column of numbers (columns: {', '.join(skipped[:12]) or 'none'})")
    twice = sorted({c.path[0] for c in chosen if sum(o.path == c.path and o.part == c.part for o in chosen) > 1})
    if twice:
        raise DataError(f"has several columns called {twice[0]!r}; name them apart")
    columns = tuple(column.column for column in chosen)
    if skipped:
        notes = (*notes, f"columns of other types: {', '.join(skipped[:12])}")

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        pieces: dict[int, list[NDArray[Any]]] = {index: [] for index in wanted}
        fields = list(dict.fromkeys(chosen[index].path[0] for index in wanted))
        row = 0
        broken: BatchError | None = None
        late: list[Finding] = []
        source = batches(fields)
        while True:
            place: Place | None = None
            try:
                item = next(source)
                if isinstance(item, Finding):
                    late.append(item)
                    continue
                place, batch = item
                got = {i: numbers(batch.column(chosen[i].path[0]), chosen[i], exact=i == exact) for i in wanted}
            except StopIteration:
                break
            except (MemoryError, DataError):
                raise
            except BatchError as error:
                broken = error
                break
            except Exception as error:
                broken = BatchError(place, first_line(error))
                break
            for index, values in got.items():
                # A copy, because the file is closed later, and so that a column does not keep an array of three columns
                # in memory.
                pieces[index].append(np.array(values))
            row += batch.num_rows
        if broken is not None:
            place, reason = broken.args
            late.append(fault(truncated=truncated, place=place, reason=reason, kept=row, declared=rows))
            if not row:
                raise DataError(f"no rows can be read: {sentence(late[-1])}")
        joined: dict[int, NDArray[Any]] = {}
        for index in wanted:
            held = pieces.pop(index)
            joined[index] = held[0] if len(held) == 1 else np.concatenate(held) if held else np.empty(0)
        return Loaded(columns=real_columns(joined, columns), findings=tuple(late))

    def words(name: str) -> NDArray[Any]:
        try:
            held = [item[1].column(name) for item in batches([name]) if not isinstance(item, Finding)]
            return np.concatenate([np.asarray(column.to_pylist(), dtype=object) for column in held])
        except Exception as error:
            raise DataError(f"column {name!r} cannot be read: {first_line(error)}") from None

    texts = {name: lambda name=name: words(name) for name in skipped if "." not in name}
    return Table(format=kind, columns=columns, notes=notes, load=load, rows=rows, words=texts)
