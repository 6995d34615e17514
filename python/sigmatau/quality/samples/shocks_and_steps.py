"""Motion: knocks, vibration that comes and goes, rotation, tilt and other changes of level."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sigmatau.findings.finding import Finding
from sigmatau.quality.facts import stream_fact
from sigmatau.quality.samples.common import affected, axes_text, length, place, present, when, worst_on_white
from sigmatau.quality.samples.level_walk import own_walk, parts_without, walk_effect
from sigmatau.quality.samples.masking import leave_out_option, without_steps
from sigmatau.quality.samples.motion import Burst, LevelChange, Summary, bursts, excursions, level_changes, summary
from sigmatau.record.streams import Stream

__all__ = ["Movements", "level_finding", "movements", "not_static"]

# A mean rate that no bias reaches: 20 deg/s is twice the largest zero-rate offset of consumer sensors' datasheets.
_ROTATION = math.radians(20)

# A burst of no more windows is a knock.
_KNOCK = 3

# From here on a coefficient changes noticeably.
_MATTERS = 1.02

# A level that changes by less than this part of what it went away by has come back.
_STAYS = 0.5

# So many changes of level are told with their times, the largest.
_TOLD = 8


def not_static(stream: Stream, *, judged: Stream | None = None, knocks: Sequence[Burst] = ()) -> list[Finding]:
    """Motion of a sensor that should rest: rotation, knocks and other bursts, changes of level (tilt).

    Parameters
    ----------
    stream : Stream
        Angular rates or accelerations; of other signals nothing is said.
    judged : Stream, optional
        The same without spikes, in which motion is looked for; effects are those on the stream itself.
    knocks : sequence of Burst
        That are known already, see `sigmatau.quality.samples.light_shocks`.

    Returns
    -------
    list of Finding
        At most one a channel and one for several axes together.
    """
    if stream.quantity not in ("angular_rate", "acceleration"):
        return []
    seen = movements(stream if judged is None else judged)
    findings = []
    rotating = _rotation(stream, seen.rates)
    if rotating is not None:
        return [rotating]
    moved, changed = [*seen.moved, *_apart(knocks, seen.moved)], seen.changed
    if moved:
        findings.append(_moved(stream, moved, seen.window, light=not seen.moved))
    alone = findings[0].channel if findings else None
    for channel, changes in changed.items():
        finding = level_finding(stream, channel, changes)
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


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Movements:
    """Where the channels of a stream move.

    Attributes
    ----------
    moved : list of Burst
    changed : dict of str to list of LevelChange
        By channel, of those that have any.
    rates : dict of str to float
        Size of the mean, by channel.
    window : int
        Samples in a window.
    """

    moved: list[Burst]
    changed: dict[str, list[LevelChange]]
    rates: dict[str, float]
    window: int


def _apart(knocks: Sequence[Burst], moved: Sequence[Burst]) -> list[Burst]:
    """Knocks that are not found as motion of their axis already."""
    return [
        knock
        for knock in knocks
        if not any(m.channel == knock.channel and m.start < knock.stop and knock.start < m.stop for m in moved)
    ]


@stream_fact
def movements(stream: Stream) -> Movements:
    """Bursts, excursions and changes of level of each channel."""
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
        if changes:  # the way out and back of a rotation of some seconds is no change that holds
            gone = excursions(stream, seen)
            changes = [change for change in changes if not any(_comes_back(seen, change, one) for one in gone)]
        if changes:
            changed[channel] = changes
        moved += excursions(stream, seen, changes)
    return Movements(moved=moved, changed=changed, rates=rates, window=window)


def _comes_back(seen: Summary, change: LevelChange, one: Burst) -> bool:
    """Whether a change of level is part of an excursion after which the level is what it was before."""
    size = one.stop - one.start
    if not one.start - 2 * size <= change.sample <= one.stop + 2 * size:
        return False
    w = seen.window
    before = present(seen.mean[max(one.start - 6 * size, 0) // w : max(one.start - 2 * size, 0) // w])
    after = present(seen.mean[(one.stop + 2 * size) // w : (one.stop + 6 * size) // w])
    if not (len(before) and len(after)):
        return False
    return abs(float(np.median(after) - np.median(before))) < _STAYS * abs(change.size)


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


def _moved(stream: Stream, moved: list[Burst], w: int, *, light: bool) -> Finding:
    """All bursts of a stream in one finding: when, how long, on which axes."""
    spans: list[list[Burst]] = []
    for burst in sorted(moved, key=lambda b: b.start):
        if spans and burst.start <= max(b.stop for b in spans[-1]):
            spans[-1].append(burst)
        else:
            spans.append([burst])
    strongest = max(spans, key=lambda span: max(b.ratio for b in span))
    start, stop = min(b.start for b in strongest), max(b.stop for b in strongest)
    knocks = all(
        max(b.stop for b in s) - min(b.start for b in s) <= _KNOCK * w and not all(b.away for b in s) for s in spans
    )
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
    shown = f"samples change {times:.3g} times as much as usual"
    farthest = max(strongest, key=lambda b: b.ratio)
    if farthest.away:
        shown = (
            f"the mean goes away by {farthest.away:.3g} {stream.unit} and comes back, {times:.3g} standard deviations of"
            " what the noise does"
        )
    message = (
        f"{what}{on}, {length(total, stream)} in all: {'the strongest ' if several else ''}at {when(start, stream)} for"
        f" {length(stop - start, stream)}, {shown}"
    )
    return Finding(
        code="not_static",
        severity="info" if light and factor < _MATTERS else "warning",
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
    return worst_on_white(x, bad, stream.grid.tau0)


def level_finding(stream: Stream, channel: str, changes: Sequence[LevelChange]) -> Finding:
    """The finding that a channel's level changes: when, by how much, and what that adds to the rate random walk."""
    largest = max(changes, key=lambda change: abs(change.size))
    tau0 = stream.grid.tau0
    # Half the mean square of a step's triangle of differences, Δ²τ/(3T), is what K² = Δ²/T makes: K²τ/3, eq. (21).
    added = sum(change.size**2 for change in changes) / stream.grid.duration
    around = [
        (max(change.sample - change.around, 0), min(change.sample + change.around, stream.grid.n)) for change in changes
    ]
    between = parts_without(stream.grid.n, [a for a, _ in around], [b for _, b in around])
    own, rules = own_walk(stream.column(channel), tau0, between)
    effect, factors = walk_effect(stream, added, own, rules=rules)
    tilt = ""
    if stream.quantity == "acceleration":
        tilt = f" ({math.degrees(abs(largest.size) / 9.80665):.2g} deg, if it is a tilt from level)"
    shown = sorted(sorted(changes, key=lambda change: -abs(change.size))[:_TOLD], key=lambda change: change.sample)
    others = ", ".join(f"{change.size:+.3g} at {when(change.sample, stream)}" for change in shown if change != largest)
    many = f", the largest of {len(changes)}" if len(changes) > 1 else ""
    return Finding(
        code="not_static",
        severity="warning",
        channel=channel,
        message=(
            f"the level {'drifts' if largest.gradual else 'changes'} by {largest.size:+.3g} {stream.unit}{tilt}"
            f" {'about' if largest.gradual else 'at'} {when(largest.sample, stream)}{many}:"
            f" {largest.times:.3g} standard deviations of what its noise does in {length(largest.window, stream)}"
            + (f"; also by {others}{'' if len(shown) == len(changes) else ' and more'}" if others else "")
        ),
        where=", ".join(place(change.sample, stream) for change in shown).replace(", t = ", ", "),
        size=abs(largest.size),
        unit=stream.unit,
        effect=effect,
        changes=factors,
        remedy=without_steps(stream, [(c.sample, c.window, c.size) for c in changes]),
    )
