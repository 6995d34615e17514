"""What of a stream is the sensor at rest: all but motion, held levels, made-up lines and a filter's start."""

from __future__ import annotations

import numpy as np

from sigmatau.integrity.knocks import light_knocks
from sigmatau.integrity.masking import mask_of, masked
from sigmatau.integrity.spikes import mask_spikes
from sigmatau.integrity.start import settled_from
from sigmatau.integrity.static import movements
from sigmatau.integrity.stuck import without_runs
from sigmatau.record import Record
from sigmatau.streams import Stream

__all__ = ["DISTURBANCES", "undisturbed"]

DISTURBANCES = ("dropout", "saturation", "stuck_samples", "interpolated", "not_static", "start_transient")
"""Codes of findings about some stretches of a record."""

# A record that is disturbed for more than this has nothing usual left: then it is taken as it is.
_MOST = 0.4


def undisturbed(stream: Stream) -> Stream:
    """The stream with what `check` tells as a disturbance at some time taken for missing.

    Motion on all axes, with a window before and after it, for what shakes one axis shakes the others less; changes of level
    as far as they may reach; runs of equal samples and straight lines.

    Parameters
    ----------
    stream : Stream

    Returns
    -------
    Stream
        The very same if nothing is disturbed, or too much.
    """
    still = without_runs(stream)
    if stream.quantity not in ("angular_rate", "acceleration"):
        return still
    start = max((settled_from(stream, channel) for channel in stream.channels), default=0)
    still = masked(still, mask_of(still.grid.n, [(0, start)]))
    knocks = light_knocks(still)
    alone, _ = mask_spikes(Record(streams=(still,)))
    seen = movements(alone.streams[0])
    bad = mask_of(still.grid.n, [(b.start - seen.window, b.stop + seen.window) for b in (*seen.moved, *knocks)])
    mask = np.repeat(bad[:, None], len(still.channels), axis=1)
    for channel, changes in seen.changed.items():
        for change in changes:
            around = slice(max(change.sample - change.around, 0), change.sample + change.around)
            mask[around, still.channels.index(channel)] = True
    return still if mask.mean() > _MOST else masked(still, mask)
