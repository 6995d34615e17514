"""Shocks too light or short for a burst: spikes on several axes at about one time."""

from __future__ import annotations

import math

import numpy as np

from sigmatau.frozen import frozen
from sigmatau.quality.facts import stream_fact
from sigmatau.quality.samples.common import block_rms
from sigmatau.quality.samples.motion import Burst
from sigmatau.quality.samples.spikes import spike_mask
from sigmatau.record.streams import Stream


@frozen
class LightShockThresholds:
    """Thresholds of `light_shocks`."""

    group_gap: float = 0.25
    """Distance of the spikes of a group, at most. [s] Judgement: a knock on a table rings for a quarter of a second."""

    least_spikes: int = 3
    """Spikes of a group that is a shock. [samples] Derived: single spikes, k a second on each axis, form such groups
    (k/2)² as often."""

    least_axes: int = 2
    """Axes on which they are. [1] Judgement: a shock has a direction, but no axis of a sensor."""

    least_times: int = 2
    """Rows in which they are. [samples] Judgement: a corrupt row makes spikes in one row only."""

    most_single: float = 0.5
    """Share of the spikes outside groups beyond which groups form by chance. [1] Judgement: half of them."""

    before: float = 0.1
    """Part of the shock before its first spike. [s] Judgement: what rises below the threshold of spikes."""

    after: float = 0.5
    """Part of the shock after its last spike. [s] Judgement: what rings below the threshold of spikes."""


THRESHOLDS = LightShockThresholds()


@stream_fact
def light_shocks(stream: Stream) -> list[Burst]:
    """Shocks that show as spikes on two axes or more within a quarter of a second, in more than one row: a burst per axis.

    A corrupt row makes spikes on all axes in that row only; a shock rings.
    """
    if stream.quantity not in ("angular_rate", "acceleration") or len(stream.channels) < THRESHOLDS.least_axes:
        return []
    places = [np.flatnonzero(spike_mask(stream, channel)) for channel in stream.channels]
    at = np.concatenate(places)
    axis = np.repeat(np.arange(len(places)), [len(p) for p in places])
    if len(at) < THRESHOLDS.least_spikes:
        return []
    order = np.argsort(at, kind="stable")
    at, axis = at[order], axis[order]
    tau0 = stream.grid.tau0
    cuts = np.flatnonzero(np.diff(at) * tau0 > THRESHOLDS.group_gap) + 1
    groups = [
        (rows, on)
        for rows, on in zip(np.split(at, cuts), np.split(axis, cuts), strict=True)
        if len(rows) >= THRESHOLDS.least_spikes
        and len(np.unique(on)) >= THRESHOLDS.least_axes
        and len(np.unique(rows)) >= THRESHOLDS.least_times
    ]
    if len(at) - sum(len(rows) for rows, _ in groups) > THRESHOLDS.most_single * len(at):
        return []
    found = []
    for rows, on in groups:
        start = max(int(rows[0]) - round(THRESHOLDS.before / tau0), 0)
        stop = min(int(rows[-1]) + round(THRESHOLDS.after / tau0), stream.grid.n)
        for k in np.unique(on).tolist():
            channel = stream.channels[k]
            changes = np.diff(stream.column(channel))
            here = changes[start : stop - 1]
            usual = block_rms(changes)
            ratio = float(np.sqrt(np.nanmean(here * here))) / usual if usual > 0 else math.inf
            found.append(Burst(channel, start, stop, ratio))
    return found
