"""Samples taken for missing."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sigmatau.streams import Stream, Transform

__all__ = ["blanked", "rows"]


def blanked(stream: Stream, mask: NDArray[np.bool_]) -> Stream:
    """The stream with samples taken for missing where the mask, shape (n, n_channels), is true."""
    if not mask.any():
        return stream
    raw = tuple(np.where(mask[:, k], np.nan, stream.column(channel)) for k, channel in enumerate(stream.channels))
    samples = replace(stream.samples, raw=raw, transforms=(Transform(),) * len(raw))
    return replace(stream, samples=samples, mask=mask if stream.mask is None else mask | stream.mask)


def rows(stream: Stream, stretches: Iterable[tuple[int, int]]) -> NDArray[np.bool_]:
    """True in some stretches of all channels, shape (n, n_channels)."""
    mask = np.zeros((stream.grid.n, len(stream.channels)), dtype=bool)
    for start, stop in stretches:
        mask[max(start, 0) : stop] = True
    return mask
