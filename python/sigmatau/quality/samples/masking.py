"""Samples taken for missing: masks, their stretches, and what to leave out of a record with steps of the mean."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from sigmatau.arrays import Bools, runs
from sigmatau.findings.finding import Finding, Span
from sigmatau.frozen import frozen
from sigmatau.record.streams import Stream

Found = tuple[Finding, Bools | None]
"""A finding and the samples that it is about, shape (n, n_channels); None if leaving them out would not help."""


@frozen
class MaskingThresholds:
    """Thresholds of `bridged` and `without_steps`."""

    short: int = 4
    """Longest gap that is bridged. [samples] Judgement: spikes and lost rows; a longer gap would be a part of the
    spectrum."""

    apart: int = 7
    """Distance of the good sample that takes the place of a missing one. [samples] Judgement: no neighbour, so that
    noise stays as rough as it is."""

    cancels: float = 0.3
    """Sum of two steps over the larger one, below which they are a change of the mean that ends. [1] Judgement: the
    sizes of steps are known to a tenth or two."""


THRESHOLDS = MaskingThresholds()


def masked(stream: Stream, mask: Bools) -> Stream:
    """The stream with samples taken for missing by a mask, shape (n,) or (n, n_channels); the same object if it is empty."""
    if not mask.any():
        return stream
    missing = np.array(np.broadcast_to(mask.reshape(len(mask), -1), (stream.grid.n, len(stream.channels))))
    if stream.mask is not None:
        missing |= stream.mask
    return replace(stream, samples=replace(stream.samples, missing=missing), mask=missing)


def bridged(stream: Stream) -> Stream:
    """The stream with good samples nearby in place of up to four missing ones, because spectra cannot use such gaps.

    The seventh good sample before: no neighbour, so that noise stays as rough as it is.
    """
    if stream.mask is None:
        return stream
    columns = []
    for channel in stream.channels:
        x = stream.column(channel)
        absent = ~np.isfinite(x)
        good = np.flatnonzero(~absent)
        short = [(start, stop) for start, stop in runs(absent) if stop - start <= THRESHOLDS.short]
        if short and len(good) > 2 * THRESHOLDS.apart:
            at, x = np.concatenate([np.arange(start, stop) for start, stop in short]), x.copy()
            which = np.searchsorted(good, at)
            x[at] = x[good[np.where(which >= THRESHOLDS.apart, which - THRESHOLDS.apart, which + THRESHOLDS.apart)]]
        columns.append(x)
    filled = stream.with_rates(columns)
    mask = np.stack([~np.isfinite(x) for x in columns], axis=1)
    return replace(filled, mask=mask if mask.any() else None)


def mask_of(n: int, spans: Iterable[tuple[int, int]]) -> Bools:
    """True in some stretches of n samples, which may reach beyond its ends; shape (n,)."""
    mask = np.zeros(n, dtype=bool)
    for start, stop in spans:
        mask[max(start, 0) : max(stop, 0)] = True
    return mask


def in_seconds(stream: Stream, spans: Iterable[tuple[int, int]]) -> tuple[Span, ...]:
    """Stretches of samples as times from the beginning of the whole record. [s]"""
    return tuple((stream.grid.time(start), stream.grid.time(stop)) for start, stop in spans)


def without_steps(
    stream: Stream, steps: Sequence[tuple[int, int, float]]
) -> tuple[tuple[Span, ...], tuple[float | None, float | None] | None]:
    """What to leave out, or else what to keep, of a record with steps: sample, uncertainty in samples, and size of each.

    The stretch between two steps that cancel is left out; otherwise the longest part between steps is kept, because a
    record without the moment of a step still has both means. From the beginning of the whole record; None for its ends. [s]
    """
    n = stream.grid.n
    if len(steps) == 2:
        (first, near, up), (second, wide, down) = steps
        if abs(up + down) < THRESHOLDS.cancels * max(abs(up), abs(down)):
            return in_seconds(stream, [(max(first - near, 0), min(second + wide, n))]), None
    edges = [(0, 0), *((at, about) for at, about, _ in steps), (n, 0)]
    k = max(range(len(edges) - 1), key=lambda i: edges[i + 1][0] - edges[i][0])
    ((start, stop),) = in_seconds(stream, [(edges[k][0] + edges[k][1], edges[k + 1][0] - edges[k + 1][1])])
    whole = stream.grid.lead == 0
    return (), (None if k == 0 and whole else start, None if k == len(steps) and whole else stop)
