"""Own non-negative least squares against SciPy's, on columns as parallel as those of a fit."""

import numpy as np
import pytest
from scipy.optimize import nnls

from known import seed_of
from sigmatau._native.gls import non_negative


@pytest.mark.parametrize("columns", range(1, 7))
def test_it_is_scipys(columns):
    rng = np.random.default_rng(seed_of(f"nnls {columns}"))
    bound = 0
    for _ in range(200):
        x = np.geomspace(1, 1000, 20)[:, None]
        design = x ** rng.uniform(-2, 1, columns) * 10.0 ** rng.integers(-20, 20, columns)
        target = rng.standard_normal(20) + rng.uniform(-1, 1)
        found, residual = non_negative(design, target), nnls(design / np.linalg.norm(design, axis=0), target)[1]
        assert found.min() >= 0
        bound += int((found == 0).sum())
        # The sum of squares is what is least; columns that are nearly parallel may share it in another way.
        assert np.linalg.norm(design @ found - target) == pytest.approx(residual, rel=1e-9)
    assert bound > 0


def test_nothing_helps():
    assert non_negative(np.ones((5, 2)), -np.ones(5)).tolist() == [0, 0]
    assert non_negative(np.empty((5, 0)), np.ones(5)).shape == (0,)
