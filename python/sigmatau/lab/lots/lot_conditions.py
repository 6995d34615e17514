"""Units of a lot that were recorded under other conditions than the rest: they get a remark, and are not compared."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

from sigmatau.lab.lots.conditions import RATE, SUPPLY, TEMPERATURE, ConditionFactor
from sigmatau.lab.lots.lot_findings import MixedLot, OtherCondition
from sigmatau.lab.lots.lot_remark import Remark, remark
from sigmatau.lab.lots.lot_unit import UnitResult

CLEAR = 2 / 3
"""Smallest share of the units with which a group counts as the lot, and the others as exceptions; without such a group it is
not known which is right. [1] Judgement.
"""


def comparable_units(units: Mapping[str, UnitResult], remarks: dict[str, list[Remark]]) -> dict[str, UnitResult]:
    """Select the units that were recorded under the same conditions, and add remarks on the others.

    If no group of a condition has two thirds of the units, no unit is compared.
    """
    comparable = dict(units)
    for factor in (TEMPERATURE, SUPPLY, RATE):
        for labels in _labels(factor, units):
            counts = Counter(labels.values())
            usual, count = counts.most_common(1)[0]
            if len(counts) < 2:
                continue
            if count < CLEAR * len(labels):
                details = MixedLot(factor=factor.name, groups=tuple(counts.items()))
                for name in labels:
                    if not any(isinstance(earlier.details, MixedLot) for earlier in remarks[name]):
                        remarks[name].append(remark(details, "data"))
                    comparable.pop(name, None)
                continue
            for name, label in labels.items():
                if label != usual:
                    exception = OtherCondition(factor=factor.name, value=label, value_of_lot=usual)
                    if not any(earlier.details == exception for earlier in remarks[name]):
                        remarks[name].append(remark(exception, "data"))
                    comparable.pop(name, None)
    return comparable


def _labels(factor: ConditionFactor, units: Mapping[str, UnitResult]) -> list[dict[str, str]]:
    """The group of each unit; for rates, by channel."""
    if factor is not RATE:
        values = {name: unit.temperature if factor is TEMPERATURE else unit.supply for name, unit in units.items()}
        return [dict(zip(values, factor.groups([*values.values()]), strict=True))] if values else []
    channels = dict.fromkeys(channel for unit in units.values() for channel in unit.channels)
    result = []
    for channel in channels:
        rates = {name: unit.channels[channel].rate for name, unit in units.items() if channel in unit.channels}
        result.append(dict(zip(rates, factor.groups([*rates.values()]), strict=True)))
    return result
