"""Means over blocks of samples, their covariance, and the temperature of blocks."""

import numpy as np
import pytest
from studies.selection_bias import autocovariance

from known import seed_of
from sigmatau import Record
from sigmatau._native import kernels
from sigmatau.fitting.block_temperature import between_steps, smoothed
from sigmatau.noise.terms import NOISE
from sigmatau.quality.samples.common import block_means


@pytest.mark.parametrize("term", NOISE)
@pytest.mark.parametrize("length", [1, 7, 100, 5000])
def test_variance_is_twice_the_allan_variance(term, length):
    """Identity: neighbouring means over T differ by twice AVAR(T); closed forms against closed forms, to rounding."""
    expected = 2 * kernels.term_avar(term, 1.0, [length], 1.0)[0]
    assert autocovariance(term, 3, length)[0] == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("term", NOISE)
def test_all_lags_make_the_allan_variance_of_many_blocks(term):
    """Identity: 2 AVAR(kL) = Σ w(l) γ(l), w the autocorrelation of the triangle 1 … k … 1 over k²."""
    length, k = 6, 100  # beyond lag 64, where the series of the flicker's covariance takes over
    triangle = np.convolve(np.ones(k), np.ones(k)) / k
    weights = np.correlate(triangle, triangle, "full")[len(triangle) - 1 :]
    gamma = autocovariance(term, len(weights), length)
    total = weights[0] * gamma[0] + 2 * weights[1:] @ gamma[1:]
    expected = 2 * kernels.term_avar(term, 1.0, [k * length], 1.0)[0]
    # The series is cut after its second term: 1e-7 of γ at lag 64; the rest is rounding, worst for quantization.
    assert total == pytest.approx(expected, rel=1e-5)


def test_means_with_gaps():
    x = np.arange(1005.0)
    x[:7] = x[20:24] = np.nan
    means = block_means(Record.from_arrays(rate=1.0, x=x).streams[0], "x", 10)
    assert means.shape == (100,)
    assert np.isnan(means[0])  # 3 of 10 samples
    assert means[1] == 14.5
    assert means[2] == pytest.approx(np.mean(x[24:30]))


def test_fine_and_noisy_thermometers():
    """Noise is smoothed, a clean one is left as it is, one that follows a walk is not flattened."""
    rng = np.random.default_rng(seed_of("smoothed"))
    slow = np.sin(2 * np.pi * np.arange(512) / 100)
    assert smoothed(slow) == pytest.approx(slow, abs=1e-3)
    noisy = slow + 0.3 * rng.standard_normal(512)
    assert np.std(smoothed(noisy) - slow) < 0.15
    walk = np.cumsum(rng.standard_normal(512))
    assert np.corrcoef(np.diff(smoothed(walk)), np.diff(walk))[0, 1] > 0.5
    at = np.arange(7200.0)
    assert between_steps(at, walk.repeat(15)[:7200]) == pytest.approx(walk.repeat(15)[:7200])
    ramp = 0.01 * at
    assert between_steps(at, np.round(ramp)) == pytest.approx(ramp, abs=0.02)
