"""Goodness of fit: its size with the right model, its power against a Gauss-Markov process, and the price of a process."""

import math

import numpy as np
import pytest
from scipy import stats
from scipy.signal import lfilter

from known import seed_of
from sigmatau import NoiseModel, Record, allan, fit, simulate
from sigmatau._native.gls import Components, Gls
from sigmatau.fitting.components import half_octaves
from sigmatau.units import to_si

N = 2**12
SIZES = half_octaves(1, N // 3)


def above(share, count):
    """A share and three standard errors of so many records."""
    return share + 3 * math.sqrt(share * (1 - share) / count)


@pytest.mark.parametrize(
    "truth",
    [
        {"random_walk": 1.0},
        {"rate_random_walk": 1.0},
        {"random_walk": 1.0, "bias_instability": 0.2, "rate_random_walk": 0.01},
    ],
)
def test_size(truth):
    """Twice the smaller of two p-values: never more often below a limit than it says, and not much less often."""
    rng, count, p = np.random.default_rng(seed_of(f"goodness {truth}")), 150, []
    parts, model = Components(N, SIZES), NoiseModel(channels={"gyro_x": truth})
    for _ in range(count):
        curve = allan(simulate(model, duration=N, rate=1.0, rng=rng), taus=SIZES, threads=1)["gyro_x"]
        gls = Gls(parts, curve.avar / curve.avar[0])
        p.append(gls.p_value(gls.fit()))
    for limit in (0.01, 0.05, 0.2):
        assert np.mean(np.array(p) < limit) <= above(limit, count)
    assert np.mean(np.array(p) < 0.4) >= 0.2 - 3 * math.sqrt(0.2 * 0.8 / count)


def test_a_freedom_less_for_each_coefficient():
    """Large degrees of freedom: the deviates are the errors over their standard deviations."""
    parts = Components(2**26, (1, 2, 4, 8, 16, 32))
    theta = np.array([0, 1.0, 0, 1e-12])
    expected, covariance = parts.design @ theta, parts.covariance(theta)
    errors = np.sqrt(np.diag(covariance)) * np.array([1, -1, 1, -1, 1.5, 1.0])
    misfit = errors @ np.linalg.solve(covariance, errors)
    assert Gls(parts, expected + errors).p_value(theta) == pytest.approx(2 * stats.chi2.sf(misfit, 6 - 2), rel=0.02)


def test_a_model_that_is_too_high():
    """Three times above the curve at the four longest octaves: the Allan deviations of a walk have 1 to 20 degrees."""
    parts = Components(N, SIZES)
    theta = np.array([0, 1.0, 0, 1e-4])
    measured = parts.design @ theta
    octaves = [k for k, m in enumerate(SIZES) if m.bit_count() == 1]
    measured[octaves[-4] :] /= 9
    assert Gls(parts, parts.design @ theta).p_value(theta) == 1.0
    assert Gls(parts, measured).p_value(theta) < 0.002


def test_deviance_of_a_single_variance_is_that_of_chi2():
    parts = Components(200, (1,))
    theta = np.array([0, 1.0, 0, 0])
    freedom = float(parts.degrees_of_freedom(theta, ramp=0.0)[0])
    a, b = (Gls(parts, np.array([x])).deviance(theta) for x in (0.8, 1.3))
    law = stats.chi2(freedom, scale=1 / freedom)
    assert a - b == pytest.approx(-2 * (law.logpdf(0.8) - law.logpdf(1.3)), rel=1e-6)


def process(n, tau0, time, sigma, rng):
    decay = math.exp(-tau0 / time)
    driven = rng.standard_normal(n) * math.sqrt(1 - decay**2) * sigma
    driven[0] /= math.sqrt(1 - decay**2)
    return lfilter([1], [1, -decay], driven)


def test_a_gauss_markov_process_is_no_walk():
    """20 deg/h, 100 s in 3 h: the terms alone are rejected, and the process is found; the model is nowhere far above."""
    rng = np.random.default_rng(seed_of("goodness: Gauss-Markov"))
    rate, n, count = 10.0, 108_000, 3
    white, sigma = to_si(0.3, "deg/sqrt(h)") * math.sqrt(rate), to_si(20, "deg/h")
    sizes = half_octaves(1, n // 3)
    rejected, found, covered, highest = 0, 0, [], []
    for _ in range(count):
        y = process(n, 1 / rate, 100.0, sigma, rng) + white * rng.standard_normal(n)
        curve = allan(Record.from_arrays(rate=rate, gyro_x=y, unit={"gyro": "rad/s"}), taus="half", threads=1)["gyro_x"]
        gls = Gls(Components(n, sizes), curve.avar[: len(sizes)] / curve.avar[0])
        rejected += gls.p_value(gls.fit()) < 0.002
        fitted = fit(curve)
        if fitted.gauss_markov:
            found += 1
            one = fitted.gauss_markov[0]
            covered += [one.sigma.low <= sigma <= one.sigma.high, one.time.low <= 100 <= one.time.high]
            highest.append(math.sqrt((fitted.avar(m=sizes) / curve.avar[: len(sizes)]).max()))
    least = count * (0.95 - 3 * math.sqrt(0.95 * 0.05 / count))
    assert rejected >= least
    assert found >= least
    assert np.mean(covered) >= 0.92 - 3 * math.sqrt(0.92 * 0.08 / found)
    # Before, up to 13: now what one slow mode does by chance.
    assert max(highest) < 4
