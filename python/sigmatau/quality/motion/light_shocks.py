"""Shocks that are too light or short for a burst, but cause spikes on several axes at about the same time."""

from __future__ import annotations

import math

import numpy as np

from sigmatau.arrays import distinct
from sigmatau.quality.facts import stream_fact
from sigmatau.quality.motion.windows import Burst
from sigmatau.quality.samples.common import block_rms
from sigmatau.quality.samples.spikes import spike_mask
from sigmatau.record.streams import Stream

# Largest distance between the spikes of a group. [s] Judgement: a knock on a table rings for a quarter of a second.
_SPIKE_GAP = 0.25
# Smallest number of spikes in a shock. [samples] Derived: single spikes, k per second on each axis, form such groups
# (k/2)² times as often.
_MIN_SPIKES = 3
# Smallest number of axes with spikes in a shock. [1] Judgement: a shock is seldom along a single axis.
_MIN_AXES = 2
# Smallest number of rows with spikes in a shock. [samples] Judgement: a corrupt row has spikes in one row only.
_MIN_ROWS = 2
# Share of the spikes outside groups beyond which groups form by chance. [1] Judgement: half of them.
_MAX_SINGLE = 0.5
# Part of the shock before its first spike. [s] Judgement: the rise is below the threshold of spikes.
_BEFORE_SPIKES = 0.1
# Part of the shock after its last spike. [s] Judgement: the ringing falls below the threshold of spikes.
_AFTER_SPIKES = 0.5


@stream_fact
def light_shocks(stream: Stream) -> list[Burst]:
    """Find shocks: spikes on at least two axes within a quarter of a second and in more than one row. Returns one burst
    per axis.

    A corrupt row has spikes on all axes in that row only, whereas a shock rings.
    """
    if stream.quantity not in ("angular_rate", "acceleration") or len(stream.channels) < _MIN_AXES:
        return []
    places = [np.flatnonzero(spike_mask(stream, channel)) for channel in stream.channels]
    rows, axes = np.concatenate(places), np.repeat(np.arange(len(places)), [len(each) for each in places])
    if len(rows) < _MIN_SPIKES:
        return []
    order = np.argsort(rows, kind="stable")
    rows, axes = rows[order], axes[order]
    tau0 = stream.grid.tau0
    cuts = np.flatnonzero(np.diff(rows) * tau0 > _SPIKE_GAP) + 1
    groups = [
        (times, distinct(group_axes))
        for times, group_axes in zip(np.split(rows, cuts), np.split(axes, cuts), strict=True)
        if len(times) >= _MIN_SPIKES and len(distinct(times)) >= _MIN_ROWS
    ]
    groups = [(times, group_axes) for times, group_axes in groups if len(group_axes) >= _MIN_AXES]
    if len(rows) - sum(len(times) for times, _ in groups) > _MAX_SINGLE * len(rows):
        return []
    shocks = []
    for times, group_axes in groups:
        start = max(int(times[0]) - round(_BEFORE_SPIKES / tau0), 0)
        stop = min(int(times[-1]) + round(_AFTER_SPIKES / tau0), stream.grid.n)
        for k in group_axes.tolist():
            changes = np.diff(stream.column(stream.channels[k]))
            during, usual = changes[start : stop - 1], block_rms(changes)
            ratio = float(np.sqrt(np.nanmean(during * during))) / usual if usual > 0 else math.inf
            shocks.append(Burst(stream.channels[k], start, stop, ratio))
    return shocks
