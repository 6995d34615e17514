"""Rate random walk that steps of the mean add, compared with the sensor's own in the parts between the steps."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sigmatau.arrays import Floats, Ints, Runs
from sigmatau.findings.kinds.disturbances import AddedWalk
from sigmatau.quality.samples.common import octaves
from sigmatau.record.streams import Stream

__all__ = ["added_by_stretches", "added_walk", "own_walk", "parts_without", "walk_of_runs"]

Parts = Sequence[tuple[int, int]]

# A walk dominates the long times if 3σ²/τ is constant over these octaves, to this factor: bias instability changes it by a
# factor of 8, and the last variance, of some 16 pairs, has an error of a third.
_CONSTANT_OCTAVES, _CONSTANT_FACTOR = 3, 2.0
_LEAST_PAIRS = 16

# Length of the means beside a stretch: that of the stretch, within these limits. [s]
_LEAST_MEAN, _LONGEST_MEAN = 1.0, 30.0

_MOST_STRETCHES = 256  # the longest ones; the others add next to nothing


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


def added_by_stretches(x: Floats, tau0: float, first: Ints, lengths: Ints) -> float:
    """K² that stretches with a false mean add at averaging times up to their length: a step at either end of each.

    Half the mean square of a step's triangle of differences, Δ²τ/(3T), is what K² = Δ²/T makes: K²τ/3, eq. (21).
    """
    clean = x.copy()
    for start, size in zip(first.tolist(), lengths.tolist(), strict=True):
        clean[start : start + size] = np.nan
    squares = 0.0
    for k in np.argsort(-lengths)[:_MOST_STRETCHES].tolist():
        start, stop = int(first[k]), int(first[k] + lengths[k])
        around = round(min(max((stop - start) * tau0, _LEAST_MEAN), _LONGEST_MEAN) / tau0)
        for end, beside in (
            (x[start], clean[max(start - around, 0) : start]),
            (x[stop - 1], clean[stop : stop + around]),
        ):
            there = beside[np.isfinite(beside)]
            if len(there):
                squares += float(end - there.mean()) ** 2
    return squares / (len(x) * tau0)


def walk_of_runs(stream: Stream, channel: str, runs: Runs) -> AddedWalk:
    """The walk that stretches with a false mean add, given by first samples and lengths."""
    (first, lengths), x = runs, stream.column(channel)
    added = added_by_stretches(x, stream.grid.tau0, first, lengths)
    return added_walk(stream, channel, added, parts_without(len(x), first.tolist(), (first + lengths).tolist()))


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
