"""Stamps of a clock that makes few steps in a record: the sample intervals that all stamps allow."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Allowed", "allowed", "few_steps"]

_BISECTIONS = 60  # of a slope, to the resolution of a double
_ROUNDING = 1e-9  # relative rounding error of exact stamps [steps of the clock]


@dataclass(frozen=True, slots=True, kw_only=True)
class Allowed:
    """Sample intervals that fit stamps of one clock, in their unit."""

    interval: float  # Of the line with the smallest largest distance of a stamp
    # Shortest and longest interval with every stamp within one step of the clock; both `interval` if there is none. The
    # shortest is 0 if the clock made one step only: then the rate has no upper limit.
    least: float
    most: float
    width: float  # Range of the distances of the stamps from that line

    @property
    def error(self) -> float:
        """Largest relative error of the interval; infinite if it has no lower bound."""
        if not self.least > 0:
            return math.inf
        return max(self.interval - self.least, self.most - self.interval) / self.interval


def few_steps(n: int, steps: int) -> bool:
    """Whether the least-squares line is less accurate than the line that the corners of the staircase allow.

    A staircase changes the slope of the least-squares line by up to 1/steps² (exactly that in the worst phase); its corners
    are one sample wide and leave about 1/n.
    """
    return steps > 0 and steps * steps < n


def allowed(t: NDArray[np.float64], step: float) -> Allowed:
    """The intervals that evenly spaced samples may have, given their stamps by a clock with a coarse step.

    Notes
    -----
    Only the corners of the staircase matter: the first and the last sample on each level. The width of t − b·k is a convex
    function of b. The sign of its slope, by the outermost corners, gives the side of its minimum.

    `t`: stamps, not decreasing, the last larger than the first.
    """
    up = np.flatnonzero(np.diff(t)) + 1
    first, last = np.concatenate(([0], up)), np.append(up - 1, len(t) - 1)
    levels = t[first]

    def width(b: float) -> tuple[float, float]:
        over, under = levels - b * first, levels - b * last
        high, low = int(np.argmax(over)), int(np.argmin(under))
        return float(over[high] - under[low]), float(last[low] - first[high])

    low, high = 0.0, float(t[-1] - t[0])
    for _ in range(_BISECTIONS):
        b = (low + high) / 2
        low, high = (b, high) if width(b)[1] < 0 else (low, b)
    best = (low + high) / 2
    room = step * (1 + _ROUNDING)

    def end(inside: float, outside: float) -> float:
        if width(outside)[0] <= room:
            return outside
        for _ in range(_BISECTIONS):
            b = (inside + outside) / 2
            inside, outside = (b, outside) if width(b)[0] <= room else (inside, b)
        return inside

    fits = width(best)[0] <= room
    return Allowed(
        interval=best,
        least=end(best, 0.0) if fits else best,
        most=end(best, float(t[-1] - t[0])) if fits else best,
        width=width(best)[0],
    )
