"""The last step of reading: a record from columns and options."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from sigmatau.errors import OptionError
from sigmatau.io.read.names import recognise
from sigmatau.io.read.options import Options
from sigmatau.io.read.table import Table
from sigmatau.io.read.table_streams import Part, part
from sigmatau.record.record import Checksum, Provenance, Record, stream_name
from sigmatau.record.streams import Stream

__all__ = ["assemble", "joined", "of_table"]


def assemble(tables: Sequence[Table], file: Path | None, options: Options) -> Record:
    """A record from the chosen tables of a file.

    `file`: for its name and checksum; None for a data frame.
    """
    if len(tables) > 1 and options.channels:
        topics = " and ".join(table.topic for table in tables)
        raise OptionError(
            f"--channels applies to one topic, but {topics} are read; choose one by --topic", option="channels"
        )
    return joined([part(table, of_table(table, tables, options)) for table in tables], tables, file)


def joined(parts: Sequence[Part], tables: Sequence[Table], file: Path | None) -> Record:
    """A record from the streams of its tables; raises `OptionError` if two tables have the same sensor."""
    checksum = None if file is None else Checksum(file)
    streams = _one_temperature([stream for each in parts for stream in each.streams])
    for stream in streams:
        if sum(other.name == stream.name for other in streams) > 1:
            topics = " and ".join(table.topic for table in tables)
            raise OptionError(f"{topics} both have {stream.name}; choose one by --topic", option="topic")
    several = len(tables) > 1
    return Record(
        streams=tuple(streams),
        provenance=Provenance(
            path=None if file is None else str(file),
            format=tables[0].format,
            topics=tuple(table.topic for table in tables if table.topic),
            rows=max(each.rows for each in parts),
            conversions=tuple(f"{each.topic}: {c}" if several else c for each in parts for c in each.conversions),
            ignored=tuple(f"{each.topic}: {c}" if several else c for each in parts for c in each.ignored),
            checksum=checksum,
        ),
        findings=tuple(dict.fromkeys(finding for each in parts for finding in each.findings)),
    )


def _one_temperature(streams: list[Stream]) -> list[Stream]:
    """The streams without the second and further temperatures, which were not asked for."""
    first = next((stream for stream in streams if stream.quantity == "temperature"), None)
    return [stream for stream in streams if stream.quantity != "temperature" or stream is first]


def of_table(table: Table, tables: Sequence[Table], options: Options) -> Options:
    """The options without units, scales and offsets of sensors that only the other tables have."""
    if len(tables) == 1:
        return options
    own, others = _sensors(table), {s for other in tables if other is not table for s in _sensors(other)}

    def kept(values: Mapping[str, Any]) -> dict[str, Any]:
        return {
            key: value for key, value in values.items() if stream_name(key) in own or stream_name(key) not in others
        }

    return replace(options, unit=kept(options.unit), scale=kept(options.scale), offset=kept(options.offset))


def _sensors(table: Table) -> set[str]:
    return {stream_name(match[0]) for match in recognise(table.columns) if match is not None and match[0] != "time"}
