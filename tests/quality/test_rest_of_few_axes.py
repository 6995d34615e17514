"""Rest of accelerometers alone and of one axis, fits beyond the noisiest sensors; short forms of studies/rest_axes.py."""

from collections import Counter

import numpy as np
import pytest
from studies.motions import held
from studies.rest_axes import moving_axes
from studies.rest_windows import CLASSES, clean, verdict

import sigmatau as st
from known import seed_of
from sigmatau.findings.fit import BeyondClass

RECORDS = 4


def verdicts(kind, sensors):
    rng = np.random.default_rng(seed_of(f"{kind} of {sensors}"))
    records = [moving_axes(int(rng.integers(1 << 62)), kind, sensors) for _ in range(RECORDS)]
    return Counter(verdict(record).verdict for record in records)


@pytest.mark.parametrize("kind", ["tilt", "springs", "car", "walk", "drone"])
def test_three_accelerometers_that_move(kind):
    assert verdicts(kind, "accel, 3")["not_at_rest"] >= RECORDS - 1


@pytest.mark.parametrize("kind", ["walk", "drone", "hand", "held"])
def test_one_gyro_that_moves(kind):
    assert verdicts(kind, "gyro, 1") == {"not_at_rest": RECORDS}


def test_one_axis_of_a_hand_has_a_tremor():
    record = held(seed_of("one axis held"), sensors="gyro")
    one = st.Record.from_arrays(rate=100, gyro_x=record.streams[0].column("gyro_x"))
    assert verdict(one).motion.kind == "shakes"


@pytest.mark.parametrize(
    ("grade", "channels"),
    [*zip(CLASSES, 2 * [("accel_x",), ("accel_x", "accel_y", "accel_z"), ("gyro_z",)], strict=False)],
)
def test_clean_axes(grade, channels):
    record = clean(seed_of(f"{grade} {channels}"), grade, longest=600.0)
    axes = {channel: record.stream_of(channel).column(channel) for channel in channels}
    record = st.Record.from_arrays(rate=record.streams[0].grid.rate, **axes)
    assert verdict(record).verdict == "at_rest"
    if all(np.ptp(x) > 0 for x in axes.values()):  # coarse steps may hide all noise
        assert "beyond_class" not in {finding.code for finding in st.analyze(record).findings}


@pytest.mark.parametrize("times", [0.7, 2.0])
def test_one_accelerometer_with_more_noise_than_any(times):
    """Twice the noise of the noisiest: the motion may be aliased, or the unit is wrong."""
    x = 9.8 + times * 0.015 * 10 * np.random.default_rng(seed_of(f"noise {times}")).standard_normal(12_000)
    found = st.analyze(st.Record.from_arrays(rate=100, accel_z=x))
    assert found.rest.verdict == ("at_rest" if times < 1 else "not_at_rest")
    assert found.rest.unit_in_doubt == (times > 1)


def test_noise_beyond_the_class_is_not_good():
    """1.4 times the noisiest: at rest, and the factor is stated."""
    x = 9.8 + 1.4 * 0.015 * 10 * np.random.default_rng(seed_of("beyond")).standard_normal(12_000)
    found = st.analyze(st.Record.from_arrays(rate=100, accel_z=x))
    (finding,) = (one for one in found.findings if isinstance(one.details, BeyondClass))
    assert finding.severity == "warning"
    assert finding.details.times == pytest.approx(1.4, rel=0.1)
    assert dict(finding.factors)["random_walk"] == pytest.approx(1.4, rel=0.1)
    assert found["accel_z"].trust == "partial"
