"""Supply voltage as a condition in a store: where it comes from, and that runs at two voltages are never mixed."""

import json
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest
from store_results import entry_of, result

import sigmatau as st
from sigmatau.cli import main
from sigmatau.errors import DataError, OptionError
from sigmatau.lab.store.choosing import Chosen
from sigmatau.lab.store.ingest import Added
from sigmatau.lab.store.naming import Naming
from sigmatau.lab.store.store import Store


def supplied(volts, k):
    return entry_of(result(k, log=f"{k}", path=f"{k}.csv"), unit="A", name=f"day {k}", supply=volts)


def supplies(store):
    runs = store.runs().columns()
    return dict(zip(runs["unit"], runs["supply"], strict=True))


def test_the_voltage_is_stated_noted_measured_or_in_the_name(place):
    in_name = result(0, log="0", path="logs/SN7_3V3.csv")
    noted = {**result(1, log="1", path="SN7_3V3.csv"), "notes": {"supply voltage": "5V"}}
    noise = np.random.default_rng(3).standard_normal((2, 4000))
    record = st.Record.from_arrays(rate=100, gyro_x=1e-3 * noise[0], vdd=1.8 + 1e-3 * noise[1], unit={"vdd": "V"})
    with Store(place) as store:
        store.add([entry_of(in_name, unit="name"), entry_of(noted, unit="note")])
        store.add(entry_of(result(2, log="2", path="SN7_3V3.csv"), unit="stated", supply=12.0))
        store.add(
            [entry_of(result(3, log="3"), unit="nowhere"), entry_of(st.analyze(record).to_dict(), unit="measured")]
        )
        found = supplies(store)
    measured = pytest.approx(1.8, abs=1e-4)  # six standard errors of the mean
    assert found == {"name": 3.3, "note": 5.0, "stated": 12.0, "nowhere": None, "measured": measured}


def test_a_stated_voltage_replaces_one_of_the_log_but_not_the_reverse(place):
    content = result(0, path="SN7_3V3.csv")
    with Store(place) as store:
        assert store.add(entry_of(content, unit="A")) == Added(new=1)
        assert store.add(entry_of(content, unit="A", supply=3.31)) == Added(updated=1)
        assert store.add(entry_of(content, unit="A")) == Added(known=1)
        assert supplies(store) == {"A": 3.31}


def test_runs_at_two_voltages_are_those_of_two_units(place):
    with Store(place) as store:
        store.add([supplied(3.3, 0), supplied(3.31, 1), supplied(5.0, 2), supplied(5.0, 3), supplied(None, 4)])
        found = store.compare()
        assert found.groups == ("A at 3.3 V", "A at 5 V", "A at an unknown supply")
        assert "2 at 3.3 V, 2 at 5 V, 1 at an unknown supply" in " ".join(repr(found).split())
        assert store.compare(Chosen(supply=(3.2, 3.4))).groups == ("A",)


def test_both_conditions_divide_the_runs(place):
    with Store(place) as store:
        entries = [supplied(volts, k) for k, volts in enumerate((3.3, 5.0, 3.3, 5.0))]
        temperatures = (-40.0, -40.0, 85.0, 85.0)
        store.add([replace(entry, temperature=degrees) for entry, degrees in zip(entries, temperatures, strict=True)])
        assert store.compare().groups == tuple(f"A at {t} °C at {v} V" for t in ("-40", "85") for v in ("3.3", "5"))


def test_a_trend_has_a_table_for_each_voltage(place):
    with Store(place) as store:
        for k in range(4):
            store.add(replace(supplied((3.3, 5.0)[k % 2], k), recorded=datetime(2026, 1, 1 + k, tzinfo=UTC)))
        trend = store.trend("random_walk", channels=("gyro_x",))
    assert [*trend.channels] == ["gyro_x at 3.3 V", "gyro_x at 5 V"]
    assert [channel.periods[0].runs for channel in trend.channels.values()] == [2, 2]


@pytest.fixture
def lab(tmp_path, capsys):
    """A store with two units, each at two supply voltages, and its place."""
    for k in range(4):
        rng = np.random.default_rng([k, 31])
        record = st.Record.from_arrays(rate=100, gyro=1e-4 * rng.standard_normal((4000, 3)), unit={"gyro": "rad/s"})
        notes = {"serial number": f"SN{k % 2}", "supply": ("3.3V", "5V")[k // 2], "date": f"2026-05-0{k + 1}"}
        (tmp_path / f"{k}.json").write_text(json.dumps(st.analyze(record, notes=notes).to_dict()))
    place = str(tmp_path / "lab.db")
    assert main(["store", "add", str(tmp_path), "--store", place]) == 0
    capsys.readouterr()
    return place


def test_a_lot_has_one_voltage(lab, capsys):
    assert main(["lot", "--store", lab]) == 2
    assert "runs at 3.3 V, at 5 V; a lot has one supply, give --supply" in capsys.readouterr().err
    assert main(["lot", "--store", lab, "--supply", "3300mV"]) == 4
    assert "2 units" in capsys.readouterr().out


def test_commands_choose_by_voltage(lab, capsys):
    def runs(*words):
        assert main(["store", "list", "runs", "--store", lab, "--json", *words]) == 0
        return json.loads(capsys.readouterr().out)["supply"]

    assert sorted(runs()) == [3.3, 3.3, 5.0, 5.0]
    assert runs("--supply", "5V") == [5.0, 5.0]
    assert runs("--supply", "3:4") == [3.3, 3.3]
    assert main(["compare", "--store", lab, "--supply", "3.3V"]) == 0
    assert " V" not in capsys.readouterr().out
    assert main(["compare", "--store", lab]) == 0
    assert "2 at 3.3 V, 2 at 5 V" in " ".join(capsys.readouterr().out.split())
    assert main(["store", "show", "SN0", "--store", lab]) == 0
    assert "5 V" in capsys.readouterr().out.splitlines()[0]


@pytest.mark.parametrize("text", ["three", "3.3A", "5:3", "1:2:3", "0V", "3300V"])
def test_a_wrong_voltage_is_an_option_error(lab, text, capsys):
    for command in (["lot", "--store", lab], ["compare", "--store", lab], ["store", "list", "runs", "--store", lab]):
        assert main([*command, "--supply", text]) == 2, command
        assert "--supply" in capsys.readouterr().err


def test_a_voltage_without_a_store_is_an_option_error(capsys):
    for command in (["lot", "a.json"], ["compare", "a.json"]):
        assert main([*command, "--supply", "3.3V"]) == 2
        assert "--supply needs --store" in capsys.readouterr().err


def test_a_note_that_is_no_voltage_is_not_ignored():
    analysis = st.Analysis.from_dict({**result(0), "notes": {"supply": "3,3 V"}})
    with pytest.raises(DataError, match=r"the note supply '3,3 V' is not a voltage like 3\.3V"):
        Naming(unit="A").entry(analysis, "a.json")
    with pytest.raises(OptionError, match="is not above 0 and at most 1000 V"):
        Naming(unit="A", supply=3300.0).check()
