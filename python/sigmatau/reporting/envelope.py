"""Downsampling for a picture: the smallest and the largest sample of each stretch, so that no spike is lost."""

from __future__ import annotations

import numpy as np

from sigmatau.arrays import Floats, Ints
from sigmatau.record.streams import Stream

_PIECE = 1 << 20  # samples read at a time


def envelope(stream: Stream, channel: str, bins: int) -> tuple[Floats, Floats, Ints]:
    """Smallest and largest sample of each bin, NaN where all are missing; and the edges of the bins in samples.

    The samples of the log are used, including those that an analysis leaves out.

    Parameters
    ----------
    stream : Stream
    channel : str
    bins : int
        Largest number of bins; a bin has one sample or more.

    Returns
    -------
    low, high : ndarray, shape (n_bins,)
        [unit]
    edges : ndarray of int, shape (n_bins + 1,)
    """
    n, k = stream.grid.n, stream.channels.index(channel)
    bins = min(bins, n)
    edges = np.linspace(0, n, bins + 1).round().astype(np.int64)
    low, high = np.full(bins, np.nan), np.full(bins, np.nan)
    first = 0
    while first < bins:
        last = max(int(np.searchsorted(edges, edges[first] + _PIECE, side="right")) - 1, first + 1)
        x = stream.samples.read(k, int(edges[first]), int(edges[last]))
        starts = edges[first:last] - edges[first]
        low[first:last], high[first:last] = np.fmin.reduceat(x, starts), np.fmax.reduceat(x, starts)
        first = last
    return low, high, edges
