"""Stores that other versions wrote."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
import sqlalchemy
from store_results import entry_of

from sigmatau.errors import DataError
from sigmatau.lab.store.choosing import Chosen
from sigmatau.lab.store.ingest import Added
from sigmatau.lab.store.store import Store
from sigmatau.lab.store.tables import metadata


@pytest.fixture
def old(tmp_path):
    """Two results of a log, one of another log, a failure, and a result without a log."""
    path = tmp_path / "old.db"
    with closing(sqlite3.connect(path)) as file:
        file.executescript((Path(__file__).parent / "frozen" / "store-0003.sql").read_text("utf-8"))
    return path


def test_a_stored_version_is_read_and_added_to(old):
    """Its tables are those of this version; what is added again is recognised, however its conversions are worded."""
    with Store(old) as store:
        with store._engine.connect() as connection:
            there = sqlalchemy.inspect(connection)
            for table in metadata.tables.values():
                assert [column["name"] for column in there.get_columns(table.name)] == [*table.columns.keys()]
        runs = store.runs(Chosen(history=True)).columns()
        assert sorted(zip(runs["run"], runs["revision"], strict=True)) == [
            ("day1.csv", 1), ("day1.csv", 2), ("day2.csv", 1), ("day3.csv", 1), ("in memory", 1),
        ]  # fmt: skip
        stored = [(row, store.content(row["id"])) for row, _ in store.results()]
        for row, content in stored:
            names = {"unit": row["unit"], "name": row["run"], "recorded": row["recorded"]}
            assert store.add([entry_of(content, **names)]) == Added(known=1)
        (day2,) = (content for row, content in stored if row["run"] == "day2.csv")
        worded = day2 | {"source": day2["source"] | {"conversions": ["in words of a later version"]}}
        assert store.add([entry_of(worded, unit="A1")]) == Added(revised=1)


@pytest.mark.parametrize(
    ("version", "told"), [("9999", "newer version of sigmatau"), ("0002", "sigmatau store add RESULTS --store NEW")]
)
def test_other_versions_are_refused(place, version, told):
    with Store(place) as store, store._engine.connect().execution_options(writes=True) as connection:
        connection.exec_driver_sql(f"UPDATE alembic_version SET version_num = '{version}'")
        connection.commit()
    with pytest.raises(DataError, match=told):
        Store(place)
