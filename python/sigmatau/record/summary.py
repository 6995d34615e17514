"""Summary of a channel in a few numbers, which show whether its unit and its column are correct."""

from __future__ import annotations

import math

import numpy as np

from sigmatau.arrays import run_edges
from sigmatau.frozen import frozen
from sigmatau.record.streams import Stream

_PIECE = 1 << 20  # samples read at a time


@frozen
class ChannelSummary:
    """Summary of a channel; NaN without samples.

    Attributes
    ----------
    mean, low, high : float
        Mean, smallest and largest sample. [unit of the stream]
    missing : int
        Samples that are missing.
    gaps : int
        Stretches of missing samples.
    """

    mean: float
    low: float
    high: float
    missing: int
    gaps: int

    @property
    def peak_to_peak(self) -> float:
        """Largest minus smallest sample."""
        return self.high - self.low


def summarise(stream: Stream, channel: str) -> ChannelSummary:
    """Mean, range and gaps of a channel, in bounded memory.

    Parameters
    ----------
    stream : Stream
    channel : str
        A channel of the stream.

    Returns
    -------
    ChannelSummary
    """
    k, n = stream.channels.index(channel), stream.grid.n
    total, count, low, high = 0.0, 0, math.nan, math.nan
    for first in range(0, n, _PIECE):
        x = stream.samples.read(k, first, min(first + _PIECE, n))
        finite = x[np.isfinite(x)]
        count += len(finite)
        total += float(finite.sum())
        low, high = float(np.fmin.reduce(x, initial=low)), float(np.fmax.reduce(x, initial=high))
    gaps = 0 if stream.mask is None else len(run_edges(stream.mask[:, k]))
    mean = total / count if count else math.nan
    return ChannelSummary(mean=mean, low=low, high=high, missing=n - count, gaps=gaps)
