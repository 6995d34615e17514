"""Bias stability as the standard deviation of 10 s or 100 s means, as in GJB 2426A.

The means of consecutive stretches of a record have a sample variance (ddof = 1) that grows with the length of the record for
slow noise, so the number only describes records of this length. The interval is that of the square root of the expected
variance at this length. The modes of the means (cosine transform, type II) are independent to a good approximation: their
expected powers follow from the fitted model, and the variance is a sum of χ² of one degree of freedom with these weights.
The interval includes the ends of the intervals of flicker noise and random walk, and covers the truth in at least 95 % of
records.

References
----------
.. [1] GJB 2426A-2015, test methods of fibre-optic gyros: bias stability as the STD of 10 s means.
.. [2] D. Kuonen, "Saddlepoint approximations for distributions of quadratic forms in normal variables," Biometrika,
   vol. 86, no. 4, 1999, :doi:`10.1093/biomet/86.4.929`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.fitting.log_spectra import cosine_modes
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.frozen import frozen
from sigmatau.noise.terms import NOISE, SLOW
from sigmatau.record.streams import Stream
from sigmatau.results import plain

AVERAGES = (10.0, 100.0)
"""Averaging times that are computed. [s]"""

MIN_MEANS = 10
"""Smallest number of means: a variance of fewer means is too uncertain."""

_MIN_PRESENT = 0.5  # smallest share of the samples of a mean that must be present
_PIECE = 1 << 20  # samples read at a time
_MODES_AT_ONCE = 1 << 12  # number of modes whose aliases are in memory
# number of aliases on each side of a mode that are summed; the remaining aliases are treated as white noise
_ALIASES = 16
_SLOW = tuple(name for name in NOISE if name in SLOW)
# The search is in the logarithm of 1 − 2·w·tilt of the largest weight w, in which the normal quantile is nearly straight.
_FIRST_STEP = 0.5  # first step from 0, doubled until two points bracket the quantile
_SEARCH_END = 40.0  # farthest point of the search
_SADDLEPOINT_GAP = 0.01  # distance from 0 within which the saddlepoint formula cancels numerically
_STEPS = 40
_QUANTILE_TOLERANCE = 1e-10  # tolerance of a normal quantile


@frozen
class MeanStability:
    """Standard deviation of the means of one averaging time.

    Attributes
    ----------
    average : float
        Averaging time. [s]
    means : int
        Number of means.
    value : float
        Standard deviation of the means, ddof = 1. [rate unit]
    low, high : float or None
        Interval of the expected value at this length of the record; None if no model fits. [rate unit]
    edf : float or None
        Equivalent degrees of freedom of the variance, (ΣS)²/ΣS² of the modes.
    level : float
        Confidence level of the interval.
    unit : str
        SI unit of the rate.
    """

    average: float
    means: int
    value: float
    low: float | None
    high: float | None
    edf: float | None
    level: float
    unit: str

    def to_dict(self) -> dict[str, Any]:
        """Plain values; an interval only if there is one."""
        values = plain(self, "average_s=average means value low high edf level unit")
        return {key: value for key, value in values.items() if value is not None}


def mean_stability(
    stream: Stream, channel: str, fitted: NoiseFit | None, *, averages: tuple[float, ...] = AVERAGES
) -> tuple[MeanStability, ...]:
    """Standard deviations of the means of a channel, with the intervals of a fitted model.

    Parameters
    ----------
    stream : Stream
    channel : str
    fitted : NoiseFit or None
        Without a model that fits, the values have no intervals.
    averages : tuple of float
        Averaging times, rounded to whole samples. [s]

    Returns
    -------
    tuple of MeanStability
        For each averaging time with at least ten means.
    """
    tau0, k = stream.grid.tau0, stream.channels.index(channel)
    results = []
    for average in averages:
        m = round(average / tau0)
        if m < 1 or stream.grid.n // m < MIN_MEANS:
            continue
        means = _means(stream, k, m)
        y = means[np.isfinite(means)]
        if len(y) < MIN_MEANS:
            continue
        value = float(np.std(y, ddof=1))
        low, high, edf = (None, None, None) if fitted is None else _interval(value, fitted, m, len(y))
        level = 0.95 if fitted is None else fitted.level
        results.append(
            MeanStability(
                average=m * tau0, means=len(y), value=value, low=low, high=high, edf=edf, level=level, unit=stream.unit
            )
        )
    return tuple(results)


def _means(stream: Stream, channel: int, m: int) -> Floats:
    """Means of consecutive stretches of `m` samples; NaN if fewer than half of the samples are present."""
    blocks = stream.grid.n // m
    at_once = max(_PIECE // m, 1)
    means = np.full(blocks, np.nan)
    for first in range(0, blocks, at_once):
        last = min(first + at_once, blocks)
        rows = stream.samples.read(channel, first * m, last * m).reshape(last - first, m)
        means[first:last] = rows.mean(axis=1)
        for k in np.flatnonzero(~np.isfinite(means[first:last])):
            present = rows[k][np.isfinite(rows[k])]
            means[first + k] = present.mean() if len(present) >= _MIN_PRESENT * m else np.nan
    return means


def _interval(value: float, fitted: NoiseFit, m: int, n: int) -> tuple[float | None, float | None, float | None]:
    """Interval of the expected value and its degrees of freedom; None without a model that fits."""
    if not fitted.quantified or not value > 0:
        return None, None, None
    tail = (1 - fitted.level) / 2
    lows, highs, freedoms = [], [], []
    for powers, drifts in mode_powers(tuple(_models(fitted)), m, n):
        total, noise = float((powers + drifts).sum()), float(powers.sum())
        if not (total > 0 and noise > 0):
            return None, None, None
        # The ratio of the measured to the expected variance lies between these quantiles with the probability `level`.
        below, above = (quantile(powers / total, drifts / total, probability) for probability in (tail, 1 - tail))
        lows.append(value / math.sqrt(above))
        highs.append(value / math.sqrt(below))
        freedoms.append(noise**2 / float((powers**2).sum()))
    return min(lows), max(highs), freedoms[0]


def _models(fitted: NoiseFit) -> Iterator[NoiseFit]:
    """The fitted model, and variants with each slow term at the ends of its interval or at its limit.

    A random walk that the record does not determine makes the variance of its means much less certain.
    """
    yield fitted
    for name in _SLOW:
        term = fitted.terms.get(name)
        if term is None:
            continue
        for end in (term.low, term.high, term.upper_limit):
            if end is not None and math.isfinite(end):
                yield replace(fitted, model={**fitted.model, name: end})


def mode_powers(models: Sequence[NoiseFit], m: int, n: int) -> list[tuple[Floats, Floats]]:
    """Expected powers of the modes 1 … n − 1 of `n` means of `m` samples for models of one record: of the noise, and of the
    deterministic parts (ramp, warm-up, lines). [(rate unit)²]
    """
    tau0 = models[0].tau0
    span = m * tau0
    f = np.arange(1, n) / (2 * n * span)
    half = 0.5 / tau0
    beyond = min((_ALIASES + 1) / span, half)
    aliases = np.arange(-_ALIASES, _ALIASES + 1)[:, np.newaxis] / span
    powers = np.empty((len(models), n - 1))
    for first in range(0, n - 1, _MODES_AT_ONCE):
        part = slice(first, first + _MODES_AT_ONCE)
        shifted = f[part] + aliases
        gain = np.sinc(shifted * span) ** 2
        rest = np.maximum(1 - gain.sum(axis=0), 0.0)
        # The spectrum of the samples repeats, and is even.
        folded = np.abs(shifted - np.round(shifted * tau0) / tau0)
        frequencies = np.append(np.clip(folded, f[0], half), beyond)
        for row, model in zip(powers, models, strict=True):
            densities = model.psd(frequencies)
            row[part] = (gain * densities[:-1].reshape(gain.shape)).sum(axis=0) + rest * densities[-1]
    return [(row / span, _drifts(model, span, n)) for row, model in zip(powers, models, strict=True)]


def _drifts(fitted: NoiseFit, span: float, n: int) -> Floats:
    """Squared modes of the parts that are not noise."""
    t = (np.arange(n) + 0.5) * span
    mean = fitted.model.get("rate_ramp", 0.0) * t
    if fitted.warm_up is not None:
        mean = mean + fitted.warm_up.amplitude.value * np.exp(-t / fitted.warm_up.time)
    power = np.zeros(n - 1)
    if mean.any():
        power += 2 / n * cosine_modes(np.asarray(mean, dtype=np.float64))[1:] ** 2
    for line in fitted.sinusoid:
        frequency = line.frequency.value
        amplitude = line.amplitude.value * abs(np.sinc(frequency * span))
        distance = abs(frequency - round(frequency * span) / span)
        mode = min(max(round(2 * n * span * distance), 1), n - 1)
        power[mode - 1] += n * amplitude**2 / 2
    return power


def quantile(weights: Floats, shifts: Floats, probability: float) -> float:
    """Quantile of Σ (√w·z + √d)² with independent standard normal z, by the saddlepoint approximation [2]_.

    Parameters
    ----------
    weights : ndarray
        Variances w of the modes, at least one above 0.
    shifts : ndarray
        Squares d of their means.
    probability : float

    Returns
    -------
    float

    Notes
    -----
    With w = 1 and d = 0 the law is χ². The error is below 0.6 % for three or more equal modes, and 2 % for a random walk.
    """
    wanted = NormalDist().inv_cdf(probability)
    law = _SquaresLaw(weights, float(weights.max()), shifts if shifts.any() else None)
    # The search brackets the quantile from the middle outwards, then uses the Illinois variant of false position.
    a = b = -_SADDLEPOINT_GAP if wanted > 0 else _SADDLEPOINT_GAP
    value, logarithm = law.saddlepoint(a)
    off_a = off_b = logarithm - wanted
    step = _FIRST_STEP if off_a > 0 else -_FIRST_STEP
    while off_a * off_b > 0 and abs(b) < _SEARCH_END:
        a, off_a = b, off_b
        b, step = step, 2 * step
        value, logarithm = law.saddlepoint(b)
        off_b = logarithm - wanted
    for _ in range(_STEPS):
        if abs(off_b) < _QUANTILE_TOLERANCE or off_a == off_b:
            break
        c = b - off_b * (b - a) / (off_b - off_a)
        value, logarithm = law.saddlepoint(c)
        if (logarithm - wanted) * off_b < 0:
            a, off_a = b, off_b
        else:
            off_a /= 2
        b, off_b = c, logarithm - wanted
    return value


class _SquaresLaw(NamedTuple):
    """The law of Σ (√w·z + √d)² with independent standard normal z."""

    weights: Floats
    largest: float
    shifts: Floats | None  # None if all are 0

    def saddlepoint(self, logarithm: float) -> tuple[float, float]:
        """Value whose saddlepoint has a logarithm of 1 − 2·w·tilt with the largest w, and the normal quantile of the
        probability of not exceeding it (Lugannani-Rice, in the form of Barndorff-Nielsen).
        """
        tilt = -0.5 * math.expm1(logarithm) / self.largest
        if abs(tilt) * self.largest < 1e-5:
            tilt = math.copysign(1e-5 / self.largest, tilt)
        shrunk = 1 - 2 * self.weights * tilt
        scaled = self.weights / shrunk
        value = float(scaled.sum())
        cumulant = -0.5 * float(np.log(shrunk).sum())
        curvature = 2 * float(scaled @ scaled)
        if self.shifts is not None:
            moved = self.shifts / shrunk
            value += float((moved / shrunk).sum())
            cumulant += tilt * float(moved.sum())
            curvature += 4 * float((scaled * moved / shrunk).sum())
        w = math.copysign(math.sqrt(max(2 * (tilt * value - cumulant), 1e-300)), tilt)
        v = tilt * math.sqrt(curvature)
        return value, w + math.log(v / w) / w
