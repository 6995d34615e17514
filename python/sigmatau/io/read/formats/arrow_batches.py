"""Batches of an Arrow table, put together up to the first that cannot be read."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.io.read.formats.arrays import real_columns
from sigmatau.io.read.formats.arrow_columns import ArrowColumn, numbers
from sigmatau.io.read.table import REST_MISSING, Loaded, Table

__all__ = ["BatchError", "rest_lost", "table_of", "text_of"]


class BatchError(Exception):
    """A batch cannot be read; the words say which."""


def table_of(
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
    """The table of these columns, read batch by batch; `damage` is the code of a batch that cannot be."""
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
                fault = text_of(error)
                break
            for index, values in got.items():
                # Of a page on disk a copy, for the file is closed; of three columns in one array no more than is wanted.
                pieces[index].append(np.array(values))
            row += batch.num_rows
        if fault:
            declared = "" if rows is None else f" of {rows}"
            late.append(rest_lost(damage, f"{fault}: {row}{declared} rows are read"))
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


def rest_lost(code: str, message: str) -> Finding:
    """That what follows is not read, as an error."""
    return Finding(code=code, severity="error", message=message, effect=REST_MISSING)


def text_of(error: Exception) -> str:
    """The first line of an error of pyarrow."""
    return str(error).split("\n")[0] or type(error).__name__
