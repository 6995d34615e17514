"""Runs of equal samples: stuck sensors, and dropouts, where a log holds the number 0."""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import Any

import numpy as np

from sigmatau.arrays import Bools, Floats, Runs
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.values import Dropout, StuckSamples
from sigmatau.quality.facts import stream_fact
from sigmatau.quality.samples.common import (
    change_of_white,
    growing_step,
    longest_spans,
    mask_of_runs,
    merged_axes,
    present,
)
from sigmatau.quality.samples.level_walk import walk_of_runs
from sigmatau.quality.samples.masking import masked
from sigmatau.quality.samples.repeated_samples import repeats, runs_of_equal
from sigmatau.quality.samples.resolution import resolution
from sigmatau.quality.samples.straight_lines import MIN_STRETCH, filled
from sigmatau.record.streams import Stream

__all__ = ["WARN_SHARE", "dropouts", "extent", "stuck_runs", "stuck_samples", "without_runs", "zero_rate", "zero_runs"]

_FALSE_ALARM = 1e-4  # probability that a record of noise alone has a run that is reported
_MIN_RUN = 5  # shortest run of equal samples that is reported: logs of real sensors have triples without a fault

# Least noise seen, in steps, for which runs are judged. Rounded noise of 0.15 steps, which may rest on one value, shows 0 to
# 0.5 steps, depending on where its mean lies between two steps.
_MIN_NOISE_STEPS = 0.6

WARN_DURATION, WARN_SHARE = 1.0, 1e-3  # length of a run [s] and part of a record from which on a finding is a warning
_WARN_CHANGE = 0.02  # of the random walk, from which on it is one too

# Least part of the visits to zero that are runs. Single samples of a sensor whose range ends at zero, or whose numbers are
# coarse, are zero too.
_MIN_SHARE_IN_RUNS = 0.95


def stuck_runs(stream: Stream, channel: str, x: Floats) -> Runs:
    """First samples and lengths of the runs of equal samples of a channel x that are longer than the noise can explain.

    A run is too long if n·p^length < 1e-4, where p is the probability that a sample of the white part of the noise falls
    into the middle of a step, the largest there can be. No run is reported where less than 0.6 steps of noise are seen:
    then the mean may be near the border of a step, and the noise may rest on one value in the middle of another.
    """
    first, lengths = runs_of_equal(x, least=_MIN_RUN)
    if len(first) == 0 or int(lengths.max()) == len(present(x)) or growing_step(x) > 0:
        return first[:0], lengths[:0]
    found = resolution(stream, channel)

    def limit(times: float) -> float:
        stay = 0.0
        if found is not None:
            if found.ratio < _MIN_NOISE_STEPS:
                return math.inf
            # Rounding makes q²/12 of what is seen; neighbours of quantization noise differ by 3/2 of what white ones do.
            variance = (found.noise**2 * times - found.step**2 / 12) / 1.5
            stay = 2 * NormalDist().cdf(found.step / (2 * math.sqrt(variance))) - 1
        longest = math.log(len(x) / _FALSE_ALARM) / -math.log(max(stay, 1e-12))
        # Irregular repetition has runs of twice its mean, and rarely more.
        return max(_MIN_RUN, longest) * (1 if times <= 1 else 2 * times)

    kept = lengths > limit(1.0)
    if kept.any():
        held = repeats(stream)
        if held is not None and channel in held.channels:
            kept = lengths > limit(max(held.times, held.longest / 2))
    return first[kept], lengths[kept]


def zero_rate(stream: Stream, channel: str) -> float | None:
    """The rate that the number 0 of the log stands for; None for accumulated values, whose rate is 0 where they stick."""
    transform = stream.samples.transforms[stream.channels.index(channel)]
    if transform.kind == "accumulated":
        return None
    factor = transform.scale * transform.factor / (stream.grid.tau0 if transform.kind != "rate" else 1.0)
    return -transform.offset * factor if transform.offset else 0.0


def zero_runs(stream: Stream, channel: str, x: Floats) -> Runs:
    """The runs in which the log holds only the number 0; none if single samples are 0 too (coarse, or a range from 0 on)."""
    first, lengths = stuck_runs(stream, channel, x)
    zero = zero_rate(stream, channel)
    here = np.zeros(len(first), dtype=bool) if zero is None else x[first] == zero
    count = int(np.count_nonzero(here))
    if count:
        visits = int(np.count_nonzero(np.diff(np.flatnonzero(x == zero)) > 1)) + 1
        if visits - count > (1 - _MIN_SHARE_IN_RUNS) * visits:
            here[:] = False
    return first[here], lengths[here]


@stream_fact
def without_runs(stream: Stream) -> Stream:
    """The stream with runs of equal samples and of straight lines that noise cannot explain taken for missing."""
    masks = []
    for channel in stream.channels:
        mask = mask_of_runs(stream.grid.n, *stuck_runs(stream, channel, stream.column(channel)))
        lines = filled(stream, channel)
        if lines is not None:
            mask |= mask_of_runs(stream.grid.n, *lines.outages)
        masks.append(mask)
    return masked(stream, np.stack(masks, axis=1))


def dropouts(stream: Stream, *, warn_duration: float = WARN_DURATION, warn_share: float = WARN_SHARE) -> list[Finding]:
    """Runs in which the log holds only the number 0: the sensor, or the link to it, was not there.

    At most one finding of all axes concerned, a warning from a length [s] or a part of the record on; none for a channel
    that never changes.
    """
    findings = []
    for channel in stream.channels:
        x = stream.column(channel)
        runs = zero_runs(stream, channel, x)
        if len(runs[0]):
            findings.append(_held(Dropout, stream, channel, x, runs, (warn_duration, warn_share)))
    return merged_axes(findings)


def stuck_samples(
    stream: Stream, *, warn_duration: float = WARN_DURATION, warn_share: float = WARN_SHARE
) -> list[Finding]:
    """Runs of equal samples that are improbably long for the step and the noise of a channel; thresholds as of `dropouts`.

    At most one finding of all axes concerned; none for a channel that never changes, for runs at an end of the range, see
    `saturation`, and for runs of the number 0, see `dropouts`.
    """
    findings = []
    for channel in stream.channels:
        x = stream.column(channel)
        first, lengths = stuck_runs(stream, channel, x)
        if not len(first):
            continue
        zeros = zero_runs(stream, channel, x)[0]
        kept = ~np.isin(x[first], (np.nanmin(x), np.nanmax(x))) & ~np.isin(first, zeros)
        if kept.any():
            runs = first[kept], lengths[kept]
            findings.append(_held(StuckSamples, stream, channel, x, runs, (warn_duration, warn_share)))
    return merged_axes(findings)


def extent(bad: Bools, runs: Runs, tau0: float) -> dict[str, Any]:
    """The fields of held samples that say how many there are, and when."""
    (first, lengths), k = runs, int(np.argmax(runs[1]))
    longest = {"start": int(first[k]) * tau0, "longest": int(lengths[k]) * tau0}
    return {"samples": int(bad.sum()), "share": float(bad.mean()), "runs": len(first), **longest}


def _held(
    kind: type[Dropout | StuckSamples], stream: Stream, channel: str, x: Floats, runs: Runs, warn: tuple[float, float]
) -> tuple[float, Finding]:
    """The finding of a channel, and K that the levels held add."""
    (first, lengths), tau0 = runs, stream.grid.tau0
    own = 0 if kind is Dropout else 1  # the first sample that is held is the sensor's own
    bad = mask_of_runs(len(x), first + own, lengths - own)
    factor, tau = change_of_white(x, bad, tau0, beyond=int(lengths.max()))
    share, duration = float(bad.mean()), int(lengths.max()) * tau0
    long = lengths >= MIN_STRETCH
    walk = walk_of_runs(stream, channel, (first[long], lengths[long])) if long.any() else None
    matters = share > warn[1] or duration >= warn[0] or abs(factor - 1) > _WARN_CHANGE
    return walk.coefficient if walk is not None else 0.0, Finding(
        details=kind(strongest=channel, tau=tau, walk=walk, **extent(bad, runs, tau0)),
        severity="warning" if matters else "info",
        channels=(channel,),
        spans=longest_spans(stream, first, lengths),
        size=duration,
        unit="s",
        factors=(("random_walk", factor), *(walk.factors if walk is not None else ())),
    )
