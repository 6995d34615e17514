"""Noise models as linear systems: their Allan variance by doubling against the closed forms."""

import math

import numpy as np
import pytest

from sigmatau import DataError, OptionError
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import GaussMarkov, LowPass, Sinusoid
from sigmatau.statespace.flicker import flicker_poles
from sigmatau.statespace.state_space import state_space

SIZES = (1, 2, 7, 100, 10_000, 1_000_000)
TAU0 = 0.01

EXACT = {
    "quantization": ChannelModel(terms={"quantization": 1e-3}),
    "random walk": ChannelModel(terms={"random_walk": 0.005}),
    "rate random walk": ChannelModel(terms={"rate_random_walk": 1e-4}),
    "ramp": ChannelModel(terms={"rate_ramp": -1e-6}),
    "Gauss-Markov": ChannelModel(gauss_markov=(GaussMarkov(sigma=1e-3, time=10.0), GaussMarkov(sigma=2.0, time=0.02))),
    **{
        f"bandwidth {order}, {corner:g} Hz": ChannelModel(
            terms={"random_walk": 0.005}, bandwidth=LowPass(order=order, corner=corner)
        )
        for order, corner in [(1, 30.0), (2, 30.0), (3, 3.0), (5, 70.0), (9, 30.0), (2, 0.01)]
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
        sizes = np.unique(np.round(2 ** np.linspace(0, math.log2(10**decades), 2000)).astype(int))
        off = np.abs(np.sqrt(system.avar(sizes) / self.model.avar(m=sizes, tau0=TAU0)) - 1).max()
        # Between the times at which it was taken, 1/48 octave apart, the error is flat to that squared.
        assert off == pytest.approx(system.flicker_error, rel=1e-3)
        assert system.flicker_error <= error

    def test_what_cannot_be_reached_is_said(self):
        with pytest.raises(OptionError, match=r"0\.0001 to 1"):
            flicker_poles(dt=0.01, tau_max=100.0, error=1e-6)
        with pytest.raises(OptionError, match="tau_max"):
            flicker_poles(dt=0.01, tau_max=0.001)
        with pytest.raises(OptionError, match="dt"):
            state_space(self.model, dt=0.0)


# AVAR of 1, 2 and 7 samples every 0.01 s behind a filter, N = 0.005, to 80 digits from the autocovariance: a sum over
# the poles p, r(t) = N²·ω·Σ exp(p·ω·t)/Π(−p − q)·Π(p − q).
SHORT = {
    (1, 0.0001): (4.9347866974388095e-14, 7.40214128860459e-14, 2.326330787859046e-13),
    (2, 0.01): (1.0959127640939679e-13, 4.381541391624412e-13, 5.356064647411994e-12),
    (5, 0.001): (3.832586569581644e-17, 1.5330346253845e-16, 1.8779673711111198e-15),
    (9, 0.0001): (3.4451418533592494e-20, 1.378056741325945e-19, 1.6881195077980407e-18),
    (9, 30.0): (0.0007667857278241729, 0.0010825790003464346, 0.00033885531991812774),
    (2, 10000.0): (0.5553603672697958, 0.2776801836348979, 0.07933719532425654),
}


@pytest.mark.parametrize(("order", "corner"), SHORT)
def test_a_step_short_against_a_filter_keeps_its_digits(order, corner):
    # Of no other than this: the closed form cancels too at times short against the filter.
    model = ChannelModel(terms={"random_walk": 0.005}, bandwidth=LowPass(order=order, corner=corner))
    got = state_space(model, dt=TAU0).avar([1, 2, 7])
    np.testing.assert_allclose(got, SHORT[order, corner], rtol=1e-11)


@pytest.mark.parametrize("m", [[1.5], [math.nan], [math.inf], ["1"], [True], [1, 2.25]])
def test_sizes_are_whole_numbers(m):
    system = state_space(ChannelModel(terms={"random_walk": 0.005}), dt=TAU0)
    with pytest.raises(OptionError, match="whole numbers"):
        system.avar(m)
    assert system.avar([2.0]) == system.avar([2])


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
