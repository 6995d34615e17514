"""Standard deviations of means: known answers, missing samples, and the coverage of their intervals."""

import math

import numpy as np
import pytest
from scipy.stats import chi2

from known import seed_of
from sigmatau import NoiseModel, Record, analyze, simulate
from sigmatau.fitting.mean_stability import mean_stability, quantile
from sigmatau.noise import terms


def stream_of(x, rate=10.0):
    (stream,) = Record.from_arrays(rate=rate, gyro=x, unit={"gyro": "rad/s"}).streams
    return stream


def test_it_is_the_std_of_the_means():
    x = np.random.default_rng(seed_of("std of means")).standard_normal(4_037) + 1e6
    ten, hundred = mean_stability(stream_of(x), "gyro", None, averages=(1.0, 10.0))
    assert (ten.average, ten.means) == (1.0, 403)
    # Of a mean of 10 about 1e6 in doubles.
    assert ten.value == pytest.approx(np.std(x[:4030].reshape(-1, 10).mean(axis=1), ddof=1), rel=1e-9)
    assert hundred.value == pytest.approx(np.std(x[:4000].reshape(-1, 100).mean(axis=1), ddof=1), rel=1e-9)
    assert (ten.low, ten.high, ten.edf) == (None, None, None)


def test_missing_samples():
    x = np.random.default_rng(seed_of("missing in means")).standard_normal(1_000)
    x[3:8] = np.nan  # half of the first mean: it stays
    x[20:26] = np.nan  # more than half of the third
    (found,) = mean_stability(stream_of(x), "gyro", None, averages=(1.0,))
    means = [np.nanmean(part) for k, part in enumerate(x.reshape(-1, 10)) if k != 2]
    assert found.means == 99
    assert found.value == pytest.approx(np.std(means, ddof=1), rel=1e-12)


def test_too_few_means_state_nothing():
    assert mean_stability(stream_of(np.arange(950.0)), "gyro", None) == ()
    assert len(mean_stability(stream_of(np.arange(1_000.0)), "gyro", None)) == 1


@pytest.mark.parametrize("n", [3, 10, 100, 1000])
@pytest.mark.parametrize("probability", [0.025, 0.5, 0.975])
def test_quantiles_of_chi2(n, probability):
    """Equal modes: χ². The saddlepoint approximation is within 0.6 % from three modes on."""
    assert quantile(np.ones(n), np.zeros(n), probability) == pytest.approx(chi2.ppf(probability, n), rel=0.006)


def test_quantiles_of_a_random_walk():
    """Modes in 1/j²: the distribution of Cramér and von Mises, T. W. Anderson & D. A. Darling (1952), table 1."""
    weights = 1 / (np.arange(1, 2_000) * math.pi) ** 2
    for probability, value in ((0.5, 0.11888), (0.9, 0.34730), (0.95, 0.46136), (0.99, 0.74346)):
        assert quantile(weights, np.zeros_like(weights), probability) == pytest.approx(value, rel=0.035)


def test_a_drift_is_part_of_it():
    """A noncentral χ²: its mean is n + d."""
    n, d = 20, 30.0
    shifts = np.zeros(n)
    shifts[0] = d
    from scipy.stats import ncx2

    for probability in (0.025, 0.5, 0.975):
        # Standard normal modes with a mean: exact, and the approximation is as good as for χ² of 20.
        assert quantile(np.ones(n), shifts, probability) == pytest.approx(ncx2.ppf(probability, n, d), rel=0.002)


CASES = {
    "white": {"random_walk": 1e-3},
    "with flicker noise": {"random_walk": 1e-3, "bias_instability": 3e-4},
    "with a random walk": {"random_walk": 1e-3, "bias_instability": 3e-4, "rate_random_walk": 1.5e-5},
}


@pytest.mark.parametrize("case", CASES)
def test_intervals_cover(case):
    """256 means of 10 s at 1 Hz; √E[s²] by the sum of Allan variances (n/(n − 1) times half of it for 2^k means)."""
    model, means, trials = CASES[case], 256, 24
    steps = np.array([10 << j for j in range(8)])
    total = sum(terms.avar(name, value, m=steps, tau0=1.0) for name, value in model.items())
    truth = math.sqrt(means / (means - 1) * float(np.sum(total)) / 2)
    rng = np.random.default_rng(seed_of(f"coverage of means {case}"))
    covered = 0
    for _ in range(trials):
        noise = NoiseModel(channels={"gyro_x": model})
        one = analyze(simulate(noise, duration=2560, rate=1, rng=rng)).mean_stability["gyro_x"][0]
        assert one.means == means
        covered += one.low <= truth <= one.high
    # At least 95 %, less three standard errors of so many records; docs/study/mean-stability.md has 500.
    assert covered / trials >= 0.95 - 3 * math.sqrt(0.95 * 0.05 / trials)


def test_it_is_in_the_json_and_the_long_table():
    rng = np.random.default_rng(seed_of("means in the json"))
    analysis = analyze(simulate(NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}}), duration=600, rate=10, rng=rng))
    (row,) = analysis.to_dict()["channels"]["gyro_x"]["mean_stability"]
    assert row["average_s"] == 10
    assert row["low"] < row["value"] < row["high"]
    # White noise: 60 independent means.
    assert row["edf"] == pytest.approx(59, rel=0.05)
    assert "STD of 10 s means" in analysis.summary()
