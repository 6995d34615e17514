"""The typed fit of the compiled core: values, pickling, printing, constants that Python shares."""

import pickle

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, Record, fit_channel, simulate
from sigmatau._native import likelihood as native
from sigmatau._native.likelihood import ChannelFit, summarize
from sigmatau.findings.reasons import MAX_LINES
from sigmatau.fitting.joint_fit import ALPHA
from sigmatau.fitting.noise_fit import NoiseFit


@pytest.fixture(scope="module")
def found():
    """White noise with a rate random walk and a line, behind a filter."""
    rng = np.random.default_rng(seed_of("typed fit"))
    n = 60_000
    x = np.convolve(rng.standard_normal(n + 3), np.full(4, 0.25), "valid") + 1e-3 * np.cumsum(rng.standard_normal(n))
    x += 0.05 * np.sin(2 * np.pi * 1.7 * np.arange(n) * 0.01)
    return x, summarize([x], samples=n, tau0=0.01).fit()


def test_a_fit_is_pickled_by_its_values(found):
    _, fit = found
    assert fit.response is not None
    assert fit.sinusoid
    again = pickle.loads(pickle.dumps(fit))
    assert isinstance(again, ChannelFit)
    assert repr(again) == repr(fit)


def test_the_fit_of_a_channel_has_its_values(found):
    x, fit = found
    named = fit_channel(Record.from_arrays(rate=100, unit={"gyro": "rad/s"}, gyro_x=x), "gyro_x")
    assert named.model == dict(fit.model)
    for name, term in fit.terms:
        assert (named[name].observed, named[name].low, named[name].high) == (term.observed, term.low, term.high)
    assert (named.verdict, named.tau_min, named.tau_max) == (fit.verdict, fit.tau_min, fit.tau_max)
    assert [each.part for each in named.covariance.parameters] == [each.part for each in fit.parameters]
    assert named.covariance.matrix.ravel().tolist() == fit.covariance


def test_an_averaging_time_below_one_sample_is_refused():
    model = NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    fit = fit_channel(simulate(model, duration=60, rate=100, rng=1), "gyro_x")
    assert isinstance(fit, NoiseFit)
    with pytest.raises(ValueError, match="at least 1 sample"):
        fit.avar(m=[0, 1])


def test_unknown_names_are_refused():
    x = np.random.default_rng(seed_of("unknown names")).standard_normal(1000)
    summary = summarize([x], samples=1000, tau0=0.01)
    for terms, said in (["drift"], "unknown term"), (["rate_ramp"], "not a noise term"):
        with pytest.raises(ValueError, match=said):
            summary.fit(terms=terms)


def test_constants_are_those_of_the_core():
    assert (MAX_LINES, ALPHA) == (native.MAX_LINES, native.OUTLIER_ALPHA)
