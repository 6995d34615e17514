"""The undisturbed parts of a stream: without motion, held values, interpolated samples and start transients."""

from __future__ import annotations

import numpy as np

from sigmatau.arrays import Bools
from sigmatau.quality.facts import stream_fact
from sigmatau.quality.samples.light_shocks import light_shocks
from sigmatau.quality.samples.lost_rows import lost_rows
from sigmatau.quality.samples.masking import mask_of, masked
from sigmatau.quality.samples.shocks_and_steps import Movements, movements
from sigmatau.quality.samples.spikes import spikes_missing
from sigmatau.quality.samples.start_transient import settled_from
from sigmatau.quality.samples.stuck_samples import without_runs
from sigmatau.record.streams import Stream

__all__ = ["DISTURBANCES", "quiet", "undisturbed"]

DISTURBANCES = ("dropout", "saturation", "stuck_samples", "interpolated", "not_static", "start_transient")
"""Codes of findings about stretches of a record."""

_MOST_DISTURBED = 0.4  # a record with a larger disturbed share is left as it is


@stream_fact
def undisturbed(stream: Stream) -> Stream:
    """The stream with disturbed samples taken for missing; the same object if nothing is disturbed, or more than 40 %.

    Motion on all axes, with a window before and after it, because a shock of one axis reaches the others; steps of the mean
    with their uncertainty; runs of equal samples and straight lines.
    """
    still = without_runs(stream)
    if stream.quantity not in ("angular_rate", "acceleration"):
        return still
    still, _, seen, bad = _moving(stream, still)
    mask = np.repeat(bad[:, None], len(still.channels), axis=1)
    for channel, changes in seen.changed.items():
        for change in changes:
            around = slice(max(change.sample - change.around, 0), change.sample + change.around)
            mask[around, still.channels.index(channel)] = True
    return still if mask.mean() > _MOST_DISTURBED else masked(still, mask)


@stream_fact
def quiet(stream: Stream) -> Stream:
    """The stream in which a drift is looked for: without lost rows, runs, spikes and motion, but with all steps of the mean.

    A value held at either end, or a spike of a thousand standard deviations there, looks like a drift; and the steep
    beginning of a drift looks like a step.
    """
    still = without_runs(lost_rows(stream)[1])
    if stream.quantity not in ("angular_rate", "acceleration"):
        return spikes_missing(still)
    still, alone, _, bad = _moving(still, still)
    return still if bad.mean() > _MOST_DISTURBED else masked(alone, bad)


def _moving(stream: Stream, still: Stream) -> tuple[Stream, Stream, Movements, Bools]:
    """The stream without a start transient; also without spikes; its motion; and the samples in motion, with a margin."""
    start = max((settled_from(stream, channel) for channel in stream.channels), default=0)
    still = masked(still, mask_of(still.grid.n, [(0, start)]))
    shocks = light_shocks(still)
    alone = spikes_missing(still)
    seen = movements(alone)
    bad = mask_of(still.grid.n, [(b.start - seen.window, b.stop + seen.window) for b in (*seen.moved, *shocks)])
    return still, alone, seen, bad
