"""Neighbours of samples, and medians of rows."""

from __future__ import annotations

import numpy as np

from sigmatau.arrays import Floats, Ints


def neighbours(x: Floats, at: Ints, first: int, last: int) -> Floats:
    """The samples from `first` to `last` after each index; NaN beyond the ends."""
    places = at[:, None] + np.arange(first, last + 1)
    inside = (places >= 0) & (places < len(x))
    return np.where(inside, x[np.clip(places, 0, len(x) - 1)], np.nan)


def medians(rows: Floats) -> Floats:
    """Median of each row without NaN; NaN for an empty row."""
    ordered = np.sort(rows, axis=1)  # NaN last
    count = np.isfinite(ordered).sum(axis=1)
    row = np.arange(len(rows))
    both = ordered[row, np.maximum(count - 1, 0) // 2] + ordered[row, np.minimum(count // 2, rows.shape[1] - 1)]
    return np.asarray(np.where(count > 0, both / 2, np.nan))
