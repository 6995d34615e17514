"""Thermometer topics: messages with only a temperature (``sensor_msgs/Temperature``), in addition to the topics of the
sensors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sigmatau.errors import DataError, OptionError
from sigmatau.io.read.names import temperature_unit
from sigmatau.io.read.options import Options
from sigmatau.io.read.table import Table
from sigmatau.io.read.table_streams import Part, part
from sigmatau.record.thermometers import PLAUSIBLE

_TEMPERATURE = "temperature"
_WITHOUT_VALUE = {"seq", "stamp", "log_time", "variance"}  # fields of such a message besides its value


def split_thermometers(tables: Sequence[Table], chosen: Sequence[Table]) -> tuple[list[Table], Table | None]:
    """Separate the chosen topics into those of sensors and that of a thermometer.

    If no thermometer is chosen, the only one of the file is used, or else the only one whose name begins with that of the
    device: ``/imu/temperature`` for ``/imu/data``.
    """
    sensed = [table for table in chosen if not is_thermometer(table)]
    if not sensed or len(tables) == 1:
        return list(chosen), None
    candidates = [table for table in chosen if is_thermometer(table)]
    candidates = candidates or [table for table in tables if table.rows != 0 and is_thermometer(table)]
    if len(candidates) > 1:
        devices = {table.topic.rpartition("/")[0] or table.topic for table in sensed} | {t.topic for t in sensed}
        candidates = [table for table in candidates if any(table.topic.startswith(f"{device}/") for device in devices)]
    return sensed, candidates[0] if len(candidates) == 1 else None


def _field_name(name: str) -> str:
    """The last field name in the path of a column, without its unit."""
    return name.partition("[")[0].rstrip().rpartition(".")[2]


def is_thermometer(table: Table) -> bool:
    """Whether the messages contain a temperature and nothing else but stamps and its variance."""
    values = {_field_name(column.name) for column in table.columns} - _WITHOUT_VALUE
    return values == {_TEMPERATURE}


def thermometer_part(table: Table, options: Options, sensed: Sequence[Part]) -> Part | None:
    """Read the stream of a thermometer; None if the sensors have a temperature, or if it is unreadable or implausible."""
    if any(stream.quantity == _TEMPERATURE for each in sensed for stream in each.streams):
        return None
    (column,) = (c for c in table.columns if _field_name(c.name) == _TEMPERATURE)
    chosen = replace(
        options,
        channels={_TEMPERATURE: column.name},
        unit={_TEMPERATURE: temperature_unit(column) or "degC"},  # unit that sensor_msgs/Temperature prescribes
        scale={},
        offset={},
        rate=None,
        rates={},
        sensors=(),
        input="rate",
        interleaved=1,
    )
    try:
        made = part(table, chosen)
    except (DataError, OptionError):
        return None
    if not PLAUSIBLE[0] <= float(np.nanmedian(made.streams[0].column(_TEMPERATURE))) <= PLAUSIBLE[1]:
        return None
    return replace(made, conversions=(*made.conversions, f"temperature from column {column.name}"), units_stated=())
