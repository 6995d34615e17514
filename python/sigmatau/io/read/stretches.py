"""Streams of a record too large for one process: opened without a pass over their samples, and read in stretches."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from sigmatau.errors import DataError, OptionError
from sigmatau.findings.finding import Finding
from sigmatau.frozen import frozen
from sigmatau.io.read import opened
from sigmatau.io.read.assemble import choose_tables
from sigmatau.io.read.options import Options, ReadOptions
from sigmatau.io.read.resolve import resolve
from sigmatau.io.read.table import Table
from sigmatau.io.read.time.timing import find_stated_contradiction
from sigmatau.options import keywords_of
from sigmatau.record.on_disk import FileColumn
from sigmatau.record.record import Provenance, make_stream, stream_name
from sigmatau.record.sampling import GIVEN_RATE
from sigmatau.record.streams import Stream


@frozen
class Unread:
    """Streams whose samples have not been read yet. A missing sample is NaN when it is read."""

    streams: tuple[Stream, ...]
    source: Provenance
    findings: tuple[Finding, ...]


@keywords_of(ReadOptions)
def unread(path: str | os.PathLike[str], how: ReadOptions) -> Unread:
    """Open the streams of a log whose columns stay in the file: a Zarr store, ``.npy``, or raw binary with `layout`.

    Raises
    ------
    OptionError
        As `sigmatau.read`; also without a rate, because time stamps are not read.
    DataError
        As `sigmatau.read`; also for a log of another format, or with several tables.
    """
    options = how.checked()
    if options.interleaved not in (None, 1):
        raise OptionError(
            "{option} is not for a record in stretches; save each sensor to its own log", option="interleaved"
        )
    with opened(path, how) as (_, tables):
        chosen = choose_tables(tables, options.topic, options.channels)
        if len(chosen) > 1:
            raise DataError("has its sensors in several tables; a record in stretches is of one table")
        streams, loaded = _streams(chosen[0], options)
    source = Provenance(path=os.fsdecode(path), format=chosen[0].format, rows=streams[0].grid.n)
    return Unread(streams=streams, source=source, findings=(*chosen[0].findings, *loaded))


def _streams(table: Table, options: Options) -> tuple[tuple[Stream, ...], tuple[Finding, ...]]:
    choice, unit, overruled = resolve(table, options)
    options = options.for_streams(tuple(dict.fromkeys(map(stream_name, choice.channels))))
    rate = options.rate if options.rate is not None else table.rate
    if rate is None:
        raise OptionError(
            "states no rate, and time stamps of a record in stretches are not read; give {option}", option="rate"
        )
    if options.rate is not None and (contradiction := find_stated_contradiction(table, options)) is not None:
        raise contradiction.error()
    if options.input == "accumulated":
        raise OptionError("{option} accumulated is not for a record in stretches", option="input")
    loaded = table.load(sorted(choice.channels.values()), None)
    if not all(isinstance(column, FileColumn) for column in loaded.columns.values()):
        raise DataError(
            f"is {table.format}, which is not read in stretches: save it as Zarr or .npy, or give a worker more memory"
        )
    by_stream: dict[str, dict[str, np.ndarray[Any, Any]]] = {}
    for channel, index in choice.channels.items():
        by_stream.setdefault(stream_name(channel), {})[channel] = loaded.columns[index]
    streams = tuple(
        make_stream(
            name, columns, rate=rate, unit=unit, kind=options.input, scale=options.scale, offset=options.offset,
            grid_source=GIVEN_RATE if options.rate is not None else table.rate_source, finite=True,
        )
        for name, columns in by_stream.items()
    )  # fmt: skip
    return streams, (*loaded.findings, *overruled)
