"""`Store`: results of many units and runs, kept, found again and followed over time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.results import Tabular, plain
from sigmatau.store.ingest import Added
from sigmatau.store.rows import Entry

if TYPE_CHECKING:
    from sqlalchemy import ColumnElement, Select
    from sqlalchemy.engine import Connection

_READ = 100  # results that are read at a time


@frozen
class Chosen:
    """Which runs: all that are current, or those of units, of a sensor model, of a state, or of a time."""

    units: tuple[str, ...] = ()  # names; with a * any that begin or end so
    model: str | None = None
    states: tuple[str, ...] = ()
    since: datetime | None = None  # UTC
    until: datetime | None = None
    history: bool = False  # whether results that were replaced are chosen too


@frozen(kw_only=False)
class Table(Tabular):
    """Rows of a store."""

    content: Mapping[str, list[Any]]

    def columns(self) -> dict[str, list[Any]]:
        """The table by column; see `Tabular.columns`."""
        return dict(self.content)

    def __len__(self) -> int:
        return len(next(iter(self.content.values()), ()))

    def to_dict(self) -> dict[str, Any]:
        return plain(self, "content")["content"]

    def __repr__(self) -> str:
        head, rows = list(self.content), list(zip(*self.content.values(), strict=True))
        texts = [head, *([_text(value) for value in row] for row in rows)]
        widths = [max(len(row[k]) for row in texts) for k in range(len(head))]
        return "\n".join(
            "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in texts
        )


def _text(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, datetime):
        return f"{value:%Y-%m-%d %H:%M}"
    return "" if value is None else str(value)


class Store:
    """A database of results.

    Parameters
    ----------
    place : str or Path
        A SQLite file, or the URL of a PostgreSQL database, ``postgresql://USER@HOST/NAME``.
    create : bool
        Whether a file that is not there is made.

    Raises
    ------
    OptionError
        For a URL of another database.
    DataError
        For a place that is not a store, or cannot be reached.
    ImportError
        Without SQLAlchemy and Alembic.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> record = st.Record.from_arrays(rate=100, gyro_x=np.random.default_rng(1).normal(size=9000), unit={"gyro": "rad/s"})
    >>> with st.Store("doctest.db") as store:  # doctest: +SKIP
    ...     store.add(st.analyze(record), unit="A1")
    ...     print(store.coefficients(term="random_walk"))
    """

    def __init__(self, place: str | Path, *, create: bool = True) -> None:
        from sigmatau.store.connect import engine_of

        self._engine = engine_of(place, create=create)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the connections."""
        self._engine.dispose()

    def add(self, entries: Iterable[Entry], *, batch: int = 200) -> Added:
        """Add results; see `sigmatau.store.ingest.add`."""
        from sigmatau.store.ingest import add

        return add(self._engine, entries, batch=batch)

    @contextmanager
    def _read(self) -> Iterator[Connection]:
        from sqlalchemy.exc import SQLAlchemyError

        from sigmatau.store.connect import reason

        try:
            with self._engine.connect() as connection:
                yield connection
        except SQLAlchemyError as error:
            raise DataError(f"the store cannot be read: {reason(error)}") from None

    def _table(self, query: Select[Any]) -> Table:
        with self._read() as connection:
            found = connection.execute(query)
            names, rows = list(found.keys()), found.all()
        columns = [list(column) for column in zip(*rows, strict=True)] if rows else [[] for _ in names]
        return Table(dict(zip(names, columns, strict=True)))

    def units(self, chosen: Chosen | None = None) -> Table:
        """A row a unit: name, sensor model, runs by state, first and last time."""
        from sqlalchemy import case, func, select

        from sigmatau.store.tables import model, run, unit

        def count(state: str) -> ColumnElement[int]:
            return func.sum(case((run.c.state == state, 1), else_=0)).label(state)

        query = (
            select(
                unit.c.name.label("unit"), model.c.name.label("model"), func.count().label("runs"),
                *(count(state) for state in ("fitted", "not_at_rest", "failed")),
                func.min(run.c.recorded).label("first"), func.max(run.c.recorded).label("last"),
            )
            .join_from(unit, run).outerjoin(model, unit.c.model_id == model.c.id)
            .where(*_conditions(chosen)).group_by(unit.c.name, model.c.name).order_by(unit.c.name)
        )  # fmt: skip
        return self._table(query)

    def runs(self, chosen: Chosen | None = None) -> Table:
        """A row a run: unit, name, time, state, and why it failed."""
        from sqlalchemy import select

        from sigmatau.store.tables import model, run, unit

        query = (
            select(
                run.c.id, unit.c.name.label("unit"), model.c.name.label("model"), run.c.name.label("run"),
                run.c.recorded, run.c.temperature, run.c.duration, run.c.state, run.c.revision, run.c.version,
                run.c.message,
            )
            .join_from(run, unit).outerjoin(model, unit.c.model_id == model.c.id)
            .where(*_conditions(chosen)).order_by(unit.c.name, run.c.recorded, run.c.id)
        )  # fmt: skip
        return self._table(query)

    def coefficients(
        self, chosen: Chosen | None = None, *, term: str | None = None, channel: str | None = None
    ) -> Table:
        """A row a run, channel and term: value with interval, or limit, in SI."""
        from sqlalchemy import and_, select

        from sigmatau.store import tables

        one, label, of, run = tables.coefficient.c, tables.label.c, tables.channel.c, tables.run.c
        query = (
            select(
                tables.unit.c.name.label("unit"), run.name.label("run"), run.recorded, run.temperature, label.channel,
                label.term, one.observed, one.value, one.low, one.high, one.upper_limit, one.level,
                label.unit.label("si"), of.verdict, of.trust,
            )
            .join_from(tables.coefficient, tables.label)
            .join(tables.channel, and_(of.run_id == one.run_id, of.name == label.channel))
            .join(tables.run, one.run_id == run.id)
            .join(tables.unit, run.unit_id == tables.unit.c.id)
            .outerjoin(tables.model, tables.unit.c.model_id == tables.model.c.id)
            .where(*_conditions(chosen))
            .order_by(tables.unit.c.name, run.recorded, run.id, label.channel, label.id)
        )  # fmt: skip
        if term is not None:
            query = query.where(label.term == term)
        if channel is not None:
            query = query.where(label.channel == channel)
        return self._table(query)

    def results(self, chosen: Chosen | None = None) -> Iterator[tuple[Mapping[str, Any], dict[str, Any]]]:
        """Each run, as in `runs`, with its result as it was added."""
        from sqlalchemy import select

        from sigmatau.store.packing import unpack
        from sigmatau.store.tables import result

        table = self.runs(chosen).columns()
        rows = [dict(zip(table, row, strict=True)) for row in zip(*table.values(), strict=True)]
        for at in range(0, len(rows), _READ):
            part = rows[at : at + _READ]
            found = select(result.c.run_id, result.c.content, result.c.curves)
            with self._read() as connection:
                asked = connection.execute(found.where(result.c.run_id.in_([row["id"] for row in part])))
                contents = {key: (content, curves) for key, content, curves in asked}
            for row in part:
                yield row, unpack(*contents[row["id"]])


def _conditions(chosen: Chosen | None) -> list[ColumnElement[bool]]:
    from sqlalchemy import or_

    from sigmatau.store.tables import model, run, unit

    one = chosen or Chosen()
    found: list[ColumnElement[bool]] = [] if one.history else [run.c.current]
    if one.units:
        found.append(or_(*(unit.c.name.like(_pattern(name), escape="\\") for name in one.units)))
    if one.model is not None:
        found.append(model.c.name == one.model)
    if one.states:
        found.append(run.c.state.in_(one.states))
    if one.since is not None:
        found.append(run.c.recorded >= one.since)
    if one.until is not None:
        found.append(run.c.recorded < one.until)
    return found


def _pattern(name: str) -> str:
    for special in ("\\", "%", "_"):
        name = name.replace(special, "\\" + special)
    return name.replace("*", "%")
