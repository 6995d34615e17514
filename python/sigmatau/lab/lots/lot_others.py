"""Comparison of a unit with the other units of its lot: distributions, outliers, scale, length, rate, channels, copies."""

from __future__ import annotations

import hashlib
import math
from collections import Counter
from collections.abc import Collection, Mapping

import numpy as np

from sigmatau.lab.lots.lot_bands import Band, mistaken_units, scale
from sigmatau.lab.lots.lot_findings import OtherAxes, OtherScale, SameData, ShortRecord
from sigmatau.lab.lots.lot_means import compare_means
from sigmatau.lab.lots.lot_outliers import outlier_remarks
from sigmatau.lab.lots.lot_remark import Remark, remark
from sigmatau.lab.lots.lot_series import Distributions
from sigmatau.lab.lots.lot_statistics import MEAN_SHARE
from sigmatau.lab.lots.lot_unit import UnitResult
from sigmatau.record import stream_name
from sigmatau.results import printable

_MIN_UNITS = 3  # smallest number of units that are compared with their median
_OTHER_SCALE = math.log(5)
"""Smallest ratio of the curves of all axes of a sensor to those of the lot that is reported as another scale. Sensors of one
type differ by tens of per cent.
"""

_SAME_ON_AXES = math.log(1.5)  # largest difference of the scale between the axes of a sensor
_SHORT = 0.8  # ratio to the median length below which a record is short [1]


def compare_units(
    units: Mapping[str, UnitResult],
    compared: Collection[str],
    distributions: Distributions,
    remarks: dict[str, list[Remark]],
    *,
    judged: bool,
) -> None:
    """Add remarks by unit.

    `compared`: units under the same conditions, from which the distributions were computed. `judged`: whether there is a
    specification; outliers are then only notes.
    """
    units_with_channels = {name: unit for name, unit in units.items() if unit.channels}
    _same_data(units_with_channels, remarks)
    units_with_channels = {name: unit for name, unit in units_with_channels.items() if name in compared}
    if len(units_with_channels) >= _MIN_UNITS:
        levels = _levels(units_with_channels, {band_.channel: band_ for band_ in distributions.bands})
        scaled = _other_scales(units_with_channels, levels, remarks)
        scaled |= compare_means(
            units_with_channels,
            remarks,
            {key: float(np.mean([*ratios.values()])) for key, ratios in levels.items()},
            without=scaled,
            probability=MEAN_SHARE,
            judged=judged,
        )
        for name, about in outlier_remarks(units_with_channels, distributions, judged=judged, scaled=scaled).items():
            remarks[name] += about
        _other_records(units_with_channels, remarks)


def _same_data(units: Mapping[str, UnitResult], remarks: dict[str, list[Remark]]) -> None:
    """Units whose curves are equal to the last digit, or without curves units of equal logs: one log under two names."""
    first_names: dict[str, str] = {}
    for name, unit in units.items():
        digest = hashlib.sha256()
        for channel, part in sorted(unit.channels.items()):
            digest.update(channel.encode() + part.tau.tobytes() + part.adev.tobytes())
        if not any(len(part.tau) for part in unit.channels.values()):
            digest.update((unit.sha256 or name).encode())
        first = first_names.setdefault(digest.hexdigest(), name)
        if first != name:
            remarks[name].append(remark(SameData(unit=printable(first)), "data"))
            remarks[first].append(remark(SameData(unit=printable(name)), "data"))


def _levels(units: Mapping[str, UnitResult], bands: Mapping[str, Band]) -> dict[tuple[str, str], dict[str, float]]:
    """Logarithm of the ratio of the curve to that of the lot, by unit and sensor and then by channel."""
    levels: dict[tuple[str, str], dict[str, float]] = {}
    for name, unit in units.items():
        for channel in unit.channels:
            enough = len(bands[channel].curves) >= _MIN_UNITS
            if enough and (ratio := scale(bands[channel], name)) is not None:
                levels.setdefault((name, stream_name(channel)), {})[channel] = ratio
    return levels


def _other_scales(
    units: Mapping[str, UnitResult],
    levels: Mapping[tuple[str, str], Mapping[str, float]],
    remarks: dict[str, list[Remark]],
) -> set[tuple[str, str]]:
    """Add remarks on sensors with another scale than the lot; return their units and sensors."""
    named = set()
    for (name, sensor), ratios in levels.items():
        values = np.array(list(ratios.values()))
        if np.abs(values).min() < _OTHER_SCALE or np.ptp(values) > _SAME_ON_AXES:
            continue
        ratio = math.exp(float(values.mean()))
        quantity = units[name].channels[next(iter(ratios))].quantity
        likely = mistaken_units(quantity, ratio)
        named.add((name, sensor))
        remarks[name].append(remark(OtherScale(ratio=ratio, likely=likely), "lot", tuple(ratios)))
    return named


def _other_records(units: Mapping[str, UnitResult], remarks: dict[str, list[Remark]]) -> None:
    """Add remarks on units whose records are shorter, or have other channels, than those of the lot."""
    lengths = {name: max(part.duration for part in unit.channels.values()) for name, unit in units.items()}
    usual_length = float(np.median(list(lengths.values())))
    sets = Counter(tuple(sorted(unit.channels)) for unit in units.values())
    usual_set, count = sets.most_common(1)[0]
    for name, unit in units.items():
        if lengths[name] < _SHORT * usual_length:
            shorter = ShortRecord(ratio=lengths[name] / usual_length, length=lengths[name])
            remarks[name].append(remark(shorter, "data"))
        lacking = tuple(channel for channel in usual_set if channel not in unit.channels)
        extra = tuple(channel for channel in unit.channels if channel not in usual_set)
        if 2 * count > len(units) and (lacking or extra):
            remarks[name].append(remark(OtherAxes(lacking=lacking, extra=extra), "data"))
