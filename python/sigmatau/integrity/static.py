"""Motion: knocks, vibration that comes and goes, rotation, tilt and other changes of level."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from sigmatau.integrity.masking import leave_out_option, without_steps
from sigmatau.integrity.motion import Burst, LevelChange, bursts, level_changes, summary
from sigmatau.integrity.samples import affected, axes_text, change_of_white, length, octaves, place, present, when
from sigmatau.results import Finding
from sigmatau.streams import Stream
from sigmatau.terms import TERMS

__all__ = ["not_static"]

# A mean rate that no bias reaches: 20 deg/s is twice the largest zero-rate offset of consumer sensors' datasheets.
_ROTATION = math.radians(20)

# A burst of no more windows is a knock.
_KNOCK = 3

# From here on a coefficient changes noticeably.
_MATTERS = 1.02


# A walk rules the long times if 3σ²/τ is the same over so many octaves, to this factor: bias instability makes 8 of it, and
# the last variance of some 16 pairs has an error of a third.
_RULED_OCTAVES, _SAME = 3, 2.0


def not_static(stream: Stream) -> list[Finding]:
    """Motion of a sensor that should rest: rotation, knocks and other bursts, changes of level (tilt).

    Parameters
    ----------
    stream : Stream
        Angular rates or accelerations; of other signals nothing is said.

    Returns
    -------
    list of Finding
        At most one a channel and one for several axes together.
    """
    if stream.quantity not in ("angular_rate", "acceleration"):
        return []
    moved: list[Burst] = []
    changed: dict[str, list[LevelChange]] = {}
    rates: dict[str, float] = {}
    window = 0
    findings = []
    for channel in stream.channels:
        seen = summary(stream, channel)
        window = seen.window
        rates[channel] = abs(seen.first + float(np.mean(present(seen.mean)))) if np.isfinite(seen.mean).any() else 0.0
        here = bursts(stream, seen)
        moved += here
        if here:  # a level can be told before and after motion, not in it; across a knock, from one to the other
            mean = seen.mean.copy()
            for burst in here:
                first, last = burst.start // window, burst.stop // window
                short = last - first <= _KNOCK and first > 0 and last < len(mean)
                middle = (first + last) // 2
                mean[first:middle] = mean[first - 1] if short else np.nan
                mean[middle:last] = mean[last] if short else np.nan
            seen = replace(seen, mean=mean)
        changes = level_changes(stream, seen)
        if changes:
            changed[channel] = changes
    rotating = _rotation(stream, rates)
    if rotating is not None:
        return [rotating]
    if moved:
        findings.append(_moved(stream, moved, window))
    alone = findings[0].channel if findings else None
    for channel, changes in changed.items():
        finding = _level(stream, channel, changes)
        if channel == alone:  # one finding a channel
            knock = findings[0]
            findings[0] = replace(
                knock,
                message=f"{knock.message}; {finding.message}",
                effect=f"{knock.effect}; {finding.effect}",
                changes=(*knock.changes, *finding.changes),
            )
        else:
            findings.append(finding)
    return findings


def _rotation(stream: Stream, rates: dict[str, float]) -> Finding | None:
    channel = max(rates, key=lambda c: rates[c])
    mean = rates[channel]
    if stream.quantity != "angular_rate" or mean < _ROTATION:
        return None
    return Finding(
        code="not_static",
        severity="warning",
        channel=channel,
        message=(
            f"the mean rate is {math.degrees(mean):.3g} deg/s, more than a bias can be: the sensor turns, or the unit is"
            " wrong"
        ),
        size=mean,
        unit=stream.unit,
        effect="errors of scale and of the turning itself are in every coefficient",
        remedy=(
            f"record at rest; if the numbers are in deg/s and not in rad/s, give --unit {stream.name}=deg/s, if they are"
            " counts, --scale"
        ),
    )


def _moved(stream: Stream, moved: list[Burst], w: int) -> Finding:
    """All bursts of a stream in one finding: when, how long, on which axes."""
    spans: list[list[Burst]] = []
    for burst in sorted(moved, key=lambda b: b.start):
        if spans and burst.start <= max(b.stop for b in spans[-1]):
            spans[-1].append(burst)
        else:
            spans.append([burst])
    strongest = max(spans, key=lambda span: max(b.ratio for b in span))
    start, stop = min(b.start for b in strongest), max(b.stop for b in strongest)
    knocks = all(max(b.stop for b in s) - min(b.start for b in s) <= _KNOCK * w for s in spans)
    axes = tuple(c for c in stream.channels if any(b.channel == c for b in moved))
    changes = {c: _without(stream, c, [b for b in moved if b.channel == c]) for c in axes}
    worst = max(axes, key=lambda c: changes[c][0])
    factor, tau = changes[worst]
    total = sum(max(b.stop for b in s) - min(b.start for b in s) for s in spans)
    several = len(spans) > 1
    what = f"{len(spans)} knocks" if knocks and several else "a knock" if knocks else "motion"
    if several and not knocks:
        what = f"motion {len(spans)} times"
    on = f" on {axes_text(axes)}" if len(axes) > 1 else ""
    times = max(b.ratio for b in strongest)
    message = (
        f"{what}{on}, {length(total, stream)} in all: {'the strongest ' if several else ''}at {when(start, stream)} for"
        f" {length(stop - start, stream)}, samples change {times:.3g} times as much as usual"
    )
    return Finding(
        code="not_static",
        severity="warning",
        channel=axes[0] if len(axes) == 1 else None,
        message=message,
        where=place(start, stream),
        size=times,
        effect=f"{f'{worst}: ' if len(axes) > 1 else ''}{affected(factor)} (at τ = {tau:.3g} s)",
        changes=(("random_walk", factor),) if factor > _MATTERS or factor < 1 / _MATTERS else (),
        remedy=(
            f"{leave_out_option(stream, [(min(b.start for b in s), max(b.stop for b in s)) for s in spans])} takes"
            f" {'them' if several else 'it'} for missing; or record again where nothing moves"
        ),
    )


def _without(stream: Stream, channel: str, moved: list[Burst]) -> tuple[float, float]:
    x = stream.column(channel)
    bad = np.zeros(len(x), dtype=bool)
    for burst in moved:
        bad[burst.start : burst.stop] = True
    return change_of_white(x, bad, stream.grid.tau0)


def _level(stream: Stream, channel: str, changes: list[LevelChange]) -> Finding:
    largest = max(changes, key=lambda change: abs(change.size))
    duration = stream.grid.duration
    # Half the mean square of a step's triangle of differences, Δ²τ/(3T), is what K² = Δ²/T makes: K²τ/3, eq. (21).
    added = sum(change.size**2 for change in changes) / duration
    own, rules = _walk(stream, channel, changes)
    factor = math.sqrt(1 + added / own) if own > 0 else math.inf
    # A bound on the sensor's own walk makes a bound on the factor, and no change of a number.
    said, walk = "", TERMS["rate_random_walk"].label(stream.quantity)
    if math.isfinite(factor):
        said = affected(factor, term=walk)
        if not rules:
            said = f"{factor:.3g} times the sensor's own {walk} or more, of which the record shows a limit only"
    tilt = ""
    if stream.quantity == "acceleration":
        tilt = f" ({math.degrees(abs(largest.size) / 9.80665):.2g} deg, if it is a tilt from level)"
    many = f", the largest of {len(changes)}" if len(changes) > 1 else ""
    return Finding(
        code="not_static",
        severity="warning",
        channel=channel,
        message=(
            f"the level changes by {largest.size:+.3g} {stream.unit}{tilt} at {when(largest.sample, stream)}{many}:"
            f" {largest.times:.3g} standard deviations of what its noise does in {length(largest.window, stream)}"
        ),
        where=place(largest.sample, stream),
        size=abs(largest.size),
        unit=stream.unit,
        effect=(
            f"as much as {'an' if walk[0] == 'a' else 'a'} {walk} of {math.sqrt(added):.3g} {stream.unit}/√s adds to σ at"
            " long τ" + (f": {said}" if said else "")
        ),
        changes=(("rate_random_walk", factor),) if rules and math.isfinite(factor) else (),
        remedy=without_steps(stream, [(c.sample, c.window, c.size) for c in changes]),
    )


def _walk(stream: Stream, channel: str, changes: list[LevelChange]) -> tuple[float, bool]:
    """The channel's own K² with its changes of level taken out, or a bound on it; and whether a walk rules the long times.

    3σ²(τ)/τ is K² where a walk rules, and more elsewhere: other terms only add to it. It then stays the same over octaves;
    bias instability makes it fall by 2 an octave, white noise by 4.
    """
    x = stream.column(channel).copy()
    for change in changes:
        x[change.sample :] -= change.size
    bounds = [3 * avar / (m * stream.grid.tau0) for m, avar, pairs in octaves(x) if pairs >= 16]
    last = bounds[-1 - _RULED_OCTAVES :]
    rules = len(last) > _RULED_OCTAVES and last[0] < _SAME * last[-1]
    return min(bounds, default=0.0), rules
