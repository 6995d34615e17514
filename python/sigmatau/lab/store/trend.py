"""Drift of a coefficient over time: over the units of a production, and within ageing units."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.distributions import chi2_quantile_above, student_below, student_quantile
from sigmatau.arrays import Floats, Ints
from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.lab.lots.repeatability import check_level
from sigmatau.lab.lots.runs import SIGNED
from sigmatau.results import Tabular, plain

Period = Literal["day", "week", "month", "quarter", "year"]
PERIODS: tuple[Period, ...] = ("day", "week", "month", "quarter", "year")

Kind = Literal["production", "ageing"]

_MONTH = 365.2425 / 12  # length of a month [days]
_LEAST_FREEDOM = 3  # smallest number of degrees of freedom of a slope: with fewer, its interval is too wide
_MIN_UNITS_OF_MEDIAN = 6  # smallest number of units for which order statistics give a 95 % interval of the median


@frozen
class InPeriod:
    """A coefficient of the units that were recorded in a period.

    Attributes
    ----------
    name : str
        ``"2026-05"``, ``"2026-W18"`` …
    units, runs, limits : int
        Numbers of units and runs with a value, and of runs with an upper limit only.
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
    """Slope of a coefficient over time, by least squares, with Student's interval.

    Attributes
    ----------
    kind : {"production", "ageing"}
        Over the means of units, or within units.
    units, runs : int
        Numbers of units and runs used for the slope.
    slope, low, high : float
        Slope and its interval. [1/month, relative; SI/month for a term with a sign]
    p_value : float
        Two-sided p-value of the hypothesis of no drift.
    drifts : bool
        Whether this hypothesis is rejected, at the level of all slopes of the table together (Bonferroni).
    """

    kind: Kind
    units: int
    runs: int
    slope: float
    low: float
    high: float
    p_value: float
    drifts: bool

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return plain(self, "kind units runs slope low high p_value drifts")


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
        Drifts over production and within units, if they can be estimated.
    """

    channel: str
    quantity: str
    unit: str
    rate_unit: str
    periods: tuple[InPeriod, ...]
    drifts: tuple[Drift, ...]

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return plain(self, "channel unit periods drifts")


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
        Trends by channel; a channel with several SI units has one trend per unit, ``"gyro_x [rad/s]"``.
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
    channels: dict[str, ChannelTrend] = {}
    kinds = list(zip(rows["channel"], rows["si"], strict=True))
    distinct = {kind: k for k, kind in enumerate(dict.fromkeys(kinds))}
    which = np.array([distinct[kind] for kind in kinds], dtype=np.int64)
    names = [name for name, _ in distinct]
    for kind, k in distinct.items():
        channel_rows = np.flatnonzero((which == k) & dated)
        if not len(channel_rows):
            continue
        first = int(channel_rows[0])
        name = kind[0] if names.count(kind[0]) == 1 else f"{kind[0]} [{kind[1]}]"
        values_of_channel = _Values(
            y=values[channel_rows] if term in SIGNED else _log(values[channel_rows]),
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
    tests = sum(len(channel.drifts) for channel in channels.values())
    return Trend(
        term=term,
        by=by,
        level=level,
        channels={name: _judged(channel, tests, level) for name, channel in channels.items()},
        undated=int((~dated & ~np.isnan(values)).sum()),
    )


@frozen(eq=False)
class _Values:
    y: Floats  # logarithms, or values with a sign; NaN without a value
    unit: Ints
    time: NDArray[np.datetime64]
    limited: NDArray[np.bool_]
    signed: bool

    def observed(self) -> tuple[Floats, Ints, Floats]:
        """Values, positions of their units (from 0), and times in months."""
        keep = ~np.isnan(self.y)
        if not keep.any():
            return self.y[keep], self.unit[keep], self.y[keep]
        months = (self.time[keep] - self.time[keep].min()) / np.timedelta64(1, "D") / _MONTH
        return self.y[keep], np.unique(self.unit[keep], return_inverse=True)[1], months


def _log(values: Floats) -> Floats:
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(values > 0, np.log(values), np.nan)


def _judged(channel: ChannelTrend, tests: int, level: float) -> ChannelTrend:
    from dataclasses import replace

    drifts = tuple(replace(drift, drifts=bool(drift.p_value * tests < 1 - level)) for drift in channel.drifts)
    return replace(channel, drifts=drifts)


def _means(values: Floats, unit: Ints) -> Floats:
    return np.bincount(unit, weights=values) / np.bincount(unit)


def _production(values: _Values, level: float) -> Drift | None:
    """Slope over the means of units, which are independent even if runs of a unit are not."""
    y, unit, months = values.observed()
    units = len(np.unique(unit))
    if units < 2 + _LEAST_FREEDOM:
        return None
    return _slope(
        _means(months, unit), _means(y, unit), units - 2, level, values, kind="production", runs=len(y), units=units
    )


def _ageing(values: _Values, level: float) -> Drift | None:
    """Slope within units: values and times minus the means of their unit."""
    y, unit, months = values.observed()
    units = len(np.unique(unit))
    x, y = months - _means(months, unit)[unit], y - _means(y, unit)[unit]
    freedom = len(y) - units - 1
    if freedom < _LEAST_FREEDOM:
        return None
    return _slope(x, y, freedom, level, values, kind="ageing", runs=len(y), units=units)


def _slope(
    x: Floats, y: Floats, freedom: int, level: float, values: _Values, *, kind: Kind, runs: int, units: int
) -> Drift | None:
    x, y = x - x.mean(), y - y.mean()
    square = float(x @ x)
    if square <= (1e-9 * max(len(x), 1)) ** 2:  # all times are equal
        return None
    slope = float(x @ y) / square
    error = math.sqrt(max(float(((y - slope * x) ** 2).sum()), 0.0) / freedom / square)
    if error == 0:
        return None
    half = float(student_quantile(freedom, (1 + level) / 2)) * error
    p_value = 2 * float(student_below(freedom, -abs(slope) / error))
    ends = [slope, slope - half, slope + half]
    if not values.signed:
        ends = [math.expm1(min(end, 700.0)) for end in ends]
    return Drift(
        kind=kind, units=units, runs=runs, slope=ends[0], low=ends[1], high=ends[2], p_value=min(p_value, 1.0), drifts=False
    )  # fmt: skip


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
    inside_with_value = inside & ~np.isnan(values.y)
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
    """Rank r from either end so that the r-th values enclose the median with at least this probability; 0 without such a
    rank.
    """
    logs = [
        math.lgamma(n + 1) - math.lgamma(k + 1) - math.lgamma(n - k + 1) - n * math.log(2) for k in range(n // 2 + 1)
    ]
    below = np.cumsum(np.exp(logs))  # P(B <= k) of the binomial distribution with p = 1/2
    return int(np.searchsorted(below, (1 - level) / 2, side="right"))
