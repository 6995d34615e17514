"""Stretches that are in a record twice, and steps of the mean across a gap."""

import numpy as np
import pytest
from tests.known import seed_of
from tests.quality.clean_records import record as clean_record

import sigmatau as st
from sigmatau.quality.check import examine
from sigmatau.quality.samples.copied_stretches import copied_stretches
from sigmatau.quality.selection.exclusion import from_the_start

RATE = 100.0


def stream_of(x):
    return st.Record.from_arrays(rate=RATE, gyro=x).streams[0]


def rounded_noise(name, step):
    rng = np.random.default_rng(seed_of(name))
    x = rng.standard_normal((60000, 3))
    return (np.round(x / step) * step if step else x) * 1e-3


@pytest.mark.parametrize("step", [0.0, 0.1, 1.0])
@pytest.mark.parametrize("rows", [100, 2000])
def test_copies_of_a_second_and_of_twenty(step, rows):
    x = rounded_noise(f"copies {step} {rows}", step)
    x[40000 : 40000 + rows] = x[10007 : 10007 + rows]
    (found,) = copied_stretches(stream_of(x))
    details = found.details
    assert rows <= details.rows <= rows + 20  # rows beside it may be equal by chance
    assert details.copy - details.start == pytest.approx(299.93)
    assert details.copy == pytest.approx(400, abs=0.2)


def test_no_copy_is_found_where_none_is():
    for step in (0.0, 0.1, 1.0, 3.0):
        assert not copied_stretches(stream_of(rounded_noise(f"no copies {step}", step)))
    rng = np.random.default_rng(seed_of("clean records without copies"))
    for _ in range(10):
        for stream in clean_record(rng).streams:
            assert not copied_stretches(stream)


def test_stuck_and_missing_stretches_are_no_copies():
    x = rounded_noise("stuck", 0.0)
    x[10000:11000] = x[30000:31000] = 0.0
    x[50000:51000] = np.nan
    x[20000:21000] = np.nan
    assert not copied_stretches(stream_of(x))


@pytest.mark.parametrize("size", [0.0, 1.0])
def test_a_step_of_the_mean_across_a_gap(size):
    x = rounded_noise("gap", 0.0)
    x[30000:] += size * 1e-3
    x[30000:30500] = np.nan
    found = examine(from_the_start(st.Record.from_arrays(rate=RATE, gyro=x))).findings
    assert ("not_static" in {one.code for one in found}) == (size > 0)
