"""Drift of a coefficient over time: over the units of a production, and within ageing units."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.distributions import chi2_quantile_above, student_below, student_quantile
from sigmatau.arrays import Bools, Floats, Ints
from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.lab.lots.conditions import condition_groups
from sigmatau.lab.lots.order_effect import LEAST_IN_ORDER, OrderEffect, fit_order
from sigmatau.lab.lots.repeatability import check_level
from sigmatau.lab.lots.robust_effect import estimate_effects
from sigmatau.lab.lots.runs import SIGNED
from sigmatau.results import Tabular, plain

Period = Literal["day", "week", "month", "quarter", "year"]
PERIODS: tuple[Period, ...] = ("day", "week", "month", "quarter", "year")

Kind = Literal["production", "ageing"]

_SAME_TIME = 1e-6  # span up to which runs count as simultaneous, so that no drift is estimated [days]
_LARGEST = 700.0  # exponent of the largest number
_LEAST_FREEDOM = 3  # smallest degrees of freedom of a slope: with fewer, its interval is too wide to be of use
_MIN_UNITS_OF_MEDIAN = 6  # smallest number of units for which order statistics give a 95 % interval of the median


@frozen
class InPeriod:
    """A coefficient of the units that were recorded in a period.

    Attributes
    ----------
    name : str
        ``"2026-05"``, ``"2026-W18"`` …
    units, runs, limits : int
        Number of units with a value, of runs with a value, and of runs that have only an upper limit.
    middle, low, high : float or None
        Median over the units with its interval by order statistics; for fewer than six units their (geometric) mean with
        Student's interval. One unit has no interval. [SI]
    spread, spread_low, spread_high : float or None
        Standard deviation over the units with its χ² interval: relative, or in SI for a term with a sign.
    """

    name: str
    units: int
    runs: int
    limits: int
    middle: float | None
    low: float | None
    high: float | None
    spread: float | None
    spread_low: float | None
    spread_high: float | None

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return plain(self, "name units runs limits middle low high spread spread_low spread_high")


@frozen
class Drift:
    """Change of a coefficient over the observed time, by the robust regression of `sigmatau lot`, with Student's interval.

    Attributes
    ----------
    kind : {"production", "ageing"}
        Over the units, or within units.
    units, runs : int
        Number of units and of runs from which the change is estimated.
    span : float
        Observed time: from the first to the last unit; for ageing, the longest time of a unit. [days]
    change, low, high : float
        Change over the span, with its interval: relative, or in SI for a term with a sign.
    p_value : float
        Two-sided p-value of the hypothesis of no drift.
    drifts : bool
        Whether this hypothesis is rejected, corrected for the number of tests in the table (Bonferroni).
    """

    kind: Kind
    units: int
    runs: int
    span: float
    change: float
    low: float
    high: float
    p_value: float
    drifts: bool

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return plain(self, "kind units runs change low high p_value drifts", span_days=self.span)


@frozen
class ChannelTrend:
    """A coefficient of a channel over time.

    Attributes
    ----------
    channel : str
    quantity : str
        ``"angular_rate"``, ``"acceleration"`` or ``"signal"``.
    unit : str
        Unit of the coefficient; SI.
    rate_unit : str
        Unit of the channel; SI.
    periods : tuple of InPeriod
        Periods in order of time.
    drifts : tuple of Drift
        Over production and within units, where they can be estimated.
    order : OrderEffect or None
        Drift or batch in the order of production, as in `sigmatau lot`; None if it is not significant, or for a term with
        a sign.
    """

    channel: str
    quantity: str
    unit: str
    rate_unit: str
    periods: tuple[InPeriod, ...]
    drifts: tuple[Drift, ...]
    order: OrderEffect | None = None

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return plain(self, "channel unit periods drifts order")


@frozen
class Trend(Tabular):
    """Result of `Store.trend`.

    Attributes
    ----------
    term : str
    by : {"day", "week", "month", "quarter", "year"}
    level : float
        Confidence level of intervals and tests.
    channels : mapping of str to ChannelTrend
        By name; a channel that has several units is one for each, ``"gyro_x [rad/s]"``; that of runs at several temperatures
        or supply voltages is one for each, ``"gyro_x at 25 °C at 3.3 V"``.
    undated : int
        Values without a time, which are not used.
    """

    term: str
    by: Period
    level: float
    channels: Mapping[str, ChannelTrend]
    undated: int

    def __getitem__(self, channel: str) -> ChannelTrend:
        if channel not in self.channels:
            raise KeyError(f"no channel {channel!r}; channels: {', '.join(self.channels)}")
        return self.channels[channel]

    def columns(self) -> dict[str, list[Any]]:
        """One row per channel and period, in SI; see `Tabular.columns`."""
        rows = [
            {"channel": channel.channel, **period.to_dict(), "unit": channel.unit}
            for channel in self.channels.values()
            for period in channel.periods
        ]
        return {key: [row[key] for row in rows] for key in rows[0]} if rows else {}

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return plain(self, "term by level undated channels")

    def __repr__(self) -> str:
        from sigmatau.lab.store.text import trend_text

        return trend_text(self)


def estimate_trend(rows: Mapping[str, Sequence[Any]], *, term: str, by: Period = "month", level: float = 0.95) -> Trend:
    """Estimate the trend from the rows of `Store.coefficients` for one term.

    Raises
    ------
    DataError
        If no value has a time.
    OptionError
        For an unknown period, or a level outside 0 to 1.
    """
    if by not in PERIODS:
        raise OptionError(f"{{option}} must be {', '.join(PERIODS)}, not {by!r}", option="by")
    check_level(level)
    dated = np.array([time is not None for time in rows["recorded"]], dtype=bool)
    values = np.array(rows["value"], dtype=np.float64)
    if not dated.any():
        what = (
            f"none of the runs with it has a time; add results with {Hint('date')}"
            if len(values)
            else "no selected run has it"
        )
        raise DataError(f"no trend of {term}: {what}")
    position = {name: k for k, name in enumerate(dict.fromkeys(rows["unit"]))}
    unit = np.array([position[name] for name in rows["unit"]], dtype=np.int64)
    time = np.array(rows["recorded"], dtype="datetime64[us]")
    limited = np.array([limit is not None for limit in rows["upper_limit"]], dtype=bool) & np.isnan(values)
    bounded = np.where(limited, np.array(rows["upper_limit"], dtype=np.float64), values)
    channels: dict[str, ChannelTrend] = {}
    orders: dict[str, _UnitSeries] = {}
    unstated = [None] * len(values)
    groups = condition_groups(rows.get("temperature", unstated), rows.get("supply", unstated))
    kinds = list(zip(rows["channel"], rows["si"], groups, strict=True))
    distinct = {kind: k for k, kind in enumerate(dict.fromkeys(kinds))}
    which = np.array([distinct[kind] for kind in kinds], dtype=np.int64)
    names = [(name, group) for name, _, group in distinct]
    for kind, k in distinct.items():
        channel_rows = np.flatnonzero((which == k) & dated)
        if not len(channel_rows):
            continue
        first = int(channel_rows[0])
        title = f"{kind[0]} {kind[2]}".strip()
        name = title if names.count((kind[0], kind[2])) == 1 else f"{title} [{kind[1]}]"
        values_of_channel = _Values(
            y=bounded[channel_rows] if term in SIGNED else _log(bounded[channel_rows]),
            unit=unit[channel_rows],
            time=time[channel_rows],
            limited=limited[channel_rows],
            signed=term in SIGNED,
        )
        channels[name] = ChannelTrend(
            channel=name,
            quantity=rows["quantity"][first],
            unit=rows["si"][first],
            rate_unit=rows["rate_unit"][first],
            periods=_periods(values_of_channel, by, level),
            drifts=tuple(filter(None, (_production(values_of_channel, level), _ageing(values_of_channel, level)))),
        )
        in_order = _over_units(values_of_channel)
        if term not in SIGNED and len(in_order.y) >= LEAST_IN_ORDER:
            orders[name] = in_order
    tests = sum(len(channel.drifts) for channel in channels.values()) + len(orders)
    serials = [*position]
    return Trend(
        term=term,
        by=by,
        level=level,
        channels={
            name: _judged(channel, orders.get(name), serials, tests, level) for name, channel in channels.items()
        },
        undated=int((~dated & ~np.isnan(values)).sum()),
    )


@frozen(eq=False)
class _Values:
    y: Floats  # logarithms, or values with a sign, or upper limits; NaN without either
    unit: Ints
    time: NDArray[np.datetime64]
    limited: NDArray[np.bool_]
    signed: bool

    def usable(self) -> tuple[Floats, Ints, Floats, Bools]:
        """Values and limits, positions of their units from 0, times in days, and which are limits."""
        keep = ~np.isnan(self.y)
        if not keep.any():
            return self.y[keep], self.unit[keep], self.y[keep], self.limited[keep]
        days = (self.time[keep] - self.time[keep].min()) / np.timedelta64(1, "D")
        return self.y[keep], np.unique(self.unit[keep], return_inverse=True)[1], days, self.limited[keep]


@frozen(eq=False)
class _UnitSeries:
    """Mean of each unit in the order of production, or its lowest limit, with time, position of the unit, and date."""

    y: Floats
    days: Floats
    limited: Bools
    unit: Ints
    date: tuple[str, ...]


def _log(values: Floats) -> Floats:
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(values > 0, np.log(values), np.nan)


def _judged(
    channel: ChannelTrend, units: _UnitSeries | None, serials: Sequence[str], tests: int, level: float
) -> ChannelTrend:
    from dataclasses import replace

    drifts = tuple(replace(drift, drifts=bool(drift.p_value * tests < 1 - level)) for drift in channel.drifts)
    if units is None:
        return replace(channel, drifts=drifts)
    names = [serials[k] for k in units.unit.tolist()]
    order = fit_order(names, units.y, units.limited, probability=(1 - level) / tests, dates=units.date)
    return replace(channel, drifts=drifts, order=order.effect)


def _means(values: Floats, unit: Ints) -> Floats:
    return np.bincount(unit, weights=values) / np.bincount(unit)


def _over_units(values: _Values) -> _UnitSeries:
    """Units in the order of their times. A unit that has only limits is represented by its lowest limit."""
    y, unit, days, limited = values.usable()
    count = int(unit.max()) + 1 if len(unit) else 0
    numbers = np.bincount(unit[~limited], minlength=count)
    totals = np.bincount(unit[~limited], weights=y[~limited], minlength=count)
    lowest = np.full(count, np.inf)
    np.minimum.at(lowest, unit[limited], y[limited])
    result = np.where(numbers > 0, totals / np.maximum(numbers, 1), lowest)
    times = _means(days, unit) if count else np.zeros(0)
    order = np.argsort(times, kind="stable")
    positions = np.unique(values.unit[~np.isnan(values.y)])
    first = values.time[~np.isnan(values.y)].min() if count else np.datetime64(0, "us")
    dates = first + (times * 86400e6).astype("timedelta64[us]")
    return _UnitSeries(
        y=result[order],
        days=times[order],
        limited=(numbers == 0)[order],
        unit=positions[order],
        date=tuple(str(date.astype("datetime64[D]")) for date in dates[order]),
    )


def _production(values: _Values, level: float) -> Drift | None:
    """Estimate the change from the means of units, which are independent, although the runs of a unit are not."""
    units = _over_units(values)
    if int((~units.limited).sum()) < 2 + _LEAST_FREEDOM:
        return None
    runs = int((~np.isnan(values.y)).sum())
    return _drift(
        units.days, units.y, units.limited, None, level, values, kind="production", runs=runs, units=len(units.y)
    )


def _ageing(values: _Values, level: float) -> Drift | None:
    """Estimate the change within units, from differences to the means of each unit; limits are not used."""
    y, unit, days, limited = values.usable()
    if limited.all():
        return None
    y, days, unit = y[~limited], days[~limited], np.unique(unit[~limited], return_inverse=True)[1]
    units = int(unit.max()) + 1
    x, y = days - _means(days, unit)[unit], y - _means(y, unit)[unit]
    freedom = len(y) - units - 1
    if freedom < _LEAST_FREEDOM:
        return None
    limits = np.zeros(len(y), dtype=bool)
    return _drift(x, y, limits, freedom, level, values, kind="ageing", runs=len(y), units=units)


def _drift(
    x: Floats,
    y: Floats,
    limited: Bools,
    freedom: int | None,
    level: float,
    values: _Values,
    *,
    kind: Kind,
    runs: int,
    units: int,
) -> Drift | None:
    span = float(np.ptp(x))
    if span <= _SAME_TIME or not np.ptp(y[~limited]) > 0:
        return None
    effects = estimate_effects(x / span, y, limited)
    spare = effects.freedom if freedom is None else freedom
    error = float(effects.error[0]) * math.sqrt(effects.freedom / spare)
    if not error > 0:
        return None
    change = float(effects.value[0])
    half = float(student_quantile(spare, (1 + level) / 2)) * error
    ends = [change, change - half, change + half]
    if not values.signed:
        ends = [math.expm1(min(end, _LARGEST)) for end in ends]
    return Drift(
        kind=kind,
        units=units,
        runs=runs,
        span=span,
        change=ends[0],
        low=ends[1],
        high=ends[2],
        p_value=min(2 * float(student_below(spare, -abs(change) / error)), 1.0),
        drifts=False,
    )


def number_periods(time: NDArray[np.datetime64], by: Period) -> tuple[Ints, list[str]]:
    """Position of the period of each time, and names of the periods in order."""
    if by == "day":
        keys = time.astype("datetime64[D]")
        text = [str(key) for key in np.unique(keys)]
    elif by == "week":
        days = time.astype("datetime64[D]").astype(np.int64)
        keys = (days + 3) // 7  # 1970-01-01 was a Thursday; weeks begin on Monday
        weeks = [np.datetime64(int(key) * 7 - 3, "D").item().isocalendar() for key in np.unique(keys)]
        text = [f"{week.year}-W{week.week:02d}" for week in weeks]
    elif by == "month":
        keys = time.astype("datetime64[M]")
        text = [str(key) for key in np.unique(keys)]
    elif by == "quarter":
        keys = time.astype("datetime64[M]").astype(np.int64) // 3
        text = [f"{1970 + int(key) // 4}-Q{int(key) % 4 + 1}" for key in np.unique(keys)]
    else:
        keys = time.astype("datetime64[Y]")
        text = [str(key) for key in np.unique(keys)]
    return np.unique(keys, return_inverse=True)[1], text


def _periods(values: _Values, by: Period, level: float) -> tuple[InPeriod, ...]:
    where, names = number_periods(values.time, by)
    return tuple(_in_period(name, values, where == k, level) for k, name in enumerate(names))


def _in_period(name: str, values: _Values, inside: NDArray[np.bool_], level: float) -> InPeriod:
    back = (lambda x: x) if values.signed else math.exp
    inside_with_value = inside & ~np.isnan(values.y) & ~values.limited
    y, unit = values.y[inside_with_value], np.unique(values.unit[inside_with_value], return_inverse=True)[1]
    means = np.sort(_means(y, unit)) if len(y) else y
    n = len(means)
    middle, low, high = _middle(means, level)
    spread = float(means.std(ddof=1)) if n > 1 else None
    ends: list[float | None] = [None, None]
    if spread is not None:
        ends = [
            spread * math.sqrt((n - 1) / float(chi2_quantile_above(n - 1, p)))
            for p in ((1 - level) / 2, (1 + level) / 2)
        ]
    return InPeriod(
        name=name,
        units=n,
        runs=len(y),
        limits=int((values.limited & inside).sum()),
        middle=None if middle is None else back(middle),
        low=None if low is None else back(low),
        high=None if high is None else back(high),
        spread=spread,
        spread_low=ends[0],
        spread_high=ends[1],
    )


def _middle(y: Floats, level: float) -> tuple[float | None, float | None, float | None]:
    """Median of sorted values with its interval by order statistics; for few values, the mean with Student's interval."""
    n = len(y)
    if n < 2:
        return (None if n == 0 else float(y[0])), None, None
    rank = _rank(n, level)
    if n >= _MIN_UNITS_OF_MEDIAN and rank:
        return float(np.median(y)), float(y[rank - 1]), float(y[n - rank])
    mean = float(y.mean())
    half = float(student_quantile(n - 1, (1 + level) / 2)) * float(y.std(ddof=1)) / math.sqrt(n)
    return mean, mean - half, mean + half


def _rank(n: int, level: float) -> int:
    """Largest rank r for which the r-th smallest and the r-th largest value enclose the median with this probability; 0 if
    there is none.
    """
    logs = [
        math.lgamma(n + 1) - math.lgamma(k + 1) - math.lgamma(n - k + 1) - n * math.log(2) for k in range(n // 2 + 1)
    ]
    below = np.cumsum(np.exp(logs))  # P(B <= k) of the binomial distribution with p = 1/2
    return int(np.searchsorted(below, (1 - level) / 2, side="right"))
