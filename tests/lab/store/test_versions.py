"""Stores that other versions wrote."""

import json
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
import sqlalchemy
from store_results import entry_of, result

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


def test_the_previous_version_gets_the_conditions_of_its_results(place):
    """A store of version 0003 has neither supply voltages nor temperatures from thermometers; opening it reads them."""
    noted, named, measured = (result(k, log=str(k), path=f"{k}.csv") for k in range(3))
    noted["notes"] = {"supply": "3300mV"}
    named["source"]["path"] = "SN7_5V0.csv"
    measured["source"]["temperature_degc"] = {"mean": -40.1, "low": -40.3, "high": -39.9}
    failed = {**json.loads(json.dumps(result(3))), "channels": {}, "error": {"message": "cut", "exit_code": 1}}
    with Store(place) as store:
        units = ("noted", "named", "measured", "failed")
        store.add(
            [entry_of(each, unit=unit) for each, unit in zip((noted, named, measured, failed), units, strict=True)]
        )
        stated = store.add(entry_of(result(4, log="4", path="4.csv"), unit="stated", temperature=25.0, supply=5.0))
        assert stated == Added(new=1)
        expected = store.runs().columns()
        with store._engine.connect().execution_options(writes=True) as connection:
            for column in ("supply", "has_curves"):
                connection.exec_driver_sql(f"ALTER TABLE run DROP COLUMN {column}")
            connection.exec_driver_sql("DROP TABLE place")
            connection.exec_driver_sql("UPDATE run SET temperature = NULL WHERE temperature < 0")
            connection.exec_driver_sql("UPDATE alembic_version SET version_num = '0003'")
            connection.commit()
    expected["supply"][expected["unit"].index("stated")] = None  # was nowhere in the store
    for _ in range(2):
        with Store(place) as store:
            assert store.runs().columns() == expected
            assert store.add(entry_of(noted, unit="noted")) == Added(known=1)
    conditions = dict(zip(expected["unit"], zip(expected["temperature"], expected["supply"], strict=True), strict=True))
    assert conditions == {
        "noted": (None, 3.3), "named": (None, 5.0), "measured": (-40.1, None), "failed": (None, None),
        "stated": (25.0, None),
    }  # fmt: skip


def test_a_store_of_the_previous_version_without_write_permission_says_what_to_do(old, tmp_path, monkeypatch):
    monkeypatch.setattr("sigmatau.lab.store.connect._writable", lambda path: False)
    with pytest.raises(DataError, match="copy the file to a folder with write permission"):
        Store(old)


@pytest.mark.parametrize(
    ("version", "told"), [("9999", "newer version of sigmatau"), ("0002", "sigmatau store add RESULTS --store NEW")]
)
def test_other_versions_are_refused(place, version, told):
    with Store(place) as store, store._engine.connect().execution_options(writes=True) as connection:
        connection.exec_driver_sql(f"UPDATE alembic_version SET version_num = '{version}'")
        connection.commit()
    with pytest.raises(DataError, match=told):
        Store(place)
