"""Tests whether vibration or rounding hides the noise of a record, and the upper limits that remain."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from sigmatau._native.distributions import normal_quantile
from sigmatau.arrays import Floats, quantile
from sigmatau.estimators.octaves import octaves
from sigmatau.findings.reasons import CoarseCounts, VibrationPower
from sigmatau.fitting.adjustment import Adjustment, Cause, Change, Part
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.model.parameters import Parameter
from sigmatau.noise.terms import avar
from sigmatau.record.streams import Stream

# Largest share of lines and narrow resonances in the power of a quiet sensor. [1] Study: docs/study/disturbed.md; 0.83
# is the largest of 270 fits of parts of real records at rest.
MAX_SHARE = 0.85
# Share of such power above which the random walk must be visible in the curve. [1] Study: docs/study/disturbed.md.
MAX_HIDING_SHARE = 0.3
# Smallest ratio of the fitted random walk to the limit from the curve, above that share. [1] Study:
# docs/study/disturbed.md; 0.72 is the smallest of quiet real records.
HIDDEN = 0.6
# Largest ratio of the power at the loudest times to that at the median, relative to normal noise and to neighbouring
# samples. [1] Study: docs/study/disturbed.md; 1.45 is the largest of 198 parts of real records at rest.
MAX_BURSTS = 3.0
# Smallest cluster whose power is compared. [samples] Judgement: rounding leaves enough distinct values of the sum.
_MIN_CLUSTER = 8
# Smallest number of pairs of clusters. [1] Derived: the ratio then has a standard error of 20 %.
_BURST_BLOCKS = 256
# Length of sums below which NumPy is slow. [samples] Judgement: changes the time, not the result.
_SHORT_SUM = 32
# Largest number of pairs of clusters. [1] Judgement: limits the time.
_MAX_BURST_BLOCKS = 2048
# Longest averaging time of a cluster. [s] Judgement: people and vehicles move faster, and temperature changes more
# slowly.
_LONGEST_BURST = 1.0
# Smallest change of the sum of a cluster. [steps] Judgement: rounding changes it by one or two.
_MIN_CHANGE = 3.0
# Quantile of the loudness that is compared. [1] Judgement: people move a sensor for a fortieth of the time.
_LOUD_SHARE = 0.975
# Largest half width of a resonance over its centre, if it is a vibration. [1] Judgement: a wider one is a property of
# the sensor's noise.
_NARROW = 0.25
# Lowest centre of a resonance that is a vibration. [Hz] Judgement: a slower one is a drift.
_SLOWEST = 0.5
# Largest number of lines of a steady machine or of the mains that leave a steady white level visible. [1] Study:
# docs/study/disturbed.md.
_STEADY_LINES = 3
# Largest power of narrow resonances over that of these lines. [1] Judgement: a resonance is seldom steady.
_STEADY_RESONANCES = 0.1
# Smallest p-value of an equal white level in all eighths of the record. [1] Judgement: one false alarm in 1000 axes
# with this much vibration.
_UNSTEADY = 1e-3
# Smallest cluster whose variance limits white noise. [samples] Derived: a filter with a corner above 1/20 of the rate
# lowers σ² by less than 15 % there.
_MIN_SIZE = 32
# Normal quantile by which an Allan variance is raised. [1] Derived: probability 0.6 %, because the smallest of many
# variances is used.
_QUANTILE = 2.5
# Smallest number of pairs of clusters for a limit. [1] Derived: with fewer, the limit is more than 5 times the variance.
_MIN_PAIRS = 16
# Smallest number of pairs of clusters for a limit that is compared with N. [1] Derived: for white noise alone the limit
# is then at most 1.36 times N.
_MIN_PAIRS_HIDDEN = 64
# Number of parts of a record, the quietest of which is reported. [1] Judgement: a pause of an eighth of the record is
# useful.
_STRETCHES = 8
# Smallest part. [samples] Derived: 16 pairs of clusters of 32, see `_MIN_PAIRS`.
_MIN_STRETCH = 1024
# Longest record that is used. [samples] Judgement: limits the memory.
_LONGEST = 1 << 24
# Longest part of a record that is examined for bursts. [samples] Judgement: limits the time.
_LONGEST_LOOK = 1 << 21


_HIDDEN_PARTS: tuple[Part, ...] = (
    *("gauss_markov", "response", "warm_up", "alike_from", "alike_sigma", "second", "unclear", "discrepancy"),
    "covariance",
)
"""Fields that are removed from a fit if the noise is hidden: lines and resonances are then those of the vibration."""


def vibration_share(fitted: NoiseFit) -> float:
    """Share of lines and narrow resonances in the power of the record; the rest is random walk and quantization noise."""
    shaken = sum(line.amplitude.value**2 / 2 for line in fitted.sinusoid) + _power_of_resonances(fitted)
    walk = fitted.terms.get("random_walk")
    level = 0.0 if walk is None else walk.value or walk.upper_limit or 0.0
    rounding = fitted.model.get("quantization", 0.0) / fitted.tau0
    noise = level**2 / fitted.tau0 + 2 * rounding**2
    return shaken / (shaken + noise) if shaken > 0 else 0.0


def burst_share(x: Floats, tau0: float) -> float:
    """Share of intermittent motion in the power at the loudest times; 0 if there is none.

    People and vehicles move a sensor for a fraction of a second or longer. Differences of neighbouring clusters then have
    wider tails than those of neighbouring samples, which are mostly noise.
    """
    steps = np.abs(np.diff(x[: 2 * _MAX_BURST_BLOCKS]))
    step = float(np.min(steps, where=steps > 0, initial=math.inf))
    reference, largest, m = max(_loudness(x, 1, 0.0), 1.0), 1.0, _MIN_CLUSTER
    while len(x) // (2 * m) >= _BURST_BLOCKS and m * tau0 <= _LONGEST_BURST:
        largest = max(largest, _loudness(x, m, _MIN_CHANGE * step))
        m *= 2
    return 1 - reference / largest if largest > MAX_BURSTS * reference else 0.0


def _loudness(x: Floats, m: int, floor: float) -> float:
    """Compare the loudest differences of sums of `m` samples with the median.

    Returns the ratio of their powers, relative to normal noise; 1 if there are too few differences, or if the median is
    below `floor`.
    """
    count = len(x) // (2 * m)
    blocks = x[: count * 2 * m].reshape(count, 2, m)[:: max(1, count // _MAX_BURST_BLOCKS)]
    sums = functools.reduce(np.add, np.moveaxis(blocks, 2, 0)) if m < _SHORT_SUM else blocks.sum(axis=2)
    sizes = np.abs(sums[:, 1] - sums[:, 0])
    sizes = sizes[np.isfinite(sizes)]
    if len(sizes) < _BURST_BLOCKS:
        return 1.0
    median, loud = quantile(sizes, 0.5), quantile(sizes, _LOUD_SHARE)
    return (loud / median / _normal_loudness(_LOUD_SHARE)) ** 2 if median > max(floor, 0.0) else 1.0


@functools.cache
def _normal_loudness(share: float) -> float:
    """Ratio of the loudest absolute values to the median, for normal noise."""
    return float(normal_quantile((1 + share) / 2)) / float(normal_quantile(0.75))


def _samples(fitted: NoiseFit, stream: Stream, *, limit: int) -> Floats:
    return stream.samples.read(stream.channels.index(fitted.channel), 0, min(stream.grid.n, limit))


def _is_hidden(fitted: NoiseFit, stream: Stream) -> bool:
    """Whether all Allan deviations are well above the random walk of the model, or one is significantly below it."""
    walk = fitted.terms.get("random_walk")
    level = None if walk is None else walk.value or walk.upper_limit
    if walk is None or level is None:
        return False
    x = _samples(fitted, stream, limit=_LONGEST)

    def limit(pairs: int) -> float:
        return upper_limits(x, fitted.tau0, ("random_walk",), min_pairs=pairs)["random_walk"]

    return level < HIDDEN * limit(_MIN_PAIRS_HIDDEN) < math.inf or (walk.low or 0.0) > limit(_MIN_PAIRS)


def _power_of_resonances(fitted: NoiseFit) -> float:
    """Power of the narrow resonances after the filter. A peak of the filter amplifies a resonance within
    it.
    """
    narrow = [r for r in fitted.resonance if is_narrow(r.frequency.value, r.width.value)]
    series = fitted.response
    return sum(
        r.sigma.value**2 * (1.0 if series is None else series.power_of_series(r.frequency.value)) for r in narrow
    )


def is_narrow(frequency: float, width: float) -> bool:
    """Whether a resonance is a vibration, rather than a property of the sensor's noise or a drift.

    No fitted resonance is wider than a quarter of its centre; a resonance at that bound counts as a vibration.
    """
    widest = _NARROW * frequency
    return (width < widest or math.isclose(width, widest)) and frequency > _SLOWEST


def is_disturbed(fitted: NoiseFit, stream: Stream, *, unsteady: float) -> bool:
    """Whether vibration hides the noise. It does if it is intermittent, if it has most of the power, or if it has much of
    the power and the white noise of the model is not visible at any averaging time.

    A few steady lines hide nothing if the white level is visible.

    `unsteady` is the p-value of an equal white level in all eighths of the record.
    """
    if burst_share(_samples(fitted, stream, limit=_LONGEST_LOOK), fitted.tau0) > 0:
        return True
    share = vibration_share(fitted)
    if share <= MAX_HIDING_SHARE:
        return False
    if _is_hidden(fitted, stream):
        return True
    lines = sum(line.amplitude.value**2 / 2 for line in fitted.sinusoid)
    is_steady = len(fitted.sinusoid) <= _STEADY_LINES and _power_of_resonances(fitted) <= _STEADY_RESONANCES * lines
    return share > MAX_SHARE and not (is_steady and unsteady >= _UNSTEADY and fitted.verdict != "widened")


def vibration_power(fitted: NoiseFit, stream: Stream) -> VibrationPower:
    """Share of the vibration in the power, and the quietest stretch of the record with its limit, if that is smaller than
    the limit of the record.
    """
    x = _samples(fitted, stream, limit=_LONGEST)
    first, last, quietest = _quietest(x, fitted.tau0)
    whole = upper_limits(x, fitted.tau0, ("random_walk",))["random_walk"]
    return VibrationPower(
        lines=len(fitted.sinusoid),
        resonances=len(fitted.resonance),
        share=max(
            vibration_share(fitted),
            burst_share(x[:_LONGEST_LOOK], fitted.tau0),
        ),
        start=stream.grid.time(first),
        stop=stream.grid.time(last),
        quietest=quietest if 0 < quietest < whole else None,
    )


def hidden_by_vibration(fitted: NoiseFit, *, stream: Stream, unsteady: float) -> Adjustment | None:
    """Replace all terms by upper limits if vibration hides the noise; see `is_disturbed`."""
    if not is_disturbed(fitted, stream, unsteady=unsteady):
        return None
    return limits_alone(fitted, stream, cause="vibration", reason=vibration_power(fitted, stream))


def limits_alone(
    fitted: NoiseFit,
    stream: Stream,
    *,
    cause: Cause,
    reason: VibrationPower | CoarseCounts,
    without: Sequence[Part] = (),
) -> Adjustment:
    """Upper limits of all terms, for a record whose noise is hidden."""
    x = _samples(fitted, stream, limit=_LONGEST)
    limits = upper_limits(x, fitted.tau0, tuple(fitted.terms))
    finite = {name: limit for name, limit in limits.items() if math.isfinite(limit)}
    return Adjustment(
        cause=cause,
        findings=("disturbed",) if cause == "vibration" else ("coarse_resolution",),
        changes=tuple(Change.limiting(Parameter(name), term, finite.get(name)) for name, term in fitted.terms.items()),
        verdict="disturbed",
        without=(*_HIDDEN_PARTS, *without),
        reason=reason,
    )


def upper_limits(x: Floats, tau0: float, terms: Sequence[str], *, min_pairs: int | None = None) -> dict[str, float]:
    """Upper limit of each term from the Allan variances, which other terms and vibration only increase.

    A low-pass filter removes white and slow noise at short times, so their limits come from clusters of at least 32
    samples. `inf` if there are too few clusters.
    """
    limits = dict.fromkeys(terms, math.inf)
    for m, variance, pairs in octaves(x):
        if pairs < (_MIN_PAIRS if min_pairs is None else min_pairs):
            break
        # spread of χ² with 2/3 degrees of freedom per pair of clusters of white noise (Lesage and Audoin)
        spread = 2 / (9 * (2 * pairs / 3))
        high = variance / (1 - spread - _QUANTILE * math.sqrt(spread)) ** 3  # its lower quantile (Wilson and Hilferty)
        for name in terms:
            if m >= _MIN_SIZE or name == "quantization":
                unit = float(avar(name, 1.0, m=m, tau0=tau0)[0])
                limits[name] = min(limits[name], math.sqrt(high / unit))
    return limits


def _quietest(x: Floats, tau0: float) -> tuple[int, int, float]:
    """First sample, end, and upper limit of the random walk of the stretch where this limit is smallest."""
    count = max(min(_STRETCHES, len(x) // _MIN_STRETCH), 1)
    edges = np.linspace(0, len(x), count + 1).astype(int).tolist()
    stretches = [(upper_limits(x[a:b], tau0, ("random_walk",))["random_walk"], a, b) for a, b in pairwise(edges)]
    limit, first, last = min(stretches)
    return first, last, limit
