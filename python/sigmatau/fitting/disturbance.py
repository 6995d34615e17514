"""Records whose noise is hidden, by vibration or by rounding: when a fit says so, and the upper limits that remain."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np

from sigmatau._native.distributions import normal_quantile
from sigmatau.arrays import Floats
from sigmatau.estimators.octaves import octaves
from sigmatau.findings.reasons import Reason, VibrationPower
from sigmatau.fitting.fitted_values import FittedTerm
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.model.parameters import Covariance
from sigmatau.noise.terms import avar
from sigmatau.record.streams import Stream

MAX_SHARE = 0.85
"""Largest share of lines and narrow resonances in the power of a quiet sensor; 0.83 is the largest of 270 fits of parts of
real records at rest, see docs/study/disturbed.md."""

MAX_HIDING_SHARE, HIDDEN = 0.3, 0.6
"""Share of such power from which on the random walk must show in the curve; and its least size there, over the limit that
the curve sets: 0.72 is the least of quiet real records with so large a share."""

MAX_BURSTS = 3.0
"""Largest power of the loudest times over that of the median, relative to normal noise and to neighbouring samples: 1.45 is
the largest of 198 parts of real records at rest, see docs/study/disturbed.md."""

_LEAST_BURSTS = 8  # samples of a cluster of which rounding leaves enough values
_BURST_BLOCKS, _MOST_BURST_BLOCKS = 256, 2048  # pairs of clusters: with 256 the ratio has a standard error of 20 %
_LONGEST_BURST = 1.0  # averaging time: people and vehicles move faster, and temperature changes slower [s]
_COUNTS = 3.0  # steps of the log that the sum of a cluster must vary by
_LOUD_SHARE = 0.975  # of the times that are not among the loudest

# Half width over centre, and centre, of a resonance that is a vibration: largest, and least. [1, Hz]
_NARROW, _SLOWEST = 0.25, 0.5

# Beside some lines of a steady machine or the mains a steady white level is known: their number at most, the largest power
# of narrow resonances over theirs, and the least p-value of a white level that is the same in all eighths of the record.
_STEADY_LINES, _STEADY_RESONANCES, _UNSTEADY = 3, 0.1, 1e-3

_LEAST_SIZE = (
    32  # samples of a cluster at which a filter with a corner above 1/20 of the rate lowers σ² by less than 15 %
)
_QUANTILE = 2.5  # normal quantile by which an Allan variance is taken higher: the least of many is used
_MIN_PAIRS = 16  # of clusters: with fewer, the limit of a variance is more than 5 times it
_MIN_PAIRS_HIDDEN = 64  # the same, where the limit is compared: of white noise alone it is then at most 1.36 times N
_STRETCHES, _LEAST_STRETCH = 8, 1024  # parts of which the quietest is named, at most, and least samples of a part
_LONGEST = 1 << 24  # samples that are used, and of those that are looked at in every record
_LONGEST_LOOK = 1 << 21


def vibration_share(fitted: NoiseFit) -> float:
    """Share of lines and narrow resonances in the power of the record, beside random walk and quantization noise."""
    shaken = sum(line.amplitude.value**2 / 2 for line in fitted.sinusoid) + _power_of_resonances(fitted)
    walk = fitted.terms.get("random_walk")
    level = 0.0 if walk is None else walk.value or walk.upper_limit or 0.0
    rounding = fitted.model.get("quantization", 0.0) / fitted.tau0
    noise = level**2 / fitted.tau0 + 2 * rounding**2
    return shaken / (shaken + noise) if shaken > 0 else 0.0


def burst_share(x: Floats, tau0: float) -> float:
    """Share of motion that comes and goes in the power of the loudest times; 0 if none is seen.

    People and vehicles move a sensor at times, for a fraction of a second or longer. Differences of neighbouring clusters
    then have a distribution with wide tails, which those of neighbouring samples, mostly noise, have not.
    """
    steps = np.abs(np.diff(x[: 2 * _MOST_BURST_BLOCKS]))
    step = float(np.min(steps, where=steps > 0, initial=math.inf))
    reference, largest, m = max(_loudness(x, 1, 0.0), 1.0), 1.0, _LEAST_BURSTS
    while len(x) // (2 * m) >= _BURST_BLOCKS and m * tau0 <= _LONGEST_BURST:
        largest = max(largest, _loudness(x, m, _COUNTS * step))
        m *= 2
    return 1 - reference / largest if largest > MAX_BURSTS * reference else 0.0


def _loudness(x: Floats, m: int, least: float) -> float:
    """Power of the loudest differences of sums of `m` samples over that of the median, relative to normal ones.

    1 if there are too few, or if the median is below `least`.
    """
    count = len(x) // (2 * m)
    blocks = x[: count * 2 * m].reshape(count, 2, m)[:: max(1, count // _MOST_BURST_BLOCKS)]
    sizes = np.abs(np.diff(blocks.sum(axis=2), axis=1)).ravel()
    sizes = sizes[np.isfinite(sizes)]
    if len(sizes) < _BURST_BLOCKS:
        return 1.0
    median, loud = np.quantile(sizes, (0.5, _LOUD_SHARE)).tolist()
    return (loud / median / _loud_of_normal()) ** 2 if median > max(least, 0.0) else 1.0


@cache
def _loud_of_normal() -> float:
    """The loudest sizes over the median of those of normal noise."""
    return float(normal_quantile((1 + _LOUD_SHARE) / 2)) / float(normal_quantile(0.75))


def _samples(fitted: NoiseFit, stream: Stream, *, most: int = _LONGEST) -> Floats:
    return stream.samples.read(stream.channels.index(fitted.channel), 0, min(stream.grid.n, most))


def _is_hidden(fitted: NoiseFit, stream: Stream) -> bool:
    """Whether the Allan deviations are all well above the random walk of the model, or one is surely below it."""
    walk = fitted.terms.get("random_walk")
    level = None if walk is None else walk.value or walk.upper_limit
    if walk is None or level is None:
        return False
    x = _samples(fitted, stream)

    def limit(pairs: int) -> float:
        return upper_limits(x, fitted.tau0, ("random_walk",), min_pairs=pairs)["random_walk"]

    return level < HIDDEN * limit(_MIN_PAIRS_HIDDEN) < math.inf or (walk.low or 0.0) > limit(_MIN_PAIRS)


def _power_of_resonances(fitted: NoiseFit) -> float:
    return sum(r.sigma.value**2 for r in fitted.resonance if is_narrow(r.frequency.value, r.width.value))


def is_narrow(frequency: float, width: float) -> bool:
    """Whether a resonance is a vibration: no shape of the sensor's noise, and no drift."""
    return width < _NARROW * frequency and frequency > _SLOWEST


def is_disturbed(fitted: NoiseFit, stream: Stream, *, unsteady: float) -> bool:
    """Whether vibration hides the noise: it comes and goes, or it has much of the power and the white noise of the model
    shows at no averaging time, or it has most of the power. Some steady lines beside a white level that shows hide nothing.

    `unsteady` is the p-value of a white level that is the same in all eighths of the record.
    """
    if burst_share(_samples(fitted, stream, most=_LONGEST_LOOK), fitted.tau0) > 0:
        return True
    share = vibration_share(fitted)
    if share <= MAX_HIDING_SHARE:
        return False
    if _is_hidden(fitted, stream):
        return True
    lines = sum(line.amplitude.value**2 / 2 for line in fitted.sinusoid)
    few = len(fitted.sinusoid) <= _STEADY_LINES and _power_of_resonances(fitted) <= _STEADY_RESONANCES * lines
    return share > MAX_SHARE and not (few and unsteady >= _UNSTEADY and fitted.verdict != "widened")


def vibration_of(fitted: NoiseFit, stream: Stream) -> VibrationPower:
    """The share of the vibration in the power, and the quietest stretch of the record with its limit if that is smaller."""
    x = _samples(fitted, stream)
    first, last, least = _quietest(x, fitted.tau0)
    whole = upper_limits(x, fitted.tau0, ("random_walk",))["random_walk"]
    return VibrationPower(
        lines=len(fitted.sinusoid),
        resonances=len(fitted.resonance),
        share=max(vibration_share(fitted), burst_share(x[:_LONGEST_LOOK], fitted.tau0)),
        start=stream.grid.time(first),
        stop=stream.grid.time(last),
        quietest=least if 0 < least < whole else None,
    )


def with_limits(fitted: NoiseFit, stream: Stream, reason: Reason) -> NoiseFit:
    """The fit of a record whose noise is hidden: upper limits of all terms."""
    x = _samples(fitted, stream)
    limits = upper_limits(x, fitted.tau0, tuple(fitted.terms))
    walk = limits.get("random_walk", math.inf)
    return replace(
        fitted,
        verdict="disturbed",
        terms={name: _limit(term, limits.get(name)) for name, term in fitted.terms.items()},
        model={"random_walk": walk} if math.isfinite(walk) else {},
        reasons=(reason, *fitted.reasons),
        gauss_markov=(),
        response=None,
        warm_up=None,
        alike_from=None,
        alike_sigma=None,
        second=(),
        unclear=(),
        discrepancy=(),
        covariance=Covariance(),
    )


def _limit(term: FittedTerm, limit: float | None) -> FittedTerm:
    known = limit is not None and math.isfinite(limit)
    return FittedTerm(
        term=term.term, unit=term.unit, observed=False, level=term.level, upper_limit=limit if known else None
    )


def upper_limits(x: Floats, tau0: float, terms: Sequence[str], *, min_pairs: int = _MIN_PAIRS) -> dict[str, float]:
    """Upper limit of each term from the Allan variances: every other term, and every vibration, only adds to them.

    A low-pass filter takes white and slow noise away at short times, so that their limits come from clusters of 32 samples
    on. `inf` where there are too few.
    """
    limits = dict.fromkeys(terms, math.inf)
    for m, variance, pairs in octaves(x):
        if pairs < min_pairs:
            break
        spread = 2 / (9 * (2 * pairs / 3))  # of χ² with 2/3 a pair of clusters of white noise (Lesage and Audoin)
        high = variance / (1 - spread - _QUANTILE * math.sqrt(spread)) ** 3  # its lower quantile (Wilson and Hilferty)
        for name in terms:
            if m >= _LEAST_SIZE or name == "quantization":
                unit = float(avar(name, 1.0, m=m, tau0=tau0)[0])
                limits[name] = min(limits[name], math.sqrt(high / unit))
    return limits


def _quietest(x: Floats, tau0: float) -> tuple[int, int, float]:
    """First sample, end and upper limit of the random walk of the stretch in which that is least."""
    count = max(min(_STRETCHES, len(x) // _LEAST_STRETCH), 1)
    edges = np.linspace(0, len(x), count + 1).astype(int).tolist()
    found = [(upper_limits(x[a:b], tau0, ("random_walk",))["random_walk"], a, b) for a, b in pairwise(edges)]
    limit, first, last = min(found)
    return first, last, limit
