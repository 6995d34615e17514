"""Runs of equal samples that noise does not explain: a stuck sensor, or zeros of a dropout."""

from __future__ import annotations

import math
from statistics import NormalDist

import numpy as np

from sigmatau.arrays import Bools, Floats, Runs, column_counts, distinct
from sigmatau.findings.finding import Finding
from sigmatau.findings.values import Dropout, StuckSamples
from sigmatau.quality.facts import channel_fact
from sigmatau.quality.samples.common import (
    FEW_STEPS,
    block_rms,
    growing_step,
    longest_of_tail,
    mask_of_runs,
    present,
    spans_of_runs,
)
from sigmatau.quality.samples.masking import MaskedFinding
from sigmatau.quality.samples.repeated_samples import repeats, runs_of_equal, runs_of_places
from sigmatau.quality.samples.resolution import resolution, usual_value
from sigmatau.record.streams import Stream

# Probability of a reported run in a record of noise only. [1] Judgement: one false alarm in 10⁴ channels.
_FALSE_ALARM = 1e-4
# Shortest run that is reported. [samples] Measured: logs of real sensors have triples without a fault.
_MIN_RUN = 5
# Observed noise above which runs are judged. [steps] Derived: rounded noise of 0.15 steps, which may stay at one
# value, shows 0 to 0.5 steps, depending on the position of its mean between two steps.
_MIN_NOISE_STEPS = 0.6
# Power of the second differences, over that of the first differences, below which noise is smooth. [1] Derived: a
# random walk has 2.
_SMOOTH = 1.0
# Smallest change next to a faulty run of smooth noise. [steps] Judgement: noise that stays at a value leaves it by a
# step or two.
_JUMP = 2.5
# Smallest such change, over the white part of the noise. [1] Judgement: see `_JUMP`.
_TIMES_NOISE = 1.0
# Smallest share of the visits to zero that are in runs. [1] Judgement: single samples of a sensor whose range ends at
# zero, or whose numbers are coarse, are zero too.
_MIN_SHARE_IN_RUNS = 0.95
# Number of samples that decide whether the noise is smooth. [samples] Judgement: a power then has an error of 1 %.
_EXAMINED = 1 << 14


@channel_fact
def stuck_runs(stream: Stream, channel: str) -> Runs:
    """Find runs of equal samples of a channel that are longer than the noise can explain; return first samples and lengths.

    A run is too long if n·p^length < 1e-4, where p is the largest probability that a sample of the white part of the
    noise falls into one step, the middle one. Noise after a low-pass filter stays at one value at its extremes; next to a
    faulty run it jumps. No run is reported if the numbers show less than 0.6 steps of noise: with the mean near the
    border of a step they show noise, but with the mean in the middle of a step the noise may stay at one value.
    """
    x = stream.column(channel)
    first, lengths = runs_of_equal(x, shortest=_MIN_RUN)
    if len(first) == 0 or int(lengths.max()) == len(present(x)) or growing_step(x) > 0:
        return first[:0], lengths[:0]
    resolved, usual = resolution(stream, channel), usual_value(stream, channel)

    def longest_by_chance(stay: float) -> float:
        return math.log(len(x) / _FALSE_ALARM) / -math.log(min(max(stay, 1e-12), 1 - 1e-12))

    def limit(times: float) -> float:
        stay = 0.0
        if resolved is not None:
            if resolved.ratio < _MIN_NOISE_STEPS:
                return math.inf
            # Rounding adds q²/12 to the visible noise; the differences of neighbours are 3/2 as large in quantization
            # noise as in white noise.
            variance = (resolved.noise**2 * times - resolved.step**2 / 12) / 1.5
            stay = 2 * NormalDist().cdf(resolved.step / (2 * math.sqrt(variance))) - 1
        longest = longest_by_chance(max(stay, usual))
        # Irregular repetition has runs of up to twice its mean, and rarely longer ones.
        return max(_MIN_RUN, longest) * (1 if times <= 1 else 2 * times)

    is_stuck = lengths > limit(1.0)
    if is_stuck.any():
        held = repeats(stream)
        if held is not None and channel in held.channels:
            is_stuck = lengths > limit(max(held.times, held.longest / 2))
    if is_stuck.any() and resolved is not None and resolved.ratio < FEW_STEPS:
        for value in distinct(x[first[is_stuck]]):  # value of a counter between its pulses
            runs, (_, visits) = x[first] == value, runs_of_places(np.flatnonzero(x == value))
            usual = int(visits.sum() - lengths[runs & is_stuck].sum()) / len(x)
            tails = (longest_of_tail(group, false_alarm=_FALSE_ALARM) for group in (visits, lengths[runs]))
            is_stuck[runs] &= lengths[runs] > max(longest_by_chance(usual), *tails)
    if is_stuck.any() and resolved is not None and _is_smooth(x):
        edges = np.concatenate(([np.nan], x, [np.nan]))
        changes = np.abs(np.stack([edges[first], edges[first + lengths + 1]]) - x[first])
        jumps = np.where(np.isnan(changes), math.inf, changes).max(axis=0)
        is_stuck &= jumps > max(_JUMP * resolved.step, _TIMES_NOISE * resolved.noise)
    return first[is_stuck], lengths[is_stuck]


def _is_smooth(x: Floats) -> bool:
    """Whether noise is smoother than a random walk."""
    changes = np.diff(present(x[:_EXAMINED]))
    return 0 < block_rms(np.diff(changes)) ** 2 < _SMOOTH * block_rms(changes) ** 2


def zero_rate(stream: Stream, channel: str) -> float | None:
    """Rate that corresponds to the number 0 in the log; None for accumulated values, whose rate is 0 while they are
    constant.
    """
    transform = stream.samples.transforms[stream.channels.index(channel)]
    if transform.kind == "accumulated":
        return None
    factor = transform.scale * transform.factor / (stream.grid.tau0 if transform.kind != "rate" else 1.0)
    return -transform.offset * factor if transform.offset else 0.0


def zero_runs(stream: Stream, channel: str) -> Runs:
    """Runs in which the log contains only the number 0; none if single samples are also 0 (coarse numbers, or a range
    that begins at 0).
    """
    first, lengths = stuck_runs(stream, channel)
    if len(first) == 0:
        return first, lengths
    x = stream.column(channel)
    zero = zero_rate(stream, channel)
    here = np.zeros(len(first), dtype=bool) if zero is None else x[first] == zero
    count = int(np.count_nonzero(here))
    if count:
        visits = int(np.count_nonzero(np.diff(np.flatnonzero(x == zero)) > 1)) + 1
        if visits - count > (1 - _MIN_SHARE_IN_RUNS) * visits:
            here[:] = False
    return first[here], lengths[here]


def stuck_samples(stream: Stream) -> list[MaskedFinding]:
    """Report runs of equal samples that are improbably long for the step and the noise of a channel. At most one finding.

    No finding for a channel that never changes, for runs at an end of the range (see `saturation`), or for runs of the
    number 0 (see `dropouts`).
    """
    masks = []
    for channel in stream.channels:
        x = stream.column(channel)
        first, lengths = stuck_runs(stream, channel)
        if len(first):
            zeros, _ = zero_runs(stream, channel)
            is_stuck = ~np.isin(x[first], (np.nanmin(x), np.nanmax(x))) & ~np.isin(first, zeros)
            first, lengths = first[is_stuck], lengths[is_stuck]
        masks.append(mask_of_runs(len(x), first, lengths))
    return held(StuckSamples, stream, np.stack(masks, axis=1))


def held(kind: type[Dropout | StuckSamples], stream: Stream, mask: Bools) -> list[MaskedFinding]:
    """Build one finding about the samples of a mask; none if it is empty."""
    if not mask.any():
        return []
    counts = column_counts(mask)
    strongest = int(np.argmax(counts))
    first, lengths = runs_of_places(np.flatnonzero(mask[:, strongest]))
    k = int(np.argmax(lengths))
    details = kind(
        samples=int(counts[strongest]),
        share=float(counts[strongest] / stream.grid.n),
        runs=len(first),
        start=stream.grid.time(int(first[k])),
        longest=int(lengths[k]) * stream.grid.tau0,
    )
    channels = tuple(channel for channel, count in zip(stream.channels, counts, strict=True) if count)
    spans, more_spans = spans_of_runs(stream, first, lengths)
    finding = Finding(
        details=details, severity="warning", channels=channels, spans=spans, more_spans=more_spans, size=details.share
    )
    return [(finding, mask)]
