"""Distributions of the extension against SciPy; known answers with 50 digits are in crates/core/src/distributions."""

import numpy as np
import pytest
from scipy import special

from sigmatau._native import distributions as ours

PROMISED = 1e-12
# SciPy 1.17 loses digits itself: P(10⁶, 10⁶ − 5·10³) by 4e-6, beyond 10⁵ in general; and 1.5e-12 for shapes near 1000.
SHAPES = np.array([0.5, 1, 1.5, 3, 9.5, 10, 40, 150.5, 2e4, 1e5])[:, None]
SCIPY = 3e-12

PROBABILITIES = np.concatenate([np.logspace(-250, -1, 84), np.linspace(0.1, 0.9, 33), 1 - np.logspace(-1, -12, 34)])


def same(got, expected, tolerance=SCIPY):
    there = (np.abs(expected) > 1e-290) & np.isfinite(expected)
    assert there.sum() > 0.5 * there.size
    np.testing.assert_allclose(got[there], expected[there], rtol=tolerance, atol=0)


@pytest.mark.parametrize(("name", "peer"), [("gamma_below", special.gammainc), ("gamma_above", special.gammaincc)])
def test_tails_of_the_gamma_distribution(name, peer):
    x = SHAPES * np.exp(np.linspace(-20, 20, 161) / np.sqrt(SHAPES))
    same(getattr(ours, name)(SHAPES, x), peer(SHAPES, x))


@pytest.mark.parametrize(
    ("name", "peer"), [("gamma_quantile", special.gammaincinv), ("gamma_quantile_above", special.gammainccinv)]
)
def test_quantiles_of_the_gamma_distribution(name, peer):
    same(getattr(ours, name)(SHAPES, PROBABILITIES), peer(SHAPES, PROBABILITIES))


@pytest.mark.parametrize("shape", [0.5, 2, 30, 9999, 1e6, 1e9])
def test_quantiles_of_the_gamma_distribution_return_their_probability(shape):
    x = ours.gamma_quantile(shape, PROBABILITIES)
    # A value that is rounded to 2⁻⁵³ moves the logarithm of its probability by up to x times the density over it.
    digits = 1.2e-16 * np.sqrt(2 * np.log(1 / PROBABILITIES) * shape) + PROMISED
    there = x > 1e-300
    assert there.sum() > 100
    ratio = ours.gamma_below(shape, x)[there] / PROBABILITIES[there]
    assert (np.abs(ratio - 1) < digits[there]).all()


def test_chi2_is_a_gamma_distribution():
    freedom, x = np.array([1, 2, 7.5, 300])[:, None], np.geomspace(0.01, 900, 41)
    same(ours.chi2_below(freedom, x), special.chdtr(freedom, x))
    same(ours.chi2_above(freedom, x), special.chdtrc(freedom, x))
    same(ours.chi2_quantile_above(freedom, PROBABILITIES), special.chdtri(freedom, PROBABILITIES))


def test_students_t():
    freedom = np.array([0.5, 1, 2, 3, 7.25, 40, 1e3, 1e5, 1e7])[:, None]
    t = np.concatenate([-np.logspace(-2, 6, 97), [0], np.logspace(-2, 6, 97)])
    same(ours.student_below(freedom, t), special.stdtr(freedom, t), PROMISED)
    inside = PROBABILITIES[PROBABILITIES > 1e-100]  # SciPy's quantile fails further out: 3 degrees of freedom, 1e-193
    same(ours.student_quantile(freedom[2:], inside), special.stdtrit(freedom[2:], inside))


def test_students_t_in_closed_form():
    t = np.logspace(-9, 9, 73)
    tail = np.arctan2(1, t) / np.pi  # one degree of freedom: Cauchy's distribution
    np.testing.assert_allclose(ours.student_below(1, -t), tail, rtol=PROMISED)
    np.testing.assert_allclose(ours.student_below(1, t), 1 - tail, rtol=PROMISED)
    wide = np.sqrt(2 + t**2)
    np.testing.assert_allclose(ours.student_below(2, -t), 1 / (wide * (wide + t)), rtol=PROMISED)


def test_normal():
    z = np.linspace(-37, 37, 741)
    same(ours.normal_below(z), special.ndtr(z), PROMISED)
    same(ours.normal_quantile(PROBABILITIES), special.ndtri(PROBABILITIES), PROMISED)


def test_digamma_and_gamma():
    x = np.geomspace(0.5, 1e9, 400)
    np.testing.assert_allclose(ours.digamma(x), special.digamma(x), rtol=PROMISED, atol=1e-15)
    np.testing.assert_allclose(ours.log_gamma(x), special.gammaln(x), rtol=PROMISED, atol=1e-15)


def test_shapes_are_those_of_the_arguments():
    assert ours.gamma_below([[1.0], [2.0]], [1.0, 2.0, 3.0]).shape == (2, 3)
    assert ours.normal_below(np.zeros((2, 3)).T).shape == (3, 2)
    assert ours.student_quantile(3, 0.975).shape == ()
    assert float(ours.student_quantile(3, 0.975)) == pytest.approx(
        3.182446305284263, rel=PROMISED
    )  # 16 digits of SciPy
    many = np.arange(1.0, 7.0).reshape(2, 3)[:, ::-1]
    assert ours.digamma(many)[1, 0] == ours.digamma(6.0)
