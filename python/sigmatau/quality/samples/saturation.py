"""Saturation: a channel that touches an end of its range again and again."""

from __future__ import annotations

import math
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from sigmatau.findings.finding import Finding
from sigmatau.quality.samples.common import affected, growing_step, one_for_all, place, when
from sigmatau.quality.samples.resolution import Resolution, resolution
from sigmatau.quality.samples.stuck_samples import stuck_runs, zero_runs
from sigmatau.record.streams import Stream

__all__ = ["saturation"]

# In the tail of any noise about a slowly moving level an outer value is rarer than the next one inwards. So of T visits
# to the outermost level and the next three at most T/4 are to the outermost; P(c of T) ≤ exp(-T·KL(c/T, 1/4)), Chernoff.
_LEVELS = 4
_FALSE = 1e-8

# Coarser channels have no tail: all their values are extremes.
_TOO_COARSE = 0.5

_NORMAL = NormalDist()


def saturation(stream: Stream) -> list[Finding]:
    """Channels that lie at their largest or smallest value more often than a tail of noise does.

    Parameters
    ----------
    stream : Stream

    Returns
    -------
    list of Finding
        At most one a channel; ``changes`` holds what clipping does to white noise, where the clipped samples are spread
        over the whole record.
    """
    findings = []
    for channel in stream.channels:
        x = stream.column(channel)
        first, size = zero_runs(stream, channel, x)
        for a, m in zip(first.tolist(), size.tolist(), strict=True):  # a sensor that is not there has no range
            x = x.copy() if a == first[0] else x
            x[a : a + m] = np.nan
        low, high = float(np.min(x)), float(np.max(x))
        if math.isnan(low):
            low, high = float(np.fmin.reduce(x)), float(np.fmax.reduce(x))
        if not low < high:
            continue
        ends = [np.flatnonzero(x == low), np.flatnonzero(x == high)]
        if max(map(len, ends)) < _LEVELS:
            continue
        found = resolution(stream, channel)
        if growing_step(x) > 0:
            continue
        step = 0.0 if found is None else found.step
        # Of few values, and of noise that is seldom seen, the outermost is no end of a range.
        judged = found is None or (found.ratio >= _TOO_COARSE and high - low >= _LEVELS * step)
        runs, lengths = stuck_runs(stream, channel, x)
        clipped = []
        for end, at, sign in ((low, ends[0], -1.0), (high, ends[1], 1.0)):
            if (judged and _too_often(x, at, end, sign, step)) or np.any(x[runs] == end):
                clipped.append(at)
            else:
                clipped.append(at[:0])
        if any(map(len, clipped)):
            findings.append(_finding(stream, channel, x, clipped, (low, high), found, int(lengths.max(initial=0))))
    return one_for_all(findings, stream)


def _too_often(x: NDArray[np.float64], at: NDArray[np.int64], end: float, sign: float, step: float) -> bool:
    visits = [_visits(at)]
    if step > 0:
        edge = end - sign * (_LEVELS - 0.5) * step
        near = np.flatnonzero(x > edge if sign > 0 else x < edge)
        level = np.rint((end - x[near]) * sign / step)
        visits += [_visits(near[level == k]) for k in range(1, _LEVELS)]
    total = sum(visits)
    part = visits[0] / total
    if part <= 1 / _LEVELS:
        return False
    distance = part * math.log(part * _LEVELS)
    if part < 1:
        distance += (1 - part) * math.log((1 - part) / (1 - 1 / _LEVELS))
    return total * distance > -math.log(_FALSE)


def _visits(at: NDArray[np.int64]) -> int:
    """Runs of neighbouring samples: one long stay is one visit, so that a sensor that is read twice is not at fault."""
    return int(np.count_nonzero(np.diff(at) > 1)) + 1 if len(at) else 0


def _clipped_sd(low: float, high: float, *, half: float = 0.0) -> float:
    """Standard deviation of unit Gaussian noise of which parts `low` and `high` are held at the ends they go beyond.

    `half` is half a step of the numbers: where they are rounded, the ends are so much further out than what counts as there.
    """
    a = _NORMAL.inv_cdf(low) if low > 0 else -40.0
    b = -_NORMAL.inv_cdf(high) if high > 0 else 40.0
    pa, pb = _NORMAL.pdf(a), _NORMAL.pdf(b)
    least, most = a - half, b + half
    mean = least * low + pa - pb + most * high
    square = least**2 * low + (1 - low - high + a * pa - b * pb) + most**2 * high
    return math.sqrt(max(square - mean * mean, 0.0))


def _finding(
    stream: Stream,
    channel: str,
    x: NDArray[np.float64],
    clipped: list[NDArray[np.int64]],
    ends: tuple[float, float],
    found: Resolution | None,
    longest: int,
) -> Finding:
    n = int(np.count_nonzero(np.isfinite(x)))
    low, high = (len(at) / n for at in clipped)
    at = np.sort(np.concatenate(clipped))
    share = len(at) / n
    values = " and ".join(f"{end:.6g}" for end, where in zip(ends, clipped, strict=True) if len(where))
    tenths = np.bincount(at * 10 // len(x), minlength=10)
    everywhere = bool(np.all(tenths > 0.3 * tenths.mean())) and share < 0.9
    changes: tuple[tuple[str, float], ...] = ()
    if everywhere:
        factor = 1.0
        for _ in range(3 if found else 1):  # the step is known in parts of the clipped noise
            factor = _clipped_sd(low, high, half=factor / found.ratio / 2 if found else 0.0)
        changes = (("random_walk", factor),)
        effect = f"{affected(factor)} if the noise is white, and the mean is biased"
    else:
        stay = f", up to {longest * stream.grid.tau0:.3g} s on end" if longest else ""
        effect = f"noise and level are unknown there{stay}; all terms may be wrong"
    return Finding(
        code="saturation",
        severity="warning",
        channel=channel,
        message=(
            f"{len(at)} samples ({100 * share:.2g} %) lie at the end of the range, {values} {stream.unit}, the first at"
            f" {when(int(at[0]), stream)}"
        ),
        where=place(int(at[0]), stream),
        size=share,
        effect=effect,
        changes=changes,
        remedy="choose a wider range and record again, or analyse a window without these samples",
    )
