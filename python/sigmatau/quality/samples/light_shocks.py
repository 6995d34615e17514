"""Knocks so light or short that only their largest samples stand out: spikes on several axes, or in a row, at one time."""

from __future__ import annotations

import math

import numpy as np

from sigmatau.quality.facts import stream_fact
from sigmatau.quality.samples.common import block_rms
from sigmatau.quality.samples.motion import Burst
from sigmatau.quality.samples.spikes import spike_mask
from sigmatau.record.streams import Stream

__all__ = ["light_knocks"]

# Spikes belong together that are no further apart. Three of them, on two axes and at two times, are a knock: of spikes made
# one by one by a link, k a second on each axis, they are (k/2)² as often as chance.
_TOGETHER_S = 0.25
_LEAST, _AXES, _TIMES = 3, 2, 2

# If so large a part of the spikes is not in knocks, they come so often that some are together by chance.
_MOST_ALONE = 0.5

_BEFORE_S, _AFTER_S = 0.1, 0.5  # what belongs to it and does not stand out


@stream_fact
def light_knocks(stream: Stream) -> list[Burst]:
    """Knocks that show as spikes on two axes or more within a quarter of a second, and not in one row alone.

    A row that is wrong makes spikes on all axes in that row; what is shaken rings.

    Parameters
    ----------
    stream : Stream

    Returns
    -------
    list of Burst
        One a knock and axis with spikes.
    """
    if stream.quantity not in ("angular_rate", "acceleration") or len(stream.channels) < _AXES:
        return []
    places = [np.flatnonzero(spike_mask(stream, channel)) for channel in stream.channels]
    at = np.concatenate(places)
    axis = np.repeat(np.arange(len(places)), [len(p) for p in places])
    if len(at) < _LEAST:
        return []
    order = np.argsort(at, kind="stable")
    at, axis = at[order], axis[order]
    tau0 = stream.grid.tau0
    cuts = np.flatnonzero(np.diff(at) * tau0 > _TOGETHER_S) + 1
    groups = [
        (rows, on)
        for rows, on in zip(np.split(at, cuts), np.split(axis, cuts), strict=True)
        if len(rows) >= _LEAST and len(np.unique(on)) >= _AXES and len(np.unique(rows)) >= _TIMES
    ]
    if len(at) - sum(len(rows) for rows, _ in groups) > _MOST_ALONE * len(at):
        return []
    found = []
    for rows, on in groups:
        start = max(int(rows[0]) - round(_BEFORE_S / tau0), 0)
        stop = min(int(rows[-1]) + round(_AFTER_S / tau0), stream.grid.n)
        for k in np.unique(on).tolist():
            channel = stream.channels[k]
            changes = np.diff(stream.column(channel))
            here = changes[start : stop - 1]
            usual = block_rms(changes)
            ratio = float(np.sqrt(np.nanmean(here * here))) / usual if usual > 0 else math.inf
            found.append(Burst(channel=channel, start=start, stop=stop, ratio=ratio))
    return found
