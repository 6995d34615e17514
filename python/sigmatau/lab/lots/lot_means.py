"""Means of a unit compared with the lot: orientation and signs of the axes, gravity, and outlying means.

The mean of an accelerometer is gravity, that of a gyro its bias and the earth rate. A unit with an outlying mean is compared
with all 47 changes of the axes of the lot.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence, Set

import numpy as np

from sigmatau.arrays import SIGMA_OF_MAD, Floats
from sigmatau.frozen import frozen
from sigmatau.lab.lots.axis_changes import AXES, CHANGES, AxisChange
from sigmatau.lab.lots.lot_conditions import CLEAR
from sigmatau.lab.lots.lot_findings import MixedLot, Orientation, OtherMean, OtherScale
from sigmatau.lab.lots.lot_remark import Remark, remark
from sigmatau.lab.lots.lot_statistics import LEAST_UNITS, extreme_values
from sigmatau.lab.lots.lot_unit import UnitChannel, UnitResult
from sigmatau.lab.lots.lot_words import what_unit
from sigmatau.record import stream_name
from sigmatau.units import STANDARD_GRAVITY

_TOLERANCE = 4.5
"""Largest difference between the means of a unit and those that a change of axes predicts, in standard deviations of the
means over the units."""

_TOLERANCE_OF_SIZE = 0.05  # this difference as a share of the mean vector: tilt of the fixture, bias [1]
_DISTINCT = 2.0  # smallest ratio of the difference from the lot to the tolerance, for a change of the axes
# Smallest relative difference of gravity that is reported. [1] Judgement: bias and tilt of a good sensor are below.
_LEAST_SCALE = 0.02
# Smallest and largest ratio of the median mean acceleration to gravity with which a lot shows gravity. [1] Judgement: scale
# errors and biases of working accelerometers are within it, and a record without gravity is far below.
_GRAVITY_FROM, _GRAVITY_TO = 0.5, 2.0
# Smallest difference of an outlying mean from the median, in its standard errors. [1] Judgement: the means of records from
# which the mean was subtracted differ only by rounding.
_SIGNIFICANT = 3.0
_CONFIRMABLE = 0.1  # smallest relative difference of gravity that the noise can confirm [1]
_MOST_WAYS = 2  # largest number of explanations that are named
_ALONG = 0.9  # smallest share of gravity along an axis that is called vertical


@frozen(eq=False)
class SensorMeans:
    """Means of a sensor with three axes over the units of a lot.

    Attributes
    ----------
    sensor : str
        Name of the stream.
    channels : tuple of str
        Its axes x, y, z.
    quantity, unit : str
        Quantity and SI unit of the rate.
    names : tuple of str
        Names of the units.
    values : ndarray, shape (n, 3)
        Means of the axes by unit. [unit]
    errors : ndarray, shape (n, 3)
        Standard errors of the means from the random walk alone; 0 if it is unknown. [unit]
    """

    sensor: str
    channels: tuple[str, ...]
    quantity: str
    unit: str
    names: tuple[str, ...]
    values: Floats
    errors: Floats

    @property
    def center(self) -> Floats:
        """Median of each axis, shape (3,). [unit]"""
        return np.asarray(np.median(self.values, axis=0), dtype=np.float64)

    @property
    def spread(self) -> Floats:
        """Robust standard deviation of each axis, shape (3,). [unit]"""
        return np.asarray(SIGMA_OF_MAD * np.median(np.abs(self.values - self.center), axis=0), dtype=np.float64)

    @property
    def vertical(self) -> int | None:
        """Axis of gravity; None for another quantity, or if it is not along an axis."""
        size = float(np.linalg.norm(self.center))
        axis = int(np.argmax(np.abs(self.center)))
        along = self.quantity == "acceleration" and abs(self.center[axis]) > _ALONG * size
        return axis if along else None

    def changes(self, row: int) -> tuple[AxisChange, ...]:
        """The changes of the axes that explain the means of a unit; empty if its means are those of the lot."""
        tolerance = max(_TOLERANCE * float(self.spread.max()), _TOLERANCE_OF_SIZE * float(np.linalg.norm(self.center)))
        if np.abs(self.values[row] - self.center).max() <= _DISTINCT * tolerance:
            return ()
        return tuple(
            change for change in CHANGES if np.abs(self.values[row] - change.matrix @ self.center).max() <= tolerance
        )


def collect_means(units: Mapping[str, UnitResult]) -> list[SensorMeans]:
    """Collect the means of gyros and accelerometers with three axes, if enough units have them."""
    sensors: dict[tuple[str, str], None] = {}
    for unit in units.values():
        for name, channel in unit.channels.items():
            if channel.quantity in ("angular_rate", "acceleration"):
                sensors.setdefault((stream_name(name), channel.unit))
    results = []
    for sensor, unit_text in sensors:
        channels = tuple(f"{sensor}_{axis}" for axis in AXES)
        rows = {
            name: [unit.channels[channel].mean for channel in channels]
            for name, unit in units.items()
            if all(channel in unit.channels and unit.channels[channel].unit == unit_text for channel in channels)
        }
        means = {name: row for name, row in rows.items() if None not in row}
        if len(means) < LEAST_UNITS:
            continue
        first = units[next(iter(means))].channels[channels[0]]
        values = np.array(list(means.values()), dtype=np.float64)
        errors = np.array([[_error(units[name].channels[channel]) for channel in channels] for name in means])
        results.append(
            SensorMeans(
                sensor=sensor,
                channels=channels,
                quantity=first.quantity,
                unit=first.unit,
                names=tuple(means),
                values=values,
                errors=errors,
            )
        )
    return results


def _error(channel: UnitChannel) -> float:
    """Standard error of the mean by the random walk alone: N/√T."""
    walk = channel.coefficients.get("random_walk")
    return 0.0 if walk is None or walk.value is None else walk.value / math.sqrt(channel.samples / channel.rate)


def compare_means(
    units: Mapping[str, UnitResult],
    remarks: dict[str, list[Remark]],
    levels: Mapping[tuple[str, str], float],
    *,
    without: Set[tuple[str, str]],
    probability: float,
    judged: bool,
) -> set[tuple[str, str]]:
    """Add remarks on orientation, gravity and outlying means; return the units and sensors whose gravity differs.

    `levels`: logarithm of the ratio of the curves to those of the lot, by unit and sensor. `without`: units and sensors that
    already have a remark on their scale. `probability`: probability that a lot without a fault gets a remark.
    """
    sensors = collect_means(units)
    families = sum(3 + (means.quantity == "acceleration") for means in sensors)
    scaled: set[tuple[str, str]] = set()
    outlying: dict[str, list[tuple[SensorMeans, int, list[int]]]] = {}
    for means in sensors:
        share = probability / families
        if (mixed := _mixed_orientations(means)) is not None:
            for name in means.names:
                remarks[name].append(remark(mixed, "note", means.channels))
            continue
        if means.quantity == "acceleration":
            scaled |= _gravity(means, remarks, levels, without=without, probability=share)
        by_row: dict[int, list[int]] = {}
        for axis in range(3):
            for row in extreme_values(means.values[:, axis], probability=share):
                difference = abs(means.values[row, axis] - means.center[axis])
                if difference > _SIGNIFICANT * means.errors[row, axis]:
                    by_row.setdefault(row, []).append(axis)
        for row, axes in by_row.items():
            if (means.names[row], means.sensor) not in scaled | without:
                outlying.setdefault(means.names[row], []).append((means, row, axes))
    for name, outlying_sensors in outlying.items():
        remarks[name] += _orientation(outlying_sensors, judged=judged)
    return scaled


def _gravity(
    means: SensorMeans,
    remarks: dict[str, list[Remark]],
    levels: Mapping[tuple[str, str], float],
    *,
    without: Set[tuple[str, str]],
    probability: float,
) -> set[tuple[str, str]]:
    """Add remarks on units whose gravity differs from that of the lot; if the noise differs too, the scale is wrong."""
    sizes = np.linalg.norm(means.values, axis=1)
    # In a lot without gravity, the length of the mean vector is that of the biases, and its logarithm is skewed.
    if not (sizes > 0).all() or not _GRAVITY_FROM < float(np.median(sizes)) / STANDARD_GRAVITY < _GRAVITY_TO:
        return set()
    logs = np.log(sizes)
    center = float(np.median(logs))
    named: set[tuple[str, str]] = set()
    for row in extreme_values(logs, probability=probability):
        difference, name = float(logs[row]) - center, means.names[row]
        if abs(difference) < _LEAST_SCALE or (name, means.sensor) in without:
            continue
        level = levels.get((name, means.sensor))
        confirmed = abs(difference) >= _CONFIRMABLE and level is not None and abs(level - difference) < abs(level)
        gravity = math.exp(difference)
        details = OtherScale(ratio=math.exp(level) if confirmed and level is not None else 1.0, gravity=gravity)
        remarks[name].append(remark(details, "lot", means.channels))
        named.add((name, means.sensor))
    return named


def _mixed_orientations(means: SensorMeans) -> MixedLot | None:
    """The directions of gravity in a lot, if no direction has two thirds of the units; otherwise None."""
    if means.quantity != "acceleration":
        return None
    sizes = np.linalg.norm(means.values, axis=1)
    along = np.abs(means.values).max(axis=1) > _ALONG * sizes
    if not along.all() or not _GRAVITY_FROM < float(np.median(sizes)) / STANDARD_GRAVITY < _GRAVITY_TO:
        return None
    counts = Counter(map(_direction, means.values))
    if counts.most_common(1)[0][1] >= CLEAR * len(means.names):
        return None
    groups = tuple((f"with gravity along {direction}", count) for direction, count in counts.most_common())
    return MixedLot(factor="orientation", groups=groups)


def _orientation(outlying: Sequence[tuple[SensorMeans, int, list[int]]], *, judged: bool) -> list[Remark]:
    """Remarks on the outlying sensors of a unit: a change of axes that explains all, otherwise one for each sensor."""
    explained = [(means, row, means.changes(row)) for means, row, _ in outlying]
    common = [change for change in CHANGES if all(change in changes for _, _, changes in explained if changes)]
    results, turned = [], [entry for entry in explained if entry[2]]
    if turned:
        groups = [(turned, tuple(common))] if common else [([entry], entry[2]) for entry in turned]
        for members, changes in groups:
            channels = tuple(channel for means, _, _ in members for channel in means.channels)
            results.append(remark(_details(members, changes), "lot", channels))
    explained_sensors = {means.sensor for means, _, _ in turned}
    for means, row, axes in outlying:
        if means.sensor not in explained_sensors:
            results += [_other_mean(means, row, axis, judged=judged) for axis in axes]
    return results


def _details(
    members: Sequence[tuple[SensorMeans, int, tuple[AxisChange, ...]]], changes: tuple[AxisChange, ...]
) -> Orientation:
    vertical, along, along_lot = None, "", ""
    for means, row, _ in members:
        if means.vertical is not None:
            vertical = means.vertical
            along, along_lot = _direction(means.values[row]), _direction(means.center)
    return Orientation(changes=_distinct(changes, vertical), vertical=vertical, along=along, along_lot=along_lot)


def _distinct(changes: Sequence[AxisChange], vertical: int | None) -> tuple[AxisChange, ...]:
    """The first changes whose words differ."""
    by_words: dict[str, AxisChange] = {}
    for change in changes:
        by_words.setdefault(change.words(vertical), change)
    return tuple(by_words.values())[:_MOST_WAYS]


def _direction(vector: Floats) -> str:
    axis = int(np.argmax(np.abs(vector)))
    return f"{'+' if vector[axis] > 0 else '−'}{AXES[axis]}"


def _other_mean(means: SensorMeans, row: int, axis: int, *, judged: bool) -> Remark:
    values = (float(means.values[row, axis]), float(means.center[axis]), float(means.spread[axis]))
    unit, factor = what_unit("means_10", means.quantity, means.unit, [values[0]])
    details = OtherMean(value=values[0], median=values[1], spread=values[2], unit=unit, factor=factor)
    return remark(details, "note" if judged else "lot", (means.channels[axis],))
