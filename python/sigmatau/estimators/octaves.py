"""Allan variance of disjoint clusters of 1, 2, 4, … samples, some of which may be missing."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from sigmatau.arrays import Floats

_MIN_PAIRS = 8


def octaves(x: Floats) -> Iterator[tuple[int, float, int]]:
    """Yield, for cluster sizes 1, 2, 4 …, the size, the Allan variance of disjoint clusters that are at least half
    full, and the number of pairs (8 or more).
    """
    n = len(x)
    present = np.isfinite(x)
    if present.all():
        total, count = x - x[0], None
    else:
        first = x[int(np.argmax(present))] if present.any() else 0.0
        total, count = np.where(present, x - first, 0.0), present.astype(np.float64)
    m = 1
    while n // m > _MIN_PAIRS:
        if count is None:
            mean = total / m
        else:
            with np.errstate(invalid="ignore", divide="ignore"):
                mean = np.where(count >= m / 2, total / count, np.nan)
        steps = np.diff(mean)
        steps = steps[np.isfinite(steps)]
        if len(steps) >= _MIN_PAIRS:
            yield m, float(np.mean(steps * steps)) / 2, len(steps)
        m *= 2
        half = len(total) // 2 * 2
        total = total[0:half:2] + total[1:half:2]
        count = None if count is None else count[0:half:2] + count[1:half:2]
