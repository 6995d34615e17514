"""Series of a lot: each coefficient by unit, for a channel or as a mean over the axes of a sensor; and their statistics."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from sigmatau.frozen import frozen
from sigmatau.lab.lots.lot_bands import Band, band
from sigmatau.lab.lots.lot_statistics import Distribution, Series, distribution, series_order
from sigmatau.lab.lots.lot_unit import UnitCoefficient, UnitResult
from sigmatau.noise.terms import TERMS
from sigmatau.record import stream_name

_COEFFICIENTS = (*TERMS, "means_10", "means_100")
_INTERVAL_WIDTH = 3.92  # width of a 95 % interval in standard errors
_LONG = 8.0  # record length over the averaging time at which slow noise is compared: about six independent clusters [1]


@frozen(eq=False)
class Distributions:
    """The distributions and the curves of a lot.

    Attributes
    ----------
    values : tuple of Distribution
        Coefficients that at least half of the units show, by channel.
    sensors : tuple of Distribution
        Geometric means of these coefficients over the axes of each sensor.
    slow : tuple of Distribution
        Allan deviations at a long averaging time, by channel and by sensor.
    bands : tuple of Band
        Curves by channel.
    """

    values: tuple[Distribution, ...]
    sensors: tuple[Distribution, ...]
    slow: tuple[Distribution, ...]
    bands: tuple[Band, ...]


def collect_distributions(units: Mapping[str, UnitResult]) -> Distributions:
    """Collect the distributions of coefficients that at least half of the units show, and the bands of the curves."""
    channels: dict[str, dict[str, UnitResult]] = {}
    for name, unit in units.items():
        for channel in unit.channels:
            channels.setdefault(channel, {})[name] = unit
    shown: list[Series] = []
    slow: list[Series] = []
    bands = []
    for channel, channel_units in channels.items():
        first = next(iter(channel_units.values())).channels[channel]
        alike = {name: unit for name, unit in channel_units.items() if unit.channels[channel].unit == first.unit}
        curves = {name: (unit.channels[channel].tau, unit.channels[channel].adev) for name, unit in alike.items()}
        if not all(len(tau) for tau, _ in curves.values()):
            # A store may keep the curves of doubtful units alone, which are not those of the lot.
            curves = dict.fromkeys(curves, (np.empty(0), np.empty(0)))
        bands.append(band(channel, curves, quantity=first.quantity, unit=first.unit))
        for what in _COEFFICIENTS:
            series = _series(channel, what, alike)
            if series is not None:
                shown.append(series)
        long_series = _long_series(bands[-1], alike)
        if long_series is not None:
            slow.append(long_series)
    over_axes, slow_over_axes = _over_axes(shown), _over_axes(slow)
    families = max(sum(map(len, (shown, slow, over_axes, slow_over_axes))), 1)
    sensor_series = (*over_axes, *slow_over_axes)
    orders = {(series.channels, series.what): series_order(series, families=families) for series in sensor_series}

    def described(series: Series) -> Distribution:
        # A change of the random walk changes this Allan deviation too, and is determined more precisely.
        whats = (series.what, "random_walk") if series.what == "adev" else (series.what,)
        sensor = [key for what in whats for key in orders if series.channels[0] in key[0] and key[1] == what]
        order = next((orders[key] for key in sensor if orders[key].effect is not None), None)
        channel = series.channels[0] if len(series.channels) == 1 else stream_name(series.channels[0])
        return distribution(channel, series, families=families, order=order)

    return Distributions(
        values=tuple(map(described, shown)),
        sensors=tuple(map(described, over_axes)),
        slow=tuple(map(described, (*slow, *slow_over_axes))),
        bands=tuple(bands),
    )


def _series(channel: str, what: str, units: Mapping[str, UnitResult]) -> Series | None:
    """The series of a coefficient; None if fewer than half of the units show it."""
    coefficients = {
        name: unit.channels[channel].coefficients[what]
        for name, unit in units.items()
        if what in unit.channels[channel].coefficients
    }
    usable = {name: c for name, c in coefficients.items() if c.value or c.limit}
    limited = np.array([not c.value for c in usable.values()], dtype=bool)
    values = int((~limited).sum())
    if not values or 2 * values < len(coefficients):
        return None
    return Series(
        channels=(channel,),
        what=what,
        units=tuple(usable),
        logs=np.log(np.array([c.value or c.limit for c in usable.values()], dtype=np.float64)),
        errors=np.array([_error(c) for c in usable.values()]),
        limited=limited,
        dates=tuple(units[name].day for name in usable),
    )


def _error(coefficient: UnitCoefficient) -> float:
    """Standard error of the logarithm of a coefficient, from its interval; 0 if it has none."""
    if coefficient.low is None or coefficient.high is None or coefficient.value is None:
        return 0.0
    return math.log(coefficient.high / coefficient.low) / _INTERVAL_WIDTH if coefficient.low > 0 else math.inf


def _long_series(curves: Band, units: Mapping[str, UnitResult]) -> Series | None:
    """Series of the Allan deviations of a channel at a long averaging time that nearly all units have."""
    length = float(np.median([unit.channels[curves.channel].duration for unit in units.values()]))
    table = np.array([curves.curves[name] for name in units if name in curves.curves])
    if not len(table):
        return None
    usable = np.flatnonzero((curves.tau <= length / _LONG) & (np.isfinite(table).mean(axis=0) >= 0.9))
    if not len(usable):
        return None
    column = int(usable[-1])
    names = [name for name in units if name in curves.curves and curves.curves[name][column] > 0]
    return Series(
        channels=(curves.channel,),
        what="adev",
        units=tuple(names),
        logs=np.log([curves.curves[name][column] for name in names]),
        errors=np.zeros(len(names)),
        limited=np.zeros(len(names), dtype=bool),
        tau=float(curves.tau[column]),
        dates=tuple(units[name].day for name in names),
    )


def _over_axes(series: Sequence[Series]) -> list[Series]:
    """Geometric means over the axes of each sensor, for units that show a coefficient on all axes."""
    groups: dict[tuple[str, str], list[Series]] = {}
    for single in series:
        groups.setdefault((stream_name(single.channels[0]), single.what), []).append(single)
    results = []
    for members in groups.values():
        values = [
            {
                name: (log, error, day)
                for name, log, error, is_limit, day in zip(
                    single.units, single.logs, single.errors, single.limited, single.dates, strict=True
                )
                if not is_limit
            }
            for single in members
        ]
        names = [name for name in members[0].units if all(name in part for part in values)]
        if len(members) < 2 or len(names) < len(members[0].units) / 2:
            continue
        table = np.array([[part[name][:2] for part in values] for name in names])
        results.append(
            Series(
                channels=tuple(single.channels[0] for single in members),
                what=members[0].what,
                units=tuple(names),
                logs=table[:, :, 0].mean(axis=1),
                errors=np.sqrt((table[:, :, 1] ** 2).sum(axis=1)) / len(members),
                limited=np.zeros(len(names), dtype=bool),
                tau=members[0].tau,
                dates=tuple(values[0][name][2] for name in names),
            )
        )
    return results
