"""Disturbances: samples that are clearly not noise of the sensor, by cause, and their exclusion."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable
from dataclasses import replace

import numpy as np

from sigmatau.arrays import Bools, column_counts
from sigmatau.findings.disturbances import Spikes
from sigmatau.findings.finding import Finding, Span
from sigmatau.frozen import frozen
from sigmatau.quality.facts import stream_fact
from sigmatau.quality.motion.shocks_and_steps import shocks
from sigmatau.quality.motion.start_transient import start_transient
from sigmatau.quality.samples.common import without_rounding_errors
from sigmatau.quality.samples.dropouts import dropouts
from sigmatau.quality.samples.duplicate_rows import copies
from sigmatau.quality.samples.interpolation import filled_outages
from sigmatau.quality.samples.masking import MaskedFinding, masked
from sigmatau.quality.samples.saturation import saturation
from sigmatau.quality.samples.spikes import spikes
from sigmatau.quality.samples.stuck_samples import stuck_samples
from sigmatau.record.streams import Stream

CAUSES: dict[str, Callable[[Stream], list[MaskedFinding]]] = {
    "start": start_transient,
    "dropouts": dropouts,
    "saturation": saturation,
    "stuck": stuck_samples,
    "interpolated": filled_outages,
    "copies": copies,
    "shocks": shocks,
    "spikes": spikes,
}
"""Causes by their names in `keep`, in the order of the search. Each search ignores the samples of previous causes."""

_ROUNDING = 1e-6  # rounding tolerance [samples]
_COMPARE_EQUAL = ("dropouts", "saturation", "stuck", "copies")  # causes that compare samples for equality


# Largest share of a channel that a disturbance can have. [1] Judgement: at least half of the samples must remain.
_MAX_LEFT_OUT = 0.4


@frozen(kw_only=False, eq=False)
class Disturbance:
    """Samples that one cause disturbs, and the finding about them."""

    cause: str  # a key of `CAUSES`
    finding: Finding
    mask: Bools | None  # the disturbed samples, shape (n, n_channels); None if leaving them out would not help


@stream_fact
def disturbances(stream: Stream) -> tuple[Disturbance, ...]:
    """Find the disturbances of a stream, in the order of `CAUSES`."""
    collected: list[Disturbance] = []
    without_errors = without_rounding_errors(stream)
    for cause, search in CAUSES.items():
        remaining = masked_by(without_errors if cause in _COMPARE_EQUAL else stream, collected)
        for finding, mask in search(remaining):
            usable = mask is not None and column_counts(mask).max() <= _MAX_LEFT_OUT * len(mask)
            collected.append(Disturbance(cause, finding, mask if usable else None))
    return tuple(collected)


def masked_by(stream: Stream, disturbed: Iterable[Disturbance]) -> Stream:
    """Mark the samples of some disturbances as missing; the same object if there are none."""
    for disturbance in disturbed:
        if disturbance.mask is not None:
            stream = masked(stream, disturbance.mask)
    return stream


def disturbances_outside(stream: Stream, spans: Collection[Span]) -> tuple[Disturbance, ...]:
    """Find the disturbances of a stream outside some spans of time from the beginning of the record. [s]"""
    if not spans:
        return disturbances(stream)
    inside = np.zeros(stream.grid.n, dtype=bool)
    for start, stop in spans:
        inside[first_sample_from(stream, start) : first_sample_from(stream, stop)] = True
    outside = []
    for disturbance in disturbances(stream):
        mask = None if disturbance.mask is None else disturbance.mask & ~inside[:, None]
        outside.append(replace(disturbance, mask=mask if mask is not None and mask.any() else None))
    return tuple(outside)


def first_sample_from(stream: Stream, time: float) -> int:
    """Index of the first sample of a stream at or after a time from the beginning of the record. [s]"""
    index = (time - stream.grid.lead) / stream.grid.tau0 - _ROUNDING
    return math.ceil(min(max(index, 0), stream.grid.n))


def without(stream: Stream, *, keep: Iterable[str] = (), spans: Collection[Span] = ()) -> tuple[Stream, list[Finding]]:
    """Exclude the disturbances of a stream, except for the causes to `keep` and those in some `spans` of time [s]; return
    the stream and the findings about all of them.
    """
    causes, disturbed = set(keep), disturbances_outside(stream, spans)
    findings = []
    for disturbance in disturbed:
        if disturbance.mask is None or disturbance.cause in causes:
            findings.append(disturbance.finding)
        else:
            count = int(column_counts(disturbance.mask).max())
            findings.append(_left_out(disturbance.finding, count))
    return masked_by(stream, (disturbance for disturbance in disturbed if disturbance.cause not in causes)), findings


def _left_out(finding: Finding, count: int) -> Finding:
    """State how leaving out spikes changes the random walk. If the noise has heavy tails, part of it is left out, and the
    random walk may be too small. If small spikes remain, it is too large.
    """
    details = finding.details
    if not isinstance(details, Spikes):
        return replace(finding, severity="info", left_out=count)
    factor = details.small_factor / details.tail_factor
    return replace(
        finding,
        severity=finding.severity if details.more_below else "info",
        left_out=count,
        factors=(("random_walk", factor),) if factor != 1 else (),
    )
