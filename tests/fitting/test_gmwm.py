"""The generalised method of wavelet moments of the studies, which is written apart from the package, as its oracle."""

import math

import numpy as np
import pytest
from studies.gmwm import _covariance, _grid, expected_variances, gmwm, wavelet_variances
from studies.samples import simulated

from known import seed_of
from sigmatau import Record, allan, fit_channel
from sigmatau.noise import terms
from sigmatau.noise.terms import NOISE

HALVES = (1, 2, 4, 8, 16, 32, 64)


def test_wavelet_variances_are_half_the_allan_variances():
    x = np.random.default_rng(seed_of("gmwm variances")).standard_normal(3000)
    curve = allan(Record.from_arrays(rate=10, gyro_x=x, unit={"gyro": "rad/s"}), taus=np.array(HALVES) / 10)["gyro_x"]
    # Sums of 3000 terms lose 1e-13.
    assert wavelet_variances(x, HALVES) == pytest.approx(curve.avar / 2, rel=1e-11)


@pytest.mark.parametrize("term", NOISE)
def test_expected_variances_are_half_the_allan_variances(term):
    m = np.array([1, 2, 7, 1000, 20_000])
    expected = terms.avar(term, 1.0, m=m, tau0=0.02) / 2
    assert expected_variances(term, m, 0.02) == pytest.approx(expected, rel=1e-12)


def test_covariance_is_that_of_records():
    """Of white noise, at octaves of a long record: variances and correlations within 4 standard errors of 1000 records."""
    rng = np.random.default_rng(seed_of("gmwm covariance"))
    found = np.array([wavelet_variances(rng.standard_normal(4096), HALVES) for _ in range(1000)])
    stated = _covariance(np.ones_like(_grid(4096, HALVES)[0]), 4096, HALVES, 1.0)
    scale = np.sqrt(np.diag(stated))
    # 0.02 for the ends of the record, which the theory of long records leaves out, at 64 of 4096 samples.
    assert found.var(axis=0) / np.diag(stated) == pytest.approx(1.0, abs=4 * math.sqrt(2 / 1000) + 0.02)
    error = 4 / math.sqrt(1000) + 0.02
    assert np.corrcoef(found.T) == pytest.approx(stated / np.outer(scale, scale), abs=error)


def test_estimates_agree_with_the_likelihood():
    """Both from one record of N and K: within half of the interval of the likelihood, which is nearly efficient."""
    truth = {"random_walk": 1.0, "rate_random_walk": 0.02}
    x = simulated(2**15, 1.0, truth, seed=seed_of("gmwm and likelihood"))
    found = gmwm(x, list(truth), 1.0)
    fit = fit_channel(
        Record.from_arrays(rate=1, gyro_x=x, unit={"gyro": "rad/s"}), "gyro_x", terms=list(truth), processes=[]
    )
    for term in truth:
        estimate = fit[term]
        assert abs(found[term] - estimate.value) < (estimate.high - estimate.low) / 2, term
