"""The stretches of a record that an analysis used, and the record with nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sigmatau.arrays import Floats, Ints
from sigmatau.errors import OptionError
from sigmatau.record.record import Record
from sigmatau.record.streams import Stream


def span_samples(spans: Floats, stream: Stream) -> Ints:
    """Spans in samples of a stream, within it; shape (n, 2)."""
    found = np.round((spans - stream.grid.lead) / stream.grid.tau0).astype(np.int64)
    return np.clip(found, 0, stream.grid.n)


def only_used(record: Record, used: Mapping[str, Floats]) -> Record:
    """The record with the stretches that an analysis used: cut to them, and all between them missing.

    Parameters
    ----------
    record : Record
        As it was given to the analysis.
    used : mapping of str to ndarray, shape (n, 2)
        `Analysis.used`.

    Raises
    ------
    OptionError
        If the record has none of the channels, or ends before the stretches do.
    """
    streams = [_only_used(stream, used) for stream in record.streams if not used.keys().isdisjoint(stream.channels)]
    if not streams:
        raise OptionError("{option} has none of the channels of the analysis", option="record")
    return replace(record, streams=tuple(streams))


def _only_used(stream: Stream, used: Mapping[str, Floats]) -> Stream:
    stream = stream.of([channel for channel in stream.channels if channel in used])
    spans = {channel: span_samples(used[channel], stream) for channel in stream.channels}
    last = max(float(used[channel][-1, 1]) for channel in stream.channels)
    if last > stream.grid.lead + (stream.grid.n + 0.5) * stream.grid.tau0:
        raise OptionError("{option} is shorter than the record of the analysis", option="record")
    first, stop = min(int(one[0, 0]) for one in spans.values()), max(int(one[-1, 1]) for one in spans.values())
    part = stream.cut(first, stop)
    if all(len(one) == 1 and tuple(one[0]) == (first, stop) for one in spans.values()) and part.mask is None:
        return part
    missing = np.ones((part.grid.n, len(part.channels)), dtype=bool)
    for k, one in enumerate(spans.values()):
        for start, end in one - first:
            missing[start:end, k] = False
    return replace(part, samples=replace(part.samples, missing=missing), mask=missing if missing.any() else None)
