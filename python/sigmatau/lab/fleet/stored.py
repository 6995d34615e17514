"""Logs of a fleet that are already in a store."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from sigmatau.errors import DataError
from sigmatau.findings.finding import WITHOUT_REST
from sigmatau.lab.fleet.logs import Log

if TYPE_CHECKING:
    from sqlalchemy import Engine
    from sqlalchemy.engine import Connection

    from sigmatau.lab.store.ingest import Added
    from sigmatau.lab.store.keeping import KeepCurves
    from sigmatau.lab.store.rows import Rows

NOT_AT_REST, DAMAGED = 5, 4
"""Exit codes of a log that was not at rest or too short to tell, and of one that was read in part."""

_AT_ONCE = 500  # number of keys in a statement


class Stored:
    """Runs of a store with given options.

    Parameters
    ----------
    engine : Engine
    options : mapping
        Options in the form of results.
    keep_curves : {"failed", "all", "none"}
        A result that is stored without its curves, but keeps them now, counts as missing.

    Raises
    ------
    DataError
        If the store cannot be read.
    """

    def __init__(self, engine: Engine, options: Mapping[str, Any], *, keep_curves: KeepCurves = "all") -> None:
        from sqlalchemy import and_, select
        from sqlalchemy.exc import SQLAlchemyError

        from sigmatau.lab.store.connect import reason
        from sigmatau.lab.store.keeping import lacks_curves
        from sigmatau.lab.store.rows import options_key
        from sigmatau.lab.store.tables import finding, place, run

        self._engine = engine
        self._is_selected = and_(run.c.current, run.c.options_key == options_key(options), run.c.file_version != "")
        columns = (
            run.c.path,
            run.c.file_version,
            run.c.state,
            run.c.id,
            run.c.recorded,
            run.c.temperature,
            run.c.supply,
        )
        lacks = lacks_curves(keep_curves).label("lacks")
        query = select(*columns, run.c.message, lacks).where(self._is_selected)
        # A finding about the whole record that is an error determines the exit code, see `sigmatau.findings.exit_code`.
        errors = select(run.c.path, run.c.file_version, finding.c.code).join_from(finding, run)
        errors = errors.where(self._is_selected, finding.c.severity == "error", finding.c.channels == "")
        copies = select(place.c.path, place.c.file_version, run.c.state).join_from(place, run).where(self._is_selected)
        self._runs: dict[str, list[tuple[str, str]]] = {}
        self._stated: dict[str, list[tuple[int, dict[str, Any]]]] = {}
        self._messages: dict[tuple[str, str], str] = {}  # of failures, by place and version
        self._lacking: set[tuple[str, str]] = set()  # place and version of results that lack their curves
        self._errors: dict[tuple[str, str], set[str]] = {}  # codes of findings, by place and version
        try:
            with engine.connect() as connection:
                for path, version, state, key, recorded, temperature, supply, message, lacking in connection.execute(
                    query
                ):
                    if lacking:
                        self._lacking.add((path, version))
                    if state == "failed":
                        self._messages[path, version] = message
                    self._runs.setdefault(path, []).append((version, state))
                    stated = {"recorded": recorded, "temperature": temperature, "supply": supply}
                    self._stated.setdefault(path, []).append((key, stated))
                for path, version, state in connection.execute(copies):
                    self._runs.setdefault(path, []).append((version, state))
                for path, version, code in connection.execute(errors):
                    self._errors.setdefault((path, version), set()).add(code)
        except SQLAlchemyError as error:
            raise DataError(f"the store cannot be read: {reason(error)}") from None

    def close(self) -> None:
        """Close the connections. SQLite then moves the written data from its log to the file."""
        self._engine.dispose()

    def has(self, log: Log, *, failures: bool = True) -> bool:
        """Whether there is a result for this version of a log, with the curves that it keeps. A failure counts unless
        `failures` is False.
        """
        if self.lacks_curves(log):
            return False
        runs = self._runs.get(log.place, ())
        return any(version == log.version and (failures or state != "failed") for version, state in runs)

    def lacks_curves(self, log: Log) -> bool:
        """Whether the result for this version of a log lacks the curves that it keeps now."""
        return (log.place, log.version) in self._lacking

    def failures(self, logs: Iterable[Log]) -> dict[str, str]:
        """Reason of the failure, by place, of each log whose present version has no other result."""
        reasons = {}
        for log in logs:
            states = {state for version, state in self._runs.get(log.place, ()) if version == log.version}
            if states == {"failed"}:
                reasons[log.place] = self._messages[log.place, log.version]
        return reasons

    def code(self, log: Log) -> int:
        """Exit code of the result for this version of a log that did not fail."""
        codes = self._errors.get((log.place, log.version), set())
        return 0 if not codes else NOT_AT_REST if codes.intersection(WITHOUT_REST) else DAMAGED

    def describe(self, stated: Mapping[str, Mapping[str, Any]]) -> int:
        """Set the time, temperature or supply voltage of existing runs of logs by place; return the number of changed runs.

        Raises
        ------
        DataError
            If the store refuses a value.
        """
        from sqlalchemy import update

        from sigmatau.lab.store.ingest import add_rows
        from sigmatau.lab.store.tables import run

        news = {
            key: values
            for place, values in stated.items()
            for key, stated_before in self._stated.get(place, ())
            if any(stated_before[name] != value for name, value in values.items())
        }
        if not news:
            return 0

        def change(connection: Connection) -> None:
            for key, values in news.items():
                connection.execute(update(run).where(run.c.id == key).values(values))

        add_rows(self._engine, [], then=change)
        return len(news)

    def add(self, rows: Sequence[Rows], logs: Iterable[Log]) -> Added:
        """Add the results of logs in one transaction. Raises `DataError`.

        Results of earlier versions of the logs, and old failures, become history. If the result of a changed log is the
        same, its row remains and gets the version of the log.
        """
        from sigmatau.lab.store.ingest import add_rows

        stored_logs = [log for log in logs if log.place in self._runs]

        def settle(connection: Connection) -> None:
            for start in range(0, len(stored_logs), _AT_ONCE):
                self._settle(connection, {log.place: log for log in stored_logs[start : start + _AT_ONCE]})

        return add_rows(self._engine, rows, then=settle)

    def _settle(self, connection: Connection, logs: Mapping[str, Log]) -> None:
        from sqlalchemy import select, update

        from sigmatau.lab.store.tables import run

        query = select(run.c.id, run.c.path, run.c.file_version, run.c.state).order_by(run.c.id)
        rows = connection.execute(query.where(self._is_selected, run.c.path.in_(logs))).all()
        by_place: dict[str, list[tuple[int, str, str]]] = {}
        for key, path, version, state in rows:
            by_place.setdefault(path, []).append((key, version, state))
        past: list[int] = []
        for place, runs in by_place.items():
            version = logs[place].version
            current = [key for key, stored, state in runs if stored == version and state != "failed"]
            current = current or [key for key, stored, _ in runs if stored == version]
            if not current:
                current = [runs[-1][0]]
                connection.execute(update(run).where(run.c.id == current[-1]).values(file_version=version))
            past += [key for key, _, _ in runs if key != current[-1]]
        if past:
            connection.execute(update(run).where(run.c.id.in_(past)).values(current=False))
