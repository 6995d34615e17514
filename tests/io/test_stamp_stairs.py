"""Clocks that make only a few steps in a record: stamps in single precision, short records in whole seconds."""

import numpy as np
import pytest
from stamping import codes, found, record_of

from known import seed_of
from sigmatau.errors import DataError

EPOCH = 1_700_000_000.0


def single(t):
    return (EPOCH + t).astype(np.float32).astype(float)


@pytest.mark.parametrize("rate", [50.0, 100.0, 400.0])
@pytest.mark.parametrize("minutes", [5, 20])
def test_single_precision_seconds_since_1970(rate, minutes):
    n = round(60 * minutes * rate)
    one = found(single(np.arange(n) / rate))
    said = next(f for f in one.findings if f.code == "coarse_stamps")
    assert (said.severity, said.size) == ("warning", 128.0)
    assert said.details.single_precision
    assert codes(one, least="warning") == ["coarse_stamps"]
    assert one.rate == pytest.approx(rate, rel=1.01 / (128 * rate))  # a corner is one sample wide, of a step at least
    assert one.n == n


def test_with_one_step_the_rate_must_be_given():
    t = single(np.arange(10_000) / 100)
    with pytest.raises(DataError, match="two values only") as refused:
        record_of(t)
    assert "give --rate HZ" in str(refused.value)
    one = found(t, rate=100)
    assert one.rate == pytest.approx(100)
    assert codes(record_of(t, rate=100)) == ["coarse_stamps"]
    assert "rate_mismatch" in codes(record_of(t, rate=10))  # 6400 of 10,000 samples in 128 s are 50 Hz or more


@pytest.mark.parametrize("steps", [2.4, 5.7, 12.3, 30.9])
def test_the_rate_is_within_what_is_stated(steps):
    """Against samples that are even by construction, whatever their phase; least squares would be off by 1/steps²."""
    rng = np.random.default_rng(seed_of(f"stairs {steps}"))
    worse = 0
    for _ in range(80):
        per = rng.uniform(30, 300)
        n = round(steps * per)
        t = np.floor(np.arange(n) / per + rng.random())
        t -= t[0]
        if t[-1] < 2 or t[-1] ** 2 >= n:
            continue
        one = found(t)
        said = next(f for f in one.findings if f.code == "coarse_stamps")
        assert abs(one.rate / per - 1) <= said.details.rate_error
        assert said.details.rate_error <= 1.1 / (per * max(t[-1] - 1, 1))
        middle = np.arange(n) - (n - 1) / 2
        line = float(middle @ t) / float(middle @ middle)
        worse += abs(line * per - 1) > said.details.rate_error
    assert worse > 8  # so that the line of least squares would not do


def test_how_sure_the_rate_is_goes_with_it():
    t = np.floor(np.arange(62) / 20.3)
    said = next(f for f in found(t).findings if f.code == "coarse_stamps")
    assert said.severity == "warning"  # four levels of 20 samples: 2 %
    assert said.details.rate_error == pytest.approx(1 / 40)
    whole = found(np.floor(np.arange(20_000) / 100.0))
    assert [(f.code, f.severity) for f in whole.findings] == [("coarse_stamps", "info")]


@pytest.mark.parametrize("bunch", [700, 2000])
def test_long_bunches_are_no_drift(bunch):
    """A few bunches of uneven length bend a line through all stamps; their rate by tenths says nothing of the sensor."""
    rng = np.random.default_rng(seed_of(f"long bunches {bunch}"))
    for _ in range(8):
        ends = np.cumsum(rng.integers(bunch // 2, 3 * bunch // 2, 2 * 60_000 // bunch))
        k = np.arange(60_000)
        t = ends[np.searchsorted(ends, k, side="right")] / 100 + rng.uniform(0, 1e-3)
        assert "rate_drift" not in codes(found(t + 1e-9 * k))
