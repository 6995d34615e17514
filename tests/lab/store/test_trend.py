"""Drift over time: false alarms, coverage and power by Monte Carlo; periods and medians."""

import numpy as np
import pytest

from known import seed_of
from sigmatau.errors import DataError, OptionError
from sigmatau.lab.store.trend import _middle, estimate_trend, number_periods

MONTH = 365.2425 / 12
SETS = 150


def rows(values, months, units, *, channel="gyro_x", limits=None):
    """Rows as those of `Store.coefficients`."""
    count = len(values)
    times = np.datetime64("2026-01-01") + (np.asarray(months) * MONTH * 86400e6).astype("timedelta64[us]")
    return {
        "unit": [f"u{k}" for k in units],
        "channel": [channel] * count,
        "quantity": ["angular_rate"] * count,
        "rate_unit": ["rad/s"] * count,
        "si": ["rad/sqrt(s)"] * count,
        "recorded": times.tolist(),
        "value": [None if np.isnan(x) else float(x) for x in values],
        "upper_limit": [None] * count if limits is None else limits,
    }


def production(rng, *, units=40, runs=3, slope=0.0, heavy=False):
    """Units made over a year, each with runs on consecutive days: units differ by 5 %, runs by 2 %."""
    unit = np.repeat(np.arange(units), runs)
    made = rng.uniform(0, 12, units)
    months = made[unit] + np.tile(np.arange(runs), units) / 30
    of_unit = rng.standard_t(3, units) if heavy else rng.standard_normal(units)
    log = np.log(1e-4) + slope * made[unit] + 0.05 * of_unit[unit] + 0.02 * rng.standard_normal(len(unit))
    return rows(np.exp(log), months, unit)


def ageing(rng, *, units=6, runs=12, slope=0.0):
    """Few units, measured each month for a year."""
    unit = np.repeat(np.arange(units), runs)
    months = np.tile(np.arange(runs), units) + 0.0
    log = slope * months + 0.3 * rng.standard_normal(units)[unit] + 0.03 * rng.standard_normal(len(unit))
    return rows(np.exp(log), months, unit)


def drift(found, kind, channel="gyro_x"):
    return next(one for one in found[channel].drifts if one.kind == kind)


def within(share, expected, sets=SETS, extra=0.0):
    return abs(share - expected) <= 3 * np.sqrt(expected * (1 - expected) / sets) + extra


@pytest.mark.parametrize(("make", "kind"), [(production, "production"), (ageing, "ageing")])
@pytest.mark.parametrize("slope", [0.0, 0.004])
def test_interval_covers_the_slope(make, kind, slope):
    rng = np.random.default_rng(seed_of(f"drift interval {kind} {slope}"))
    hits = 0
    for _ in range(SETS):
        one = drift(estimate_trend(make(rng, slope=slope), term="random_walk", by="year"), kind)
        hits += one.low <= np.expm1(slope * one.span / MONTH) <= one.high
    assert within(hits / SETS, 0.95)


def test_false_alarms_of_a_table():
    """Of a table without a drift, one of twenty names one or more: all its slopes together (Bonferroni: at most)."""
    rng = np.random.default_rng(seed_of("drift false alarms"))
    alarms = 0
    for _ in range(40):
        tables = [production(rng) for _ in range(6)]
        together = {key: [value for one in tables for value in one[key]] for key in tables[0]}
        together["channel"] = [f"c{k}" for k, one in enumerate(tables) for _ in one["value"]]
        found = estimate_trend(together, term="random_walk", by="year")
        assert sum(len(one.drifts) for one in found.channels.values()) == 12
        alarms += any(
            channel.order is not None or any(one.drifts for one in channel.drifts)
            for channel in found.channels.values()
        )
    assert alarms / 40 <= 0.05 + 3 * np.sqrt(0.05 * 0.95 / 40)


def test_false_alarms_with_units_of_heavy_tails():
    rng = np.random.default_rng(seed_of("drift heavy tails"))
    alarms = 0
    for _ in range(SETS):
        found = estimate_trend(production(rng, heavy=True), term="random_walk", by="year")
        alarms += drift(found, "production").p_value < 0.05
    assert alarms / SETS <= 0.05 + 3 * np.sqrt(0.05 * 0.95 / SETS)


def test_drift_is_seen():
    """A drift of 1 % per month over 40 units with 5 % of spread is four standard errors; one of three tests needs 2.4."""
    rng = np.random.default_rng(seed_of("drift power"))
    seen = sum(
        drift(estimate_trend(production(rng, slope=0.01), term="random_walk", by="year"), "production").drifts
        for _ in range(100)
    )
    assert seen / 100 >= 0.94 - 3 * np.sqrt(0.94 * 0.06 / 100)


def test_one_bad_unit_neither_hides_nor_makes_a_drift():
    """A unit four times too noisy, at the beginning of a production with and without a drift."""
    rng = np.random.default_rng(seed_of("drift with a bad unit"))
    for slope in (0.0, 0.015):
        table = production(rng, slope=slope)
        first = int(np.argmin([time.timestamp() for time in table["recorded"]]))
        table["value"] = [
            4 * value if unit == table["unit"][first] else value
            for value, unit in zip(table["value"], table["unit"], strict=True)
        ]
        one = drift(estimate_trend(table, term="random_walk", by="year"), "production")
        assert one.drifts == (slope > 0)
        assert one.low < np.expm1(slope * one.span / MONTH) < one.high


def test_a_short_span_is_not_stated_per_month():
    """Four days: the change over these days, not four hundred per cent per month."""
    rng = np.random.default_rng(seed_of("drift of four days"))
    days = np.repeat(np.arange(4), 10)
    values = 1e-4 * np.exp(0.06 * days + 0.03 * rng.standard_normal(40))
    found = estimate_trend(rows(values, days / MONTH, range(40)), term="random_walk", by="day")
    one = drift(found, "production")
    assert one.span == pytest.approx(3)
    assert one.low < np.expm1(0.18) < one.high
    assert "% over 3 days [" in repr(found)
    assert "per month" not in repr(found)


def test_limits_count_as_censored_values():
    """A fifth of the units show only a limit; without them the drift would be too small."""
    rng = np.random.default_rng(seed_of("drift with limits"))
    hits = 0
    for _ in range(SETS):
        months = np.sort(rng.uniform(0, 12, 40))
        logs = 0.02 * months + 0.1 * rng.standard_normal(40)
        limits = 0.05 + 0.03 * rng.standard_normal(40)
        values = np.where(logs < limits, np.nan, np.exp(logs))
        upper = [float(np.exp(limit)) if np.isnan(value) else None for limit, value in zip(limits, values, strict=True)]
        table = rows(values, months, range(40), limits=upper)
        one = drift(estimate_trend(table, term="random_walk", by="year"), "production")
        hits += one.low <= np.expm1(0.02 * one.span / MONTH) <= one.high
    assert hits / SETS >= 0.95 - 3 * np.sqrt(0.95 * 0.05 / SETS)


def test_a_batch_is_named_as_by_lot():
    rng = np.random.default_rng(seed_of("batch of a store"))
    days = np.repeat(np.arange(4), 10)
    logs = 0.03 * rng.standard_normal(40)
    logs[30:] += 0.2
    found = estimate_trend(rows(np.exp(logs), days / MONTH, range(40)), term="random_walk", by="day")
    order = found["gyro_x"].order
    assert (order.kind, order.first, order.last, order.units) == ("batch", "u30", "u39", 10)
    assert order.low < np.expm1(0.2) < order.high
    assert "batch u30 to u39 (10 units): +" in repr(found)


def test_ageing_is_not_production():
    """Units that age alike, made at the same time, say nothing of the production."""
    rng = np.random.default_rng(seed_of("drift of units"))
    found = estimate_trend(ageing(rng, slope=0.02), term="random_walk", by="year")
    assert [one.kind for one in found["gyro_x"].drifts] == ["ageing"]
    one = drift(found, "ageing")
    assert one.drifts
    assert one.low < np.expm1(0.02 * one.span / MONTH) < one.high


@pytest.mark.parametrize("n", [2, 3, 5, 6, 10, 60])
def test_interval_of_the_median(n):
    rng = np.random.default_rng(seed_of(f"median of {n}"))
    hits, sets = 0, 1000
    for _ in range(sets):
        _, low, high = _middle(np.sort(rng.standard_normal(n)), 0.95)
        hits += low <= 0 <= high
    few = 6  # below, Student's interval is exact; order statistics cover at least the level
    assert within(hits / sets, 0.95, sets) if n < few else hits / sets >= 0.95 - 3 * np.sqrt(0.05 * 0.95 / sets)
    if n >= few:
        assert hits / sets <= {6: 0.985, 10: 0.99, 60: 0.985}[n]  # and not much more: 0.969, 0.979, 0.960


def test_spread_covers():
    rng = np.random.default_rng(seed_of("spread of a period"))
    hits = 0
    for _ in range(SETS):
        units = np.arange(8)
        table = rows(np.exp(0.05 * rng.standard_normal(8)), units / 100, units)
        [period] = estimate_trend(table, term="random_walk", by="year")["gyro_x"].periods
        hits += period.spread_low <= 0.05 <= period.spread_high
    assert within(hits / SETS, 0.95)


@pytest.mark.parametrize(("by", "names"), [
    ("day", ["2025-12-29", "2026-01-01", "2026-03-31", "2026-04-01"]),
    ("week", ["2026-W01", "2026-W14"]),
    ("month", ["2025-12", "2026-01", "2026-03", "2026-04"]),
    ("quarter", ["2025-Q4", "2026-Q1", "2026-Q2"]),
    ("year", ["2025", "2026"]),
])  # fmt: skip
def test_periods(by, names):
    times = np.array(
        ["2025-12-29T00:00", "2026-01-01T00:00", "2026-03-31T23:59", "2026-04-01T00:00"], dtype="datetime64[us]"
    )
    where, found = number_periods(times, by)
    assert found == names
    assert np.all(np.diff(where) >= 0)


def test_limits_and_values_without_a_time():
    table = rows([1.0, np.nan, 2.0, 3.0], [0, 0, 0, 1], [0, 1, 2, 3], limits=[None, 5.0, None, None])
    table["recorded"][3] = None
    found = estimate_trend(table, term="random_walk", by="year")
    [period] = found["gyro_x"].periods
    assert (period.units, period.runs, period.limits, found.undated) == (2, 2, 1, 1)
    assert found["gyro_x"].drifts == ()
    assert "1 values without a time are not used" in repr(found)


def test_terms_with_a_sign_are_not_relative():
    rng = np.random.default_rng(seed_of("drift of a mean"))
    units = np.arange(60)
    months = units / 5
    found = estimate_trend(rows(1e-6 * months - 5e-6 + 1e-7 * rng.standard_normal(60), months, units), term="mean")
    one = drift(found, "production")
    months = one.span / MONTH
    assert one.change == pytest.approx(1e-6 * months, abs=4 * (one.high - one.low) / 3.92)  # four standard errors
    assert one.high - one.low < 1e-7 * months
    assert "deg/h per month" in repr(found)


@pytest.mark.parametrize(("change", "options", "error"), [
    ({}, {"by": "decade"}, OptionError),
    ({}, {"level": 1.0}, OptionError),
    ({"recorded": [None] * 3}, {}, DataError),
])  # fmt: skip
def test_errors(change, options, error):
    with pytest.raises(error):
        estimate_trend(rows([1.0, 2.0, 3.0], [0, 1, 2], [0, 1, 2]) | change, term="random_walk", **options)


def test_units_are_not_mixed():
    """A channel that was read in deg/s by one log and as an acceleration by another is two channels."""
    values = np.array([1.0, 1.02, 0.99, 1.01, 1.0, 1.0]) * 1e-4
    found = rows([*values, *1e3 * values], np.arange(12), range(12))
    found["si"][6:] = found["rate_unit"][6:] = ["m/s^2"] * 6
    trend = estimate_trend(found, term="random_walk")
    assert list(trend.channels) == ["gyro_x [rad/sqrt(s)]", "gyro_x [m/s^2]"]
    assert [one.unit for one in trend.channels.values()] == ["rad/sqrt(s)", "m/s^2"]
    assert not any(one.drifts for part in trend.channels.values() for one in part.drifts)
    assert trend.channels["gyro_x [m/s^2]"].periods[0].middle == pytest.approx(0.1, rel=1e-12)


@pytest.mark.parametrize(("batches", "share"), [(0.02, 0.13), (0.05, 0.34)])
def test_random_batches_pass_for_drifts(batches, share):
    """What docs/how-to/store.md states of batches that differ at random, in 60 units of six months without a trend."""
    rng = np.random.default_rng(seed_of(f"drift of batches {batches}"))
    sets = 150
    found = 0
    for _ in range(sets):
        months = rng.uniform(0, 6, 60)
        batch = batches * rng.standard_normal(6)[months.astype(int)]
        values = 1e-4 * np.exp(batch + 0.05 * rng.standard_normal(60))
        channel = estimate_trend(rows(values, months, range(60)), term="random_walk")["gyro_x"]
        found += channel.drifts[0].drifts
    # The stated share is of 400 sets, so both errors count.
    assert abs(found / sets - share) <= 3 * np.sqrt(share * (1 - share) * (1 / sets + 1 / 400))
