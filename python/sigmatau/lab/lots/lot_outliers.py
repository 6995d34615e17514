"""Remarks on units whose coefficients or slow noise are outliers of the lot."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from sigmatau.lab.lots.lot_bands import scale
from sigmatau.lab.lots.lot_findings import Outlier, SlowNoise
from sigmatau.lab.lots.lot_remark import Remark, remark
from sigmatau.lab.lots.lot_series import Distributions
from sigmatau.lab.lots.lot_statistics import Distribution
from sigmatau.lab.lots.lot_unit import UnitResult
from sigmatau.lab.lots.lot_words import what_text, what_unit
from sigmatau.noise.terms import SLOW, TERMS
from sigmatau.record import stream_name

_SAME_ON_AXES = 0.5  # smallest deviation of each axis, as a share of that of their mean, for an outlier of all axes
_SLOW = math.log(1.5)
"""Smallest ratio of the Allan deviation at a long averaging time to that of the lot, over the ratio of the whole curve.
Smaller ratios are within the scatter of so few clusters.
"""


def outlier_remarks(
    units: Mapping[str, UnitResult],
    distributions: Distributions,
    *,
    judged: bool,
    scaled: set[tuple[str, str]],
) -> dict[str, list[Remark]]:
    """Remarks by unit; they are notes if there is a specification (`judged`). Units and sensors in `scaled` are skipped."""
    remarks: dict[str, list[Remark]] = {}
    covered: set[tuple[str, str, str]] = set()  # unit, channel, coefficient
    by_channel = {(part.channel, part.what): part for part in distributions.values}
    for part in (*distributions.sensors, *distributions.values):
        for name, ratio in part.outliers.items():
            if (name, stream_name(part.channels[0])) in scaled or (name, part.channel, part.what) in covered:
                continue
            if len(part.channels) > 1:
                if not _is_on_all_axes(name, ratio, [by_channel[channel, part.what] for channel in part.channels]):
                    continue
                covered |= {(name, channel, part.what) for channel in part.channels}
            details = _outlier(part, name, ratio, units[name])
            remarks.setdefault(name, []).append(remark(details, "note" if judged else "lot", part.channels))
    for name, slow, channels in _slow_noise(units, distributions):
        if (name, stream_name(channels[0])) not in scaled:
            remarks.setdefault(name, []).append(remark(slow, "note" if judged else "lot", channels))
    return remarks


def _is_on_all_axes(name: str, ratio: float, axes: Sequence[Distribution]) -> bool:
    """Whether each axis of a sensor differs from the lot in the same direction as their mean, and by a similar factor."""
    mean = math.log(ratio)
    for axis in axes:
        value = float(axis.values[axis.units.index(name)])
        if math.log(value / axis.median) * math.copysign(1.0, mean) < _SAME_ON_AXES * abs(mean):
            return False
    return True


def _outlier(part: Distribution, name: str, ratio: float, unit: UnitResult) -> Outlier:
    channel = unit.channels[part.channels[0]]
    value = float(part.values[part.units.index(name)])
    text, factor = what_unit(part.what, channel.quantity, channel.unit, [value])
    return Outlier(what=what_text(part.what, channel.quantity), value=value, ratio=ratio, unit=text, factor=factor)


def _slow_noise(
    units: Mapping[str, UnitResult], distributions: Distributions
) -> list[tuple[str, SlowNoise, tuple[str, ...]]]:
    """Units with more slow noise than the lot: name, finding, channels. The axes of a sensor share a finding."""
    bands = {band.channel: band for band in distributions.bands}
    named: dict[tuple[str, str], list[tuple[float, float, tuple[str, ...]]]] = {}
    for part in distributions.slow:
        for name, ratio in part.outliers.items():
            scales = [scale(bands[channel], name) or 0.0 for channel in part.channels]
            if math.log(ratio) - max(sum(scales) / len(scales), 0.0) >= _SLOW:
                named.setdefault((name, stream_name(part.channels[0])), []).append((ratio, part.tau, part.channels))
    common = {(part.channel, part.what) for part in distributions.values}
    results = []
    for (name, _), entries in named.items():
        ratio, tau, _ = max(entries)
        channels = tuple(dict.fromkeys(channel for _, _, channels in sorted(entries) for channel in channels))
        ordered = tuple(channel for channel in units[name].channels if channel in channels)
        results.append((name, _details(units[name], ordered, ratio, tau, common), ordered))
    return results


def _details(
    unit: UnitResult, channels: Sequence[str], ratio: float, tau: float, common: set[tuple[str, str]]
) -> SlowNoise:
    """The finding, with the slow term that the unit shows and the lot does not."""
    shown = [
        (coefficient.value * float(TERMS[what].deviation(tau)), what, coefficient.value, unit.channels[channel])
        for channel in channels
        for what in SLOW
        if (coefficient := unit.channels[channel].coefficients.get(what)) is not None
        if coefficient.value and (channel, what) not in common
    ]
    if not shown:
        return SlowNoise(tau=tau, ratio=ratio)
    _, what, value, channel = max(shown, key=lambda entry: entry[0])
    text, factor = what_unit(what, channel.quantity, channel.unit, [value])
    return SlowNoise(
        tau=tau, ratio=ratio, what=what_text(what, channel.quantity), value=value, unit=text, factor=factor
    )
