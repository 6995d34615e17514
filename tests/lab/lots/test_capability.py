"""Yield and capability: known answers and coverage."""

import math

import numpy as np
import pytest

from known import seed_of
from sigmatau.lab.lots.capability import estimate_capability, estimate_yield


def test_known_answers():
    """Wilson's interval of 8 of 10 is 0.490 to 0.943. A mean 0.6 below the maximum is six standard deviations of 0.1."""
    share = estimate_yield(8, 10)
    assert (share.value, round(share.low, 3), round(share.high, 3)) == (0.8, 0.490, 0.943)
    assert (estimate_yield(0, 10).low, estimate_yield(10, 10).high) == (0.0, 1.0)
    logs = np.tile([-1.0, 1.0], 10)
    logs *= 0.1 / np.std(logs, ddof=1)
    assert estimate_capability(np.exp(logs), math.exp(0.6)).value == pytest.approx(2.0)


def test_few_or_equal_units_have_no_capability():
    assert estimate_capability(np.arange(1.0, 10.0), 20.0) is None
    assert estimate_capability(np.ones(20), 2.0) is None


@pytest.mark.parametrize("units", [10, 40])
def test_interval_of_the_capability_covers(units):
    """True Cpk: ln 1.6 over three standard deviations of 10 %. The interval is an approximation for few units."""
    rng = np.random.default_rng(seed_of(f"capability of {units}"))
    sets, true = 1000, math.log(1.6) / 0.3
    numbers = [estimate_capability(np.exp(0.1 * rng.standard_normal(units)), 1.6) for _ in range(sets)]
    share = np.mean([number.low <= true <= number.high for number in numbers])
    assert abs(share - 0.95) <= 3 * math.sqrt(0.95 * 0.05 / sets)
