"""Shocks too light or short for a burst: spikes on several axes at about one time."""

from __future__ import annotations

import math

import numpy as np

from sigmatau.quality.facts import stream_fact
from sigmatau.quality.samples.common import block_rms
from sigmatau.quality.samples.motion import Burst
from sigmatau.quality.samples.spikes import spike_mask
from sigmatau.record.streams import Stream

# Spikes no further apart form a group. [s] Three of them, on two axes and at two times, are a shock: single spikes, k a
# second on each axis, form such groups (k/2)² as often.
_GROUP_GAP = 0.25
_LEAST_SPIKES, _LEAST_AXES, _LEAST_TIMES = 3, 2, 2

_MOST_SINGLE = 0.5  # with a larger share of spikes outside groups, groups form by chance
_BEFORE, _AFTER = 0.1, 0.5  # parts of the shock before its first and after its last spike [s]


@stream_fact
def light_shocks(stream: Stream) -> list[Burst]:
    """Shocks that show as spikes on two axes or more within a quarter of a second, in more than one row: a burst per axis.

    A corrupt row makes spikes on all axes in that row only; a shock rings.
    """
    if stream.quantity not in ("angular_rate", "acceleration") or len(stream.channels) < _LEAST_AXES:
        return []
    places = [np.flatnonzero(spike_mask(stream, channel)) for channel in stream.channels]
    at = np.concatenate(places)
    axis = np.repeat(np.arange(len(places)), [len(p) for p in places])
    if len(at) < _LEAST_SPIKES:
        return []
    order = np.argsort(at, kind="stable")
    at, axis = at[order], axis[order]
    tau0 = stream.grid.tau0
    cuts = np.flatnonzero(np.diff(at) * tau0 > _GROUP_GAP) + 1
    groups = [
        (rows, on)
        for rows, on in zip(np.split(at, cuts), np.split(axis, cuts), strict=True)
        if len(rows) >= _LEAST_SPIKES and len(np.unique(on)) >= _LEAST_AXES and len(np.unique(rows)) >= _LEAST_TIMES
    ]
    if len(at) - sum(len(rows) for rows, _ in groups) > _MOST_SINGLE * len(at):
        return []
    found = []
    for rows, on in groups:
        start = max(int(rows[0]) - round(_BEFORE / tau0), 0)
        stop = min(int(rows[-1]) + round(_AFTER / tau0), stream.grid.n)
        for k in np.unique(on).tolist():
            channel = stream.channels[k]
            changes = np.diff(stream.column(channel))
            here = changes[start : stop - 1]
            usual = block_rms(changes)
            ratio = float(np.sqrt(np.nanmean(here * here))) / usual if usual > 0 else math.inf
            found.append(Burst(channel, start, stop, ratio))
    return found
