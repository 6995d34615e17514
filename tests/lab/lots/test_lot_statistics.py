"""Statistics of a lot: how often they name a unit of a lot without outliers, and what they find."""

import math

import numpy as np
import pytest

from known import seed_of
from sigmatau.lab.lots.lot_bands import band, mistaken_units, scale
from sigmatau.lab.lots.lot_statistics import (
    COEFFICIENT_SHARE,
    FALSE_ALARMS,
    MEAN_SHARE,
    ORDER_SHARE,
    Series,
    distribution,
    outliers,
)

_FAMILIES = 18  # of six axes with three coefficients


def series(logs, errors=None, limited=None, what="random_walk"):
    """A series of one channel."""
    n = len(logs)
    return Series(
        channels=("gyro_x",),
        what=what,
        units=tuple(f"u{k}" for k in range(n)),
        logs=np.asarray(logs, dtype=float),
        errors=np.zeros(n) if errors is None else np.asarray(errors, dtype=float),
        limited=np.zeros(n, dtype=bool) if limited is None else limited,
        tau=60.0 if what == "adev" else 0.0,
    )


def test_shares_add_up():
    assert math.isclose(COEFFICIENT_SHARE + ORDER_SHARE + MEAN_SHARE, FALSE_ALARMS)


@pytest.mark.parametrize(("units", "lots"), [(10, 60), (40, 30)])
def test_false_alarms_of_outliers_and_order(units, lots):
    """Units differ by 20 % (ln), and are measured with errors of up to as much; a share of lots may name one."""
    rng = np.random.default_rng(seed_of(f"lots of {units}"))
    alarms = 0
    for _ in range(lots):
        named = False
        for k in range(_FAMILIES):
            error = (0.002, 0.05, 0.2)[k % 3]
            logs = 0.2 * rng.standard_normal(units) + error * rng.standard_normal(units)
            described = distribution("gyro_x", series(logs, np.full(units, error)), families=_FAMILIES)
            named |= bool(described.outliers) or described.order is not None
        alarms += named
    share = COEFFICIENT_SHARE + ORDER_SHARE
    assert alarms / lots <= share + 3 * math.sqrt(share * (1 - share) / lots)


def test_slow_noise_is_reported_above_the_lot_alone():
    """ln χ² has a long tail below, which is not a fault."""
    rng = np.random.default_rng(seed_of("slow noise"))
    logs = 0.1 * rng.standard_normal(40)
    logs[[3, 9]] = -2.0, 1.5
    assert list(distribution("gyro_x", series(logs, what="adev"), families=20).outliers) == ["u9"]
    assert list(distribution("gyro_x", series(logs), families=20).outliers) == ["u3", "u9"]


def test_a_batch_does_not_hide_an_outlier():
    """A unit 25 % above units that differ by 3 %, with a batch that rises to 30 %."""
    logs = 0.03 * np.random.default_rng(seed_of("batch and outlier")).standard_normal(40)
    logs[30:] += 0.03 * np.arange(1, 11)
    logs[21] += math.log(1.25)
    described = distribution("gyro_x", series(logs), families=_FAMILIES)
    assert list(described.outliers) == ["u21"]
    assert described.order.first in {"u28", "u29", "u30", "u31", "u32"}
    assert described.outliers["u21"] == pytest.approx(1.25, rel=0.1)


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
