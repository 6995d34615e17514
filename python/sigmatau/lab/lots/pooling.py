"""Distributions of a lot by sensor: its channels are combined, as tables and charts show them."""

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
    """Values of a coefficient of all channels of a sensor in all units of the lot; numbers are in `unit`."""

    sensor: str
    what: str
    label: str
    unit: str
    factor: float  # size of the unit in SI
    limits: tuple[float, ...]
    distributions: Sequence[Distribution]  # one for each channel

    @property
    def title(self) -> str:
        """Sensor and coefficient."""
        return f"{self.sensor}: {self.label}"

    @property
    def units(self) -> int:
        """Number of units that show the coefficient."""
        return len({name for distribution in self.distributions for name in distribution.units})

    @property
    def values(self) -> Floats:
        """All values."""
        return np.concatenate([distribution.values for distribution in self.distributions]) / self.factor

    @property
    def spread(self) -> float:
        """Relative standard deviation over the units: the median over the channels."""
        return float(np.median([distribution.spread for distribution in self.distributions]))

    @property
    def outliers(self) -> dict[tuple[str, str], float]:
        """Outliers by unit and channel, each as a ratio to the median."""
        return {(name, d.channel): ratio for d in self.distributions for name, ratio in d.outliers.items()}


def pooled(lot: Lot) -> list[Pooled]:
    """Combine the distributions of the channels of each sensor."""
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
