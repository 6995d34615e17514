"""A fit of the spectrum ends at half the rate; a sampled resonance folds what is beyond it."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, Record, allan, analyze, simulate
from sigmatau.fitting.noise_fit import Interval, WarmUp
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import Resonance
from sigmatau.noise.resonance import folded_level, folds, resonance_avar, resonance_psd, unfolded_avar

TAU0 = 0.01
WIDE, SLOW = (1.0, 31.0, 7.7), (1.0, 1.5, 0.2)  # σ, centre, half width


@pytest.mark.parametrize("shape", [WIDE, (1.0, 9.2, 0.3), (1.0, 2.5, 0.5)])
def test_it_is_the_integral_of_the_density(shape):
    """σ²(τ) = 4 ∫ S sin⁴(πfmτ₀)/(m sin πfτ₀)² df up to half the rate."""
    m = np.array([1, 4, 12, 96])
    f = (np.arange(400_000) + 0.5) / 400_000 * 0.5 / TAU0
    density = resonance_psd(*shape, f)
    expected = [
        4 * np.mean(density * np.sin(np.pi * f * k * TAU0) ** 4 / (k * np.sin(np.pi * f * TAU0)) ** 2) * 0.5 / TAU0
        for k in m
    ]
    assert unfolded_avar(*shape, m, TAU0) == pytest.approx(expected, rel=1e-3)


def test_what_is_folded_is_white():
    """At long averaging times the sampled resonance has the Allan variance of white noise of this density."""
    m = np.array([1000, 10_000])
    assert resonance_avar(*WIDE, m, TAU0) == pytest.approx(folded_level(*WIDE, TAU0) / (m * TAU0), rel=0.02)
    assert folded_level(*SLOW, TAU0) < 0.03 * folded_level(*WIDE, TAU0)
    assert folds(*WIDE, TAU0, random_walk=0.1)
    assert not folds(*SLOW, TAU0, random_walk=0.1)


def test_the_model_has_the_curve_of_the_record():
    """A hump near half the rate: fit and model agree with the measured curve from τ_min on."""
    truth = ChannelModel(
        terms={"random_walk": 1e-3},
        resonance=(Resonance(sigma=0.012, frequency=31.0, width=5.0),),
        quantity="angular_rate",
        unit="rad/s",
    )
    record = simulate(NoiseModel(channels={"gyro_x": truth}), duration=3600, rate=100, rng=seed_of("folded resonance"))
    analysis = analyze(record)
    fit, curve = analysis.fits["gyro_x"], analysis.curves["gyro_x"]
    there = (curve.m * TAU0 >= fit.tau_min) & (curve.m < curve.n // 50)
    model = NoiseModel.from_result(analysis).channels["gyro_x"]
    for avar in (fit.avar(m=curve.m), model.avar(m=curve.m, tau0=TAU0)):
        assert np.sqrt(avar[there]) / curve.adev[there] == pytest.approx(1, abs=0.12)
    assert fit.tau_min < 10


def test_a_warm_up_is_in_the_curve_of_the_fit():
    n, time, size = 200_000, 150.0, 0.05
    t = np.arange(n) * TAU0
    x = size * np.exp(-t / time)
    curve = allan(Record.from_arrays(rate=100, gyro_x=x, unit={"gyro": "rad/s"}))["gyro_x"]
    warm_up = WarmUp(amplitude=Interval(value=size, low=size, high=size, unit="rad/s"), time=time)
    got = warm_up.avar(curve.m * TAU0, duration=n * TAU0)
    long = curve.m >= 10
    assert np.sqrt(got[long]) == pytest.approx(curve.adev[long], rel=0.01)
