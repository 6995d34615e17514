"""Resonances in a noise model: every form of the same noise agrees."""

import re
import tomllib

import numpy as np
import pytest

from known import seed_of
from sigmatau import ChannelModel, DataError, NoiseModel, allan, arma, predict, simulate, state_space
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import prepare
from sigmatau.model.processes import GaussMarkov, LowPass, Resonance
from sigmatau.model.transform import integrate_density

TAU0 = 0.01
SIZES = np.array([1, 2, 7, 40, 300, 5000])
SHAPES = [(2.0, 0.3), (0.004, 0.001), (0.56, 0.002), (70.0, 9.0)]  # the last is folded


@pytest.mark.parametrize(("frequency", "width"), SHAPES)
def test_every_form_is_the_same_noise(frequency, width):
    one = Resonance(sigma=1e-3, frequency=frequency, width=width)
    model = ChannelModel(resonance=(one,))
    system = state_space(model, dt=TAU0)
    expected = model.avar(m=SIZES, tau0=TAU0)
    # The sums of the closed form lose (f·τ0)⁻² of their digits.
    lost = 1e-15 / (2 * np.pi * min(frequency * TAU0, 1.0)) ** 2
    np.testing.assert_allclose(system.avar(SIZES), expected, rtol=1e-8 + 100 * lost)
    lags = np.arange(50)
    covariance = model.autocovariance(lags, tau0=TAU0)
    powers = [(system.H @ np.linalg.matrix_power(system.F, k) @ system.P0 @ system.H.T)[0, 0] for k in lags]
    np.testing.assert_allclose(covariance, powers, atol=1e-12 * covariance[0])
    assert covariance[0] == pytest.approx(1e-6, rel=1e-12)  # its own standard deviation
    f = np.geomspace(1e-3, 49.9, 40)
    np.testing.assert_allclose(arma(model, dt=TAU0).psd(f), model.psd(f, tau0=TAU0), rtol=1e-6)


def test_the_density_has_the_allan_variance_and_the_samples_have_both():
    model = ChannelModel(resonance=(Resonance(sigma=1e-3, frequency=2.0, width=0.3),))
    by_density = integrate_density(lambda f: model.psd(f, tau0=TAU0), SIZES * TAU0, tau0=TAU0)
    np.testing.assert_allclose(by_density, model.avar(m=SIZES, tau0=TAU0), rtol=1e-9)
    f = np.array([0.1, 1.0, 2.0, 4.0])
    many = model.psd(f, tau0=1e-4)  # sampled so fast that nothing of note is folded
    np.testing.assert_allclose(many, model.psd(f), rtol=2e-2)
    whole = NoiseModel(channels={"gyro_x": model})
    record = simulate(whole, duration=2000, rate=100, rng=seed_of("simulated resonance"))
    y = record.streams[0].column("gyro_x")
    # The variance of a record of length T has the relative standard error √(1/(γT)), of both quadratures.
    assert y.var() == pytest.approx(1e-6, rel=4 / np.sqrt(2 * np.pi * 0.3 * 2000))
    measured = allan(record)["gyro_x"].at(np.array([1, 8, 32, 64]))
    np.testing.assert_allclose(
        measured.avar, model.avar(m=measured.m, tau0=TAU0), rtol=4 / np.sqrt(2 * np.pi * 0.3 * 2000)
    )


def test_a_file_keeps_resonances_alike_walks_and_the_rate_of_a_bandwidth():
    model = NoiseModel(
        channels={
            "gyro_x": ChannelModel(
                terms={"random_walk": 1e-4, "rate_random_walk": 1e-7},
                resonance=(Resonance(sigma=1e-5, frequency=0.004, width=0.001),),
                alike_from=GaussMarkov(sigma=3e-6, time=1800.0),
                bandwidth=LowPass(order=2, corner=31.0, rate=100.0),
            )
        }
    )
    text = model.to_toml()
    assert NoiseModel.from_dict(tomllib.loads(text)) == model
    assert "of 30 min or more explains the rate random walk as well" in text
    with pytest.raises(DataError, match=r"resonance lacks frequency and width; write \{ sigma = .*width"):
        NoiseModel.from_dict({"channels": {"gyro_x": {"resonance": [{"sigma": "1 deg/h"}]}}})
    with pytest.raises(DataError, match="half width of a resonance must be less"):
        Resonance(sigma=1.0, frequency=0.1, width=0.1)
    with pytest.raises(DataError, match="there is no rate_random_walk"):
        ChannelModel(terms={"random_walk": 1e-4}, alike_from=GaussMarkov(sigma=1.0, time=1.0))


def test_a_random_walk_measured_behind_a_filter_is_that_of_the_samples():
    """At long times the variance is N²/τ of the samples, with what was folded; before the sampler it is less."""
    low_pass = LowPass(order=1, corner=30.0, rate=100.0)
    model = ChannelModel(terms={"random_walk": 1e-4}, bandwidth=low_pass)
    m = np.array([100_000])
    assert model.avar(m=m, tau0=0.01)[0] == pytest.approx(1e-8 / 1000, rel=1e-4)
    assert low_pass.before_sampling(1e-4) == pytest.approx(1e-4 / 1.131, rel=1e-3)  # Fig. 12 of the paper
    assert model.psd([1e-4], tau0=0.01)[0] == pytest.approx(1e-8, rel=1e-6)
    assert state_space(model, dt=0.01).avar(m)[0] == pytest.approx(1e-8 / 1000, rel=1e-4)
    assert arma(model, dt=0.01).psd([1e-4])[0] == pytest.approx(1e-8, rel=1e-6)


def test_both_explanations_of_a_walk_are_carried():
    walk = {"random_walk": 1e-5, "rate_random_walk": 1e-7}
    alike = GaussMarkov(sigma=3e-6, time=1800.0)
    channel = ChannelModel(terms=walk, alike_from=alike, limits={"bias_instability": 1e-7}, rate=100.0)
    both = NoiseModel(channels={"gyro_z": channel})
    found = predict(both, after=[600, 7200], rate=100)["heading"]
    process = ChannelModel(terms={"random_walk": 1e-5}, gauss_markov=(alike,))
    for other in (ChannelModel(terms=walk), process):
        rms = predict(NoiseModel(channels={"gyro_z": other}), after=[600, 7200], rate=100)["heading"].rms
        assert (found.low <= rms).all()
        assert (rms <= found.high).all()
    assert (found.high <= found.at_most).all()
    np.testing.assert_allclose(
        found.rms, predict(NoiseModel(channels={"gyro_z": walk}), after=[600, 7200], rate=100)["heading"].rms
    )
    assert "the interval includes both" in repr(predict(both, after=[600], rate=100))
    system = state_space(channel, dt=0.01)
    assert system.states == ("bias",)
    assert system.alike_from == 1800.0
    assert "of 30 min or more explains" in repr(system)
    content = prepare(both, to="state-space").content
    assert content.count("of 30 min or more explains") == 1


def test_a_walk_takes_resonances_in():
    """A consistent walk is larger by the resonance, and every explanation is stated."""
    one = ChannelModel(
        terms={"random_walk": 1e-4, "rate_random_walk": 1e-6},
        resonance=(Resonance(sigma=1e-5, frequency=0.004, width=0.001),),
        alike_from=GaussMarkov(sigma=3e-5, time=1800.0),
        rate=100.0,
    )
    accel = ChannelModel(
        terms={"random_walk": 1e-3, "rate_random_walk": 1e-4}, quantity="acceleration", unit="m/s^2", rate=100.0
    )
    model = NoiseModel(channels={"gyro_x": one, "accel_x": accel})
    text = prepare(model, to="kalibr").content
    (walk,) = re.findall(r"^gyroscope_random_walk: (\S+)", text, flags=re.MULTILINE)
    assert float(walk) > 1.01e-6
    observed = prepare(model, to="kalibr", choices=Choices(walk={"gyro": "observed", "accel": "observed"})).content
    assert "gyroscope_random_walk: 1.0e-06" in observed
    assert observed.count("explains the rate random walk as well") == 1
    assert "resonance_1_2" in prepare(model, to="state-space").content
    assert "its half width" in prepare(model, to="ieee952").content
