"""The numeric columns of an Arrow schema."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.io.read.formats.arrays import WIDEST, parts, pick
from sigmatau.io.read.table import Column
from sigmatau.io.read.time.rows import NO_STAMP

__all__ = ["ArrowColumn", "columns_of", "is_list", "numbers", "with_sizes"]

_INDEX = re.compile(r"^__index_level_\d+__$")  # pandas, of an index without a name


@dataclass(frozen=True, slots=True, kw_only=True)
class ArrowColumn:
    """A numeric column of an Arrow table."""

    column: Column
    path: tuple[str, ...]  # The field, and the fields within it if it is a struct
    part: tuple[int, ...] = ()  # Index of the element, if the field is a list of fixed size


def columns_of(schema: Any) -> tuple[list[ArrowColumn], list[str]]:  # noqa: ANN401  pyarrow has no types
    """The numeric columns of an Arrow schema, and the names of its other fields."""
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
    """The numbers of a column; a null is NaN, or the smallest integer in times and in an exact column."""
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
    if pa.types.is_fixed_size_list(array.type) or is_list(array.type):
        size = _size_of(array, column, row) if is_list(array.type) else array.type.list_size
        lists = array.drop_null()  # the values of a null list are undefined
        held: NDArray[Any] = pick(lists.flatten().to_numpy(zero_copy_only=False).reshape(-1, size), column.part)
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


def is_list(kind: Any) -> bool:  # noqa: ANN401
    """Whether a type is a list of variable length."""
    import pyarrow as pa

    return bool(pa.types.is_list(kind) or pa.types.is_large_list(kind))


def _size_of(array: Any, column: ArrowColumn, row: int) -> int:  # noqa: ANN401
    """The length of all lists; raises `DataError` if they differ."""
    lengths = np.asarray(array.drop_null().value_lengths())
    size = int(lengths[0]) if len(lengths) else 1
    if (lengths != size).any() or column.part[0] >= size:
        raise DataError(f"column {'.'.join(column.path)!r} has lists of unequal length, after row {row}")
    return size


def with_sizes(schema: Any, first: Any) -> Any:  # noqa: ANN401
    """A schema with lists of the size of the first row, because pandas writes lists of variable size."""
    import pyarrow as pa

    for k, field in enumerate(schema):
        if is_list(field.type) and len(first) and first.column(field.name)[0].is_valid:
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
