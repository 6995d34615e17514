"""Shocks and other motion after which the mean returns, and steps of the mean (tilt)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sigmatau.arrays import Floats, median
from sigmatau.findings.disturbances import LevelStep, MotionBurst, NotStatic
from sigmatau.findings.finding import Finding, Span
from sigmatau.frozen import frozen
from sigmatau.quality.facts import stream_fact
from sigmatau.quality.motion.light_shocks import light_shocks
from sigmatau.quality.motion.windows import (
    Burst,
    MeanStep,
    Windows,
    bursts,
    excursions,
    mean_steps,
    summarise_windows,
)
from sigmatau.quality.samples.common import present
from sigmatau.quality.samples.masking import MaskedFinding, in_seconds, mask_from_spans, masked
from sigmatau.quality.samples.spikes import spikes_missing
from sigmatau.record.streams import Stream

# Largest number of windows of 1 s in a shock. [windows] Judgement: a knock rings for less than a second, and may span
# two windows.
_SHOCK_WINDOWS = 3
# Number of windows on each side of a step whose means are compared. [windows] Judgement: a median of three tolerates
# one disturbed window.
_SIDE_WINDOWS = 3
# Ratio of the change of the mean to the size of an excursion, below which the mean has returned. [1] Judgement: halfway
# between a step and none.
_RETURNED = 0.5
# Ratio of the sum of two steps to the larger one, below which they cancel. [1] Judgement: the sizes of steps have
# errors of a tenth or two.
_CANCELS = 0.3


@frozen(eq=False)
class ShocksAndSteps:
    """Motion and steps found in the channels of a stream."""

    bursts: list[Burst]  # bursts and excursions
    steps: dict[str, list[MeanStep]]  # steps of the mean, by channel that has steps
    window: int  # samples in a window


def shocks(stream: Stream) -> list[MaskedFinding]:
    """Report shocks and other motion after which the mean returns: at most one finding, for all axes.

    The finding covers the samples of all axes, with a margin, because a shock on one axis reaches the others. Shocks are
    also searched among spikes.
    """
    if stream.quantity not in ("angular_rate", "acceleration"):
        return []
    light, motion = light_shocks(stream), shocks_and_steps(spikes_missing(stream))
    moved = [*motion.bursts, *(shock for shock in light if not any(_overlap(shock, b) for b in motion.bursts))]
    if not moved:
        return []
    margins = [max(motion.window, b.stop - b.start) if b.away else motion.window for b in moved]
    bad = mask_from_spans(stream.grid.n, [(b.start - m, b.stop + m) for b, m in zip(moved, margins, strict=True)])
    return [(_shock_finding(stream, moved, motion.window), np.repeat(bad[:, None], len(stream.channels), axis=1))]


def _overlap(a: Burst, b: Burst) -> bool:
    return a.channel == b.channel and b.start < a.stop and a.start < b.stop


def not_static(stream: Stream, *, still: Stream | None = None) -> list[Finding]:
    """Report motion that is not left out: steps of the mean (tilt), by channel.

    Parameters
    ----------
    stream : Stream
        Angular rates or accelerations with their shocks and spikes, because the mean may step across a shock. Other
        signals are not checked.
    still : Stream, optional
        The same stream without shocks and spikes, in which a step must remain.
    """
    if stream.quantity not in ("angular_rate", "acceleration"):
        return []
    findings = []
    for channel, steps in shocks_and_steps(spikes_missing(stream)).steps.items():
        if lasting := [step for step in steps if still is None or _remains(summarise_windows(still, channel), step)]:
            findings.append(step_finding(stream, channel, lasting))
    return findings


def _remains(windows: Windows, step: MeanStep) -> bool:
    """Whether the means before and after a step differ without the shocks next to it."""
    place, size = step.sample // windows.length, _SIDE_WINDOWS * step.window // windows.length
    change = _change(present(windows.mean[:place])[-size:], present(windows.mean[place:])[:size])
    return not abs(change) <= _RETURNED * abs(step.size)


def _change(before: Floats, after: Floats) -> float:
    """Change of the median; NaN if there is no window on one side."""
    return median(after) - median(before)


def between_steps(stream: Stream, findings: Sequence[Finding]) -> Stream:
    """Mark the samples around the reported steps of the mean as missing."""
    mask = np.zeros((stream.grid.n, len(stream.channels)), dtype=bool)
    for finding in findings:
        if isinstance(finding.details, NotStatic) and finding.channel in stream.channels:
            for step in finding.details.steps:
                first, last = map(stream.grid.sample, (step.time - step.uncertainty, step.time + step.uncertainty))
                mask[max(first, 0) : max(last, 0), stream.channels.index(finding.channel)] = True
    return masked(stream, mask)


@stream_fact
def shocks_and_steps(stream: Stream) -> ShocksAndSteps:
    """Find bursts, excursions and steps of the mean of each channel."""
    motion = ShocksAndSteps(bursts=[], steps={}, window=summarise_windows(stream, stream.channels[0]).length)
    for channel in stream.channels:
        windows = summarise_windows(stream, channel)
        moved = bursts(stream, windows)
        if moved:
            windows = replace(windows, mean=_mean_without_motion(windows, moved))
        steps = mean_steps(stream, windows)
        if steps:  # the two edges of a short excursion are not steps
            gone = excursions(stream, windows)
            steps = [step for step in steps if not any(_comes_back(windows, step, excursion) for excursion in gone)]
        if steps:
            motion.steps[channel] = steps
        motion.bursts.extend([*moved, *excursions(stream, windows, steps)])
    return motion


def _mean_without_motion(windows: Windows, moved: Sequence[Burst]) -> Floats:
    """Remove motion from the mean. At a shock it then steps from the mean before to the mean after."""
    mean = windows.mean.copy()
    for burst in moved:
        first, last = burst.start // windows.length, burst.stop // windows.length
        short = last - first <= _SHOCK_WINDOWS and first > 0 and last < len(mean)
        middle = (first + last) // 2
        mean[first:middle] = mean[first - 1] if short else np.nan
        mean[middle:last] = mean[last] if short else np.nan
    return mean


def _comes_back(windows: Windows, step: MeanStep, excursion: Burst) -> bool:
    """Whether a step is an edge of an excursion, after which the mean returns."""
    size, w = excursion.stop - excursion.start, windows.length
    if not excursion.start - 2 * size <= step.sample <= excursion.stop + 2 * size:
        return False
    before = windows.mean[max(excursion.start - 6 * size, 0) // w : max(excursion.start - 2 * size, 0) // w]
    after = windows.mean[(excursion.stop + 2 * size) // w : (excursion.stop + 6 * size) // w]
    return abs(_change(present(before), present(after))) < _RETURNED * abs(step.size)


def _shock_finding(stream: Stream, moved: Sequence[Burst], window: int) -> Finding:
    """Collect all bursts of a stream in one finding."""
    groups: list[list[Burst]] = []
    for burst in sorted(moved, key=lambda b: b.start):
        if groups and burst.start <= max(b.stop for b in groups[-1]):
            groups[-1].append(burst)
        else:
            groups.append([burst])
    together = tuple(_join_bursts(stream, group, window) for group in groups)
    return Finding(
        details=NotStatic(quantity=stream.quantity, unit=stream.unit, bursts=together),
        severity="warning",
        channels=_in_order(stream, moved),
        spans=tuple((burst.start, burst.stop) for burst in together),
        size=max(burst.ratio for burst in together),
    )


def _in_order(stream: Stream, moved: Sequence[Burst]) -> tuple[str, ...]:
    return tuple(channel for channel in stream.channels if any(b.channel == channel for b in moved))


def _join_bursts(stream: Stream, group: Sequence[Burst], window: int) -> MotionBurst:
    """Join bursts of several axes that overlap in time."""
    strongest = max(group, key=lambda b: b.ratio)
    first, last = min(b.start for b in group), max(b.stop for b in group)
    return MotionBurst(
        start=stream.grid.time(first),
        stop=stream.grid.time(last),
        channels=_in_order(stream, group),
        ratio=strongest.ratio,
        departure=strongest.away,
        shock=last - first <= _SHOCK_WINDOWS * window and not all(b.away for b in group),
    )


def step_finding(stream: Stream, channel: str, steps: Sequence[MeanStep], *, beside_drift: bool = False) -> Finding:
    """Build the finding about steps of the mean: their times, sizes and contribution to the rate random walk."""
    grid = stream.grid
    leave_out, keep = _leave_out_or_keep(stream, steps)
    details = NotStatic(
        quantity=stream.quantity,
        unit=stream.unit,
        steps=tuple(
            LevelStep(
                time=grid.time(step.sample),
                uncertainty=step.half_width * grid.tau0,
                size=step.size,
                ratio=step.ratio,
                window=step.window * grid.tau0,
                gradual=step.gradual,
            )
            for step in steps
        ),
        beside_drift=beside_drift,
        # The squared differences at a step form a triangle; half their mean, Δ²τ/(3T), equals K²τ/3 of eq. (21) for K²
        # = Δ²/T.
        added_walk=math.sqrt(sum(step.size**2 for step in steps) / grid.duration),
        leave_out=leave_out,
        keep=keep,
    )
    return Finding(
        details=details,
        severity="warning",
        channels=(channel,),
        spans=in_seconds(stream, [(step.sample, step.sample) for step in steps]),
        size=max(abs(step.size) for step in steps),
        unit=stream.unit,
    )


def _leave_out_or_keep(
    stream: Stream, steps: Sequence[MeanStep]
) -> tuple[tuple[Span, ...], tuple[float | None, float | None] | None]:
    """Choose the stretch of a record with steps to leave out or to keep.

    The stretch between two steps that cancel is left out. Otherwise the longest part between steps is kept, because
    leaving out only the moment of a step would keep both means. Times are from the beginning of the whole record; None is
    one of its ends. [s]
    """
    n = stream.grid.n
    if len(steps) == 2:
        up, down = steps
        if abs(up.size + down.size) < _CANCELS * max(abs(up.size), abs(down.size)):
            return in_seconds(stream, [(max(up.sample - up.window, 0), min(down.sample + down.window, n))]), None
    edges = [(0, 0), *((step.sample, step.window) for step in steps), (n, 0)]
    k = max(range(len(edges) - 1), key=lambda i: edges[i + 1][0] - edges[i][0])
    ((start, stop),) = in_seconds(stream, [(sum(edges[k]), edges[k + 1][0] - edges[k + 1][1])])
    whole = stream.grid.lead == 0
    return (), (None if k == 0 and whole else start, None if k == len(steps) and whole else stop)
