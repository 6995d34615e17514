"""Correlation of the noise of the axes of a stream.

Each pair of axes is measured by two kinds of correlation. The correlation of first differences shows fast common noise:
vibration, a line, a common converter. The correlation of differences of means over 1 s, 4 s, 16 s and so on shows slow
common noise: supply, temperature, a rate random walk that white noise hides in shorter means. Differences are used
because random walks and drifts are correlated by chance.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import combinations

import numpy as np

from sigmatau._native.distributions import student_quantile
from sigmatau.arrays import Floats
from sigmatau.findings.finding import Finding
from sigmatau.findings.spectrum import AxisPair, CorrelatedAxes, IdenticalAxes
from sigmatau.quality.samples.common import row_means
from sigmatau.record.streams import Stream

# Probability of a finding for a stream with independent axes, divided among its pairs of axes and its measures. [1]
# Judgement: one false alarm in 10⁴ records.
_FALSE_ALARM = 1e-4
# Smallest correlation that is reported. [1] Derived: a smaller one has no consequence; the variance of the mean of
# two Allan variances grows by the factor 1 + r².
_REPORTED = 0.05
# Smallest number of means whose correlation is measured. [1] Judgement: its error is then 0.13.
_MIN_MEANS = 60
# Factor from one length of means to the next; the last is the longest with `_MIN_MEANS` means. [1] Judgement: slow
# common noise shows within two octaves.
_LONGER = 4
# Variance of the correlation of two independent Gaussian series of length n, times n: Σ ρ₁(l)ρ₂(l) over all lags. [1]
# Derived: Bartlett 1935. First differences of white noise (ρ = −1/2 at lag 1) give 1.5; those of quantization noise
# (−2/3 and 1/6) give 1.944, the maximum over all mixtures of the five terms.
INFLATION = 1 + 2 * (4 / 9 + 1 / 36)
# Number of stretches, whose spread gives the error of the correlation of fast differences, by Student's t, if
# neighbouring samples are correlated. [1] Judgement: the spread has an error of an eighth.
_STRETCHES = 32
# Number of samples for fast differences, in evenly spaced stretches. [samples] Judgement: limits the time.
_MAX_SAMPLES = 1 << 22


def cross_axis(stream: Stream) -> list[Finding]:
    """Report correlation of the axes of a stream beyond chance: at most one ``"correlated_axes"``.

    A filter then needs the covariance of the axes; the intervals of each axis remain valid. Identical axes are a separate
    warning. If there are more than 4.2·10⁶ samples, fast differences are taken from 32 evenly spaced parts.
    """
    if len(stream.channels) < 2 or stream.grid.n < 4 * _STRETCHES:
        return []
    columns = {channel: stream.column(channel) for channel in stream.channels}
    pairs = list(combinations(stream.channels, 2))
    lengths = _lengths(stream)
    level = _FALSE_ALARM / ((1 + len(lengths)) * len(pairs))
    fast = {channel: _differences(column) for channel, column in columns.items()}
    slow = [{channel: _mean_differences(column, length) for channel, column in columns.items()} for length in lengths]
    correlated: list[AxisPair] = []
    identical: list[Finding] = []
    for first, second in pairs:
        if _are_identical(columns[first], columns[second]):
            copies = IdenticalAxes(samples=len(columns[first]))
            identical.append(Finding(details=copies, severity="warning", channels=(first, second)))
            continue
        # The squares of extreme values overflow or vanish; another check reports such a channel.
        with np.errstate(over="ignore", under="ignore", invalid="ignore", divide="ignore"):
            r, mean_length = _fast_correlation(fast[first], fast[second], level), 0
            for length, means in zip(lengths, slow, strict=True):
                slower = _slow_correlation(means[first], means[second], level)
                if abs(slower) > abs(r) + _chance(len(means[first]), 0.05, INFLATION):
                    r, mean_length = slower, length
        if _REPORTED <= abs(r) <= 1 + 1e-9:
            seconds = mean_length * stream.grid.tau0
            correlated.append(AxisPair(first=first, second=second, coefficient=r, mean_length=seconds))
    if not correlated:
        return identical
    correlated.sort(key=lambda pair: -abs(pair.coefficient))
    largest = abs(correlated[0].coefficient)
    stretches = 1 if stream.grid.n <= _MAX_SAMPLES else _STRETCHES
    only_slow = all(pair.mean_length for pair in correlated)
    details = CorrelatedAxes(pairs=tuple(correlated), only_slow=only_slow, stretches=stretches)
    channels = tuple(c for c in stream.channels if any(c in (pair.first, pair.second) for pair in correlated))
    return [*identical, Finding(details=details, severity="info", channels=channels, size=largest)]


def _are_identical(first: Floats, second: Floats) -> bool:
    """Whether two columns are identical, with the same missing samples. Most columns already differ in the first few."""
    return np.array_equal(first[:_STRETCHES], second[:_STRETCHES], equal_nan=True) and np.array_equal(
        first, second, equal_nan=True
    )


def _lengths(stream: Stream) -> list[int]:
    """Lengths of the means in samples: from 1 s up to the longest with `_MIN_MEANS` means."""
    length, longest = max(round(1 / stream.grid.tau0), 1), stream.grid.n // (_MIN_MEANS + 1)
    lengths = []
    while length < longest:
        lengths.append(length)
        length *= _LONGER
    return [each for each in [*lengths, longest] if each > 1]


def _differences(column: Floats) -> Floats:
    """First differences in stretches, shape (32, k), 0 where one of the two samples is missing."""
    n = len(column)
    if n > _MAX_SAMPLES:
        size = _MAX_SAMPLES // _STRETCHES
        starts = np.linspace(0, n - size, _STRETCHES).astype(np.int64)
        d = np.stack([np.diff(column[start : start + size]) for start in starts])
    else:
        size = n // _STRETCHES
        d = np.diff(column[: size * _STRETCHES].reshape(_STRETCHES, size), axis=1)
    return _centred(d)


def _mean_differences(column: Floats, length: int) -> Floats:
    """Differences of means over `length` samples, without a ramp; 0 if half of the samples are missing."""
    count = len(column) // length
    return _centred(np.diff(row_means(column[: count * length].reshape(count, length))))


def _centred(d: Floats) -> Floats:
    """Subtract the mean of the differences, which is a ramp that axes may have in common by chance. Missing differences
    become 0.
    """
    mean = float(np.sum(d)) / max(int(d.size), 1)
    if not np.isnan(mean):
        return d - mean
    is_present = ~np.isnan(d)
    d[~is_present] = 0.0
    d[is_present] -= float(d.sum()) / max(int(np.count_nonzero(is_present)), 1)
    return d


def _fast_correlation(a: Floats, b: Floats, level: float) -> float:
    """Correlation of fast differences; 0 if the scatter of the stretches explains it."""
    both = np.einsum("ij,ij->i", a, b)
    power = np.einsum("ij,ij->i", a, a), np.einsum("ij,ij->i", b, b)
    if not (power[0].sum() > 0 and power[1].sum() > 0):
        return 0.0
    r = float(both.sum() / np.sqrt(power[0].sum() * power[1].sum()))
    has_power = (power[0] > 0) & (power[1] > 0)
    each = both[has_power] / np.sqrt(power[0][has_power] * power[1][has_power])
    count = len(each)
    if count < _STRETCHES // 2:
        return 0.0
    bound = float(student_quantile(count - 1, 1 - level / 2)) * float(np.std(each, ddof=1)) / np.sqrt(count)
    number = int(np.count_nonzero((a != 0) & (b != 0))) if a.size <= 1 << 16 else a.size
    return r if abs(r) > max(bound, _chance(number, level, INFLATION)) else 0.0


def _slow_correlation(a: Floats, b: Floats, level: float) -> float:
    """Correlation of slow differences; 0 if chance explains it with this number of pairs."""
    number = int(np.count_nonzero((a != 0) & (b != 0)))
    if number < _MIN_MEANS:
        return 0.0
    r = float(a @ b / np.sqrt((a @ a) * (b @ b)))
    return r if abs(r) > _chance(number, level, INFLATION) else 0.0


@lru_cache
def _chance(number: int, level: float, inflation: float) -> float:
    """Correlation that independent series exceed with probability `level`, by Student's law."""
    freedom = max(number / inflation - 2, 1.0)
    t = float(student_quantile(freedom, 1 - level / 2))
    return float(t / np.sqrt(freedom + t * t))
