"""Arrays with known answers: closed forms, the classical hat, and a likelihood written out in full."""

import math
from itertools import combinations

import allantools
import numpy as np
import pytest

import sigmatau as st
from known import seed_of
from sigmatau.lab.arrays.array_fit import Conditions, fit_array, without_drifts
from sigmatau.lab.arrays.codeviation import allan_covariances, hat_curves
from sigmatau.lab.arrays.components import Component, densities
from sigmatau.lab.arrays.cosine_bands import cosine_transform, gather_bands
from sigmatau.lab.arrays.covariance_fit import full_structure
from sigmatau.lab.arrays.weights import optimal_vector

N = 1e-4


def gyros(name, count, *, r=0.0, duration=600, walk=None, sizes=None):
    """Simulated array: white noise with one correlation of all pairs, and independent rate random walks."""
    names = [f"gyro_{k}" for k in range(count)]
    sizes = sizes or [1.0] * count
    terms = [{"random_walk": N * size} | ({} if walk is None else {"rate_random_walk": walk * size}) for size in sizes]
    pairs = dict.fromkeys(combinations(names, 2), r) if r else {}
    model = st.NoiseModel(
        channels=dict(zip(names, terms, strict=True)), correlation={"random_walk": pairs} if pairs else {}
    )
    return st.simulate(model, duration=duration, rate=20, rng=seed_of(name))


def samples_of(record):
    return np.stack([record.stream_of(name).column(name) for name in record.channels])


@pytest.mark.parametrize("count", [2, 3, 5])
def test_equal_independent_sensors(count):
    """The mean of n equal sensors has 1/√n of their noise; weights that differ from 1/n would gain nothing."""
    array = st.analyze_array(gyros(f"equal {count}", count))
    walk = array.virtual.coefficients["random_walk"]
    assert walk.low <= N / math.sqrt(count) <= walk.high
    assert not array.virtual.weights.differ
    assert array.virtual.weights.vector.sum() == pytest.approx(1, abs=1e-12)


def test_negative_correlation_is_better_than_independence():
    """w'Cw = N²(1 + (n − 1)·r)/n: r = −0.3 and n = 3 give 0.4/3, less than 1/3."""
    array = st.analyze_array(gyros("negative", 3, r=-0.3))
    walk = array.virtual.coefficients["random_walk"]
    assert walk.low <= N * math.sqrt(0.4 / 3) <= walk.high
    assert walk.high < N / math.sqrt(3)
    assert all(each.correlated and each.value < 0 for each in array.correlations["random_walk"].values())


def test_unequal_sensors():
    """Weights of independent sensors are as 1/N²."""
    array = st.analyze_array(gyros("unequal", 3, sizes=[1, 2, 4]))
    expected = np.array([16, 4, 1]) / 21
    for each, truth in zip(array.virtual.weights.values, expected, strict=True):
        assert each.low <= truth <= each.high
    gain = array.virtual.weights.gain
    assert gain.low <= math.sqrt(21 / 16) <= gain.high
    assert array.virtual.weights.differ


def test_target_is_a_time():
    """At a long time, the weights follow the rate random walks, not the white noise."""
    names = ["gyro_0", "gyro_1", "gyro_2"]
    model = st.NoiseModel(
        channels={
            name: {"random_walk": n * N, "rate_random_walk": k * 1e-4}
            for name, n, k in zip(names, (1, 2, 2), (3, 1, 1), strict=True)
        }
    )
    record = st.simulate(model, duration=3600, rate=20, rng=seed_of("target"))
    short = st.analyze_array(record).virtual.weights.vector
    long = st.analyze_array(record, target=60.0).virtual
    assert short[0] > 0.6
    assert long.weights.vector[0] < 0.2
    assert long.target == "deviation at 60 s"
    assert long.curve.agrees


def test_allan_covariance_is_the_direct_sum():
    """½⟨Δȳ₁Δȳ₂⟩ of all overlapping pairs of clusters, written as its definition."""
    rng = np.random.default_rng(seed_of("direct"))
    x = rng.standard_normal((2, 200)) + 0.5 * rng.standard_normal(200)
    m = np.array([1, 2, 8, 32])
    curve = allan_covariances(("a", "b"), x, 0.1, 0.1 * m, np.full((2, 4), 20.0), level=0.95)[0]
    for k, size in enumerate(m):
        means = np.stack([np.convolve(each, np.ones(size) / size, mode="valid") for each in x])
        steps = means[:, size:] - means[:, :-size]
        assert curve.covariance[k] == pytest.approx(0.5 * np.mean(steps[0] * steps[1]), rel=1e-10)
    assert (curve.low < curve.covariance).all()
    assert (curve.covariance < curve.high).all()
    assert (np.abs(curve.correlation) <= 1).all()


def test_three_cornered_hat_is_that_of_allantools():
    rng = np.random.default_rng(seed_of("hat"))
    x = np.array([[1.0], [1.5], [3.0]]) * rng.standard_normal((3, 2000)) + 5 * rng.standard_normal(2000)
    m = np.array([1, 4, 16])
    curves = hat_curves(("a", "b", "c"), x, 1.0, m * 1.0, np.full(3, 100.0), level=0.95)
    phase = np.concatenate([np.zeros((3, 1)), np.cumsum(x, axis=1)], axis=1)
    result = allantools.three_cornered_hat_phase(
        phase[0] - phase[1], phase[1] - phase[2], phase[2] - phase[0], rate=1.0, taus=m * 1.0, function=allantools.oadev
    )
    assert np.sqrt(curves[0].variance) == pytest.approx(np.asarray(result[1]), rel=1e-9)  # sums of 2000 phases


def test_hat_of_more_sensors_solves_all_pairs():
    """With an exact structure, AVAR(x_i − x_j) = d_i + d_j, least squares returns d."""
    rng = np.random.default_rng(seed_of("pairs"))
    x = np.array([[1.0], [2.0], [3.0], [4.0]]) * rng.standard_normal((4, 40_000)) + rng.standard_normal(40_000) * 10
    curves = hat_curves(("a", "b", "c", "d"), x, 1.0, np.array([1.0]), np.array([26_000.0]), level=0.999)
    for curve, size in zip(curves, (1, 2, 3, 4), strict=True):
        assert curve.low[0] <= size <= curve.high[0]


def test_upper_limit_of_a_hat_is_one_sided():
    """A limit at 95 % is the upper end of the two-sided interval at 90 %."""
    rng = np.random.default_rng(seed_of("limit of a hat"))
    samples = rng.standard_normal((3, 4096)) * np.array([[1.0], [1.0], [0.01]])
    tau = 2.0 ** np.arange(6)
    names, edf = ("a", "b", "c"), np.full(len(tau), 5.0)
    quiet = hat_curves(names, samples, 1.0, tau, edf, level=0.95)[2]
    assert np.isfinite(quiet.upper_limit).all()
    assert quiet.upper_limit == pytest.approx(hat_curves(names, samples, 1.0, tau, edf, level=0.9)[2].high)


def test_hat_by_likelihood():
    """A common walk a hundred times larger than the noise does not reach the coefficients."""
    record = gyros("hat by likelihood", 4, sizes=[1, 1, 2, 3])
    x = samples_of(record) + np.cumsum(np.random.default_rng(seed_of("table")).standard_normal(12_000)) * 0.1
    array = st.analyze_array(st.Record.from_arrays(rate=20, **dict(zip(record.channels, x, strict=True))), common=True)
    for each, size in zip(array.coefficients["random_walk"].values(), (1, 1, 2, 3), strict=True):
        assert each.low <= size * N <= each.high
    assert array.correlations == {}
    assert len(array.hat) == 4
    assert "N-cornered hat" in repr(array)


def test_transform_is_that_of_scipy():
    from scipy.fft import dct

    x = np.random.default_rng(seed_of("transform")).standard_normal((2, 1001))
    assert cosine_transform(x) == pytest.approx(dct(x, type=2, norm="ortho"), abs=1e-12)


@pytest.mark.parametrize("term", ["random_walk", "bias_instability", "rate_random_walk", "quantization"])
def test_densities_are_the_variances_of_the_transform(term):
    """From the generalised covariance of the model: c'Rc for the vectors c of the transform, which have the sum 0."""
    n, tau0 = 256, 0.5
    model = st.ChannelModel(terms={term: 1.0}, quantity="signal", unit="1")
    lags = np.arange(n + 1)
    phase = model.phase_autocovariance(lags, tau0=tau0)
    rate = (2 * phase[:-1] - phase[1:] - np.concatenate([phase[1:2], phase[:-2]])) / tau0**2
    matrix = rate[np.abs(np.subtract.outer(np.arange(n), np.arange(n)))]
    basis = cosine_transform(np.eye(n))  # column k: the vector of frequency k
    expected = np.einsum("ik,ij,jk->k", basis, matrix, basis)
    computed = densities((Component(name=term),), n, tau0)[0]
    # The average of a walk within a sample, and the ends of flicker at high frequencies, are left out: 1 % and less.
    low = slice(1, 32)
    assert computed[low] == pytest.approx(expected[low], rel=0.012)


def test_likelihood_of_single_frequencies():
    """Without bands and regressors, the estimate of white noise alone is the mean of the squares of the transform."""
    x = np.random.default_rng(seed_of("single")).standard_normal((3, 2048))
    components = (Component(name="random_walk"),)
    fit = fit_array(x, 1.0, components, np.ones((1, 3)), common=False, conditions=Conditions())
    y = cosine_transform(x)[:, 1:]
    # The ramp that is eliminated takes one frequency: its transform is orthogonal to all others only in part.
    assert fit.matrices[0] == pytest.approx(y @ y.T / 2047, abs=0.003)
    assert fit.structure is full_structure(3)


def test_ramps_do_not_matter():
    """The restricted likelihood does not change if a ramp is added to a channel."""
    x = np.cumsum(np.random.default_rng(seed_of("ramp")).standard_normal((2, 2048)), axis=1)
    components = (Component(name="rate_random_walk"),)
    ramp = np.outer([5.0, -2.0], np.arange(2048))
    fits = [
        fit_array(each, 1.0, components, np.ones((1, 2)), common=False, conditions=Conditions())
        for each in (x, x + ramp)
    ]
    assert fits[0].matrices == pytest.approx(fits[1].matrices, rel=1e-6)
    assert gather_bands(x, 1.0).samples == 2048


def test_optimal_vector_has_a_closed_form():
    matrix = np.array([[2.0, 0.5], [0.5, 1.0]])
    assert optimal_vector(matrix) == pytest.approx([0.25, 0.75])


def test_signals_of_any_kind_are_an_array():
    """Voltage references: the unit goes through, and the fused record is a signal."""
    x = 1e-6 * np.random.default_rng(seed_of("references")).standard_normal((3, 4000))
    unit = {f"ref_{k}": "V" for k in "abc"}
    record = st.Record.from_arrays(rate=1, unit=unit, ref_a=x[0], ref_b=x[1], ref_c=x[2])
    array = st.analyze_array(record)
    assert (array.quantity, array.unit) == ("signal", "V")
    assert array.fused_record.stream_of("ref_virtual").unit == "V"
    assert array.virtual.model["ref_virtual"].unit == "V"
    assert "3 sensors at 1 Hz" in repr(array)
    common = st.analyze_array(record, common=True)
    assert common.coefficients["random_walk"]["ref_a"].observed


def test_excluded_bands_leave_the_rest():
    """Around a resonance and a line, frequencies are left out, and white noise is estimated from the others."""
    x = np.random.default_rng(seed_of("excluded")).standard_normal((2, 8192))
    x += 20 * np.sin(2 * np.pi * 0.11 * np.arange(8192))
    bands = gather_bands(x, 1.0, lines=[0.11], excluded=[(0.2, 0.3)], highest=0.4)
    used = np.flatnonzero(bands.used) / (2 * 8192)
    assert used.max() == pytest.approx(0.4, abs=1e-3)
    assert not ((used > 0.2) & (used < 0.3)).any()
    assert not (abs(used - 0.11) < 0.002).any()
    assert bands.count.sum() == bands.used.sum() == pytest.approx(8192 * 0.6, rel=0.02)
    conditions = Conditions(highest=0.4, lines=(0.11,), resonances=((0.2, 0.3),))
    white = (Component(name="random_walk"),)
    fit = fit_array(
        without_drifts(x, 1.0, conditions), 1.0, white, np.ones((1, 2)), common=False, conditions=conditions
    )
    assert np.diag(fit.matrices[0]) == pytest.approx(1, abs=4 * np.sqrt(2 / bands.count.sum()))
