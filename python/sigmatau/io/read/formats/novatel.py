"""NovAtel RAWIMU, RAWIMUS, RAWIMUX and RAWIMUSX, ASCII and binary: counts of velocity and angle over a sample interval.

Only RAWIMUX and RAWIMUSX name the type of the sensor, which determines the scale. In other logs, and for types that are not
in the table below, the numbers are counts, and the user must give a scale.
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import Place, SkippedMessages
from sigmatau.io.read.formats.damage import fault
from sigmatau.io.read.table import Column, Head, Loaded, Table
from sigmatau.record.on_disk import file_bytes

_FOOT = 0.3048
_DEGREE = np.pi / 180

# By type of IMU: one count of angle in rad and of velocity in m/s. OEM7 manual, table "Raw IMU Scale Factors".
_SCALES: dict[int, tuple[str, float, float]] = {
    5: ("HG1900 CA29", 2.0**-33, 2.0**-27 * _FOOT),
    8: ("LN200", 2.0**-19, 2.0**-14),
    11: ("HG1700 AG58", 2.0**-33, 2.0**-27 * _FOOT),
    12: ("HG1700 AG62", 2.0**-33, 2.0**-26 * _FOOT),
    26: ("ISA-100C", 1e-9, 2e-8),
    27: ("HG1900 CA50", 2.0**-33, 2.0**-27 * _FOOT),
    28: ("HG1930 CA50", 2.0**-33, 2.0**-27 * _FOOT),
    32: ("STIM300", 2.0**-21 * _DEGREE, 2.0**-22),
    56: ("STIM300D", 2.0**-21 * _DEGREE, 2.0**-22),
    58: ("HG4930 AN01", 2.0**-33, 2.0**-29),
    68: ("HG4930 AN04", 2.0**-33, 2.0**-29),
}

_IDS = {268: "RAWIMU", 325: "RAWIMUS", 1461: "RAWIMUX", 1462: "RAWIMUSX"}
_ASCII = re.compile(rb"[#%](RAWIMU(?:SX|S|X|))A,[^;*#%\r\n]{0,200};([^*#%\r\n]{0,200})\*([0-9A-Fa-f]{8})")
_BEGUN = re.compile(rb"[#%]RAWIMU(?:SX|S|X|)A,")
_ANY = re.compile(rb"^[#%][A-Z][A-Z0-9_]{2,30}A,[^;*\r\n]{0,300};[^*\r\n]*\*[0-9A-Fa-f]{8}\r?$", re.MULTILINE)
_SYNC = re.compile(rb"\xaaD[\x12\x13]")
_WEEK_NS = 604_800_000_000_000
_DTYPE = np.dtype([("time", "i8"), ("type", "i8"), ("counts", "i8", (6,))])


@dataclass(slots=True)
class _Scan:
    """Rows by the name of the log, and the places of bytes that are not part of a complete message."""

    rows: dict[str, list[tuple[int, int, tuple[int, ...]]]] = field(default_factory=dict)
    broken: list[int] = field(default_factory=list)  # positions
    end: int = 0  # end of the last whole message
    whole: int = 0  # number of complete messages; in binary logs, of all names


def sniff(head: bytes, path: Path) -> bool:
    """Whether the file begins with a RAWIMU log, or with other NovAtel logs and contains a RAWIMU later."""
    has_other_logs = any(b"RAWIMU" not in match[0][:8] for match in _ANY.finditer(head))
    if _BEGUN.search(head) is None and _SYNC.search(head) is None and not has_other_logs:
        return False
    scan = _scan(head)
    if scan.rows or not (has_other_logs or scan.whole):
        return bool(scan.rows)
    data = file_bytes(path).data
    return scan.whole > 0 or _BEGUN.search(data) is not None or _SYNC.search(data) is not None


def read(path: Path, head: Head) -> tuple[Table, ...]:
    """Read the logs of a file. Each name is a topic; only messages with a valid CRC-32 are used."""
    data = file_bytes(path).tobytes()
    scan = _scan(data)
    rest = data[scan.end : scan.end + 400]
    if not scan.rows:
        raise DataError(
            f"is a NovAtel log without RAWIMU, RAWIMUS, RAWIMUX or RAWIMUSX; log one of them ({scan.whole} others)"
        )
    findings = _findings(scan, rest)
    return tuple(_table(name, np.array(rows, dtype=_DTYPE), findings) for name, rows in scan.rows.items())


def _scan(data: bytes) -> _Scan:
    scan = _Scan()
    if _SYNC.search(data):
        for name, body in _messages(data, scan):
            _take_binary(name, body, scan)
    good = 0
    for match in _ASCII.finditer(data):
        start = match.start() + 1
        if _crc(data[start : match.end() - 9]) == int(match[3], 16) and _take_ascii(match[1].decode(), match[2], scan):
            good += 1
            scan.whole += 1
            scan.end = max(scan.end, match.end())
        else:
            scan.broken.append(match.start())
    begun = [match.start() for match in _BEGUN.finditer(data)]
    if good < len(begun):
        whole = {match.start() for match in _ASCII.finditer(data)}
        scan.broken.extend(start for start in begun if start not in whole)
    scan.broken.sort()
    return scan


def _crc(data: bytes) -> int:
    # NovAtel starts at 0 and does not invert the result; zlib inverts both.
    return zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


def _messages(data: bytes, scan: _Scan) -> Iterator[tuple[str, bytes]]:
    position, size = 0, len(data)
    while (position := data.find(b"\xaaD", position)) >= 0 and position + 12 <= size:
        kind = data[position + 2]
        if kind == 0x12:
            header, length = data[position + 3], int.from_bytes(data[position + 8 : position + 10], "little")
        elif kind == 0x13:
            header, length = 12, data[position + 3]
        else:
            position += 2
            continue
        end = position + header + length
        message = data[position:end]
        if header >= 12 and end + 4 <= size and _crc(message) == int.from_bytes(data[end : end + 4], "little"):
            name = _IDS.get(int.from_bytes(message[4:6], "little"))
            if name is not None:
                yield name, message[header:]
            scan.whole += 1
            position = end + 4
            scan.end = position
        else:
            if int.from_bytes(data[position + 4 : position + 6], "little") in _IDS:
                scan.broken.append(position)
            position += 2


def _take_binary(name: str, body: bytes, scan: _Scan) -> None:
    if len(body) < 40:
        return
    if name.endswith("X"):
        kind, week, seconds, _, *counts = struct.unpack_from("<xBHdI6i", body)
    else:
        kind, (week, seconds, _, *counts) = 0, struct.unpack_from("<IdI6i", body)
    if 0 <= seconds < 604_801 and week < 10_000:
        scan.rows.setdefault(name, []).append((_stamp(week, seconds), kind, tuple(counts)))


def _take_ascii(name: str, body: bytes, scan: _Scan) -> bool:
    fields = body.split(b",")
    kind = 0
    try:
        if name.endswith("X"):
            kind, fields = int(fields[1]), fields[2:]
        week, seconds, counts = int(fields[0]), float(fields[1]), tuple(int(f) for f in fields[3:])
    except (ValueError, IndexError):
        return False
    if len(counts) != 6 or not (0 <= seconds < 604_801 and 0 <= week < 10_000) or max(map(abs, counts)) >= 1 << 31:
        return False
    scan.rows.setdefault(name, []).append((_stamp(week, seconds), kind, counts))
    return True


def _stamp(week: int, seconds: float) -> int:
    return week * _WEEK_NS + round(seconds * 1e9)


def _table(name: str, rows: NDArray[Any], findings: tuple[Finding, ...]) -> Table:
    kinds = np.unique(rows["type"]).tolist()
    scales = _SCALES.get(kinds[0]) if len(kinds) == 1 and name.endswith("X") else None
    units = ("", "") if scales is None else (" [rad]", " [m/s]")
    columns = (
        Column(name="time [ns]"),
        *(Column(name=f"delta_theta_{axis}{units[0]}") for axis in "xyz"),
        *(Column(name=f"delta_vel_{axis}{units[1]}") for axis in "xyz"),
    )
    if scales is not None:
        note = f"counts of the {scales[0]} by its published scale"
    elif name.endswith("X"):
        note = f"counts: the scale of IMU type {', '.join(map(str, kinds))} is not known"
    else:
        note = f"counts: {name} does not name the sensor"

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        raw: dict[int, NDArray[Any]] = {}
        for index in wanted:
            if index == 0:
                raw[0] = rows["time"] if exact == 0 else rows["time"].astype(np.float64)
                continue
            gyro, axis = index <= 3, (index - 1) % 3
            # Order in the log: z, -y, x; velocity first.
            counts = rows["counts"][:, (3 if gyro else 0) + 2 - axis].astype(np.float64)
            scale = 1.0 if scales is None else scales[1] if gyro else scales[2]
            raw[index] = counts * (-scale if axis == 1 else scale)
        return Loaded(columns=raw)

    return Table(
        format="novatel",
        columns=columns,
        notes=(f"NovAtel {name}, CRC-32 verified", note),
        load=load,
        where=lambda row: f"row {row} (counted from 0) of {name}",
        topic=name,
        rows=len(rows),
        findings=findings,
    )


def _findings(scan: _Scan, rest: bytes) -> tuple[Finding, ...]:
    findings = []
    rows = sum(map(len, scan.rows.values()))
    inner = [start for start in scan.broken if start < scan.end]
    if inner:
        details = SkippedMessages(count=len(inner), place=Place("byte", inner[0]), kept=rows)
        findings.append(Finding(details=details, severity="error"))
    if rest.strip(b"\r\n\0 "):
        place = Place("byte", scan.end)
        findings.append(fault(truncated=True, place=place, inside="message", kept=rows, counted="messages"))
    return tuple(findings)
