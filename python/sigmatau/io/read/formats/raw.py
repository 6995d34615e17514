"""Raw binary files of rows of numbers, with a layout that the user gives."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sigmatau.errors import DataError, OptionError
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import Place
from sigmatau.hints import Hint
from sigmatau.io.read.formats.damage import fault
from sigmatau.io.read.table import Column, Head, Loaded, Table
from sigmatau.record.on_disk import FileRows

_EXAMPLE = '"<u4 time[us],3f4 gyro[rad/s],3f4 accel[m/s^2]"'
_HEADER = re.compile(r"header\s+(\d+)")
_SKIPPED = re.compile(r"(\d*)x")
_FIELD = re.compile(r"([<>]?)\s*(\d*)\s*([iufIUF][1248])\s+([^\s\[\],](?:[^\[\],]*[^\s\[\],])?)\s*(?:\[([^\[\]]*)\])?")
_TYPES = ("i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "f4", "f8")
_LONGEST_ROW = 1 << 20  # largest size of a row [bytes]


def parse_layout(text: str) -> tuple[int, np.dtype[Any], tuple[tuple[Column, str, int | None], ...]]:
    """Bytes of the header, the type of a row, and for each column its field and its index in the field."""
    header, order, offset = 0, "", 0
    names: list[str] = []
    formats: list[np.dtype[Any]] = []
    offsets: list[int] = []
    columns: list[tuple[Column, str, int | None]] = []
    for k, part in enumerate(text.split(",")):
        part = part.strip()
        if k == 0 and (match := _HEADER.fullmatch(part)):
            header = _count(match[1], part)
        elif match := _SKIPPED.fullmatch(part):
            offset += _count(match[1] or "1", part)
        elif match := _FIELD.fullmatch(part):
            order = match[1] or order
            kind, count = match[3].lower(), _count(match[2] or "1", part)
            if kind not in _TYPES:
                raise _wrong(part, f"unknown type {kind}; types: {', '.join(_TYPES)}")
            if not order and kind[1] != "1":
                raise _wrong(
                    part, "the byte order is missing: < (low byte first) or > (high byte first), e.g. <" + part
                )
            name = f"f{len(names)}"
            base = np.dtype((order or "|") + kind)
            if count * base.itemsize > _LONGEST_ROW:
                raise _wrong(part, "the row grows beyond 1 MiB")
            names.append(name)
            formats.append(np.dtype((base, (count,))) if count > 1 else base)
            offsets.append(offset)
            offset += count * base.itemsize
            unit = f" [{match[5]}]" if match[5] else ""
            endings = [""] if count == 1 else [f"_{e}" for e in ("xyz" if count == 3 else range(1, count + 1))]
            for place, ending in enumerate(endings):
                column = Column(name=f"{match[4]}{ending}{unit}")
                columns.append((column, name, None if count == 1 else place))
        else:
            raise _wrong(part, f"a field has a count, a type, a name and a unit, e.g. {_EXAMPLE}")
        if offset > _LONGEST_ROW:
            raise _wrong(part, "the row grows beyond 1 MiB")
    if not columns:
        raise OptionError(f"{{option}} {text!r} has no fields; e.g. {_EXAMPLE}", option="layout")
    row = np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": offset})
    return header, row, tuple(columns)


def _count(text: str, part: str) -> int:
    if len(text) > 9 or int(text) == 0:
        raise _wrong(part, "the number must be from 1 to 999999999")
    return int(text)


def _wrong(part: str, why: str) -> OptionError:
    return OptionError(f"{{option}}: {part!r}: {why}", option="layout")


def read(path: Path, head: Head, layout: object) -> tuple[Table]:
    """Read the columns of a raw file. The numbers stay in the file until they are used."""
    if not isinstance(layout, str) or not layout.strip():
        raise OptionError(f"{{option}} must be text such as {_EXAMPLE}, not {layout!r}", option="layout")
    if head.gzip:
        raise DataError(f"is compressed by gzip, but {Hint('layout')} needs an uncompressed file; decompress it first")
    header, row, columns = parse_layout(layout)
    size = path.stat().st_size
    rows, rest = divmod(max(size - header, 0), row.itemsize)
    if not rows:
        raise DataError(f"has {size} bytes: too few for a row of {row.itemsize} bytes after a header of {header}")
    held = FileRows(path, row, rows, header)

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        return Loaded(columns={index: held.column(*columns[index][1:]) for index in wanted})

    findings: tuple[Finding, ...] = ()
    if rest:
        place = Place("row", rows)
        findings = (
            fault(truncated=True, place=place, inside="row", reason=f"{rest} of {row.itemsize} bytes", kept=rows),
        )
    return (
        Table(
            format="raw",
            columns=tuple(column for column, _, _ in columns),
            notes=(f"{rows} rows of {row.itemsize} bytes" + (f" after a header of {header}" if header else ""),),
            load=load,
            rows=rows,
            findings=findings,
        ),
    )
