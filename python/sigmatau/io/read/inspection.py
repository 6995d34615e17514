"""Inspection of a file without options: tables, columns, rates, damage."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from typing import Any

from sigmatau._version import __version__
from sigmatau.errors import DataError, OptionError, RecordTooShortError
from sigmatau.findings.columns import ColumnsByGravity
from sigmatau.findings.finding import Finding, ranked
from sigmatau.findings.reading import Unusable
from sigmatau.frozen import frozen
from sigmatau.io.read import assemble, opened
from sigmatau.io.read.assemble import choose_tables, sensors
from sigmatau.io.read.column_samples import ColumnSamples, SampledTable
from sigmatau.io.read.columns import choose
from sigmatau.io.read.names import recognise, split_unit
from sigmatau.io.read.options import Options, ReadOptions
from sigmatau.io.read.suggestions import by_gravity
from sigmatau.io.read.table import Table
from sigmatau.io.read.table_streams import Part
from sigmatau.io.read.thermometers import split_thermometers, thermometer_part
from sigmatau.io.read.turn_tables import separate_turns
from sigmatau.record.record import Record
from sigmatau.record.sampling import RateSource
from sigmatau.results import Printed, duration_text, lines_text, plain

_LISTED = 40
_MIN_IN_ONE_LINE = 3  # smallest number of elements of an array that share a line
_ELEMENT = re.compile(r"(.+)\[(\d+)\]")


@frozen
class ColumnInfo:
    """A column of a table.

    Attributes
    ----------
    name : str
        Name as the file spells it; empty if the column has none.
    channel : str or None
        Channel that the column is recognised as, ``"gyro_x"``, ``"time"`` …; None if it is not recognised.
    unit : str or None
        Unit as the file spells it; None if the file states none.
    first : str
        Value in the first row, if the name does not identify the column; else empty.
    """

    name: str
    channel: str | None
    unit: str | None
    first: str = ""


@frozen
class TableInfo:
    """A table of a file.

    Attributes
    ----------
    topic : str
        Name in the file; empty if the file has one table only.
    rows : int or None
        Number of rows; None if they were not counted.
    columns : tuple of ColumnInfo
    rate : float or None
        Sampling rate; None if it was not found. [Hz]
    rate_source : RateSource or None
        How the rate was found; None if it was not.
    notes : tuple of str
        Properties of the table, and conversions on reading.
    findings : tuple of Finding
        Faults of the table.
    chosen : bool
        Whether the table is read by default.
    question : OptionError or None
        Options that must be given before the table can be analysed; `wanting` describes them in words.
    places : mapping of str to int
        Columns that are read, counted from 0, by channel or ``"time"``; also if the table needs further options.
    samples : mapping of int to ColumnSamples
        Contents of the columns, counted from 0, if requested.
    """

    topic: str
    rows: int | None
    columns: tuple[ColumnInfo, ...]
    rate: float | None = None
    rate_source: RateSource | None = None
    notes: tuple[str, ...] = ()
    findings: tuple[Finding, ...] = ()
    chosen: bool = False
    question: OptionError | None = None
    places: Mapping[str, int] = field(default_factory=dict)
    samples: Mapping[int, ColumnSamples] = field(default_factory=dict)

    @property
    def wanting(self) -> str:
        """Options that are needed to analyse it, in words; empty if there are none."""
        return "" if self.question is None else str(self.question)

    def to_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        columns = [{"name": c.name, "channel": c.channel, "unit": c.unit, "first": c.first} for c in self.columns]
        source = "" if self.rate_source is None else str(self.rate_source)
        return plain(self, "topic rows rate_hz=rate notes findings chosen wanting", columns=columns, rate_source=source)


@frozen(eq=False)
class Inspection(Printed):
    """The contents of a file, and the findings about them.

    Attributes
    ----------
    path : str
        The file, as given.
    format : str
        Name of the format.
    tables : tuple of TableInfo
        Tables in the order of the file.
    question : OptionError or None
        Options that must be given before the file can be analysed, such as the topic; `wanting` describes them in words.
    checks : tuple of Finding
        Findings about the samples of the tables that are read by default.
    record : Record or None
        The record that would be analysed; None if options are needed first.

    See Also
    --------
    sigmatau.inspect : makes it.
    """

    path: str
    format: str
    tables: tuple[TableInfo, ...]
    question: OptionError | None = None
    checks: tuple[Finding, ...] = ()
    record: Record | None = None

    @property
    def wanting(self) -> str:
        """Options that are needed to analyse the file, in words; empty if there are none."""
        return "" if self.question is None else str(self.question)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Findings of all tables and samples, each once, errors first."""
        return ranked([*(finding for table in self.tables for finding in table.findings), *self.checks])

    def to_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return {"sigmatau": __version__} | plain(self, "path format wanting tables findings=checks")

    def __repr__(self) -> str:
        lines = (*self.contents(), *map(str, self.findings), *self.wants())
        return lines_text(lines)

    def contents(self) -> list[str]:
        """Lines that describe the tables."""
        lines = [f"{self.path}: {self.format}"]
        for table in self.tables:
            lines += _lines(table, several=len(self.tables) > 1)
        return lines

    def wants(self) -> list[str]:
        """A line with the options that are needed; nothing if there are none."""
        return [f"to analyse it: {self.wanting}"] if self.wanting else []


def _lines(table: TableInfo, *, several: bool) -> list[str]:
    rows = "rows not counted" if table.rows is None else f"{table.rows} rows"
    rate = "" if table.rate is None else f", {table.rate:.6g} Hz ({table.rate_source})"
    length = "" if table.rate is None or not table.rows else f", {duration_text(table.rows / table.rate)}"
    mark = "*" if table.chosen else " "
    lines = [f"{mark} {table.topic}: {rows}{length}{rate}" if several else f"  {rows}{length}{rate}"]
    rows_of_columns = _runs(table.columns)
    width = min(max((len(name) for _, name, _ in rows_of_columns), default=0), 40)
    digits = max(3, *(len(number) for number, _, _ in rows_of_columns[:_LISTED])) if rows_of_columns else 3
    for number, name, column in rows_of_columns[:_LISTED]:
        taken = column.channel or ""
        unit = f" [{column.unit}]" if column.unit else ""
        lines.append(f"    {number:>{digits}} {name:{width}}  {taken}{unit if taken else ''}".rstrip())
    if len(rows_of_columns) > _LISTED:
        lines.append(f"        … {len(table.columns)} columns in all")
    lines += [f"    {note}" for note in table.notes]
    if table.wanting:
        lines.append(f"    to analyse it: {table.wanting}")
    return lines


def _runs(columns: Sequence[ColumnInfo]) -> list[tuple[str, str, ColumnInfo]]:
    """Number, name and column of each line. Elements of an array that are not channels share a line: ``covariance[0]`` to
    ``covariance[8]``.
    """
    lines: list[tuple[str, str, ColumnInfo]] = []
    start = 0
    while start < len(columns):
        end = start + 1
        element = None if columns[start].channel else _ELEMENT.fullmatch(columns[start].name)
        base, first = (element[1], int(element[2])) if element else ("", 0)
        while (
            element
            and end < len(columns)
            and columns[end].channel is None
            and columns[end].name == f"{base}[{first + end - start}]"
        ):
            end += 1
        if end - start < _MIN_IN_ONE_LINE:
            lines += [(str(k + 1), _column_text(columns[k]), columns[k]) for k in range(start, end)]
        else:
            lines.append((f"{start + 1}:{end}", f"{columns[start].name} … [{first + end - start - 1}]", columns[start]))
        start = end
    return lines


def _column_text(column: ColumnInfo) -> str:
    return f"{column.name} ({column.first} …)".lstrip() if column.first else column.name


def inspect(path: str | os.PathLike[str], how: ReadOptions, *, sampled: bool = False) -> Inspection:
    """Inspect the contents and faults of a file, without options.

    Tables with a sensor, and tables that `topic` or `channels` ask for, are read. Other tables are only listed by name.
    With `sampled`, tables that are read have the `samples` of their columns.
    """
    options = how.checked()
    with opened(path, how) as (file, tables):
        question = None
        tables = separate_turns(tables, options)
        pictured = [SampledTable(table) for table in tables] if sampled else []
        tables = [each.table for each in pictured] or tables
        try:
            chosen = choose_tables(tables, options.topic, options.channels)
        except OptionError as error:
            if options.topic:
                raise
            chosen, question = [], error
        chosen, thermometer = split_thermometers(tables, chosen)
        infos = [_list_columns(table) for table in tables]
        parts: dict[int, Part] = {}  # of the chosen tables, by their place in the file
        looked_into: list[int] = []
        for k, table in enumerate(tables):
            is_chosen = any(table is each for each in chosen)
            if is_chosen or (sensors(table) and not options.topic):
                looked_into.append(k)
                asked = options if len(chosen) == 1 else replace(options, channels={})
                infos[k], made = _look_into(table, infos[k], chosen or [table], asked, chosen=is_chosen)
                if made is not None and is_chosen:
                    parts[k] = made
        sources = list(chosen)
        if thermometer is not None and parts:
            warm = thermometer_part(thermometer, options, list(parts.values()))
            if warm is not None:
                place = next(k for k, table in enumerate(tables) if table is thermometer)
                infos[place] = _with_part(replace(infos[place], chosen=True), warm)
                sources.append(thermometer)
                parts[place] = warm
        in_time = assemble.shift_to_one_clock(list(parts.values())) if parts else []
        for k, made in zip(parts, in_time, strict=True):
            infos[k] = replace(infos[k], findings=made.findings)
        merged = assemble.with_topics([(infos[k].topic, infos[k].findings) for k in looked_into]) if looked_into else []
        for k, findings in zip(looked_into, merged, strict=True):
            infos[k] = replace(infos[k], findings=findings)
        for k in range(len(pictured)):
            infos[k] = replace(infos[k], samples=pictured[k].samples())
        record = None
        if chosen and len(parts) == len(sources):
            with contextlib.suppress(OptionError):  # raised again when the record is read
                record = assemble.joined(in_time, sources, file)
    return Inspection(
        path=os.fsdecode(path), format=tables[0].format, tables=tuple(infos), question=question, record=record
    )


def _look_into(
    table: Table, info: TableInfo, tables: Sequence[Table], options: Options, *, chosen: bool
) -> tuple[TableInfo, Part | None]:
    """Add to a table what its samples show, and read its streams if no further options are needed."""
    info = replace(info, chosen=chosen)
    try:
        made = assemble.part_with_data(table, assemble.options_for_table(table, tables, options))
        assemble.refuse_contradictions([made], options)
    except OptionError as error:
        asked = _count_rows(table, replace(info, question=error, places=_named_places(table, options)))
        by_mean = None if options.channels else by_gravity(table)
        return asked if by_mean is None else _by_gravity(asked, (by_mean[1], *asked.findings)), None
    except DataError as error:
        # An empty topic beside a topic that is read is not a fault.
        return (info if isinstance(error, RecordTooShortError) and not chosen else _unusable(info, error)), None
    return _by_gravity(_with_part(info, made), made.findings), made


def _with_part(info: TableInfo, made: Part) -> TableInfo:
    """The table with its rows, rate, conversions and findings."""
    grid = made.streams[0].grid
    return replace(
        info, rows=made.rows, rate=grid.rate, rate_source=grid.source, notes=made.conversions, findings=made.findings,
        places=made.places,
    )  # fmt: skip


def _named_places(table: Table, options: Options) -> Mapping[str, int]:
    """The columns that names or options identify, by channel; empty if none is identified."""
    try:
        return choose(table.columns, options.channels).places
    except OptionError:
        return {}


def _by_gravity(info: TableInfo, findings: tuple[Finding, ...]) -> TableInfo:
    """Add the findings of a table, and the channels that gravity identifies if a finding reports them."""
    channels: dict[int, str] = {}
    for details in (finding.details for finding in findings):
        if isinstance(details, ColumnsByGravity):
            places = {"gyro": details.gyro, "accel": details.accel}
            channels = {first + k: f"{name}_{'xyz'[k]}" for name, (first, _) in places.items() for k in range(3)}
            channels |= {} if details.time is None else {details.time: "time"}
    columns = tuple(
        replace(column, channel=channels.get(number, column.channel)) for number, column in enumerate(info.columns, 1)
    )
    return replace(info, columns=columns, findings=findings)


def _count_rows(table: Table, info: TableInfo) -> TableInfo:
    """Add the number of rows to a table, the first value of each column if no name identifies it, and the findings of
    loading them.
    """
    recognised = [i for i, match in enumerate(recognise(table.columns)) if match is not None]
    wanted = recognised[:1] or list(range(min(len(table.columns), _LISTED)))
    try:
        loaded = table.load(wanted, None)
    except DataError as error:
        return _unusable(info, error)
    rows = len(loaded.columns[wanted[0]])
    columns = list(info.columns)
    for k in () if recognised or not rows else wanted:
        text = table.columns[k].first or f"{loaded.columns[k][0]:.6g}"
        columns[k] = replace(columns[k], first=text)
    return replace(info, rows=rows, columns=tuple(columns), findings=(*info.findings, *loaded.findings))


def _unusable(info: TableInfo, error: DataError) -> TableInfo:
    details = Unusable(reason=error.reason)
    return replace(info, findings=(*info.findings, Finding(details=details, severity="error")))


def _list_columns(table: Table) -> TableInfo:
    """List the columns of a table that is not read."""
    columns = []
    for column, match in zip(table.columns, recognise(table.columns), strict=True):
        stated = split_unit(column)[1] or (match[1] if match else None)
        first = "" if column.name else column.first
        columns.append(ColumnInfo(name=column.name, channel=match[0] if match else None, unit=stated, first=first))
    return TableInfo(
        topic=table.topic, rows=table.rows, columns=tuple(columns), notes=table.notes, findings=table.findings
    )
