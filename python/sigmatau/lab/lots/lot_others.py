"""A unit beside the other units of its lot: distributions, outliers, scale, length, rate, channels, copies."""

from __future__ import annotations

import hashlib
import math
from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from sigmatau.frozen import frozen
from sigmatau.lab.lots.lot_findings import OtherAxes, OtherRate, OtherScale, Outlier, SameData, ShortRecord
from sigmatau.lab.lots.lot_remark import Remark, remark
from sigmatau.lab.lots.lot_statistics import Band, Distribution, band, distribution, mistaken_units, scale
from sigmatau.lab.lots.lot_unit import Coefficient, UnitResult
from sigmatau.lab.lots.lot_words import what_text, what_unit
from sigmatau.noise.terms import TERMS
from sigmatau.record import stream_name
from sigmatau.results import printable

_WHATS = (*TERMS, "means_10", "means_100")
_LEAST = 3  # units from which on there is a median to compare with
_OTHER_SCALE = math.log(5)
"""A sensor whose curves are this far from the lot's on all axes has another unit, or is bad; units of a type differ by
tens of per cent."""

_SAME_ON_AXES = math.log(1.5)  # by which the axes of a sensor differ in their scale at most
_SHORT = 0.8  # of the usual length
_OTHER_RATE = 0.02  # relative difference of sampling rates; clocks differ by less
_LEVEL = 3.92  # width of a 95 % interval in standard errors


@frozen(eq=False)
class Distributions:
    """The distributions and the curves of a lot."""

    values: tuple[Distribution, ...]
    bands: tuple[Band, ...]


def distributions_of(units: Mapping[str, UnitResult]) -> Distributions:
    """Distributions of the coefficients that at least half of the units show, and the bands of the curves, by channel."""
    channels: dict[str, dict[str, UnitResult]] = {}
    for name, unit in units.items():
        for channel in unit.channels:
            channels.setdefault(channel, {})[name] = unit
    shown: list[tuple[str, str, dict[str, tuple[float, float]], int]] = []
    bands = []
    for channel, those in channels.items():
        first = next(iter(those.values())).channels[channel]
        alike = {name: one.channels[channel] for name, one in those.items() if one.channels[channel].unit == first.unit}
        curves = {name: (one.tau, one.adev) for name, one in alike.items()}
        bands.append(band(channel, curves, quantity=first.quantity, unit=first.unit))
        for what in _WHATS:
            found = {name: one.coefficients[what] for name, one in alike.items() if what in one.coefficients}
            seen = {name: (one.value, _error(one)) for name, one in found.items() if one.value}
            if seen and 2 * len(seen) >= len(found):
                shown.append((channel, what, seen, len(found) - len(seen)))
    values = tuple(
        distribution(channel, what, seen, below=below, families=len(shown)) for channel, what, seen, below in shown
    )
    return Distributions(values=values, bands=tuple(bands))


def _error(one: Coefficient) -> float:
    """Standard error of the logarithm of a coefficient, from its interval; 0 without one."""
    if one.low is None or one.high is None:
        return 0.0
    return math.log(one.high / one.low) / _LEVEL if one.low > 0 else math.inf


def beside_others(
    units: Mapping[str, UnitResult], distributions: Distributions, *, judged: bool
) -> dict[str, list[Remark]]:
    """Remarks by unit. `judged`: there is a specification, beside which an outlier is only told."""
    found: dict[str, list[Remark]] = {name: [] for name in units}
    there = {name: unit for name, unit in units.items() if unit.channels}
    _same_data(there, found)
    if len(there) >= _LEAST:
        scaled = _other_scales(there, {one.channel: one for one in distributions.bands}, found)
        _outliers(there, distributions.values, found, judged=judged, known=scaled)
        _other_records(there, found)
    return found


def _same_data(units: Mapping[str, UnitResult], found: dict[str, list[Remark]]) -> None:
    """Units whose curves are equal to the last digit: one log under two names."""
    seen: dict[str, str] = {}
    for name, unit in units.items():
        digest = hashlib.sha256()
        for channel, one in sorted(unit.channels.items()):
            digest.update(channel.encode() + one.tau.tobytes() + one.adev.tobytes())
        first = seen.setdefault(digest.hexdigest(), name)
        if first != name:
            found[name].append(remark(SameData(unit=printable(first)), "data"))
            found[first].append(remark(SameData(unit=printable(name)), "data"))


def _other_scales(
    units: Mapping[str, UnitResult], bands: Mapping[str, Band], found: dict[str, list[Remark]]
) -> set[tuple[str, str]]:
    """Units whose sensor has another scale than the lot, told and returned with the sensor."""
    named = set()
    for name, unit in units.items():
        sensors: dict[str, dict[str, float]] = {}
        for channel in unit.channels:
            enough = len(bands[channel].curves) >= _LEAST
            if enough and (ratio := scale(bands[channel], name)) is not None:
                sensors.setdefault(stream_name(channel), {})[channel] = ratio
        for sensor, ratios in sensors.items():
            values = np.array(list(ratios.values()))
            if np.abs(values).min() < _OTHER_SCALE or np.ptp(values) > _SAME_ON_AXES:
                continue
            ratio = math.exp(float(values.mean()))
            quantity = unit.channels[next(iter(ratios))].quantity
            likely = mistaken_units(quantity, ratio)
            named.add((name, sensor))
            found[name].append(remark(OtherScale(ratio=ratio, likely=likely), "lot", tuple(ratios)))
    return named


def _outliers(
    units: Mapping[str, UnitResult],
    distributions: Sequence[Distribution],
    found: dict[str, list[Remark]],
    *,
    judged: bool,
    known: set[tuple[str, str]],
) -> None:
    for one in distributions:
        for name, ratio in one.outliers.items():
            if (name, stream_name(one.channel)) in known:
                continue
            channel = units[name].channels[one.channel]
            value = channel.coefficients[one.what].value
            text, factor = what_unit(one.what, channel.quantity, channel.unit, [value])
            details = Outlier(
                what=what_text(one.what, channel.quantity),
                value=value,
                ratio=ratio,
                unit=text,
                factor=factor,
            )
            found[name].append(remark(details, "note" if judged else "lot", (one.channel,)))


def _other_records(units: Mapping[str, UnitResult], found: dict[str, list[Remark]]) -> None:
    """Records that are shorter, sampled at another rate, or of other channels than those of the lot."""
    lengths = {name: max(one.duration for one in unit.channels.values()) for name, unit in units.items()}
    usual_length = float(np.median(list(lengths.values())))
    sets = Counter(tuple(sorted(unit.channels)) for unit in units.values())
    usual_set, count = sets.most_common(1)[0]
    rates: dict[str, float] = {}
    for channel in dict.fromkeys(channel for unit in units.values() for channel in unit.channels):
        rates[channel] = float(
            np.median([unit.channels[channel].rate for unit in units.values() if channel in unit.channels])
        )
    for name, unit in units.items():
        if lengths[name] < _SHORT * usual_length:
            shorter = ShortRecord(ratio=lengths[name] / usual_length, length=lengths[name])
            found[name].append(remark(shorter, "data"))
        other = [channel for channel, one in unit.channels.items() if abs(one.rate / rates[channel] - 1) > _OTHER_RATE]
        if other:
            rate = OtherRate(rate=unit.channels[other[0]].rate, rate_of_lot=rates[other[0]])
            found[name].append(remark(rate, "data", tuple(other)))
        lacking = tuple(channel for channel in usual_set if channel not in unit.channels)
        extra = tuple(channel for channel in unit.channels if channel not in usual_set)
        if 2 * count > len(units) and (lacking or extra):
            found[name].append(remark(OtherAxes(lacking=lacking, extra=extra), "data"))
