"""Disturbances: samples that are clearly not noise of the sensor, by cause, and the stream without them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from sigmatau.arrays import Bools
from sigmatau.findings.disturbances import Spikes
from sigmatau.findings.finding import Finding
from sigmatau.quality.facts import stream_fact
from sigmatau.quality.motion.shocks_and_steps import shocks
from sigmatau.quality.motion.start_transient import start_transient
from sigmatau.quality.samples.common import without_dust
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
"""Causes by the name that `keep` gives them, in the order in which they are looked for: each beside those before it."""

_EQUAL = ("dropouts", "saturation", "stuck", "copies")  # these compare samples for equality


# Share of a channel beyond which a cause is the record, and not a disturbance of it. [1] Judgement: the rest would be
# less than the disturbance.
_MOST_LEFT_OUT = 0.4


@dataclass(frozen=True, slots=True, eq=False)
class Disturbance:
    """Samples that one cause disturbs, and the finding about them."""

    cause: str  # a key of `CAUSES`
    finding: Finding
    mask: Bools | None  # the samples, shape (n, n_channels); None if leaving them out would not help


@stream_fact
def disturbances(stream: Stream) -> tuple[Disturbance, ...]:
    """The disturbances of a stream, in the order of `CAUSES`."""
    collected: list[Disturbance] = []
    even = without_dust(stream)
    for cause, looked_for in CAUSES.items():
        here = masked_by(even if cause in _EQUAL else stream, collected)
        for finding, mask in looked_for(here):
            usable = mask is not None and mask.mean(axis=0).max() <= _MOST_LEFT_OUT
            collected.append(Disturbance(cause, finding, mask if usable else None))
    return tuple(collected)


def masked_by(stream: Stream, disturbed: Iterable[Disturbance]) -> Stream:
    """The stream with the samples of some disturbances taken for missing; the same object if there are none."""
    for disturbance in disturbed:
        if disturbance.mask is not None:
            stream = masked(stream, disturbance.mask)
    return stream


def without(stream: Stream, *, keep: Iterable[str] = ()) -> tuple[Stream, list[Finding]]:
    """The stream without its disturbances, except for the causes to `keep`, and the findings about all of them."""
    causes, disturbed = set(keep), disturbances(stream)
    findings = []
    for disturbance in disturbed:
        if disturbance.mask is None or disturbance.cause in causes:
            findings.append(disturbance.finding)
        else:
            count = int(np.count_nonzero(disturbance.mask, axis=0).max())
            findings.append(_left_out(disturbance.finding, count))
    return masked_by(stream, (disturbance for disturbance in disturbed if disturbance.cause not in causes)), findings


def _left_out(finding: Finding, count: int) -> Finding:
    """Of noise with heavy tails a part is left out with the spikes: the random walk may be too small. With small spikes that
    remain it is too large.
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
