"""Stretches of a record that are left out: their samples are taken for missing, and the grid stays as it is.

A window is one piece; several short stretches can be left out from the middle of a record without losing the rest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sigmatau.errors import OptionError
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.disturbances import LeftOut, LeftOutOfStream
from sigmatau.quality.samples.duplicate_rows import copy_masks
from sigmatau.quality.samples.lost_rows import dropout_masks, stuck_masks
from sigmatau.quality.samples.masking import masked
from sigmatau.quality.selection.time_text import time_of
from sigmatau.record.record import MIN_SAMPLES, Record
from sigmatau.record.streams import Stream
from sigmatau.results import seconds

__all__ = ["from_the_start", "leave_out"]

FAULTS = {"dropouts": dropout_masks, "stuck": stuck_masks, "copies": copy_masks}
"""Faults that can be left out by name: the samples that the findings ``dropout``, ``stuck_samples`` and, of single rows,
``repeated_samples`` are about."""

_FORMS = f"give stretches such as 720s:722s,1080s:1083s, :10s or 2h:, or one of {', '.join(FAULTS)}"
_TO_ROUNDING = 1e-6  # of a sample
_LISTED = 5


def from_the_start(record: Record) -> Record:
    """The record with times of its streams from the beginning of the earliest stream, as options count them."""
    origin = min(stream.grid.start for stream in record.streams)
    if all(stream.grid.lead == stream.grid.start - origin for stream in record.streams):
        return record
    streams = (replace(s, grid=replace(s.grid, lead=s.grid.start - origin)) for s in record.streams)
    return replace(record, streams=tuple(streams))


def leave_out(record: Record, stretches: str | Sequence[str]) -> tuple[Record, list[Finding]]:
    """The record with some stretches taken for missing on all sensors, and the finding ``"left_out"``, an info.

    Parameters
    ----------
    record : Record
    stretches : str or sequence of str
        ``"720s:722s"``, ``"720s:722s,1080s:1083s"``, ``":10s"``, ``"2h:"``: times from the beginning of the record, the end
        not included; units ms, s, min, h, d. Or the name of a fault, see `FAULTS`: its samples, each on its channels.

    Raises
    ------
    OptionError
        For any other text, for a stretch beyond the record, or if fewer than 4 samples are left.
    """
    texts = [stretches] if isinstance(stretches, str) else list(stretches)
    parts = [part.strip() for text in texts for part in text.split(",") if part.strip()]
    if not parts:
        raise OptionError(f"{{option}} names nothing: {_FORMS}", option="leave_out")
    end = max(stream.grid.lead + stream.grid.duration for stream in record.streams)
    spans = [_span(part, end) for part in parts if part not in FAULTS]
    faults = [part for part in dict.fromkeys(parts) if part in FAULTS]
    streams, told = [], list[LeftOutOfStream]()
    for stream in record.streams:
        if stream.quantity == "temperature":  # not disturbed by what disturbs the sensors
            streams.append(stream)
            continue
        bad = np.zeros(stream.grid.n, dtype=bool)
        for start, stop in spans:
            bad[_first_at(stream, start) : _first_at(stream, stop)] = True
        masks = [bad.copy() for _ in stream.channels]
        for fault in faults:
            masks = [mask | more for mask, more in zip(masks, FAULTS[fault](stream), strict=True)]
        if not any(mask.any() for mask in masks):
            streams.append(stream)
            continue
        most = max(int(mask.sum()) for mask in masks)
        told.append(
            LeftOutOfStream(stream=stream.name, count=most, samples=stream.grid.n, duration=most * stream.grid.tau0)
        )
        without = masked(stream, np.stack(masks, axis=1))
        left = 0 if without.mask is None else int((~without.mask).sum(axis=0).max())
        if left < MIN_SAMPLES:
            few = f"{{option}} leaves {left} samples of {stream.name}; at least {MIN_SAMPLES} are needed"
            raise OptionError(few, option="leave_out")
        streams.append(without)
    listed = [f"{seconds(a)} s to {seconds(b)} s" for a, b in spans[:_LISTED]]
    listed += [f"{len(spans) - _LISTED} more"] if len(spans) > _LISTED else []
    listed += faults
    conversions = (*record.provenance.conversions, f"left out as asked: {', '.join(listed)}")
    provenance = replace(record.provenance, conversions=conversions)
    details = LeftOut(faults=tuple(faults), streams=tuple(told))
    finding = Finding(
        details=details, severity="info", spans=tuple(spans), size=float(sum(b - a for a, b in spans)), unit="s"
    )
    return replace(record, streams=tuple(streams), provenance=provenance), [finding]


def _span(text: str, end: float) -> tuple[float, float]:
    first, colon, last = text.partition(":")
    if not colon or ":" in last or not (first.strip() or last.strip()):
        raise OptionError(f"{{option}} {text!r} is not understood: {_FORMS}", option="leave_out")
    start = time_of(first, text, option="leave_out", forms=_FORMS) if first.strip() else 0.0
    stop = time_of(last, text, option="leave_out", forms=_FORMS) if last.strip() else end
    if start >= end:
        raise OptionError(
            f"{{option}} {text!r} begins at {seconds(start)} s; the record is {seconds(end)} s long", option="leave_out"
        )
    if start >= stop:
        raise OptionError(f"{{option}} {text!r} ends at {seconds(stop)} s, before it begins", option="leave_out")
    return start, min(stop, end)


def _first_at(stream: Stream, time: float) -> int:
    """The first sample at a time or after it."""
    at = math.ceil((time - stream.grid.lead) / stream.grid.tau0 - _TO_ROUNDING)
    return min(max(at, 0), stream.grid.n)
