"""Statistics of a lot: how often they name a unit of a lot without outliers, and what they find."""

import math

import numpy as np
import pytest

from known import seed_of
from sigmatau.lab.lots.lot_statistics import (
    FALSE_ALARMS,
    band,
    distribution,
    mistaken_units,
    outliers,
    scale,
    trend,
)

_FAMILIES = 18  # of six axes with three coefficients


@pytest.mark.parametrize(("units", "lots"), [(10, 150), (40, 80), (400, 15)])
def test_false_alarms_of_outliers_and_drift(units, lots):
    """Units differ by 20 % (ln), and are measured with errors of up to as much; in 5 % of lots one may be named."""
    rng = np.random.default_rng(seed_of(f"lots of {units}"))
    far = moved = 0
    for _ in range(lots):
        named = drifting = False
        for k in range(_FAMILIES):
            error = (0.002, 0.05, 0.2)[k % 3]
            x = np.exp(0.2 * rng.standard_normal(units) + error * rng.standard_normal(units))
            values = {str(j): (float(value), error) for j, value in enumerate(x)}
            found = distribution("gyro_x", "random_walk", values, families=_FAMILIES)
            named |= bool(found.outliers)
            drifting |= found.drift is not None
        far += named
        moved += drifting
    gate = FALSE_ALARMS + 3 * math.sqrt(FALSE_ALARMS * (1 - FALSE_ALARMS) / lots)
    assert far / lots <= gate
    assert moved / lots <= gate


@pytest.mark.parametrize("units", [10, 40, 400])
def test_outliers_are_found(units):
    """Units that differ by 4 %, and one 40 % above: ten standard deviations."""
    rng = np.random.default_rng(seed_of(f"outlier of {units}"))
    logs = 0.04 * rng.standard_normal(units)
    logs[3] = 0.4
    assert outliers(logs, np.full(units, 0.01), probability=FALSE_ALARMS / _FAMILIES) == [3]


def test_several_outliers_do_not_hide_each_other():
    logs = 0.04 * np.random.default_rng(seed_of("masking")).standard_normal(40)
    logs[[2, 9, 30]] = 0.6, 0.62, -0.7
    assert outliers(logs, np.zeros(40), probability=0.05 / _FAMILIES) == [2, 9, 30]


def test_a_unit_that_was_measured_badly_is_no_outlier():
    logs = 0.04 * np.random.default_rng(seed_of("badly measured")).standard_normal(40)
    errors = np.full(40, 0.01)
    logs[5], errors[5] = 0.5, 0.3
    assert 5 not in outliers(logs, errors, probability=0.05)


def test_a_small_difference_is_none_of_production():
    logs = 1e-4 * np.random.default_rng(seed_of("small difference")).standard_normal(40)
    logs[5] = 0.05
    assert outliers(logs, np.zeros(40), probability=0.05) == []


def test_few_or_equal_units():
    assert outliers(np.array([0.0, 0.0, 0.0, 9.0]), np.zeros(4), probability=0.05) == []
    assert outliers(np.zeros(40), np.zeros(40), probability=0.05) == []
    assert trend(np.zeros(40), probability=0.05) == (None, None)


def test_drift_is_found_with_its_size():
    """1 % a unit in noise of 4 %: 40 % over 40 units."""
    logs = 0.01 * np.arange(40) + 0.04 * np.random.default_rng(seed_of("drift")).standard_normal(40)
    change, p_value = trend(logs, probability=0.05 / _FAMILIES)
    assert change == pytest.approx(0.39, abs=3 * 0.04 * math.sqrt(12 / 40))  # error of a slope over the range
    assert p_value < 1e-6


def test_scale_is_that_of_the_whole_curve():
    tau = np.geomspace(0.1, 100, 20)
    rng = np.random.default_rng(seed_of("scale"))
    curves = {str(k): (tau, tau**-0.5 * np.exp(0.02 * rng.standard_normal(20))) for k in range(9)}
    curves["odd"] = (tau, 57.3 * tau**-0.5)
    of = band("gyro_x", curves, quantity="angular_rate", unit="rad/s")
    assert math.exp(scale(of, "odd")) == pytest.approx(57.3, rel=0.05)
    assert abs(scale(of, "3")) < 0.05
    assert scale(of, "none") is None


@pytest.mark.parametrize(
    ("quantity", "ratio", "units"),
    [
        ("angular_rate", 57.3, ("deg/s", "rad/s")),
        ("angular_rate", 1 / 57.3, ("rad/s", "deg/s")),
        ("angular_rate", 3600, ("deg/h", "deg/s")),
        ("acceleration", 9.8, ("m/s^2", "g")),
        ("acceleration", 1 / 9.8, ("g", "m/s^2")),
        ("angular_rate", 6.0, None),
        ("temperature", 57.3, None),
    ],
)
def test_mistaken_units(quantity, ratio, units):
    assert mistaken_units(quantity, ratio) == units


def test_curves_of_other_lengths():
    long, short = np.geomspace(0.1, 100, 31), np.geomspace(0.1, 10, 21)
    curves = {"a": (long, long**-0.5), "b": (long, long**-0.5), "c": (short, 2 * short**-0.5)}
    of = band("gyro_x", curves, quantity="angular_rate", unit="rad/s")
    assert len(of.tau) == 31
    assert np.isnan(of.curves["c"][-1])
    assert of.curves["c"][0] == pytest.approx(2 * 0.1**-0.5)
