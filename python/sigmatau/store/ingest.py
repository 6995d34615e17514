"""Results into a store: each run once, with its history."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from itertools import islice
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Literal

from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.noise.terms import TERMS
from sigmatau.store import tables
from sigmatau.store.packing import Packed, pack

if TYPE_CHECKING:
    from sqlalchemy import Engine, Table
    from sqlalchemy.engine import Connection

_SCHEMAS = (1, 2)
_ATTEMPTS = 5  # of a transaction that meets another writer

State = Literal["fitted", "not_fitted", "not_at_rest", "failed"]


@frozen
class Entry:
    """A result with what is known of its unit and its run."""

    result: Mapping[str, Any]
    unit: str
    model: str = ""
    name: str = ""  # of the run; default: the name of its log
    recorded: datetime | None = None  # with a time zone, or UTC
    temperature: float | None = None  # [degC]


@frozen
class Added:
    """What `add` did."""

    new: int = 0  # runs that were not there
    revised: int = 0  # results that replace earlier ones of the same log and options
    known: int = 0  # results that were there


def add(engine: Engine, entries: Iterable[Entry], *, batch: int = 200) -> Added:
    """Add results, `batch` of them in a transaction: what was committed stays if the process is killed.

    The same log with the same options is one run: a result that is there already is not added again, one that differs is
    a new revision of it.

    Raises
    ------
    DataError
        For a result that is none, or a database that does not take it; earlier batches stay.
    """
    total = Added()
    source = iter(entries)
    while chunk := [_prepared(entry) for entry in islice(source, batch)]:
        one = _committed(engine, chunk)
        total = Added(new=total.new + one.new, revised=total.revised + one.revised, known=total.known + one.known)
    return total


def _committed(engine: Engine, chunk: Sequence[tuple[Entry, str, Packed]]) -> Added:
    """Add results in a transaction. If another writer added the same runs meanwhile, they are compared with its rows."""
    import sqlalchemy

    from sigmatau.store.connect import reason

    for attempt in range(_ATTEMPTS):
        try:
            with engine.connect().execution_options(writes=True) as connection, connection.begin():
                return _add(connection, chunk)
        except (sqlalchemy.exc.IntegrityError, sqlalchemy.exc.OperationalError) as error:
            if attempt == _ATTEMPTS - 1 or not _may_pass(error):
                raise DataError(f"the store did not take the results: {reason(error)}") from None
        except sqlalchemy.exc.SQLAlchemyError as error:
            raise DataError(f"the store did not take the results: {reason(error)}") from None
    raise AssertionError


def _may_pass(error: Exception) -> bool:
    """Whether a second attempt may succeed: rows of another writer, or a deadlock with it."""
    import sqlalchemy

    return isinstance(error, sqlalchemy.exc.IntegrityError) or "deadlock" in str(error).lower()


def _prepared(entry: Entry) -> tuple[Entry, str, Packed]:
    """An entry with its identity, in its stored form; raises `DataError`."""
    result = entry.result
    if not isinstance(result, Mapping) or not isinstance(result.get("channels"), Mapping) or "source" not in result:
        raise DataError(f"{entry.unit}: not a result of sigmatau analyze")
    if result.get("schema", 1) not in _SCHEMAS:
        raise DataError(f"{entry.unit}: schema {result['schema']!r:.20} is of a newer version of sigmatau")
    source = result["source"]
    log = source.get("sha256") or f"{entry.unit}/{source.get('path')}"
    made_with = json.dumps([result.get("options", {}), source.get("conversions", [])], sort_keys=True)
    identity = hashlib.sha256(f"{entry.unit}\n{log}\n{made_with}".encode()).hexdigest()
    return entry, identity, pack(result)


def _add(connection: Connection, chunk: Sequence[tuple[Entry, str, Packed]]) -> Added:
    from sqlalchemy import insert, update

    known = _latest(connection, {identity for _, identity, _ in chunk})
    units = _unit_ids(connection, [entry for entry, _, _ in chunk])
    now = datetime.now(UTC).replace(tzinfo=None)
    rows: dict[tuple[str, int], dict[str, Any]] = {}
    results, replaced = [], set()
    for entry, identity, stored in chunk:
        revision, last = known.get(identity, (0, ""))
        if stored.digest == last:
            continue
        known[identity] = (revision + 1, stored.digest)
        if revision:
            replaced.add(identity)
        if (identity, revision) in rows:
            rows[identity, revision]["current"] = False
        row = _run_row(entry, now) | {"identity": identity, "revision": revision + 1, "digest": stored.digest}
        rows[identity, revision + 1] = row | {"content": stored.content, "unit_id": units[entry.unit], "current": True}
        results.append((entry.result, stored.curves))
    if replaced:
        connection.execute(update(tables.run).where(tables.run.c.identity.in_(replaced)).values(current=False))
    if rows:
        made = insert(tables.run).returning(tables.run.c.id, sort_by_parameter_order=True)
        ids = connection.execute(made, list(rows.values())).scalars().all()
        _add_contents(connection, zip(ids, results, strict=True))
    new = sum(revision == 1 for _, revision in rows)
    return Added(new=new, revised=len(rows) - new, known=len(chunk) - len(rows))


def _latest(connection: Connection, identities: set[str]) -> dict[str, tuple[int, str]]:
    """Last revision and its content, by identity."""
    from sqlalchemy import select

    run = tables.run.c
    rows = connection.execute(
        select(run.identity, run.revision, run.digest).where(run.identity.in_(identities), run.current)
    )
    return {identity: (revision, content) for identity, revision, content in rows}


def _unit_ids(connection: Connection, entries: Sequence[Entry]) -> dict[str, int]:
    """The units by name, with the type of sensor if it is stated; new ones are made."""
    from sqlalchemy import update

    models = _ids(connection, tables.model, {entry.model for entry in entries if entry.model})
    units = _ids(connection, tables.unit, {entry.unit for entry in entries})
    typed = {entry.unit: models[entry.model] for entry in entries if entry.model}
    for name, model in typed.items():
        of = tables.unit.c
        connection.execute(
            update(tables.unit).where(of.id == units[name], of.model_id.is_distinct_from(model)).values(model_id=model)
        )
    return units


def _ids(connection: Connection, table: Table, names: set[str]) -> dict[str, int]:
    """The keys of names, which are added if they are not there; another writer may add them meanwhile."""
    from sqlalchemy import select
    from sqlalchemy.dialects import postgresql, sqlite

    if not names:
        return {}
    found = select(table.c.name, table.c.id).where(table.c.name.in_(names))
    ids = {name: key for name, key in connection.execute(found)}
    if missing := sorted(names - ids.keys()):
        made = (sqlite if connection.dialect.name == "sqlite" else postgresql).insert(table)
        connection.execute(made.on_conflict_do_nothing(), [{"name": name} for name in missing])
        ids = {name: key for name, key in connection.execute(found)}
    return ids


def _run_row(entry: Entry, now: datetime) -> dict[str, Any]:
    result = entry.result
    source, channels = result["source"], result["channels"]
    path = str(source.get("path") or "")
    lengths = [one["samples"] / one["sample_rate_hz"] for one in channels.values()]
    recorded = entry.recorded
    if recorded is not None and recorded.tzinfo is not None:
        recorded = recorded.astimezone(UTC).replace(tzinfo=None)
    return {
        "name": entry.name or PurePath(path).name or entry.unit,
        "path": path,
        "sha256": source.get("sha256"),
        "recorded": recorded,
        "temperature": entry.temperature,
        "duration": max(lengths, default=None),
        "state": _state(result),
        "message": str((result.get("error") or {}).get("message", "")),
        "version": str(result.get("sigmatau", "")),
        "added": now,
    }


def _state(result: Mapping[str, Any]) -> State:
    if result.get("error"):
        return "failed"
    if any("fit" in channel for channel in result["channels"].values()):
        return "fitted"
    return "not_at_rest" if (result.get("rest") or {}).get("verdict") == "not_at_rest" else "not_fitted"


def _add_contents(
    connection: Connection, results: Iterable[tuple[int, tuple[Mapping[str, Any], Mapping[str, bytes]]]]
) -> None:
    from sqlalchemy import insert

    channels, terms, findings = [], [], []
    for run_id, (result, curves) in results:
        for name, one in result["channels"].items():
            channels.append(_channel_row(run_id, name, one) | {"curve": curves[name]})
            terms += [row | {"run_id": run_id, "channel": name} for row in _term_rows(one)]
        for one in result.get("findings", ()):
            row = {key: str(one.get(key, "")) for key in ("code", "severity", "message")}
            findings.append(row | {"run_id": run_id, "channels": " ".join(one.get("channels") or ())})
    for table, rows in ((tables.channel, channels), (tables.coefficient, terms), (tables.finding, findings)):
        if rows:
            connection.execute(insert(table), rows)


def _channel_row(run_id: int, name: str, channel: Mapping[str, Any]) -> dict[str, Any]:
    fitted = channel.get("fit") or {}
    return {
        "run_id": run_id,
        "name": name,
        "quantity": channel["quantity"],
        "unit": channel["curve"]["unit"],
        "rate": channel["sample_rate_hz"],
        "samples": channel["samples"],
        "verdict": fitted.get("verdict", ""),
        "trust": channel.get("trust", ""),
        "p_value": fitted.get("p_value"),
        "mean": (channel.get("mean") or {}).get("value"),
    }


_NUMBERS = ("value", "low", "high", "upper_limit")


def _term_rows(channel: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    for name, term in (channel.get("fit") or {}).get("terms", {}).items():
        if name in TERMS:
            yield {
                "term": name,
                "observed": term["observed"],
                **{key: term.get(key) for key in _NUMBERS},
                "level": term["level"],
                "unit": term["unit"],
            }
