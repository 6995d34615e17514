"""Options of reading, shared by all commands that take a log."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from sigmatau.cli.options import key_numbers, key_values, reading
from sigmatau.io.read import read
from sigmatau.record.record import Record

__all__ = ["Reading", "read_log"]


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Reading:
    """Options of reading.

    Parameters
    ----------
    rate
        Sampling rate in Hz. Default: computed from the time stamps of the log.
    unit
        Unit of a sensor, a channel or the time: gyro=deg/s, accel_x=g, time=ns. Required if the log does not state it.
    topic
        Topic, message or variable to read if the log contains several: one, or one for each sensor.
    layout
        Fields of a row of a raw binary file, e.g. "<u8 time[us],3f4 gyro[rad/s],3f4 accel[m/s^2]"; 4x skips 4 bytes.
    channels
        Columns of the channels, by name or number from 1: gyro_x=wx, time=1, gyro=2:4. Other names add further signals.
        time=none ignores the time stamps.
    input
        Content of the columns: rates, increments per sample, or accumulated angle and velocity.
    scale
        Factor from counts or volts to the unit, gyro=1/131: value = (reading - offset) × scale.
    offset
        Reading at zero, in counts or volts: gyro=2048.
    """

    rate: float | None = None
    unit: Annotated[list[str] | None, Parameter(negative=())] = None
    topic: Annotated[list[str] | None, Parameter(negative=())] = None
    layout: str | None = None
    channels: Annotated[list[str] | None, Parameter(negative=())] = None
    input: Literal["rate", "increments", "accumulated"] = "rate"
    scale: Annotated[list[str] | None, Parameter(negative=())] = None
    offset: Annotated[list[str] | None, Parameter(negative=())] = None

    def options(self) -> dict[str, Any]:
        """Arguments of `sigmatau.read`."""
        return {
            "rate": self.rate,
            "unit": key_values(self.unit or [], "unit", "gyro=deg/s"),
            "topic": self.topic,
            "layout": self.layout,
            "channels": key_values(self.channels or [], "channels", "gyro_x=wx"),
            "input": self.input,
            "scale": key_numbers(self.scale or [], "scale", "gyro=0.01"),
            "offset": key_numbers(self.offset or [], "offset", "gyro=2048"),
        }


def read_log(log: Path, how: Reading | None, *, quiet: bool) -> Record:
    """Read the record, with progress on the terminal."""
    options = (how or Reading()).options()
    with reading(log, quiet=quiet):
        return read(log, **options)
