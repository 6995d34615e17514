"""Several writers at once, writers that are killed, and stores of another schema."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import textwrap
import time
from pathlib import Path

import pytest
import sqlalchemy
import store_results
from store_results import entry_of, result

from sigmatau.errors import DataError, OptionError
from sigmatau.lab.store import connect, tables
from sigmatau.lab.store.store import Store

WRITER = textwrap.dedent(
    """
    import json, sys
    import store_results
    from sigmatau.lab.store.store import Store

    store_results._made = json.load(sys.stdin).__getitem__  # those of the test: an analysis takes longer than the store
    place, first, count, batch = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4])
    with Store(place) as store:
        for k in range(first, first + count, batch):
            chunk = [(store_results.result(j, log=str(j)), f"unit{j % 7}") for j in range(k, k + batch)]
            print(store.add([store_results.entry_of(found, unit=unit) for found, unit in chunk]), flush=True)
    """
)


def writer(place, first, count, batch=20):
    with tempfile.TemporaryFile("w+") as made:
        json.dump([store_results._made(k) for k in range(5)], made)
        made.seek(0)
        return subprocess.Popen(
            [sys.executable, "-c", WRITER, place, str(first), str(count), str(batch)],
            cwd=Path(__file__).parent,
            stdin=made,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
        )


def identities(store):
    with store._engine.connect() as connection:
        return connection.execute(sqlalchemy.select(tables.run.c.identity)).scalars().all()


def test_two_writers_of_the_same_runs(place):
    with writer(place, 0, 100) as one, writer(place, 0, 100) as other:
        assert "Added" in one.communicate(timeout=120)[0]
        assert "Added" in other.communicate(timeout=120)[0]
    with Store(place) as store:
        found = identities(store)
        assert len(found) == len(set(found)) == 100
        assert len(store.coefficients(term="random_walk")) == 300


def test_killed_writer_loses_only_what_was_not_committed(place):
    with Store(place):
        pass
    with writer(place, 0, 2000, batch=20) as one:
        told = [one.stdout.readline() for _ in range(3)]
        one.send_signal(signal.SIGKILL)
        told += one.stdout.readlines()
    with Store(place) as store:
        at_least = 20 * sum(line.endswith(")\n") for line in told)
        deadline = time.monotonic() + 20
        while (count := len(identities(store))) < at_least and time.monotonic() < deadline:
            time.sleep(0.1)
        assert count >= at_least
        assert count % 20 == 0
        assert len(store.coefficients(term="random_walk")) == 3 * count  # no half of a run
    with writer(place, 0, 200, batch=20) as again:
        assert "Added" in again.communicate(timeout=120)[0]
    with Store(place) as store:
        found = identities(store)
        assert len(found) == len(set(found)) == max(200, count)


def test_other_database_is_refused(place):
    engine = sqlalchemy.create_engine(connect._url(place, create=True))
    with engine.begin() as connection:
        connection.exec_driver_sql("CREATE TABLE orders (id INTEGER)")
    engine.dispose()
    with pytest.raises(DataError, match="has other tables"):
        Store(place)


def test_places_that_are_no_store(tmp_path):
    text = tmp_path / "notes.txt"
    text.write_text("no database at all")
    cut = tmp_path / "cut.db"
    with Store(cut) as store:
        store.add([entry_of(result(0), unit="A1")])
    raw = cut.read_bytes()
    cut.write_bytes(raw[:5000])
    for place, told in [
        (text, "is not a store"),
        (tmp_path, "is a directory"),
        (tmp_path / "nowhere" / "x.db", "no directory"),
        (cut, "malformed|disk image|damaged|not a database"),
    ]:
        with pytest.raises(DataError, match=told), Store(place) as store:
            store.runs()
    with pytest.raises(DataError, match="there is no such store"):
        Store(tmp_path / "x.db", create=False)
    with pytest.raises(OptionError, match="mysql is not supported"):
        Store("mysql://host/name")
    with pytest.raises(DataError, match="refused") as caught:
        Store("postgresql://me:secret@127.0.0.1:1/name")
    assert "secret" not in str(caught.value)
