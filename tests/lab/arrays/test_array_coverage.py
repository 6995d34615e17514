"""Coverage of intervals, and the check on the second half, in small; studies/arrays.py has the large version."""

import math
from itertools import combinations

import numpy as np

from known import seed_of
from sigmatau.lab.arrays.array_fit import Conditions, estimate_coefficients, estimate_correlations, fit_array
from sigmatau.lab.arrays.components import Component
from sigmatau.lab.arrays.fusing import FittedArray, make_virtual
from sigmatau.lab.arrays.weights import estimate_weights, optimal_vector

SETS, N = 150, 4096
COMPONENTS = (Component(name="random_walk"), Component(name="rate_random_walk"))
SHAPE = np.array([[1.0, 0.4, 0.0], [0.4, 1.0, 0.2], [0.0, 0.2, 2.0]])
NAMES = ("a", "b", "c")


def is_covered(share, sets, *, level=0.95):
    return abs(share - level) <= 3 * math.sqrt(level * (1 - level) / sets)


def simulated(rng, white, walk):
    """White noise and a random walk with these covariance matrices, at 1 Hz."""
    roots = [np.linalg.cholesky(each) for each in (white, walk)]
    noise = rng.standard_normal((2, 3, N))
    return roots[0] @ noise[0] + np.cumsum(roots[1] @ noise[1], axis=1)


def contains(each, truth):
    return truth <= each.upper_limit if each.value is None else each.low <= truth <= each.high


def test_intervals_of_matrices_and_weights():
    rng = np.random.default_rng(seed_of("matrices and weights"))
    truth = (SHAPE, 0.01 * np.diag([1.0, 2.0, 1.0]))
    hits = {"variance": [], "correlation": [], "weight": []}
    for _ in range(SETS):
        x = simulated(rng, *truth)
        fit = fit_array(x, 1.0, COMPONENTS, np.array([[1.0] * 3, [0.01] * 3]), common=False, conditions=Conditions())
        values = estimate_coefficients(NAMES, fit, COMPONENTS, 1.0, 0.95, ["", ""])
        pairs = estimate_correlations(NAMES, fit, COMPONENTS, values, 1.0, 0.95)
        for t, component in enumerate(COMPONENTS):
            sizes = np.sqrt(np.diag(truth[t]))
            for k, name in enumerate(NAMES):
                hits["variance"].append(contains(values[component.name][name], sizes[k]))
            for (i, j), each in zip(combinations(range(3), 2), pairs[component.name].values(), strict=True):
                hits["correlation"].append(contains(each, truth[t][i, j] / (sizes[i] * sizes[j])))
            weights = estimate_weights(fit, np.eye(2)[t], level=0.95, widening=1.0)
            expected = optimal_vector(truth[t])
            hits["weight"] += [contains(a, b) for a, b in zip(weights.values, expected, strict=True)]
    for name, each in hits.items():
        assert is_covered(np.mean(each), 2 * SETS), (name, np.mean(each))  # six of a set count as two


def test_intervals_of_a_hat():
    rng = np.random.default_rng(seed_of("intervals of a hat"))
    truth = (np.diag([1.0, 1.0, 4.0]), 0.01 * np.diag([1.0, 2.0, 1.0]))
    hits = []
    for _ in range(SETS):
        x = simulated(rng, *truth) + 10 * np.cumsum(rng.standard_normal(N))
        fit = fit_array(x, 1.0, COMPONENTS, np.array([[2.0] * 3, [0.01] * 3]), common=True, conditions=Conditions())
        values = estimate_coefficients(NAMES, fit, COMPONENTS, 1.0, 0.95, ["", ""])
        for t, component in enumerate(COMPONENTS):
            for k, name in enumerate(NAMES):
                hits.append(contains(values[component.name][name], math.sqrt(truth[t][k, k])))
    assert is_covered(np.mean(hits), 2 * SETS), np.mean(hits)


def test_independent_sensors_are_not_called_correlated():
    rng = np.random.default_rng(seed_of("independent"))
    truth = (np.eye(3), 0.01 * np.eye(3))
    alarms = 0
    for _ in range(SETS):
        x = simulated(rng, *truth)
        fit = fit_array(x, 1.0, COMPONENTS, np.array([[1.0] * 3, [0.01] * 3]), common=False, conditions=Conditions())
        values = estimate_coefficients(NAMES, fit, COMPONENTS, 1.0, 0.95, ["", ""])
        pairs = estimate_correlations(NAMES, fit, COMPONENTS, values, 1.0, 0.95)
        alarms += any(each.correlated for by in pairs.values() for each in by.values())
    assert alarms / SETS <= 0.05 + 3 * math.sqrt(0.05 * 0.95 / SETS)


def test_second_half_is_in_the_band_of_the_first():
    rng = np.random.default_rng(seed_of("second half"))
    inside = []
    for _ in range(SETS):
        x = simulated(rng, np.eye(3), 1e-4 * np.eye(3))
        first = np.array([[1.0] * 3, [1e-4] * 3])
        fit = fit_array(x, 1.0, COMPONENTS, first, common=False, conditions=Conditions())
        array = FittedArray(
            samples=x, tau0=1.0, components=COMPONENTS, first=first, conditions=Conditions(), fit=fit,
            widening=1.0, level=0.95, common=False,
        )  # fmt: skip
        names = {"channel": "gyro_x", "quantity": "angular_rate", "unit": "rad/s", "units": ["", ""]}
        inside.append(make_virtual(array, "random_walk", **names).second_half.agrees)
    assert np.mean(inside) >= 0.95 - 3 * math.sqrt(0.05 * 0.95 / SETS)
