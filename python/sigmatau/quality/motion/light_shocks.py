"""Shocks too light or short for a burst: spikes on several axes at about one time."""

from __future__ import annotations

import math

import numpy as np

from sigmatau.quality.facts import stream_fact
from sigmatau.quality.motion.windows import THRESHOLDS, Burst
from sigmatau.quality.samples.common import block_rms
from sigmatau.quality.samples.spikes import spike_mask
from sigmatau.record.streams import Stream


@stream_fact
def light_shocks(stream: Stream) -> list[Burst]:
    """Shocks that show as spikes on two axes or more within a quarter of a second, in more than one row: a burst per axis.

    A corrupt row makes spikes on all axes in that row only; a shock rings.
    """
    if stream.quantity not in ("angular_rate", "acceleration") or len(stream.channels) < THRESHOLDS.least_axes:
        return []
    rows, axes = np.nonzero(np.stack([spike_mask(stream, channel) for channel in stream.channels], axis=1))
    if len(rows) < THRESHOLDS.least_spikes:
        return []
    tau0 = stream.grid.tau0
    cuts = np.flatnonzero(np.diff(rows) * tau0 > THRESHOLDS.spike_gap) + 1
    groups = [
        (times, np.unique(group_axes))
        for times, group_axes in zip(np.split(rows, cuts), np.split(axes, cuts), strict=True)
        if len(times) >= THRESHOLDS.least_spikes and len(np.unique(times)) >= THRESHOLDS.least_rows
    ]
    groups = [(times, group_axes) for times, group_axes in groups if len(group_axes) >= THRESHOLDS.least_axes]
    if len(rows) - sum(len(times) for times, _ in groups) > THRESHOLDS.most_single * len(rows):
        return []
    shocks = []
    for times, group_axes in groups:
        start = max(int(times[0]) - round(THRESHOLDS.before_spikes / tau0), 0)
        stop = min(int(times[-1]) + round(THRESHOLDS.after_spikes / tau0), stream.grid.n)
        for k in group_axes.tolist():
            changes = np.diff(stream.column(stream.channels[k]))
            during, usual = changes[start : stop - 1], block_rms(changes)
            ratio = float(np.sqrt(np.nanmean(during * during))) / usual if usual > 0 else math.inf
            shocks.append(Burst(stream.channels[k], start, stop, ratio))
    return shocks
