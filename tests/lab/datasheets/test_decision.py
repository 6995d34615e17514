"""Decision rules and their risks: the stated probabilities are those of simulated pairs of true and measured values."""

import itertools
import math

import numpy as np
import pytest

from known import seed_of
from sigmatau.errors import OptionError
from sigmatau.lab.datasheets.decision import decide, risk_above
from sigmatau.lab.datasheets.measured import Measured

Z = 1.959963985
PAIRS = 200_000


def interval(value, upper, lower):
    """A measured value whose standard uncertainties, relative, differ above and below."""
    return Measured(value=value, low=value * math.exp(-Z * lower), high=value * math.exp(Z * upper))


@pytest.mark.parametrize("u", [0.02, 0.1, 0.4])
def test_risks_are_the_shares_of_simulated_pairs(u):
    """A flat prior of the logarithm, wide against the uncertainty: of measured values with a stated risk, that share of the
    true values is above the maximum.
    """
    rng = np.random.default_rng(seed_of(f"risks {u}"))
    true = rng.uniform(-6 * u, 6 * u, PAIRS)
    measured = true + u * rng.standard_normal(PAIRS)
    inner = np.abs(measured) < 3 * u  # the prior has no end within six standard uncertainties of these
    edges = np.quantile(measured[inner], np.linspace(0, 1, 21))
    for low, high in itertools.pairwise(edges):
        chosen = inner & (measured >= low) & (measured < high)
        values = np.exp(measured[chosen])
        risks = [risk_above(v, v * math.exp(-Z * u), v * math.exp(Z * u), 1.0) for v in values]
        stated, share = float(np.mean(risks)), float(np.mean(true[chosen] > 0))
        error = math.sqrt(max(stated * (1 - stated), 1e-6) / len(risks))
        assert abs(share - stated) < 3 * error + 1e-4


@pytest.mark.parametrize("u", [0.02, 0.1])
def test_the_guard_band_limits_the_risks(u):
    """Of accepted values at the edge of the guard band 2.5 % are above the maximum, of all accepted ones fewer."""
    rng = np.random.default_rng(seed_of(f"guard band {u}"))
    true = rng.uniform(-5 * u, 5 * u, 20_000)
    measured = true + u * rng.standard_normal(len(true))
    outcomes = [decide(interval(math.exp(m), u, u), 1.0, "guard band")[0] for m in measured]
    accepted = np.array([outcome == "conforms" for outcome in outcomes])
    rejected = np.array([outcome == "does not conform" for outcome in outcomes])
    assert np.mean(true[accepted] > 0) < 0.025
    assert np.mean(true[rejected] <= 0) < 0.025
    assert set(outcomes) == {"conforms", "does not conform", "not decided"}
    assert np.abs(measured[~accepted & ~rejected]).max() <= Z * u * (1 + 1e-6)


@pytest.mark.parametrize(
    ("distance", "below", "above"),
    [(0.98, "not decided", "not decided"), (1.02, "conforms", "does not conform")],
)
def test_the_guard_band_is_the_expanded_uncertainty(distance, below, above):
    """The outcome changes where the end of the 95 % interval passes the maximum: at a `distance` of U."""
    u = 0.1
    assert decide(interval(math.exp(-distance * Z * u), u, u), 1.0, "guard band")[0] == below
    assert decide(interval(math.exp(distance * Z * u), u, u), 1.0, "guard band")[0] == above


@pytest.mark.parametrize(
    ("value", "upper", "lower", "risk"),
    [
        (1.0, 0.1, 0.1, 0.5),  # at the maximum
        (math.exp(-0.1), 0.1, 0.3, 0.158655),  # one standard uncertainty of the upper side below
        (math.exp(0.3), 0.1, 0.3, 1 - 0.158655),  # one standard uncertainty of the lower side above
        (math.exp(-Z * 0.1), 0.1, 0.1, 0.025),
    ],
)
def test_the_side_of_the_maximum_counts(value, upper, lower, risk):
    measured = interval(value, upper, lower)
    assert risk_above(value, measured.low, measured.high, 1.0) == pytest.approx(risk, abs=1e-5)


def test_an_interval_from_zero_is_linear():
    assert risk_above(2.0, 0.0, 5.0, 1.0) == pytest.approx(1 - 0.5 * math.erfc(Z / 2 / math.sqrt(2)))
    assert risk_above(2.0, 2.0, 2.0, 2.0) == 0.5
    assert (risk_above(2.0, 2.0, 2.0, 3.0), risk_above(2.0, 2.0, 2.0, 1.0)) == (0.0, 1.0)


@pytest.mark.parametrize(
    ("value", "simple", "guard"),
    [
        (0.7, "conforms", "conforms"),
        (0.95, "conforms", "not decided"),
        (1.0, "conforms", "not decided"),
        (1.05, "does not conform", "not decided"),
        (1.4, "does not conform", "does not conform"),
    ],
)
def test_rules(value, simple, guard):
    assert decide(interval(value, 0.1, 0.1), 1.0, "simple acceptance")[0] == simple
    assert decide(interval(value, 0.1, 0.1), 1.0, "guard band")[0] == guard


def test_values_that_were_not_observed():
    assert decide(Measured(upper_limit=0.9), 1.0, "guard band") == ("conforms", pytest.approx(0.05), True)
    assert decide(Measured(upper_limit=1.1), 1.0, "guard band") == ("not decided", None, False)
    assert decide(Measured(lower_limit=1.1), 1.0, "guard band") == ("does not conform", None, False)
    assert decide(Measured(), 1.0, "simple acceptance") == ("not decided", None, False)
    assert decide(Measured(value=0.5), 1.0, "simple acceptance") == ("not decided", None, False)


def test_an_unknown_rule():
    with pytest.raises(OptionError, match="simple acceptance or guard band"):
        decide(Measured(value=1.0), 1.0, "lenient")
