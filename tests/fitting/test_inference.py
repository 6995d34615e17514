"""The interval of a term against that of χ², and what a test detects."""

import numpy as np
import pytest
from scipy import stats

from sigmatau._native.gls import Components, Gls


def test_interval_of_a_single_term_is_that_of_chi2():
    """White noise alone, all information in one variance: [νa/χ²] within the skewed law's exactness."""
    n, sizes = 200, (1,)
    parts = Components(n, sizes)
    gls = Gls(parts, np.array([1.0]), (1,))
    _, found_low, found_high = gls.evidence(1, [0, 1.0, 0, 0], level=0.95)
    freedom = float(parts.degrees_of_freedom([0, 1.0, 0, 0], ramp=0.0)[0])
    low, high = (freedom / stats.chi2.ppf(q, freedom) for q in (0.975, 0.025))
    assert found_low == pytest.approx(low, rel=0.01)
    assert found_high == pytest.approx(high, rel=0.01)


def test_more_data_detect_less():
    theta = np.array([0, 1.0, 0.01, 0])
    least = []
    for n in (2**12, 2**14, 2**16):
        sizes = tuple(sorted({s << j for s in (1, 3) for j in range(17) if s << j <= n // 3}))
        parts = Components(n, sizes)
        half, most = (parts.detectable(3, theta, level=0.95, power=p) for p in (0.5, 0.9))
        assert half < most
        least.append(half)
    assert least[0] > least[1] > least[2]
