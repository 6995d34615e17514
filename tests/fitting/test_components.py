"""What a fit is made of, against dense matrices and simulated records."""

import numpy as np
import pytest
from scipy.linalg import toeplitz
from studies.mixtures import crb
from studies.samples import simulated

from known import seed_of
from sigmatau._native import kernels
from sigmatau._native.gls import Components, Gls
from sigmatau.estimators.deviation_kinds import cluster_sizes
from sigmatau.noise.terms import NOISE, avar
from sigmatau.noise.uncertainty import avar_covariance, degrees_of_freedom

N = 1024
SIZES = tuple(int(m) for m in cluster_sizes("half", n=N, tau0=1.0) if m <= N // 3)
MIXTURE = {"quantization": 1.63, "random_walk": 1.0, "bias_instability": 0.188, "rate_random_walk": 0.0125}
THETA = np.array([MIXTURE[name] ** 2 for name in NOISE])


def curves_of(coefficients, case, records, n=N):
    rng = np.random.default_rng(seed_of(case))
    for _ in range(records):
        y = simulated(n, 1.0, coefficients, seed=int(rng.integers(1 << 62)))
        variances, ramps, _ = kernels.allan_variances(
            [y], np.array(SIZES), overlap="full", counting="standard", threads=1, names=["x"]
        )
        yield variances[0], ramps[0]


def test_expectation_and_covariance_are_those_of_uncertainty():
    parts = Components(N, SIZES)
    expected = sum(avar(name, c, m=SIZES, tau0=1.0) for name, c in MIXTURE.items())
    assert parts.design @ THETA == pytest.approx(expected, rel=1e-14)
    covariance = Gls(parts, expected).covariance(THETA)
    assert covariance == pytest.approx(avar_covariance(MIXTURE, n=N, m=SIZES, tau0=1.0), rel=1e-12)


@pytest.mark.parametrize("ramp", [0.0, 1e-3])
def test_degrees_of_freedom(ramp):
    parts = Components(N, SIZES)
    expected = degrees_of_freedom({**MIXTURE, "rate_ramp": ramp}, n=N, m=SIZES, tau0=1.0)
    assert parts.degrees_of_freedom(THETA, ramp=ramp) == pytest.approx(expected, rel=1e-12)


def test_gauss_markov_and_sinusoid_columns():
    process = Components(N, SIZES, correlation_time=12.5)
    assert process.design[:, 4] == pytest.approx(kernels.gauss_markov_avar(1.0, 12.5, np.array(SIZES), 1.0), rel=1e-14)
    line = Components(N, SIZES, frequency=0.12)
    assert line.design[:, 4] == pytest.approx(kernels.sinusoid_avar(1.0, 0.12, np.array(SIZES), 1.0), rel=1e-14)
    assert line.covariance([*THETA, 0.0]) == pytest.approx(Components(N, SIZES).covariance(THETA), rel=1e-14)


def test_a_long_correlation_time_is_a_rate_random_walk():
    """σ² = K² T_c/2; the covariances agree as far as the variances do."""
    parts = Components(N, SIZES, correlation_time=1e7)
    walk, process = np.array([0, 0, 0, 1.0, 0]), np.array([0, 0, 0, 0, 0.5e7])
    gls = Gls(parts, parts.design @ walk)
    assert parts.design @ process == pytest.approx(parts.design @ walk, rel=1e-3)
    assert gls.covariance(process) == pytest.approx(gls.covariance(walk), rel=1e-3)


def test_covariance_beside_a_sinusoid():
    """What a line adds to the covariance, by simulation: 8A²S/N times the shape of the line."""
    frequency, amplitude = 0.11, 3.0
    parts = Components(N, SIZES, frequency=frequency)
    rng = np.random.default_rng(seed_of("covariance beside a sinusoid"))
    rows = []
    for _ in range(1500):
        y = rng.standard_normal(N) + amplitude * np.sin(2 * np.pi * (frequency * np.arange(N) + rng.uniform()))
        variances, _, _ = kernels.allan_variances(
            [y], np.array(SIZES[:6]), overlap="full", counting="standard", threads=1, names=["x"]
        )
        rows.append(variances[0])
    theta = np.array([0, 1.0, 0, 0, amplitude**2])
    exact = np.diag(Gls(parts, parts.design @ theta).covariance(theta))[:6]
    measured = np.var(rows, axis=0, ddof=1)
    # A variance of 1500 draws is known to 3.7 %; the line is not quite periodic in the record.
    assert measured == pytest.approx(exact, rel=0.12)
    alone = np.diag(avar_covariance({"random_walk": 1.0}, n=N, m=SIZES[:6], tau0=1.0))
    assert (exact / alone).max() > 2


@pytest.mark.parametrize("term", ["random_walk", "bias_instability", "rate_random_walk"])
def test_variances_without_their_ramp(term):
    """Mean of what is left, for any weights, and variance, for the best, by simulation."""
    parts = Components(N, SIZES)
    theta = np.array([1.0 if name == term else 0.0 for name in NOISE])
    any_weights = np.zeros(len(SIZES))
    any_weights[-1] = 1.0
    gls = Gls(parts, np.ones(len(SIZES)))
    best = gls.ramp_weights(theta)
    records = list(curves_of({term: 1.0, "rate_ramp": 0.3}, f"without ramp {term}", 1000))
    for weights in (any_weights, best):
        rows = [Gls(parts, avars).without_ramp(weights, ramps).avar for avars, ramps in records]
        without = gls.without_ramp(weights, np.zeros(len(SIZES)))
        mean, variance = np.mean(rows, axis=0), np.var(rows, axis=0, ddof=1)
        expected = without.expected(theta)
        assert np.all(np.abs(mean - expected) <= 4.5 * np.sqrt(variance / len(rows)))
    # A variance of 1000 is known to 4.5 % and more where it is skewed; independent remainders are an approximation.
    assert variance == pytest.approx(np.diag(without.covariance(theta)), rel=0.25)


@pytest.mark.parametrize(
    ("truth", "active"),
    [
        ((100.0, 1.0, 0, 0), [0, 1]),
        ((0, 1.0, 0, 1e-2), [1, 3]),
        ((0, 1.0, 0.1, 0), [1, 2]),
        ((25.0, 0, 1.0, 0), [0, 2]),
        ((0, 1.0, 1.0, 0.1), [1, 2, 3]),
    ],
)
def test_cramer_rao_bound(truth, active):
    """Of independent modes against the information of the full covariance matrix of the differenced record.

    For terms that a thousand samples determine; the phase of quantization noise reaches one sample beyond each end, and
    flicker is not quite diagonal: 3 %.
    """
    n = 1000
    theta = np.array(truth, dtype=float)
    k = np.arange(n + 2)
    variogram = np.concatenate([[0.0], np.cumsum(4 / np.pi / (2 * k[1:] - 1))])  # of flicker, B = 1
    pad = np.zeros(n - 1)

    def second(f):  # autocovariance of the differences from that of the rates or half the variogram, to the sign
        return np.concatenate([[2 * f[0] - 2 * f[1]], 2 * f[1:n] - f[: n - 1] - f[2 : n + 1]])[: n - 1]

    rates = {0: np.concatenate([[2.0, -1.0], np.zeros(n)]), 1: np.concatenate([[1.0], np.zeros(n + 1)])}
    columns = [second(rates[0]), second(rates[1]), second(-variogram / 2), pad.copy()]
    columns[3][0] = 1.0
    matrices = [toeplitz(columns[p]) for p in active]
    inverse = np.linalg.inv(sum(theta[p] * m for p, m in zip(active, matrices, strict=True)))
    scaled = [inverse @ m for m in matrices]
    information = np.array([[0.5 * np.sum(a * b.T) for b in scaled] for a in scaled])
    exact = np.sqrt(np.diag(np.linalg.inv(information))) / (2 * theta[active])
    parts = Components(n, SIZES)
    assert crb(parts.spectra, parts.modes, theta) == pytest.approx(exact, rel=0.03)


def test_skewness():
    """Of the free estimate of a rate random walk beside white noise, by simulation."""
    parts = Components(N, SIZES)
    truth = np.array([0, 1.0, 0, 1e-5])
    _, sigma, skewness, weights = Gls(parts, parts.design @ truth, (1, 3)).score(3, 1e-5)
    rows = np.array([weights @ a for a, _ in curves_of(
        {"random_walk": 1.0, "rate_random_walk": 1e-5**0.5}, "skewness", 3000)])  # fmt: skip
    z = (rows - rows.mean()) / rows.std()
    # The standard error of the sample's skewness is some 0.2 for a law this skewed.
    assert skewness == pytest.approx(np.mean(z**3), abs=0.7)
    assert sigma == pytest.approx(rows.std(), rel=0.1)
    assert skewness > 0.7
