"""Correlation of the noise of the axes of a stream.

Each pair of axes is measured by the correlation of first differences, for fast common noise (vibration, a line, a common
converter), and by those of differences of means over 1 s, 4 s, 16 s and so on, for slower common noise (supply, temperature,
a rate random walk that white noise hides in shorter means). Differences are used because random walks and drifts are
correlated by chance.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import combinations

import numpy as np

from sigmatau._native.distributions import student_quantile
from sigmatau.arrays import Floats
from sigmatau.findings.finding import Finding
from sigmatau.findings.spectrum import AxisPair, CorrelatedAxes, IdenticalAxes
from sigmatau.frozen import frozen
from sigmatau.quality.samples.common import row_means
from sigmatau.record.streams import Stream


@frozen
class CorrelationThresholds:
    """Thresholds of `cross_axis`."""

    false_alarm: float = 1e-4
    """Probability of a finding for a stream with independent axes; divided among its pairs and its measures. [1]
    Judgement: one false alarm in 10⁴ records."""

    reported: float = 0.05
    """Correlation from which on there is a finding. [1] Derived: a smaller one has no consequence; the variance of
    the mean of two Allan variances grows by the factor 1 + r²."""

    least_means: int = 60
    """Means from which on their correlation is measured. [1] Judgement: it is known to 0.13."""

    longer: int = 4
    """Factor from one length of means to the next; the last is the longest of which there are enough. [1] Judgement:
    slow common noise shows within two octaves."""

    inflation: float = 1 + 2 * (4 / 9 + 1 / 36)
    """Variance of the correlation of n pairs of independent Gaussian series, times n: Σ ρ₁(l)ρ₂(l) over all lags.
    [1] Derived: Bartlett 1935; first differences of white noise have ρ = −1/2 at lag 1, 1.5; those of quantization
    noise −2/3 and 1/6, 1.944, the most that any mixture of the five terms makes."""

    stretches: int = 32
    """Stretches whose correlations show, by Student's t, how much fast differences scatter, where neighbouring
    samples are correlated. [1] Judgement: their spread is known to an eighth."""

    most_samples: int = 1 << 22
    """Samples whose fast differences are used, in evenly spread stretches. [samples] Judgement: bounds the time."""


THRESHOLDS = CorrelationThresholds()


def cross_axis(stream: Stream) -> list[Finding]:
    """Correlation of the axes of a stream beyond chance: at most one ``"correlated_axes"``.

    It is information for a filter, which needs the covariance of the axes; the intervals of each axis hold. Identical axes
    are a warning of their own. Of more than 4.2·10⁶ samples, 32 evenly spread parts are used for neighbouring
    samples.
    """
    if len(stream.channels) < 2 or stream.grid.n < 4 * THRESHOLDS.stretches:
        return []
    columns = {channel: stream.column(channel) for channel in stream.channels}
    pairs = list(combinations(stream.channels, 2))
    lengths = _lengths(stream)
    level = THRESHOLDS.false_alarm / ((1 + len(lengths)) * len(pairs))
    fast = {channel: _differences(column) for channel, column in columns.items()}
    slow = [{channel: _slow(column, length) for channel, column in columns.items()} for length in lengths]
    correlated: list[AxisPair] = []
    identical: list[Finding] = []
    for first, second in pairs:
        if _are_identical(columns[first], columns[second]):
            copies = IdenticalAxes(samples=len(columns[first]))
            identical.append(Finding(details=copies, severity="warning", channels=(first, second)))
            continue
        # Squares of extreme values overflow or vanish; a channel in the wrong unit is for another check.
        with np.errstate(over="ignore", under="ignore", invalid="ignore", divide="ignore"):
            r, mean_length = _by_stretches(fast[first], fast[second], level), 0
            for length, means in zip(lengths, slow, strict=True):
                slower = _by_number(means[first], means[second], level)
                if abs(slower) > abs(r) + _chance(len(means[first]), 0.05, THRESHOLDS.inflation):
                    r, mean_length = slower, length
        if THRESHOLDS.reported <= abs(r) <= 1 + 1e-9:
            seconds = mean_length * stream.grid.tau0
            correlated.append(AxisPair(first=first, second=second, coefficient=r, mean_length=seconds))
    if not correlated:
        return identical
    correlated.sort(key=lambda pair: -abs(pair.coefficient))
    largest = abs(correlated[0].coefficient)
    stretches = 1 if stream.grid.n <= THRESHOLDS.most_samples else THRESHOLDS.stretches
    only_slow = all(pair.mean_length for pair in correlated)
    details = CorrelatedAxes(pairs=tuple(correlated), only_slow=only_slow, stretches=stretches)
    channels = tuple(c for c in stream.channels if any(c in (pair.first, pair.second) for pair in correlated))
    return [*identical, Finding(details=details, severity="info", channels=channels, size=largest)]


def _are_identical(first: Floats, second: Floats) -> bool:
    """Whether two columns have the same samples and the same missing samples. Most columns differ in the first few."""
    return np.array_equal(
        first[: THRESHOLDS.stretches], second[: THRESHOLDS.stretches], equal_nan=True
    ) and np.array_equal(first, second, equal_nan=True)


def _lengths(stream: Stream) -> list[int]:
    """Lengths of the means in samples: from 1 s up to the longest of which there are enough."""
    length, longest = max(round(1 / stream.grid.tau0), 1), stream.grid.n // (THRESHOLDS.least_means + 1)
    lengths = []
    while length < longest:
        lengths.append(length)
        length *= THRESHOLDS.longer
    return [each for each in [*lengths, longest] if each > 1]


def _differences(column: Floats) -> Floats:
    """First differences in stretches, shape (32, k), 0 where one of the two samples is missing."""
    n = len(column)
    if n > THRESHOLDS.most_samples:
        size = THRESHOLDS.most_samples // THRESHOLDS.stretches
        starts = np.linspace(0, n - size, THRESHOLDS.stretches).astype(np.int64)
        d = np.stack([np.diff(column[start : start + size]) for start in starts])
    else:
        size = n // THRESHOLDS.stretches
        d = np.diff(column[: size * THRESHOLDS.stretches].reshape(THRESHOLDS.stretches, size), axis=1)
    return _centred(d)


def _slow(column: Floats, length: int) -> Floats:
    """Differences of means over `length` samples, 0 where half of them are missing, without a ramp."""
    count = len(column) // length
    return _centred(np.diff(row_means(column[: count * length].reshape(count, length))))


def _centred(d: Floats) -> Floats:
    """Differences without their mean, which is a ramp, and would be common to all axes that have one; 0 where missing."""
    mean = float(np.sum(d)) / max(int(d.size), 1)
    if not np.isnan(mean):
        return d - mean
    is_present = ~np.isnan(d)
    d[~is_present] = 0.0
    d[is_present] -= float(d.sum()) / max(int(np.count_nonzero(is_present)), 1)
    return d


def _by_stretches(a: Floats, b: Floats, level: float) -> float:
    """Correlation, 0 where that of the stretches scatters about 0 by chance."""
    both = np.einsum("ij,ij->i", a, b)
    power = np.einsum("ij,ij->i", a, a), np.einsum("ij,ij->i", b, b)
    if not (power[0].sum() > 0 and power[1].sum() > 0):
        return 0.0
    r = float(both.sum() / np.sqrt(power[0].sum() * power[1].sum()))
    has_power = (power[0] > 0) & (power[1] > 0)
    each = both[has_power] / np.sqrt(power[0][has_power] * power[1][has_power])
    count = len(each)
    if count < THRESHOLDS.stretches // 2:
        return 0.0
    bound = float(student_quantile(count - 1, 1 - level / 2)) * float(np.std(each, ddof=1)) / np.sqrt(count)
    number = int(np.count_nonzero((a != 0) & (b != 0))) if a.size <= 1 << 16 else a.size
    return r if abs(r) > max(bound, _chance(number, level, THRESHOLDS.inflation)) else 0.0


def _by_number(a: Floats, b: Floats, level: float) -> float:
    """Correlation, 0 where its number of pairs makes as much by chance."""
    number = int(np.count_nonzero((a != 0) & (b != 0)))
    if number < THRESHOLDS.least_means:
        return 0.0
    r = float(a @ b / np.sqrt((a @ a) * (b @ b)))
    return r if abs(r) > _chance(number, level, THRESHOLDS.inflation) else 0.0


@lru_cache
def _chance(number: int, level: float, inflation: float) -> float:
    """Correlation that independent series exceed with probability `level`, by Student's law."""
    freedom = max(number / inflation - 2, 1.0)
    t = float(student_quantile(freedom, 1 - level / 2))
    return float(t / np.sqrt(freedom + t * t))
