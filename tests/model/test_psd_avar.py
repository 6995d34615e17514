"""Allan variances of sampled densities and of matrices, against closed forms, the integral of a function, and records."""

import itertools
import math

import numpy as np
import pytest

import known
import sigmatau as st
from sigmatau.noise import terms

TAU0 = 0.01
SIZES = np.array([1, 2, 7, 100, 3333])
TIMES = SIZES * TAU0
TOLERANCE = 1e-9  # measured: 1e-15


def whole(f, density, **how):
    got = st.avar_from_psd(f, density, TIMES, sided="two", **how)
    return got.avar + got.below + got.above


class TestTermsOfAWholeBand:
    """Eqs. (14) to (21) as sampled densities: the band, and the same law outside it, are the whole."""

    F = np.geomspace(1e-3, 50, 200)

    def test_random_walk(self):
        got = whole(self.F, 0.3**2 + 0 * self.F, slope_below=0.0, slope_above=0.0)
        np.testing.assert_allclose(got, 0.3**2 / TIMES, rtol=TOLERANCE)  # eq. (17)

    def test_random_walk_of_samples(self):
        got = whole(self.F, 0.3**2 + 0 * self.F, slope_below=0.0, tau0=TAU0)
        np.testing.assert_allclose(got, 0.3**2 / TIMES, rtol=TOLERANCE)

    def test_rate_random_walk(self):
        got = whole(self.F, terms.psd("rate_random_walk", 0.3, self.F), slope_below=-2.0, slope_above=-2.0)
        np.testing.assert_allclose(got, 0.3**2 * TIMES / 3, rtol=TOLERANCE)  # eq. (21)

    def test_quantization_by_the_right_hand_side_of_eq_14(self):
        got = st.avar_from_psd(self.F, (2 * np.pi * self.F) ** 2 * TAU0, TIMES, sided="two", slope_below=2.0)
        np.testing.assert_allclose(got.avar + got.below, 3 / TIMES**2, rtol=TOLERANCE)  # eq. (15)

    @pytest.mark.parametrize("cutoff", [0.3, 1.0, 70.0])
    def test_bias_instability_up_to_a_cut_off(self, cutoff):
        f = np.geomspace(1e-3, cutoff, 50)
        times = np.array([t for t in TIMES if t * cutoff > 0.4])
        got = st.avar_from_psd(f, terms.psd("bias_instability", 0.3, f), times, sided="two", slope_below=-1.0)
        m = np.round(times / TAU0).astype(int)
        expected = terms.avar("bias_instability", 0.3, m=m, tau0=TAU0, cutoff=cutoff)  # eq. (19)
        np.testing.assert_allclose(got.avar + got.below, expected, rtol=TOLERANCE)

    def test_a_ramp_has_no_density(self):
        with pytest.raises(st.OptionError, match="slope_below"):
            whole(self.F, terms.psd("rate_ramp", 0.3, self.F), slope_below=-3.0)  # eq. (24)


def rough(f):
    """A density with a step, a peak and three powers."""
    return 1 + 0.1 / f + f / 10 + 5 / (1 + ((f - 3) / 0.4) ** 2) + 2 * (f > 8)


@pytest.mark.parametrize("tau0", [None, TAU0])
@pytest.mark.parametrize("between", ["power law", "linear"])
def test_a_sampled_density_is_the_function_that_joins_its_points(tau0, between):
    """The oracle interpolates the points by NumPy, and adds up 2000 middles of each interval."""
    f = np.concatenate([np.geomspace(0.02, 1, 9), np.linspace(1.1, 40, 25)])
    density = rough(f)

    def joined(x):
        if between == "linear":
            return np.interp(x, f, density)
        return np.exp(np.interp(np.log(x), np.log(f), np.log(density)))

    tau = np.array([1, 3, 10, 300, 900]) * TAU0 * 2
    got = st.avar_from_psd(f, density, tau, sided="two", between=between, tau0=tau0)
    edges = np.concatenate([np.linspace(a, b, 2000, endpoint=False) for a, b in itertools.pairwise(f)] + [f[-1:]])
    nodes, weights = np.polynomial.legendre.leggauss(5)
    half = np.diff(edges)[:, None] / 2
    x = edges[:-1, None] + half * (1 + nodes)
    for k, time in enumerate(tau):
        below = np.pi * x * time if tau0 is None else time / tau0 * np.sin(np.pi * x * tau0)
        expected = 4 * (weights * half * joined(x) * np.sin(np.pi * x * time) ** 4 / below**2).sum()
        assert got.avar[k] == pytest.approx(expected, rel=1e-12), time
    function = st.avar_from_psd((f[0], f[-1]), joined, tau, sided="two", tau0=tau0)
    np.testing.assert_allclose(got.avar, function.avar, rtol=1e-9)
    np.testing.assert_allclose(got.below, function.below, rtol=1e-9)
    np.testing.assert_allclose(got.above, function.above, rtol=1e-9)
    assert (got.above > 0).all()


def test_a_density_with_zeros_is_straight_there():
    f = np.array([1.0, 2.0, 3.0, 4.0])
    got = st.avar_from_psd(f, [1.0, 0.0, 0.0, 1.0], 0.3, sided="two")
    expected = st.avar_from_psd(f, [1.0, 0.0, 0.0, 1.0], 0.3, sided="two", between="linear")
    assert got.avar == pytest.approx(expected.avar, rel=1e-12)


def test_bound_holds_for_every_density_below_its_law():
    """What is cut off is between 0 and the bounds, whichever slopes above -2 and below 0 the density has."""
    for low in (-1.9, -1.0, 0.0, 2.0):
        for high in (-3.0, -1.0, 0.0):

            def density(f, low=low, high=high):
                return np.where(f < 1, f**low, f**high)

            tau = [0.2, 0.5, 3.0, 10.0]
            all_of = st.avar_from_psd((1e-9, 1e9), density, tau, sided="two").avar
            f = np.unique([*np.geomspace(0.03, 5, 300), 1.0])
            got = st.avar_from_psd(f, density(f), tau, sided="two")
            assert (got.avar <= all_of * (1 + 1e-6)).all()
            assert (all_of <= (got.avar + got.below + got.above) * (1 + 1e-6)).all()


def test_one_sided_is_twice_two_sided():
    f = np.geomspace(0.01, 50, 30)
    two = st.avar_from_psd(f, rough(f), 1.0, sided="two")
    one = st.avar_from_psd(f, 2 * rough(f), 1.0, sided="one")
    assert one.avar == pytest.approx(two.avar, rel=1e-14)
    assert st.avar_from_psd((0.01, 50), lambda x: 2 * rough(x), 1.0, sided="one").avar == pytest.approx(
        st.avar_from_psd((0.01, 50), rough, 1.0, sided="two").avar, rel=1e-12
    )


def test_default_times_are_those_of_the_band():
    f = np.geomspace(0.01, 50, 30)
    tau = st.avar_from_psd(f, rough(f), sided="two").tau
    assert tau[0] == pytest.approx(0.371 / 50, rel=1e-3)  # sin⁴x/x² is largest at f·τ = 0.371
    assert 0.371 / 0.01 / math.sqrt(2) < tau[-1] <= 0.3711 / 0.01
    samples = st.avar_from_psd(f, rough(f), sided="two", tau0=TAU0).tau / TAU0
    np.testing.assert_allclose(samples, np.round(samples), atol=1e-9)


def test_a_record_through_its_spectrum():
    """Welch's density of a record gives the Allan variance of the record, within the scatter of both."""
    model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4, "bias_instability": 3e-4}})
    record = st.simulate(model, duration=4000, rate=10, rng=known.seed_of("psd of a record"))
    spectrum = st.psd(record)["gyro_x"]
    tau = np.array([0.1, 0.4, 1.6, 6.4])
    got = st.avar_from_psd(spectrum.frequency, spectrum.density, tau, sided="two", tau0=0.1)
    # 40,000 samples: 0.5 % at one sample, 2.5 % at 64.
    np.testing.assert_allclose(
        got.avar + got.below, model.channels["gyro_x"].avar(m=np.round(tau / 0.1), tau0=0.1), rtol=0.12
    )
    np.testing.assert_allclose(
        got.adev[:3], st.allan(record, taus=tau[:3])["gyro_x"].adev, rtol=0.01
    )  # the same samples: what differs is leakage, and the band below the first frequency


# Three gyros in a housing whose temperature moves them all: x' = −x/T + w (a Gauss-Markov process), H = (a/(jω + 1/T), 1).
GAINS = np.array([1.0, -0.5, 0.25])
TIME, DRIVE = 20.0, 2e-5
WHITE = np.array([1e-4, 2e-4, 1e-4])


def matrix(f):
    """S = H·S_in·H*ᵀ, eq. (2)."""
    h = np.concatenate(
        [(GAINS / (2j * np.pi * f[:, None] + 1 / TIME))[:, :, None], np.eye(3) * np.ones((len(f), 1, 1))], axis=2
    )
    return h @ np.diag([DRIVE**2, *WHITE**2]) @ h.conj().swapaxes(1, 2)


class TestMatrix:
    TAU = np.array([0.5, 3.0, 30.0, 200.0])

    def expected(self):
        process = st.ChannelModel(gauss_markov=(st.GaussMarkov(sigma=DRIVE * math.sqrt(TIME / 2), time=TIME),))
        ratio = self.TAU / TIME  # averaged in continuous time: THEORY of IEEE 952
        gauss_markov = (
            (DRIVE * TIME) ** 2 / self.TAU * (1 - (3 - 4 * np.exp(-ratio) + np.exp(-2 * ratio)) / (2 * ratio))
        )
        assert process.avar(m=np.round(self.TAU / 0.01), tau0=0.01) == pytest.approx(gauss_markov, rel=1e-3)
        return gauss_markov[:, None, None] * np.outer(GAINS, GAINS) + np.diag(WHITE**2) / self.TAU[:, None, None]

    def test_function(self):
        got = st.avar_from_psd((0, math.inf), matrix, self.TAU, sided="two")
        np.testing.assert_allclose(got.avar, self.expected(), rtol=1e-9, atol=1e-20)

    @pytest.mark.parametrize("between", ["power law", "linear"])
    def test_sampled(self, between):
        f = np.geomspace(1e-5, 1e3, 4000)
        got = st.avar_from_psd(f, matrix(f), self.TAU, sided="two", between=between, slope_below=0.0)
        # 500 points in a decade: the error of joining them is 1e-5.
        deviations = np.sqrt(np.einsum("kii->ki", self.expected()))
        scale = deviations[:, :, None] * deviations[:, None, :]
        off = np.abs(got.avar - self.expected())
        assert (off <= got.below + got.above + 1e-4 * scale).all()
        total = np.einsum("kii->ki", got.avar + got.below + got.above)
        np.testing.assert_allclose(total, deviations**2, rtol=1e-4)
        assert (np.linalg.eigvalsh(got.avar) > 0).all()

    def test_elements_are_those_of_the_sum_of_channels(self):
        f = np.geomspace(1e-3, 10, 50)
        got = st.avar_from_psd(f, matrix(f), self.TAU, sided="two", between="linear").avar
        both = st.avar_from_psd(
            f, matrix(f)[:, :2, :2].sum(axis=(1, 2)).real, self.TAU, sided="two", between="linear"
        ).avar
        np.testing.assert_allclose(got[:, :2, :2].sum(axis=(1, 2)), both, rtol=1e-10)

    def test_a_phase_lag_is_not_seen(self):
        """The kernel is even and the imaginary part of a cross-density is odd."""
        f = np.geomspace(1e-2, 10, 50)
        quadrature = np.array([[1, 0.9j], [-0.9j, 1]]) * np.ones((len(f), 1, 1))
        got = st.avar_from_psd(f, quadrature, 1.0, sided="two").avar[0]
        assert abs(got[0, 1]) < 1e-15 < got[0, 0]


F, S = [1.0, 2.0, 3.0], [1.0, 1.0, 1.0]


@pytest.mark.parametrize(
    ("error", "message", "arguments"),
    [
        (st.DataError, r"`density` is -1 at index 1 \(2 Hz\), but cannot be negative", (F, [1, -1, 1], 0.3)),
        (st.DataError, r"`density` is not finite at index 2 \(3 Hz\)", (F, [1, 1, math.nan], 0.3)),
        (st.DataError, r"`frequency` must rise, but is 2 Hz at index 2 after 3 Hz", ([1, 3, 2], S, 0.3)),
        (st.DataError, "leave out the density at 0 Hz", ([0, 1, 2], S, 0.3)),
        (st.DataError, "above 0 Hz, but is nan at index 1", ([1, math.nan, 2], S, 0.3)),
        (st.DataError, r"has the shape \(2,\); want \(3,\)", (F, [1, 1], 0.3)),
        (st.DataError, "two or more numbers of Hz", ([1], [1], 0.3)),
        (st.DataError, "must have numbers", (F, ["a", "b", "c"], 0.3)),
        (st.DataError, "must be real", (F, [1, 1j, 1], 0.3)),
        (st.DataError, "not Hermitian", (F, [[[1, 0.5], [0.1, 1]]] * 3, 0.3)),
        (st.DataError, "a coherence is above 1", (F, [[[1, 2], [2, 1]]] * 3, 0.3)),
        (st.DataError, "two ends of the band", ((3, 1), lambda f: f, 0.3)),
        (
            st.OptionError,
            r"`tau` of 50 s is outside the band of the density, which has 0.1237 to 0.371 s",
            (F, S, [0.3, 50]),
        ),
        (st.OptionError, r"`tau` of 0.01 s is outside the band", (F, S, 0.01)),
        (st.OptionError, "`tau` must be positive", (F, S, [-1])),
        (st.OptionError, "`tau` must be positive numbers of seconds, not 'x'", (F, S, "x")),
        (st.DataError, "must return numbers", ((0, 1), lambda f: "x", 1.0)),
        (st.DataError, "two ends of the band", ((1, "a"), lambda f: f, 1.0)),
        (st.OptionError, "`tau` is required", ((0, 1), lambda f: 1 + 0 * f, None)),
    ],
)
def test_what_cannot_be_used(error, message, arguments):
    with pytest.raises(error, match=message):
        st.avar_from_psd(*arguments, sided="two")


@pytest.mark.parametrize(
    ("message", "how"),
    [
        ("`sided` must be 'one' or 'two'", {"sided": "both"}),
        ("`between` must be", {"between": "cubic"}),
        ("`tau0` must be a positive number", {"tau0": -1.0}),
        ("samples have densities up to 0.5 Hz, but `frequency` goes to 3 Hz", {"tau0": 1.0}),
        ("whole multiples of `tau0`", {"tau0": 0.11}),
        ("`slope_below` must be above -3", {"slope_below": -3.0}),
        ("`slope_above` must be below 1", {"slope_above": 1.0}),
        ("`between` is for a sampled density", {"density": rough, "frequency": (1, 3), "between": "linear"}),
    ],
)
def test_wrong_options(message, how):
    arguments = {"frequency": F, "density": S, "tau": 0.3, "sided": "two"} | how
    with pytest.raises(st.OptionError, match=message):
        st.avar_from_psd(**arguments)
    with pytest.raises(TypeError, match="sided"):
        st.avar_from_psd(F, S, 0.3)


def test_prints_itself_and_its_assumption():
    got = st.avar_from_psd(F, S, [0.2, 0.3], sided="two")
    assert "outside: below 1 Hz no steeper than f^-2, above 3 Hz no steeper than f^0" in repr(got)
    assert got.to_dict()["slope_below"] == -2.0
    assert len(got.to_dict()["avar"]) == 2
    three = st.avar_from_psd((0, math.inf), matrix, [1.0], sided="two")
    assert "3 channels" in repr(three)
    assert "outside: nothing" in repr(three)
