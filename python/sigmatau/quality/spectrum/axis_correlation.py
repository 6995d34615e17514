"""Whether the axes of a stream share a part of their noise.

Measures of each pair of axes: the correlation of first differences, of what is fast (vibration, a line, a common
converter), and those of the differences of means over 1 s, 4 s, 16 s and so on, of what is slower (supply, temperature, a
walk of the rate that white noise hides in shorter means). Differences, because random walks and drifts are correlated by
chance.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from sigmatau.findings.finding import Finding
from sigmatau.record.streams import Stream
from sigmatau.results import duration_text, two_digits

__all__ = ["OVER", "cross_axis"]

Floats = NDArray[np.float64]

_FALSE_ALARM = 1e-4
"""Probability for a stream whose axes are independent; divided among its pairs and its measures."""

# The correlation of n pairs of independent Gaussian series has the variance Σ ρ₁(l) ρ₂(l) / n over all lags (Bartlett 1935).
# First differences of white noise have ρ = −1/2 at lag 1: 1.5. Those of quantization noise −2/3 and 1/6: 1.944, the most
# that any mixture of the five terms makes.
_INFLATION = 1 + 2 * (4 / 9 + 1 / 36)

# Where neighbouring samples are correlated (a filter, a line), fast differences have more: their scatter over stretches
# tells how much, by Student's t.
_STRETCHES = 32

OVER = "between means over"
"""What is said of correlation that shows in the differences of means."""

_LEAST = 0.05
"""A smaller one is of no consequence: what two axes tell about their common noise is r² less than twice what one does."""

_STRONG = 0.3
_LEAST_MEANS = 60
_LONGER = 4  # times, from one length of means to the next; the last is the longest of which there are enough
_HALF = 0.5  # of its samples that a mean must have
_MOST_SAMPLES = 1 << 22


def cross_axis(stream: Stream) -> list[Finding]:
    """Correlation of the axes of a stream beyond chance.

    Parameters
    ----------
    stream : Stream
        Missing samples are NaN.

    Returns
    -------
    list of Finding
        At most one ``"correlated_axes"`` for the stream, with channel None: an info for correlations below 0.3, else a
        warning.

    Notes
    -----
    Beyond 4.2·10⁶ samples, 32 evenly spread stretches are looked at.
    """
    if len(stream.channels) < 2 or stream.grid.n < 4 * _STRETCHES:
        return []
    columns = {channel: stream.column(channel) for channel in stream.channels}
    pairs = list(combinations(stream.channels, 2))
    lengths = _lengths(stream)
    level = _FALSE_ALARM / ((1 + len(lengths)) * len(pairs))
    fast = {channel: _differences(column) for channel, column in columns.items()}
    slow = [{channel: _slow(column, length) for channel, column in columns.items()} for length in lengths]
    found: list[tuple[float, str, tuple[str, str]]] = []
    for first, second in pairs:
        # Squares of what is far too large or small are none; a channel in the wrong unit is for others to find.
        with np.errstate(over="ignore", under="ignore", invalid="ignore", divide="ignore"):
            r, kind = _by_stretches(fast[first], fast[second], level), "between neighbouring samples"
            for length, means in zip(lengths, slow, strict=True):
                other = _by_number(means[first], means[second], level)
                if abs(other) > abs(r) + _chance(len(means[first]), 0.05):
                    r, kind = other, f"{OVER} {duration_text(length * stream.grid.tau0)}"
        if _LEAST <= abs(r) <= 1 + 1e-9:
            found.append((r, kind, (first, second)))
    if not found:
        return []
    return [_finding(stream, found)]


def _lengths(stream: Stream) -> list[int]:
    """Samples in the means: 1 s and more, so long as there are enough of them."""
    length, longest = max(round(1 / stream.grid.tau0), 1), stream.grid.n // (_LEAST_MEANS + 1)
    lengths = []
    while length < longest:
        lengths.append(length)
        length *= _LONGER
    return [each for each in [*lengths, longest] if each > 1]


def _finding(stream: Stream, found: list[tuple[float, str, tuple[str, str]]]) -> Finding:
    found = sorted(found, key=lambda one: -abs(one[0]))
    largest = found[0][0]
    listed = ", ".join(f"{a} and {b} by {r:.2f} {kind}" for r, kind, (a, b) in found)
    fast = found[0][1].startswith("between neighbouring")
    cause = (
        "a vibration, a line or a converter that they share"
        if fast
        else "a slow line, a supply, a temperature or a motion that they share"
    )
    part = "" if stream.grid.n <= _MOST_SAMPLES else " (of 32 evenly spread stretches)"
    return Finding(
        code="correlated_axes",
        severity="warning" if abs(largest) >= _STRONG else "info",
        message=f"{stream.name}: changes are correlated beyond chance: {listed}{part}",
        size=abs(largest),
        effect=(
            f"up to {two_digits(100 * abs(largest))} % of the variance of these changes is common: coefficients and their"
            " intervals are right for each axis, but not independent, and a mean over the axes is less sure than it seems"
        ),
        remedy=f"look for {cause}; a filter that takes the axes as independent needs their common part as a covariance",
    )


def _differences(column: Floats) -> Floats:
    """First differences in stretches, shape (32, k), 0 where one of the two samples is missing."""
    n = len(column)
    if n > _MOST_SAMPLES:
        size = _MOST_SAMPLES // _STRETCHES
        starts = np.linspace(0, n - size, _STRETCHES).astype(np.int64)
        d = np.stack([np.diff(column[start : start + size]) for start in starts])
    else:
        size = n // _STRETCHES
        d = np.diff(column[: size * _STRETCHES].reshape(_STRETCHES, size), axis=1)
    return _centred(d)


def _slow(column: Floats, length: int) -> Floats:
    """Differences of means over so many samples, 0 where half of them are missing, without a ramp."""
    count = len(column) // length
    samples = column[: count * length].reshape(count, length)
    means = samples.mean(axis=1)
    torn = np.flatnonzero(np.isnan(means))
    if len(torn):
        there = ~np.isnan(samples[torn])
        number = there.sum(axis=1)
        sums = np.where(there, samples[torn], 0.0).sum(axis=1)
        means[torn] = np.where(number >= _HALF * length, sums / np.maximum(number, 1), np.nan)
    return _centred(np.diff(means))


def _centred(d: Floats) -> Floats:
    """Without their mean, which is a ramp and would be common to all axes that have one; 0 where missing."""
    mean = float(np.sum(d)) / max(int(d.size), 1)
    if np.isnan(mean):
        there = ~np.isnan(d)
        d[~there] = 0.0
        number = int(np.count_nonzero(there))
        mean = float(d.sum()) / max(number, 1)
        d[there] -= mean
        return d
    d -= mean
    return d


def _by_stretches(a: Floats, b: Floats, level: float) -> float:
    """Correlation, 0 where that of the stretches scatters about 0 by chance."""
    from scipy.special import stdtrit

    both = np.einsum("ij,ij->i", a, b)
    power = np.einsum("ij,ij->i", a, a), np.einsum("ij,ij->i", b, b)
    if not (power[0].sum() > 0 and power[1].sum() > 0):
        return 0.0
    r = float(both.sum() / np.sqrt(power[0].sum() * power[1].sum()))
    there = (power[0] > 0) & (power[1] > 0)
    each = both[there] / np.sqrt(power[0][there] * power[1][there])
    count = len(each)
    if count < _STRETCHES // 2:
        return 0.0
    bound = float(stdtrit(count - 1, 1 - level / 2)) * float(np.std(each, ddof=1)) / np.sqrt(count)
    number = int(np.count_nonzero((a != 0) & (b != 0))) if a.size <= 1 << 16 else a.size
    return r if abs(r) > max(bound, _chance(number, level)) else 0.0


def _by_number(a: Floats, b: Floats, level: float) -> float:
    """Correlation, 0 where its number of pairs makes as much by chance."""
    number = int(np.count_nonzero((a != 0) & (b != 0)))
    if number < _LEAST_MEANS:
        return 0.0
    r = float(a @ b / np.sqrt((a @ a) * (b @ b)))
    return r if abs(r) > _chance(number, level) else 0.0


def _chance(number: int, level: float) -> float:
    """What independent series exceed with probability `level`, by Student's law of a correlation."""
    from scipy.special import stdtrit

    freedom = max(number / _INFLATION - 2, 1.0)
    t = float(stdtrit(freedom, 1 - level / 2))
    return float(t / np.sqrt(freedom + t * t))
