"""Repeatability from a store is that of the files."""

import numpy as np
import pytest
from store_results import entry_of, result

import sigmatau as st
from sigmatau.errors import DataError, OptionError
from sigmatau.lab.lots.conditions import TEMPERATURE
from sigmatau.lab.store.choosing import Chosen
from sigmatau.lab.store.naming import Naming
from sigmatau.lab.store.store import Store


def test_same_as_of_results(place):
    results = [result(k, log=str(k), path=f"day{k}.csv") for k in range(5)]
    results[3]["channels"]["gyro_x"]["fit"]["verdict"] = "descriptive"
    terms = results[4]["channels"]["gyro_y"]["fit"]["terms"]
    terms["rate_ramp"] = {
        "observed": True,
        "value": -2e-9,
        "low": -3e-9,
        "high": -1e-9,
        "level": 0.9,
        "unit": "rad/s^2",
    }
    terms["quantization"] = {"observed": True, "value": 2e-9, "low": 0.0, "high": 3e-9, "level": 0.95, "unit": "rad"}
    names = [f"day{k}.csv" for k in range(5)]
    expected = st.compare_runs(results, names=names, units=["A"] * 5)
    with Store(place) as store:
        store.add([entry_of(one, unit="A") for one in results])
        found = store.compare()
    wanted = {(channel, term): expected.row(at) for at, (_, channel, term) in enumerate(expected)}
    assert {(channel, term) for _, channel, term in found} == set(wanted)
    for at, (_, channel, term) in enumerate(found):
        one, other = found.row(at).to_dict(), wanted[channel, term].to_dict()
        for key, value in other.items():
            same = pytest.approx(value, rel=1e-12, abs=0, nan_ok=True) if isinstance(value, float) else value
            assert one[key] == same, (channel, term, key)
        seen = [value for _, value, _ in found.values(at)]
        assert seen == [value for _, value, _ in expected.values([*wanted].index((channel, term)))]


def test_units_are_groups_and_are_chosen(place):
    with Store(place) as store:
        store.add([entry_of(result(k, log=str(k)), unit=f"{'AB'[k % 2]}{k % 4}") for k in range(5)])
        assert store.compare().groups == ("A0", "A2", "B1", "B3")
        assert store.compare(Chosen(units=("A*",))).groups == ("A0", "A2")
        with pytest.raises(DataError, match="no run with coefficients"):
            store.compare(Chosen(units=("C",)))


def test_temperatures_of_thermometers_divide_the_runs_as_for_files(place):
    """Without a stated temperature; one that is stated is not replaced by that of the log."""
    results = [result(k, log=str(k), path=f"day{k}.csv") for k in range(4)]
    for k, each in enumerate(results):
        mean = (-40.0, 25.0)[k % 2]
        each["source"]["temperature_degc"] = {"mean": mean, "low": mean - 1, "high": mean + 1}
    with Store(place) as store:
        store.add([entry_of(each, unit="A") for each in results])
        assert store.compare().groups == ("A at -40 °C", "A at 25 °C")
        assert store.compare().groups == st.compare_runs(results, units=["A"] * 4).groups
        store.add([entry_of(each, unit="A", temperature=25.0) for each in results])
        assert store.compare().groups == ("A",)
        store.add([entry_of(each, unit="A") for each in results])
        assert store.compare().groups == ("A",)


def test_a_copy_of_a_log_is_not_another_run(place):
    """Saved again it has other bytes: by its values it is the same record, as for files."""
    results = [result(k, log=str(k), path=f"day{k}.csv") for k in range(3)] + [
        result(0, log="saved again", path="x.csv")
    ]
    with Store(place) as store:
        store.add([entry_of(one, unit="A") for one in results])
        found = store.compare()
    assert [run.problem for run in found.runs] == ["", "", "", "of the same log as day0.csv"]
    expected = st.compare_runs(results, names=["0", "1", "2", "3"], units=["A"] * 4)
    assert [run.problem for run in expected.runs] == ["", "", "", "of the same log as 0"]
    assert found["A", "gyro_x", "random_walk"].std == pytest.approx(
        expected["A", "gyro_x", "random_walk"].std, rel=1e-12
    )


def test_a_log_with_two_options_is_one_run(place):
    with Store(place) as store:
        one = result(0, log="1")
        store.add([entry_of(one, unit="A"), entry_of(result(1, log="2"), unit="A")])
        store.add([entry_of(result(2, log="1") | {"options": {"analysis": {"window": "0s:30s"}}}, unit="A")])
        assert len(store.runs()) == 3
        found = store.compare()
        values = [value for _, value, _ in found.values([*found].index(("A", "gyro_x", "random_walk")))]
    told = [result(k)["channels"]["gyro_x"]["fit"]["terms"]["random_walk"]["value"] for k in (1, 2)]
    assert sorted(values) == sorted(told)


def test_analysis_is_added_by_its_notes(tmp_path):
    rates = 1e-3 * np.random.default_rng(3).standard_normal((3000, 1))
    record = st.Record.from_arrays(rate=100, gyro_x=rates[:, 0], unit={"gyro": "rad/s"})
    with st.Store(tmp_path / "x.db") as store:
        store.add(st.analyze(record, notes={"serial number": "A1", "date": "2026-05-01", "temperature": "25 degC"}))
        store.add(st.analyze(record), unit="A2")
        table = store.runs().columns()
        with pytest.raises(DataError, match="unit is not known"):
            store.add(st.analyze(record))
        with pytest.raises(OptionError):
            store.trend("walk")
    assert table["unit"] == ["A1", "A2"]
    assert table["temperature"] == [25.0, None]
    assert Naming().unit is None


def test_rows_are_in_the_order_of_files(tmp_path):
    """Gyros before accelerometers, whatever the order of the keys of the database."""
    rng = np.random.default_rng(24)
    days = []
    for _ in range(3):
        gyro, accel = 1e-3 * rng.standard_normal((2, 3000, 3))
        record = st.Record.from_arrays(rate=100, gyro=gyro, accel=accel, unit={"gyro": "rad/s", "accel": "m/s^2"})
        days.append(st.analyze(record).to_dict())
    expected = st.compare_runs(days, names=["1", "2", "3"], units=["A"] * 3)
    with Store(tmp_path / "x.db") as store:
        store.add([entry_of(day, unit="A", name=str(k)) for k, day in enumerate(days)])
        assert [key[1:] for key in store.compare()] == [key[1:] for key in expected]


@pytest.mark.parametrize(("stated", "groups"), [
    ([25.0, 25.4, 24.0, None], [""] * 4),
    ([-40.0, 25.0, 27.0], ["at -40 °C", "at 26 °C", "at 26 °C"]),
    ([85.0, None, 25.0], ["at 85 °C", "at an unknown temperature", "at 25 °C"]),
])  # fmt: skip
def test_groups_of_temperatures(stated, groups):
    assert TEMPERATURE.groups(stated) == groups


def test_temperatures_are_not_mixed(place):
    """N differs by 30 % between -40 and 85 °C: that is not a spread of the unit between its runs."""
    with Store(place) as store:
        for seed, temperature in enumerate((-40.0, -40.0, 85.0, 85.0)):
            store.add([entry_of(result(seed), unit="A", name=f"run {seed}", temperature=temperature)])
        compared = store.compare()
        assert compared.groups == ("A at -40 °C", "A at 85 °C")
        assert {compared["A at 85 °C", "gyro_x", "random_walk"].k} == {2}
        assert store.compare(Chosen(temperature=(80.0, 90.0))).groups == ("A",)
