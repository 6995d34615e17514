"""A log that fails, is repaired and fails again; one that gets an earlier content; one that has another place."""

from dataclasses import replace
from datetime import datetime

import pytest
from store_results import entry_of, result

from sigmatau.analysis import FailedAnalysis
from sigmatau.errors import DataError
from sigmatau.lab.fleet.logs import Log
from sigmatau.lab.fleet.stored import Stored
from sigmatau.lab.store.choosing import Chosen
from sigmatau.lab.store.ingest import Added
from sigmatau.lab.store.rows import make_rows
from sigmatau.lab.store.store import Store

FAILED = FailedAnalysis(path="day1.csv", message="day1.csv: is damaged", exit_code=1).to_dict()


def test_results_with_a_past_failure_are_added_again(place):
    """As `sigmatau store add` of a folder does that holds the failure and the later result."""
    entries = [entry_of(FAILED, unit="A"), entry_of(result(0), unit="A")]
    with Store(place) as store:
        assert store.add(entries) == Added(new=2)
        assert store.add(entries) == Added(known=2)
        assert store.runs().columns()["state"] == ["fitted"]


def taken(store, content, version, path="day1.csv"):
    """What a fleet does with a log whose file has this version."""
    log = Log(place=path, size=1, changed=version)
    stored = Stored(store._engine, {})
    assert not stored.has(log)
    content = content | {"source": content["source"] | {"path": path}}
    entry = entry_of(content, unit="A", file_version=log.version)
    added = stored.add([make_rows(entry)], [log])
    assert Stored(store._engine, {}).has(log)
    return added


def shown(store, *, history=False):
    runs = store.runs(Chosen(history=history)).columns()
    return sorted(zip(runs["state"], runs["revision"], strict=True))


def test_log_that_fails_again(place):
    with Store(place) as store:
        taken(store, FAILED, "1")
        taken(store, result(0), "2")
        assert shown(store) == [("fitted", 1)]
        assert taken(store, FAILED, "3") == Added(revised=1)
        assert shown(store) == [("failed", 2)]
        assert len(shown(store, history=True)) == 3


@pytest.mark.parametrize("version", ["1", "3"])
def test_log_that_gets_its_earlier_content(place, version):
    """Also with its earlier time of change, as a backup has it."""
    with Store(place) as store:
        taken(store, result(0), "1")
        taken(store, result(1), "2")
        assert taken(store, result(0), version) == Added(revised=1)
        assert shown(store) == [("fitted", 2)]
        (run_id,) = store.runs().columns()["id"]
        assert store.content(run_id)["channels"] == result(0)["channels"]


def test_touched_log_keeps_its_row(place):
    with Store(place) as store:
        taken(store, result(0), "1")
        assert taken(store, result(0), "2") == Added(known=1)
        assert shown(store, history=True) == [("fitted", 1)]


def test_moved_log_and_copies_are_no_revisions(place):
    with Store(place) as store:
        taken(store, result(0), "1")
        assert taken(store, result(0), "1", path="old/day1.csv") == Added(known=1)
        assert Stored(store._engine, {}).has(Log(place="day1.csv", size=1, changed="1"))  # moved back, or a copy
        assert taken(store, result(0), "2") == Added(known=1)
        assert taken(store, result(1), "3", path="old/day1.csv") == Added(new=1)  # overwritten: the other place stays
        assert Stored(store._engine, {}).has(Log(place="day1.csv", size=1, changed="2"))
        assert shown(store) == [("fitted", 1), ("fitted", 1)]


def test_time_and_temperature_are_stated_later(place):
    """A trend without times says: add results with `date`. The same results are then there already, and get it."""
    entry = entry_of(result(0), unit="A")
    with Store(place) as store:
        store.add([entry])
        with pytest.raises(DataError, match="add results with `date`"):
            store.trend()
        day = datetime(2026, 5, 1)  # noqa: DTZ001  UTC
        assert store.add([replace(entry, recorded=day, temperature=25.0)]) == Added(updated=1)
        assert store.add([entry]) == Added(known=1)  # what is not stated stays
        runs = store.runs(Chosen(history=True)).columns()
        assert (runs["recorded"], runs["temperature"]) == ([day], [25.0])


def test_fleet_states_the_time_later(place):
    log = "logs/2026-05-02.csv"
    with Store(place) as store:
        taken(store, result(0), "1", path=log)
        taken(store, result(1), "1", path="logs/other.csv")
        stored = Stored(store._engine, {})
        day = datetime(2026, 5, 2)  # noqa: DTZ001  UTC
        assert stored.describe({log: {"recorded": day}}) == 1
        assert Stored(store._engine, {}).describe({log: {"recorded": day}, "gone.csv": {"recorded": day}}) == 0
        assert sorted(store.runs().columns()["recorded"], key=str) == [day, None]
