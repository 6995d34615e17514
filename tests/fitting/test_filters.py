"""Filters of known shape: the random walk is the level at low frequencies, whatever the order, corner and length."""

import math

import numpy as np
import pytest

from known import seed_of
from sigmatau import ChannelModel, GaussMarkov, NoiseModel, Record, fit_channel, simulate

N = 1e-4
COUNT = 2


def butterworth(order, corner):
    """|H|² of a filter by the bilinear transform; frequencies are times the sample interval."""
    return lambda x: 1 / (1 + (np.tan(np.pi * x) / np.tan(np.pi * corner)) ** (2 * order))


def two_poles(corner, damping):
    def power(x):
        u = (np.tan(np.pi * x) / np.tan(np.pi * corner)) ** 2
        return 1 / ((1 - u) ** 2 + 4 * damping**2 * u)

    return power


def smoothing(share):
    """y += share · (x − y)."""
    p = 1 - share
    return lambda x: (1 - p) ** 2 / (1 - 2 * p * np.cos(2 * np.pi * x) + p**2)


def means(length, stages):
    def power(x):
        x = np.maximum(x, 1e-9)
        return (np.sin(np.pi * length * x) / (length * np.sin(np.pi * x))) ** (2 * stages)

    return power


def filtered(power, n, rate, rng):
    """White noise behind a filter, from a circle that is longer than the record."""
    size = 1 << int(np.ceil(np.log2(1.2 * n)))
    white = np.fft.rfft(rng.standard_normal(size)) * N * math.sqrt(rate)
    x = np.minimum(np.arange(white.size) / size, 0.5 - 1e-9)
    return np.fft.irfft(white * np.sqrt(power(x)), size)[:n]


def fits(name, power, *, seconds, rate, flicker=0.0):
    rng = np.random.default_rng(seed_of(f"filters, {name}"))
    n = round(seconds * rate)
    for _ in range(COUNT):
        samples = filtered(power, n, rate, rng)
        if flicker:
            behind = NoiseModel(channels={"gyro_x": ChannelModel(terms={"bias_instability": flicker})})
            samples = samples + simulate(behind, duration=seconds, rate=rate, rng=rng).streams[0].column("gyro_x")
        log = Record.from_arrays(rate=rate, gyro_x=samples, unit={"gyro_x": "rad/s"})
        yield fit_channel(log, "gyro_x")


CASES = {
    "first order, 0.003 of the rate": (butterworth(1, 0.003), {"seconds": 3600, "rate": 100.0}),
    "first order, 0.01 of the rate, flicker behind": (
        smoothing(0.0609),
        {"seconds": 3600, "rate": 50.0, "flicker": 5e-5},
    ),
    "second order, 0.01 of the rate, flicker behind": (
        butterworth(2, 0.01),
        {"seconds": 3600, "rate": 50.0, "flicker": 5e-5},
    ),
    "second order, 0.4 of the rate": (butterworth(2, 0.4), {"seconds": 600, "rate": 100.0}),
    "third order, 0.1 of the rate, 1 kHz": (butterworth(3, 0.1), {"seconds": 600, "rate": 1000.0}),
    "fourth order, 0.05 of the rate": (butterworth(4, 0.05), {"seconds": 1800, "rate": 100.0}),
    "sixth order, 0.02 of the rate, 10 Hz": (butterworth(6, 0.02), {"seconds": 7200, "rate": 10.0}),
    "little damping": (two_poles(0.05, 0.35), {"seconds": 1800, "rate": 100.0}),
    "much damping": (two_poles(0.05, 1.5), {"seconds": 1800, "rate": 100.0}),
    "three means of 8": (means(8, 3), {"seconds": 1800, "rate": 100.0}),
    "mean of 100, flicker behind": (means(100, 1), {"seconds": 3600, "rate": 50.0, "flicker": 5e-5}),
}


@pytest.mark.parametrize("name", CASES)
def test_the_level_at_low_frequencies_is_in_its_interval(name):
    power, options = CASES[name]
    covered = 0
    for fit in fits(name, power, **options):
        walk = fit["random_walk"]
        assert walk.observed
        half = (walk.high - walk.low) / 2
        assert fit.trust != "good" or abs(walk.value - N) < 3 * half
        covered += walk.low <= N <= walk.high
    # 95 %, less three standard errors of as many records.
    assert covered >= COUNT * 0.95 - 3 * math.sqrt(COUNT * 0.95 * 0.05), f"{covered} of {COUNT}"


def test_shapes_have_their_numbers():
    """A corner in its interval, and the order, or the damping, of the filter that is there."""
    fit = next(fits("second order", butterworth(2, 0.05), seconds=1800, rate=100.0))
    assert (fit.response.shape, fit.response.order) == ("butterworth", 2)
    assert fit.response.low < 5.0 < fit.response.high
    fit = next(fits("damped", two_poles(0.05, 0.35), seconds=1800, rate=100.0))
    assert fit.response.shape == "two_poles"
    assert fit.response.damping == pytest.approx(0.35, rel=0.1)
    fit = next(fits("means", means(16, 2), seconds=1800, rate=100.0))
    # Their number shows beyond the first zero, which is not used.
    assert fit.response.shape == "running_means"
    # sin⁴(πx)/(πx)⁴ is a half at 0.319.
    assert fit.response.corner == pytest.approx(0.319 / 16 * 100, rel=0.05)


def test_white_noise_beside_a_process_of_a_second_is_what_it_is():
    """White noise behind a filter has the same spectrum if something white is behind the filter: that is stated."""
    process = GaussMarkov(sigma=N * math.sqrt(30 / 2), time=1.0)
    model = NoiseModel(channels={"gyro_x": ChannelModel(terms={"random_walk": N}, gauss_markov=(process,))})
    rng = np.random.default_rng(seed_of("filters, a process of a second"))
    covered = 0
    for _ in range(COUNT):
        fit = fit_channel(simulate(model, duration=3600, rate=50.0, rng=rng), "gyro_x")
        walk = fit["random_walk"]
        covered += walk.low <= N <= walk.high
        assert walk.value == pytest.approx(N, rel=0.05)
        assert walk.high > N * math.sqrt(25)
        second = next(second for second in fit.second if second.filter is not None)
        assert second.filter == pytest.approx(1 / (2 * math.pi), rel=0.3)
        assert second.terms["random_walk"] == pytest.approx(N * math.sqrt(31), rel=0.15)
        assert fit.highest is None
    assert covered >= COUNT * 0.95 - 3 * math.sqrt(COUNT * 0.95 * 0.05)
