"""Block means of a channel."""

from __future__ import annotations

from sigmatau.arrays import Floats
from sigmatau.quality.samples.common import row_means
from sigmatau.record.streams import Stream


def block_means(stream: Stream, channel: str, *, length: int) -> Floats:
    """Means of a channel over blocks of `length` samples, NaN if half of one is missing; shape (n_blocks,)."""
    count = stream.grid.n // length
    return row_means(stream.column(channel)[: count * length].reshape(count, length))
