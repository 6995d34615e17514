"""The law of the statistic, the sharing of the tails, and an oracle for the whole interval."""

import math

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import brentq
from scipy.special import ndtr

from sigmatau.fitting.components import components
from sigmatau.fitting.gls import Gls
from sigmatau.fitting.inference import (
    _critical,
    _crossing,
    _feldman_cousins,
    detectable_theta,
    evidence,
    skewed_tails,
)


@pytest.mark.parametrize("skewness", [-2.0, -0.3, 1e-6, 0.05, 1.0, 3.0])
@pytest.mark.parametrize("z", [-3.0, -0.7, 0.0, 1.2, 4.0])
def test_tails_are_pearsons(z, skewness):
    law = stats.pearson3(skewness) if abs(skewness) > 1e-3 else stats.norm()
    below, above = skewed_tails(z, skewness)
    assert below == pytest.approx(law.cdf(z), rel=1e-6, abs=1e-12)
    assert above == pytest.approx(law.sf(z), rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("level", [0.68, 0.9, 0.95])
def test_acceptance_has_its_probability_and_order(level):
    ratios, shares = _feldman_cousins(level)
    assert shares[0] == pytest.approx(1 - level, abs=1e-4)
    assert shares[-1] == pytest.approx((1 - level) / 2, abs=1e-6)
    assert np.all(np.diff(shares) <= 1e-12)
    for mu, share in zip(ratios[::7], shares[::7], strict=True):
        upper = mu - stats.norm.ppf(share)
        lower = mu + stats.norm.ppf(1 - level - share + 1e-300) if share < 1 - level else -np.inf
        assert ndtr(upper - mu) - ndtr(lower - mu) == pytest.approx(level, abs=1e-9)
        # Both ends are as likely, over the best value that is not negative.
        if 0.1 < mu < 3:
            ratio = [stats.norm.pdf(x - mu) / stats.norm.pdf(x - max(x, 0)) for x in (lower, upper)]
            assert ratio[0] == pytest.approx(ratio[1], rel=1e-6)


def test_published_interval():
    """Feldman & Cousins (1998), Table X: a measurement of 0 with 90 %: [0, 1.64]; of 1: [0, 2.64]; of 2: [0.58, 3.64]."""
    ratios, shares = _feldman_cousins(0.9)
    mu = np.linspace(0.001, 4, 4000)
    share = np.interp(mu, ratios, shares)
    upper = mu - stats.norm.ppf(share)
    lower = mu + stats.norm.ppf(np.maximum(0.1 - share, 1e-300))
    for x, low, high in ((0.0, 0.0, 1.64), (1.0, 0.0, 2.64), (2.0, 0.58, 3.64)):
        inside = mu[(lower <= x) & (x <= upper)]
        assert inside.min() == pytest.approx(low, abs=0.006)
        assert inside.max() == pytest.approx(high, abs=0.006)


@pytest.mark.parametrize("skewness", [-1.9, -0.4, 1e-4, 0.4, 1.9])
@pytest.mark.parametrize("probability", [0.001, 0.05, 0.5])
def test_critical_deviate_inverts_the_tails(skewness, probability):
    """The normal law that stands for a skewness of 1e-4 is off by a sixth of it."""
    assert skewed_tails(_critical(skewness, probability), skewness)[1] == pytest.approx(probability, rel=1e-3)


@pytest.mark.parametrize(
    "f", [lambda x: x**3 - 2, lambda x: math.atan(50 * (x - 0.3)), lambda x: x - 1.7, lambda x: -math.expm1(5 - 40 * x)]
)
def test_root_is_that_of_brent(f):
    calls = []

    def counted(x):
        calls.append(x)
        return f(x)

    # Of the root, 1e-4, and of the upper end.
    assert _crossing(counted, 0.01, 2.0) == pytest.approx(brentq(f, 0.01, 2.0), abs=4e-4)
    assert len(calls) <= 18
    assert len(set(calls)) == len(calls)
    assert (_crossing(f, 1.9, 2.0), _crossing(f, 0.01, 0.02)) == (1.9, 0.02)


def test_interval_of_a_single_term_is_that_of_chi2():
    """White noise alone, all information in one variance: [νa/χ²] within the skewed law's exactness."""
    n, sizes = 200, (1,)
    parts = components(n, sizes)
    gls = Gls(parts, np.array([1.0]), (1,))
    found = evidence(gls, 1, np.array([0, 1.0, 0, 0]), level=0.95)
    freedom = float(parts.degrees_of_freedom(np.array([0, 1.0, 0, 0]), ramp=0.0)[0])
    low, high = (freedom / stats.chi2.ppf(q, freedom) for q in (0.975, 0.025))
    assert found.low == pytest.approx(low, rel=0.01)
    assert found.high == pytest.approx(high, rel=0.01)


def test_more_data_detect_less():
    theta = np.array([0, 1.0, 0.01, 0])
    least = []
    for n in (2**12, 2**14, 2**16):
        sizes = tuple(sorted({s << j for s in (1, 3) for j in range(17) if s << j <= n // 3}))
        parts = components(n, sizes)
        half, most = (
            detectable_theta(Gls(parts, parts.design @ theta), 3, theta, level=0.95, power=p) for p in (0.5, 0.9)
        )
        assert half < most
        least.append(half)
    assert least[0] > least[1] > least[2]
