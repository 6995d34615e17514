"""Noise models as linear systems: their Allan variance by doubling against the closed forms."""

import math

import numpy as np
import pytest

from sigmatau import DataError, OptionError
from sigmatau.model import ChannelModel, GaussMarkov, LowPass, Sinusoid
from sigmatau.model.flicker import flicker_poles
from sigmatau.model.state_space import state_space

SIZES = (1, 2, 7, 100, 10_000, 1_000_000)
TAU0 = 0.01

EXACT = {
    "quantization": ChannelModel(terms={"quantization": 1e-3}),
    "random walk": ChannelModel(terms={"random_walk": 0.005}),
    "rate random walk": ChannelModel(terms={"rate_random_walk": 1e-4}),
    "ramp": ChannelModel(terms={"rate_ramp": -1e-6}),
    "Gauss-Markov": ChannelModel(gauss_markov=(GaussMarkov(sigma=1e-3, time=10.0), GaussMarkov(sigma=2.0, time=0.02))),
    **{
        f"bandwidth {order}": ChannelModel(terms={"random_walk": 0.005}, bandwidth=LowPass(order=order, corner=corner))
        for order, corner in [(1, 30.0), (2, 30.0), (3, 3.0), (5, 70.0), (9, 30.0)]
    },
    "all": ChannelModel(
        terms={"quantization": 1e-5, "random_walk": 0.005, "rate_random_walk": 1e-4, "rate_ramp": 1e-6},
        gauss_markov=(GaussMarkov(sigma=1e-3, time=10.0),),
    ),
}


@pytest.mark.parametrize("output", ["rate", "increments", "integrated"])
@pytest.mark.parametrize("case", EXACT)
def test_allan_variance_is_that_of_the_closed_form(case, output):
    expected = EXACT[case].avar(m=SIZES, tau0=TAU0)
    got = state_space(EXACT[case], dt=TAU0, output=output).avar(SIZES)
    np.testing.assert_allclose(got, expected, rtol=1e-12)


def test_a_sinusoid_turns():
    line = ChannelModel(sinusoid=(Sinusoid(amplitude=1e-3, frequency=0.37),))
    sizes = (1, 2, 7, 100, 333)
    got = state_space(line, dt=TAU0).avar(sizes)
    np.testing.assert_allclose(got, line.avar(m=sizes, tau0=TAU0), rtol=1e-12)


class TestFlicker:
    model = ChannelModel(terms={"bias_instability": 0.0028})

    # With one pole a decade, and one more at either end: the bound of the issue, met with room.
    @pytest.mark.parametrize(
        ("decades", "poles", "error"), [(2, 4, 0.012), (4, 6, 0.012), (6, 8, 0.012), (6, 12, 1e-3)]
    )
    def test_error_is_what_is_stated(self, decades, poles, error):
        system = state_space(self.model, dt=TAU0, tau_max=TAU0 * 10**decades, flicker_error=error)
        assert len(system.states) == poles
        sizes = np.unique(np.round(2 ** np.linspace(0, math.log2(10**decades), 97)).astype(int))
        off = np.sqrt(system.avar(sizes) / self.model.avar(m=sizes, tau0=TAU0)) - 1
        assert np.abs(off).max() <= 1.1 * system.flicker_error  # between the times that it was fitted at
        assert system.flicker_error <= error

    def test_what_cannot_be_reached_is_said(self):
        with pytest.raises(OptionError, match=r"0\.0001 to 1"):
            flicker_poles(dt=0.01, tau_max=100.0, error=1e-6)
        with pytest.raises(OptionError, match="tau_max"):
            flicker_poles(dt=0.01, tau_max=0.001)
        with pytest.raises(OptionError, match="dt"):
            state_space(self.model, dt=0.0)


def test_turn_on_bias_is_a_state_and_no_allan_variance_shows_it():
    model = ChannelModel(terms={"random_walk": 0.005})
    plain, biased = state_space(model, dt=TAU0), state_space(model, dt=TAU0, turn_on=1.0)
    assert (plain.states, biased.states) == ((), ("bias",))
    assert biased.P0[0, 0] == 1.0
    np.testing.assert_allclose(biased.avar(SIZES), plain.avar(SIZES), rtol=1e-12)


def test_silent_arguments_are_refused():
    model = ChannelModel(terms={"random_walk": 0.005})
    with pytest.raises(OptionError, match="output"):
        state_space(model, dt=0.01, output="angle")
    with pytest.raises(OptionError, match="turn_on"):
        state_space(model, dt=0.01, turn_on=-1.0)
    with pytest.raises(OptionError, match="at least 1"):
        state_space(model, dt=0.01).avar([0])
    with pytest.raises(DataError, match="no random_walk"):
        ChannelModel(terms={"quantization": 1.0}, bandwidth=LowPass(order=1, corner=30.0))
    with pytest.raises(DataError, match="order"):
        LowPass(order=10, corner=30.0)
