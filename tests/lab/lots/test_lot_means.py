"""Orientation, signs and gravity of a unit against the lot: every change of the axes, and false alarms."""

import math

import numpy as np
import pytest

from known import seed_of
from sigmatau.lab.lots.axis_changes import CHANGES
from sigmatau.lab.lots.lot_means import collect_means, compare_means
from sigmatau.lab.lots.lot_unit import UnitChannel, UnitCoefficient, UnitResult

UNITS = 20
GRAVITY = 9.80665
BIAS = {"gyro": [2e-4, -6e-4, 1e-3], "accel": [0.0, 0.0, GRAVITY]}
SPREAD = {"gyro": 2e-5, "accel": 0.03}
QUANTITY = {"gyro": ("angular_rate", "rad/s"), "accel": ("acceleration", "m/s^2")}


def lot(rng, *, units=UNITS, tails=None):
    """Means of a lot by sensor, shape (units, 3)."""
    noise = {
        sensor: rng.standard_normal((units, 3)) if tails is None else rng.standard_t(tails, (units, 3))
        for sensor in BIAS
    }
    return {sensor: np.array(BIAS[sensor]) + SPREAD[sensor] * noise[sensor] for sensor in BIAS}


def as_units(means, walk=None):
    """Units with channels that have a mean, and a random walk if it is given."""
    coefficients = {} if walk is None else {"random_walk": UnitCoefficient(value=walk, low=walk, high=walk)}
    count = len(next(iter(means.values())))
    empty = np.zeros(0)
    return {
        f"u{row}": UnitResult(
            channels={
                f"{sensor}_{axis}": UnitChannel(
                    quantity=QUANTITY[sensor][0],
                    unit=QUANTITY[sensor][1],
                    rate=100.0,
                    samples=1000,
                    tau=empty,
                    adev=empty,
                    coefficients=coefficients,
                    mean=float(values[row, k]),
                )
                for sensor, values in means.items()
                for k, axis in enumerate("xyz")
            }
        )
        for row in range(count)
    }


def compared(means, levels=None, probability=0.01, walk=None):
    units = as_units(means, walk)
    remarks = {name: [] for name in units}
    scaled = compare_means(units, remarks, levels or {}, without=set(), probability=probability, judged=True)
    return {name: about for name, about in remarks.items() if about}, scaled


@pytest.mark.parametrize("change", CHANGES, ids=[f"{change.sources}{change.signs}" for change in CHANGES])
def test_every_change_of_the_axes_is_named(change):
    """The gyro biases of the lot differ on all axes, so that each of the 47 changes is distinct."""
    means = lot(np.random.default_rng(seed_of(f"change {change}")))
    for values in means.values():
        values[7] = change.matrix @ values[7]
    remarks, _ = compared(means)
    assert list(remarks) == ["u7"]
    [remark] = remarks["u7"]
    assert remark.code == "orientation"
    assert remark.kind == "lot"
    assert remark.details.changes == (change,)
    # Gravity does not move in a turn about z: then only the gyros differ.
    assert len(remark.channels) == (3 if change.sources[2] == 2 and change.signs[2] == 1 else 6)


@pytest.mark.parametrize(("change", "words"), [
    ((0, 2, 1, 1, 1, 1), "axes y and z exchanged, or mounted on its side, 90° about x: gravity is along +y, "),
    ((0, 1, 2, 1, -1, -1), "mounted upside down, or sign of z reversed: gravity is along −z, in the lot along +z"),
    ((0, 2, 1, 1, -1, 1), "mounted on its side, 90° about x, or "),
])  # fmt: skip
def test_words_of_gravity_alone(change, words):
    """Gravity on one axis leaves two explanations open; both are named."""
    means = {"accel": lot(np.random.default_rng(seed_of(f"words {change}")))["accel"]}
    matrix = next(c for c in CHANGES if (*c.sources, *c.signs) == change).matrix
    means["accel"][3] = matrix @ means["accel"][3]
    remarks, _ = compared(means)
    assert remarks["u3"][0].finding.message.startswith(words)


def test_a_wrong_scale_is_gravity_and_noise():
    means = lot(np.random.default_rng(seed_of("scale of a unit")))
    means["accel"][4] *= 1.25
    remarks, scaled = compared(means, {("u4", "accel"): math.log(1.22)})
    assert scaled == {("u4", "accel")}
    [remark] = remarks["u4"]
    assert remark.code == "other_scale"
    assert remark.details.gravity == pytest.approx(1.25, rel=0.01)
    assert remark.finding.message == "wrong scale: gravity is 25 % above the lot's median, the noise 22 % above it"
    remarks, _ = compared(means, {("u4", "accel"): 0.0})
    assert remarks["u4"][0].finding.message == "scale or bias? Gravity is 25 % above the lot's median"


def test_an_outlying_mean_is_a_note():
    means = lot(np.random.default_rng(seed_of("outlying mean")))
    means["gyro"][5, 1] += 20 * SPREAD["gyro"]
    remarks, _ = compared(means)
    [remark] = remarks["u5"]
    assert (remark.code, remark.kind, remark.channels) == ("other_mean", "note", ("gyro_y",))


@pytest.mark.parametrize(("units", "gravity"), [(6, GRAVITY), (60, GRAVITY), (20, 0.0)])
def test_false_alarms(units, gravity):
    """Of clean lots, at most the stated share names anybody, also if gravity was removed."""
    rng = np.random.default_rng(seed_of(f"clean means {units} {gravity}"))
    sets, probability, alarms = 200, 0.05, 0
    for _ in range(sets):
        means = lot(rng, units=units)
        means["accel"][:, 2] += gravity - GRAVITY
        alarms += bool(compared(means, probability=probability)[0])
    assert alarms / sets <= probability + 3 * math.sqrt(probability * (1 - probability) / sets)


def test_a_difference_within_the_noise_of_the_mean_is_no_outlier():
    """Records whose mean was removed have means of rounding; one of them is the largest."""
    means = {sensor: np.zeros((UNITS, 3)) for sensor in BIAS}
    means["gyro"][:, 0] = np.linspace(-1e-19, 1e-19, UNITS)
    means["gyro"][5, 0] = 1e-17
    assert compared(means)[0]["u5"]
    assert compared(means, walk=1e-4)[0] == {}


def test_two_orientations_of_a_fixture_are_not_outliers():
    means = lot(np.random.default_rng(seed_of("two stands")))
    means["accel"][::2, 2] *= -1
    for remarks in compared(means)[0].values():
        assert [(remark.code, remark.kind) for remark in remarks] == [("mixed_lot", "note")]


def test_few_units_or_axes_are_not_compared():
    rng = np.random.default_rng(seed_of("few means"))
    assert collect_means(as_units(lot(rng, units=5))) == []
    units = as_units({"gyro": lot(rng)["gyro"]})
    without = {
        name: UnitResult(channels={c: part for c, part in unit.channels.items() if c != "gyro_z"})
        for name, unit in units.items()
    }
    assert collect_means(without) == []
