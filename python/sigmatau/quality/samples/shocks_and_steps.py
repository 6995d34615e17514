"""Motion of a sensor that should rest: shocks, vibration, rotation, and steps of the mean (tilt)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from sigmatau.findings.finding import Finding, Span
from sigmatau.findings.kinds.disturbances import LevelStep, MotionBurst, NotStatic, Rotation
from sigmatau.quality.facts import stream_fact
from sigmatau.quality.samples.common import WARN_FACTOR, present, worst_on_white
from sigmatau.quality.samples.level_walk import added_walk, parts_without
from sigmatau.quality.samples.masking import in_seconds, mask_of, without_steps
from sigmatau.quality.samples.motion import Burst, LevelChange, Summary, bursts, excursions, level_changes, summary
from sigmatau.record.streams import Stream

__all__ = ["Movements", "level_finding", "movements", "not_static"]

LARGEST_BIAS = math.radians(20)
"""Largest mean rate of a gyro at rest: twice the largest zero-rate offset of consumer sensors' datasheets. [rad/s]"""

_SHOCK_WINDOWS = 3  # a burst of no more windows, of 1 s each, is a shock
_RETURNED = 0.5  # a mean that changes by less than this part of an excursion has returned


def not_static(
    stream: Stream,
    *,
    judged: Stream | None = None,
    shocks: Sequence[Burst] = (),
    largest_bias: float = LARGEST_BIAS,
    warn_factor: float = WARN_FACTOR,
) -> list[Finding]:
    """Motion of a sensor that should rest: rotation, shocks and other bursts, steps of the mean (tilt).

    At most one finding a channel and one for several axes together; light shocks are an info below `warn_factor`.

    Parameters
    ----------
    stream : Stream
        Angular rates or accelerations; other signals are not checked.
    judged : Stream, optional
        The same without spikes, in which motion is looked for; effects are those on the stream itself.
    shocks : sequence of Burst
        Shocks found before, see `sigmatau.quality.samples.light_shocks`.
    largest_bias : float
        A larger mean rate is a rotation. [rad/s]
    """
    if stream.quantity not in ("angular_rate", "acceleration"):
        return []
    seen = movements(stream if judged is None else judged)
    rotating = max(seen.rates, key=lambda channel: seen.rates[channel])
    if stream.quantity == "angular_rate" and seen.rates[rotating] >= largest_bias:
        return [_rotation(stream, rotating, seen.rates[rotating])]
    findings = {channel: level_finding(stream, channel, changes) for channel, changes in seen.changed.items()}
    if moved := [*seen.moved, *_not_in(shocks, seen.moved)]:
        light = not seen.moved
        motion = _motion(stream, moved, seen.window, light=light, warn_factor=warn_factor)
        if steps := findings.pop(motion.channel or "", None):  # one finding a channel
            motion = _both(motion, steps)
        return [motion, *findings.values()]
    return list(findings.values())


def _both(motion: Finding, steps: Finding) -> Finding:
    """Bursts and steps of one channel in one finding."""
    one, other = cast("NotStatic", motion.details), cast("NotStatic", steps.details)
    return replace(
        motion,
        details=replace(one, steps=other.steps, walk=other.walk, keep=other.keep),
        spans=tuple(sorted({*motion.spans, *steps.spans})),
        factors=(*motion.factors, *steps.factors),
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Movements:
    """Motion of the channels of a stream."""

    moved: list[Burst]
    changed: dict[str, list[LevelChange]]  # steps of the mean, of the channels that have any
    rates: dict[str, float]  # size of the mean, by channel
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
    changed: dict[str, list[LevelChange]] = {}
    rates: dict[str, float] = {}
    window = 0
    for channel in stream.channels:
        seen = summary(stream, channel)
        window = seen.window
        rates[channel] = abs(seen.first + float(np.mean(present(seen.mean)))) if np.isfinite(seen.mean).any() else 0.0
        here = bursts(stream, seen)
        moved += here
        if here:  # the mean during motion is not used; across a shock it steps from the mean before to the mean after
            mean = seen.mean.copy()
            for burst in here:
                first, last = burst.start // window, burst.stop // window
                short = last - first <= _SHOCK_WINDOWS and first > 0 and last < len(mean)
                middle = (first + last) // 2
                mean[first:middle] = mean[first - 1] if short else np.nan
                mean[middle:last] = mean[last] if short else np.nan
            seen = replace(seen, mean=mean)
        changes = level_changes(stream, seen)
        if changes:  # the two edges of an excursion of some seconds are not steps
            gone = excursions(stream, seen)
            changes = [change for change in changes if not any(_comes_back(seen, change, one) for one in gone)]
        if changes:
            changed[channel] = changes
        moved += excursions(stream, seen, changes)
    return Movements(moved=moved, changed=changed, rates=rates, window=window)


def _comes_back(seen: Summary, change: LevelChange, one: Burst) -> bool:
    """Whether a step is an edge of an excursion after which the mean is what it was before."""
    size = one.stop - one.start
    if not one.start - 2 * size <= change.sample <= one.stop + 2 * size:
        return False
    w = seen.window
    before = present(seen.mean[max(one.start - 6 * size, 0) // w : max(one.start - 2 * size, 0) // w])
    after = present(seen.mean[(one.stop + 2 * size) // w : (one.stop + 6 * size) // w])
    if not (len(before) and len(after)):
        return False
    return abs(float(np.median(after) - np.median(before))) < _RETURNED * abs(change.size)


def _rotation(stream: Stream, channel: str, rate: float) -> Finding:
    details = NotStatic(quantity=stream.quantity, unit=stream.unit, rotation=Rotation(rate=rate, stream=stream.name))
    return Finding(details=details, severity="warning", channels=(channel,), size=rate, unit=stream.unit)


def _motion(stream: Stream, moved: Sequence[Burst], window: int, *, light: bool, warn_factor: float) -> Finding:
    """All bursts of a stream in one finding."""
    groups: list[list[Burst]] = []
    for burst in sorted(moved, key=lambda b: b.start):
        if groups and burst.start <= max(b.stop for b in groups[-1]):
            groups[-1].append(burst)
        else:
            groups.append([burst])
    spans = [(min(b.start for b in group), max(b.stop for b in group)) for group in groups]
    times = in_seconds(stream, spans)
    told = tuple(
        _burst(stream, group, span, shock=stop - start <= _SHOCK_WINDOWS * window and not all(b.away for b in group))
        for group, span, (start, stop) in zip(groups, times, spans, strict=True)
    )
    axes = tuple(c for c in stream.channels if any(b.channel == c for b in moved))
    tau0, n = stream.grid.tau0, stream.grid.n
    masks = {c: mask_of(n, [(b.start, b.stop) for b in moved if b.channel == c]) for c in axes}
    effects = {c: worst_on_white(stream.column(c), mask, tau0) for c, mask in masks.items()}
    strongest = max(axes, key=lambda c: effects[c][0])
    factor, tau = effects[strongest]
    return Finding(
        details=NotStatic(
            quantity=stream.quantity,
            unit=stream.unit,
            bursts=told,
            strongest=strongest,
            random_walk=factor,
            tau=tau,
            leave_out=in_seconds(stream, spans, of_log=True),
        ),
        severity="info" if light and factor < warn_factor else "warning",
        channels=axes,
        spans=times,
        size=max(burst.ratio for burst in told),
        factors=(("random_walk", factor),) if not 1 / warn_factor <= factor <= warn_factor else (),
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


def level_finding(
    stream: Stream, channel: str, changes: Sequence[LevelChange], *, beside_drift: bool = False
) -> Finding:
    """Finding about one or more steps of the mean: when, how large, and what they add to the rate random walk."""
    largest = max(changes, key=lambda change: abs(change.size))
    tau0, n = stream.grid.tau0, stream.grid.n
    # Half the mean square of a step's triangle of differences, Δ²τ/(3T), is what K² = Δ²/T makes: K²τ/3, eq. (21).
    added = sum(change.size**2 for change in changes) / stream.grid.duration
    between = parts_without(
        n,
        [max(change.sample - change.around, 0) for change in changes],
        [min(change.sample + change.around, n) for change in changes],
    )
    walk = added_walk(stream, channel, added, between)
    leave_out, keep = without_steps(stream, [(c.sample, c.window, c.size) for c in changes])
    steps = tuple(
        LevelStep(
            time=change.sample * tau0,
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
            walk=walk,
            leave_out=leave_out,
            keep=keep,
        ),
        severity="warning",
        channels=(channel,),
        spans=in_seconds(stream, [(change.sample, change.sample) for change in changes]),
        size=abs(largest.size),
        unit=stream.unit,
        factors=walk.factors,
    )
