"""Runs of equal samples: a sensor that sticks, and one that is not there."""

from __future__ import annotations

import math
from dataclasses import replace
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from sigmatau.findings.finding import Finding
from sigmatau.quality.facts import stream_fact
from sigmatau.quality.samples.common import (
    affected,
    axes_text,
    change_of_white,
    growing_step,
    length,
    place,
    present,
    when,
)
from sigmatau.quality.samples.level_walk import added_by_stretches, own_walk, parts_without, walk_effect
from sigmatau.quality.samples.masking import leave_out_option, masked
from sigmatau.quality.samples.repeated_samples import repeats, runs_of_equal
from sigmatau.quality.samples.resolution import resolution
from sigmatau.quality.samples.straight_lines import STRETCH, filled
from sigmatau.record.streams import Stream

__all__ = ["dropouts", "stuck_runs", "stuck_samples", "without_runs", "zero_runs"]

# A run is improbable if noise makes one so long in one of so many records.
_FALSE = 1e-4

# Fewer equal samples are no run, whatever the noise: logs of real sensors have triples for reasons of their own.
_LEAST_RUN = 5

# Rounded noise of 0.15 steps, which may rest for ever, shows 0 to 0.5 steps as its mean lies in a step or between two.
_SEEN = 0.6

# From so long or so large a part of the record on, a coefficient or the time base suffers.
_LONG_S, _SHARE = 1.0, 1e-3

# So large a part of the visits to zero must be runs: a sensor whose range ends at zero is there for single samples too, and
# so is one whose numbers are coarse.
_IN_RUNS = 0.95


def stuck_runs(stream: Stream, channel: str, x: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First samples and lengths of the runs of equal samples that noise does not make.

    A run is too long if n·p^length < 1e-4, where p is the probability that a sample of the white part of the noise falls
    into the very middle of a step: the largest there can be. Where less than 0.6 steps of noise are seen nothing is said:
    then the mean may be near the border of a step, and noise that shows there rests for ever in the middle of one.

    Parameters
    ----------
    stream : Stream
    channel : str
    x : ndarray
        The channel.
    """
    first, lengths = runs_of_equal(x, least=_LEAST_RUN)
    if len(first) == 0 or int(lengths.max()) == len(present(x)) or growing_step(x) > 0:
        return first[:0], lengths[:0]
    found = resolution(stream, channel)

    def limit(times: float) -> float:
        stay = 0.0
        if found is not None:
            if found.ratio < _SEEN:
                return math.inf
            # Rounding makes q²/12 of what is seen; neighbours of quantization noise differ by 3/2 of what white ones do.
            variance = (found.noise**2 * times - found.step**2 / 12) / 1.5
            stay = 2 * NormalDist().cdf(found.step / (2 * math.sqrt(variance))) - 1
        longest = math.log(len(x) / _FALSE) / -math.log(max(stay, 1e-12))
        # Irregular repetition has runs of twice its mean, and rarely more.
        return max(_LEAST_RUN, longest) * (1 if times <= 1 else 2 * times)

    kept = lengths > limit(1.0)
    if kept.any():
        held = repeats(stream)
        if held is not None and channel in held.channels:
            kept = lengths > limit(max(held.times, held.longest / 2))
    return first[kept], lengths[kept]


def zero_runs(stream: Stream, channel: str, x: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First samples and lengths of the runs in which a channel has nothing but the number 0: it was not connected.

    None of a sensor whose range ends at 0, or whose numbers are coarse, which is there for single samples too, and none of
    accumulated values, whose changes are 0 where they stick.
    """
    first, lengths = stuck_runs(stream, channel, x)
    transform = stream.samples.transforms[stream.channels.index(channel)]
    if len(first) == 0 or transform.kind == "accumulated":
        return first[:0], lengths[:0]
    factor = transform.scale * transform.factor / (stream.grid.tau0 if transform.kind != "rate" else 1.0)
    zero = -transform.offset * factor if transform.offset else 0.0
    here = x[first] == zero
    if not here.any():
        return first[:0], lengths[:0]
    at = np.flatnonzero(x == zero)
    alone = np.count_nonzero(np.diff(at) > 1) + 1 - np.count_nonzero(here)
    if alone > (1 - _IN_RUNS) * (alone + np.count_nonzero(here)):
        here[:] = False
    return first[here], lengths[here]


@stream_fact
def without_runs(stream: Stream) -> Stream:
    """The stream with the runs that noise does not make, equal samples and straight lines, taken for missing."""
    mask = np.zeros((stream.grid.n, len(stream.channels)), dtype=bool)
    for k, channel in enumerate(stream.channels):
        x = stream.column(channel)
        for start, size in zip(*(found.tolist() for found in stuck_runs(stream, channel, x)), strict=True):
            mask[start : start + size, k] = True
        lines = filled(stream, channel)
        if lines is not None:
            for at in lines.stretches.tolist():
                mask[lines.first[at] : lines.first[at] + lines.lengths[at], k] = True
    return masked(stream, mask)


def dropouts(stream: Stream) -> list[Finding]:
    """Runs in which a channel has nothing but the number 0: the sensor, or the link to it, was not there.

    Parameters
    ----------
    stream : Stream

    Returns
    -------
    list of Finding
        At most one a channel, or one for several axes; none for a channel that never changes.
    """
    findings = []
    for channel in stream.channels:
        x = stream.column(channel)
        first, lengths = zero_runs(stream, channel, x)
        if len(first):
            added, finding = _stuck(stream, channel, x, first, lengths, zero=True)
            findings.append((added, replace(finding, code="dropout")))
    return _one_for_all(findings)


def stuck_samples(stream: Stream) -> list[Finding]:
    """Runs of equal samples that are improbably long for the step and the noise of a channel.

    Parameters
    ----------
    stream : Stream

    Returns
    -------
    list of Finding
        At most one a channel, or one for several axes; none for a channel that never changes, for runs at an end of the
        range, see `saturation`, and for runs of the number 0, see `dropouts`.
    """
    findings = []
    for channel in stream.channels:
        x = stream.column(channel)
        first, lengths = stuck_runs(stream, channel, x)
        if not len(first):
            continue
        # At an end of the range it is the range that is too small: `saturation` says so.
        gone = zero_runs(stream, channel, x)[0]
        kept = ~np.isin(x[first], (np.nanmin(x), np.nanmax(x))) & ~np.isin(first, gone)
        if kept.any():
            findings.append(_stuck(stream, channel, x, first[kept], lengths[kept]))
    return _one_for_all(findings)


def _one_for_all(findings: list[tuple[float, Finding]]) -> list[Finding]:
    """One finding for several axes: the one of the axis on which the level held is farthest from its own speaks for all."""
    if len(findings) < 2:
        return [finding for _, finding in findings]
    _, worst = max(findings, key=lambda one: one[0])
    channels = axes_text([finding.channel for _, finding in findings if finding.channel])
    matters = any(finding.severity == "warning" for _, finding in findings)
    told = f"{channels}; most on {worst.channel}: {worst.message}"
    return [replace(worst, channel=None, message=told, severity="warning" if matters else "info")]


def _stuck(
    stream: Stream,
    channel: str,
    x: NDArray[np.float64],
    first: NDArray[np.int64],
    lengths: NDArray[np.int64],
    *,
    zero: bool = False,
) -> tuple[float, Finding]:
    """The finding, and what the levels held add to K²."""
    tau0 = stream.grid.tau0
    longest = int(np.argmax(lengths))
    bad = np.zeros(len(x), dtype=bool)
    for start, size in zip(first.tolist(), lengths.tolist(), strict=True):
        bad[start + (not zero) : start + size] = True  # the first that is held is the sensor's own
    share = float(bad.mean())
    factor, tau = change_of_white(x, bad, tau0, beyond=int(lengths.max()))
    equal = "0" if zero else "equal"
    start, size = int(first[longest]), int(lengths[longest])
    kind = "dropouts" if zero else "stuck"
    runs = [(a, a + m) for a, m in zip(first.tolist(), lengths.tolist(), strict=True)]
    many = (
        f"{len(first)} runs of samples that are {equal}, the longest {size}"
        if len(first) > 1
        else f"{size} samples are {equal}"
    )
    first, lengths = first[lengths >= STRETCH], lengths[lengths >= STRETCH]
    walk, added = "", 0.0
    factors: tuple[tuple[str, float], ...] = ()
    if len(first):
        added = added_by_stretches(x, tau0, first, lengths)
        own, rules = own_walk(x, tau0, parts_without(len(x), first.tolist(), (first + lengths).tolist()))
        walk, factors = walk_effect(stream, added, own, rules=rules)
    held = f"; the level held there is {walk}" if walk else ""
    matters = share > _SHARE or size * tau0 >= _LONG_S or abs(factor - 1) > 0.02
    return added, Finding(
        code="stuck_samples",
        severity="warning" if matters else "info",
        channel=channel,
        message=(
            f"{many} ({length(size, stream)}) from {when(start, stream)} on, which its"
            f" noise does not make; {100 * share:.2g} % of the record is {'lost so' if zero else 'stuck'}"
        ),
        where=place(start, stream),
        size=size * tau0,
        unit="s",
        effect=f"{affected(factor)} (at τ = {tau:.3g} s, where the runs count most){held}",
        changes=(("random_walk", factor), *factors),
        remedy=(f"{leave_out_option(stream, runs, kind=kind)} takes these samples for missing"),
    )
