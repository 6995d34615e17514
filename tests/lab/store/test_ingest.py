"""Results in a store, on SQLite and PostgreSQL alike."""

import json
from datetime import UTC, datetime

import numpy as np
import pytest
from store_results import entry_of, result

from known import seed_of
from sigmatau import Analysis, Record, analyze
from sigmatau.analysis import FailedAnalysis
from sigmatau.errors import DataError
from sigmatau.lab.store.choosing import Chosen
from sigmatau.lab.store.ingest import Added
from sigmatau.lab.store.store import Store


def entries(count, *, days=1):
    for k in range(count):
        for day in range(days):
            yield entry_of(
                result(k, log=f"{k}/{day}", path=f"unit{k}/day{day}.csv"),
                unit=f"unit{k}",
                model="tactical",
                recorded=datetime(2026, 1, 1 + day, 12, tzinfo=UTC),
                temperature=20.5,
            )


def test_result_comes_back_as_it_was(place):
    with Store(place) as store:
        one = result(3)
        store.add([entry_of(one, unit="A1")])
        [(row, analysis)] = store.results()
        found = store.content(row["id"])
    assert analysis.to_dict() == Analysis.from_dict(one).to_dict()
    assert found == json.loads(json.dumps(one))
    assert list(found) == list(one)  # in its order
    assert row["unit"] == "A1"
    assert row["state"] == "fitted"


def test_a_record_too_short_for_a_fit_is_not_fitted(place):
    record = Record.from_arrays(rate=100.0, gyro=[[0.1, 0.2, 0.4]] * 2 + [[0.2, 0.1, 0.3]] * 2, unit={"gyro": "rad/s"})
    with Store(place) as store:
        store.add([entry_of(analyze(record, at_rest=True).to_dict(), unit="A1"), entry_of(result(1), unit="A2")])
        assert store.runs(Chosen(states=("not_fitted",))).columns()["unit"] == ["A1"]
        units = store.units().columns()
    assert (units["fitted"], units["not_fitted"]) == ([0, 1], [1, 0])


def test_a_record_too_short_to_tell_rest_has_its_own_state(place):
    y = np.random.default_rng(seed_of("short in a store")).standard_normal((400, 3))
    record = Record.from_arrays(rate=100.0, gyro=1e-3 * y, unit={"gyro": "rad/s"})
    with Store(place) as store:
        store.add([entry_of(analyze(record).to_dict(), unit="A1"), entry_of(result(1), unit="A2")])
        assert store.runs(Chosen(states=("too_short_to_tell",))).columns()["unit"] == ["A1"]
        units = store.units().columns()
    assert (units["fitted"], units["too_short_to_tell"]) == ([0, 1], [1, 0])


def test_same_run_is_added_once(place):
    with Store(place) as store:
        assert store.add(entries(3, days=2)) == Added(new=6)
        assert store.add(entries(3, days=2)) == Added(known=6)
        assert len(store.runs()) == 6
        assert store.units().columns()["runs"] == [2, 2, 2]


def test_other_result_of_the_same_log_is_a_revision(place):
    with Store(place) as store:
        first, later = result(0, log="log"), result(1, log="log")
        again = dict(first, sigmatau="9.9.9")
        store.add([entry_of(first, unit="A1")])
        assert store.add([entry_of(again, unit="A1")]) == Added(known=1)  # another version, the same numbers
        assert store.add([entry_of(later, unit="A1")]) == Added(revised=1)
        assert store.runs().columns()["revision"] == [2]
        assert store.runs(Chosen(history=True)).columns()["revision"] == [1, 2]
        [(row, _)] = store.results()
        assert store.content(row["id"])["channels"] == later["channels"]


def test_several_revisions_in_one_batch(place):
    with Store(place) as store:
        chain = [entry_of(result(k, log="log"), unit="A1") for k in (0, 1, 1, 2)]
        assert store.add(chain) == Added(new=1, revised=2, known=1)
        assert store.runs().columns()["revision"] == [3]


def test_other_options_are_another_run(place):
    with Store(place) as store:
        one = result(0, log="log")
        other = result(1, log="log") | {"options": {"analysis": {"at_rest": True}}}
        assert store.add([entry_of(one, unit="A1"), entry_of(other, unit="A1")]) == Added(new=2)


def test_records_without_a_file_are_runs_of_their_own(place):
    days = [result(k) for k in (0, 1, 2)]
    for one in days:
        one["source"] = {"path": None, "sha256": None}
    with Store(place) as store:
        assert store.add([entry_of(one, unit="A1") for one in days]) == Added(new=3)
        assert store.add([entry_of(days[1], unit="A1")]) == Added(known=1)


def test_failures_are_rows(place):
    with Store(place) as store:
        failed = FailedAnalysis(path="bad.csv", message="bad.csv: no columns", exit_code=1).to_dict()
        store.add([entry_of(failed, unit="A1"), entry_of(result(0), unit="A1")])
        runs = store.runs().columns()
        assert sorted(runs["state"]) == ["failed", "fitted"]
        assert "bad.csv: no columns" in runs["message"]
        assert store.units().columns()["failed"] == [1]


def test_coefficients_are_those_of_the_result(place):
    with Store(place) as store:
        one = result(2)
        store.add([entry_of(one, unit="A1")])
        table = store.coefficients(term="random_walk", channels=("gyro_y",)).columns()
    told = one["channels"]["gyro_y"]["fit"]["terms"]["random_walk"]
    assert (table["value"], table["low"], table["high"]) == ([told["value"]], [told["low"]], [told["high"]])
    assert table["observed"] == [True]


@pytest.mark.parametrize(
    "bad", [{}, [], {"channels": 3, "source": {}}, {"channels": {}}, {"channels": {}, "source": {}, "schema": 99}]
)
def test_no_result_is_an_error_and_adds_nothing(place, bad):
    with Store(place) as store:
        with pytest.raises(DataError):
            store.add([entry_of(result(0), unit="A1"), entry_of(bad, unit="A2")])
        assert len(store.runs()) == 0  # the batch is whole or not there


def test_choosing(place):
    with Store(place) as store:
        store.add(entries(4, days=3))
        assert len(store.runs(Chosen(units=("unit1", "unit2")))) == 6
        assert len(store.runs(Chosen(units=("unit*",)))) == 12
        assert len(store.runs(Chosen(units=("UNIT*",)))) == 0
        assert len(store.runs(Chosen(units=("unit_",)))) == 0  # not a pattern
        assert (
            len(store.runs(Chosen(since=datetime(2026, 1, 2, tzinfo=UTC), until=datetime(2026, 1, 3, tzinfo=UTC)))) == 4
        )
        assert len(store.runs(Chosen(model="tactical"))) == 12
        assert len(store.runs(Chosen(model="other"))) == 0
        assert len(store.runs(Chosen(temperature=(20, 21)))) == 12
        assert len(store.runs(Chosen(temperature=(21.2, 22)))) == 0


def test_version_is_not_compared_wherever_it_stands():
    from sigmatau.lab.store.packing import pack

    one = result(0)
    later = one | {"sigmatau": "9.9", "schema": 3}
    moved = {key: later[key] for key in [*reversed(later)]}
    assert pack(one).digest == pack(later).digest
    assert pack(moved).digest == pack(moved | {"sigmatau": "0.1", "schema": 2}).digest
    assert pack(one).digest != pack(result(1)).digest
    without = {key: value for key, value in one.items() if key not in ("schema", "sigmatau")}
    assert pack(without).digest == pack(one).digest
