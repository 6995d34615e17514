"""Several records of one unit: the clock that is off is named, and no honest one is."""

import numpy as np
import pytest
from scipy.signal import butter, lfilter

import known
from sigmatau import Record
from sigmatau.fitting.channel import fit_channel
from sigmatau.quality.clocks import Mark, collect_marks, compare_clocks

RATE, N, POOL, SETS = 100.0, 40_000, 6, 60
LINES = (7.31, 18.77)  # not multiples of each other [Hz]


def marks_of_record(name, *, rate=RATE, lines=LINES):
    """Three gyros behind a filter, with lines; `rate`: at which it is read."""
    rng = np.random.default_rng(known.seed_of(f"clock {name}"))
    b, a = butter(2, 0.5)
    t = np.arange(N) / RATE
    axes = {}
    for axis in "xyz":
        y = lfilter(b, a, rng.standard_normal(N + 500))[500:]
        y += sum(rng.uniform(0.1, 0.2) * np.sin(2 * np.pi * f * t + rng.uniform(0, 6)) for f in lines)
        axes[f"gyro_{axis}"] = 0.05 * y + 1e-6 * np.cumsum(rng.standard_normal(N))
    record = Record.from_arrays(rate=rate, unit={"gyro": "deg/s"}, **axes)
    return collect_marks({channel: fit_channel(record, channel) for channel in axes})


@pytest.fixture(scope="module")
def pool():
    return [marks_of_record(f"honest {k}") for k in range(POOL)]


@pytest.mark.parametrize("factor", [1.03])
def test_the_clock_that_is_off(pool, factor):
    records = {f"log {k}": marks for k, marks in enumerate(pool[:3])}
    found = compare_clocks({**records, "wrong": marks_of_record("wrong", rate=RATE * factor)})
    assert set(found) == {"wrong"}
    details = found["wrong"].details
    assert details.low <= factor <= details.high
    assert details.high - details.low < 0.02
    assert (details.others, details.marks >= 3) == (3, True)


def test_honest_records_have_no_clock_that_is_off(pool):
    """No set of 3 to 6 records of 60."""
    rng = np.random.default_rng(known.seed_of("sets of honest records"))
    for _ in range(SETS):
        chosen = rng.choice(POOL, rng.integers(3, 7), replace=False)
        assert compare_clocks({f"log {k}": pool[k] for k in chosen}) == {}


def test_lines_anywhere_are_no_clock():
    """Records of different places: 60 sets of lines at random frequencies, on the axes where they are seen."""
    rng = np.random.default_rng(known.seed_of("lines anywhere"))

    def record():
        at = rng.uniform(0.5, 49, rng.integers(1, 9))
        return tuple(
            Mark(f"gyro_{axis}", "line", float(f), 0.02 / f) for axis in "xyz" for f in at if rng.random() < 0.8
        )

    assert [compare_clocks({f"log {k}": record() for k in range(4)}) for _ in range(SETS)] == [{}] * SETS


def test_a_fan_at_another_speed_is_no_clock(pool):
    """Its line and their multiples move together, the filter does not."""
    fan = [marks_of_record(f"fan {k}", lines=(f, 2 * f)) for k, f in enumerate((9.0, 9.0, 9.0, 8.73))]
    assert compare_clocks({f"log {k}": marks for k, marks in enumerate(fan)}) == {}


def test_two_records_do_not_tell_which_clock_is_off(pool):
    assert compare_clocks({"one": pool[0], "wrong": marks_of_record("wrong", rate=0.97 * RATE)}) == {}
