"""Motion of a sensor that should rest: shocks, vibration, and steps of the mean (tilt)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sigmatau.arrays import median
from sigmatau.findings.disturbances import LevelStep, MotionBurst, NotStatic
from sigmatau.findings.finding import Finding, Span
from sigmatau.frozen import frozen
from sigmatau.quality.facts import stream_fact
from sigmatau.quality.samples.common import present
from sigmatau.quality.samples.light_shocks import light_shocks
from sigmatau.quality.samples.masking import Found, in_seconds, mask_of, masked, without_steps
from sigmatau.quality.samples.motion import Burst, MeanStep, Summary, bursts, excursions, level_changes, summary
from sigmatau.quality.samples.spikes import spikes_missing
from sigmatau.record.streams import Stream


@frozen
class ShockThresholds:
    """Thresholds of `shocks` and `not_static`."""

    shock_windows: int = 3
    """Windows of 1 s in a burst, up to which it is a shock. [windows] Judgement: a knock rings for less than a
    second, and may lie across two windows."""

    side_windows: int = 3
    """Windows of a step whose means before and after it are compared. [windows] Judgement: a median of three
    tolerates one that is disturbed."""

    returned: float = 0.5
    """Change of the mean over the size of an excursion, below which the mean has returned. [1] Judgement: half way
    between a step and none."""


THRESHOLDS = ShockThresholds()


def shocks(stream: Stream) -> list[Found]:
    """Shocks and other motion after which the mean is what it was before: at most one finding, of all axes.

    Their samples are those of all axes, with a margin: a shock of one axis reaches the others. They are looked for beside
    spikes.
    """
    if stream.quantity not in ("angular_rate", "acceleration"):
        return []
    light, alone = light_shocks(stream), spikes_missing(stream)
    movement = movements(alone)
    moved = [*movement.moved, *_not_in(light, movement.moved)]
    if not moved:
        return []
    margins = ((b, max(movement.window, b.stop - b.start) if b.away else movement.window) for b in moved)
    bad = mask_of(stream.grid.n, [(b.start - margin, b.stop + margin) for b, margin in margins])
    return [(_motion(stream, moved, movement.window), np.repeat(bad[:, None], len(stream.channels), axis=1))]


def not_static(stream: Stream, *, still: Stream | None = None) -> list[Finding]:
    """Motion of a sensor that should rest and that is not left out: steps of the mean (tilt), by channel.

    Parameters
    ----------
    stream : Stream
        Angular rates or accelerations, with their shocks and spikes: across a shock the mean may step. Other signals are not
        checked.
    still : Stream, optional
        The same without them, in which a step must be left.
    """
    if stream.quantity not in ("angular_rate", "acceleration"):
        return []
    movement = movements(spikes_missing(stream))
    findings = []
    for channel, changes in movement.changed.items():
        if lasting := [change for change in changes if still is None or _remains(summary(still, channel), change)]:
            findings.append(level_finding(stream, channel, lasting))
    return findings


def _remains(windows: Summary, change: MeanStep) -> bool:
    """Whether the mean before a step and after it differ without the shocks beside it."""
    place, size = change.sample // windows.window, THRESHOLDS.side_windows * change.window // windows.window
    before, after = present(windows.mean[:place])[-size:], present(windows.mean[place:])[:size]
    if not (len(before) and len(after)):
        return True
    return abs(median(after) - median(before)) > THRESHOLDS.returned * abs(change.size)


def between_steps(stream: Stream, findings: Sequence[Finding]) -> Stream:
    """The stream with the neighbourhood of steps of the mean taken for missing, by findings about them."""
    mask = np.zeros((stream.grid.n, len(stream.channels)), dtype=bool)
    for finding in findings:
        if isinstance(finding.details, NotStatic) and finding.channel in stream.channels:
            for step in finding.details.steps:
                first, last = map(stream.grid.sample, (step.time - step.uncertainty, step.time + step.uncertainty))
                mask[max(first, 0) : max(last, 0), stream.channels.index(finding.channel)] = True
    return masked(stream, mask)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Movements:
    """Motion of the channels of a stream."""

    moved: list[Burst]
    changed: dict[str, list[MeanStep]]  # steps of the mean, of the channels that have any
    window: int  # samples in a window


def _not_in(shocks: Sequence[Burst], moved: Sequence[Burst]) -> list[Burst]:
    """Shocks that do not overlap with motion of the same axis."""
    return [
        shock
        for shock in shocks
        if not any(m.channel == shock.channel and m.start < shock.stop and shock.start < m.stop for m in moved)
    ]


@stream_fact
def movements(stream: Stream) -> Movements:
    """Bursts, excursions and steps of the mean of each channel."""
    moved: list[Burst] = []
    changed: dict[str, list[MeanStep]] = {}
    window = 0
    for channel in stream.channels:
        windows = summary(stream, channel)
        window = windows.window
        here = bursts(stream, windows)
        moved += here
        if here:  # the mean during motion is not used; across a shock it steps from the mean before to the mean after
            mean = windows.mean.copy()
            for burst in here:
                first, last = burst.start // window, burst.stop // window
                short = last - first <= THRESHOLDS.shock_windows and first > 0 and last < len(mean)
                middle = (first + last) // 2
                mean[first:middle] = mean[first - 1] if short else np.nan
                mean[middle:last] = mean[last] if short else np.nan
            windows = replace(windows, mean=mean)
        changes = level_changes(stream, windows)
        if changes:  # the two edges of an excursion of some seconds are not steps
            gone = excursions(stream, windows)
            changes = [
                change for change in changes if not any(_comes_back(windows, change, burst_away) for burst_away in gone)
            ]
        if changes:
            changed[channel] = changes
        moved += excursions(stream, windows, changes)
    return Movements(moved=moved, changed=changed, window=window)


def _comes_back(windows: Summary, change: MeanStep, excursion: Burst) -> bool:
    """Whether a step is an edge of an excursion after which the mean is what it was before."""
    size = excursion.stop - excursion.start
    if not excursion.start - 2 * size <= change.sample <= excursion.stop + 2 * size:
        return False
    w = windows.window
    before = present(windows.mean[max(excursion.start - 6 * size, 0) // w : max(excursion.start - 2 * size, 0) // w])
    after = present(windows.mean[(excursion.stop + 2 * size) // w : (excursion.stop + 6 * size) // w])
    if not (len(before) and len(after)):
        return False
    return abs(median(after) - median(before)) < THRESHOLDS.returned * abs(change.size)


def _motion(stream: Stream, moved: Sequence[Burst], window: int) -> Finding:
    """All bursts of a stream in one finding."""
    groups: list[list[Burst]] = []
    for burst in sorted(moved, key=lambda b: b.start):
        if groups and burst.start <= max(b.stop for b in groups[-1]):
            groups[-1].append(burst)
        else:
            groups.append([burst])
    spans = [(min(b.start for b in group), max(b.stop for b in group)) for group in groups]
    times = in_seconds(stream, spans)
    bursts_of_motion = tuple(
        _burst(
            stream,
            group,
            span,
            shock=stop - start <= THRESHOLDS.shock_windows * window and not all(b.away for b in group),
        )
        for group, span, (start, stop) in zip(groups, times, spans, strict=True)
    )
    axes = tuple(c for c in stream.channels if any(b.channel == c for b in moved))
    return Finding(
        details=NotStatic(quantity=stream.quantity, unit=stream.unit, bursts=bursts_of_motion),
        severity="warning",
        channels=axes,
        spans=times,
        size=max(burst.ratio for burst in bursts_of_motion),
    )


def _burst(stream: Stream, group: Sequence[Burst], span: Span, *, shock: bool) -> MotionBurst:
    """Bursts of several axes at one time."""
    strongest = max(group, key=lambda b: b.ratio)
    return MotionBurst(
        start=span[0],
        stop=span[1],
        channels=tuple(c for c in stream.channels if any(b.channel == c for b in group)),
        ratio=strongest.ratio,
        departure=strongest.away,
        shock=shock,
    )


def level_finding(stream: Stream, channel: str, changes: Sequence[MeanStep], *, beside_drift: bool = False) -> Finding:
    """Finding about one or more steps of the mean: when, how large, and what they add to the rate random walk."""
    largest = max(changes, key=lambda change: abs(change.size))
    tau0 = stream.grid.tau0
    # Half the mean square of a step's triangle of differences, Δ²τ/(3T), is what K² = Δ²/T makes: K²τ/3, eq. (21).
    added = math.sqrt(sum(change.size**2 for change in changes) / stream.grid.duration)
    leave_out, keep = without_steps(stream, [(c.sample, c.window, c.size) for c in changes])
    steps = tuple(
        LevelStep(
            time=stream.grid.time(change.sample),
            uncertainty=change.around * tau0,
            size=change.size,
            ratio=change.times,
            window=change.window * tau0,
            gradual=change.gradual,
        )
        for change in changes
    )
    return Finding(
        details=NotStatic(
            quantity=stream.quantity,
            unit=stream.unit,
            steps=steps,
            beside_drift=beside_drift,
            added_walk=added,
            leave_out=leave_out,
            keep=keep,
        ),
        severity="warning",
        channels=(channel,),
        spans=in_seconds(stream, [(change.sample, change.sample) for change in changes]),
        size=abs(largest.size),
        unit=stream.unit,
    )
