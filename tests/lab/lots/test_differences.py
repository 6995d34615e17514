"""The difference of two results and its interval."""

import math
from dataclasses import replace

import numpy as np
import pytest

import sigmatau as st
from known import seed_of
from sigmatau.errors import OptionError
from sigmatau.lab.lots.differences import term_differences

MODEL = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})


@pytest.fixture(scope="module")
def runs():
    rng = np.random.default_rng(seed_of("differences"))
    return [st.analyze(st.simulate(MODEL, duration=600, rate=10, rng=rng)) for _ in range(40)]


def with_term(analysis, **values):
    """The analysis with another random walk."""
    fit = analysis.fits["gyro_x"]
    terms = {**fit.terms, "random_walk": replace(fit.terms["random_walk"], **values)}
    return replace(analysis, fits=type(analysis.fits)({"gyro_x": replace(fit, terms=terms)}))


def walk(first, second):
    (found,) = (each for each in term_differences(first, second) if each.term == "random_walk")
    return found


@pytest.mark.parametrize(
    ("before", "after", "low", "high", "verdict"),
    [
        ((10, 9, 11), (12, 11, 13), 2 - math.sqrt(2), 2 + math.sqrt(2), "differs"),
        ((10, 9, 11), (11, 10, 12), 1 - math.sqrt(2), 1 + math.sqrt(2), "same"),
        ((10, 9, 13), (12, 8, 13), 2 - 5, 2 + math.sqrt(2), "same"),  # (12 - 8, 13 - 10); (13 - 12, 10 - 9)
    ],
)
def test_known_intervals(runs, before, after, low, high, verdict):
    keys = ("value", "low", "high")
    first, second = (dict(zip(keys, numbers, strict=True)) for numbers in (before, after))
    found = walk(with_term(runs[0], **first), with_term(runs[1], **second))
    assert (found.low, found.high, found.verdict) == (pytest.approx(low), pytest.approx(high), verdict)
    assert found.value == after[0] - before[0]
    assert found.text


@pytest.mark.parametrize(("limit", "verdict"), [(5.0, "differs"), (9.5, "unknown")])
def test_a_limit_and_a_value(runs, limit, verdict):
    observed = with_term(runs[0], value=10.0, low=9.0, high=11.0)
    limited = with_term(runs[1], value=None, low=None, high=None, upper_limit=limit, observed=False)
    for pair in ((observed, limited), (limited, observed)):
        found = walk(*pair)
        assert (found.value, found.verdict) == (None, verdict)
    assert not [each for each in term_differences(limited, limited) if each.term == "random_walk"]


def test_coverage(runs):
    """Of 20 pairs of one sensor, 19 contain 0 on average; six or more do not with a probability of 0.03 %."""
    pairs = [walk(first, second) for first, second in zip(runs[::2], runs[1::2], strict=True)]
    assert sum(pair.verdict == "differs" for pair in pairs) < 6
    assert {pair.level for pair in pairs} == {0.95}


def test_a_change_is_seen(runs):
    """600 s at 10 Hz: N to 0.9 %, the difference to 2.5 % at 95 %."""
    changed = st.NoiseModel(channels={"gyro_x": {"random_walk": 1.1e-4}})
    found = walk(runs[0], st.analyze(st.simulate(changed, duration=600, rate=10, rng=seed_of("changed"))))
    assert (found.verdict, found.value > 0) == ("differs", True)
    assert found.to_dict()["unit"] == "rad/sqrt(s)"


def test_another_quantity(runs):
    fit = replace(runs[1].fits["gyro_x"], quantity="signal", rate_unit="V")
    with pytest.raises(OptionError, match="another quantity"):
        term_differences(runs[0], replace(runs[1], fits=type(runs[1].fits)({"gyro_x": fit})))
