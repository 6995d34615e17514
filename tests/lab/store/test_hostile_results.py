"""Results with values of other types, damaged and foreign databases, wrong places and options: one sentence, and no harm."""

import json
import sqlite3
from datetime import UTC, datetime, timedelta, timezone

import pytest
from store_results import entry_of, result

import sigmatau as st
from sigmatau.cli import main
from sigmatau.errors import DataError, OptionError
from sigmatau.lab.store.choosing import Chosen
from sigmatau.lab.store.connect import is_store, shown_place
from sigmatau.lab.store.ingest import Added
from sigmatau.lab.store.naming import Naming
from sigmatau.lab.store.store import Store


def channel(**values):
    def change(one):
        one["channels"]["gyro_x"] |= values

    return change


def fit(**values):
    def change(one):
        one["channels"]["gyro_x"]["fit"] |= values

    return change


def walk(**values):
    def change(one):
        one["channels"]["gyro_x"]["fit"]["terms"]["random_walk"] |= values

    return change


def nested(one):
    one["options"] = NESTED


NESTED = "so deep that a recursive program ends"

HOSTILE = {
    "more samples than 64 bits": channel(samples=1e300),
    "negative samples": channel(samples=-5),
    "rate": channel(sample_rate_hz=0),
    "trust": channel(trust={"a": 1}),
    "quantity": channel(quantity={"a": 1}),
    "long quantity": channel(quantity="q" * 100_000),
    "verdict": fit(verdict=[]),
    "long verdict": fit(verdict="x" * 300),
    "probability": fit(p_value="high"),
    "observed": walk(observed={}),
    "observed as text": walk(observed="maybe"),
    "observed as a number": walk(observed=1.0),
    "value is true": walk(value=True),
    "infinite": walk(value=float("inf")),
    "unit": walk(unit=None),
    "checksum": lambda one: one["source"].update(sha256={"a": 5}),
    "nested": nested,
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_result_keeps_no_other_from_the_store(tmp_path, name):
    one = result(1)
    HOSTILE[name](one)
    files = [tmp_path / f"{k}.json" for k in range(3)]
    for file, content in zip(files, (result(0), one, result(2)), strict=True):
        file.write_text(json.dumps(content).replace(f'"{NESTED}"', '{"a": ' * 950 + "{}" + "}" * 950))
    with Store(tmp_path / "x.db") as store:
        found = store.add_files(files, Naming(unit="A"))
        assert (found.added, [problem.file.stem for problem in found.problems]) == (Added(new=2), ["1"])


def test_several_analyses_are_added(tmp_path):
    model = st.NoiseModel(channels={"gyro_x": {"random_walk": 2e-5}})
    days = [st.analyze(st.simulate(model, duration=200, rate=10, rng=day)) for day in (1, 2)]
    with Store(tmp_path / "x.db") as store:
        assert store.add(days, unit="A") == Added(new=2)
        for wrong in (result(0), [result(0)], None):
            with pytest.raises(TypeError, match="Entry or Analysis"):
                store.add(wrong, unit="A")
        with pytest.raises(OptionError, match="at least 1"):
            store.add(days, unit="A", batch=0)


EDGE = datetime(1, 1, 1, tzinfo=timezone(timedelta(hours=12)))


def test_times_and_temperatures_that_are_none(tmp_path):
    with Store(tmp_path / "x.db") as store:
        for entry in (
            entry_of(result(0), unit="A", recorded=EDGE),
            entry_of(result(0), unit="A", temperature=float("nan")),
        ):
            with pytest.raises(DataError):
                store.add([entry])
        with pytest.raises(DataError, match="years 1 to 9999"):
            store.runs(Chosen(since=EDGE))
        early = datetime(1, 1, 1, tzinfo=UTC)
        store.add([entry_of(result(0), unit="A", recorded=early)])
        assert store.runs(Chosen(since=early)).columns()["recorded"] == [early.replace(tzinfo=None)]
    for degrees in (float("nan"), float("inf"), -300.0):
        with pytest.raises(OptionError, match=r"outside -273\.15 to 1000"):
            Naming(unit="A", temperature=degrees).check()
    with pytest.raises(DataError, match="years 1 to 9999"):
        Naming(unit="A", date=EDGE.isoformat()).check()


def changed(place, *statements):
    with sqlite3.connect(place) as connection:
        for statement in statements:
            connection.execute(statement)
    connection.close()


@pytest.mark.parametrize(
    ("statement", "read"),
    [
        ("UPDATE result SET numbers = x'0102'", lambda store: store.compare()),
        ("UPDATE result SET content = x'00'", lambda store: store.latest("A")),
        ("UPDATE run SET recorded = 'yesterday'", lambda store: store.runs()),
        ("UPDATE run SET recorded = 'yesterday'", lambda store: store.units_latest()),
        ("UPDATE run SET recorded = x'00'", lambda store: store.runs()),
        ("UPDATE run SET duration = 'long'", lambda store: store.runs()),
        ("UPDATE run SET state = x'00'", lambda store: store.runs()),
        ("DROP TABLE coefficient", lambda store: store.coefficients()),
    ],
)
def test_damaged_values_are_an_error_of_the_store(tmp_path, statement, read):
    place = tmp_path / "x.db"
    with Store(place) as store:
        store.add([entry_of(result(0), unit="A", recorded=datetime(2026, 5, 1, tzinfo=UTC))])
    changed(place, statement)
    with Store(place) as store, pytest.raises(DataError, match="store"):
        read(store)


@pytest.mark.parametrize(
    "statements",
    [
        ("UPDATE alembic_version SET version_num = x'00'",),
        (
            "PRAGMA writable_schema = 1",
            # CREATE TABLE label, and a byte that is not text
            "UPDATE sqlite_master SET sql = CAST(x'435245415445205441424c45206c6162656c20d63028' AS TEXT)"
            " WHERE name = 'label'",
        ),
    ],
    ids=["version", "schema"],
)
def test_a_store_that_cannot_be_opened(tmp_path, statements):
    """SQLite puts bytes of the file into its message, which may not be text."""
    place = tmp_path / "x.db"
    Store(place).close()
    changed(place, *statements)
    with pytest.raises(DataError, match=r"x\.db: "):
        Store(place)
    assert is_store(place) in {True, False}


def test_database_of_another_program_with_versions(tmp_path):
    place = tmp_path / "other.db"
    changed(
        place,
        "CREATE TABLE users (a)",
        "CREATE TABLE alembic_version (version_num VARCHAR(32))",
        "INSERT INTO alembic_version VALUES ('ab12')",
    )
    with pytest.raises(DataError, match="has other tables"):
        Store(place)


@pytest.mark.parametrize(
    ("place", "told"),
    [
        ("postgresql://lab@host:port/results", "is not a URL"),
        ("sqlite://lab.db", "by its name"),
        ("MYSQL://lab@host/results", "mysql is not supported"),
    ],
)
def test_wrong_urls(place, told):
    with pytest.raises(OptionError, match=told):
        Store(place)


@pytest.mark.parametrize(
    ("place", "shown"),
    [
        ("postgresql://lab:p@ss@host/results", "postgresql://lab:…@host/results"),
        ("postgresql://host/results?user=lab&password=secret&connect_timeout=5",
         "postgresql://host/results?user=lab&password=…&connect_timeout=5"),
        ("postgresql://lab@host/results", "postgresql://lab@host/results"),
    ],
)  # fmt: skip
def test_passwords_are_not_shown(place, shown):
    assert shown_place(place) == shown


def test_full_disk_says_what_to_do(tmp_path):
    with Store(tmp_path / "x.db") as store:
        with store._engine.connect() as connection:
            connection.exec_driver_sql("PRAGMA max_page_count = 40")
        with pytest.raises(DataError, match="disk is full; free some space"):
            store.add([entry_of(result(k, log=str(k)), unit="A") for k in range(60)])
        assert len(store.runs()) == 0


def test_one_unit_is_chosen_by_its_name(tmp_path):
    with Store(tmp_path / "x.db") as store:
        store.add([entry_of(result(k, log=str(k)), unit=unit) for k, unit in enumerate(["AB", "A", "B"])])
        assert store.runs(Chosen(units="AB")).columns()["unit"] == ["AB"]


def test_output_never_replaces_a_store(tmp_path, capsys):
    place = str(tmp_path / "lab.db")
    with Store(place) as store:
        store.add([entry_of(result(0), unit="A")])
    for command in (["store", "show", "A"], ["store", "trend"], ["compare"]):
        assert main([*command, "--store", place, "--json", place]) == 2
        assert "is a database" in capsys.readouterr().err
    with Store(place) as store:
        assert len(store.runs()) == 1
