"""The linear model held against curves: p is uniform for the true model, small for a wrong one."""

import json

import numpy as np
import pytest
from scipy import signal, stats

from known import seed_of
from sigmatau import DataError, NoiseModel, OptionError, Record, allan, simulate
from sigmatau.model import covariance as covariances
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import GaussMarkov, LowPass, Resonance, Sinusoid
from sigmatau.noise.uncertainty import avar_covariance, degrees_of_freedom
from sigmatau.statespace.avar_scatter import covariance_of_model, covariance_with
from sigmatau.statespace.verify import verify

RATE = 10.0
RECORDS = 40
TERMS = {"quantization": 2e-4, "random_walk": 0.005, "bias_instability": 0.0028, "rate_random_walk": 1e-3}


def curve_of(y):
    return allan(Record.from_arrays(rate=RATE, gyro_x=y), taus="octave", threads=1)["gyro_x"]


def simulated(terms, name, *, n=4096, records=RECORDS):
    """Curves of records with the given terms; the records are channels of one, which is made at once."""
    model = NoiseModel(channels={f"gyro_{k}": terms for k in range(records)})
    return list(allan(simulate(model, duration=n / RATE, rate=RATE, rng=seed_of(name)), taus="octave").values())


def assert_uniform(p):
    """Kolmogorov's test at 1e-3; the mean at ±3 standard errors; at 5 %, the rate plus three standard errors."""
    assert stats.kstest(p, "uniform").pvalue > 1e-3
    assert abs(np.mean(p) - 0.5) < 3 / np.sqrt(12 * len(p))
    assert np.mean(np.array(p) < 0.05) <= 0.05 + 3 * np.sqrt(0.05 * 0.95 / len(p))


class TestStatistics:
    @pytest.mark.parametrize("terms", [TERMS, {"random_walk": 0.005}, {"rate_random_walk": 1e-3}], ids=" ".join)
    def test_true_model(self, terms):
        model = ChannelModel(terms=terms)
        found = [verify(model, curve) for curve in simulated(terms, f"verify {' '.join(terms)}")]
        assert_uniform([v.p_value for v in found])
        inside = np.mean([np.mean(~v.outside[v.used]) for v in found])
        # Octaves of a record are correlated: as if a third of them counted.
        assert inside == pytest.approx(0.95, abs=3 * np.sqrt(0.05 * 0.95 / (RECORDS * found[0].freedom / 3)))

    def test_random_walk_that_is_5_percent_off(self):
        """1.05² is 10 % of a variance that 2^16 samples show to 0.7 %: the misfit is hundreds."""
        wrong = ChannelModel(terms={**TERMS, "random_walk": 1.05 * TERMS["random_walk"]})
        for curve in simulated(TERMS, "verify N off", n=1 << 16, records=3):
            assert verify(wrong, curve).p_value < 1e-6

    def test_missing_rate_random_walk(self):
        wrong = ChannelModel(terms={t: v for t, v in TERMS.items() if t != "rate_random_walk"})
        found = [verify(wrong, curve).p_value for curve in simulated(TERMS, "verify K missing", n=1 << 16, records=3)]
        assert max(found) < 1e-3

    def test_gauss_markov_process(self):
        rng = np.random.default_rng(seed_of("verify Gauss-Markov"))
        model = ChannelModel(terms={"random_walk": 0.005}, gauss_markov=(GaussMarkov(sigma=0.01, time=3.0),))
        phi = np.exp(-1 / RATE / 3.0)
        e = 0.01 * np.sqrt(1 - phi**2) * rng.standard_normal((RECORDS, 1000 + 4096))
        y = signal.lfilter([1.0], [1.0, -phi], e)[:, 1000:] + 0.005 * np.sqrt(RATE) * rng.standard_normal(
            (RECORDS, 4096)
        )
        assert_uniform([verify(model, curve_of(row)).p_value for row in y])

    @pytest.mark.parametrize(("order", "corner"), [(1, 1.0), (4, 0.5)])
    def test_bandwidth(self, order, corner):
        """White noise behind a filter: p as often below 5 % as it says, and 95 % of ratios inside their bands."""
        terms = {"random_walk": 0.005, "rate_random_walk": 1e-3}
        model = ChannelModel(terms=terms, bandwidth=LowPass(order=order, corner=corner))
        found = [verify(model, curve) for curve in simulated(model, f"verify bandwidth {order}", records=50)]
        assert_uniform([v.p_value for v in found])
        inside = np.mean([~v.outside[v.used] for v in found], axis=0)
        # The least of eleven octaves, of few records: the quantile of the binomial law.
        assert len(found) * inside.min() >= stats.binom.ppf(1e-3 / len(inside), len(found), 0.95)

    def test_sinusoid(self):
        rng = np.random.default_rng(seed_of("verify sinusoid"))
        line = Sinusoid(amplitude=0.02, frequency=0.5)
        model = ChannelModel(terms={"random_walk": 0.005}, sinusoid=(line,))
        t = np.arange(4096) / RATE
        y = 0.02 * np.sin(np.pi * t + 6.28 * rng.random((RECORDS, 1))) + 0.005 * np.sqrt(RATE) * rng.standard_normal(
            (RECORDS, 4096)
        )
        assert_uniform([verify(model, curve_of(row)).p_value for row in y])
        assert verify(ChannelModel(terms={"random_walk": 0.005}), curve_of(y[0])).p_value < 1e-12


def test_covariance_is_the_exact_one():
    sizes = np.array([1, 4, 32, 300])
    terms = {**TERMS, "rate_ramp": 1e-4}
    expected = avar_covariance(terms, n=1000, m=sizes, tau0=0.1)
    np.testing.assert_allclose(
        covariance_of_model(ChannelModel(terms=terms), n=1000, m=sizes, tau0=0.1), expected, rtol=1e-12
    )


def test_covariance_behind_a_first_order_filter():
    """Its samples are those of a Gauss-Markov process, of which the kernels have the exact covariance."""
    sizes = np.array([1, 3, 40, 300])
    rest = {"quantization": 2e-4, "bias_instability": 0.0028, "rate_random_walk": 1e-3, "rate_ramp": 1e-4}
    time, corner = 0.8, 1 / (2 * np.pi * 0.8)
    same = ChannelModel(terms=rest, gauss_markov=(GaussMarkov(sigma=0.01, time=time),))
    terms = {"random_walk": 0.01 * np.sqrt(2 * time), **rest}
    model = ChannelModel(terms=terms, bandwidth=LowPass(order=1, corner=corner))
    expected, found = (covariance_of_model(one, n=1000, m=sizes, tau0=0.1) for one in (same, model))
    sd = np.sqrt(np.diag(expected))
    np.testing.assert_allclose(found / np.outer(sd, sd), expected / np.outer(sd, sd), atol=1e-3)  # the kernels' 1e-3


def over_all_lags(product, n, sizes, tau0):
    """Covariances of variances, summed over all lags: `product` of the covariances of second differences, and of a mean."""
    expected = np.zeros((len(sizes), len(sizes)))
    for i, a in enumerate(sizes):
        for j, b in enumerate(sizes):
            first, second = n - 2 * a + 1, n - 2 * b + 1
            lag = np.arange(1 - first, second)
            pairs = np.minimum(first, second - lag) - np.maximum(0, -lag)
            ends = [(x * y, lag + q * b - p * a) for p, x in enumerate((1, -2, 1)) for q, y in enumerate((1, -2, 1))]
            squares, mean = product(lambda phase, ends=ends: sum(w * phase(np.abs(at)) for w, at in ends))
            expected[i, j] = (pairs * (squares / (a * b * tau0**2) ** 2 + mean)).sum() / (first * second)
    return expected


@pytest.mark.parametrize(("order", "corner"), [(2, 0.5), (9, 0.1), (5, 30.0)])
def test_covariance_behind_a_filter(order, corner):
    """Against the sum over all lags, beside flicker noise and a ramp."""
    n, sizes, tau0, ramp = 1500, np.array([1, 5, 64, 430]), 0.1, 3e-3
    part = covariances.band_limited(1.0, LowPass(order=order, corner=corner), tau0)

    def filtered(lags):
        return part.phase(lags.astype(float), tau0)

    def beside(lags):
        return covariances.phase_autocovariance_of_term("bias_instability", 0.3, lags.astype(float), tau0)

    found = covariance_with(
        part,
        n=n,
        m=sizes,
        tau0=tau0,
        rest=beside,
        ramp=ramp,
        together=np.array([True, True, False, True]),
    )

    def product(difference):
        own, other = difference(filtered), difference(beside)
        return (own**2 + 2 * own * other) / 2, ramp**2 * own

    expected = over_all_lags(product, n, sizes, tau0)
    sd = np.sqrt(np.diag(expected))
    np.testing.assert_allclose(np.diag(found), np.diag(expected), rtol=1e-4)
    assert found[2, 0] == found[2, 3] == 0
    kept = np.ix_([0, 1, 3], [0, 1, 3])
    np.testing.assert_allclose((found / np.outer(sd, sd))[kept], (expected / np.outer(sd, sd))[kept], atol=1e-4)


@pytest.mark.parametrize(
    ("resonances", "off"),
    [
        ([(1e-2, 2.0, 0.3), (1e-3, 0.05, 0.01)], 2e-4),
        ([(1e-2, 2.0, 0.1)], 2e-2),  # narrow: the mean over an oscillation, far from coincidences of cluster ends
        ([(1e-2, 2.0, 0.01)], 1e-2),
    ],
)
def test_covariance_with_resonances(resonances, off):
    """Against the sum over all lags of all noise together."""
    n, sizes, tau0 = 5000, np.array([1, 7, 64, 500, 1600]), 0.02
    own = tuple(Resonance(sigma=s, frequency=f, width=w) for s, f, w in resonances)
    model = ChannelModel(
        terms={"random_walk": 1e-3, "bias_instability": 1e-4}, resonance=own, bandwidth=LowPass(order=2, corner=8.0)
    )
    phase = model.phase_autocovariance(np.arange(4 * n), tau0=tau0)
    expected = over_all_lags(lambda difference: (difference(lambda lags: phase[lags]) ** 2 / 2, 0.0), n, sizes, tau0)
    sd = np.sqrt(np.diag(expected))
    found = covariance_of_model(model, n=n, m=sizes, tau0=tau0)
    np.testing.assert_allclose(found / np.outer(sd, sd), expected / np.outer(sd, sd), atol=off)


@pytest.mark.parametrize("turns", [1.3, 5.2, 1500.0])  # the last shows in samples as half their rate
def test_chance_of_the_phase_of_a_sinusoid(turns):
    """The variances of 64 phases around: cos(2φ) of evenly spaced phases has its moments exactly."""
    n, line = 1000, Sinusoid(amplitude=0.02, frequency=turns / 100)
    phases = np.arange(64) / 64
    y = 0.02 * np.sin(2 * np.pi * (line.frequency * np.arange(n) / RATE + phases[:, None]))
    found = np.array([curve_of(row).avar for row in y])
    m = curve_of(y[0]).m
    model = ChannelModel(terms={"random_walk": 1e-12}, sinusoid=(line,))
    np.testing.assert_allclose(found.mean(axis=0), model.avar(m=m, tau0=1 / RATE), rtol=1e-9, atol=1e-20)
    expected = np.cov(found.T, bias=True)
    got = covariance_of_model(model, n=n, m=m, tau0=1 / RATE)
    np.testing.assert_allclose(got, expected, atol=1e-9 * expected.max())


def test_models_without_chance_are_refused():
    line = Sinusoid(amplitude=1e-2, frequency=0.013)
    for model, words in (
        (ChannelModel(terms={"rate_ramp": 1e-2}), "has no noise, so a misfit has no probability"),
        (ChannelModel(sinusoid=(line,)), "has no noise"),
        (ChannelModel(terms={"random_walk": 1e-5}, sinusoid=(line,)), "0.013 Hz, of 1.3 turns .* hides the noise"),
    ):
        curve = curve_of(0.01 * np.sin(2 * np.pi * 0.013 * np.arange(1000) / RATE))
        with pytest.raises(DataError, match=words):
            verify(model, curve)


def test_linear_models_curve_and_bands():
    """The avar is that of the matrices, and the degrees of freedom those of the model."""
    model = ChannelModel(terms=TERMS)
    (curve,) = simulated(TERMS, "verify one", records=1)
    found = verify(model, curve)
    np.testing.assert_allclose(found.avar, model.avar(m=curve.m, tau0=curve.tau0), rtol=2 * 0.01)
    assert 0 < found.flicker_error <= 0.01
    edf = degrees_of_freedom(TERMS, n=curve.n, m=curve.m, tau0=curve.tau0)
    np.testing.assert_allclose(found.curve.edf, edf, rtol=1e-10)
    np.testing.assert_allclose(found.ratio, np.sqrt(found.avar / curve.avar), rtol=1e-12)
    assert found.curve.m[found.used].tolist() == [2**k for k in range(11)]  # 1024 ≤ 4096/3 < 2048
    later = verify(model, curve, tau_min=0.8)
    assert later.curve.m[later.used][0] == 8


def test_misfit_begins_where_the_fit_of_the_model_does():
    """Averages of four samples, a filter that the model has not: wrong below 0.8 s, right from there on."""
    white = np.random.default_rng(seed_of("verify tau_min")).standard_normal(20_003)
    curve = curve_of(np.convolve(white, np.full(4, 0.25), "valid"))
    terms = {"random_walk": RATE**-0.5}
    fitted = ChannelModel(terms=terms, tau_min=6.4)
    found = verify(fitted, curve)
    assert found.curve.m[found.used][0] == 64
    assert found.p_value > 1e-3
    assert "misfit of averaging times from 6.4 s on, where the fit of the model begins" in repr(found)
    assert verify(NoiseModel(channels={"gyro_x": fitted}), {"gyro_x": curve})["gyro_x"].tau_min == 6.4
    assert verify(fitted, curve, tau_min=0.0).p_value < 1e-12
    assert verify(ChannelModel(terms=terms), curve).p_value < 1e-12


def test_what_is_printed_written_and_drawn():
    model = NoiseModel(channels={"gyro_x": TERMS, "gyro_y": {"random_walk": 1.0}})
    curves = allan(simulate(model, duration=400.0, rate=RATE, rng=seed_of("verify print")))
    found = verify(model, curves, tau_min={"gyro_y": 1.0})
    assert set(found) == {"gyro_x", "gyro_y"}
    text = repr(found)
    assert "gyro_x: linear model of " in text
    assert "gyro_y: linear model of 0 states every 0.1 s, misfit " in text
    assert "σ of the model is" in text
    content = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert content["gyro_x"]["freedom"] == found["gyro_x"].freedom
    assert len(content["gyro_y"]["tau_s"]) == len(content["gyro_y"]["used"])
    assert len(found.plot().axes) == 2
    ax = found["gyro_x"].plot(unit="rad/s").axes[0]
    np.testing.assert_allclose(ax.lines[1].get_ydata(), np.sqrt(found["gyro_x"].avar))
    wrong = verify(NoiseModel(channels={"gyro_x": {**TERMS, "random_walk": 0.02}}), {"gyro_x": curves["gyro_x"]})
    assert "outside" in repr(wrong)


def test_many_averaging_times_are_thinned():
    y = np.random.default_rng(seed_of("verify all")).standard_normal(1000)
    curve = allan(Record.from_arrays(rate=RATE, gyro_x=y), taus="all")["gyro_x"]
    found = verify(ChannelModel(terms={"random_walk": RATE**-0.5}), curve)
    assert len(found.curve.m) <= 64
    assert found.freedom >= 7
    assert found.p_value > 1e-3


def test_what_is_refused():
    y = np.random.default_rng(seed_of("verify refused")).standard_normal(1000)
    model = ChannelModel(terms={"random_walk": 1.0})
    with pytest.raises(OptionError, match="rad/s"):
        verify(ChannelModel(terms={"random_walk": 1.0}, quantity="acceleration", unit="m/s^2"), curve_of(y))
    with pytest.raises(OptionError, match="overlap"):
        verify(model, allan(Record.from_arrays(rate=RATE, gyro_x=y), overlap="none")["gyro_x"])
    with pytest.raises(OptionError, match="`level`"):
        verify(model, curve_of(y), level=1.0)
    for wrong in ("1", -1.0, np.nan, True):
        with pytest.raises(OptionError, match="`tau_min` must be a number of seconds, 0 or more"):
            verify(model, curve_of(y), tau_min=wrong)
    with pytest.raises(OptionError, match="1 octaves"):
        verify(model, curve_of(y), tau_min=25.6)
    with pytest.raises(OptionError, match="gyro_x, which the model lacks"):
        verify(NoiseModel(channels={"gyro_y": {"random_walk": 1.0}}), {"gyro_x": curve_of(y)})
    y[100:120] = np.nan
    with pytest.raises(DataError, match="gaps, 20 of 1000 samples missing"):
        verify(model, curve_of(y))


def test_the_states_of_flicker_noise_are_no_misfit():
    """Of flicker noise alone the curve is known to 0.2 % at short times, and the states are right to 1 %."""
    model = NoiseModel(channels={"gyro_x": {"bias_instability": 1e-4}})
    found = []
    for k in range(8):
        record = simulate(model, duration=1310.72, rate=100, rng=seed_of(f"verify flicker {k}"))
        found.append(verify(model, allan(record))["gyro_x"].p_value)
    assert min(found) > 0.01
    wrong = NoiseModel(channels={"gyro_x": {"bias_instability": 1.1e-4}})
    assert verify(wrong, allan(record))["gyro_x"].p_value < 0.01
