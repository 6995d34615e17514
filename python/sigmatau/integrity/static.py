"""Motion: knocks, vibration that comes and goes, rotation, tilt and other changes of level."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sigmatau.integrity.resolution import resolution
from sigmatau.integrity.samples import affected, axes_text, change_of_white, length, octaves, place, present, when
from sigmatau.results import Finding
from sigmatau.streams import Stream

__all__ = ["Burst", "LevelChange", "bursts", "earth_rate", "level_changes", "not_static"]

EARTH_RATE = 7.292115e-5
"""Sidereal rotation of the Earth. [rad/s]"""

# A mean rate that no bias reaches: 20 deg/s is twice the largest zero-rate offset of consumer sensors' datasheets.
_ROTATION = math.radians(20)

# Length of a window, in seconds and in samples at least.
_WINDOW_S, _WINDOW = 1.0, 16

# Fewer windows than this have no distribution of their own to be far beyond.
_LEAST_WINDOWS = 24

# The cube root of the power of a window is Gaussian to some percent of its spread (Wilson and Hilferty, PNAS 17, 1931). Its
# centre and spread are the median and the MAD of all windows. 8 of those, and power four times the usual: noise of 10^4
# windows goes to 4.5, and no less than 16 samples reach four times their usual power by chance (χ² with 10 degrees: 3.5
# in 10^4 windows, spread of the MAD included).
_FAR, _POWER = 8.0, 4.0

# A spike makes two large changes; of two spikes all may be in one window.
_PEAKS = 4

# Differences of neighbouring windows' means are Gaussian for each of the five terms, whatever the window; a term only
# chooses their variance. Robust z of n of them passes this a·(1 + b/n) in less than 1e-5 of records (measured, n ≥ 24).
_FAR_LEVEL, _FEW = 7.0, 12.0

# Rounding moves a mean by one step at most.
_STEPS = 1.5

# Windows that belong together are no further apart.
_TOGETHER_S = 5.0

# A burst of no more windows is a knock.
_KNOCK = 3

# A level holds if the change is there, to this part, in the medians of as many half windows before and after.
_HOLDS, _AHEAD = 0.6, 6

# From here on a coefficient changes noticeably.
_MATTERS = 1.02


@dataclass(frozen=True, slots=True, kw_only=True)
class Burst:
    """A stretch of one channel in which it moves.

    Attributes
    ----------
    channel : str
    start, stop : int
        Samples, stop not included.
    ratio : float
        Largest root mean square of the samples' changes in a window, over the usual one.
    """

    channel: str
    start: int
    stop: int
    ratio: float


@dataclass(frozen=True, slots=True, kw_only=True)
class LevelChange:
    """A change of level that holds.

    Attributes
    ----------
    channel : str
    sample : int
        Where, to half the window.
    size : float
        New level less the old one. [unit of the stream]
    window : int
        Samples in the windows that show it most clearly.
    times : float
        How many standard deviations of what the noise does between such windows.
    """

    channel: str
    sample: int
    size: float
    window: int
    times: float


def _window(stream: Stream) -> int:
    return max(round(_WINDOW_S / stream.grid.tau0), _WINDOW)


def _summaries(stream: Stream, channel: str) -> tuple[NDArray[np.float64], NDArray[np.float64], int, float]:
    """Mean of each window less the first sample, mean square of its samples' changes; samples in a window; first sample.

    NaN where half of a window is missing.
    """
    w = _window(stream)
    c, n = stream.channels.index(channel), stream.grid.n // w * w
    many = max((1 << 16) // w, 1) * w
    means, powers = [], []
    first = 0.0
    for start in range(0, n, many):
        x = stream.samples.read(c, start, min(start + many, n)).reshape(-1, w)
        if start == 0:
            first = float(present(x.ravel())[0]) if np.isfinite(x).any() else 0.0
        x = x - first  # a large level would cost digits
        steps = np.diff(x, axis=1)
        power = np.einsum("ij,ij->i", steps, steps) / (w - 1)
        mean = np.einsum("ij->i", x) / w
        gaps = np.flatnonzero(~np.isfinite(mean))
        for i in gaps.tolist():
            there = present(x[i])
            changes = present(steps[i])
            enough = len(there) >= w / 2 and len(changes) > 0
            mean[i] = there.mean() if enough else np.nan
            power[i] = (changes @ changes) / len(changes) if enough else np.nan
        means.append(mean)
        powers.append(power)
    if not means:
        return np.zeros(0), np.zeros(0), w, 0.0
    return np.concatenate(means), np.concatenate(powers), w, first


def _centre_and_spread(x: NDArray[np.float64]) -> tuple[float, float]:
    x = present(x)
    centre = float(np.median(x))
    return centre, 1.4826 * float(np.median(np.abs(x - centre)))


def bursts(stream: Stream, channel: str) -> list[Burst]:
    """Stretches in which the samples of a channel change far more than usual.

    The mean square of the changes from sample to sample in windows of 1 s (16 samples at least) against its own
    distribution over the record; slow terms hardly enter it.

    Parameters
    ----------
    stream : Stream
    channel : str

    Returns
    -------
    list of Burst
        In order of time; none for fewer than 24 windows.
    """
    _, power, w, _ = _summaries(stream, channel)
    return _bursts(stream, channel, power, w)


def _bursts(stream: Stream, channel: str, power: NDArray[np.float64], w: int) -> list[Burst]:
    if np.count_nonzero(np.isfinite(power)) < _LEAST_WINDOWS:
        return []
    root = np.cbrt(power)
    centre, spread = _centre_and_spread(root)
    usual = centre**3
    limit = max(centre + _FAR * spread, np.cbrt(_POWER * usual))
    if not np.any(root > limit):
        return []
    found = resolution(stream, channel)
    step = 0.0 if found is None else found.step
    # Values that go to and fro between two steps change by one step at each sample.
    at = np.flatnonzero(power > max(limit**3, _POWER * step**2))
    at = at[[_without_peaks(stream, channel, int(i), w) > limit**3 for i in at]]
    if len(at) == 0:
        return []
    apart = max(round(_TOGETHER_S / (w * stream.grid.tau0)), 1)
    groups = np.split(at, np.flatnonzero(np.diff(at) > apart) + 1)
    floor = max(usual, step**2 / 12)
    return [
        Burst(
            channel=channel,
            start=int(g[0]) * w,
            stop=(int(g[-1]) + 1) * w,
            ratio=math.sqrt(float(np.max(power[g])) / floor) if floor > 0 else math.inf,
        )
        for g in groups
    ]


def _without_peaks(stream: Stream, channel: str, window: int, w: int) -> float:
    """Mean square of the changes in a window but for the largest four, which one or two spikes make."""
    x = stream.samples.read(stream.channels.index(channel), window * w, (window + 1) * w)
    squares = np.sort(present(np.diff(x)) ** 2)[:-_PEAKS]
    return float(squares.mean()) if len(squares) else 0.0


def level_changes(stream: Stream, channel: str) -> list[LevelChange]:
    """Changes of a channel's level that its noise does not make, and that hold.

    Differences of the means of neighbouring windows of 2 s, 4 s, 8 s, … are Gaussian with the variance 2σ²(τ), for a pure
    rate random walk and for flicker noise as for white noise. A change shows as one of them far beyond all others at the
    same τ; where several windows show it, the one that does so most clearly counts.

    Parameters
    ----------
    stream : Stream
    channel : str

    Returns
    -------
    list of LevelChange
        In order of time; none for fewer than 48 s.
    """
    mean, _, w, _ = _summaries(stream, channel)
    return _level_changes(stream, channel, mean, w)


def _level_changes(stream: Stream, channel: str, mean: NDArray[np.float64], w: int) -> list[LevelChange]:
    step: float | None = None
    found: list[LevelChange] = []
    half, shortest = mean, w  # means of half windows, so that no change is shared out worse than 3 to 1
    while len(half) >= 2 * _LEAST_WINDOWS:
        window = half[1:] + half[:-1]
        differences = (window[2:] - window[:-2]) / 2
        known = int(np.count_nonzero(np.isfinite(differences)))
        if known < _LEAST_WINDOWS:
            break
        centre, spread = _centre_and_spread(differences)
        far = np.abs(differences - centre)
        limit = _FAR_LEVEL * (1 + _FEW / known) * spread
        if np.any(far > limit):
            if step is None:
                resolved = resolution(stream, channel)
                step = 0.0 if resolved is None else resolved.step
            limit = max(limit, _STEPS * step)
            for i in np.flatnonzero(far > limit).tolist():
                before = present(half[max(i + 2 - _AHEAD, 0) : i + 2])
                after = present(half[i + 2 : i + 2 + _AHEAD])
                if len(before) < 2 or len(after) < 2:
                    continue
                size = float(np.median(after) - np.median(before))
                if size * differences[i] > 0 and abs(size) > _HOLDS * abs(differences[i]):
                    times = float(far[i]) / spread if spread > 0 else math.inf
                    at = _where(mean, (i + 2) * w // shortest, w // shortest) * shortest
                    found.append(LevelChange(channel=channel, sample=at, size=size, window=2 * w, times=times))
        even = len(half) // 2 * 2
        half = (half[0:even:2] + half[1:even:2]) / 2
        w *= 2
    kept: list[LevelChange] = []
    for change in sorted(found, key=lambda change: -change.times):
        if all(abs(change.sample - other.sample) > 3 * max(change.window, other.window) for other in kept):
            kept.append(change)
    return sorted(kept, key=lambda change: change.sample)


def _where(mean: NDArray[np.float64], about: int, around: int) -> int:
    """The shortest window before which a level ends, by least squares of two levels about a place."""
    start = max(about - 2 * around, 0)
    x = mean[start : about + 2 * around]
    x = np.where(np.isfinite(x), x, np.median(present(x)))
    k = np.arange(1, len(x))
    sums = np.cumsum(x)
    explained = (sums[:-1] - sums[-1] * k / len(x)) ** 2 / (k * (len(x) - k))
    return start + 1 + int(np.argmax(explained))


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
    findings = []
    for channel in stream.channels:
        mean, power, w, first = _summaries(stream, channel)
        rates[channel] = abs(first + float(np.mean(present(mean)))) if np.isfinite(mean).any() else 0.0
        moved += _bursts(stream, channel, power, w)
        changes = _level_changes(stream, channel, mean, w)
        if changes:
            changed[channel] = changes
    rotating = _rotation(stream, rates)
    if rotating is not None:
        return [rotating]
    if moved:
        findings.append(_moved(stream, moved))
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
            f"record at rest; if these are {mean:.3g} deg/s or counts rather than rad/s, say so with --unit or --scale"
        ),
    )


def _moved(stream: Stream, moved: list[Burst]) -> Finding:
    """All bursts of a stream in one finding: when, how long, on which axes."""
    tau0 = stream.grid.tau0
    spans: list[list[Burst]] = []
    for burst in sorted(moved, key=lambda b: b.start):
        if spans and burst.start <= max(b.stop for b in spans[-1]):
            spans[-1].append(burst)
        else:
            spans.append([burst])
    strongest = max(spans, key=lambda span: max(b.ratio for b in span))
    start, stop = min(b.start for b in strongest), max(b.stop for b in strongest)
    w = _window(stream)
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
            f"analyse a window without {'them' if several else 'it'} (--window), or record again where nothing moves;"
            f" {start * tau0:.6g} s to {stop * tau0:.6g} s is the strongest"
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
    own = _walk(stream, channel, changes)
    factor = math.sqrt(1 + added / own) if own > 0 else math.inf
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
            f"as much as a rate random walk of {math.sqrt(added):.3g} {stream.unit}/√s adds to σ at long τ"
            + (f": {affected(factor, term='rate random walk')}" if math.isfinite(factor) else "")
        ),
        changes=(("rate_random_walk", factor),) if math.isfinite(factor) else (),
        remedy="analyse a window that ends before it or begins after it (--window)",
    )


def _walk(stream: Stream, channel: str, changes: list[LevelChange]) -> float:
    """The least 3σ²(τ)/τ of the channel with its changes of level taken out: K² or more, for other terms only add to it."""
    x = stream.column(channel).copy()
    for change in changes:
        x[change.sample :] -= change.size
    bounds = [3 * avar / (m * stream.grid.tau0) for m, avar, pairs in octaves(x) if pairs >= 16]
    return min(bounds, default=0.0)


def earth_rate(stream: Stream, *, bias: float) -> list[Finding]:
    """Whether the mean of a gyro triad can be the rotation of the Earth.

    Parameters
    ----------
    stream : Stream
        Three orthogonal gyros.
    bias : float
        What the constant bias of each gyro may be at most, by its datasheet. [rad/s]

    Returns
    -------
    list of Finding
        Empty if the stream is no triad of gyros, or if bias and noise are together larger than a fifth of the Earth's
        rate, so that nothing could be said.
    """
    if stream.quantity != "angular_rate" or len(stream.channels) != 3:
        return []
    means, variance = [], 0.0
    for channel in stream.channels:
        x = stream.column(channel)
        means.append(float(np.mean(present(x))) if np.isfinite(x).any() else math.nan)
        levels = [avar for _, avar, _ in octaves(x)]
        # σ²(τ) at the longest τ is no less than the variance of the mean, for white noise; for slower noise it is near.
        variance += levels[-1] if levels else math.inf
    spread = 2 * math.sqrt(variance) + math.sqrt(3) * bias
    rate = math.sqrt(math.fsum(m * m for m in means))
    if not spread < EARTH_RATE / 5:
        return []
    agrees = abs(rate - EARTH_RATE) <= spread
    return [
        Finding(
            code="earth_rate",
            severity="info" if agrees else "warning",
            message=(
                f"the mean rate is {math.degrees(rate) * 3600:.4g} deg/h, that of the Earth 15.04 deg/h; noise and a bias of"
                f" {math.degrees(bias) * 3600:.3g} deg/h allow ± {math.degrees(spread) * 3600:.2g} deg/h"
            ),
            size=rate,
            unit=stream.unit,
            effect=(
                "" if agrees else "unit or scale is wrong, the bias is larger than stated, or the sensor does not rest"
            ),
            remedy="" if agrees else "check --unit and --scale",
        )
    ]
