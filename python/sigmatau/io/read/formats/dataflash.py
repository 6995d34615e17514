"""ArduPilot logs (DataFlash, .bin): each kind of message is a table, or one table per instance.

``FMT`` defines the messages; ``FMTU``, ``UNIT`` and ``MULT`` define their units. Compiled code follows the chain of messages
and reports where it is truncated. This module interprets the fields.
https://ardupilot.org/dev/docs/code-overview-adding-a-new-log-message.html
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import logs
from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.wording import sentence
from sigmatau.frozen import frozen
from sigmatau.io.read.formats.damage import broken, trailing_bytes
from sigmatau.io.read.table import Column, Head, Loaded, Table

# Format of each type letter. Text and arrays are not read.
_TYPES = {
    "b": "i1",
    "B": "u1",
    "M": "u1",
    "h": "<i2",
    "H": "<u2",
    "i": "<i4",
    "I": "<u4",
    "q": "<i8",
    "Q": "<u8",
    "g": "<f2",
    "f": "<f4",
    "d": "<f8",
    "c": "<i2",
    "C": "<u2",
    "e": "<i4",
    "E": "<u4",
    "L": "<i4",
}
_HUNDREDTHS = "cCeE"  # letters of integers in hundredths

# Units of older logs, which define no units, from ArduPilot's documentation.
_DEFAULT_UNITS = {
    "TimeUS": "us",
    "SampleUS": "us",
    **dict.fromkeys(("GyrX", "GyrY", "GyrZ"), "rad/s"),
    **dict.fromkeys(("AccX", "AccY", "AccZ"), "m/s^2"),
}
_ESTIMATOR = re.compile(r"[ENX]K[A-Z]?\d+")  # EKF1, NKF2, XKF1 … of ArduPilot's Kalman filters
_BIASES = ("GX", "GY", "GZ", "AX", "AY", "AZ")  # biases of gyros and accelerometers in the messages of estimators
_SENSORS = ("IMU", "GYR", "ACC")
_SECONDS = {1e-3: "ms", 1e-6: "us", 1e-9: "ns"}
_SPELLED = {"m/s/s": "m/s^2"}


@frozen(kw_only=False)
class _MessageKind:
    """A kind of message, see `sigmatau._native.logs.scan_dataflash`."""

    number: int
    name: str
    fields: Sequence[tuple[str, str, int]]
    size: int
    instance: int | None
    rows: Sequence[tuple[int, int]]
    several: bool = False  # whether several kinds have this name


def read(path: Path, head: Head) -> tuple[Table, ...]:
    """The messages of a log, by instance: ``IMU[0]``, ``IMU[1]``, ``GYR[0]`` …; ``BARO`` if they have no instances."""
    scan = logs.scan_dataflash(str(path))
    declared = [_MessageKind(*kind) for kind in scan["kinds"]]
    kinds = [replace(kind, several=sum(each.name == kind.name for each in declared) > 1) for kind in declared]
    size, end = path.stat().st_size, int(scan["end"])
    findings = trailing_bytes(path, end, "the last message") if scan["filler"] is not None else broken(scan, size)
    units = _units(kinds, scan["definitions"])
    tables = [
        table
        for kind in kinds
        for instance, rows in kind.rows
        for table in _tables(str(path), end, kind, instance, rows, units.get(kind.number, {}), findings)
    ]
    if not tables:
        because = f": {sentence(findings[0])}" if findings else ""
        raise DataError(f"is an ArduPilot log without data{because}")
    return tuple(tables)


def _tables(
    path: str,
    end: int,
    kind: _MessageKind,
    instance: int,
    rows: int,
    units: Mapping[str, str],
    findings: tuple[Finding, ...],
) -> Iterator[Table]:
    fields = [f for f in kind.fields if f[1] in _TYPES]
    if not any(name not in ("TimeUS", "I") for name, _, _ in fields):
        return
    topic = kind.name if kind.instance is None else f"{kind.name}[{instance}]"
    topic = f"{topic} of kind {kind.number}" if kind.several else topic
    columns = tuple(Column(name=_name(kind.name, name, units.get(name))) for name, _, _ in fields)

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        raw = logs.dataflash_columns(
            path,
            end=end,
            kind=kind.number,
            instance=None if kind.instance is None else (kind.instance, instance),
            rows=rows,
            size=kind.size,
            fields=[(fields[i][2], np.dtype(_TYPES[fields[i][1]]).itemsize) for i in wanted],
        )
        arrays: dict[int, NDArray[Any]] = {}
        for index, column in zip(wanted, raw, strict=True):
            letter = fields[index][1]
            array: NDArray[Any] = column.view(_TYPES[letter])
            arrays[index] = array / 100.0 if letter in _HUNDREDTHS else array
        return Loaded(columns=arrays)

    yield Table(
        format="dataflash",
        columns=columns,
        notes=(),
        load=load,
        where=lambda row: f"message {row + 1} of {topic}",
        topic=topic,
        rows=rows,
        findings=findings,
    )


def _name(kind: str, field: str, unit: str | None) -> str:
    """The name of a column, with its unit. The biases of a Kalman filter (`GX` …) must not look like samples."""
    name = f"{field} bias" if _ESTIMATOR.fullmatch(kind) and field in _BIASES else field
    return name if unit is None else f"{name} [{unit}]"


def _units(kinds: Sequence[_MessageKind], definitions: Sequence[tuple[int, bytes]]) -> dict[int, dict[str, str]]:
    """Units by kind and field. A unit is used if it is defined and its multiplier is 1, or makes ms, us or ns of s."""
    by_number = {kind.number: kind for kind in kinds}
    names: dict[str, str] = {}
    factors: dict[str, float] = {}
    letters: dict[int, tuple[str, str]] = {}
    for place, body in definitions:
        kind = kinds[place]
        match kind.name:
            case "UNIT":
                names[chr(int(_value(kind, body, "Id", 0)) & 0xFF)] = _text(kind, body, "Label")
            case "MULT":
                factors[chr(int(_value(kind, body, "Id", 0)) & 0xFF)] = _value(kind, body, "Mult", np.nan)
            case _:
                number = int(_value(kind, body, "FmtType", -1))
                letters[number] = (_text(kind, body, "UnitIds"), _text(kind, body, "MultIds"))
    units: dict[int, dict[str, str]] = {}
    for number, kind in by_number.items():
        defaults = {
            name: unit
            for name, unit in _DEFAULT_UNITS.items()
            if kind.name.rstrip("0123456789") in _SENSORS or name == "TimeUS"
        }
        by_field = units[number] = {field[0]: defaults[field[0]] for field in kind.fields if field[0] in defaults}
        for (name, letter, _), unit, mult in zip(kind.fields, *letters.get(number, ("", "")), strict=False):
            spelled = names.get(unit, "")
            factor = 1.0 if mult in "-0?" or letter in _HUNDREDTHS else factors.get(mult, np.nan)
            if spelled == "s" and factor in _SECONDS:
                by_field[name] = _SECONDS[factor]
            elif spelled and factor == 1:
                by_field[name] = _SPELLED.get(spelled, spelled)
            elif spelled:
                by_field.pop(name, None)  # remove the default unit: the defined factor has no name
    return units


def _value(kind: _MessageKind, body: bytes, name: str, missing: float) -> float:
    for field, letter, offset in kind.fields:
        if field == name and letter in _TYPES:
            dtype = np.dtype(_TYPES[letter])
            value = float(np.frombuffer(body, dtype, count=1, offset=offset)[0])
            return value if (np.isfinite(value) and abs(value) < 1e6) or name == "Mult" else missing
    return missing


def _text(kind: _MessageKind, body: bytes, name: str) -> str:
    for field, letter, offset in kind.fields:
        if field == name and letter in "nNZ":
            (text,) = struct.unpack_from({"n": "4s", "N": "16s", "Z": "64s"}[letter], body, offset)
            return str(text.split(b"\0", 1)[0], "ascii", "replace")
    return ""
