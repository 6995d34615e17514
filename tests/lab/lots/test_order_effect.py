"""Changes in the order of production: coverage of their sizes, change points, false alarms and power by Monte Carlo."""

import math

import numpy as np
import pytest

from known import seed_of
from sigmatau.lab.lots.order_effect import fit_order
from sigmatau.lab.lots.robust_effect import estimate_effects

SETS = 150


def within(share, expected=0.95, sets=SETS):
    return abs(share - expected) <= 3 * math.sqrt(expected * (1 - expected) / sets)


def fitted(logs, limited=None, probability=0.01, dates=()):
    names = [f"u{k}" for k in range(len(logs))]
    mask = np.zeros(len(logs), dtype=bool) if limited is None else limited
    return fit_order(names, logs, mask, probability=probability, dates=dates)


@pytest.mark.parametrize("units", [10, 40])
@pytest.mark.parametrize("case", ["normal", "heavy", "bad unit", "limits"])
def test_interval_of_an_effect_covers_it(units, case):
    """Also with a unit 28 standard deviations away, and with upper limits in place of about a fifth of the values."""
    rng = np.random.default_rng(seed_of(f"robust effect {units} {case}"))
    x, hits = np.arange(units) / (units - 1), 0
    for _ in range(SETS):
        y = 0.7 * x + (rng.standard_t(3, units) if case == "heavy" else rng.standard_normal(units))
        limited = np.zeros(units, dtype=bool)
        if case == "bad unit":
            y[rng.integers(units)] += 28
        if case == "limits":
            limits = -0.8 + 0.3 * rng.standard_normal(units)
            limited, y = y < limits, np.maximum(y, limits)
        low, high = estimate_effects(x, y, limited).interval(0.95)
        hits += bool(low[0] <= 0.7 <= high[0])
    # The limits are taken as exact, so that their intervals may be wider than necessary.
    assert within(hits / SETS) or (case == "limits" and hits / SETS > 0.95)


def test_effect_is_that_of_least_squares_without_tails():
    """Residuals of one size have one weight: the estimate is the least-squares line."""
    x = np.arange(40.0)
    y = 3.0 + 0.25 * x + np.tile([0.1, -0.1, -0.1, 0.1], 10)
    effects = estimate_effects(x, y)
    assert effects.value[0] == pytest.approx(np.polyfit(x, y, 1)[0], abs=1e-9)
    assert effects.start[0] == pytest.approx(3.0, abs=1e-9)


def test_too_few_values_have_no_effect():
    effects = estimate_effects(np.arange(5), np.ones(5), np.array([True, True, True, False, False]))
    assert np.isnan(effects.value[0])
    assert np.isnan(estimate_effects(np.ones(9), np.arange(9.0)).value[0])


@pytest.mark.parametrize(("kind", "size"), [("drift", 0.4), ("batch", 0.15), ("rise", 0.03)])
def test_kind_units_and_size(kind, size):
    """Units that differ by 3 %: the change is found with its kind and place, and its interval covers it."""
    rng = np.random.default_rng(seed_of(f"order {kind}"))
    order, sets = np.arange(40.0), 60
    shape = {"drift": order / 39, "batch": (order >= 15) & (order < 25), "rise": np.maximum(order - 29, 0)}[kind]
    first = {"drift": 0, "batch": 15, "rise": 30}[kind]
    same = placed = hits = 0
    for _ in range(sets):
        effect = fitted(size * shape + 0.03 * rng.standard_normal(40)).effect
        if effect is None or effect.kind != kind:
            continue
        same += 1
        placed += abs(int(effect.first[1:]) - first) <= 2
        hits += effect.low <= math.expm1(size) <= effect.high
    assert same / sets >= 0.9
    assert placed / same >= 0.9
    assert hits / same >= 0.95 - 3 * math.sqrt(0.95 * 0.05 / same)


def test_dates_place_a_batch():
    """Of change points that fit about as well, that between two dates."""
    rng = np.random.default_rng(seed_of("dates of batches"))
    dates = [f"2026-05-{4 + k // 10:02d}" for k in range(40)]
    exact = 0
    for _ in range(50):
        logs = 0.05 * (np.arange(40) >= 30) + 0.025 * rng.standard_normal(40)
        effect = fitted(logs, dates=dates, probability=0.05).effect
        exact += effect is None or effect.kind == "drift" or effect.first == "u30"
    assert exact >= 45


@pytest.mark.parametrize("units", [10, 40])
@pytest.mark.parametrize("heavy", [False, True])
def test_false_alarms(units, heavy):
    rng = np.random.default_rng(seed_of(f"order without a change {units} {heavy}"))
    sets, probability = 150, 0.05
    alarms = 0
    for _ in range(sets):
        logs = rng.standard_t(3, units) if heavy else rng.standard_normal(units)
        alarms += fitted(logs, probability=probability).effect is not None
    assert alarms / sets <= probability + 3 * math.sqrt(probability * (1 - probability) / sets)


def test_short_or_constant_series():
    assert fitted(np.arange(9.0)).p_value is None
    assert fitted(np.zeros(40)).effect is None
    assert fitted(np.arange(40.0), limited=np.arange(40) < 30).p_value is None


def test_large_lots_use_a_grid_of_change_points():
    rng = np.random.default_rng(seed_of("large lot"))
    logs = 0.05 * rng.standard_normal(2000)
    logs[1000:] += 0.05
    effect = fitted(logs).effect
    assert effect.kind == "batch"
    assert abs(int(effect.first[1:]) - 1000) < 60
