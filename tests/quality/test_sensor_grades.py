"""Units by noise and mean; silence on sensors from navigation grade to cheap MEMS."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import Record
from sigmatau.hints import Hint
from sigmatau.quality.facts import keep_facts
from sigmatau.quality.samples.units import implausible_unit

DEG, G = np.pi / 180, 9.80665
N, RATE = 1 << 14, 100.0


def triad(rng, density, means, *, spread=0.0):
    """White noise of (density)/√Hz on each axis, spread lognormally, about some means."""
    sigma = density * np.sqrt(RATE) * np.exp(spread * rng.standard_normal(3))
    return np.asarray(means) + sigma * rng.standard_normal((N, 3))


def gyro_record(samples, unit="rad/s"):
    return Record.from_arrays(rate=RATE, unit={"gyro": unit}, gyro=samples)


def accel_record(samples, unit="m/s^2"):
    return Record.from_arrays(rate=RATE, unit={"accel": unit}, accel=samples)


@keep_facts()
def found(record):
    return implausible_unit(record.streams[0])


def test_all_in_g_is_told_of_the_triad():
    rng = np.random.default_rng(seed_of("all in g"))
    (said,) = found(accel_record(triad(rng, 50e-6, [0.01, -0.015, 1.0])))
    assert said.channels == ("accel_x", "accel_y", "accel_z")
    assert said.details.correction == Hint("unit", "accel", "g")


@pytest.mark.parametrize("density", [0.004, 0.005, 0.03])
def test_consumer_gyros_in_degrees_said_to_be_radians(density):
    rng = np.random.default_rng(seed_of(f"degrees {density}"))
    (said,) = found(gyro_record(triad(rng, density, [0.05, -0.03, 0.02])))
    assert said.details.correction == Hint("unit", "gyro", "deg/s")
    assert dict(said.factors)["random_walk"] == pytest.approx(1 / DEG)


def test_noise_that_no_unit_explains_may_be_counts():
    rng = np.random.default_rng(seed_of("counts"))
    (said,) = found(gyro_record(triad(rng, 1.0, [3.0, -2.0, 1.0]), "deg/s"))
    assert said.details.likely == ""


@pytest.mark.parametrize("density", [0.003, 0.005])
def test_radians_said_to_be_degrees(density):
    """As quiet as optical gyros, with the bias of MEMS."""
    rng = np.random.default_rng(seed_of(f"radians {density}"))
    (said,) = found(gyro_record(triad(rng, density * DEG, np.array([0.9, -1.2, 0.3]) * DEG), "deg/s"))
    assert said.details.correction == Hint("unit", "gyro", "rad/s")
    assert dict(said.factors)["random_walk"] == pytest.approx(DEG)


EARTH = 15.04 / 3600  # deg/s

# White noise [(deg/s)/√Hz], bias of an axis [deg/s]: datasheets from ring lasers to the noisiest MEMS.
GYROS = {
    "ring laser": (0.002 / 60, 0.003 / 3600),
    "fibre optic": (0.012 / 60, 2 / 3600),
    "closed-loop fibre": (0.05 / 60, 6 / 3600),
    "tactical MEMS": (0.15 / 60, 250 / 3600),
    "industrial MEMS": (0.0066, 0.2),
    "older MEMS": (0.05, 3.0),
    "first MEMS": (0.1, 5.0),
    "consumer MEMS": (0.005, 10.0),
    "cheapest": (0.03, 15.0),
}


@pytest.mark.parametrize("unit", ["rad/s", "deg/s"])
@pytest.mark.parametrize("kind", GYROS)
def test_no_sensor_that_there_is_has_a_finding(kind, unit):
    """Five units of each, axes that differ by a fifth (1 sd), the Earth's rate on any of them; 90 triads, no finding.

    By the thresholds: 0.2 (deg/s)/√Hz is 3.5 sd above the noisiest; two axes of one triad apart by 6 is 6 sd.
    """
    rng = np.random.default_rng(seed_of(f"{kind} {unit}"))
    noise, bias = GYROS[kind]
    for _ in range(5):
        direction = rng.standard_normal(3)
        mean = bias * rng.uniform(-1, 1, 3) + EARTH * direction / np.linalg.norm(direction)
        samples = triad(rng, noise, mean, spread=0.2)
        record = gyro_record(samples * (DEG if unit == "rad/s" else 1.0), unit)
        assert found(record) == []


@pytest.mark.parametrize("density", [1e-8, 1e-6, 50e-6, 400e-6, 3e-3])
def test_accelerometers_from_seismic_to_cheap(density):
    rng = np.random.default_rng(seed_of(f"accel {density}"))
    for _ in range(5):
        direction = rng.standard_normal(3)
        samples = triad(rng, density, direction / np.linalg.norm(direction) + 0.02 * rng.standard_normal(3), spread=0.2)
        assert found(accel_record(samples, "g")) == []


@pytest.mark.parametrize("walk", [0.1, 0.3, 1.0])
@pytest.mark.parametrize("axes", ["xyz", "x"])
def test_degrees_per_second_said_to_be_per_hour(walk, axes):
    """Three axes as quiet as a strategic gyro, without the Earth's rotation; one axis only below all gyros."""
    rng = np.random.default_rng(seed_of(f"per hour {walk} {axes}"))
    samples = triad(rng, walk / 60, [0.4, -0.2, 0.1])
    columns = {f"gyro_{axis}": samples[:, k] for k, axis in enumerate(axes)}
    record = Record.from_arrays(rate=RATE, unit={"gyro": "deg/h"}, **columns)
    details = [(f.details.evidence, f.details.likely) for f in found(record)]
    if axes == "x":  # 6.9e-5 deg/√h is the quietest
        assert details == ([("quiet", "deg/s")] if walk / 3600 < 6.5e-5 else [])
    else:
        assert [likely for _, likely in details] == ["deg/s"]
        assert dict(found(record)[0].factors)["random_walk"] == pytest.approx(1 / 3600)


@pytest.mark.parametrize("walk", [1e-4, 1e-3])
def test_strategic_gyros_that_measure_the_earth(walk):
    rng = np.random.default_rng(seed_of(f"strategic {walk}"))
    samples = triad(rng, walk * 60, [9.0, 5.0, 10.6])  # deg/h
    assert found(gyro_record(samples, "deg/h")) == []


@pytest.mark.parametrize("truth", ["m/s^2", "g"])
@pytest.mark.parametrize("stated", ["ug", "mg"])
def test_gravity_in_a_smaller_unit(truth, stated):
    rng = np.random.default_rng(seed_of(f"{truth} as {stated}"))
    samples = triad(rng, 1e-3, [0.1, 0.2, 9.8]) / (9.80665 if truth == "g" else 1.0)
    (said,) = found(accel_record(samples, stated))
    assert (said.details.evidence, said.details.stated, said.details.likely) == ("gravity", stated, truth)


def test_one_accelerometer_below_all_noise():
    rng = np.random.default_rng(seed_of("one accelerometer"))
    record = Record.from_arrays(rate=RATE, unit={"accel": "ug"}, accel_z=9.8 + 0.01 * rng.standard_normal(N))
    (said,) = found(record)
    assert (said.details.evidence, said.details.likely) == ("quiet", "m/s^2")
    seismic = Record.from_arrays(rate=RATE, accel_z=10e-9 * G * 10 * rng.standard_normal(N))
    assert found(seismic) == []
