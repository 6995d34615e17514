"""Odd names, large numbers, absent values, and other results than those of analyze."""

import json
from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest
from store_results import entry_of, result

from sigmatau.analysis import FailedAnalysis
from sigmatau.errors import DataError
from sigmatau.lab.store.choosing import Chosen
from sigmatau.lab.store.ingest import Added
from sigmatau.lab.store.packing import NUMBERS
from sigmatau.lab.store.rows import options_key
from sigmatau.lab.store.store import Store

NAMES = [
    "A 1",
    "O'Brien",
    'a"b',
    "100%",
    "a_b",
    "a\\b",
    "x;DROP TABLE run",
    "Зонд",
    "\u202eabc",
    "🚀",
    "a\nb",
    "é",
    "e\u0301",
]


@pytest.mark.parametrize("name", NAMES, ids=ascii)
def test_odd_names(place, name):
    with Store(place) as store:
        store.add(
            [
                entry_of(result(0, log="1", path=f"{name}.csv"), unit=name),
                entry_of(result(0, log="2"), unit="B"),
            ]
        )
        [(row, found)] = store.results(Chosen(units=(name,)))
        assert row["unit"] == name.strip()
        assert found.source.path == f"{name}.csv"


def test_characters_that_databases_refuse(place):
    one = result(0, path="a\0b.csv")
    other = result(1, path="caf\udce9.csv")  # bytes of a file name that are not UTF-8
    with Store(place) as store:
        assert store.add([entry_of(one, unit="A\0"), entry_of(other, unit="B")]) == Added(new=2)
        assert store.runs().columns()["unit"] == ["A\\0", "B"]
        assert [found.source.path for _, found in store.results()] == ["a\0b.csv", "caf\udce9.csv"]


@pytest.mark.parametrize(("content", "names", "told"), [
    (result(0), {"unit": " "}, "name of the unit is empty"),
    (result(0), {"unit": "x" * 401}, "401 characters, more than 400"),
    (result(0), {"unit": "A", "model": "m" * 201}, "201 characters"),
    (result(0) | {"channels": {"gyro_x": {}}}, {"unit": "A"}, "quantity is missing"),
    (result(0) | {"channels": {"gyro_x": 3}}, {"unit": "A"}, "3 is not an object"),
    (result(0) | {"source": 5}, {"unit": "A"}, "source: 5 is not an object"),
])  # fmt: skip
def test_refused_and_nothing_added(place, content, names, told):
    with Store(place) as store:
        with pytest.raises(DataError, match=told):
            store.add([entry_of(result(1), unit="B"), entry_of(content, **names)])
        assert len(store.runs()) == 0


def test_more_samples_than_32_bits_hold(place):
    one = result(0)
    one["channels"]["gyro_x"] |= {"samples": 2**31 + 5}
    with Store(place) as store:
        store.add([entry_of(one, unit="A")])
        [(row, found)] = store.results()
    assert found["gyro_x"].n == 2**31 + 5
    assert row["duration"] == pytest.approx((2**31 + 5) / 100, rel=1e-12)


def test_absent_values_are_null(place):
    one = result(0)
    del one["channels"]["gyro_y"]["fit"]["p_value"]
    one["channels"]["gyro_z"]["curve"]["edf"][0] = None
    with Store(place) as store:
        store.add([entry_of(one, unit="A")])
        runs = store.runs().columns()
        assert (runs["recorded"], runs["temperature"], runs["model"]) == ([None], [None], [None])
        (row_id,) = runs["id"]
        assert store.content(row_id) == one
        rows = store.coefficients(term="bias_instability").columns()
        limits = [
            (x, low) for x, low, limit in zip(rows["value"], rows["low"], rows["upper_limit"], strict=True) if limit
        ]
        assert limits
        assert set(limits) == {(None, None)}  # not NaN


def test_numbers_of_a_run_are_its_rows(place):
    """The array that comparisons read says the same as the table."""
    from sqlalchemy import select

    from sigmatau.lab.store import tables

    one = result(0)
    one["channels"]["gyro_x"]["mean"] = {"value": -2e-5, "error": 1e-6, "unit": "rad/s"}
    one["channels"]["gyro_y"]["mean"] = {"value": 3e-5, "error": None, "unit": "rad/s"}
    one["channels"]["gyro_z"]["fit"]["verdict"] = "descriptive"
    with Store(place) as store:
        store.add([entry_of(result(1), unit="A"), entry_of(one, unit="B")])
        with store._engine.connect() as connection:
            of = tables.coefficient.c
            columns = (of.value, of.low, of.high, of.upper_limit, of.level)
            rows = connection.execute(select(of.run_id, of.label_id, *columns)).all()
            stored = connection.execute(select(tables.result.c.run_id, tables.result.c.numbers)).all()
        means = store.coefficients(Chosen(units=("B",)), term="mean").columns()
    found = {}
    for run, raw in stored:
        for label, fits, *numbers in np.frombuffer(raw, dtype=NUMBERS).tolist():
            found[run, label] = [None if np.isnan(x) else x for x in numbers]
            assert fits in (0, 1)
    assert found == {(run, label): list(numbers) for run, label, *numbers in rows}
    assert means["value"][:2] == [-2e-5, 3e-5]
    assert means["high"][:2] == [pytest.approx(-2e-5 + 1.959963984540054e-6, rel=1e-12), None]


def test_times_have_the_zone_of_utc(place, monkeypatch):
    monkeypatch.setenv("TZ", "Asia/Tokyo")
    noon = datetime(2026, 5, 1, 12, tzinfo=timezone(timedelta(hours=2)))
    entries = [
        entry_of(result(0, log="1"), unit="A", recorded=noon),
        entry_of(result(0, log="2"), unit="B", recorded=noon.replace(tzinfo=None)),
    ]
    with Store(place) as store:
        store.add(entries)
        table = store.runs()
        assert [one.hour for one in table.columns()["recorded"]] == [10, 12]
        assert table.to_dict()["recorded"] == ["2026-05-01T10:00:00Z", "2026-05-01T12:00:00Z"]
        json.dumps(table.to_dict(), allow_nan=False)
        since = Chosen(since=datetime(2026, 5, 1, 11, tzinfo=UTC))
        assert store.runs(since).columns()["unit"] == ["B"]


def test_failure_is_history_once_the_log_has_a_result(place):
    failed = FailedAnalysis(path="day1.csv", message="day1.csv: no rate", exit_code=2).to_dict()
    other = FailedAnalysis(path="day2.csv", message="day2.csv: is empty", exit_code=1).to_dict()
    with Store(place) as store:
        store.add([entry_of(failed, unit="A"), entry_of(other, unit="A"), entry_of(failed, unit="B")])
        store.add([entry_of(result(0, path="day1.csv"), unit="A")])
        runs = store.runs().columns()
        assert list(zip(runs["unit"], runs["run"], runs["state"], strict=True)) == [
            ("A", "day2.csv", "failed"), ("A", "day1.csv", "fitted"), ("B", "day1.csv", "failed"),
        ]  # fmt: skip
        assert len(store.runs(Chosen(history=True))) == 4


def test_versions_of_logs_by_options(place):
    key = options_key({"analysis": {"window": "0s:60s"}, "reading": {"rate": 100}})
    assert key == options_key({"reading": {"rate": 100.0}, "analysis": {"window": "0s:60s"}})
    one = result(0, path="a.csv") | {"options": {"reading": {"rate": 100}, "analysis": {"window": "0s:60s"}}}
    with Store(place) as store:
        store.add([entry_of(one, unit="A", file_version="10-5"), entry_of(result(1), unit="A", file_version="7-7")])
        assert store.versions(key) == {"a.csv": "10-5"}
        assert store.versions(options_key({})) == {"day1.csv": "7-7"}


def test_deleted_run_leaves_nothing(place):
    from sqlalchemy import func, select

    from sigmatau.lab.store import tables

    with Store(place) as store:
        store.add([entry_of(result(0), unit="A")])
        with store._engine.connect().execution_options(writes=True) as connection, connection.begin():
            connection.execute(tables.run.delete())
            for table in (tables.result, tables.channel, tables.coefficient, tables.finding):
                assert connection.execute(select(func.count()).select_from(table)).scalar_one() == 0, table.name


def test_a_clock_that_goes_backwards_does_not_choose_the_current_result(place, monkeypatch):
    """The number of the revision decides, not the time at which a result was added."""
    hours = iter([12, 3, 7])

    class Clock(datetime):
        @classmethod
        def now(cls, tz=None):
            return datetime(2026, 5, 4, next(hours), tzinfo=tz)

    monkeypatch.setattr("sigmatau.lab.store.ingest.datetime", Clock)
    with Store(place) as store:
        for seed in range(3):
            store.add([entry_of(result(seed, log="same"), unit="A")])
        runs = store.runs(Chosen(history=True)).columns()
        added = dict(zip(runs["revision"], (store.content(key) for key in runs["id"]), strict=True))
        assert sorted(added) == [1, 2, 3]
        (current,) = store.runs().columns()["id"]
        assert store.content(current) == added[3]
