"""The likelihood against an exact one: the dense covariance of the samples (studies/exact.py)."""

import math

import numpy as np
import pytest
from studies.exact import TERMS, Exact
from studies.samples import simulated

from known import seed_of
from sigmatau._native.likelihood import summarize

N = 512  # the shortest record whose likelihood is used: where approximations are worst
RECORDS = 4
MIXTURES = {
    "N": {"random_walk": 1.0},
    "Q N": {"quantization": 1.0, "random_walk": 0.3},
    "N B": {"random_walk": 1.0, "bias_instability": 0.5},
    "N K": {"random_walk": 1.0, "rate_random_walk": 0.1},
    "Q K": {"quantization": 1.0, "rate_random_walk": 0.02},
}
TENTH = 0.1  # standard errors


@pytest.fixture(scope="module")
def exact():
    return Exact(N, 1.0)


def test_variograms_are_those_of_the_densities(exact):
    """γ(d) = ∫ S (1 − cos 2πfd) df, the densities as the theory page has them."""
    f = (np.arange(200_000) + 0.5) / 400_000
    square = np.sin(np.pi * f) ** 2
    densities = {
        "quantization": 4 * square,
        "random_walk": np.ones_like(f),
        "bias_instability": 1 / (2 * np.sqrt(square)),
        "rate_random_walk": 1 / (4 * square),
    }
    for d in (1, 2, 5):
        contrast = np.zeros(N)
        contrast[[0, d]] = 1, -1
        z = exact.contrasts @ contrast
        for name, density in densities.items():
            half = 0.5 * z @ exact.parts[name] @ z
            assert half == pytest.approx(2 * np.mean(density * (1 - np.cos(2 * np.pi * f * d))) / 2, rel=1e-5), (
                name,
                d,
            )


@pytest.mark.parametrize("name", MIXTURES)
def test_estimates_are_those_of_the_exact_likelihood(exact, name):
    """To a tenth of a standard error, root mean square over the records in which the true terms are found."""
    mixture = MIXTURES[name]
    terms = tuple(term for term in TERMS if term in mixture)
    truth = np.array([mixture[term] ** 2 for term in terms])
    information = exact.information(terms, truth)
    errors = np.sqrt(np.diag(np.linalg.inv(information)))
    rng = np.random.default_rng(seed_of(f"exact {name}"))
    off = []
    for _ in range(RECORDS):
        y = simulated(N, 1.0, mixture, seed=int(rng.integers(1 << 62)))
        found = summarize([y], samples=N, tau0=1.0).fit()
        model = {term: value**2 for term, value in found.model if term in TERMS}
        if model.keys() != set(terms):
            continue
        theta = np.array([model[term] for term in terms])
        off.append((theta - exact.fit(y, terms, theta, information).theta) / errors)
    assert len(off) >= RECORDS // 2
    assert np.sqrt(np.mean(np.square(off), axis=0)).max() <= TENTH * (1 + 3 / math.sqrt(2 * len(off)))


def test_intervals_end_where_the_exact_likelihood_has_fallen(exact):
    """Root of the rise of the exact deviance at the ends: 1.96 to a tenth, on average; where no discrepancy widens them."""
    rises = []
    for name in ("Q N", "N B", "Q K"):
        mixture = MIXTURES[name]
        terms = tuple(term for term in TERMS if term in mixture)
        truth = np.array([mixture[term] ** 2 for term in terms])
        information = exact.information(terms, truth)
        rng = np.random.default_rng(seed_of(f"exact intervals {name}"))
        for _ in range(2):
            y = simulated(N, 1.0, mixture, seed=int(rng.integers(1 << 62)))
            only = {"terms": terms, "filter": False, "processes": False, "resonances": False}
            found = summarize([y], samples=N, tau0=1.0).fit(**only, lines=False, drifts=False)
            if any(size > 0 for _, size in found.discrepancy):
                continue
            profiles = [term.profile for name, term in found.terms if name in terms]
            best = exact.fit(y, terms, np.array([one.value**2 for one in profiles]), information)
            for k, profile in enumerate(profiles):
                for end in (profile.low**2, profile.high**2):
                    start = np.where(np.arange(len(terms)) == k, end, best.theta)
                    held = exact.fit(y, terms, start, information, held=k)
                    rises.append(math.sqrt(held.deviance - best.deviance))
    assert len(rises) >= 8
    assert np.mean(rises) == pytest.approx(1.96, abs=TENTH)
    assert np.std(rises) <= TENTH
