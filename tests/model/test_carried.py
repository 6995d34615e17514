"""What a fit finds is in the model made from it, and the model passes its own verification."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import ChannelModel, NoiseModel, allan, analyze, predict, simulate, verify
from sigmatau.fitting.likelihood import fit_samples
from sigmatau.model.from_result import channel_of_fit
from sigmatau.model.numbers import adev_interval
from sigmatau.model.processes import GaussMarkov, LowPass, Resonance, Sinusoid

N = {"random_walk": 8.7e-5}


def _fitted(truth, name, *, duration):
    record = simulate(NoiseModel(channels={"gyro_z": truth}), duration=duration, rate=100, rng=seed_of(name))
    fitted = fit_samples(record.streams[0], "gyro_z")
    model = channel_of_fit(fitted.to_dict(), quantity="angular_rate", unit="rad/s", duration=duration, rate=100.0)
    return fitted, model, allan(record)["gyro_z"]


def test_a_resonance_is_carried():
    truth = ChannelModel(terms=N, resonance=(Resonance(sigma=6e-5, frequency=0.02, width=0.004),))
    fitted, model, curve = _fitted(truth, "carried resonance", duration=7200)
    assert len(fitted.resonance) == len(model.resonance) == 1
    found = fitted.resonance[0]
    assert found.frequency.low <= 0.02 <= found.frequency.high
    assert {"resonance_1.sigma", "resonance_1.frequency", "resonance_1.width"} <= set(model.covariance[0])
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
    assert {"gauss_markov_1.sigma", "gauss_markov_1.time"} <= set(model.covariance[0])
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


def test_the_errors_of_processes_are_those_of_the_processes_of_the_model():
    """A resonance of the least width is a line of the fit: the errors of the others keep their places."""
    truth = ChannelModel(
        terms=N,
        sinusoid=(Sinusoid(amplitude=1e-4, frequency=0.004),),
        resonance=(Resonance(sigma=6e-5, frequency=0.02, width=0.004),),
    )
    fitted, model, _ = _fitted(truth, "carried resonance beside a slow line", duration=7200)
    assert len(fitted.sinusoid) == len(fitted.resonance) == 1
    names, covariance = model.covariance
    assert [name for name in names if name.startswith("resonance")] == [
        f"resonance_1.{number}" for number in ("sigma", "frequency", "width")
    ]
    error = np.sqrt(covariance[names.index("resonance_1.frequency"), names.index("resonance_1.frequency")])
    found = fitted.resonance[0].frequency
    assert error == pytest.approx((found.high - found.low) / 3.92, rel=0.5)  # the interval is one of the profile
