"""Marking samples as missing: masks, and their stretches as times."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from sigmatau.arrays import Bools, runs
from sigmatau.findings.finding import Finding, Span
from sigmatau.record.streams import Stream

MaskedFinding = tuple[Finding, Bools | None]
"""A finding and a mask of its samples, shape (n, n_channels); None if leaving them out would not help."""


# Longest gap that is bridged. [samples] Judgement: enough for spikes and lost rows; a longer filled gap would show in
# the spectrum.
_SHORT = 4
# Distance of the good sample that replaces a missing one. [samples] Judgement: an adjacent sample would make the noise
# smoother.
_APART = 7


def masked(stream: Stream, mask: Bools) -> Stream:
    """Mark samples as missing by a mask, shape (n,) or (n, n_channels); the same object if the mask is empty."""
    if not mask.any():
        return stream
    missing = np.array(np.broadcast_to(mask.reshape(len(mask), -1), (stream.grid.n, len(stream.channels))))
    if stream.mask is not None:
        missing |= stream.mask
    return replace(stream, samples=replace(stream.samples, missing=missing), mask=missing)


def bridged(stream: Stream) -> Stream:
    """Replace up to four consecutive missing samples by good samples nearby, because spectra cannot use such gaps.

    The seventh good sample before the gap is used: an adjacent one would make the noise smoother.
    """
    if stream.mask is None:
        return stream
    columns = []
    for channel in stream.channels:
        x = stream.column(channel)
        absent = ~np.isfinite(x)
        good = np.flatnonzero(~absent)
        short = [(start, stop) for start, stop in runs(absent) if stop - start <= _SHORT]
        if short and len(good) > 2 * _APART:
            places, x = np.concatenate([np.arange(start, stop) for start, stop in short]), x.copy()
            which = np.searchsorted(good, places)
            x[places] = x[good[np.where(which >= _APART, which - _APART, which + _APART)]]
        columns.append(x)
    filled = stream.with_rates(columns)
    mask = np.stack([~np.isfinite(x) for x in columns], axis=1)
    return replace(filled, mask=mask if mask.any() else None)


def mask_from_spans(n: int, spans: Iterable[tuple[int, int]]) -> Bools:
    """Mask of some stretches of n samples, which may extend beyond the ends; shape (n,)."""
    mask = np.zeros(n, dtype=bool)
    for start, stop in spans:
        mask[max(start, 0) : max(stop, 0)] = True
    return mask


def in_seconds(stream: Stream, spans: Iterable[tuple[int, int]]) -> tuple[Span, ...]:
    """Convert stretches of samples to times from the beginning of the whole record. [s]"""
    return tuple((stream.grid.time(start), stream.grid.time(stop)) for start, stop in spans)
