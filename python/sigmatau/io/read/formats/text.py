"""Text tables, such as CSV, plain or gzip-compressed.

`layout` detects the layout. Compiled code reads the rows, checks each line against the layout, and rounds each number to the
nearest double.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from sigmatau.errors import DataError
from sigmatau.io.read.formats.damage import read_contents
from sigmatau.io.read.formats.layout import Layout, find_layout
from sigmatau.io.read.formats.long_rows import join_channels
from sigmatau.io.read.formats.plain_cells import find_decoration
from sigmatau.io.read.formats.row_kinds import Kinds, find_device_column, find_kinds, first_values, rows_of_kind
from sigmatau.io.read.formats.text_beginning import Beginning, find_first_layout, skip_lines
from sigmatau.io.read.formats.text_lines import bare_fields, decode
from sigmatau.io.read.formats.text_programs import (
    GCSV_NOTE,
    ROS_CSV_NOTE,
    find_scales,
    is_imu,
    name_imu,
    name_sensor_logger,
    scale_columns,
    time_mt_manager,
)
from sigmatau.io.read.formats.text_rows import Text, refuse_too_large
from sigmatau.io.read.formats.truncation import last_line
from sigmatau.io.read.instances import is_single_sensor_stated
from sigmatau.io.read.table import HEAD, Head, Load, Loaded, RowKind, Table
from sigmatau.io.read.time.dates import date_columns
from sigmatau.record.sampling import STATED

_NOT_TEXT = (b"%PDF", b"#ROSBAG")
_COPIES = 3  # copies in memory of a file whose cells contain more than numbers
_MAX_DEVICES = 16  # largest number of devices in one file
# smallest number of lines of a damaged table before the first bytes that are not text; a binary file has fewer
_MIN_LINES = 16


def sniff(head: bytes, path: Path) -> bool:
    """Whether the file is text: no control characters, or a table before the first of them."""
    if head.startswith(_NOT_TEXT):
        return False
    beginning = Beginning.decode(head, whole=True)
    if beginning.whole:
        return True
    if beginning.data.count(b"\n") < _MIN_LINES:
        return False
    try:
        find_layout(beginning.data, whole=False)
    except DataError:
        return False
    return True


def read(path: Path, head: Head, *, skip: int = 0) -> tuple[Table, ...]:
    """Read the columns of a text table below `skip` lines; rows are read on demand. If the rows are of several kinds, each
    kind becomes a table.
    """
    return read_tables(path, head, path.name.split(".")[0], skip=skip)


def read_tables(source: Path | bytes, head: Head, name: str, topic: str = "", *, skip: int = 0) -> tuple[Table, ...]:
    """The tables of a file, or of text in memory: one, or one for each kind of its rows. `name` is the name of the file
    without its suffix. `topic` is the name of a single table, or the prefix of several names.
    """
    beginning = Beginning.decode(head.data, whole=head.whole)
    if skip:
        beginning = skip_lines(source, beginning, skip)
    try:
        lines, _ = decode(beginning.data, whole=beginning.whole)
    except DataError:
        lines = ""  # `find_layout` reports the reason
    if beginning.encoding == "ascii" and (decoration := find_decoration(lines)) is not None:
        contents = read_contents(source, head, copies=_COPIES)
        data = decoration.strip(contents.data)
        plain = Head(data=data[:HEAD], whole=head.whole, gzip=False)
        return tuple(
            replace(decoration.apply(table), findings=(*table.findings, *contents.findings))
            for table in read_tables(data, plain, name, topic, skip=skip)
        )
    kinds = find_kinds(lines)
    if kinds is None and not beginning.whole and not is_single_sensor_stated():
        kinds = _find_blocks(source, head, beginning, lines)
    tables = () if kinds is None else join_channels(tuple(_read_kinds(source, head, beginning, lines, kinds, topic)))
    return tuple(tables) or (_make_table(source, head, beginning, name, topic),)


def _find_blocks(source: Path | bytes, head: Head, beginning: Beginning, lines: str) -> Kinds | None:
    """The kinds of rows of devices that are logged one after the other, if the first and the last line are of different
    kinds.
    """
    kinds = find_device_column(lines)
    last = None if kinds is None else last_line(source, beginning.encoding)
    if kinds is None or last is None or kinds.labels == (*bare_fields(last, kinds.delimiter)[kinds.column :], "")[:1]:
        return None
    try:
        numbers = _make_table(source, head, beginning, "", "").load([kinds.column], None).columns[kinds.column]
    except DataError:
        return None  # raised again when the table is read
    devices = np.unique(numbers[np.isfinite(numbers)])
    if not 1 < len(devices) <= _MAX_DEVICES or np.any(devices % 1):
        return None
    decimals = kinds.labels[0].partition(".")
    return replace(kinds, labels=tuple(f"{device:.0f}{''.join(decimals[1:])}" for device in devices), are_late=True)


def _read_kinds(
    source: Path | bytes, head: Head, beginning: Beginning, lines: str, kinds: Kinds, topic: str
) -> Iterator[Table]:
    """Read a table for each kind of rows that has a layout."""
    from sigmatau.io.read.instance_tables import with_sensor_names

    first: Layout | None = None
    for label in kinds.labels:
        rows = rows_of_kind(lines, kinds, label)
        kind_text, skip = rows.text, beginning.skip
        try:
            layout = find_layout(kind_text.encode(), whole=beginning.whole, encoding=beginning.called, skip=skip)
        except DataError:
            if first is not None and kinds.are_late:  # the rows of this device begin below the head
                late = kinds.find_kind(label)
                described = replace(first, notes=(*first.notes, late.describe_rows()))
                yield _make_table(
                    source, head, beginning, "", f"{topic}/{late.topic}" if topic else late.topic, described, late
                )
            continue  # rows without numbers
        if layout.delimiter != kinds.delimiter or len(layout.columns) <= kinds.column:
            continue
        kind = kinds.find_kind(label)
        further = find_kinds(kind_text, without=kinds.column)
        if further is not None and len(further.labels) > 1:
            both = f"{kind.place()}, and {further.find_kind(label).place()}"
            raise DataError(f"{both}: both show rows of several sensors; save the rows of each sensor to its own file")
        columns, notes = with_sensor_names(layout.columns, label, first_values(kind_text, kinds, label))
        named = replace(
            layout,
            columns=columns,
            notes=(*layout.notes, kind.describe_rows(), *notes),
            skip_lines=skip + rows.numbers[layout.skip_lines - skip] - 1,
        )
        first = first or replace(named, notes=layout.notes)
        yield _make_table(source, head, beginning, "", f"{topic}/{kind.topic}" if topic else kind.topic, named, kind)


def _make_table(
    source: Path | bytes,
    head: Head,
    beginning: Beginning,
    name: str,
    topic: str,
    layout: Layout | None = None,
    kind: RowKind | None = None,
) -> Table:
    if layout is None:
        layout = find_first_layout(source, beginning)
    if beginning.skip:
        skipped = f"the first {beginning.skip} lines skipped" if beginning.skip > 1 else "the first line skipped"
        layout = replace(layout, notes=(*layout.notes, skipped))
    dated, dates = date_columns(layout.columns)
    text = Text(
        source=source,
        layout=replace(layout, columns=dated),
        encoding=beginning.encoding,
        gzip=head.gzip,
        dates=dates,
        kind=kind,
    )

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        if isinstance(source, Path) and not head.gzip:
            refuse_too_large(source, head, len(wanted) + (exact is not None))
        return text.load(wanted, exact)

    columns, program_notes = name_sensor_logger(dated, name)
    loaded: Load = load
    if layout.counts_per_second is not None:
        columns, loaded, counted = time_mt_manager(columns, load, layout.counts_per_second)
        program_notes = (*program_notes, counted)
    if scales := find_scales(beginning.data):
        columns, loaded = scale_columns(columns, loaded, scales)
        program_notes = (*program_notes, GCSV_NOTE)
    if layout.delimiter == "," and is_imu(columns):
        columns, loaded = name_imu(columns, loaded)
        program_notes = (*program_notes, ROS_CSV_NOTE)
    return Table(
        format="text",
        columns=columns,
        notes=(*(("gzip",) if head.gzip else ()), *layout.notes, *program_notes),
        load=loaded,
        rate=None if layout.rate is None else layout.rate.rate,
        rate_source=layout.rate.source if layout.rate else STATED,
        where=lambda row: f"line {text.line(row)}",
        topic=topic,
        kind=kind,
    )
