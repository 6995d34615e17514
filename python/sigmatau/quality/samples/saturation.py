"""Saturation: a channel that repeatedly reaches an end of its range."""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import cast

import numpy as np

from sigmatau.arrays import Floats, Ints, distinct, median
from sigmatau.findings.finding import Finding
from sigmatau.findings.values import Saturation
from sigmatau.quality.samples.common import block_rms, growing_step, merged_axes, present, spans_of_runs
from sigmatau.quality.samples.masking import MaskedFinding
from sigmatau.quality.samples.repeated_samples import runs_of_places
from sigmatau.quality.samples.resolution import Resolution, resolution
from sigmatau.quality.samples.stuck_samples import stuck_runs
from sigmatau.record.streams import Stream

_NORMAL = NormalDist()


# Number of outermost values that are compared. [1] Derived: in the tail of any noise around a slowly changing mean, an
# outer value is rarer than the next inner one. Of T visits to these values, at most T/levels are to the outermost one.
_LEVELS = 4
# Probability that noise visits an end as often as in a reported record. [1] Derived: P(c of T) ≤ exp(−T·KL(c/T, 1/4)),
# Chernoff; the probability is a judgement.
_FALSE_ALARM = 1e-8
# Noise above which a channel has a tail. [steps] Derived: all values of coarser channels are extremes.
_MIN_NOISE_STEPS = 0.5
# Distance of the ends beyond which no pulse of a counter is divided between neighbours. [steps] Judgement: pulses of up
# to 16 counts in each direction need 32.
_PULSE_STEPS = 40.0
# Number of increments in the sums that identify a rounded angle. [samples] Judgement: the rounding of an angle affects
# one of eight.
_SUMMED = 8
# Power of such sums, over that of independent increments, below which the samples are the changes of a rounded angle.
# [1] Derived: white noise has 1, rounding alone 1/8.
_MIN_OF_SUMS = 0.5
# Smallest number of clipped samples in each tenth of the record, over the mean, if they are spread over the record. [1]
# Judgement: slow noise moves the mean.
_MIN_PART_OF_MEAN = 0.3
# Largest share of clipped samples that are spread over the record. [1] Judgement: with more, too little noise is left
# to judge.
_MAX_SHARE = 0.9


def saturation(stream: Stream) -> list[MaskedFinding]:
    """Report channels that are at their largest or smallest value more often than the tail of noise. At most one finding
    per end.

    Stretches at an end of the range can be left out. If noise touches an end throughout the record, leaving out would remove
    its tail; `factors` then contains the effect of clipping on white noise.
    """
    spread, stretches = list[tuple[float, Finding]](), list[tuple[float, Finding]]()
    mask = np.zeros((stream.grid.n, len(stream.channels)), dtype=bool)
    for k, channel in enumerate(stream.channels):
        x = stream.column(channel)
        low, high = float(np.fmin.reduce(x)), float(np.fmax.reduce(x))
        if not low < high:
            continue
        ends = [np.flatnonzero(x == low), np.flatnonzero(x == high)]
        if max(map(len, ends)) < _LEVELS or growing_step(x) > 0:
            continue
        resolved = resolution(stream, channel)
        step = 0.0 if resolved is None else resolved.step
        # With few values, and few visible noise changes, the outermost value is not an end of a range.
        judged = resolved is None or (
            resolved.ratio >= _MIN_NOISE_STEPS
            and high - low >= _LEVELS * step
            and not (high - low < _PULSE_STEPS * step and _is_rounded_angle(x))
        )
        runs, lengths = stuck_runs(stream, channel)
        clipped = []
        for end, places in ((low, ends[0]), (high, ends[1])):
            often = judged and _too_often(x, end, step)
            clipped.append(places if often or np.any(x[runs] == end) else places[:0])
        if any(map(len, clipped)):
            longest = int(lengths.max(initial=0)) * stream.grid.tau0
            finding = _finding(stream, channel, x, clipped, (low, high), resolved, longest)
            if cast("Saturation", finding.details).spread:
                spread.append((max((factor for _, factor in finding.factors), default=0.0), finding))
            else:
                stretches.append((finding.size or 0.0, finding))
                mask[np.concatenate(clipped), k] = True
    return [
        *((finding, None) for finding in merged_axes(spread)),
        *((finding, mask) for finding in merged_axes(stretches)),
    ]


def _too_often(x: Floats, end: float, step: float) -> bool:
    values = distinct(present(x))
    edges = np.flatnonzero(np.diff(values) > step / 2)  # closer values differ by rounding
    firsts, lasts = values[np.append(0, edges + 1)], values[np.append(edges, -1)]
    tail = slice(None, -_LEVELS - 1, -1) if end == values[-1] else slice(_LEVELS)
    outer = tuple(zip(firsts[tail], lasts[tail], strict=True))
    visits = [_visits(np.flatnonzero((x >= first) & (x <= last))) for first, last in outer]
    samples = [int(np.count_nonzero((x >= first) & (x <= last))) for first, last in outer]
    total = sum(visits)
    # A long stay counts as one visit. But if other values last as long, as between the pulses of a counter, all samples
    # count.
    part = min(visits[0] / total, samples[0] / sum(samples))
    if part <= 1 / _LEVELS:
        return False
    distance = part * math.log(part * _LEVELS)
    if part < 1:
        distance += (1 - part) * math.log((1 - part) / (1 - 1 / _LEVELS))
    return total * distance > -math.log(_FALSE_ALARM)


def _is_rounded_angle(x: Floats) -> bool:
    """Whether samples are mostly changes of a rounded angle, in which the neighbours of a large sample are smaller."""
    sums = present(x[: len(x) // _SUMMED * _SUMMED].reshape(-1, _SUMMED).sum(axis=1))
    independent = 2 * _SUMMED * block_rms(present(x) - median(present(x))) ** 2
    return block_rms(np.diff(sums)) ** 2 < _MIN_OF_SUMS * independent


def _visits(places: Ints) -> int:
    """Count runs of neighbouring samples. A long stay is one visit, so that reading a sensor twice does not count as two."""
    return int(np.count_nonzero(np.diff(places) > 1)) + 1 if len(places) else 0


def _clipped_sd(low: float, high: float, *, half: float = 0.0) -> float:
    """Standard deviation of clipped Gaussian noise, σ = 1. The shares `low` and `high` of the noise are beyond the ends
    and become the ends, moved outwards by `half` a step.
    """
    a = _NORMAL.inv_cdf(low) if low > 0 else -40.0
    b = -_NORMAL.inv_cdf(high) if high > 0 else 40.0
    pa, pb = _NORMAL.pdf(a), _NORMAL.pdf(b)
    lowest, highest = a - half, b + half
    mean = lowest * low + pa - pb + highest * high
    square = lowest**2 * low + (1 - low - high + a * pa - b * pb) + highest**2 * high
    return math.sqrt(max(square - mean * mean, 0.0))


def _finding(
    stream: Stream,
    channel: str,
    x: Floats,
    clipped: list[Ints],
    ends: tuple[float, float],
    resolved: Resolution | None,
    longest: float,
) -> Finding:
    n = int(np.count_nonzero(np.isfinite(x)))
    low, high = (len(places) / n for places in clipped)
    places = np.sort(np.concatenate(clipped))
    share = len(places) / n
    tenths = np.bincount(places * 10 // len(x), minlength=10)
    spread = bool(np.all(tenths > _MIN_PART_OF_MEAN * tenths.mean())) and share < _MAX_SHARE
    factors: tuple[tuple[str, float], ...] = ()
    if spread:
        factor = 1.0
        for _ in range(3 if resolved else 1):  # the step is known as a fraction of the clipped noise
            factor = _clipped_sd(low, high, half=factor / resolved.ratio / 2 if resolved else 0.0)
        factors = (("random_walk", factor),)
    details = Saturation(
        strongest=channel,
        samples=len(places),
        share=share,
        low=ends[0] if len(clipped[0]) else None,
        high=ends[1] if len(clipped[1]) else None,
        unit=stream.unit,
        start=stream.grid.time(int(places[0])),
        longest=longest,
        spread=spread,
    )
    spans, more_spans = spans_of_runs(stream, *runs_of_places(places))
    return Finding(
        details=details, severity="warning", channels=(channel,), spans=spans, more_spans=more_spans, size=share,
        factors=factors,
    )  # fmt: skip
