"""Whole results of a store."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from sigmatau.lab.store.packing import unpack

if TYPE_CHECKING:
    from sqlalchemy.engine import Connection

READ = 100
"""Results that are read at a time."""


def contents(
    connection: Connection, keys: Sequence[int], *, without_damaged: bool = False
) -> Iterator[tuple[int, dict[str, Any]]]:
    """Keys of runs with their results as they were added; raises `DataError` for damaged content, or leaves it out."""
    from sqlalchemy import select

    from sigmatau.errors import DataError
    from sigmatau.lab.store.tables import result

    asked = select(result.c.run_id, result.c.content, result.c.curves)
    for start in range(0, len(keys), READ):
        for key, content, curves in connection.execute(asked.where(result.c.run_id.in_(keys[start : start + READ]))):
            try:
                result_as_added = unpack(content, curves)
            except DataError:
                if without_damaged:
                    continue
                raise
            yield key, result_as_added
