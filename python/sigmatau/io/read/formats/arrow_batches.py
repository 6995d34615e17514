"""The batches of an Arrow table, joined up to the first that cannot be read."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.reading import Damage, Place
from sigmatau.findings.wording import sentence
from sigmatau.io.read.formats.arrays import real_columns
from sigmatau.io.read.formats.arrow_columns import ArrowColumn, numbers
from sigmatau.io.read.formats.library_errors import first_line
from sigmatau.io.read.table import Loaded, Table

__all__ = ["BatchError", "table_of"]


class BatchError(Exception):
    """A batch that cannot be read; the arguments are fields of `sigmatau.findings.kinds.reading.Damage`."""

    def __init__(self, place: Place | None, **fields: Any) -> None:  # noqa: ANN401
        super().__init__(place)
        self.fields = {"place": place, **fields}


def table_of(
    kind: str,
    found: Sequence[ArrowColumn],
    others: Sequence[str],
    notes: tuple[str, ...],
    batches: Callable[[Sequence[str]], Iterator[tuple[Place, Any] | Finding]],
    rows: int | None,
    *,
    damage: type[Damage],
    findings: tuple[Finding, ...] = (),
) -> Table:
    """The table of these columns, read batch by batch; `damage` is the kind of finding for a batch that cannot be read."""
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
        row = 0
        fault: BatchError | None = None
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
                got = {i: numbers(batch.column(found[i].path[0]), found[i], row, exact=i == exact) for i in wanted}
            except StopIteration:
                break
            except MemoryError:
                raise
            except BatchError as error:
                fault = error
                break
            except Exception as error:
                fault = BatchError(place, reason=first_line(error))
                break
            for index, values in got.items():
                # A copy: the file is closed later, and an array of three columns is not kept for one.
                pieces[index].append(np.array(values))
            row += batch.num_rows
        if fault is not None:
            details = damage(**fault.fields, measured="rows", kept=row, declared=rows)
            late.append(Finding(details=details, severity="error"))
            if not row:
                raise DataError(f"no rows can be read: {sentence(late[-1])}")
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
