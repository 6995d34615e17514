"""The turn-on bias: its interval covers the spread between power-ups, and the model file reads back to it."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

import sigmatau as st
from known import seed_of
from sigmatau.cli import main
from sigmatau.lab.lots.group_effects import group_effects
from sigmatau.model.turn_on import is_wide

DEG = math.pi / 180


@pytest.mark.parametrize("k", [2, 3, 7])
def test_the_interval_is_that_of_a_standard_deviation(k):
    """χ² with k - 1 degrees of freedom: its ends, and its coverage in 4000 units."""
    units = 4000
    biases = np.random.default_rng(seed_of(f"turn-on {k}")).normal(3.0, 0.5, size=(units, k))
    found = group_effects(biases, None, level=0.95)
    std = biases.std(axis=1, ddof=1)
    for end, p in ((found.tau_low, 0.975), (found.tau_high, 0.025)):
        np.testing.assert_allclose(end, std * math.sqrt((k - 1) / stats.chi2.ppf(p, k - 1)), rtol=1e-9)
    covered = ((found.tau_low < 0.5) & (found.tau_high > 0.5)).mean()
    assert covered == pytest.approx(0.95, abs=3 * math.sqrt(0.95 * 0.05 / units))


def days(biases, *, seed=0):
    """Analyses of a gyro and an accelerometer after power-ups with these biases."""
    model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-5}, "accel_x": {"random_walk": 1e-4}})
    found = []
    for day, bias in enumerate(biases, seed):
        powered = st.Imperfections(level={"gyro_x": bias, "accel_x": 10 * bias})
        record = st.simulate(model, duration=120.0 + day, rate=10, rng=day, imperfections=powered)
        found.append(st.analyze(record))
    return found


@pytest.fixture(scope="module")
def analysed():
    return days([0.010, 0.012, 0.009])


def test_means_of_runs_are_power_ups(analysed):
    found = st.measure_turn_on(st.compare_runs(analysed))
    assert set(found) == {"gyro_x", "accel_x"}
    assert found["gyro_x"].sigma == pytest.approx(np.std([0.010, 0.012, 0.009], ddof=1), rel=2e-3)  # N/√T is 1e-6
    assert found["accel_x"].sigma == pytest.approx(10 * found["gyro_x"].sigma, rel=2e-3)
    assert {spread.power_ups for spread in found.values()} == {3}
    assert all(is_wide(spread) for spread in found.values())


def test_of_several_units_one_is_chosen(analysed):
    comparison = st.compare_runs([*analysed, *days([0.011, 0.013], seed=10)], units=["A", "A", "A", "B", "B"])
    with pytest.raises(st.OptionError, match="units: A, B"):
        st.measure_turn_on(comparison)
    assert st.measure_turn_on(comparison, unit="B")["gyro_x"].power_ups == 2


def test_a_model_file_reads_back_to_the_same_bits(analysed, tmp_path):
    spreads = st.measure_turn_on(st.compare_runs(analysed))
    model = analysed[0].model.with_turn_on(spreads)
    model.write(tmp_path / "unit.toml")
    text = (tmp_path / "unit.toml").read_text(encoding="utf-8")
    again = st.NoiseModel.read(tmp_path / "unit.toml")
    assert {name: channel.turn_on for name, channel in again.items()} == spreads
    assert "(95 %), 3 power-ups" in text
    assert again["gyro_x"].to_dict()["turn_on"] == spreads["gyro_x"].to_dict()
    # The noise is that of the model without it.
    np.testing.assert_array_equal(model.adev("gyro_x", [1.0]), analysed[0].model.adev("gyro_x", [1.0]))
    assert st.NoiseModel.from_dict({"channels": {"gyro_x": {"random_walk": "1 deg/sqrt(h)"}}})["gyro_x"].turn_on is None


def test_units_of_a_stated_turn_on_bias():
    table = {"random_walk": "0.3 deg/sqrt(h)", "turn_on": {"sigma": "360 deg/h"}}
    stated = st.NoiseModel.from_dict({"channels": {"gyro_x": table}})["gyro_x"].turn_on
    assert (stated.sigma, stated.power_ups) == (pytest.approx(0.1 * DEG), None)
    assert stated.scaled(2.0).sigma == pytest.approx(0.2 * DEG)


@pytest.mark.parametrize(
    ("row", "why"),
    [
        ("360 deg/h", "turn_on is"),
        ({"low": "1 deg/h"}, "turn_on is"),
        ({"sigma": "360"}, "not a value with a unit"),
        ({"sigma": "1 mg"}, "sigma of turn_on"),
        ({"sigma": "-1 deg/h"}, "must be positive"),
        ({"sigma": "1 deg/h", "power_ups": 3}, "has low, high and power_ups"),
        ({"sigma": "9 deg/h", "low": "1 deg/h", "high": "5 deg/h", "power_ups": 3}, "between low and high"),
        ({"sigma": "2 deg/h", "low": "1 deg/h", "high": "5 deg/h", "power_ups": 1.5}, "power_ups must be"),
        ({"sigma": "2 deg/h", "spread": "1 deg/h"}, "turn_on is"),
    ],
)
def test_a_wrong_turn_on_bias_is_refused(row, why):
    table = {"random_walk": "0.3 deg/sqrt(h)", "turn_on": row}
    with pytest.raises(st.DataError, match=why) as refused:
        st.NoiseModel.from_dict({"channels": {"gyro_x": table}})
    assert "gyro_x" in str(refused.value)


def test_no_spread_beyond_the_errors_has_its_upper_end_as_prior():
    none = st.TurnOn(sigma=0.0, low=0.0, high=2e-3, power_ups=5)
    assert none.prior == 2e-3
    assert none.text("angular_rate", "rad/s") == "below 413 deg/h (95 %), 5 power-ups"


def test_commands_from_results_to_a_filter(analysed, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for number, day in enumerate(analysed, 1):
        Path(f"day{number}.json").write_text(day.to_json())
    results = [f"day{number}.json" for number in (1, 2, 3)]
    assert main(["compare", *results, "--model", "unit.toml"]) == 0
    assert "unit.toml: noise of day3, turn-on bias of 2 channels" in capsys.readouterr().err  # the longest
    spread = st.NoiseModel.read("unit.toml")["gyro_x"].turn_on
    assert main(["export", "day1.json", "--turn-on", "unit.toml", "--to", "okvis2", "-o", "lines.yaml"]) == 0
    assert "turn-on bias from 3 power-ups" in capsys.readouterr().err
    assert f"sigma_bg: {spread.sigma:.4g}  # rad/s; gyro_x: turn-on bias" in (tmp_path / "lines.yaml").read_text()


@pytest.mark.parametrize(
    ("argv", "code", "why"),
    [
        (["compare", "day1.json", "--model", "unit.toml"], 1, "in two runs of a unit"),
        (["compare", "day1.json", "day2.json", "--by", "run", "--model", "unit.toml"], 2, "not --by run"),
        (["compare", "day1.json", "day2.json", "--model", "unit.json"], 2, ".toml"),
        (["compare", "--store", "x.sqlite", "--model", "unit.toml"], 2, "not --store"),
        (["export", "day1.json", "--turn-on", "plain.toml", "--to", "okvis2"], 1, "no turn_on"),
        (["export", "--from-datasheet", "bmi088", "--turn-on", "plain.toml", "--to", "okvis2"], 2, "needs a source"),
    ],
)
def test_what_cannot_be_done_is_refused(analysed, argv, code, why, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for number, day in enumerate(analysed[:2], 1):
        Path(f"day{number}.json").write_text(day.to_json())
    analysed[0].model.write("plain.toml")
    assert main(argv) == code
    assert why in capsys.readouterr().err
    assert not (tmp_path / "unit.toml").exists()
