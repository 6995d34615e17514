"""Resolution: the step of the numbers, compared with the noise."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from sigmatau.arrays import Floats, distinct, median
from sigmatau.findings.finding import Finding, Severity
from sigmatau.findings.values import CoarseResolution
from sigmatau.frozen import frozen
from sigmatau.quality.facts import channel_fact
from sigmatau.quality.samples.common import block_rms, largest_rounding, present, take_samples, white_level
from sigmatau.quality.samples.counts import rounding_by_sums, steps_per_sample
from sigmatau.record.streams import Stream

# Number of samples in which the step is searched. [samples] Judgement: enough for a channel with 10⁵ steps in a
# standard deviation.
_EXAMINED = 16384
# Largest distance of a value from a multiple of the common step. [steps] Derived: by chance a value is within it with
# probability 0.3, and 30 values with 0.3³⁰.
_MAX_OFF = 0.15
# Smallest number of values with a common step. [1] Derived: see `_MAX_OFF`.
_MIN_VALUES = 30
# Factor of the random walk above which rounding is reported. [1] Judgement: a tenth of the usual interval.
_REPORT_FACTOR = 1.005
# Factor of the random walk above which the finding is a warning. [1] Judgement: the usual interval is 5 %.
_WARN_FACTOR = 1.05
# Observed noise below which rounding errors are no longer white or independent of the signal. [steps] Study:
# docs/study/coarse.md; the noise that they add depends on the position of the mean between two steps: at 0.3 the
# standard deviation of the excess is as large as its mean. Rounded noise of 0.5 steps shows 0.577 at any mean; noise of
# 0.2 steps shows any value up to 0.5.
_MIN_NOISE_STEPS = 0.54
# Largest noise for which rounding is reported. [steps] Derived: rounding then adds 0.5 % to N at most.
_MAX_NOISE_STEPS = 3.0
# Factor of the random walk above which the contribution of rounding is unknown. [1] Judgement: three quarters of the
# power would be subtracted.
_MAX_FACTOR = 2.0
# Variance of sums of increments above which the rounding of the angle is white from sum to sum. [steps²] Derived: 0.25
# of it is due to rounding, and the rest to noise of half a step, which leaves exp(-2π²/4) = 0.7 % of the correlation of
# the rounding; docs/study/disturbed.md.
_WHITE_FROM = 0.5
# Number of sums whose variance has an error of a quarter. [1] Derived: √(2/32).
_MIN_SUMS = 32
# Smallest number of sums of coarse increments whose likelihood is used. [1] Study: docs/study/disturbed.md; in 167 of
# 170 simulated records the interval of the random walk contained the truth.
MIN_SUMS = 256
# Smallest step that is tested, over the usual change. [1] Judgement: smaller ones are printed decimals.
_SMALLEST_STEP = 1 / 6
# Largest step that is tested, over the usual change. [1] Judgement: with a larger one most changes are zero.
_LARGEST_STEP = 2.0
# Number of steps that are tested. [1] Derived: successive steps differ by 0.6 %, which is a tenth of a step after
# sixteen steps.
_STEPS_TRIED = 400
# Number of changes that are compared with a step. [samples] Judgement: limits the time.
_CHANGES = 4096
# Numbers of changes, and mean cosine above which a step is tested with more changes. [1] Derived: for changes that are
# whole steps to within a tenth the mean cosine is 0.8; few changes exclude most steps, at 0.8 minus four standard
# errors.
_STAGES = ((64, 0.4), (256, 0.6), (4096, 0.8))
# Smallest ratio of two steps that count as the same step. [1] Judgement: half a step is another step.
_SAME_STEP = 0.8
# Distance of two samples that are compared, longer than any hold. [samples] Judgement: a prime is not a multiple of the
# period of a counter.
_LAG = 251
# Number of blocks for the median. [1] Judgement: fewer than half of them are stuck or lost.
_BLOCKS = 32
# Number of samples used to estimate the white level. [samples] Judgement: its error is then 0.3 %, which suffices for
# `_REPORT_FACTOR`.
_LEVEL_FROM = 1 << 18


@frozen
class Resolution:
    """Step of the numbers of a channel, and its noise."""

    channel: str
    step: float  # common step of all rates [unit of the stream]
    # standard deviation of the white part of a sample, including its rounding: root mean square of the differences of
    # neighbours over √2 [unit of the stream]
    noise: float
    unit: str

    @property
    def ratio(self) -> float:
        """Noise as a multiple of the step."""
        return self.noise / self.step


def common_step(x: Floats, *, rounding: float = 0.0) -> float | None:
    """Find the step q of numbers a + k·q with integers k, each with an error of a fraction of q; None without a step.

    Offsets and scales do not matter, nor does rounding after scaling (printed decimals, float32): the step is that of the
    counts, by regression of the values on their integers. Values closer than `rounding` count as equal.
    """
    x = present(x)
    values = np.sort(x)
    if len(values) < 2:
        return None
    gaps = np.diff(values)
    rounded = max(rounding, 8 * np.finfo(float).eps * float(np.abs(values[[0, -1]]).max()))
    gaps = gaps[gaps > rounded]
    if len(gaps) == 0 or (len(gaps) < _MIN_VALUES and 2 * (len(gaps) + 1) > len(x)):
        return None
    # The smallest gap is the step to within rounding. Each wider set of gaps gives the step more exactly.
    step = float(gaps.min())
    for widest in (1.5, 6.5, 50.5, math.inf):
        narrow = gaps[gaps < widest * step]
        step = float(narrow.sum() / np.rint(narrow / step).sum())
    counts = np.concatenate(([0.0], np.cumsum(np.rint(gaps / step))))
    levels = np.concatenate(([0.0], np.cumsum(gaps)))
    centred = counts - counts.mean()
    # BLAS with its threads would take ten times as long for so little data.
    slope = float(np.einsum("i,i", centred, levels) / np.einsum("i,i", centred, centred))
    off = levels - levels.mean() - slope * centred
    return slope if np.abs(off).max() <= _MAX_OFF * slope else None


def white_sum(increments: Floats) -> int | None:
    """Number of increments of a rounded angle, in steps, whose sums have white rounding: a power of two.

    If an angle moves by much less than a step between samples, its rounding is nearly the same in both, and no term has
    the resulting spectrum. None if there are too few sums of sufficient length.
    """
    previous, size = False, 1
    while len(increments) // size >= _MIN_SUMS:
        whole = len(increments) // size * size
        sums = np.diff(increments[:whole].reshape(-1, size).sum(axis=1))
        # A steady rate of half a step per sum has the same variance; sums of twice the size then have no variance.
        white = float(np.nanmean(sums * sums)) / 2 >= _WHITE_FROM if np.isfinite(sums).any() else False
        if white and previous:
            return size // 2
        previous, size = white, 2 * size
    return None


@channel_fact
def resolution(stream: Stream, channel: str) -> Resolution | None:
    """Step and noise of a channel; None if its values have no detectable common step."""
    x = take_samples(stream, channel, count=_EXAMINED)
    # Rates may be differences of angles, made by another program; their rounding errors are not steps.
    rounding = max(_rounding(stream, channel), largest_rounding(x, stream.grid.n))
    step = common_step(x, rounding=rounding) or step_of_changes(np.diff(x))
    if not step:
        return None
    differences = np.diff(x)
    noise = block_rms(differences)
    if noise == 0.0:  # most blocks contain no change
        differences = present(differences)
        noise = float(np.sqrt(np.mean(differences * differences))) if len(differences) else 0.0
    return Resolution(channel=channel, step=step, noise=noise / math.sqrt(2), unit=stream.unit)


def step_of_changes(changes: Floats) -> float:
    """Step of numbers whose common step is hidden by a slow compensation or by printed decimals; 0 if there is none.

    The largest q for which the changes from sample to sample are integer multiples to about a tenth: Σ cos(2π·d/q) over the
    changes d is nearly their number.
    """
    size = np.abs(present(changes))[:_CHANGES]
    size = size[size > 0]
    if len(size) < _MIN_VALUES:
        return 0.0
    usual = median(size)
    size = size[size > usual / 4] / usual  # smaller changes are the compensation
    steps = np.geomspace(_LARGEST_STEP, _SMALLEST_STEP, _STEPS_TRIED)
    whole = steps
    for count, mean_cosine in _STAGES:
        whole = np.cos(np.multiply.outer(2 * np.pi / steps, size[:count])).mean(axis=1)
        steps, whole = steps[whole > mean_cosine], whole[whole > mean_cosine]
        if len(steps) == 0:
            return 0.0
    alike = steps > steps[0] * _SAME_STEP
    return usual * float(steps[alike][np.argmax(whole[alike])])


@channel_fact
def equal_by_chance(stream: Stream, channel: str) -> float:
    """Share of the samples that equal a distant sample, as in coarse noise without a fault.

    It is the median over blocks, which ignores a stuck or lost part of the record.
    """
    x = stream.column(channel)
    lag = min(_LAG, len(x) // 4)
    same = x[lag:] == x[:-lag]
    return median(np.array([block.mean() for block in np.array_split(same, min(_BLOCKS, len(same)))]))


def usual_value(stream: Stream, channel: str) -> float:
    """Largest share of the samples with the same value, from the share of equal pairs: Σp² of normal noise is p/√2."""
    equal = equal_by_chance(stream, channel)
    return min(math.sqrt(2) * equal, math.sqrt(equal))


def find_step(stream: Stream, channel: str) -> float:
    """Step of a channel's numbers; 0 if it has none."""
    resolved = resolution(stream, channel)
    return 0.0 if resolved is None else resolved.step


def hides_noise(stream: Stream) -> bool:
    """Whether the step of a channel is so coarse that the noise of the numbers is mostly that of rounding."""
    resolved = (resolution(stream, channel) for channel in stream.channels)
    return any(steps is not None and steps.ratio < _MIN_NOISE_STEPS for steps in resolved)


def rounded(finding: Finding) -> bool:
    """Whether the steps of rates may show in the intervals of the coefficients."""
    return isinstance(finding.details, CoarseResolution) and finding.details.rounding != "quantization"


def coarse_resolution(stream: Stream) -> list[Finding]:
    """Report channels whose step is so coarse compared with their noise that rounding affects a coefficient; one finding
    each.

    Rounding of a rate by q adds q²/12 to the variance of each sample, N_add² = q²·τ₀/12: white noise. Rounding of an
    angle is quantization noise, also in a log of rates: see `sigmatau.quality.samples.counts`. For noise below half a
    step, the contribution of the rounding of a rate is unknown.
    """
    findings = (_coarse(stream, channel) for channel in stream.channels)
    return [finding for finding in findings if finding is not None]


def _coarse(stream: Stream, channel: str) -> Finding | None:
    resolved = resolution(stream, channel)
    if resolved is None or resolved.ratio > _MAX_NOISE_STEPS:
        return None
    sample = present(take_samples(stream, channel, count=_EXAMINED))
    if 2 * len(distinct(np.rint((sample - sample[0]) / resolved.step))) > len(sample):
        return None  # a line without noise has a step too, but no repeated value
    tau0, step = stream.grid.tau0, resolved.step
    details = CoarseResolution(step=step, noise=resolved.noise, unit=resolved.unit, rounding="unknown", added=None)
    severity: Severity = "warning"
    factors: tuple[tuple[str, float], ...] = ()
    if _counted(stream, channel, step):
        samples = stream.column(channel) / step
        summed, passing = white_sum(samples), abs(steps_per_sample(samples)) / tau0
        needed = None if summed is None else MIN_SUMS * summed
        enough = needed is not None and stream.grid.n >= needed
        severity = "info" if enough else "warning"
        details = replace(
            details,
            rounding="quantization",
            added=step * tau0 / math.sqrt(12),
            summed=summed,
            needed=None if enough or needed is None else needed * tau0,
            passing=passing,
        )
    else:
        square = step**2 * tau0 / 12
        level, _ = white_level(take_samples(stream, channel, count=_LEVEL_FROM), tau0)
        factor = math.sqrt(level / (level - square)) if level > square else math.inf
        if resolved.ratio >= _MIN_NOISE_STEPS and factor <= _MAX_FACTOR:
            if factor < _REPORT_FACTOR:
                return None
            details = replace(details, rounding="white", added=math.sqrt(square))
            severity = "warning" if factor > _WARN_FACTOR else "info"
            factors = (("random_walk", factor),)
    channels, size = (channel,), resolved.ratio
    return Finding(details=details, severity=severity, channels=channels, size=size, unit="steps", factors=factors)


def _counted(stream: Stream, channel: str, step: float) -> bool:
    """Whether the angle was rounded, from sums of samples; if they do not decide it, from whether the log has rates."""
    by_sums = rounding_by_sums(stream.column(channel) / step)
    if by_sums is not None:
        return by_sums == "of_sums"
    return stream.samples.transforms[stream.channels.index(channel)].kind != "rate"


def _rounding(stream: Stream, channel: str) -> float:
    """Largest rounding error of the raw numbers by their type. [unit of the stream]"""
    k = stream.channels.index(channel)
    raw, t = stream.samples.raw[k], stream.samples.transforms[k]
    if raw.dtype.kind != "f" or len(raw) == 0:
        return 0.0
    step = max(len(raw) // 4096, 1)
    with np.errstate(invalid="ignore"):  # a damaged number may be a signalling NaN
        some = np.asarray(raw[::step], dtype=float)
    if stream.mask is not None:  # excluded samples may have any value
        gone = stream.mask[::step, k]
        some = some[: len(gone)][~gone]
    with np.errstate(invalid="ignore"):
        largest = float(np.nanmax(np.abs(some), initial=0.0))
    if not math.isfinite(largest):
        return 0.0
    # One unit in the last place may be the step of a log; its rounding is half of that.
    epsilon = float(np.finfo(raw.dtype).eps) if raw.dtype.itemsize < 8 else 8 * float(np.finfo(float).eps)
    factor = abs(t.scale * t.factor) / (1.0 if t.kind == "rate" else stream.grid.tau0)
    return 0.4 * epsilon * largest * factor
