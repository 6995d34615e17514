"""Noise that sampling folds into the random walk, for a stated bandwidth of the sensor."""

import math

import numpy as np
import pytest

import known
import sigmatau as st
from sigmatau.errors import OptionError
from sigmatau.noise.terms import aliasing_inflation
from sigmatau.quality.spectrum.aliasing import aliasing


def stream_of(y, rate):
    return st.Record.from_arrays(rate=rate, gyro_x=y).streams[0]


@pytest.mark.parametrize(("rate", "severity"), [(10.0, "warning"), (100.0, "warning"), (500.0, "info")])
def test_stated(rate, severity):
    stream = stream_of(np.random.default_rng(known.seed_of("stated")).standard_normal(1000), rate)
    (finding,) = aliasing(stream, (30.0, None))
    first, second = (aliasing_inflation(rate=rate, bandwidth=30.0, order=order) for order in (1, 2))
    assert finding.severity == severity
    assert finding.channels == ("gyro_x",)
    assert dict(finding.factors)["random_walk"] == first
    assert finding.details.second_order == second
    (finding,) = aliasing(stream, (30.0, 2))
    assert dict(finding.factors)["random_walk"] == second
    assert finding.severity == ("warning" if second > 1.05 else "info")


def test_remedy_is_a_rate_that_helps():
    stream = stream_of(np.arange(100.0), 50.0)
    (finding,) = aliasing(stream, (30.0, 1))
    rate = finding.details.rate_needed
    assert aliasing_inflation(rate=rate, bandwidth=30.0) == pytest.approx(1.02, abs=1e-3)


@pytest.mark.parametrize("wrong", [(0.0, None), (math.nan, 1), (30.0, 0), (30.0, 9), (1e9, 1)])
def test_wrong_bandwidth(wrong):
    with pytest.raises(OptionError, match=r"bandwidth|order"):
        aliasing(stream_of(np.arange(100.0), 50.0), wrong)
