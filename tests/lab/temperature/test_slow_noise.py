"""Generalised least squares in coloured noise: its algebra, and the size of its intervals."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import ChannelModel
from sigmatau.lab.temperature.slow_noise import fit_slow_noise

N, SAMPLES = 90, 7


def block_covariance(terms):
    """Covariance of centred block means from that of the phase at the borders: a slow twin, block by block."""
    model = ChannelModel(quantity="angular_rate", terms=terms)

    def s(lag):
        return float(model.phase_autocovariance([abs(lag) * SAMPLES], tau0=1.0)[0])

    table = [[s(i - j) * 2 - s(i - j + 1) - s(i - j - 1) for j in range(N)] for i in range(N)]
    centre = np.eye(N) - 1 / N
    return centre @ np.array(table) @ centre / SAMPLES**2


def columns():
    u = np.linspace(-1, 1, N)
    return np.column_stack([np.ones(N), u, u**2])


def test_the_mean_of_a_record_is_its_bias_without_an_error():
    """Noise is taken about its mean, so that a model with a constant alone leaves nothing to estimate."""
    means = np.random.default_rng(seed_of("mean of block means")).normal(size=N)
    fit = fit_slow_noise(means, np.ones((N, 1)), np.arange(N), samples=SAMPLES, white=1.0)
    assert fit.coefficients[0] == pytest.approx(means.mean(), abs=1e-12)
    assert abs(fit.covariance[0, 0]) < 1e-12


def test_the_model_itself_is_found_exactly_and_a_shift_moves_the_constant_alone():
    rng = np.random.default_rng(seed_of("exact least squares"))
    noise = rng.normal(size=N)
    truth = np.array([3.0, -2.0, 0.5])
    bare = fit_slow_noise(noise, columns(), np.arange(N), samples=SAMPLES)
    shifted = fit_slow_noise(noise + columns() @ truth + 1e6, columns(), np.arange(N), samples=SAMPLES)
    assert shifted.coefficients == pytest.approx(bare.coefficients + truth + [1e6, 0, 0], abs=1e-8)
    assert shifted.covariance == pytest.approx(bare.covariance, rel=1e-6)  # digits that 1e6 leaves
    scaled = fit_slow_noise(1e-9 * noise, columns(), np.arange(N), samples=SAMPLES)
    assert scaled.covariance == pytest.approx(1e-18 * bare.covariance, rel=1e-9)


def test_the_covariance_is_that_of_the_estimator_in_white_noise():
    """In white noise alone the errors are at least those of ordinary least squares, and larger for a walk that it hides."""
    rng = np.random.default_rng(seed_of("white least squares"))
    result = fit_slow_noise(rng.normal(size=N), columns(), np.arange(N), samples=SAMPLES, white=1.0)
    inverse = np.linalg.inv(columns().T @ columns())
    inverse[0, 0] -= 1 / N  # the mean of the noise is part of the constant
    ratio = np.sqrt(np.diag(result.covariance)[1:] / np.diag(inverse)[1:])
    assert (ratio > 0.95).all()
    assert (ratio < 6).all()


@pytest.mark.parametrize("terms", [{"rate_random_walk": 1.0}, {"bias_instability": 1.0}])
def test_the_noise_of_one_term_has_its_covariance(terms):
    """A record of slow noise alone: the stated covariance is that of the term, within the error of its size."""
    covariance = block_covariance(terms)
    rng = np.random.default_rng(seed_of(f"slow noise {sorted(terms)}"))
    root = np.linalg.cholesky(covariance + np.full((N, N), 1 / N))
    ratios = []
    for _ in range(20):
        e = root @ rng.normal(size=N)
        stated = fit_slow_noise(e - e.mean(), columns(), np.arange(N), samples=SAMPLES).noise
        ratios.append(np.trace(stated) / np.trace(covariance))
    # A sum of squares of 90 values has an error of 15 %; slow noise of other exponents has half to twice the power.
    assert 0.6 < np.median(ratios) < 2.5


def test_missing_blocks_widen_the_interval():
    rng = np.random.default_rng(seed_of("missing blocks"))
    means = rng.normal(size=N)
    whole = fit_slow_noise(means, columns(), np.arange(N), samples=SAMPLES, white=1.0)
    kept = np.r_[0:30, 60:N]
    part = fit_slow_noise(means[kept], columns()[kept], kept, samples=SAMPLES, white=1.0)
    assert part.covariance[2, 2] > whole.covariance[2, 2]
    assert part.noise.shape == (len(kept), len(kept))


def test_coverage_small():
    """Share of 95 % intervals that contain 0, with all three terms: 120 sets, 3 standard errors of the simulation."""
    covariance = block_covariance({"random_walk": 3.0, "bias_instability": 1.0, "rate_random_walk": 0.05})
    root = np.linalg.cholesky(covariance + np.full((N, N), 1e-9))
    rng = np.random.default_rng(seed_of("coverage of slow noise"))
    hits, sets = 0, 120
    for _ in range(sets):
        result = fit_slow_noise(
            root @ rng.normal(size=N), columns(), np.arange(N), samples=SAMPLES, white=9.0 / SAMPLES
        )
        hits += abs(result.coefficients[1]) <= 1.96 * np.sqrt(result.covariance[1, 1])
    assert hits / sets >= 0.95 - 3 * np.sqrt(0.95 * 0.05 / sets)
