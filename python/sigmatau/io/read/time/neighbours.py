"""Stamps that jitter moves closer to another place of the grid: neighbours and the order of rows give their place."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sigmatau.io.read.time.clock_line import BLOCK, about_line

__all__ = ["consistent_losses", "is_jitter_only"]

_WINDOW = 4  # rows on each side whose median decides on the place of a stamp
_LOSS_PRIOR = 8.0  # -ln of the probability of a loss at a given row; a loss needs jitter less likely than that
_MAX_JITTER = 0.45  # of the interval: bunches of two rows have 0.5, larger ones more; such jitter swaps 5 % of the rows
_MAX_CORRELATION = 0.15  # of neighbours: sorted jitter of 0.4 has 0.06, bunches of two rows -1, of three -0.5
# The means of two blocks with one block between them differ by a whole interval if a sample is lost. By jitter of 0.45
# alone the difference has a standard deviation of 0.08, and reaches half an interval once in 1e9 blocks.
_LOST_SAMPLE = 0.5
_LEAST_BLOCKS = 4


def is_jitter_only(t: NDArray[np.float64]) -> bool:
    """Whether the stamps are those of evenly spaced samples without losses, with independent jitter and without bunches.

    Notes
    -----
    With jitter of more than 0.2 intervals the places of single stamps are uncertain, and so is their phase. They are not
    needed if no sample is lost.
    """
    blocks = len(t) // BLOCK
    if blocks < _LEAST_BLOCKS:
        return False
    rest, interval, _ = about_line(t, np.arange(len(t), dtype=np.float64))
    parts = (rest / interval)[: blocks * BLOCK].reshape(blocks, BLOCK)
    means = parts.mean(axis=1)
    if not np.abs(means[2:] - means[:-2]).max() < _LOST_SAMPLE:
        return False
    parts = parts - means[:, None]
    square = float(np.mean(parts * parts)) * BLOCK / (BLOCK - 1)
    together = float(np.mean(parts[:, 1:] * parts[:, :-1])) + square / BLOCK
    return 0 < square < _MAX_JITTER**2 and abs(together / square) < _MAX_CORRELATION + 3 / math.sqrt(len(t))


def consistent_losses(lost: NDArray[np.float64], rest: NDArray[np.float64]) -> NDArray[np.float64]:
    """Samples lost before each stamp, not decreasing, from the estimates of single stamps."""
    believed = 0.5 + _LOSS_PRIOR * float(np.mean((rest - lost) ** 2))
    lost = _at_ends(lost.copy(), rest, believed)
    falls = np.flatnonzero(np.diff(lost) < 0)
    return _never_falling(_outvoted(lost, falls, rest, believed)) if len(falls) else lost


def _at_ends(lost: NDArray[np.float64], rest: NDArray[np.float64], believed: float) -> NDArray[np.float64]:
    """Remove the loss of one sample at the first or last stamp if jitter is more likely; no neighbours decide there."""
    if len(lost) > 2:
        if lost[-1] - lost[-2] == 1 and rest[-1] - lost[-2] < believed:
            lost[-1] = lost[-2]
        if lost[1] - lost[0] == 1 and lost[1] - rest[0] < believed:
            lost[0] = lost[1]
    return lost


def _never_falling(lost: NDArray[np.float64]) -> NDArray[np.float64]:
    """Correct late or early stamps so that losses do not decrease, in the way that moves fewer stamps."""
    late = np.minimum.accumulate(lost[::-1])[::-1]
    early = np.maximum.accumulate(lost)
    return late if np.count_nonzero(late != lost) <= np.count_nonzero(early != lost) else early


def _outvoted(
    lost: NDArray[np.float64], falls: NDArray[np.intp], rest: NDArray[np.float64], believed: float
) -> NDArray[np.float64]:
    """Replace estimates that contradict the median of their neighbours; estimates in order are kept.

    A stamp is moved by one place only if its jitter makes that likely: next to a loss the median is sometimes off by one.
    """
    n, width = len(lost), 2 * _WINDOW + 1
    if n < width:
        return lost
    near = np.unique(np.clip(falls[:, None] + np.arange(-_WINDOW, _WINDOW + 2), 0, n - 1))
    windows = np.clip(near[:, None] + np.arange(-_WINDOW, _WINDOW + 1), 0, n - 1)
    voted = np.median(lost[windows], axis=1)
    before, after = lost[np.maximum(near - 1, 0)], lost[np.minimum(near + 1, n - 1)]
    fits = (before <= lost[near]) & (lost[near] <= after)
    own = fits & (np.abs(voted - lost[near]) == 1) & (np.abs(rest[near] - voted) >= believed)
    mended = lost.copy()
    mended[near] = np.where(own, lost[near], voted)
    return mended
