"""Bursts, excursions and steps of the mean of a channel, by windows of about a second."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from sigmatau.arrays import Floats, Ints, median, median_and_spread, runs
from sigmatau.frozen import frozen
from sigmatau.quality.facts import channel_fact
from sigmatau.quality.samples.common import present
from sigmatau.quality.samples.resolution import find_step
from sigmatau.record.streams import CHUNK, Stream

# Length of a window. [s] Judgement: people and vehicles move a sensor for a longer time.
WINDOW_LENGTH = 1.0
# Smallest number of samples in a window. [samples] Derived: its power has 10 degrees of freedom, see `_BURST_POWER`.
WINDOW = 16
# Smallest number of windows for a distribution. [1] Measured: false steps were counted for 24 windows and more, see
# `_STEP_SPREADS`.
MIN_WINDOWS = 24
# Distance of a burst from the usual cube root of the power of a window, in robust standard deviations; the root is
# Gaussian to a few per cent. [1] Literature: E. B. Wilson, M. M. Hilferty, PNAS 17 (1931); noise reaches 4.5 once in
# 10⁴ windows.
_BURST_SPREADS = 8.0
# Smallest power of a burst, over the usual power. [1] Derived: χ² with 10 degrees of freedom reaches 3.5 times its mean
# once in 10⁴ windows, including the spread of the MAD.
_BURST_POWER = 4.0
# Number of the largest changes in a window that are left out of its power. [samples] Derived: two spikes make four
# changes.
_PEAKS = 4
# Distance of a step from the usual difference of windows, in robust standard deviations; differences are Gaussian for
# each of the five terms. [1] Measured: one of n ≥ 24 differences exceeds 7·(1 + 12/n) in less than 10⁻⁵ of the records.
_STEP_SPREADS = 7.0
# Number of windows in the factor 1 + 12/n of the distance. [1] Measured: see `_STEP_SPREADS`.
FEW_WINDOWS = 12.0
# Such a distance across a gap, with one difference instead of the largest of n. [1] Measured: 4500 records of white
# noise, flicker noise and rate random walk, of 100 s to 2000 s with a gap of 2 s to 40 s, reach 3.9.
_GAP_SPREADS = 5.0
# Number of window lengths that are searched for excursions, each twice the previous one. [1] Judgement: longer
# excursions appear as two steps.
_EXCURSION_LENGTHS = 4
# Smallest share of the largest distance for a window in an excursion. [1] Derived: half of an excursion appears next to
# it with the opposite sign.
_PART_OF_FARTHEST = 0.6
# Number of windows on either side of a step that distinguish it from a line. [1] Judgement: two parameters are fitted
# to eight windows.
_MIN_ON_SIDE = 4
# Largest ratio of the length of a gap to the longest lag with a known distribution. [1] Judgement: the spread is
# extrapolated by √6 at most.
_LONGER = 6
# Largest number of runs of missing windows whose two sides are compared. [1] Judgement: limits the time of a record
# with many gaps.
_MAX_GAPS = 16
# Number of candidates examined at each length of windows. [1] Judgement: limits the time of a record with many steps.
_MAX_STEPS = 256
# Change of a difference of two means by rounding. [steps] Derived: each mean is shifted by half a step at most; the
# rest is a margin.
_ROUNDING = 1.5
# Longest pause within a burst. [s] Judgement: a sensor that is handled is not at rest between two pushes.
_BURST_GAP = 5.0
# Smallest change between the medians before and after a step, over the step. [1] Judgement: more than the half that
# appears next to an excursion.
_LASTS = 0.6
# Number of half windows in these medians. [1] Judgement: a median of six tolerates two disturbed ones.
_HALF_WINDOWS = 6


@frozen(kw_only=False)
class Burst:
    """Stretch of one channel with motion."""

    channel: str
    start: int  # first sample; `stop` follows the last one
    stop: int
    # largest root mean square of the changes from sample to sample in a window, over the usual one; for an excursion,
    # its size in standard deviations of the noise
    ratio: float
    away: float = 0.0  # change of the mean of a window; 0 if the sample changes show the motion [unit of the stream]


@frozen(kw_only=False)
class MeanStep:
    """A lasting step of the mean."""

    sample: int  # first sample after the step, to within half a window
    size: float  # new mean minus old mean [unit of the stream]
    window: int  # samples in the windows that show the step best
    ratio: float  # size over the standard deviation of the difference of such windows
    half_width: int  # half width of the interval in which the mean changes [samples]
    gradual: bool  # whether a line fits better than two constant parts, as in a warm-up


@frozen(kw_only=False, eq=False)
class Windows:
    """A channel summarised by windows of about a second."""

    channel: str
    length: int  # samples in a window
    first: float  # the first sample that is present [unit of the stream]
    mean: Floats  # mean minus `first`; NaN where half of a window is missing [unit of the stream]
    power: Floats  # mean square of the changes from sample to sample [unit² of the stream]


@channel_fact
def summarise_windows(stream: Stream, channel: str) -> Windows:
    """Summarise a channel by windows of 1 s, or of 16 samples if that is longer."""
    w = max(round(WINDOW_LENGTH / stream.grid.tau0), WINDOW)
    c, n = stream.channels.index(channel), stream.grid.n // w * w
    many = max(CHUNK // w, 1) * w
    means, powers = [np.zeros(0)], [np.zeros(0)]
    first = math.nan
    for start in range(0, n, many):
        x = stream.samples.read(c, start, min(start + many, n)).reshape(-1, w)
        if math.isnan(first):
            first = float(next(iter(present(x.ravel())), math.nan))
        x = x - first  # a large mean would reduce the precision
        changes = np.diff(x, axis=1)
        power = np.einsum("ij,ij->i", changes, changes) / (w - 1)
        mean = np.einsum("ij->i", x) / w
        torn = np.flatnonzero(~np.isfinite(mean))
        if len(torn):
            mean[torn], count = _mean_of_present(x[torn])
            power[torn], changes_present = _mean_of_present(changes[torn] ** 2)
            sparse = torn[(count < w / 2) | (changes_present == 0)]
            mean[sparse] = power[sparse] = np.nan
        means.append(mean)
        powers.append(power)
    return Windows(channel, w, first, np.concatenate(means), np.concatenate(powers))


def _mean_of_present(x: Floats) -> tuple[Floats, Ints]:
    """Mean of the samples that are present in each row, and their number."""
    is_present = ~np.isnan(x)
    count = is_present.sum(axis=1)
    return np.where(is_present, x, 0.0).sum(axis=1) / np.maximum(count, 1), count


def _join_pairs(means: Floats) -> Floats:
    """Means of windows of twice the length."""
    even = len(means) // 2 * 2
    return np.asarray((means[0:even:2] + means[1:even:2]) / 2)


def _without_peaks(values: Floats) -> Floats:
    """Sorted values without the largest four, which may come from one or two spikes."""
    return values[np.argsort(np.abs(values))][:-_PEAKS]


def bursts(stream: Stream, windows: Windows) -> list[Burst]:
    """Find stretches in which the samples of a channel change far more than usual, in order of time; none if there are
    few windows.

    The mean square of the changes from sample to sample in each window is compared with its distribution over the record:
    its cube root in robust standard deviations, and the mean square as a ratio to the usual one. One or two spikes are
    not a burst.
    """
    channel, power, w = windows.channel, windows.power, windows.length
    if np.count_nonzero(np.isfinite(power)) < MIN_WINDOWS:
        return []
    root = np.cbrt(power)
    centre, spread = median_and_spread(present(root))
    usual = centre**3
    limit = max(centre + _BURST_SPREADS * spread, np.cbrt(_BURST_POWER * usual))
    if not np.any(root > limit):
        return []
    step, c = find_step(stream, channel), stream.channels.index(channel)
    # Values that alternate between two neighbouring steps change by one step at each sample.
    loud = np.flatnonzero(power > max(limit**3, _BURST_POWER * step**2))
    changes = (_without_peaks(present(np.diff(stream.samples.read(c, i * w, (i + 1) * w)))) for i in loud.tolist())
    loud = loud[[len(d) > 0 and float((d * d).mean()) > limit**3 for d in changes]]
    if len(loud) == 0:
        return []
    apart = max(round(_BURST_GAP / (w * stream.grid.tau0)), 1)
    groups = np.split(loud, np.flatnonzero(np.diff(loud) > apart) + 1)
    floor = max(usual, step**2 / 12)
    ratios = [math.sqrt(float(np.max(power[g])) / floor) if floor > 0 else math.inf for g in groups]
    return [Burst(channel, int(g[0]) * w, (int(g[-1]) + 1) * w, r) for g, r in zip(groups, ratios, strict=True)]


def mean_steps(stream: Stream, windows: Windows) -> list[MeanStep]:
    """Find lasting steps of the mean of a channel that its noise does not explain, in order of time; none for fewer than
    48 windows.

    Differences of the means of neighbouring windows of 2 s, 4 s, 8 s, … are Gaussian with the variance 2σ²(τ), for a pure
    rate random walk and for flicker noise as for white noise. At a step, one difference is far beyond all others at the
    same τ; if several windows show the step, the clearest counts. The windows before and after missing samples are
    compared with windows at the same distance, because slow noise continues in a gap.
    """
    channel, mean, w = windows.channel, windows.mean, windows.length
    candidates: list[MeanStep] = []
    half, shortest = mean, w  # means of half windows: a change within a window is divided 3 to 1 at worst
    while len(half) >= 2 * MIN_WINDOWS:
        window = (half[:-1] + half[1:]) / 2
        differences = window[2:] - window[:-2]
        judged = _departures(stream, channel, differences, _STEP_SPREADS)
        if judged is None:
            break
        distances, spread, limit = judged
        farthest = np.argsort(-distances)[:_MAX_STEPS]  # NaN last
        for i in farthest[distances[farthest] > limit].tolist():
            size = _change(half, i + 2, i + 2)
            if size * differences[i] > 0 and abs(size) > _LASTS * abs(differences[i]):
                ratio = float(distances[i]) / spread if spread > 0 else math.inf
                place = _where(mean, (i + 2) * w // shortest, w // shortest)
                gradual = _gradual(mean, place, 2 * w // shortest)
                half_width = 2 * w if gradual else max(2 * shortest, w // 8)
                candidates.append(MeanStep(place * shortest, size, 2 * w, ratio, half_width, gradual))
        candidates += _steps_across_gaps(stream, channel, half, w)
        half, w = _join_pairs(half), 2 * w
    steps: list[MeanStep] = []
    for step in sorted(candidates, key=lambda step: -step.ratio):
        if all(abs(step.sample - stronger.sample) > 3 * max(step.window, stronger.window) for stronger in steps):
            steps.append(step)
    return sorted(steps, key=lambda step: step.sample)


def _change(half: Floats, a: int, b: int) -> float:
    """Change of the median from the six half windows before `a` to the six from `b` on; NaN if one side has only one."""
    before = present(half[max(a - _HALF_WINDOWS, 0) : a])
    after = present(half[b : b + _HALF_WINDOWS])
    return median(after) - median(before) if min(len(before), len(after)) > 1 else math.nan


def _steps_across_gaps(stream: Stream, channel: str, half: Floats, w: int) -> Iterator[MeanStep]:
    """Find steps of the mean between the two sides of missing half windows of w samples.

    If a gap is too long for a distribution of differences at this distance, the longest lag with a distribution is used: the
    spread of slow noise grows at most with the root of the lag, as for a rate random walk.
    """
    gaps = sorted(runs(np.isnan(half)), key=lambda gap: gap[0] - gap[1])
    window = (half[:-1] + half[1:]) / 2
    for a, b in gaps[:_MAX_GAPS]:
        lag = b - a + 2
        if a < 2 or b + 2 > len(half):
            continue
        judged_lag = min(lag, int(np.count_nonzero(np.isfinite(window))) // (MIN_WINDOWS + 2))
        if judged_lag < 2 or lag > _LONGER * judged_lag:
            continue  # the gap is too long for a distribution from other differences
        usual = window[judged_lag:] - window[:-judged_lag]
        judged = _departures(stream, channel, usual, _GAP_SPREADS, apart=judged_lag)
        if judged is None:
            continue
        _, spread, limit = judged
        growth = lag / judged_lag
        distance = abs(float(window[b]) - float(window[a - 2]) - median(present(usual)) * growth)
        size = _change(half, a, b)
        if distance > limit * math.sqrt(growth) and abs(size) > _LASTS * distance:
            ratio = distance / spread / math.sqrt(growth) if spread > 0 else math.inf
            gradual = _gradual(half, (a + b) // 2, (b - a) // 2 + 2 * _HALF_WINDOWS)
            yield MeanStep((a + b) * w // 2, size, 2 * w, ratio, (b - a) * w // 2 + w, gradual)


def _departures(
    stream: Stream, channel: str, x: Floats, spreads: float, *, apart: int = 1
) -> tuple[Floats, float, float] | None:
    """Compute the distances of differences from their median, their spread, and the distance that noise and rounding may
    reach.

    One in `apart` differences is independent.
    """
    finite = np.isfinite(x)
    independent = int(np.count_nonzero(finite)) // apart
    if independent < MIN_WINDOWS:
        return None
    centre, spread = median_and_spread(x[finite])
    distances = np.abs(x - centre)
    limit = spreads * (1 + FEW_WINDOWS / independent) * spread
    if np.any(distances > limit):
        limit = max(limit, _ROUNDING * find_step(stream, channel))
    return distances, spread, limit


def _gradual(mean: Floats, place: int, half_width: int) -> bool:
    """Whether a line fits better at a place than two constant parts."""
    start = max(place - half_width, 0)
    x, k = mean[start : place + half_width], place - start
    is_present = np.isfinite(x)
    if min(np.count_nonzero(is_present[:k]), np.count_nonzero(is_present[k:])) < _MIN_ON_SIDE:
        return False
    levels = np.where(np.arange(len(x)) < k, present(x[:k]).mean(), present(x[k:]).mean())
    t, y = np.flatnonzero(is_present).astype(float), x[is_present]
    t, y = t - t.mean(), y - y.mean()
    line = np.sum(t * y) / np.sum(t * t) * t
    return float(np.sum((y - line) ** 2)) < float(np.sum((x - levels)[is_present] ** 2))


def excursions(stream: Stream, windows: Windows, steps: Sequence[MeanStep] = ()) -> list[Burst]:
    """Find stretches in which a channel leaves its mean and returns, too slowly to show in the changes from sample to
    sample, such as a rotation or a push.

    The mean of each window of 1 s, 2 s, 4 s and 8 s, minus the mean of the windows beyond its neighbours, is Gaussian for
    each of the five terms, like the differences of `mean_steps`, and has the same threshold. Excursions next to one of
    the `steps` of the channel are ignored.
    """
    channel, mean, w = windows.channel, windows.mean, windows.length
    c = stream.channels.index(channel)
    candidates: list[Burst] = []
    for _ in range(_EXCURSION_LENGTHS):
        if len(mean) < 2 * MIN_WINDOWS:
            break
        away = mean[2:-2] - (mean[:-4] + mean[4:]) / 2
        judged = _departures(stream, channel, away, _STEP_SPREADS)
        if judged is None:
            break
        distances, spread, limit = judged
        # Half of an excursion also appears next to it, with the opposite sign.
        places = np.flatnonzero(distances > max(limit, _PART_OF_FARTHEST * float(np.nanmax(distances))))
        for group in np.split(places, np.flatnonzero(np.diff(places) > 1) + 1) if len(places) else ():
            k = int(group[np.argmax(distances[group])])
            farthest = float(distances[k])
            if any(abs(step.sample - k * w) <= step.half_width + 6 * w + step.window for step in steps):
                continue
            base = windows.first + float((mean[k] + mean[k + 4]) / 2)
            inner = _without_peaks(present(stream.samples.read(c, (k + 2) * w, (k + 3) * w)) - base)
            if len(inner) and abs(float(inner.mean())) > _LASTS * farthest:
                ratio = farthest / spread if spread > 0 else math.inf
                candidates.append(Burst(channel, (int(group[0]) + 2) * w, (int(group[-1]) + 3) * w, ratio, farthest))
        mean, w = _join_pairs(mean), 2 * w
    separate: list[Burst] = []
    for burst in sorted(candidates, key=lambda burst: -burst.ratio):
        apart = 4 * (burst.stop - burst.start)
        if all(burst.start > stronger.stop + apart or stronger.start > burst.stop + apart for stronger in separate):
            separate.append(burst)
    return sorted(separate, key=lambda burst: burst.start)


def _where(mean: Floats, about: int, half_width: int) -> int:
    """Locate the window of a step by a least-squares fit of two constant parts."""
    start = max(about - 2 * half_width, 0)
    x = mean[start : about + 2 * half_width]
    x = np.where(np.isfinite(x), x, median(present(x)))
    k = np.arange(1, len(x))
    sums = np.cumsum(x)
    explained = (sums[:-1] - sums[-1] * k / len(x)) ** 2 / (k * (len(x) - k))
    return start + 1 + int(np.argmax(explained))
