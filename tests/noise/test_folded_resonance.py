"""A fit of the spectrum ends at half the rate; a sampled resonance folds what is beyond it."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, analyze, simulate
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import Resonance

TAU0 = 0.01


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
    model = analysis.model.channels["gyro_x"]
    for avar in (fit.avar(m=curve.m), model.avar(m=curve.m, tau0=TAU0)):
        assert np.sqrt(avar[there]) / curve.adev[there] == pytest.approx(1, abs=0.12)
    assert fit.tau_min < 10
