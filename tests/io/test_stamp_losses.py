"""Exact stamps of which most are lost: the grid is the sensor's, and bunches of a host are none."""

import numpy as np
import pytest

import sigmatau as st
from known import seed_of


def record_of(t, name, **options):
    x = np.random.default_rng(seed_of(name)).standard_normal(len(t))
    return st.from_frame({"t": t, "gyro_x": x}, unit={"gyro": "rad/s", "time": "s"}, **options)


@pytest.mark.parametrize("rate", [100.0, 128.0, 200 / 3])
@pytest.mark.parametrize("lost", [0.4, 0.6, 0.7, 0.8])
def test_samples_lost_at_random_leave_the_grid(rate, lost):
    name = f"lost {rate} {lost}"
    t = np.arange(6000) / rate
    kept = np.random.default_rng(seed_of(name)).random(len(t)) > lost
    record = record_of(t[kept], name)
    grid = record.streams[0].grid
    assert grid.rate == pytest.approx(rate, rel=1e-9)
    assert [finding.code for finding in record.findings] == ["gaps"]
    there = np.isfinite(record.streams[0].column("gyro_x"))
    first, last = np.flatnonzero(kept)[[0, -1]]
    assert np.array_equal(there, kept[first : last + 1])


@pytest.mark.parametrize("bunch", [(1, 1, 1, 12), (1, 9), (1, 4), (2, 3, 15), (1, 1, 4)])
def test_bunches_on_a_clock_of_milliseconds_are_a_hosts(bunch):
    """All of them whole multiples of 1 ms, too: but neighbours know of each other."""
    rng = np.random.default_rng(seed_of(f"bunches {bunch}"))
    steps = np.tile(bunch, 2000)
    steps[len(bunch) - 1 :: len(bunch)] += rng.integers(0, 3, 2000)
    record = record_of(np.cumsum(steps) / 1000, f"bunches {bunch}", interleaved=1)  # as groups of several sensors look
    if np.mean(steps) > 2:  # else most places are filled, and a grid it is
        assert record.streams[0].grid.rate < 500
        assert "gaps" not in [finding.code for finding in record.findings]
