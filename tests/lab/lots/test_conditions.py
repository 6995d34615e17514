"""Conditions are factors: units and runs at several temperatures, voltages or rates are never mixed in silence."""

import functools
from dataclasses import replace

import numpy as np
import pytest

import sigmatau as st
from known import seed_of
from sigmatau.lab.lots.conditions import RATE, SUPPLY, TEMPERATURE, celsius, run_supply, run_temperature, volts
from sigmatau.lab.lots.lot_findings import MixedLot, OtherCondition
from sigmatau.record.record import TemperatureRange

NAMES = [f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"]


@functools.cache
def unit(k, rate=10, gravity=9.80665):
    """A unit at rest with gravity along z."""
    rng = np.random.default_rng(seed_of(f"condition unit {k}"))
    n = 600 * rate
    columns = {
        "gyro": 1e-5 * rng.standard_normal(3) + 1e-4 * rng.standard_normal((n, 3)),
        "accel": 1e-2 * rng.standard_normal(3) + 1e-3 * rng.standard_normal((n, 3)) + [0, 0, gravity],
    }
    return st.analyze(st.Record.from_arrays(rate=rate, **columns))


def with_notes(analysis, **notes):
    return replace(analysis, notes={**analysis.notes, **notes})


def details(lot, name, kind):
    return [remark.details for remark in lot[name].remarks if isinstance(remark.details, kind)]


@pytest.mark.parametrize(
    ("factor", "values", "groups"),
    [
        (TEMPERATURE, [25, 24.1, 85, None], ["at 24.6 °C", "at 24.6 °C", "at 85 °C", "at an unknown temperature"]),
        (TEMPERATURE, [25, 27, 29.9, None], [""] * 4),
        (SUPPLY, [3.3, 3.31, 5.0], ["at 3.3 V", "at 3.3 V", "at 5 V"]),
        (RATE, [100, 100.9, 200], ["at 100 Hz", "at 100 Hz", "at 200 Hz"]),
        (RATE, [], []),
    ],
)
def test_groups(factor, values, groups):
    assert factor.groups(values) == groups


@pytest.mark.parametrize(
    ("text", "value"), [("3.3", 3.3), ("3.3V", 3.3), ("3300 mV", 3.3), ("3.3 A", None), ("", None)]
)
def test_volts(text, value):
    assert volts(text) == (None if value is None else pytest.approx(value))
    assert celsius("298.15K") == pytest.approx(25)


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("shift/SN7_3.3V.csv", 3.3), ("SN7_3V3_25C.csv", 3.3), ("SN7-5V.csv", 5.0), ("SN7_V2.csv", None),
        ("SN7_12Vx.csv", None), ("SN7_3V_5V.csv", None), ("5V/SN7.csv", None), ("", None),
    ],
)  # fmt: skip
def test_voltage_in_a_name(path, value):
    analysis = unit(0)
    analysis = replace(analysis, source=replace(analysis.source, path=path))
    assert run_supply(analysis) == value
    assert run_supply(with_notes(analysis, **{"Supply voltage": "1.8 V"})) == 1.8


def test_a_stated_temperature_precedes_that_of_the_log():
    analysis = unit(0)
    warm = replace(
        analysis, source=replace(analysis.source, temperature=TemperatureRange(mean=31.0, low=30.0, high=32.0))
    )
    assert run_temperature(analysis) is None
    assert run_temperature(warm) == 31.0
    assert run_temperature(with_notes(warm, temperature="25 degC")) == 25.0


CONDITIONS = {
    "temperature": (lambda k: with_notes(unit(k), temperature="25"), lambda k: with_notes(unit(k), temperature="85")),
    "supply": (lambda k: with_notes(unit(k), supply="3.3 V"), lambda k: with_notes(unit(k), supply="5 V")),
    "rate": (unit, lambda k: unit(k, rate=20)),
}


@pytest.mark.parametrize("factor", CONDITIONS)
class TestLot:
    def test_an_exception_is_named_and_not_compared(self, factor, request):
        usual, odd = CONDITIONS[factor]
        units = {f"SN{k}": (odd if k == 3 else usual)(k) for k in range(8)}
        lot = st.judge_lot(units)
        (other,) = details(lot, "SN3", OtherCondition)
        assert other.factor == factor
        assert not any(details(lot, name, OtherCondition) for name in units if name != "SN3")
        assert all(len(distribution.values) == 7 for distribution in lot.distributions)

    def test_without_a_majority_nothing_is_compared(self, factor):
        usual, odd = CONDITIONS[factor]
        lot = st.judge_lot({f"SN{k}": (odd if k % 2 else usual)(k) for k in range(8)})
        for judged in lot.units:
            (mixed,) = details(lot, judged.name, MixedLot)
            assert mixed.factor == factor
            assert [count for _, count in mixed.groups] == [4, 4]
        assert lot.distributions == ()


class TestOrientations:
    @pytest.mark.parametrize("turned", [6, 5])
    def test_two_groups(self, turned):
        """Of half a lot upside down, nobody knows which half is right."""
        lot = st.judge_lot({f"SN{k}": unit(k, gravity=-9.80665 if k < turned else 9.80665) for k in range(12)})
        for judged in lot.units:
            (mixed,) = details(lot, judged.name, MixedLot)
            assert mixed.factor == "orientation"
            assert not any(remark.code == "orientation" for remark in judged.remarks)
        assert "2 orientations" in repr(lot)

    def test_a_few_are_named(self):
        lot = st.judge_lot({f"SN{k}": unit(k, gravity=-9.80665 if k < 2 else 9.80665) for k in range(12)})
        named = {judged.name for judged in lot.units if any(remark.code == "orientation" for remark in judged.remarks)}
        assert named == {"SN0", "SN1"}


class TestComparison:
    def test_runs_at_two_temperatures_are_not_a_turn_on_bias(self):
        runs = [with_notes(unit(k), temperature=text, unit="A") for k, text in enumerate(["25", "25", "85", "85"])]
        comparison = st.compare_runs(runs)
        assert comparison.groups == ("A at 25 °C", "A at 85 °C")
        assert "no turn-on bias" in repr(comparison)
        assert set(st.measure_turn_on(comparison, unit="A at 25 °C")) == set(NAMES)

    def test_of_a_unit_without_a_name(self):
        runs = [with_notes(unit(k), supply=text) for k, text in enumerate(["3.3", "5"])]
        comparison = st.compare_runs(runs)
        assert comparison.groups == ("at 3.3 V", "at 5 V")
        assert "Nothing to compare" in repr(comparison)
        assert "1 at 3.3 V, 1 at 5 V" in repr(comparison)

    def test_equal_conditions(self):
        comparison = st.compare_runs([with_notes(unit(k), temperature="25") for k in range(3)])
        assert comparison.groups == ("",)
        assert "°C" not in repr(comparison)
