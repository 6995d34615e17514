"""What of a stream is the sensor at rest: all but motion, held levels, made-up lines and a filter's start."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sigmatau.quality.facts import stream_fact
from sigmatau.quality.samples.light_shocks import light_knocks
from sigmatau.quality.samples.lost_rows import lost_rows
from sigmatau.quality.samples.masking import mask_of, masked
from sigmatau.quality.samples.shocks_and_steps import Movements, movements
from sigmatau.quality.samples.spikes import spikes_missing
from sigmatau.quality.samples.start_transient import settled_from
from sigmatau.quality.samples.stuck_samples import without_runs
from sigmatau.record.streams import Stream

__all__ = ["DISTURBANCES", "quiet", "undisturbed"]

DISTURBANCES = ("dropout", "saturation", "stuck_samples", "interpolated", "not_static", "start_transient")
"""Codes of findings about some stretches of a record."""

# A record that is disturbed for more than this has nothing usual left: then it is taken as it is.
_MOST = 0.4


@stream_fact
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
    still, _, seen, bad = _moving(stream, still)
    mask = np.repeat(bad[:, None], len(still.channels), axis=1)
    for channel, changes in seen.changed.items():
        for change in changes:
            around = slice(max(change.sample - change.around, 0), change.sample + change.around)
            mask[around, still.channels.index(channel)] = True
    return still if mask.mean() > _MOST else masked(still, mask)


@stream_fact
def quiet(stream: Stream) -> Stream:
    """The stream in which a drift is looked for: without lost rows, runs, spikes and motion, but with all changes of level.

    A level that is held at either end, or one sample of a thousand standard deviations there, looks as a settling does;
    and the steep beginning of one that is real looks as a change of level does.

    Parameters
    ----------
    stream : Stream

    Returns
    -------
    Stream
        The very same if nothing is disturbed.
    """
    still = without_runs(lost_rows(stream)[1])
    if stream.quantity not in ("angular_rate", "acceleration"):
        return spikes_missing(still)
    still, alone, _, bad = _moving(still, still)
    return still if bad.mean() > _MOST else masked(alone, bad)


def _moving(stream: Stream, still: Stream) -> tuple[Stream, Stream, Movements, NDArray[np.bool_]]:
    """Without a filter's start; the same without spikes; how it moves, and in which samples, a window more either side."""
    start = max((settled_from(stream, channel) for channel in stream.channels), default=0)
    still = masked(still, mask_of(still.grid.n, [(0, start)]))
    knocks = light_knocks(still)
    alone = spikes_missing(still)
    seen = movements(alone)
    bad = mask_of(still.grid.n, [(b.start - seen.window, b.stop + seen.window) for b in (*seen.moved, *knocks)])
    return still, alone, seen, bad
