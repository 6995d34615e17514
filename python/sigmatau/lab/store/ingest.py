"""Adds results to a store. A run has one current result; replaced ones are kept as its history."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import UTC, datetime
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.lab.store.packing import NUMBERS
from sigmatau.lab.store.rows import Entry, Label, Rows, make_rows

if TYPE_CHECKING:
    from sqlalchemy import Engine, Table
    from sqlalchemy.engine import Connection

BATCH = 200
"""Number of runs in a transaction."""

_STATED = ("recorded", "temperature", "supply")  # facts about a run that the user may state
_ATTEMPTS = 5  # largest number of attempts for a transaction that conflicts with another writer


@frozen
class Added:
    """Result of `add`.

    Attributes
    ----------
    new : int
        Number of new runs.
    revised : int
        Number of results that replace earlier ones of the same log and options.
    updated : int
        Number of results that were already there, of which a time, temperature, supply voltage or the curves are new.
    known : int
        Number of other results that were already stored.
    """

    new: int = 0
    revised: int = 0
    updated: int = 0
    known: int = 0

    def __add__(self, other: Added) -> Added:
        return Added(
            new=self.new + other.new,
            revised=self.revised + other.revised,
            updated=self.updated + other.updated,
            known=self.known + other.known,
        )


def add(engine: Engine, entries: Iterable[Entry], *, batch: int = BATCH) -> Added:
    """Add results in transactions of `batch` results. Committed results remain if the process is killed.

    The same log with the same options is one run. An identical result is not added again; a different one becomes a new
    revision.

    Raises
    ------
    DataError
        For an entry that is not a result, or a result that the database refuses; earlier batches remain.
    """
    total = Added()
    source = iter(entries)
    while chunk := [_named(entry) for entry in islice(source, batch)]:
        total += add_rows(engine, chunk)
    return total


def _named(entry: Entry) -> Rows:
    try:
        return make_rows(entry)
    except DataError as error:
        raise DataError(f"{entry.unit}: {error}") from None


def add_rows(engine: Engine, chunk: Sequence[Rows], *, then: Callable[[Connection], None] = lambda _: None) -> Added:
    """Add results with all dependent rows in one transaction.

    `then` is called in the same transaction. If another writer adds the same runs at the same time, the transaction is
    repeated and compares the results with its rows.
    """
    import sqlalchemy

    from sigmatau.lab.store.connect import reason

    driver: type[Exception] = engine.dialect.loaded_dbapi.Error
    for attempt in range(_ATTEMPTS):
        try:
            with engine.connect().execution_options(writes=True) as connection, connection.begin():
                added = _add(connection, chunk)
                then(connection)
                return added
        except (sqlalchemy.exc.SQLAlchemyError, driver) as error:
            if attempt == _ATTEMPTS - 1 or not _may_succeed(error):
                raise DataError(f"the results cannot be added to the store: {reason(error)}") from None
    raise AssertionError


def _may_succeed(error: Exception) -> bool:
    """Whether a second attempt may succeed: the error is a conflict of rows, or a deadlock."""
    kind = type(getattr(error, "orig", None) or error)
    same_rows = any(base.__name__ == "IntegrityError" for base in kind.__mro__)
    return same_rows or "deadlock" in str(error).lower()


def _add(connection: Connection, chunk: Sequence[Rows]) -> Added:
    from sqlalchemy import insert, update

    from sigmatau.lab.store import tables

    last_revisions = _latest(connection, {rows_.identity for rows_ in chunk})
    units = _unit_ids(connection, chunk)
    now = datetime.now(UTC).replace(tzinfo=None)
    runs: dict[tuple[str, int], dict[str, Any]] = {}
    results, replaced, updated = [], set(), 0
    places: list[
        tuple[str, int | None, str, str]
    ] = []  # identity and key of runs, further paths, versions of the files
    for rows_ in chunk:
        last = last_revisions.get(rows_.identity, _NONE)
        if last.has(rows_):
            if rows_.run["file_version"] and last.path != rows_.run["path"]:
                is_moved = last.id is not None and last.has_moved(rows_)
                further = (last.path, last.version) if is_moved else (rows_.run["path"], rows_.run["file_version"])
                places.append((rows_.identity, last.id, *further))
            if last.id is not None and (news := last.news(rows_)):
                connection.execute(update(tables.run).where(tables.run.c.id == last.id).values(news))
                if "has_curves" in news:
                    stored = tables.result.c.run_id == last.id
                    connection.execute(update(tables.result).where(stored).values(curves=rows_.packed.curves))
                updated += not news.keys().isdisjoint((*_STATED, "has_curves"))
            continue
        revision = last.revision + 1
        last_revisions[rows_.identity] = _Last(
            revision=revision, digest=rows_.packed.digest, path=rows_.run["path"], version=rows_.run["file_version"]
        )
        if last.revision:
            replaced.add(rows_.identity)
        if (rows_.identity, last.revision) in runs:
            runs[rows_.identity, last.revision]["current"] = False
        keys = {"unit_id": units[rows_.unit], "identity": rows_.identity, "revision": revision}
        runs[rows_.identity, revision] = {**rows_.run, **keys, "current": True, "added": now}
        results.append(rows_)
    if replaced:
        connection.execute(update(tables.run).where(tables.run.c.identity.in_(replaced)).values(current=False))
    if runs:
        ids = _new_ids(connection, len(runs))
        rows = [{**row, "id": key} for key, row in zip(ids, runs.values(), strict=True)]
        connection.execute(insert(tables.run), rows)
        _add_contents(connection, ids, results)
        _replace_failed(connection, rows)
    _add_places(connection, places, {row["identity"]: row["id"] for row in rows} if runs else {})
    new = sum(revision == 1 for _, revision in runs)
    return Added(new=new, revised=len(runs) - new, updated=updated, known=len(chunk) - len(runs) - updated)


def _add_places(
    connection: Connection, places: Iterable[tuple[str, int | None, str, str]], new: Mapping[str, int]
) -> None:
    """Add further places of the logs of runs, with the keys of the `new` runs by identity."""
    from sqlalchemy import delete, insert

    from sigmatau.lab.store.tables import place

    versions = {(new[each] if key is None else key, path): version for each, key, path, version in places}
    for (key, path), version in versions.items():
        connection.execute(delete(place).where(place.c.run_id == key, place.c.path == path))
        connection.execute(insert(place).values(run_id=key, path=path, file_version=version))


def _replace_failed(connection: Connection, rows: Sequence[dict[str, Any]]) -> None:
    """Mark a failure as replaced if its log now has a result."""
    from sqlalchemy import select, update

    from sigmatau.lab.store import tables

    run = tables.run.c
    with_result = {(row["unit_id"], row["path"]): row["id"] for row in rows if row["state"] != "failed" and row["path"]}
    units = {unit for unit, _ in with_result}
    failed = connection.execute(
        select(run.id, run.unit_id, run.path).where(run.unit_id.in_(units), run.current, run.state == "failed")
    )
    ids = [key for key, unit, path in failed if key < with_result.get((unit, path), 0)]
    if ids:
        connection.execute(update(tables.run).where(run.id.in_(ids)).values(current=False))


@frozen
class _Last:
    """The last revision of a run, as far as it is compared with a new result."""

    revision: int = 0  # 0 if the run is new
    digest: str = ""
    path: str = ""
    version: str = ""  # version of its log
    current: bool = True
    recorded: datetime | None = None
    temperature: float | None = None
    supply: float | None = None
    has_curves: bool | None = None
    id: int | None = None  # None if it is not in the database yet

    def has(self, rows: Rows) -> bool:
        """Whether a result is the same. If a log has returned to an earlier version, its result is a new revision."""
        has_returned = not self.current and rows.run["file_version"]
        return bool(self.revision and self.digest == rows.packed.digest and not has_returned)

    def has_moved(self, rows: Rows) -> bool:
        """Whether the log was moved, or is an object; otherwise another file is a copy of it."""
        return self.path != rows.run["path"] and not os.path.exists(self.path)  # noqa: PTH110  may be a URL

    def news(self, rows: Rows) -> dict[str, Any]:
        """Changed facts about the same log: its place, its time of change, stated facts about its run, and curves that
        were not kept before.
        """
        changes: dict[str, Any] = {}
        is_touched = self.path == rows.run["path"] and self.version != rows.run["file_version"]
        if rows.run["file_version"] and (is_touched or self.has_moved(rows)):
            changes = {key: rows.run[key] for key in ("path", "file_version", "name")}
        for key in _STATED:
            before = getattr(self, key)
            if rows.run[key] not in (None, before) and (before is None or key not in rows.measured):
                changes[key] = rows.run[key]
        if rows.run["has_curves"] and not self.has_curves:
            changes["has_curves"] = True
        return changes


_NONE = _Last()


def _latest(connection: Connection, identities: set[str]) -> dict[str, _Last]:
    """Last revision by identity. It is not current if the log has changed, or if it is a failure of a log that now has a
    result.
    """
    from sqlalchemy import select

    from sigmatau.lab.store import tables

    run = tables.run.c
    rows = connection.execute(
        select(
            run.identity,
            run.revision,
            run.digest,
            run.path,
            run.file_version,
            run.current,
            run.recorded,
            run.temperature,
            run.supply,
            run.has_curves,
            run.id,
        )
        .where(run.identity.in_(identities))
        .order_by(run.revision)
    )
    fields = ("revision", "digest", "path", "version", "current", *_STATED, "has_curves", "id")
    return {identity: _Last(**dict(zip(fields, values, strict=True))) for identity, *values in rows}


def _new_ids(connection: Connection, count: int) -> list[int]:
    """Keys of new runs: from a sequence, or after the last key in SQLite, where no other process can write."""
    if connection.dialect.name == "sqlite":
        last = connection.exec_driver_sql("SELECT coalesce(max(id), 0) FROM run").scalar_one()
        return list(range(last + 1, last + 1 + count))
    made = f"SELECT nextval(pg_get_serial_sequence('run', 'id')) FROM generate_series(1, {count})"
    return list(connection.exec_driver_sql(made).scalars())


def _unit_ids(connection: Connection, chunk: Sequence[Rows]) -> dict[str, int]:
    """Keys of units by name. New units are added, and stated sensor models are updated."""
    from sqlalchemy import update

    from sigmatau.lab.store import tables

    models = _ids(connection, tables.model, {rows.model for rows in chunk if rows.model})
    units = _ids(connection, tables.unit, {rows.unit for rows in chunk})
    typed = {rows.unit: models[rows.model] for rows in chunk if rows.model}
    columns = tables.unit.c
    for model in set(typed.values()):
        unit_ids = [units[name] for name, model_id in typed.items() if model_id == model]
        wrong = (columns.id.in_(unit_ids), columns.model_id.is_distinct_from(model))
        connection.execute(update(tables.unit).where(*wrong).values(model_id=model))
    return units


def _ids(connection: Connection, table: Table, names: set[str]) -> dict[str, int]:
    """Keys of names. Missing names are added; another writer may add them at the same time."""
    from sqlalchemy import select

    if not names:
        return {}
    query = select(table.c.name, table.c.id).where(table.c.name.in_(names))
    ids = _pairs(connection.execute(query))
    if missing := sorted(names - ids.keys()):
        _add_missing(connection, table, [{"name": name} for name in missing])
        ids = _pairs(connection.execute(query))
    return ids


def _pairs(rows: Iterable[Any]) -> dict[str, int]:
    return {row[0]: row[1] for row in rows}


def _label_ids(connection: Connection, needed: set[Label]) -> dict[Label, int]:
    """Keys of labels. New labels are added; a store has few labels."""
    from sqlalchemy import select

    from sigmatau.lab.store import tables

    label = tables.label.c
    columns = (label.channel, label.quantity, label.term, label.unit, label.rate_unit)

    def read_ids() -> dict[Label, int]:
        return {(c, q, t, u, r): key for key, c, q, t, u, r in connection.execute(select(label.id, *columns))}

    ids = read_ids()
    if missing := sorted(needed - ids.keys()):
        names = [column.name for column in columns]
        _add_missing(connection, tables.label, [dict(zip(names, label, strict=True)) for label in missing])
        ids = read_ids()
    return ids


def _add_missing(connection: Connection, table: Table, rows: list[dict[str, Any]]) -> None:
    from sqlalchemy.dialects import postgresql, sqlite

    made = (sqlite if connection.dialect.name == "sqlite" else postgresql).insert(table)
    connection.execute(made.on_conflict_do_nothing(), rows)


def _add_contents(connection: Connection, ids: Sequence[int], results: Sequence[Rows]) -> None:
    from sigmatau.lab.store import tables

    label_ids = _label_ids(connection, {label for rows in results for label in rows.labels})
    ids_by_labels = {labels: [label_ids[label] for label in labels] for labels in {rows.labels for rows in results}}
    stored, channels, terms, findings = [], [], [], []
    for key, rows in zip(ids, results, strict=True):
        labels = ids_by_labels[rows.labels]
        numbers = np.frombuffer(rows.numbers, dtype=NUMBERS).copy()
        numbers["label"] = labels
        stored.append((key, rows.packed.content, rows.packed.curves, numbers.tobytes()))
        channels += [(key, *row) for row in rows.channels]
        terms += [(key, label, *row) for label, row in zip(labels, rows.terms, strict=True)]
        findings += [(key, *row) for row in rows.findings]
    _bulk(connection, tables.result, ("run_id", "content", "curves", "numbers"), stored)
    _bulk(connection, tables.channel, _CHANNEL, channels)
    _bulk(connection, tables.coefficient, _COEFFICIENT, terms)
    _bulk(connection, tables.finding, ("run_id", "code", "severity", "channels", "message"), findings)


_CHANNEL = ("run_id", "name", "quantity", "unit", "rate", "samples", "verdict", "trust", "p_value")
_COEFFICIENT = ("run_id", "label_id", "observed", "value", "low", "high", "upper_limit", "level")


def _bulk(connection: Connection, table: Table, columns: Sequence[str], rows: Sequence[tuple[Any, ...]]) -> None:
    """Insert rows by the fastest method of the driver: SQLAlchemy with rows as dictionaries takes ten times longer."""
    if not rows:
        return
    names = ", ".join(columns)
    if connection.dialect.name == "sqlite":
        marks = ", ".join("?" * len(columns))
        connection.exec_driver_sql(f"INSERT INTO {table.name} ({names}) VALUES ({marks})", list(rows))
        return
    with _cursor(connection) as cursor, cursor.copy(f'COPY "{table.name}" ({names}) FROM STDIN') as copy:
        for row in rows:
            copy.write_row(row)


def _cursor(connection: Connection) -> Any:  # noqa: ANN401  its type is that of the driver
    return connection.connection.cursor()
