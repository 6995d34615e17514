"""The white level and the Allan variance by octaves that the effects are stated with."""

import math

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, Record, allan, simulate
from sigmatau.estimators.octaves import octaves
from sigmatau.quality.samples.common import block_rms, take_samples, white_level

N = 1 << 17


def white(name, n=N):
    return np.random.default_rng(seed_of(name)).normal(size=n)


def test_octaves_are_those_of_clusters_that_share_no_sample():
    x = white("octaves", 4096)
    found = list(octaves(x))
    curve = allan(Record.from_arrays(rate=1, signal=x), taus=[float(m) for m, _, _ in found], overlap="none")["signal"]
    assert [m for m, _, _ in found] == [1, 2, 4, 8, 16, 32, 64, 128, 256]
    assert [avar for _, avar, _ in found] == pytest.approx(curve.avar.tolist(), rel=1e-12)


def test_clusters_with_gaps_are_means_of_what_is_there():
    """White noise over a level far from the first sample: variance E(1/m₁), a little more than 1/m."""
    x = white("gaps")
    x[0] = 50.0
    x[np.random.default_rng(seed_of("lost")).random(N) < 0.2] = np.nan
    for m, avar, pairs in octaves(x):
        if m >= 8 and pairs > 1000:
            # m₁ is binomial: E(1/m₁) = 1/(0.8 m)·(1 + 0.25/m + …).
            assert avar == pytest.approx(1 / (0.8 * m) * (1 + 0.25 / m), rel=3 * math.sqrt(3 / pairs) + 0.25 / m)


@pytest.mark.parametrize("other", ["quantization", "bias_instability", "rate_random_walk"])
def test_the_white_level_is_that_of_the_white_noise(other):
    """Whatever dominates short or long times: N² to three standard errors of the variance that it is taken from."""
    n = 0.01
    value = {"quantization": 0.001, "bias_instability": 0.002, "rate_random_walk": 5e-4}[other]
    model = NoiseModel(channels={"gyro_x": {"random_walk": n, other: value}})
    x = simulate(model, duration=N / 100, rate=100, rng=seed_of(other) % 2**60).streams[0].column("gyro_x")
    level, m = white_level(x, 0.01)
    assert level == pytest.approx(n**2, rel=3 * math.sqrt(3 * m / N) + 0.03)  # and 3 % of the other term
    assert (m > 16) == (other == "quantization")


def test_scale_is_not_moved_by_a_few_large_values():
    x = white("scale")
    x[::1000] = 1e6
    # Blocks of 32 with 32 degrees of freedom: the middle half is 2/(9·32) low in power, and one block in 31 is spoilt.
    assert block_rms(x) == pytest.approx(1.0, abs=0.01)
    assert block_rms(np.where(np.arange(N) % 5, x, np.nan)) > 0
    assert block_rms(np.zeros(0)) == 0


def test_samples_of_a_long_record_are_spread_over_it():
    stream = Record.from_arrays(rate=1, signal=np.arange(1e6)).streams[0]
    x = take_samples(stream, "signal", count=3200)
    assert (len(x), x[0], x[-1]) == (3200, 0.0, 999_999.0)
    assert np.count_nonzero(np.diff(x) != 1) == 31
