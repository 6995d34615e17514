"""Biases that findings state: the interval of the random walk holds that of the sensor, and "good" means within 5 %."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import Record, analyze

RATE, N, RUNS = 200.0, 30_000, 4
WALK = 1 / np.sqrt(RATE)  # of white noise of 1


def _rounded(noise, steps):
    return np.round(noise * steps) / steps


def _held(noise, times):
    return noise[np.floor(np.arange(len(noise)) / times).astype(int)]


def _clipped(noise, end):
    return np.clip(noise, -end, end)


def _repeated(noise, every):
    """Rows that are in the log twice, at places without an order."""
    places = np.sort(np.random.default_rng(7).choice(len(noise), len(noise) // every, replace=False))
    return np.repeat(noise, np.bincount(places, minlength=len(noise)) + 1)[: len(noise)]


CASES = {
    **{f"rounding to 1/{steps}": (_rounded, steps, 1.0) for steps in (0.6, 0.8, 1.0, 1.2, 1.5, 2.5)},
    "held 1.37 times": (_held, 1.37, 1.37**0.5),  # of a sensor whose rate is lower by this
    "held 1.6 times": (_held, 1.6, 1.6**0.5),
    "clipped at 1.5": (_clipped, 1.5, 1.0),
}


def _walks(name):
    change, size, factor = CASES[name]
    for run in range(RUNS):
        noise = np.random.default_rng(seed_of(f"{name} {run}")).standard_normal(N) * 1e-3
        found = analyze(Record.from_arrays(rate=RATE, gyro_x=1e-3 * change(1e3 * noise, size)))
        yield found.fits["gyro_x"], 1e-3 * WALK * factor


@pytest.mark.parametrize("name", CASES)
def test_interval_holds_the_walk_of_the_sensor(name):
    for fitted, truth in _walks(name):
        walk = fitted["random_walk"]
        low, high = (walk.low, walk.high) if walk.observed else (0.0, walk.upper_limit)
        assert low * 0.995 <= truth <= high * 1.005, (truth, low, walk.value, high)  # of a 95 % interval of 1.5 %
        assert fitted.trust != "good" or 0.94 < truth / walk.value < 1.06


def test_fine_steps_change_nothing():
    """Without a factor, the interval is that of the fit."""
    noise = 1e-3 * np.random.default_rng(seed_of("fine steps")).standard_normal(N)
    fine = analyze(Record.from_arrays(rate=RATE, gyro_x=_rounded(noise, 1e6))).fits["gyro_x"]["random_walk"]
    bare = analyze(Record.from_arrays(rate=RATE, gyro_x=noise)).fits["gyro_x"]["random_walk"]
    assert (fine.low, fine.high) == pytest.approx((bare.low, bare.high), rel=1e-3)


def test_bandwidth():
    """The factor of aliasing is in the interval, and in the covariance of a model."""
    noise = 1e-3 * np.random.default_rng(seed_of("bandwidth")).standard_normal(N)
    record = Record.from_arrays(rate=RATE, gyro_x=noise)
    bare, wide = (analyze(record, bandwidth=one).fits["gyro_x"] for one in (None, {"gyro": (120.0, None)}))
    (before, _), (after, _) = ((fitted["random_walk"], fitted.covariance) for fitted in (bare, wide))
    assert after.value == before.value
    assert after.high == before.high
    assert after.low < 0.9 * before.low
    names, matrix = wide.covariance.names, wide.covariance.matrix
    k = names.index("random_walk")
    width = (after.high - after.low) / (before.high - before.low)
    assert matrix[k, k] == pytest.approx(bare.covariance.matrix[k, k] * width**2)
