"""VectorNav sentences, ``$VNYMR,…*68``; lines with a wrong checksum are left out, with a finding."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from sigmatau._native import formats
from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import Place, SkippedMessages
from sigmatau.io.read.formats.damage import fault, largest_expansion, refuse_expansion
from sigmatau.io.read.table import Column, Head, Loaded, Table

_LINE = re.compile(rb"^\$(VN[A-Z]{3}),([^*\r\n$]*)\*[0-9A-Fa-f]{2}(?:[0-9A-Fa-f]{2})?\s*$", re.MULTILINE)
_NUMBER = re.compile(rb"\s*[+-]?(?:\d++(?:\.\d*+)?|\.\d++|nan|inf)(?:[eE][+-]?\d+)?\s*", re.IGNORECASE)
_ALTERNATING = 10  # longest run of other sentences in a log whose sentences alternate
_APPENDED = (b"S", b"T")  # optional fields after those of the sentence


def _xyz(name: str, unit: str) -> list[str]:
    return [f"{name}{axis} [{unit}]" for axis in "XYZ"]


_ANGLES = ["Yaw [deg]", "Pitch [deg]", "Roll [deg]"]
_MAG, _ACCEL, _GYRO = _xyz("Mag", "Gauss"), _xyz("Accel", "m/s^2"), _xyz("Gyro", "rad/s")

# Fields by sentence, from the manuals of VN-100, VN-200 and VN-300. The accelerations of VNYBA and VNYIA lack gravity.
_FIELDS = {
    "VNYMR": [*_ANGLES, *_MAG, *_ACCEL, *_GYRO],
    "VNQMR": ["Quat0", "Quat1", "Quat2", "Quat3", *_MAG, *_ACCEL, *_GYRO],
    "VNMAR": [*_MAG, *_ACCEL, *_GYRO],
    "VNIMU": [*_MAG, *_ACCEL, *_GYRO, "Temp [degC]", "Pressure [kPa]"],
    "VNCMV": [*_MAG, *_ACCEL, *_GYRO, "Temp [degC]"],
    "VNACC": _ACCEL,
    "VNGYR": _GYRO,
    "VNYBA": [*_ANGLES, *_xyz("BodyAccel", "m/s^2"), *_GYRO],
    "VNYIA": [*_ANGLES, *_xyz("InertialAccel", "m/s^2"), *_GYRO],
    "VNDTV": ["DeltaTime [s]", *_xyz("DeltaTheta", "deg"), *_xyz("DeltaVel", "m/s")],
}


def sniff(head: bytes, path: Path) -> bool:
    """Whether at least half the lines are VectorNav sentences."""
    count = sum(1 for _ in _LINE.finditer(head))
    return count > 0 and 2 * count >= sum(1 for line in head.split(b"\n") if line.strip())


def read(path: Path, head: Head) -> tuple[Table, ...]:
    """The sentences of a log, each name a topic."""
    counts: Counter[tuple[str, int]] = Counter()
    for match in _LINE.finditer(head.data):
        fields = match[2].split(b",")
        while fields and fields[-1].startswith(_APPENDED):
            fields.pop()
        if all(_NUMBER.fullmatch(field) for field in fields):
            counts[match[1].decode(), len(fields)] += 1
    widths: dict[str, int] = {}
    for (name, width), _ in counts.most_common():
        widths.setdefault(name, width)
    if not widths:
        raise DataError("has VectorNav sentences but none with numbers")
    return tuple(_table(path, name, width, gzip=head.gzip) for name, width in widths.items())


def _table(path: Path, name: str, width: int, *, gzip: bool) -> Table:
    names = _FIELDS.get(name, [])
    is_documented = len(names) == width
    columns = (
        tuple(Column(name=n) for n in names)
        if is_documented
        else tuple(Column(name=f"field {k + 1}") for k in range(width))
    )

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        try:
            stored = path.stat().st_size
            largest = largest_expansion(stored)
            sentences = formats.read_sentences(
                str(path), name=name, fields=width, wanted=tuple(wanted), max_bytes=largest
            )
        except formats.TextReadError as error:
            if error.kind == "too_large":
                refuse_expansion(stored, None)
            if error.kind == "damaged":
                raise DataError("the compressed data are damaged; copy or record the file again") from None
            raise DataError(f"cannot be read: {error.text}") from None
        rows = len(sentences.columns[0])
        return Loaded(columns=dict(zip(wanted, sentences.columns, strict=True)), findings=_findings(sentences, rows))

    what = "" if is_documented else f"; its {width} fields are not the documented ones and are named by number"
    return Table(
        format="vectornav",
        columns=columns,
        notes=(*(("gzip",) if gzip else ()), f"VectorNav sentences ${name}, checksums verified{what}"),
        load=load,
        where=lambda row: f"row {row} (counted from 0) of ${name}",
        topic=name,
    )


def _findings(sentences: formats.Sentences, rows: int) -> tuple[Finding, ...]:
    findings = []
    if sentences.broken:
        line, what = sentences.examples[0]
        details = SkippedMessages(
            count=sentences.broken, unit="lines", place=Place("line", line), example=what, kept=rows
        )
        findings.append(Finding(details=details, severity="error" if sentences.inner else "info"))
    if sentences.other_count:
        # Sentences that alternate are spread evenly. A longer run than their shares explain means that the sensor was
        # switched.
        longest, line = sentences.gap
        switched = longest > _ALTERNATING + 4 * -(-sentences.other_count // max(rows, 1))
        place = Place("line", line) if switched else None
        details = SkippedMessages(
            count=sentences.other_count, other=True, example=f"${sentences.other_name}", place=place, kept=rows
        )
        findings.append(Finding(details=details, severity="error" if switched else "info"))
    if sentences.cut:
        findings.append(fault(truncated=True, inside="line", kept=rows))
    return tuple(findings)
