"""Distributions of a lot with the channels of a sensor together, as tables and charts show them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.frozen import frozen
from sigmatau.lab.lots.lot_result import Lot
from sigmatau.lab.lots.lot_statistics import Distribution
from sigmatau.lab.lots.lot_words import what_text, what_unit
from sigmatau.record import stream_name


@frozen(eq=False)
class Pooled:
    """A coefficient over all channels of a sensor and all units; numbers are in `unit`."""

    sensor: str
    what: str
    label: str
    unit: str
    factor: float  # of the unit to SI
    limits: tuple[float, ...]
    distributions: Sequence[Distribution]  # of the channels

    @property
    def title(self) -> str:
        """Sensor and coefficient."""
        return f"{self.sensor}: {self.label}"

    @property
    def units(self) -> int:
        """Number of units that show it."""
        return len({name for distribution in self.distributions for name in distribution.units})

    @property
    def values(self) -> Floats:
        """All values."""
        return np.concatenate([distribution.values for distribution in self.distributions]) / self.factor

    @property
    def spread(self) -> float:
        """Relative standard deviation over the units, median of the channels."""
        return float(np.median([distribution.spread for distribution in self.distributions]))

    @property
    def outliers(self) -> dict[tuple[str, str], float]:
        """By unit and channel, the ratio to the median."""
        return {(name, d.channel): ratio for d in self.distributions for name, ratio in d.outliers.items()}


def pooled(lot: Lot) -> list[Pooled]:
    """The distributions of a lot, those of the channels of a sensor together."""
    groups: dict[tuple[str, str], list[Distribution]] = {}
    for distribution in lot.distributions:
        groups.setdefault((stream_name(distribution.channel), distribution.what), []).append(distribution)
    rows = []
    for (sensor, what), members in groups.items():
        quantity, si = lot.quantity_of(members[0].channel)
        unit, factor = what_unit(what, quantity, si, [distribution.median for distribution in members])
        limits = {limit / factor for distribution in members for limit in lot.limits(distribution.channel, what)}
        rows.append(
            Pooled(
                sensor=sensor,
                what=what,
                label=what_text(what, quantity),
                unit=unit,
                factor=factor,
                limits=tuple(sorted(limits)),
                distributions=members,
            )
        )
    order = {sensor: k for k, sensor in enumerate(dict.fromkeys(row.sensor for row in rows))}
    return sorted(rows, key=lambda row: order[row.sensor])
