"""Connections to a store: a SQLite file, or PostgreSQL by URL; its tables are created when it is first opened."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from sigmatau.errors import DataError, OptionError
from sigmatau.hints import Hint, command

if TYPE_CHECKING:
    from sqlalchemy import URL, Engine
    from sqlalchemy.engine import Connection

_BUSY = 60  # time that a writer of SQLite waits for another writer [s]
_PRAGMAS = (
    "page_size=16384",  # page size of a new file: writing 35 000 results takes 0.89 of the CPU time of 4 KiB
    "journal_mode=WAL",  # readers are possible during a write
    "synchronous=NORMAL",  # a crash of the system may lose the last transactions, but does not damage the file
    "foreign_keys=ON",
    "cache_size=-65536",  # cache [KiB]: the index of identities is read in random order
    "wal_autocheckpoint=2000",  # [pages] 32 MiB: a page that several transactions change is written once
)
_CASE_SENSITIVE = "case_sensitive_like=ON"  # makes patterns match as in PostgreSQL
_LOCK = 7_264_830  # advisory lock of PostgreSQL: only one process creates the tables
_HINTS = {  # action by text that occurs in the error of a database
    "readonly database": "copy the file to a folder with write permission",
    "disk image is malformed": "restore a copy, or recover it: sqlite3 FILE .recover",
    "disk is full": "free some space, and run the command again",
    "database is locked": f"another program has written for {_BUSY} s; run the command again",
}
_SQLITE = b"SQLite format 3\0"
_TABLES = {"unit", "run", "coefficient"}  # tables of all versions


def open_engine(place: str | Path, *, create: bool = True) -> Engine:
    """Open the engine of a store, and create its tables.

    Parameters
    ----------
    place : str or Path
        A file, or a URL, ``postgresql://user@host/name``.
    create : bool
        Whether a missing file is created.

    Raises
    ------
    OptionError
        For a URL of another database.
    DataError
        For a place that is not a store, or cannot be reached.
    ImportError
        If the database libraries are not installed.
    """
    try:
        import orjson  # noqa: F401
        import sqlalchemy
    except ImportError:
        raise ImportError("a store needs SQLAlchemy and orjson: pip install 'sigmatau[store]'") from None
    url = _url(place, create=create)
    try:
        engine = sqlalchemy.create_engine(url, **_arguments(url))
    except ImportError:
        raise ImportError("a store on PostgreSQL needs psycopg: pip install 'sigmatau[postgresql]'") from None
    if engine.dialect.name == "sqlite":
        _prepare_sqlite(engine, to_read="mode" in url.query)
    try:
        _make_tables(engine, place)
    except DataError:
        engine.dispose()
        raise
    except (sqlalchemy.exc.SQLAlchemyError, ValueError, TypeError) as error:  # damaged text, a value of the wrong type
        engine.dispose()
        raise DataError(f"{shown_place(place)}: {reason(error)}") from None
    return engine


def is_store(path: Path) -> bool:
    """Whether a file is a SQLite database with the tables of a store; it is not changed."""
    import sqlite3
    from contextlib import closing

    try:
        with path.open("rb") as file:
            if file.read(len(_SQLITE)) != _SQLITE:
                return False
        with closing(sqlite3.connect(f"file:{quote(str(path))}?mode=ro", uri=True)) as base:
            names = {name for (name,) in base.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    except (OSError, ValueError, sqlite3.Error):  # ValueError: a damaged text in a message of SQLite
        return False
    return names >= _TABLES


def reason(error: BaseException) -> str:
    """First line of an error of a database, and the action."""
    cause = getattr(error, "orig", None) or error
    text = str(cause).strip().partition("\n")[0] or type(cause).__name__
    if isinstance(error, ValueError | TypeError):
        return f"a value is damaged ({text}); restore the store from a copy"
    hint = next((hint for words, hint in _HINTS.items() if words in text), "")
    return f"{text}; {hint}" if hint else text


def _url(place: str | Path, *, create: bool) -> URL:
    from sqlalchemy import make_url
    from sqlalchemy.exc import ArgumentError

    text = str(place)
    match = re.match(r"([A-Za-z+0-9]+)://", text)
    if match is None:
        return _sqlite_url(_file(Path(place), create=create))
    scheme, rest = match[1].lower(), text.partition("://")[2]
    if scheme in ("postgresql", "postgres", "postgresql+psycopg"):
        try:
            return make_url(f"postgresql+psycopg://{rest}")
        except (ValueError, ArgumentError):
            raise OptionError(
                f"{shown_place(place)}: is not a URL; give it as postgresql://USER@HOST:5432/NAME", option="store"
            ) from None
    if scheme == "sqlite" and len(rest) > 1 and rest.startswith("/"):
        return _sqlite_url(_file(Path(rest[1:]), create=create))
    what = "give a file of SQLite by its name" if scheme == "sqlite" else f"{scheme} is not supported"
    raise OptionError(
        f"{shown_place(place)}: a store is a file, or postgresql://USER@HOST/NAME; {what}", option="store"
    )


def _sqlite_url(path: Path) -> URL:
    """URL of the file. Without write permission it is opened read-only, and as immutable if SQLite has no log beside it."""
    from sqlalchemy import URL

    name = str(path)
    if not path.exists() or (_writable(path) and _writable(path.absolute().parent)):
        return URL.create("sqlite", database=name)
    log = path.with_name(f"{path.name}-wal")
    query = {"mode": "ro", "uri": "true"}
    if not (log.exists() and log.stat().st_size):
        query["immutable"] = "1"
    return URL.create("sqlite", database=f"file:{quote(name)}", query=query)


def _writable(path: Path) -> bool:
    return os.access(path, os.W_OK, effective_ids=os.access in os.supports_effective_ids)


def _file(path: Path, *, create: bool) -> Path:
    if path.is_dir():
        raise DataError(f"{path}: is a directory; give the name of a file")
    if not path.exists():
        if not create:
            raise DataError(
                f"{path}: there is no such store; {command('store', 'add', 'RESULTS', Hint('store', value=path))} makes one"
            )
        if not path.absolute().parent.is_dir():
            raise DataError(f"{path}: there is no directory {path.parent}")
        return path
    try:
        with path.open("rb") as file:
            head = file.read(len(_SQLITE))
    except OSError as error:
        raise DataError(f"{path}: {error.strerror or error}") from None
    if head and head != _SQLITE:
        raise DataError(f"{path}: is not a store; give the name of a new file")
    return path


def shown_place(place: str | Path) -> str:
    """Hide the password of a place."""
    text = re.sub(r"(://[^:/@]*):.*@", r"\1:…@", str(place))
    return re.sub(r"([?&]password=)[^&]*", r"\1…", text)


def _arguments(url: URL) -> dict[str, Any]:
    if url.get_backend_name() == "sqlite":
        return {"connect_args": {"timeout": _BUSY}}
    return {"pool_pre_ping": True, "connect_args": {"connect_timeout": 10}}


def _prepare_sqlite(engine: Engine, *, to_read: bool) -> None:
    """Allow several readers and one writer at the same time. A transaction that writes waits for others when it begins,
    not at its first change.
    """
    from sqlalchemy import event

    name = str(engine.url.database)

    @event.listens_for(engine, "connect")
    def connected(connection: Any, record: Any) -> None:  # noqa: ANN401
        connection.isolation_level = None  # `begun` begins transactions
        for pragma in (_CASE_SENSITIVE,) if to_read else (_CASE_SENSITIVE, *_PRAGMAS):
            connection.execute(f"PRAGMA {pragma}")
        record.info["file"] = None if to_read else os.stat(name)  # noqa: PTH116  a result of os.stat, as `committed` needs

    @event.listens_for(engine, "begin")
    def begun(connection: Connection) -> None:
        writes = connection.get_execution_options().get("writes", False)
        connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")

    @event.listens_for(engine, "commit")
    def committed(connection: Connection) -> None:
        """Raise `DataError` if the file was removed: SQLite would go on, and its data would be lost."""
        if connection.get_execution_options().get("writes", False) and not to_read:
            try:
                same = os.path.samestat(connection.info["file"], os.stat(name))  # noqa: PTH116
            except OSError:
                same = False
            if not same:
                raise DataError(f"{name}: was removed or replaced by another program; run the command again")


def _make_tables(engine: Engine, place: str | Path) -> None:
    """Create the tables of an empty database, or update those of the previous version. Raises `DataError` for tables of
    another program or version.
    """
    from sqlalchemy import insert, inspect, select, text

    from sigmatau.lab.store.migrating import PREVIOUS, update_tables
    from sigmatau.lab.store.tables import VERSION, metadata, version

    def has_tables(connection: Connection, *, may_update: bool = False) -> bool:
        names = set(inspect(connection).get_table_names())
        stated = connection.scalar(select(version.c.version_num)) if version.name in names else None
        if stated == VERSION:
            return True
        if names and (stated is None or not _TABLES.issubset(names)):
            raise DataError(
                f"{shown_place(place)}: has other tables ({', '.join(sorted(names)[:3])} …); give an empty database"
            )
        if stated == PREVIOUS:
            if may_update:
                update_tables(connection)
            return may_update
        if stated is not None and stated < VERSION:
            again = command("store", "add", "RESULTS", Hint("store", value="NEW"))
            raise DataError(
                f"{shown_place(place)}: is of a version before the first release; add its results to a new store: {again}"
            )
        if stated is not None:
            raise DataError(f"{shown_place(place)}: is of a newer version of sigmatau; update sigmatau")
        return False

    with engine.connect() as connection:
        if has_tables(connection):
            return
    with engine.connect().execution_options(writes=True) as connection, connection.begin():
        if engine.dialect.name == "postgresql":
            connection.execute(text(f"SELECT pg_advisory_xact_lock({_LOCK})"))
        if not has_tables(connection, may_update=True):
            metadata.create_all(connection)
            connection.execute(insert(version).values(version_num=VERSION))
