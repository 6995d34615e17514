"""A store of the previous schema becomes one of this: its results, coefficients and history are the same."""

import json
import sqlite3
import zlib
from contextlib import closing
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
import sqlalchemy
from store_results import entry_of, result

from sigmatau.errors import DataError
from sigmatau.lab.store import connect
from sigmatau.lab.store.choosing import Chosen
from sigmatau.lab.store.ingest import Added
from sigmatau.lab.store.rows import make_rows, options_key
from sigmatau.lab.store.store import Store

KEPT = ("name", "path", "sha256", "duration", "state", "message", "version", "digest")


def old_content(one):
    """Content and curves as version 0001 packed them: curves by channel."""
    curves, channels = {}, {}
    for name, channel in one["channels"].items():
        lists = {key: np.array(value) for key, value in channel["curve"].items() if isinstance(value, list)}
        lists = {key: of if of.dtype == np.int64 else of.astype(np.float64) for key, of in lists.items()}
        curves[name] = b"".join(of.tobytes() for of in lists.values())
        heads = {key: [of.dtype.str, len(of)] for key, of in lists.items()}
        rest = {key: value for key, value in channel["curve"].items() if key not in lists}
        channels[name] = {**channel, "curve": {"arrays": heads, "order": [*channel["curve"]], "rest": rest}}
    return zlib.compress(json.dumps({**one, "channels": channels}).encode(), 1), curves


def fill(connection, results):
    """Rows as version 0001 wrote them."""
    text = sqlalchemy.text
    connection.execute(text("INSERT INTO model (id, name) VALUES (1, 'tactical')"))
    connection.execute(text("INSERT INTO unit (id, name, model_id) VALUES (1, 'A1', 1), (2, 'A2', NULL)"))
    for key, (one, current) in enumerate(results, 1):
        rows = make_rows(entry_of(one, unit="A1", recorded=datetime(2026, 1, key)))  # noqa: DTZ001  UTC
        content, curves = old_content(one)
        if key == 4:
            content = b"damaged"
        run = {
            **{name: rows.run[name] for name in KEPT},
            "id": key, "unit_id": 1, "identity": rows.identity, "revision": 2 if key == 3 else 1, "current": current,
            "content": content, "recorded": rows.run["recorded"], "added": datetime(2026, 2, 1),  # noqa: DTZ001
        }  # fmt: skip
        names = ", ".join(f'"{name}"' for name in run)
        kinds = {"recorded": sqlalchemy.DateTime, "added": sqlalchemy.DateTime, "content": sqlalchemy.LargeBinary}
        marks = [sqlalchemy.bindparam(name, type_=kinds.get(name)) for name in run]
        made = text(f"INSERT INTO run ({names}) VALUES ({', '.join(':' + name for name in run)})").bindparams(*marks)
        connection.execute(made, run)
        for name, quantity, unit, rate, samples, verdict, trust, p_value in rows.channels:
            mean = None if name == "gyro_x" else 1.5e-5
            connection.execute(
                text("INSERT INTO channel VALUES (:r, :n, :q, :u, :f, :s, :v, :t, :p, :m, :c)"),
                {"r": key, "n": name, "q": quantity, "u": unit, "f": rate, "s": samples, "v": verdict, "t": trust,
                 "p": p_value,
                 "m": mean, "c": curves[name]},
            )  # fmt: skip
        for (name, _, term, unit, _), (observed, value, low, high, limit, level) in zip(
            rows.labels, rows.terms, strict=True
        ):
            if term == "mean":
                continue
            connection.execute(
                text("INSERT INTO coefficient VALUES (:r, :n, :t, :o, :v, :l, :h, :i, :e, :u)"),
                {"r": key, "n": name, "t": term, "o": observed, "v": value, "l": low, "h": high, "i": limit, "e": level,
                 "u": unit},
            )  # fmt: skip


@pytest.fixture
def old(place):
    """A store at version 0001 with four runs: three results of two logs, and one whose content is damaged."""
    from alembic import command

    results = [
        (result(0, log="a"), True),
        (result(1, log="b"), False),
        (result(2, log="b"), True),
        (result(3, log="c"), True),
    ]
    for one, _ in results:
        for channel in one["channels"].values():
            channel.pop("mean", None)
    engine = sqlalchemy.create_engine(connect._url(place, create=True))
    if engine.dialect.name == "sqlite":
        connect._prepare_sqlite(engine, to_read=False)
    config = connect.configuration()
    with engine.connect().execution_options(writes=True) as connection, connection.begin():
        config.attributes["connection"] = connection
        command.upgrade(config, "0001")
        fill(connection, results)
        if engine.dialect.name == "postgresql":
            connection.exec_driver_sql("SELECT setval(pg_get_serial_sequence('run', 'id'), 4)")
            connection.exec_driver_sql("SELECT setval(pg_get_serial_sequence('unit', 'id'), 2)")
    engine.dispose()
    return place, [one for one, _ in results]


def test_previous_schema(old):
    from alembic.autogenerate import compare_metadata
    from alembic.migration import MigrationContext

    from sigmatau.lab.store import tables

    place, results = old
    with Store(place) as store:
        with store._engine.connect() as connection:
            assert compare_metadata(MigrationContext.configure(connection), tables.metadata) == []
            names = sqlalchemy.inspect(connection).get_table_names()
        assert set(names) == {*tables.metadata.tables, "alembic_version"}  # nothing is left of the migration
        assert store.runs(Chosen(history=True)).columns()["revision"] == [1, 1, 2, 1]
        until = Chosen(until=datetime(2026, 1, 4), history=True)  # noqa: DTZ001  UTC
        assert [store.content(row["id"]) for row, _ in store.results(until)] == results[:3]
        with pytest.raises(DataError, match="damaged"):
            list(store.results())
        assert store.versions(options_key({})) == {"day1.csv": ""}
        rows = store.coefficients(term="random_walk").columns()
        fits = [channel["fit"] for one in (results[0], *results[2:]) for channel in one["channels"].values()]
        told = [fit["terms"]["random_walk"]["value"] for fit in fits]
        assert rows["value"] == told
        assert store.coefficients(term="mean").columns()["value"] == [1.5e-5] * 6
        assert store.compare()["gyro_x", "random_walk"].k == 3
        # It goes on: what is there is known, and a new log is new.
        again = [entry_of(one, unit="A1") for one in (results[0], results[2])]
        assert store.add(again) == Added(known=2)
        assert store.add([entry_of(result(4, log="new"), unit="A1")]) == Added(new=1)


@pytest.fixture
def of_version_2(tmp_path):
    """A store that version 0002 wrote: two results of a log, whose conversions are worded differently, one of another log,
    a failure, and a result without a log.
    """
    path = tmp_path / "old.db"
    with closing(sqlite3.connect(path)) as file:
        file.executescript((Path(__file__).parent / "frozen" / "store-0002.sql").read_text("utf-8"))
    return path


def test_runs_told_apart_by_words_of_conversions(of_version_2):
    """They are runs by log and options now, and what is added again is recognised, however its conversions are worded."""
    with Store(of_version_2) as store:
        runs = store.runs(Chosen(history=True)).columns()
        assert sorted(zip(runs["run"], runs["revision"], strict=True)) == [
            ("day1.csv", 1), ("day1.csv", 2), ("day2.csv", 1), ("day3.csv", 1), ("in memory", 1),
        ]  # fmt: skip
        assert sorted(store.runs().columns()["run"]) == ["day1.csv", "day2.csv", "day3.csv", "in memory"]
        stored = [(row, store.content(row["id"])) for row, _ in store.results()]
        for row, content in stored:
            names = {"unit": row["unit"], "name": row["run"], "recorded": row["recorded"]}
            assert store.add([entry_of(content, **names)]) == Added(known=1)
        (day2,) = (content for row, content in stored if row["run"] == "day2.csv")
        worded = day2 | {"source": day2["source"] | {"conversions": ["in words of a later version"]}}
        assert store.add([entry_of(worded, unit="A1")]) == Added(revised=1)


def test_migration_that_fails_changes_nothing(old, monkeypatch):
    place, _ = old

    def fails(*_):
        raise sqlalchemy.exc.OperationalError("x", {}, Exception("disk is full"))

    monkeypatch.setattr("alembic.op.drop_column", fails)
    with pytest.raises(DataError, match="disk is full"):
        Store(place)
    monkeypatch.undo()
    with Store(place) as store:
        assert len(store.runs()) == 3


def test_new_store_is_the_same_as_a_migrated_one(tmp_path, old):
    place, _ = old
    if "://" in place:
        pytest.skip("compared on SQLite, which keeps the statements")
    with Store(place), Store(tmp_path / "new.db"):
        pass
    schemas = []
    for name in (place, tmp_path / "new.db"):
        import sqlite3

        connection = sqlite3.connect(name)
        schemas.append(
            sorted(row[0] for row in connection.execute("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL"))
        )
        connection.close()
    assert schemas[0] == schemas[1]
