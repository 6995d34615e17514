"""Rate random walk that steps of the mean add, compared with the sensor's own in the parts between the steps."""

from __future__ import annotations

import math
from collections.abc import Sequence

from sigmatau.arrays import Floats
from sigmatau.findings.kinds.disturbances import AddedWalk
from sigmatau.quality.samples.common import octaves
from sigmatau.record.streams import Stream

__all__ = ["added_walk", "own_walk", "parts_without"]

Parts = Sequence[tuple[int, int]]

# A walk dominates the long times if 3σ²/τ is constant over these octaves, to this factor: bias instability changes it by a
# factor of 8, and the last variance, of some 16 pairs, has an error of a third.
_CONSTANT_OCTAVES, _CONSTANT_FACTOR = 3, 2.0
_LEAST_PAIRS = 16


def parts_without(n: int, first: Sequence[int], stop: Sequence[int]) -> list[tuple[int, int]]:
    """The parts of n samples between stretches."""
    parts, at = [], 0
    for a, b in sorted(zip(first, stop, strict=True)):
        if a > at:
            parts.append((at, a))
        at = max(at, b)
    if n > at:
        parts.append((at, n))
    return parts


def own_walk(x: Floats, tau0: float, parts: Parts) -> tuple[float, bool]:
    """K² of the sensor from undisturbed parts of a channel, or an upper bound; and whether a walk dominates the long times.

    3σ²(τ)/τ is K² where a walk dominates, and more elsewhere, because other terms only add to it. It is constant there;
    bias instability makes it fall by a factor of 2 per octave, white noise by 4.
    """
    sums: dict[int, tuple[float, int]] = {}
    for start, stop in parts:
        for m, avar, pairs in octaves(x[start:stop]):
            total, count = sums.get(m, (0.0, 0))
            sums[m] = total + avar * pairs, count + pairs
    bounds = [3 * total / count / (m * tau0) for m, (total, count) in sorted(sums.items()) if count >= _LEAST_PAIRS]
    last = bounds[-1 - _CONSTANT_OCTAVES :]
    rules = len(last) > _CONSTANT_OCTAVES and last[0] < _CONSTANT_FACTOR * last[-1]
    return min(bounds, default=0.0), rules


def added_walk(stream: Stream, channel: str, added: float, parts: Parts) -> AddedWalk:
    """The walk that levels other than the sensor's own add: `added` to K² [unit²/s], against the undisturbed `parts`."""
    own, resolved = own_walk(stream.column(channel), stream.grid.tau0, parts)
    return AddedWalk(
        channel=channel,
        quantity=stream.quantity,
        unit=stream.unit,
        coefficient=math.sqrt(added),
        factor=math.sqrt(1 + added / own) if own > 0 else None,
        resolved=resolved and own > 0,
    )
