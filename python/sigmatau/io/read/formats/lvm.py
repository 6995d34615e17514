"""LabVIEW measurement files, ``.lvm``: tables of text in segments, each with a header of tags.

Specification: NI, "Specification for the LabVIEW Measurement File (.lvm)", tutorial 4139.
"""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.hints import WITHOUT_STAMPS
from sigmatau.io.read.formats.damage import read_contents
from sigmatau.io.read.formats.layout import Layout
from sigmatau.io.read.formats.text_rows import Text
from sigmatau.io.read.table import Column, Head, Loaded, Table, select_columns
from sigmatau.record.sampling import RateSource

MARK = b"LabVIEW Measurement"
_END = b"***End_of_Header***"
_SPECIAL = re.compile(rb"\*\*\*Start_Special\*\*\*.*?\*\*\*End_Special\*\*\*[^\n]*", re.DOTALL)
_COPIES = 3  # copies of the file in memory while it is read
_TAG_LINES = 64  # largest number of lines of a segment's header; the specification has 13 tags
_DIGITS = b"0123456789+-.,eE\t\r\n ;"


@frozen
class _Segment:
    """A header of tags and the rows below it."""

    names: tuple[str, ...]  # Names of the columns, except that of comments
    tags: Mapping[str, tuple[str, ...]]  # Values by tag, one for each channel
    start: int  # First byte of its rows
    end: int  # Byte after its rows
    rows: int  # Lines that are not blank

    def number(self, tag: str, point: str) -> float | None:
        """The value of a tag for the first channel; None if the tag is absent."""
        values = _numbers(self.tags.get(tag, ()), point)
        return values[0] if values else None

    def units(self) -> tuple[str, ...]:
        """Units of the Y columns."""
        return self.tags.get("Y_Unit_Label", ())

    def began(self) -> float | None:
        """Date and time in the header as seconds since 1970; None if they are absent."""
        try:
            day = dt.date.fromisoformat(self.tags["Date"][0].replace("/", "-"))
            hours, minutes, seconds = self.tags["Time"][0].replace(",", ".").split(":")
            return (day.toordinal() - 719_163) * 86_400 + int(hours) * 3600 + int(minutes) * 60 + float(seconds)
        except (KeyError, IndexError, ValueError):
            return None


def read(path: Path, head: Head) -> tuple[Table, ...]:
    """Read the segments of a file. Segments with the same columns and units form one table."""
    return read_tables(path, head, path.stem)


def read_tables(source: Path | bytes, head: Head, name: str, topic: str = "") -> tuple[Table, ...]:
    """The tables of a file, or of text in memory. `topic` is the name of a single table, or the prefix of several
    names.
    """
    contents = read_contents(source, head, copies=_COPIES)
    data = contents.data
    tags_end = data.find(_END)
    if tags_end < 0:
        raise DataError("has no end of its header (***End_of_Header***): it was truncated; record the file again")
    separator = _separator(data[:tags_end])
    tags = _tags(data[:tags_end], separator)
    point = tags.get("Decimal_Separator", (".",))[0] or "."
    x_columns = tags.get("X_Columns", ("One",))[0].lower()
    data = _SPECIAL.sub(lambda match: b"\n" * match[0].count(b"\n"), data)
    segments = _segments(data, _line_end(data, tags_end), separator)
    by_columns: dict[tuple[tuple[str, ...], ...], list[_Segment]] = {}
    for segment in segments:
        if segment.rows:
            by_columns.setdefault((segment.names, segment.units()), []).append(segment)
    if not by_columns:
        raise DataError("has headers but no rows")
    tables = []
    for alike in by_columns.values():
        place = f"segment {segments.index(alike[0]) + 1}" if len(by_columns) > 1 else ""
        table = _table(data, alike, separator, point, x_columns, "/".join(filter(None, (topic, place))))
        tables.append(
            replace(
                table,
                notes=(*(("gzip",) if head.gzip else ()), *table.notes),
                findings=(*table.findings, *contents.findings),
            )
        )
    return tuple(tables)


def _separator(head: bytes) -> bytes:
    match = re.search(rb"^Separator([\t,;])", head, re.MULTILINE)
    return match[1] if match else b"\t"


def _tags(head: bytes, separator: bytes) -> dict[str, tuple[str, ...]]:
    """The values of each tag in a header."""
    tags: dict[str, tuple[str, ...]] = {}
    for line in head.decode("utf-8", errors="replace").splitlines():
        name, *values = line.rstrip().split(separator.decode())
        tags[name.strip()] = tuple(value.strip() for value in values)
    return tags


def _line_end(data: bytes, start: int) -> int:
    end = data.find(b"\n", start)
    return len(data) if end < 0 else end + 1


def _header_start(data: bytes, mark: int) -> int:
    """Offset of the lines of tags above the end of a header."""
    start = mark
    for _ in range(_TAG_LINES):
        above = data.rfind(b"\n", 0, max(start - 1, 0)) + 1
        line = data[above:start].strip()
        if above == start or (line and not line[:1].isalpha()):
            break
        start = above
    return start


def _segments(data: bytes, start: int, separator: bytes) -> list[_Segment]:
    """Find the segments below the header of the file. If no segment has a header, all rows are one segment."""
    marks = []
    mark = data.find(_END, start)
    while mark >= 0:
        marks.append(mark)
        mark = data.find(_END, mark + 1)
    headers = [(max(_header_start(data, mark), start), mark) for mark in marks] or [(start, start)]
    segments = []
    for k, (begin, mark) in enumerate(headers):
        named = _line_end(data, mark) if marks else start
        first = _line_end(data, named)
        end = headers[k + 1][0] if k + 1 < len(headers) else len(data)
        names = _names(data[named:first], separator)
        rows = sum(1 for line in data[first:end].split(b"\n") if line.strip())
        tags = _tags(data[begin:mark], separator)
        segments.append(_Segment(names=names, tags=tags, start=first, end=max(end, first), rows=rows))
    return segments


def _names(line: bytes, separator: bytes) -> tuple[str, ...]:
    names = [name.strip().strip('"') for name in line.decode("utf-8", errors="replace").split(separator.decode())]
    while names and (not names[-1] or names[-1].lower() == "comment"):
        names.pop()
    if not names:
        raise DataError("has no names of columns below a header (***End_of_Header***); record the file again")
    return tuple(names)


def _numbers(values: Sequence[str], point: str) -> list[float]:
    try:
        return [float(value.replace(point, ".")) for value in values if value]
    except ValueError:
        return []


def _table(data: bytes, segments: list[_Segment], separator: bytes, point: str, x_columns: str, topic: str) -> Table:
    first = segments[0]
    without_x = x_columns == "no"
    names = first.names if first.names[0].lower() == "x_value" or not without_x else ("X_Value", *first.names)
    steps = _numbers(first.tags.get("Delta_X", ()), point)
    if len(set(steps)) > 1:
        listed = ", ".join(f"{step:g}" for step in sorted(set(steps)))
        raise DataError(f"has channels of different intervals (Delta_X {listed} s); save a file for each interval")
    columns = _columns(first, names)
    text = Text(
        source=_rows_in_place(data, segments, separator, len(names)),
        layout=Layout(
            delimiter=separator.decode(),
            skip_lines=data[: first.start].count(b"\n"),
            columns=columns,
            notes=(),
            decimal_comma=point == ",",
        ),
        encoding="ascii",
        gzip=False,
        dates={},
    )

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        loaded = text.load(wanted, None if without_x else exact)
        if 0 not in loaded.columns or len(segments) == 1:
            return loaded
        times = _times(loaded.columns[0], segments, point, without_x=without_x)
        return replace(loaded, columns={**loaded.columns, 0: times})

    several = f" in {len(segments)} segments" if len(segments) > 1 else ""
    notes = [f"LabVIEW measurement file{several}{' with decimal commas' if point == ',' else ''}"]
    if first.tags.get("Date") and first.tags.get("Time"):
        notes.append(f"begun {first.tags['Date'][0]} {first.tags['Time'][0][:15]} by its header")
    by_steps = without_x and len(segments) == 1
    return Table(
        format="lvm",
        columns=columns[1:] if by_steps else columns,
        notes=tuple(notes),
        load=select_columns(text.load, range(1, len(columns))) if by_steps else load,
        where=lambda row: f"line {text.line(row)}",
        topic=topic,
        rate=1 / steps[0] if by_steps and steps and steps[0] > 0 else None,
        rate_source=RateSource(kind="file", place="Delta_X"),
    )


def _columns(segment: _Segment, names: Sequence[str]) -> tuple[Column, ...]:
    """Names and units of the columns. The first X column is the time, if X is a time."""
    units = list(segment.units())
    in_time = segment.tags.get("X_Dimension", ("Time",))[0].lower() in ("time", "")
    columns = []
    for k, name in enumerate(names):
        if name.lower() == "x_value":
            columns.append(Column(name="time", unit="s") if k == 0 and in_time else Column(name=f"X_Value {k + 1}"))
        else:
            columns.append(Column(name=name, unit=(units.pop(0) or None) if units else None))
    return tuple(columns)


def _rows_in_place(data: bytes, segments: list[_Segment], separator: bytes, columns: int) -> bytes:
    """Blank out headers and other segments, so that lines keep their numbers, and remove comments."""
    pieces, end = [], segments[0].start
    pieces.append(b"\n" * data[:end].count(b"\n"))
    comment = re.compile(rb"^((?:[^%b\r\n]*%b){%d})[^\r\n]*" % (separator, separator, columns), re.MULTILINE)
    for segment in segments:
        rows = data[segment.start : segment.end]
        if rows.translate(None, _DIGITS):
            rows = comment.sub(rb"\1", rows)
        pieces += [b"\n" * data[end : segment.start].count(b"\n"), rows]
        end = segment.end
    return b"".join(pieces)


def _times(x: NDArray[Any], segments: Sequence[_Segment], point: str, *, without_x: bool) -> NDArray[Any]:
    """Times of the rows of all segments. X is offset by the start of its segment if it starts again in each."""
    x = np.array(x, dtype=np.float64)
    ends = np.minimum(np.cumsum([segment.rows for segment in segments]), len(x))
    parts = [slice(a, b) for a, b in zip((0, *ends[:-1].tolist()), ends.tolist(), strict=True) if b > a]
    if without_x:
        for segment, part in zip(segments, parts, strict=False):
            step = segment.number("Delta_X", point)
            if step is None:
                raise DataError(f"a header of a segment has no Delta_X; give the rate by {WITHOUT_STAMPS}")
            x[part] = (segment.number("X0", point) or 0.0) + step * np.arange(part.stop - part.start)
    again = any(x[b.start] <= x[a.stop - 1] for a, b in pairwise(parts))
    starts = [segment.began() for segment in segments]
    origin = starts[0]
    if again and origin is not None:
        for start, part in zip(starts, parts, strict=False):
            x[part] += 0.0 if start is None else start - origin
    return x
