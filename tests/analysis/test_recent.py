"""The picture of the last minutes of live samples."""

import numpy as np
import pytest

from known import seed_of
from sigmatau.analysis.recent import RecentSamples


@pytest.mark.parametrize("rate", [0.5, 10, 100, 1000])
@pytest.mark.parametrize("piece", [1, 7, 100_000])
def test_ends_of_the_last_minutes(rate, piece):
    n = min(int(400 * rate) + 3, 20_000 if piece < 100 else 400_003)
    x = np.random.default_rng(seed_of("recent samples")).standard_normal((n, 2))
    recent = RecentSamples(2, rate)
    for start in range(0, n, piece):
        recent.push(x[start : start + piece])
    stop = recent.first + len(recent.low) * recent.width
    assert 0 <= n - stop < recent.width
    assert len(recent.low) <= 1200
    if recent.first:
        assert (stop - recent.first) / rate >= 299
    bins = x[recent.first : stop].reshape(len(recent.low), recent.width, 2)
    assert np.array_equal(recent.low, bins.min(axis=1))
    assert np.array_equal(recent.high, bins.max(axis=1))
