"""Topics of one device: a depth camera or a flight controller logs its gyro and its accelerometer on topics of their own.

The names of such topics differ only in the word for the sensor: ``camera/gyro/sample`` and ``camera/accel/sample``,
``sensor_gyro:0`` and ``sensor_accel:0``, ``vehicle_angular_velocity`` and ``vehicle_acceleration``.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from sigmatau.io.read.table import Table

_WORDS = {
    "gyro": r"(?i)gyro(?:scope|meter)?s?|(?<![a-z])gyr(?![a-z])|ang(?:ular)?_?(?:vel(?:ocity)?|rate)",
    "accel": r"(?i)(?:lin(?:ear)?_?)?accel(?:eration|erometer)?s?|(?<![a-z])acc(?![a-z])",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Device:
    """The topics of the gyro and of the accelerometer of one device."""

    gyro: Table
    accel: Table

    @property
    def tables(self) -> list[Table]:
        return [self.gyro, self.accel]


def pair_topics(tables: Sequence[tuple[Table, Sequence[str]]]) -> list[Device]:
    """The devices among tables, each with the sensors that its columns have. A table may have the fields of both sensors,
    one of them zero: its name decides.
    """
    gyros: dict[str, list[Table]] = {}
    accels: dict[str, list[Table]] = {}
    for table, sensors in tables:
        for sensor, topics in (("gyro", gyros), ("accel", accels)):
            if sensor in sensors and (rest := _without_sensor(table.topic, sensor)) is not None:
                topics.setdefault(rest, []).append(table)
    return [
        Device(gyro=gyros[rest][0], accel=accels[rest][0])
        for rest in gyros
        if len(gyros[rest]) == 1 and len(accels.get(rest, ())) == 1 and gyros[rest][0] is not accels[rest][0]
    ]


def _without_sensor(topic: str, sensor: str) -> str | None:
    """The name of a topic with a mark for the word of its sensor; None if the name has no such word, or more than one."""
    words = re.findall(_WORDS[sensor], topic)
    return re.sub(_WORDS[sensor], "\0", topic).lower() if len(words) == 1 else None
