"""`random_effects`: the numbers of the paper's tables, closed forms, laws, size and coverage by simulation, refusals."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.stats import chi2
from scipy.stats import t as student

from known import seed_of
from paper_tables import DELTAS, SAMPLES, TABLE_I, TABLE_III, relative_errors
from sigmatau import DataError, OptionError, random_effects
from sigmatau.lab.lots.group_effects import group_effects

# Computed apart with scipy from s = sqrt(1/2N + rounding²): spread between days, its interval, half of the prediction
# interval. [%]
EXPECTED = {
    "I": ((1.81, 2.53, 2.45), ((1.16, 3.98), (1.63, 5.56), (1.57, 5.39)), (4.7, 6.6, 6.4)),
    "III": ((0.72, 0.97, 0.85), ((0.46, 1.59), (0.62, 2.14), (0.54, 1.88)), (1.9, 2.5, 2.2)),
}


@pytest.mark.parametrize("table", ["I", "III"])
def test_the_papers_tables(table):
    values = {"I": TABLE_I, "III": TABLE_III}[table]
    tau, intervals, following = EXPECTED[table]
    for axis in range(3):
        days = values[:, axis]
        found = random_effects(days, days * relative_errors(days, SAMPLES[table]))
        assert 100 * found.tau == pytest.approx(tau[axis], abs=0.005)
        assert (100 * found.tau_low, 100 * found.tau_high) == pytest.approx(intervals[axis], abs=0.005)
        assert 100 * found.next_error == pytest.approx(following[axis], abs=0.05)
        assert found.judgement == "varies"
        assert found.p_value < 1e-50
        assert found.std == pytest.approx(days.std(ddof=1), rel=1e-12)
        assert found.accepted_by_paper() is False  # with the error that such a record really has
        assert found.accepted_by_paper(DELTAS[table][axis]) is (table == "I" or axis == 0)  # with the paper's own


def oracle(c, s, level):
    """The same estimates by root finding with scipy, one group at a time."""

    def q(tau2):
        w = 1 / (s**2 + tau2)
        return float((w * (c - (w * c).sum() / w.sum()) ** 2).sum())

    def solved(target):
        return 0.0 if q(0.0) <= target else brentq(lambda x: q(x) - target, 0, 1e6 * np.var(c), xtol=1e-300, rtol=1e-13)

    k, tail = len(c), (1 - level) / 2
    tau2 = solved(k - 1)
    w = 1 / (s**2 + tau2)
    mean, se2 = (w * c).sum() / w.sum(), 1 / w.sum()
    t = student.ppf(1 - tail, k - 1)
    return {
        "mean": mean,
        "mean_error": t * math.sqrt(se2),
        "q": q(0.0),
        "p_value": chi2.sf(q(0.0), k - 1),
        "tau": math.sqrt(tau2),
        "tau_low": math.sqrt(solved(chi2.ppf(1 - tail, k - 1))),
        "tau_high": math.sqrt(solved(chi2.ppf(tail, k - 1))),
        "next_error": t * math.sqrt(tau2 + se2 + (s**2).mean()),
    }


@pytest.mark.parametrize("k", [2, 3, 7, 40])
@pytest.mark.parametrize("ratio", [0.0, 1.0, 30.0])
def test_against_root_finding(k, ratio):
    rng = np.random.default_rng(seed_of(f"oracle {k} {ratio}"))
    errors = np.exp(rng.normal(-5, 1.0, (20, k)))
    values = 3 + errors * rng.standard_normal((20, k)) + ratio * math.exp(-5) * rng.standard_normal((20, k))
    found = group_effects(values, errors, level=0.9)
    for row in range(20):
        for name, value in oracle(values[row], errors[row], 0.9).items():
            # Q is a difference of near numbers: its digits, and those of the roots, are lost where it is large.
            assert getattr(found, name)[row] == pytest.approx(value, rel=1e-8, abs=1e-12), name


def test_missing_values_are_as_if_they_were_not_there():
    rng = np.random.default_rng(seed_of("missing values"))
    values, errors = rng.standard_normal((50, 9)), np.exp(rng.standard_normal((50, 9)))
    there = rng.random((50, 9)) < 0.6
    there[:, 0] = True
    holes = group_effects(np.where(there, values, np.nan), np.where(there, errors, np.nan), level=0.95)
    for row in range(50):
        own = group_effects(values[row][there[row]][None], errors[row][there[row]][None], level=0.95)
        for name in ("mean", "tau", "tau_high", "next_error", "p_value", "outlier_p"):
            np.testing.assert_allclose(getattr(holes, name)[row], getattr(own, name)[0], rtol=1e-9, equal_nan=True)


def test_units_and_order_do_not_matter():
    rng = np.random.default_rng(seed_of("units and order"))
    values, errors = np.exp(0.1 * rng.standard_normal(7)), 0.05 * np.exp(0.3 * rng.standard_normal(7))
    first = random_effects(values, errors)
    second = random_effects(1e-7 * values[::-1], 1e-7 * errors[::-1])
    assert second.tau == pytest.approx(first.tau, rel=1e-9)
    assert second.mean == pytest.approx(1e-7 * first.mean, rel=1e-12)
    assert second.outlier == 6 - first.outlier


class TestFewRuns:
    def test_one(self):
        one = random_effects([2.0], [0.1])
        assert (one.k, one.mean, one.judgement) == (1, 2.0, "one_run")
        assert (one.tau, one.std, one.next_low, one.p_value, one.outlier) == (None,) * 5
        assert one.high == pytest.approx(2 * math.exp(0.05 * 1.959964), rel=1e-6)
        assert "nothing to compare" in repr(one)

    def test_two_that_differ_name_no_run(self):
        two = random_effects([1.0, 2.0], [0.01, 0.01])
        assert two.judgement == "varies"
        assert two.outlier is None
        # The interval of a spread from one difference: √χ² with one degree of freedom.
        assert two.tau_high / two.tau > 30

    def test_equal_values(self):
        same = random_effects([1.0] * 5, [0.1] * 5)
        assert (same.q, same.tau, same.tau_high, same.judgement) == (0.0, 0.0, 0.0, "too_alike")
        assert "\n  between runs         0 %\n" in repr(same)

    def test_without_errors_nothing_is_tested(self):
        found = random_effects([1.0, 1.1, 0.9], None)
        assert found.judgement == "without_errors"
        assert found.tau == pytest.approx(np.log([1.0, 1.1, 0.9]).std(ddof=1))
        assert found.accepted_by_paper() is None
        # Student's prediction interval, exact for normal values.
        half = student.ppf(0.975, 2) * found.tau * math.sqrt(1 + 1 / 3)
        assert found.next_error == pytest.approx(half, rel=1e-9)


def test_a_run_that_does_not_belong_is_named():
    values = np.array([1.0, 1.02, 0.99, 1.01, 2.0, 1.0, 0.98])
    found = random_effects(values, 0.02 * values)
    assert (found.judgement, found.outlier) == ("outlier", 4)
    assert "run 4 does not belong" in repr(found)


def test_values_with_a_sign():
    ramps = random_effects([-2e-10, 1e-10, 3e-10], [1e-10] * 3, scale="absolute")
    assert ramps.tau is not None
    assert ramps.next_low < 0 < ramps.next_high
    assert ramps.judgement in ("varies", "repeatable")
    assert "%" not in repr(ramps)


SETS = 4000


@pytest.mark.parametrize("k", [3, 7])
@pytest.mark.parametrize("ratio", [0.0, 1.0, 4.0])
def test_size_and_coverage(k, ratio):
    """The larger study is docs/study/repeatability.md."""
    rng = np.random.default_rng(seed_of(f"repeatability {k} {ratio}"))
    values = ratio * rng.standard_normal((SETS, k)) + rng.standard_normal((SETS, k))
    found = group_effects(values, np.ones((SETS, k)), level=0.95)
    new = math.hypot(ratio, 1) * rng.standard_normal(SETS)
    error = 3 * math.sqrt(0.05 * 0.95 / SETS)
    if ratio == 0:
        assert np.mean(found.p_value < 0.05) == pytest.approx(0.05, abs=error)
        assert np.mean(found.p_low < 0.05) == pytest.approx(0.05, abs=error)
    covered = (found.tau_low <= ratio + 1e-12) & (found.tau_high >= ratio - 1e-12)
    for share in (covered, np.abs(found.mean) <= found.mean_error, np.abs(new - found.mean) <= found.next_error):
        assert share.mean() >= 0.95 - error
    assert np.mean(found.outlier_p < 0.05) <= 0.05 + error


@pytest.mark.parametrize(
    ("values", "errors", "words"),
    [
        ([], [], "empty"),
        ([1.0, math.nan], [0.1, 0.1], "not finite, at position 1"),
        ([1.0, -1.0], [0.1, 0.1], "must be positive, not -1"),
        ([1.0, 2.0], [0.1, 0.0], "`errors` must be positive, not 0"),
        ([1.0, 2.0], [0.1, math.nan], "`errors` must be positive, not nan"),
        ([1.0, 2.0], [0.1], "1 errors, 2 values"),
        ([[1.0, 2.0]], None, "one dimension"),
        (["a"], None, "must be numbers"),
    ],
)
def test_refusals(values, errors, words):
    with pytest.raises(DataError, match=words):
        random_effects(values, errors)


@pytest.mark.parametrize("options", [{"level": 1.0}, {"level": 95}, {"level": "0.9"}, {"scale": "log"}])
def test_refused_options(options):
    with pytest.raises(OptionError):
        random_effects([1.0, 2.0], [0.1, 0.1], **options)
