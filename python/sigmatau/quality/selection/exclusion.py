"""Stretches of a record that are left out: their samples are taken for missing, and the grid stays as it is.

Unlike a window, which is one piece: a knock at minute 18 and a lost link at minute 40 cost two stretches, and not the half
of the record before or behind them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import OptionError
from sigmatau.findings.finding import Finding
from sigmatau.quality.samples.duplicate_rows import copy_masks
from sigmatau.quality.samples.lost_rows import dropout_masks, stuck_masks
from sigmatau.quality.samples.masking import masked
from sigmatau.quality.selection.time_text import time_of
from sigmatau.record.record import MIN_SAMPLES, Record
from sigmatau.record.streams import Stream
from sigmatau.results import duration_text, seconds

__all__ = ["KINDS", "from_the_start", "leave_out"]

KINDS = {"dropouts": dropout_masks, "stuck": stuck_masks, "copies": copy_masks}
"""What can be left out by name in place of times: what the findings ``dropout``, ``stuck_samples`` and, of single rows,
``repeated_samples`` are about."""

_FORMS = f"give stretches such as 720s:722s,1080s:1083s, :10s or 2h:, or one of {', '.join(KINDS)}"
_TO_ROUNDING = 1e-6  # of a sample
_LISTED = 5


def from_the_start(record: Record) -> Record:
    """The record with its streams' times from the beginning of the earliest, as the options that name times count them."""
    origin = min(stream.grid.start for stream in record.streams)
    if all(stream.grid.lead == stream.grid.start - origin for stream in record.streams):
        return record
    streams = (replace(s, grid=replace(s.grid, lead=s.grid.start - origin)) for s in record.streams)
    return replace(record, streams=tuple(streams))


def leave_out(record: Record, stretches: str | Sequence[str]) -> tuple[Record, list[Finding]]:
    """The record with some stretches taken for missing on all sensors.

    Parameters
    ----------
    record : Record
    stretches : str or sequence of str
        ``"720s:722s"``, ``"720s:722s,1080s:1083s"``, ``":10s"``, ``"2h:"``: times from the beginning of the record, the end
        not included; units ms, s, min, h, d. ``"dropouts"``, ``"stuck"`` and ``"copies"``: the samples of which the
        findings ``dropout``, ``stuck_samples`` and, of single rows, ``repeated_samples`` tell, each on its own channels.

    Returns
    -------
    Record, list of Finding
        The finding ``"left_out"``, an info, says how many samples of each stream were left out.

    Raises
    ------
    OptionError
        For a text that is none of these, a stretch that the record has not, or if fewer than 4 samples are left.
    """
    texts = [stretches] if isinstance(stretches, str) else list(stretches)
    parts = [part.strip() for text in texts for part in text.split(",") if part.strip()]
    if not parts:
        raise OptionError(f"{{option}} names nothing: {_FORMS}", option="leave_out")
    end = max(stream.grid.lead + stream.grid.duration for stream in record.streams)
    spans = [_span(part, end) for part in parts if part not in KINDS]
    kinds = [KINDS[part] for part in dict.fromkeys(parts) if part in KINDS]
    streams, said = [], []
    for stream in record.streams:
        if stream.quantity == "temperature":  # which was what it was
            streams.append(stream)
            continue
        bad = np.zeros(stream.grid.n, dtype=bool)
        for start, stop in spans:
            bad[_first_at(stream, start) : _first_at(stream, stop)] = True
        masks = [bad.copy() for _ in stream.channels]
        for kind in kinds:
            masks = [mask | more for mask, more in zip(masks, kind(stream), strict=True)]
        if not any(mask.any() for mask in masks):
            said.append(f"{stream.name}: none")
            streams.append(stream)
            continue
        said.append(_count(stream, masks))
        without = masked(stream, np.stack(masks, axis=1))
        _refuse_nothing_left(without)
        streams.append(without)
    listed = [f"{seconds(a)} s to {seconds(b)} s" for a, b in spans[:_LISTED]]
    listed += [f"{len(spans) - _LISTED} more"] if len(spans) > _LISTED else []
    listed += [part for part in dict.fromkeys(parts) if part in KINDS]
    words = f"left out as asked ({', '.join(listed)}): {'; '.join(said)}"
    provenance = replace(record.provenance, conversions=(*record.provenance.conversions, words))
    finding = Finding(
        code="left_out",
        severity="info",
        message=words,
        where=f"t = {min((a for a, _ in spans), default=0.0):.6g} s",
        size=float(sum(b - a for a, b in spans)),
        unit="s",
        effect="their places stay empty; clusters that are at least half full are averaged",
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
            f"{{option}} {text!r} begins at {seconds(start)} s; the record is {seconds(end)} s long",
            option="leave_out",
        )
    if start >= stop:
        raise OptionError(f"{{option}} {text!r} ends at {seconds(stop)} s, before it begins", option="leave_out")
    return start, min(stop, end)


def _first_at(stream: Stream, time: float) -> int:
    """The first sample at a time or after it."""
    at = math.ceil((time - stream.grid.lead) / stream.grid.tau0 - _TO_ROUNDING)
    return min(max(at, 0), stream.grid.n)


def _count(stream: Stream, masks: list[NDArray[np.bool_]]) -> str:
    counts = [int(mask.sum()) for mask in masks]
    most = max(counts)
    number = f"{most}" if min(counts) == most else f"up to {most}"
    share = 100 * most / stream.grid.n
    return (
        f"{stream.name}: {number} of {stream.grid.n} samples ({share:.2g} %, {duration_text(most * stream.grid.tau0)})"
    )


def _refuse_nothing_left(stream: Stream) -> None:
    if stream.mask is None:
        return
    left = int((~stream.mask).sum(axis=0).max())
    if left < MIN_SAMPLES:
        raise OptionError(
            f"{{option}} leaves {left} samples of {stream.name}; at least {MIN_SAMPLES} are needed", option="leave_out"
        )
