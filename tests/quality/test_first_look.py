"""Means of a record before an analysis: the verdicts, and the limits that they share with the checks of an analysis."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import Record
from sigmatau.quality.first_look import first_look
from sigmatau.quality.samples.units import GRAVITY_TOLERANCE, USUAL_OFFSET, gravity, mean_rate
from sigmatau.units import STANDARD_GRAVITY

DIRECTION = np.array([0.6, 0.0, -0.8])


def looked_at(sensor, mean, unit=None):
    """The only mean of a record of three axes."""
    noise = 1e-3 * np.random.default_rng(seed_of(f"{sensor} {mean}")).standard_normal((2000, 3))
    record = Record.from_arrays(rate=100, unit={sensor: unit} if unit else None, **{sensor: noise + mean * DIRECTION})
    (seen,) = first_look(record)
    return seen, record.streams[0]


@pytest.mark.parametrize(
    ("mean", "unit", "verdict", "likely"),
    [
        (9.81, "m/s^2", "gravity", ""),
        ((1 + 0.99 * GRAVITY_TOLERANCE) * STANDARD_GRAVITY, "m/s^2", "gravity", ""),
        ((1 + 1.01 * GRAVITY_TOLERANCE) * STANDARD_GRAVITY, "m/s^2", "not_gravity", ""),
        (0.02, "m/s^2", "gravity_removed", ""),
        (1.0, "m/s^2", "other_unit", "g"),
        (9.81, "g", "other_unit", "m/s^2"),
        (4.0, "m/s^2", "not_gravity", ""),
    ],
)
def test_accelerometer(mean, unit, verdict, likely):
    seen, stream = looked_at("accel", mean, unit)
    assert (seen.sensor, seen.verdict, seen.likely, seen.expected) == ("accel", verdict, likely, STANDARD_GRAVITY)
    warned = any(finding.severity == "warning" for finding in gravity(stream))
    assert warned == (verdict == "not_gravity")


@pytest.mark.parametrize(("share", "verdict"), [(0.0, "offset"), (0.98, "offset"), (1.02, "large_offset")])
def test_gyroscope(share, verdict):
    """The limit is that of the finding `mean_rate`."""
    seen, stream = looked_at("gyro", share * USUAL_OFFSET)
    assert (seen.verdict, seen.expected) == (verdict, USUAL_OFFSET)
    assert seen.length == pytest.approx(share * USUAL_OFFSET, abs=1e-4)
    assert bool(mean_rate(stream)) == (verdict == "large_offset")


def test_resolution_of_a_gyroscope_shows_its_unit():
    counts = np.random.default_rng(seed_of("counts")).normal(scale=20, size=(20_000, 3)).round()
    (seen,) = first_look(Record.from_arrays(rate=100, unit={"gyro": "rad/s"}, gyro=counts / 131))
    assert (seen.verdict, seen.likely) == ("other_unit", "deg/s")


def test_only_triads():
    """The mean of two axes has no expected length; a missing axis has no mean."""
    assert first_look(Record.from_arrays(rate=100, accel_x=np.ones(100), accel_y=np.ones(100))) == ()
    assert first_look(Record.from_arrays(rate=100, accel=np.full((100, 3), np.nan))) == ()
    assert first_look(Record.from_arrays(rate=100, gyro_x=np.zeros(100), mag_x=np.zeros(100))) == ()
