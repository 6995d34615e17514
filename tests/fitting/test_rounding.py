"""Allowance for rounding: the law of rounded normal noise, and intervals that hold for any mean."""

import math
from functools import partial

import numpy as np
import pytest
from scipy.signal import lfilter

from known import seed_of
from sigmatau import ChannelModel, GaussMarkov, NoiseModel, Record, analyze, simulate
from sigmatau.fitting.adjust import adjusted
from sigmatau.fitting.channel import fit_channel
from sigmatau.fitting.rounding import Rounding, rounding_adjustment

N = 2**15


@pytest.mark.parametrize("sigma", [0.2, 0.3, 0.4, 0.5, 0.8])
def test_noise_before_rounding_is_between_its_bounds(sigma):
    """The two bounds are the means at a level and halfway between two; the log of another mean is between its factors."""
    rng = np.random.default_rng(seed_of(f"bounds {sigma}"))
    x = sigma * rng.standard_normal(200_000)
    seen = {phase: float(np.round(x + phase).std()) for phase in (0.0, 0.25, 0.5)}
    for phase, one in seen.items():
        rounding = Rounding(one)
        assert rounding.smallest <= sigma * 1.02, phase
        assert rounding.largest >= sigma * 0.98, phase
        low, high = rounding.white
        assert low * 0.98 <= min(seen.values()) / one <= max(seen.values()) / one <= high * 1.02, phase
    assert Rounding(seen[0.0]).largest == pytest.approx(sigma, rel=0.02)
    if sigma >= 0.3:
        assert Rounding(seen[0.5]).smallest == pytest.approx(sigma, rel=0.05)


def test_slow_changes_through_the_rounding():
    """The mean of rounded noise differs from its own by the stated error at most, in slope by twice the dither."""
    rng = np.random.default_rng(seed_of("slow"))
    sigma, means = 0.4, np.linspace(0, 1, 21)
    x = sigma * rng.standard_normal(400_000)
    off = np.array([np.round(x + mean).mean() - x.mean() - mean for mean in means])
    rounding = Rounding(float(np.round(x + 0.5).std()))  # the mean at which the bound is the noise itself
    chance = 0.5 / math.sqrt(len(x))
    assert np.abs(off).max() == pytest.approx(rounding.slow_error, abs=4 * chance)
    assert np.abs(np.gradient(off, means)).max() == pytest.approx(2 * rounding.dither, rel=0.1)


@pytest.mark.parametrize("ratio", [0.15, 0.3, 0.4, 0.7])
def test_no_value_without_an_interval(ratio):
    """White noise of `ratio` steps: the random walk of the log at any mean is inside, also below half a step."""
    rng = np.random.default_rng(seed_of(f"coarse {ratio}"))
    y = np.round(ratio * rng.standard_normal(N) + 0.45)
    fitted = analyze(Record.from_arrays(rate=100, gyro_x=y)).fits["gyro_x"]
    walk = fitted["random_walk"]
    low, high = (walk.low, walk.high) if walk.observed else (0.0, walk.upper_limit)
    assert low <= 0.1 * math.sqrt(ratio**2 + 1 / 12) <= high
    assert walk.observed == (low > 0) == (ratio >= 0.4)  # a mean at a level shows nothing of less noise
    for name in ("bias_instability", "rate_random_walk"):
        assert fitted[name].high is not None or fitted[name].upper_limit is not None, name
    assert (fitted.verdict == "widened") == (ratio < 0.5)
    if ratio > 0.5:
        assert walk.low <= 0.1 * ratio  # the interval holds the sensor's too
        assert walk.high / walk.low < 1.1 * math.sqrt(1 + 1 / (12 * ratio**2))


def test_the_numbers_of_a_process_get_wider_too():
    """In the covariance that a model takes over, as in the intervals."""
    process = GaussMarkov(sigma=0.6, time=10.0)
    model = NoiseModel(channels={"gyro_x": ChannelModel(terms={"random_walk": 0.04}, gauss_markov=(process,))})
    x = simulate(model, duration=N / 100, rate=100.0, rng=seed_of("coarse process")).streams[0].column("gyro_x")
    fitted = fit_channel(Record.from_arrays(rate=100, gyro_x=np.asarray(x)), "gyro_x")
    names, before = fitted.covariance.names, fitted.covariance.matrix
    k = names.index("gauss_markov_1.sigma")
    after = adjusted(fitted, partial(rounding_adjustment, step=1.0, noise=0.45))
    assert after.covariance.names == names
    wider = after.gauss_markov[0].sigma.high - after.gauss_markov[0].sigma.low
    width = fitted.gauss_markov[0].sigma.high - fitted.gauss_markov[0].sigma.low
    assert wider > width
    assert after.covariance.matrix[k, k] == pytest.approx(before[k, k] * (wider / width) ** 2)


def test_a_process_beside_the_rounding():
    """Coarse samples with a Gauss-Markov process: the covariance of its numbers is kept."""
    rng = np.random.default_rng(seed_of("coarse process"))
    process = np.empty(2 * N)
    decay, state = math.exp(-1 / 200), 0.0
    for k, step in enumerate(rng.standard_normal(2 * N)):
        state = decay * state + math.sqrt(1 - decay**2) * step
        process[k] = 0.8 * state
    y = np.round(process + 0.8 * rng.standard_normal(2 * N) + 0.3)
    fitted = analyze(Record.from_arrays(rate=100, gyro_x=y), at_rest=True).fits["gyro_x"]
    assert "gauss_markov_1.sigma" in fitted.covariance.names
    assert fitted.gauss_markov[0].sigma.low <= 0.8 <= fitted.gauss_markov[0].sigma.high


def test_coarse_values_with_a_resonance():
    """The covariance holds the numbers of processes beside the terms; each has the factor of its own interval."""
    rng, decay = np.random.default_rng(seed_of("coarse resonance")), math.exp(-math.pi * 2 / 100)
    ringing = lfilter([1], [1, -2 * decay * math.cos(2 * math.pi * 10 / 100), decay**2], rng.standard_normal(20_000))
    x = np.round(0.2 * ringing / ringing.std() + 0.25 * rng.standard_normal(20_000) + 0.3)
    fitted = analyze(Record.from_arrays(rate=100, gyro_x=x)).fits["gyro_x"]
    names, covariance = fitted.covariance.names, fitted.covariance.matrix
    assert fitted.verdict == "widened"
    assert "resonance_1.sigma" in names
    assert np.isfinite(covariance).all()


def test_no_noise_that_is_seen():
    """A mean at a level hides less noise than a step: the limit is the noise of a mean halfway between two."""
    y = np.zeros(3000)
    y[::50] = 1.0
    fitted = fit_channel(Record.from_arrays(rate=100, gyro_x=y), "gyro_x")
    walk, before = (
        adjusted(fitted, partial(rounding_adjustment, step=1.0, noise=0.0))["random_walk"],
        fitted["random_walk"],
    )
    assert not walk.observed
    assert walk.upper_limit == pytest.approx((before.high or before.upper_limit) + 0.05, rel=1e-9)
