"""The errata of docs/paper/errata.md: each claim by an independent calculation."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import chi2, norm

import known
import sigmatau as st
from sigmatau.noise.terms import TERMS, aliasing_inflation, avar, psd
from sigmatau.noise.uncertainty import degrees_of_freedom, percentage_error
from sigmatau.units import to_si


def test_2_a_delay_has_no_density():
    """Two systems with the same |H|²: a zero at 2 and one at 1/2, scaled."""
    z = np.exp(-2j * np.pi * np.linspace(0.01, 0.49, 40))
    first, second = 1 - 0.5 * z, 0.5 - z
    np.testing.assert_allclose(abs(first) ** 2, abs(second) ** 2, rtol=1e-12)
    assert abs(np.angle(first / second)).max() > 1


def test_4_and_6_are_two_estimators():
    data = st.Record.from_arrays(rate=1, x=known.nbs14())
    end_to_end, overlapping = (st.allan(data, taus=[10], overlap=o)["x"].adev[0] for o in ("none", "full"))
    assert (f"{end_to_end:.6e}", f"{overlapping:.6e}") == ("9.965736e-02", "9.159953e-02")


def test_6_counts_one_pair_too_few():
    y, m = known.nbs14(), 10
    starts = [k for k in range(len(y)) if k + 2 * m <= len(y)]  # of two clusters that fit
    assert len(starts) == len(y) - 2 * m + 1
    halves = st.allan(st.Record.from_arrays(rate=1, x=y), taus=[500])["x"]
    assert halves.n_pairs[0] == 1  # n = N/2
    literal = st.allan(st.Record.from_arrays(rate=1, x=y), taus=[10], counting="paper")["x"]
    assert f"{literal.adev[0]:.6e}" == "9.161625e-02"


def test_11_holds_for_a_walk_that_is_not_stationary():
    integral = quad(
        lambda x: psd("rate_random_walk", 1.0, [x / np.pi])[0] * np.sin(x) ** 4 / x**2, 1e-9, 60, limit=400
    )[0]
    assert integral * 4 / np.pi == pytest.approx(1 / 3, rel=1e-4)  # the rest falls as x⁻³


@pytest.mark.parametrize("term", ["quantization", "random_walk", "rate_random_walk"])
def test_11_for_samples(term):
    n, t0 = 7, 0.01
    f = (np.arange(400_000) + 0.5) / 400_000 / (2 * t0)
    window = np.sin(np.pi * f * n * t0) ** 4 / (n * np.sin(np.pi * f * t0)) ** 2
    got = 4 * np.mean(psd(term, 1e-3, f, tau0=t0) * window) / (2 * t0)
    assert got == pytest.approx(avar(term, 1e-3, m=[n], tau0=t0)[0], rel=1e-6)


@pytest.mark.parametrize(("n", "share"), [(1, 0.594), (2, 0.802), (10, 0.775), (10_000, 0.7737)])
def test_14_gives_15_by_its_right_hand_form_only(n, share):
    """In the band f < 1/(2 T_s) with T_s = Q = 1; n = 10 000 by its mean of sin⁴, 3/8."""
    window = (lambda f: np.sin(np.pi * f * n) ** 4) if n < 1000 else (lambda f: 0.375 + 0 * f)
    f = (np.arange(1_000_000) + 0.5) / 2_000_000
    middle = 4 * np.mean(4 * np.sin(np.pi * f) ** 2 * window(f) / (np.pi * f * n) ** 2) / 2
    right = 4 * np.mean((2 * np.pi * f) ** 2 * window(f) / (np.pi * f * n) ** 2) / 2
    assert middle * n**2 / 3 == pytest.approx(share, abs=6e-4)
    assert right * n**2 / 3 == pytest.approx(1, rel=1e-6)


def test_14_over_all_frequencies():
    """n = 1: ∫ sin⁶x/x² dx = 3π/16, so that 16/π · 3π/16 = 3."""
    assert quad(lambda x: np.sin(x) ** 6 / x**2, 1e-9, 2000, limit=4000)[0] == pytest.approx(3 * np.pi / 16, abs=2e-4)


def test_24_diverges_and_23_is_exact():
    def from_24(cut):
        return quad(lambda u: np.sin(np.exp(u)) ** 4 / np.exp(4 * u), np.log(cut), np.log(200.0), limit=500)[0]

    assert from_24(1e-6) - from_24(1e-3) == pytest.approx(3 * np.log(10), rel=1e-5)  # a logarithm
    assert from_24(1e-4) == pytest.approx(-np.log(1e-4) - 0.111226, abs=1e-5)
    curve = st.allan(st.Record.from_arrays(rate=1, x=np.arange(1000.0)))["x"]
    np.testing.assert_allclose(curve.avar, curve.tau**2 / 2, rtol=1e-11)


def test_26_is_for_clusters_that_do_not_overlap():
    """White noise: of the disjoint deviation too narrow, of the overlapped one too wide (first order, 1/√(2 edf))."""
    n, m, records = 1024, 16, 2000
    y = np.random.default_rng(known.seed_of("eq. 26 of disjoint clusters")).standard_normal((records, n))
    means = y.reshape(records, n // m, m).mean(axis=2)
    disjoint = np.sqrt(np.mean(np.diff(means) ** 2, axis=1) / 2)
    ratio = np.std(disjoint) / np.mean(disjoint) / percentage_error(n, m)[0]
    assert ratio == pytest.approx(math.sqrt(3 / 2), abs=3 * 1.22 / math.sqrt(2 * records))
    edf = degrees_of_freedom({"random_walk": 1.0}, n=n, m=[m], tau0=1.0)[0]
    assert 0.8 < 1 / np.sqrt(2 * edf) / percentage_error(n, m)[0] < 0.88


def test_the_7_6_percent_are_at_82_seconds():
    at_100_s, at_82_s = (100 * percentage_error(1_440_000, m)[0] for m in (20_000, 2**14))
    assert round(at_100_s, 1) == 8.4
    assert round(at_82_s, 1) == 7.6
    assert round(0.973 * 0.076, 3) == 0.074
    rates = [n / 7200 for n in range(7200, 7200 * 400, 7200) if f"{100 * percentage_error(n, 1)[0]:.2f}" == "0.06"]
    assert (min(rates), max(rates)) == (165, 229)  # 0.055 to 0.065 %


@pytest.mark.parametrize(
    ("q", "other", "term", "used"),
    [
        (1.680, "2.64 m/s/h^2", "rate_ramp", 81.92),
        (2.119, "0.76 m/s/h^(3/2)", "rate_random_walk", 14.48),
        (2.199, "1.16 m/s/h^(3/2)", "rate_random_walk", 40.96),
        (2.185, "3.35 m/s/h^(3/2)", "rate_random_walk", 10.24),
    ],
)
def test_quantization_of_an_accelerometer_is_the_number_over_3600(q, other, term, used):
    m = np.unique(np.geomspace(1, 20_000, 4000).astype(int))
    value, unit = other.split()
    red = avar(term, to_si(float(value), unit), m=m, tau0=1.0)
    crossing = {si: m[np.argmin(np.abs(np.log(avar("quantization", si, m=m, tau0=1.0) / red)))] for si in (q / 3600, q)}
    assert used / 1.15 < crossing[q / 3600] < 5 * used
    assert crossing[q] > 7200 / 3 > 10 * used  # no line of the other term in the record


def test_the_random_walk_of_the_cimu_has_quantization_in_it():
    q, n = to_si(0.973, "arcsec"), to_si(0.0015, "deg/sqrt(h)")
    sigma = np.sqrt(
        sum(avar(term, value, m=[2**18], tau0=0.005)[0] for term, value in (("quantization", q), ("random_walk", n)))
    )
    assert sigma * np.sqrt(2**18 * 0.005) / n == pytest.approx(1.126, abs=5e-4)


def test_the_random_walk_of_the_cimu_if_it_was_read_at_1311_s():
    """σ²T = N² + 3Q²/T; the line through the curve there has 0.0015 deg/√h."""
    q, read, tau = to_si(0.973, "arcsec"), to_si(0.0015, "deg/sqrt(h)"), 2**18 * 0.005
    n = math.sqrt(read**2 - 3 * q**2 / tau)
    sigma2 = sum(
        avar(term, value, m=[2**18], tau0=0.005)[0] for term, value in (("quantization", q), ("random_walk", n))
    )
    assert math.sqrt(sigma2 * tau) == pytest.approx(read, rel=1e-12)
    assert n / to_si(1, "deg/sqrt(h)") == pytest.approx(0.00128, abs=5e-6)
    assert 0.33 > 1 - n / read > 0.14


def test_flicker_angle_noise_has_a_logarithm():
    """The law of NIST SP 1065, 1.038 + 3 ln(2πf_h τ), from sums of the phase autocovariance in place of the integral."""
    assert 3 * np.euler_gamma - math.log(2) == pytest.approx(1.038, abs=1e-3)
    x = np.linspace(1e-9, 50 * math.pi, 2_000_001)
    integral = np.trapezoid(np.sin(x) ** 4 / x, x)
    assert 8 * integral == pytest.approx(3 * math.log(100 * math.pi) + 1.0385, abs=2e-3)


def test_59_g_of_noise_if_the_quantization_were_in_m_per_s():
    sigma = {
        unit: math.sqrt(avar("quantization", si, m=[1], tau0=0.005)[0]) / 9.80665
        for unit, si in (("m/s", 1.68), ("/3600", 1.68 / 3600))
    }
    assert sigma["m/s"] == pytest.approx(59.3, abs=0.1)
    assert sigma["/3600"] == pytest.approx(0.0165, abs=1e-4)


def test_table_v_is_the_coefficient_by_the_crossing_at_10_s():
    level = TERMS["bias_instability"].level
    for n, b in ((0.512, 13.6), (0.486, 11.7), (0.489, 16.8)):
        walk, flat = to_si(n, "deg/sqrt(h)"), to_si(b, "deg/h")
        assert 6.8 < (walk / (level * flat)) ** 2 < 14.2
        assert 3 < (walk / flat) ** 2 < 6.3


def test_1_deg_per_root_hour_is_a_two_sided_density():
    n = to_si(1, "deg/sqrt(h)")
    assert round(n, 5) == 2.9e-4
    assert psd("random_walk", n, [1.0])[0] == pytest.approx(n**2)
    assert math.sqrt(2) * n == pytest.approx(4.1e-4, abs=5e-6)


def test_a_valley_without_flicker_noise():
    n, k = 1e-3, 1e-5
    tau = np.geomspace(1, 1e5, 20_001)
    sigma = np.sqrt(n**2 / tau + k**2 * tau / 3)
    at = np.argmin(sigma)
    assert tau[at] == pytest.approx(math.sqrt(3) * n / k, rel=1e-3)
    assert sigma[at] / TERMS["bias_instability"].level / math.sqrt(n * k) == pytest.approx(1.6176, abs=1e-4)


def test_the_rule_of_the_paper_accepts_58_percent():
    """Seven equal runs with a correct δ: STD < δ if χ² with 6 degrees of freedom is below 6."""
    assert chi2.cdf(6, 6) == pytest.approx(0.577, abs=5e-4)
    runs = norm.rvs(size=(20_000, 7), random_state=np.random.default_rng(known.seed_of("STD below δ")))
    assert np.mean(np.std(runs, axis=1, ddof=1) < 1) == pytest.approx(0.577, abs=3 * math.sqrt(0.577 * 0.423 / 20_000))


def test_sampling_too_slowly():
    law = [aliasing_inflation(rate=rate, bandwidth=30) for rate in (10, 50, 100, 500)]
    assert [round(x, 3) for x in law] == [3.07, 1.405, 1.131, 1.006]
    folded = sum(1 / (1 + (k * 100 / 30) ** 2) for k in range(-20_000, 20_001))
    assert law[2] == pytest.approx(math.sqrt(folded), rel=1e-5)


def test_the_highest_deviation_behind_30_hz_is_at_10_ms():
    process = st.ChannelModel(gauss_markov=(st.GaussMarkov(sigma=1.0, time=1 / (2 * np.pi * 30)),))
    m = np.arange(1, 4000)
    tau = m * 1e-5
    assert tau[np.argmax(process.avar(m=m, tau0=1e-5))] == pytest.approx(0.01004, rel=5e-3)


def test_the_calmest_part_has_too_small_a_variance():
    """Rate random walk, window half the record: the Allan variance at a quarter of the window, about half the truth."""
    rng = np.random.default_rng(known.seed_of("the most stable two hours"))
    n, window = 480, 240
    starts = range(0, n - window + 1, 20)
    ratios = []
    for _ in range(1500):
        y = np.cumsum(rng.standard_normal(n))
        calm = min((y[a : a + window] for a in starts), key=np.std)
        x = np.concatenate([[0], np.cumsum(calm)])
        m = window // 4
        z = x[2 * m :] - 2 * x[m:-m] + x[: -2 * m]
        ratios.append(np.mean(z**2) / (2 * m**2) / (m / 3))
    assert np.mean(ratios) + 3 * np.std(ratios) / math.sqrt(1500) < 0.55
