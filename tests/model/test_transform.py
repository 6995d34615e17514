"""Eq. (11) and its sampled form, by numbers, against every closed form of a density and an Allan variance."""

import math

import numpy as np
import pytest

import known
from sigmatau import DataError, OptionError
from sigmatau._native import kernels
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import GaussMarkov, LowPass, Sinusoid
from sigmatau.model.transform import integrate_density
from sigmatau.noise import terms

TAU0 = 0.01
SIZES = np.array([1, 2, 3, 7, 100, 3333, 1_000_003])
TIMES = SIZES * TAU0

# What the issue asks for; measured 1e-15, but for filters far below the sampling rate, 1e-13.
TOLERANCE = 1e-9


def held(psd, expected, **how):
    np.testing.assert_allclose(integrate_density(psd, TIMES, **how), expected, rtol=TOLERANCE)


class TestOfSamples:
    """Eq. (11s)."""

    @pytest.mark.parametrize("term", ["quantization", "random_walk", "bias_instability", "rate_random_walk"])
    def test_terms(self, term):
        held(lambda f: terms.psd(term, 0.3, f, tau0=TAU0), terms.avar(term, 0.3, m=SIZES, tau0=TAU0), tau0=TAU0)

    @pytest.mark.parametrize("time", [1e-3, 0.3, 10.0, 1e4])
    def test_gauss_markov(self, time):
        model = ChannelModel(gauss_markov=(GaussMarkov(sigma=2.0, time=time),))
        held(lambda f: model.psd(f, tau0=TAU0), model.avar(m=SIZES, tau0=TAU0), tau0=TAU0)

    @pytest.mark.parametrize("order", [1, 2, 5, 9])
    @pytest.mark.parametrize("corner", [0.5, 30.0, 200.0])
    def test_bandwidths(self, order, corner):
        model = ChannelModel(terms={"random_walk": 0.005}, bandwidth=LowPass(order=order, corner=corner))
        held(lambda f: model.psd(f, tau0=TAU0), model.avar(m=SIZES, tau0=TAU0), tau0=TAU0)

    def test_a_density_with_an_edge(self):
        sizes = np.array(known.SIZES[:4])
        got = integrate_density(lambda f: 0.005**2 * (f < 30), sizes * TAU0, tau0=TAU0)
        # Ten digits are known.
        assert got == pytest.approx(known.FILTERS["brick_wall", "N = 0.005"][:4], rel=1e-9)

    def test_all_at_once(self):
        model = ChannelModel(
            terms={"quantization": 1e-5, "random_walk": 0.005, "bias_instability": 0.0028, "rate_random_walk": 1e-4},
            gauss_markov=(GaussMarkov(sigma=1e-3, time=10.0),),
            bandwidth=LowPass(order=2, corner=30.0),
        )
        held(lambda f: model.psd(f, tau0=TAU0), model.avar(m=SIZES, tau0=TAU0), tau0=TAU0)


class TestContinuous:
    """Eq. (11) itself, with the closed forms of the paper."""

    def test_random_walk(self):
        held(lambda _: 0.3**2, 0.3**2 / TIMES)  # eqs. (16), (17)

    def test_rate_random_walk(self):
        expected = terms.avar("rate_random_walk", 0.3, m=SIZES, tau0=TAU0, averaged=True)
        held(lambda f: terms.psd("rate_random_walk", 0.3, f), expected)  # eqs. (20), (21)

    @pytest.mark.parametrize("cutoff", [0.003, 1.0, 70.0])
    def test_bias_instability_up_to_a_cut_off(self, cutoff):
        expected = terms.avar("bias_instability", 0.3, m=SIZES, tau0=TAU0, cutoff=cutoff)
        held(lambda f: terms.psd("bias_instability", 0.3, f), expected, f_max=cutoff)  # eqs. (18), (19)

    def test_cut_off_as_computed_by_others(self):
        for product, expected in known.CUTOFF.items():
            got = integrate_density(lambda f: 1 / (2 * np.pi * f), 1.0, f_max=product)
            assert got == pytest.approx(expected, rel=1e-13), product  # printed digits

    @pytest.mark.parametrize("time", [1e-3, 0.3, 10.0, 1e4])
    def test_gauss_markov_averaged(self, time):
        expected = kernels.gauss_markov_avar(2.0, time, SIZES, TAU0, averaged=True)
        held(lambda f: kernels.gauss_markov_psd(2.0, time, f, None), expected)

    def test_quantization_by_the_right_hand_side_of_eq_14(self):
        held(lambda f: (2 * np.pi * f) ** 2 * TAU0, 3 / TIMES**2, f_max=0.5 / TAU0)  # eq. (15)

    def test_the_middle_of_eq_14_does_not_give_eq_15(self):
        """The paper substitutes (14) into (11); that holds for its right-hand side, and for (14) in the sampled form."""
        sizes = np.array([1, 2, 10, 1_000_000])

        def middle(f):
            return 4 / TAU0 * np.sin(np.pi * f * TAU0) ** 2

        ratio = integrate_density(middle, sizes * TAU0, f_max=0.5 / TAU0) / (3 / (sizes * TAU0) ** 2)
        assert ratio == pytest.approx([0.594, 0.802, 0.775, 0.7737], abs=5.5e-4)  # three digits, four
        np.testing.assert_allclose(
            integrate_density(middle, sizes * TAU0, tau0=TAU0), 3 / (sizes * TAU0) ** 2, rtol=TOLERANCE
        )


class TestRefused:
    def test_a_ramp_diverges(self):
        with pytest.raises(DataError, match=r"diverges at f = 0: the density rises as f\^-3"):
            integrate_density(lambda f: terms.psd("rate_ramp", 1e-3, f), TIMES)  # eq. (24)
        with pytest.raises(DataError, match="diverges at f = 0"):
            integrate_density(lambda f: terms.psd("rate_ramp", 1e-3, f), TIMES, tau0=TAU0)

    def test_what_nearly_diverges_does_not(self):
        # A density f^a has an Allan variance in proportion to T^(−a−1), whatever the constant.
        a = -2.9
        got = integrate_density(lambda f: f**a, [1.0, 100.0])
        assert got[1] / got[0] == pytest.approx(100 ** (-a - 1), rel=1e-9)

    def test_a_density_that_rises_for_ever(self):
        with pytest.raises(DataError, match="f_max"):
            integrate_density(lambda f: f**2, 1.0)

    def test_wrong_densities(self):
        with pytest.raises(DataError, match="not negative"):
            integrate_density(lambda f: -f, 1.0)
        with pytest.raises(DataError, match="finite"):
            integrate_density(lambda f: np.where(f > 3, np.nan, 1.0), 1.0)
        with pytest.raises(DataError, match="a value each"):
            integrate_density(lambda f: np.ones(3), 1.0)
        with pytest.raises(DataError, match="too rough"):
            integrate_density(lambda f: 1 + np.sin(1e9 * f) ** 2, 1.0)

    @pytest.mark.parametrize(
        ("name", "how"),
        [
            ("tau", {"tau": 0.0}),
            ("tau", {"tau": math.nan}),
            ("tau", {"tau": 0.015, "tau0": 0.01}),
            ("tau0", {"tau": 1.0, "tau0": -1.0}),
            ("f_max", {"tau": 1.0, "f_max": math.inf}),
            ("rtol", {"tau": 1.0, "rtol": 1e-16}),
        ],
    )
    def test_wrong_options(self, name, how):
        with pytest.raises(OptionError, match=name):
            integrate_density(lambda _: 1.0, **how)


STATIONARY = {
    "quantization": ChannelModel(terms={"quantization": 1e-3}),
    "random walk": ChannelModel(terms={"random_walk": 0.005}),
    "Gauss-Markov": ChannelModel(gauss_markov=(GaussMarkov(sigma=1e-3, time=0.05),)),
    "bandwidth": ChannelModel(terms={"random_walk": 0.005}, bandwidth=LowPass(order=3, corner=20.0)),
    "all": ChannelModel(
        terms={"quantization": 1e-3, "random_walk": 0.005},
        gauss_markov=(GaussMarkov(sigma=1e-3, time=0.1),),
        bandwidth=LowPass(order=1, corner=30.0),
    ),
}


EVERY = {
    **{term: ChannelModel(terms={term: 0.3}) for term in terms.TERMS},
    **{
        f"Gauss-Markov {time}": ChannelModel(gauss_markov=(GaussMarkov(sigma=2.0, time=time),))
        for time in (1e-3, 0.02, 1.0, 10.0, 1e4)
    },
    **{
        f"bandwidth {order} {corner}": ChannelModel(
            terms={"random_walk": 0.005}, bandwidth=LowPass(order=order, corner=corner)
        )
        for order in (1, 2, 5, 9)
        for corner in (0.5, 30.0, 300.0)
    },
    "sinusoid": ChannelModel(sinusoid=(Sinusoid(amplitude=1e-3, frequency=0.37),)),
}


class TestAutocovariance:
    """Eq. (1), and the covariance of the phase that every Allan variance comes from."""

    @pytest.mark.parametrize("case", STATIONARY)
    def test_its_transform_is_the_density(self, case):
        model = STATIONARY[case]
        lags = np.arange(-1000, 1001)  # at which the slowest of these has e^−50 left
        f = np.array([0.01, 0.7, 13.0, 49.9])
        r = model.autocovariance(lags, tau0=TAU0)
        transform = TAU0 * np.cos(2 * np.pi * np.outer(f, lags) * TAU0) @ r
        np.testing.assert_allclose(transform, model.psd(f, tau0=TAU0), rtol=1e-11, atol=1e-12 * TAU0 * r.max())

    @pytest.mark.parametrize("case", STATIONARY)
    def test_phase_has_minus_half_the_variance_of_its_increments(self, case):
        model = STATIONARY[case]
        size = 40
        index = np.arange(size)
        covariance = model.autocovariance(index[:, None] - index, tau0=TAU0)
        expected = [-(TAU0**2) / 2 * covariance[:n, :n].sum() for n in (1, 2, 17, 40)]
        got = model.phase_autocovariance([1, 2, 17, 40], tau0=TAU0)
        start = model.phase_autocovariance(0, tau0=TAU0)
        np.testing.assert_allclose(got - start, expected, rtol=1e-9)

    def test_a_sinusoid(self):
        line = ChannelModel(sinusoid=(Sinusoid(amplitude=2.0, frequency=7.0),))
        assert line.autocovariance([0, 1, -3], tau0=TAU0) == pytest.approx(
            [2.0, 2 * math.cos(0.14 * math.pi), 2 * math.cos(0.42 * math.pi)], rel=1e-12
        )
        seen_standing = ChannelModel(sinusoid=(Sinusoid(amplitude=2.0, frequency=100.0),))
        assert seen_standing.phase_autocovariance([3], tau0=TAU0) == pytest.approx(-((2 * 0.03) ** 2) / 4, rel=1e-12)

    @pytest.mark.parametrize("case", EVERY)
    def test_allan_variance_is_that_of_its_second_differences(self, case):
        model = EVERY[case]
        n = np.array([1, 2, 7, 100, 3333, 1_000_003])

        def s(lag):
            return model.phase_autocovariance(lag, tau0=TAU0)

        got = (6 * s(0 * n) - 8 * s(n) + 2 * s(2 * n)) / (2 * (n * TAU0) ** 2)
        # Measured: 2e-10 where the correlation time is a million samples, as its docstring says; 1e-12 elsewhere.
        np.testing.assert_allclose(got, model.avar(m=n, tau0=TAU0), rtol=1e-9)

    def test_what_it_says_of_lost_digits_is_so(self):
        """An Allan variance of one sample of a process that hardly moves, from the phase: 1e-15·T/τ₀."""
        for time in (1e2, 1e4, 1e6):
            model = ChannelModel(gauss_markov=(GaussMarkov(sigma=1.0, time=time),))
            s = model.phase_autocovariance([0, 1, 2], tau0=TAU0)
            off = (6 * s[0] - 8 * s[1] + 2 * s[2]) / (2 * TAU0**2) / model.avar(m=1, tau0=TAU0)[0] - 1
            assert abs(off) < 2e-15 * time / TAU0

    @pytest.mark.parametrize("term", ["bias_instability", "rate_random_walk", "rate_ramp"])
    def test_what_is_not_stationary_has_none(self, term):
        model = ChannelModel(terms={"random_walk": 1.0, term: 1.0})
        with pytest.raises(DataError, match=f"{term} has no autocovariance.*phase_autocovariance"):
            model.autocovariance([0], tau0=TAU0)

    def test_wrong_options(self):
        model = ChannelModel(terms={"random_walk": 1.0})
        for lags in (0.5, math.nan, "x"):
            with pytest.raises(OptionError, match="lags"):
                model.autocovariance(lags, tau0=TAU0)
        for tau0 in (0.0, -1.0, math.inf):
            with pytest.raises(OptionError, match="tau0"):
                model.phase_autocovariance([0], tau0=tau0)


def test_a_density_of_a_sharp_filter_is_never_negative():
    """The sum over nine poles is rounding where the filter leaves 1e-18."""
    model = ChannelModel(terms={"random_walk": 1.0}, bandwidth=LowPass(order=9, corner=0.5))
    assert (model.psd(np.linspace(0.1, 50, 5000), tau0=TAU0) >= 0).all()
