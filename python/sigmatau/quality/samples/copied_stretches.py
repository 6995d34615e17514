"""Stretches that a record contains twice: a buffer written twice, or a log joined with a part of itself."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import Floats, distinct
from sigmatau.findings.finding import Finding
from sigmatau.findings.values import CopiedStretch
from sigmatau.quality.samples.common import present
from sigmatau.quality.samples.resolution import equal_by_chance
from sigmatau.record.streams import Stream

_CHUNK = 1 << 16  # samples whose keys are computed together, so that they stay in the cache
_MIX = 0x9E3779B97F4A7C15  # odd multiplier from the golden ratio: Fibonacci hashing
_TURN, _HIGH = 7, 40  # shift of the second sample of a pair, and shift to the well-mixed high bits [bits]


# Number of rows in the shortest copy that is reported. [samples] Judgement: shorter ones are copied rows or held
# samples.
_MIN_ROWS = 64
# Distance of the rows that are compared first. [samples] Derived: every copy of `_MIN_ROWS` contains two of them.
_COARSE = 32
# Probability that a record of noise contains equal stretches of that length. [1] Judgement: one false alarm in 10⁶
# records.
_FALSE_ALARM = 1e-6
# Smallest probability of equal samples on an axis. [1] Judgement: a smaller one cannot be estimated from the samples.
_MIN_CHANCE = 1e-3
# Number of samples whose bits form a key. [samples] Judgement: eight samples of coarse noise seldom recur by chance.
_KEY = 8
# Number of keys per examined key. The value of a key decides whether it is examined, so that a stretch and its copy are
# examined at the same places. [1] Derived: `_MIN_ROWS` contain seven examined keys on average.
_KEYS_PER_EXAMINED = 8
# Number of distances between equal keys that are examined, the most frequent first. [1] Judgement: limits the time.
_LAGS = 8
# Number of samples used to choose the axis with the most distinct values. [samples] Judgement: a few thousand are
# enough to rank the axes.
_EXAMINED = 4096


def copied_stretches(stream: Stream) -> list[Finding]:
    """Find the longest stretch of rows that are repeated, on all axes, elsewhere in the stream. At most one finding.

    A copy of L rows is reported if n²·∏p_c^L < 1e-6, where p_c is the share of the samples of axis c that equal another
    sample by chance. A stretch that overlaps its copy belongs to a periodic signal and is not reported.
    """
    n = stream.grid.n
    if n < 2 * _MIN_ROWS:
        return []
    axis = max(stream.channels, key=lambda channel: len(distinct(present(stream.column(channel)[:_EXAMINED]))))
    best = (0, 0, 0)
    for lag in _equal_on_coarse_rows(stream, _frequent_lags(stream.column(axis))):
        first, length = _longest_equal(stream, lag)
        best = max(best, (length, first, lag)) if length <= lag else best
    length, first, lag = best
    if length < _MIN_ROWS:
        return []
    chances = [equal_by_chance(stream, channel) for channel in stream.channels]
    by_chance = sum(math.log(min(max(chance, _MIN_CHANCE), 1.0)) for chance in chances)
    if 2 * math.log(n) + length * by_chance > math.log(_FALSE_ALARM):
        return []
    time = stream.grid.time
    details = CopiedStretch(start=time(first), copy=time(first + lag), duration=length * stream.grid.tau0, rows=length)
    spans = ((time(first + lag), time(first + lag + length)),)
    return [
        Finding(
            details=details,
            severity="warning",
            channels=tuple(stream.channels),
            spans=spans,
            size=details.duration,
            unit="s",
        )
    ]


def _frequent_lags(x: Floats) -> list[int]:
    """Distances between places with the same eight samples, the most frequent first."""
    parts = [_make_keys(x[start : start + _CHUNK + _KEY - 1], start) for start in range(0, len(x) - _KEY + 1, _CHUNK)]
    places, keys = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    order = np.argsort(keys, kind="stable")
    places, keys = places[order], keys[order]
    same = np.flatnonzero(keys[1:] == keys[:-1])
    if not len(same):
        return []
    lags, counts = np.unique(places[same + 1] - places[same], return_counts=True)
    return [int(lag) for lag in lags[np.argsort(-counts, kind="stable")[:_LAGS]]]


def _make_keys(x: Floats, start: int) -> tuple[NDArray[np.int64], NDArray[np.uint64]]:
    """Places of the examined keys in the stream, and the keys; `start` is the place of x[0]."""
    mixed = np.ascontiguousarray(x).view(np.uint64) * np.uint64(_MIX)  # integers wrap around
    pairs = mixed[:-1] ^ (mixed[1:] >> np.uint64(_TURN))
    # pairs of coarse values recur too often
    fours = (pairs[:-2] ^ (pairs[2:] >> np.uint64(2 * _TURN))) * np.uint64(_MIX)
    places = np.flatnonzero((fours[: len(x) - _KEY + 1] >> np.uint64(_HIGH)) & np.uint64(_KEYS_PER_EXAMINED - 1) == 0)
    # Samples of a key must be neither stuck nor missing.
    places = places[(x[places] != x[places + _KEY - 1]) & np.isfinite(x[places])]
    keys = fours[places]
    for k in range(4, _KEY):
        keys = (keys ^ mixed[places + k]) * np.uint64(_MIX)
    return places + start, keys


def _equal_on_coarse_rows(stream: Stream, lags: list[int]) -> list[int]:
    """The lags at which two consecutive rows of a coarse grid equal the rows one lag later, as in every reported copy."""
    equal = [np.ones(1, dtype=bool)] * len(lags)
    for channel in stream.channels if lags else ():
        x = stream.column(channel)
        equal = [rows & (x[lag::_COARSE] == x[:-lag:_COARSE]) for rows, lag in zip(equal, lags, strict=True)]
    return [lag for rows, lag in zip(equal, lags, strict=True) if (rows[1:] & rows[:-1]).any()]


def _longest_equal(stream: Stream, lag: int) -> tuple[int, int]:
    """First row and length of the longest run of rows that equal the rows `lag` later."""
    equal = np.ones(stream.grid.n - lag, dtype=bool)
    for channel in stream.channels:
        x = stream.column(channel)
        equal &= x[lag:] == x[:-lag]
    edges = np.flatnonzero(np.diff(np.concatenate(([False], equal, [False]))))
    if not len(edges):
        return 0, 0
    lengths = edges[1::2] - edges[::2]
    k = int(np.argmax(lengths))
    return int(edges[2 * k]), int(lengths[k])
