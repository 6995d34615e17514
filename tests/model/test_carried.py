"""What a fit finds is in the model made from it, and the model passes its own verification."""

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from known import seed_of
from sigmatau import ChannelModel, NoiseModel, OptionError, Record, allan, analyze, predict, simulate, verify
from sigmatau.fitting.channel import fit_channel
from sigmatau.fitting.likelihood import fit_samples
from sigmatau.model.numbers import adev_interval
from sigmatau.model.processes import GaussMarkov, LowPass, Resonance

N = {"random_walk": 8.7e-5}


def _fitted(truth, name, *, duration):
    record = simulate(NoiseModel(channels={"gyro_z": truth}), duration=duration, rate=100, rng=seed_of(name))
    fitted = fit_samples(record.streams[0], "gyro_z")
    model = fitted.to_model()
    return fitted, model, allan(record)["gyro_z"]


def test_a_resonance_is_carried():
    truth = ChannelModel(terms=N, resonance=(Resonance(sigma=6e-5, frequency=0.02, width=0.004),))
    fitted, model, curve = _fitted(truth, "carried resonance", duration=7200)
    assert len(fitted.resonance) == len(model.resonance) == 1
    found = fitted.resonance[0]
    assert found.frequency.low <= 0.02 <= found.frequency.high
    assert {"resonance_1.sigma", "resonance_1.frequency", "resonance_1.width"} <= set(model.covariance.names)
    np.testing.assert_allclose(model.avar(m=curve.m, tau0=0.01), fitted.avar(m=curve.m), rtol=1e-9)
    assert verify(model, curve).p_value > 0.002


@pytest.mark.parametrize(("order", "corner"), [(2, 20.0), (1, 8.0)])
def test_a_named_filter_is_carried(order, corner):
    """With the bandwidth the model holds from shorter times, and its N is that of the fit."""
    truth = ChannelModel(terms=N, bandwidth=LowPass(order=order, corner=corner))
    fitted, model, curve = _fitted(truth, f"carried filter {order}", duration=3600)
    assert model.bandwidth is not None
    assert model.bandwidth.order == order
    assert model.bandwidth.corner == pytest.approx(corner, rel=0.05)
    assert model["random_walk"] == fitted.model["random_walk"]
    long = curve.m[curve.m * 0.01 >= model.tau_min]
    np.testing.assert_allclose(model.avar(m=long, tau0=0.01), fitted.avar(m=long), rtol=0.02)
    assert model.tau_min < 0.5
    assert verify(model, curve).p_value > 0.002


def test_a_process_has_an_interval_in_the_prediction():
    """20 deg/h over 100 s in 3 h: the heading is wrong by 1.76 degrees after 10 min."""
    deg_h = np.pi / 180 / 3600
    truth = ChannelModel(terms=N, gauss_markov=(GaussMarkov(sigma=20 * deg_h, time=100.0),))
    record = simulate(NoiseModel(channels={"gyro_z": truth}), duration=10800, rate=100, rng=seed_of("carried process"))
    found = analyze(record)
    model = found.model["gyro_z"]
    assert {"gauss_markov_1.sigma", "gauss_markov_1.time"} <= set(model.covariance.names)
    heading = predict(found.model, after=[600], rate=100)["heading"]
    right = predict(NoiseModel(channels={"gyro_z": truth}), after=[600], rate=100)["heading"].rms
    assert np.rad2deg(right[0]) == pytest.approx(1.76, abs=0.005)
    assert heading.low < right < heading.high
    assert heading.high < 3 * right
    sizes = found.curves["gyro_z"].m[3 * found.curves["gyro_z"].m <= record.streams[0].grid.n]
    low, high = adev_interval(model, m=sizes, tau0=0.01)
    value = model.adev(m=sizes, tau0=0.01)
    assert ((low < value) & (value < high)).all()
    assert verify(model, found.curves["gyro_z"]).p_value > 0.002


def test_a_line_between_modes_and_segments():
    """Bins are wide there: the interval of the frequency is no narrower than they are, and that of N holds it."""
    t = np.arange(60_000) / 100
    for seed, frequency in ((3, 0.4), (1, 1.3), (2, 1.0), (0, 1.5)):
        rng = np.random.default_rng(seed)
        x = 1e-4 * (rng.standard_normal(len(t)) + np.sin(2 * np.pi * frequency * t + 6 * rng.random()))
        fitted = analyze(Record.from_arrays(rate=100, gyro_z=x)).fits["gyro_z"]
        (line,) = fitted.sinusoid
        assert line.frequency.low <= frequency <= line.frequency.high
        walk = fitted["random_walk"]
        assert walk.high - walk.low > 0.005 * walk.value
        assert not any(name.startswith("resonance") for name in fitted.covariance.names)


def test_a_line_behind_a_filter():
    """Its amplitude is that in the log, also where the fit has it as a resonance before the filter."""
    rng = np.random.default_rng(seed_of("line behind a filter"))
    t = np.arange(60_000) / 100
    x = lfilter(*butter(4, 0.1), 1e-4 * rng.standard_normal(len(t))) + 1e-4 * np.sin(60 * np.pi * t)
    fitted = analyze(Record.from_arrays(rate=100, gyro_z=x)).fits["gyro_z"]
    assert fitted.response is not None
    assert max(line.amplitude.value for line in fitted.sinusoid) < 1.2e-4


@pytest.mark.parametrize(
    "options",
    [
        {"terms": ["walk"]},
        {"terms": "random_walk"},
        {"terms": []},
        {"terms": ["rate_ramp"]},
        {"processes": [float("nan")]},
        {"processes": [0.0]},
        {"regressors": {"x": np.arange(5.0)}},
        {"regressors": {"x": np.full(1000, np.nan)}},
        {"regressors": {"x": np.ones(1000)}},
        {"regressors": {"x": np.ones((1000, 2))}},
        {"level": 1.0},
    ],
)
def test_what_a_fit_of_samples_refuses(options):
    record = Record.from_arrays(rate=100, gyro_z=np.random.default_rng(1).standard_normal(1000))
    with pytest.raises(OptionError):
        fit_samples(record.streams[0], "gyro_z", **options)


def test_an_interval_of_an_observed_ramp_excludes_0():
    t = np.arange(60_000) / 100
    ramps = [fit_channel(Record.from_arrays(rate=100, gyro_x=ramp_of(size, t)), "gyro_x") for size in (1e-6, 1e-5)]
    for fitted in ramps:
        ramp = fitted["rate_ramp"]
        assert ramp.observed == (ramp.value is not None)
        assert ramp.value is None or ramp.low * ramp.high > 0
        assert ramp.value is not None or ramp.upper_limit > 0
    assert ramps[1]["rate_ramp"].observed


def ramp_of(size, t):
    return 1e-4 * np.random.default_rng(seed_of("ramp")).standard_normal(len(t)) + size * t


def test_an_alternative_without_white_noise_has_no_filter():
    """Behind a low-pass filter a process may explain all: the band holds both, and nothing is refused."""
    other = ChannelModel(gauss_markov=(GaussMarkov(sigma=2e-4, time=0.5),))
    filtered = ChannelModel(terms={"random_walk": 1e-4}, bandwidth=LowPass(order=1, corner=0.4), alternatives=(other,))
    low, high = adev_interval(filtered, m=[500, 5000], tau0=0.02)
    assert (high >= np.sqrt(other.avar(m=[500, 5000], tau0=0.02))).all()
    assert (low <= np.sqrt(filtered.avar(m=[500, 5000], tau0=0.02))).all()
