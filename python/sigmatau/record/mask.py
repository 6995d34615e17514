"""Samples of a channel that an analysis did not use, and the reason of each stretch."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import accumulate, chain, pairwise
from typing import Any

import numpy as np

from sigmatau.arrays import Bools, Floats, Ints, distinct, run_edges
from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.record.record import Record
from sigmatau.record.streams import Stream
from sigmatau.results import Tabular

MAX_LISTED = 1000
"""Number of stretches up to which JSON lists first and last samples. Longer lists would dominate the file; run lengths take
a tenth.
"""

_MISSING = "missing"  # reason of samples that were not recorded or are not a number


@frozen(kw_only=False)
class ExcludedSpan:
    """A stretch of samples that an analysis did not use.

    Attributes
    ----------
    start, stop : int
        First sample, and the sample after the last, from the beginning of the record.
    reason : str
        ``"missing"`` for samples that the record does not have, ``"window"`` for those outside the window that was asked
        for; otherwise the code of the finding for which they were left out: ``"spikes"``, ``"left_out"`` …
    """

    start: int
    stop: int
    reason: str


@frozen(eq=False)
class ChannelMask(Tabular):
    """Samples of a channel that an analysis did not use, and why; as a table, one row per stretch.

    Attributes
    ----------
    channel : str
    samples : int
        Samples of the channel in the record, as it was given to the analysis.
    tau0 : float
        Sample interval. [s]
    lead : float
        Time of the first sample from the beginning of the record. [s]
    spans : tuple of ExcludedSpan
        In order of time; they do not overlap. A sample has the first reason that was found.

    See Also
    --------
    Analysis.mask : gives it.
    """

    channel: str
    samples: int
    tau0: float
    lead: float = 0.0
    spans: tuple[ExcludedSpan, ...] = ()

    @property
    def excluded(self) -> Bools:
        """True where a sample was not used; shape (samples,)."""
        mask = np.zeros(self.samples, dtype=bool)
        for span in self.spans:
            mask[span.start : span.stop] = True
        return mask

    @property
    def used_samples(self) -> Ints:
        """First samples of the stretches that were used, and the samples after them; shape (n, 2)."""
        edges = [0, *(edge for span in self.spans for edge in (span.start, span.stop)), self.samples]
        stretches = np.array(edges, dtype=np.int64).reshape(-1, 2)
        return stretches[stretches[:, 1] > stretches[:, 0]]

    @property
    def used(self) -> Floats:
        """Beginnings and ends of the stretches that were used, from the beginning of the record; shape (n, 2). [s]"""
        used: Floats = np.asarray(self.used_samples * self.tau0 + self.lead, dtype=np.float64)
        used.setflags(write=False)
        return used

    def columns(self) -> dict[str, list[Any]]:
        """One row per stretch, see `Tabular.columns`."""
        return {
            "start": [span.start for span in self.spans],
            "stop": [span.stop for span in self.spans],
            "start_s": [self.lead + span.start * self.tau0 for span in self.spans],
            "stop_s": [self.lead + span.stop * self.tau0 for span in self.spans],
            "reason": [span.reason for span in self.spans],
        }

    def to_dict(self) -> dict[str, Any]:
        """Samples of the record, and stretches by reason; long lists of stretches as texts of `run_lengths`."""
        by_reason: dict[str, list[list[int]]] = {}
        for span in self.spans:
            by_reason.setdefault(span.reason, []).append([span.start, span.stop])
        whole = {"samples": self.samples, "start_s": self.lead}
        if len(self.spans) <= MAX_LISTED:
            return {"excluded": whole | {"spans": by_reason}}
        return {"excluded_runs": whole | {"runs": {reason: run_lengths(pairs) for reason, pairs in by_reason.items()}}}

    def __repr__(self) -> str:
        count = sum(span.stop - span.start for span in self.spans)
        return f"{self.channel}: {count} of {self.samples} samples not used, in {len(self.spans)} stretches"


def run_lengths(pairs: Iterable[Iterable[int]]) -> str:
    """Stretches as text: the number of samples before each stretch and the number in it, in turn."""
    return " ".join(str(b - a) for a, b in pairwise(chain([0], *pairs)))


def stretches_of_runs(text: str) -> list[tuple[int, int]]:
    """The stretches of `run_lengths`; raises `ValueError` for another text."""
    lengths = [int(word) for word in text.split()]
    if any(length < 0 for length in lengths):
        raise ValueError("a length is negative")
    edges = list(accumulate(lengths))
    return list(zip(edges[::2], edges[1::2], strict=True))


@frozen(eq=False)
class Exclusion:
    """Stretches of a channel that a stage of an analysis removes, in samples after the time `start` of the log's clock."""

    channel: str
    reason: str
    start: float
    spans: Ints


def exclusions(part: Stream, mask: Bools | None, reason: str) -> Iterator[Exclusion]:
    """Convert a mask of shape (n, n_channels) to exclusions of a stream; None means no exclusions."""
    if mask is None:
        return
    for k, channel in enumerate(part.channels):
        if len(spans := run_edges(mask[:, k])):
            yield Exclusion(channel=channel, reason=reason, start=part.grid.start, spans=spans)


def excluded_from(before: Record, after: Record, reason: str) -> Iterator[Exclusion]:
    """Exclusions made by a selection, which cuts streams or marks samples as missing."""
    for old, new in zip(before.streams, after.streams, strict=True):
        if new.mask is not old.mask:
            yield from exclusions(new, new.mask, reason)
        first = round((new.grid.start - old.grid.start) / old.grid.tau0)
        outside = np.array([(0, first), (first + new.grid.n, old.grid.n)])
        for channel in new.channels if new.grid.n < old.grid.n else ():
            yield Exclusion(channel=channel, reason=reason, start=old.grid.start, spans=outside)


def channel_masks(whole: Record, excluded: Iterable[Exclusion]) -> dict[str, ChannelMask]:
    """The mask of each channel of a record. A sample with several reasons has the first one."""
    missing = (gap for stream in whole.streams for gap in exclusions(stream, stream.mask, _MISSING))
    by_channel: dict[str, list[Exclusion]] = {channel: [] for channel in whole.channels}
    for exclusion in (*missing, *excluded):
        by_channel[exclusion.channel].append(exclusion)
    masks = {}
    for channel, parts in by_channel.items():
        grid = whole.stream_of(channel).grid
        stretches = [(part.spans + round((part.start - grid.start) / grid.tau0), part.reason) for part in parts]
        spans = tuple(_without_overlap(stretches)) if stretches else ()
        masks[channel] = ChannelMask(channel=channel, samples=grid.n, tau0=grid.tau0, lead=grid.lead, spans=spans)
    return masks


def _without_overlap(stretches: list[tuple[Ints, str]]) -> Iterator[ExcludedSpan]:
    """Spans between the edges of stretches, each with the first reason that covers it."""
    edges = distinct(np.concatenate([spans.ravel() for spans, _ in stretches]))
    first = np.full(len(edges), -1)  # reason of the samples from each edge to the next one
    for k in range(len(stretches) - 1, -1, -1):
        covers = np.zeros(len(edges), dtype=np.int64)
        for edge, change in ((0, 1), (1, -1)):
            np.add.at(covers, np.searchsorted(edges, stretches[k][0][:, edge]), change)
        first[np.cumsum(covers) > 0] = k
    changes = np.concatenate(([0], np.flatnonzero(np.diff(first)) + 1))
    starts, stops = edges[changes].tolist(), [*edges[changes[1:]].tolist(), int(edges[-1])]
    for start, stop, k in zip(starts, stops, first[changes].tolist(), strict=True):
        if k >= 0:
            yield ExcludedSpan(start, stop, stretches[k][1])


def only_used(record: Record, masks: Mapping[str, ChannelMask]) -> Record:
    """Restrict the record to the stretches that an analysis used: it is cut to them, and the samples between them are
    missing.

    Parameters
    ----------
    record : Record
        As it was given to the analysis.
    masks : mapping of str to ChannelMask
        `Analysis.masks`.

    Raises
    ------
    OptionError
        If the record has none of the channels, or ends before the stretches do.
    """
    streams = [_only_used(stream, masks) for stream in record.streams if not masks.keys().isdisjoint(stream.channels)]
    if not streams:
        raise OptionError("{option} has none of the channels of the analysis", option="record")
    return replace(record, streams=tuple(streams))


def _only_used(stream: Stream, masks: Mapping[str, ChannelMask]) -> Stream:
    stream = stream.of([channel for channel in stream.channels if channel in masks])
    used = [masks[channel].used_samples for channel in stream.channels]
    first, stop = min(int(spans[0, 0]) for spans in used), max(int(spans[-1, 1]) for spans in used)
    if stop > stream.grid.n:
        raise OptionError("{option} is shorter than the record of the analysis", option="record")
    part = stream.cut(first, stop)
    if part.mask is None and all(spans.tolist() == [[first, stop]] for spans in used):
        return part
    missing = np.ones((part.grid.n, len(part.channels)), dtype=bool)
    for k, spans in enumerate(used):
        for start, end in spans - first:
            missing[start:end, k] = False
    return replace(part, samples=replace(part.samples, missing=missing), mask=missing if missing.any() else None)
