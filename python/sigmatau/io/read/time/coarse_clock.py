"""The even line through stamps of a clock that makes few steps in a record: what rates all of its stamps allow."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Allowed", "allowed", "few_steps"]

_HALVINGS = 60  # of a slope that is sought: to the last digit of a double
_ROUNDING = 1e-9  # of a step: exact stamps lie this far from theirs


@dataclass(frozen=True, slots=True, kw_only=True)
class Allowed:
    """Sample intervals that fit stamps of one clock, in their unit.

    Attributes
    ----------
    interval : float
        Of the line from which no stamp is farther than it must be.
    least, most : float
        Shortest and longest interval that put every stamp within one step of the clock; both `interval` if none does.
        The shortest is 0 if the clock made one step only: then the samples may be as fast as one likes.
    width : float
        Largest less smallest distance of the stamps from that line.
    """

    interval: float
    least: float
    most: float
    width: float

    @property
    def error(self) -> float:
        """Largest relative error of the interval; infinite if it has no lower bound."""
        if not self.least > 0:
            return math.inf
        return max(self.interval - self.least, self.most - self.interval) / self.interval


def few_steps(n: int, steps: int) -> bool:
    """Whether the line of least squares is worse than the one that the corners of the stairs allow.

    A stair of so many steps turns the line of least squares by up to 1/steps² of its slope (in the worst phase, exactly);
    its corners, one sample wide, leave about 1/n.
    """
    return steps > 0 and steps * steps < n


def allowed(t: NDArray[np.float64], step: float) -> Allowed:
    """The intervals that even samples may have, to be stamped so by a clock that goes in steps.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Stamps, growing or equal, the last larger than the first.
    step : float
        Of the clock.

    Notes
    -----
    Of a stair only the corners matter: the first sample on each of its levels, and the last. The width of t − b·k is a
    convex function of b; the sign of its slope, by the corners that are farthest out, says on which side its least is.
    """
    up = np.flatnonzero(np.diff(t)) + 1
    first, last = np.concatenate(([0], up)), np.append(up - 1, len(t) - 1)
    levels = t[first]

    def width(b: float) -> tuple[float, float]:
        over, under = levels - b * first, levels - b * last
        high, low = int(np.argmax(over)), int(np.argmin(under))
        return float(over[high] - under[low]), float(last[low] - first[high])

    low, high = 0.0, float(t[-1] - t[0])
    for _ in range(_HALVINGS):
        b = (low + high) / 2
        low, high = (b, high) if width(b)[1] < 0 else (low, b)
    best = (low + high) / 2
    room = step * (1 + _ROUNDING)

    def end(inside: float, outside: float) -> float:
        if width(outside)[0] <= room:
            return outside
        for _ in range(_HALVINGS):
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
