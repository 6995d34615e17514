"""Stamps nearer to another place than their own, by their jitter: neighbours and the order of rows say whose they are."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sigmatau.io.read.time.clock_line import BLOCK, about_line

__all__ = ["agreed", "scatter_alone"]

_WINDOW = 4  # places on each side that outvote one stamp
_PRIOR = 8.0  # -ln of the chance of a loss at a given row: jitter must be less likely before one is believed
_SCATTER = 0.45  # of the interval: bunches of two have 0.5, larger ones more; jitter so large swaps one row in twenty
_ALONE = 0.15  # correlation of neighbours: jitter of 0.4, put in order, has 0.06, bunches of two -1, of three -0.5
# Means of two blocks, with one between them, differ by a whole interval where a sample is lost; of jitter of 0.45 alone
# they have a difference of 0.08, one standard deviation, and reach half an interval once in 1e9 blocks.
_LOST = 0.5
_LEAST = 4  # blocks


def scatter_alone(t: NDArray[np.float64]) -> bool:
    """Whether stamps are those of all of even samples, each late or early by itself: jitter, if large, and no bunches.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Stamps, growing or equal.

    Notes
    -----
    With jitter of more than 0.2 intervals the places of single stamps can no longer be told, nor can their phase; but if no
    sample is lost there is nothing to be told.
    """
    blocks = len(t) // BLOCK
    if blocks < _LEAST:
        return False
    rest, interval, _ = about_line(t, np.arange(len(t), dtype=np.float64))
    parts = (rest / interval)[: blocks * BLOCK].reshape(blocks, BLOCK)
    means = parts.mean(axis=1)
    if not np.abs(means[2:] - means[:-2]).max() < _LOST:
        return False
    parts = parts - means[:, None]
    square = float(np.mean(parts * parts)) * BLOCK / (BLOCK - 1)
    together = float(np.mean(parts[:, 1:] * parts[:, :-1])) + square / BLOCK
    return 0 < square < _SCATTER**2 and abs(together / square) < _ALONE + 3 / math.sqrt(len(t))


def agreed(lost: NDArray[np.float64], rest: NDArray[np.float64]) -> NDArray[np.float64]:
    """Samples lost before each stamp, never falling, from those that each stamp says for itself.

    Parameters
    ----------
    lost : ndarray, shape (n,)
        Of each stamp alone.
    rest : ndarray, shape (n,)
        The same before it was rounded.
    """
    believed = 0.5 + _PRIOR * float(np.mean((rest - lost) ** 2))
    lost = _at_ends(lost.copy(), rest, believed)
    falls = np.flatnonzero(np.diff(lost) < 0)
    return _never_falling(_outvoted(lost, falls, rest, believed)) if len(falls) else lost


def _at_ends(lost: NDArray[np.float64], rest: NDArray[np.float64], believed: float) -> NDArray[np.float64]:
    """Without the loss of one sample beside the first or last stamp that its jitter explains better: none outvotes these."""
    if len(lost) > 2:
        if lost[-1] - lost[-2] == 1 and rest[-1] - lost[-2] < believed:
            lost[-1] = lost[-2]
        if lost[1] - lost[0] == 1 and lost[1] - rest[0] < believed:
            lost[0] = lost[1]
    return lost


def _never_falling(lost: NDArray[np.float64]) -> NDArray[np.float64]:
    """A late stamp is followed by others that are not, and an early one by others that are not: what moves fewer stamps."""
    late = np.minimum.accumulate(lost[::-1])[::-1]
    early = np.maximum.accumulate(lost)
    return late if np.count_nonzero(late != lost) <= np.count_nonzero(early != lost) else early


def _outvoted(
    lost: NDArray[np.float64], falls: NDArray[np.intp], rest: NDArray[np.float64], believed: float
) -> NDArray[np.float64]:
    """With the median of its neighbourhood where a stamp stands against it; what never falls stays as it is.

    A stamp is moved to the next place only if its jitter makes it likely to be from there: beside a true loss the median is
    one off now and then.
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
