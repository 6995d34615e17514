"""Interpolation: samples that lie on straight lines between others."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sigmatau.findings.finding import Finding
from sigmatau.quality.samples.common import affected, axes_text, block_rms, length, place, sample_of, when
from sigmatau.quality.samples.level_walk import added_by_stretches, own_walk, parts_without, walk_effect
from sigmatau.quality.samples.resolution import resolution
from sigmatau.quality.samples.straight_lines import Filled, filled
from sigmatau.record.streams import Stream

__all__ = ["Upsampling", "interpolated", "upsampling"]

# From here on a coefficient changes noticeably.
_MATTERS = 1.02

_LOOKED_AT = 1 << 15
_LEAST = 64

# So many second differences must be zero beyond those that the step of the numbers makes zero by chance.
_LEAST_SHARE, _SIGMAS = 0.05, 6.0

# With a step so coarse chance and straight lines look alike; and a channel that is one line is not interpolated.
_TOO_COARSE, _A_LINE = 0.15, 0.995

# Rounding of a second difference by double precision, against the samples; and what counts as none against the usual one:
# single precision and printed decimals leave as much, noise is below it in one of 1250 cases.
_EPS = 16 * float(np.finfo(float).eps)
_NOTHING = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Upsampling:
    """How a channel was interpolated.

    Attributes
    ----------
    factor : float
        Rate of the log over that of the sensor.
    aligned : bool
        Whether the sensor's samples are among those of the log.
    share : float
        Part of the samples that lie on the line through their neighbours.
    """

    factor: float
    aligned: bool
    share: float

    @property
    def shortest(self) -> float:
        """σ(τ₀) over that of white noise with the same σ at long τ.

        Slopes s between independent samples of variance v, r apart, have variance 2v/r² and correlation -1/2; a part 1/r
        of the changes is shared out between two of them if the samples are not aligned: σ²(τ₀) = (v/r²)(1 - 1/(2r)),
        aligned v/r², and white noise has v·r.
        """
        r = self.factor
        return math.sqrt((1.0 if self.aligned else 1 - 1 / (2 * r)) / r**3)


def upsampling(stream: Stream, channel: str) -> Upsampling | None:
    """Whether a channel was interpolated linearly, by the second differences that are zero to rounding.

    Parameters
    ----------
    stream : Stream
    channel : str

    Returns
    -------
    Upsampling or None
        None too for a ratio of rates below 2 whose samples are not aligned: then no three samples are on a line.
    """
    x = sample_of(stream, channel, most=_LOOKED_AT)
    first = np.diff(x)
    second = np.diff(first)
    known = np.isfinite(second)
    count = int(np.count_nonzero(known))
    if count < _LEAST:
        return None
    largest = float(np.abs(x[np.isfinite(x)]).max())
    found = resolution(stream, channel)
    step = 0.0 if found is None else found.step
    scale = block_rms(second[np.abs(second) > _EPS * largest])
    tolerance = _EPS * largest + _NOTHING * scale + 2.01 * step
    # Four numbers rounded by up to q/2 each leave 2q.
    chance = 2 * tolerance / (math.sqrt(2 * math.pi) * scale) if scale > 0 else 1.0
    if chance > _TOO_COARSE:
        return None
    # Counts to which a slow bias was added have no common step, but changes of zero as often as lines.
    chance = max(chance, float(np.count_nonzero(np.abs(first) <= tolerance)) / count)
    if chance > _TOO_COARSE:
        return None
    straight = (np.abs(second) <= tolerance) & (np.abs(first[1:]) > tolerance / 2)
    share = float(np.count_nonzero(straight)) / count
    if not _LEAST_SHARE + 3 * chance + _SIGMAS * math.sqrt(chance / count) < share < _A_LINE:
        return None
    knots = np.flatnonzero(known & ~straight)
    runs = np.diff(np.concatenate(([-1], np.flatnonzero(np.diff(knots) > 1), [len(knots) - 1])))
    # A sensor's sample bends the line at one sample of the log if it is one of them, at two if it lies between.
    samples = int(np.sum((runs + 1) // 2))
    return Upsampling(factor=count / samples, aligned=bool(np.median(runs) < 1.5), share=share)


def interpolated(stream: Stream) -> list[Finding]:
    """Channels whose samples were interpolated linearly: all from fewer, or some where others were lost.

    Parameters
    ----------
    stream : Stream

    Returns
    -------
    list of Finding
        One for all channels concerned. Where all were made from fewer, ``changes`` holds the random walk read at one sample
        over the sensor's own; at long τ it is right.
    """
    gaps = {c: f for c in stream.channels if (f := filled(stream, c)) is not None}
    found = {c: u for c in stream.channels if c not in gaps and (u := upsampling(stream, c)) is not None}
    said = []
    if found:
        said.append(_of_fewer(stream, found))
    if gaps:
        told = _of_lost(stream, gaps)
        # One finding a channel: what is wrong everywhere counts for more than what is wrong here and there.
        said = [told] if not found else said
    return said


def _of_fewer(stream: Stream, found: dict[str, Upsampling]) -> Finding:
    channels = tuple(found)
    first = found[channels[0]]
    rate = stream.grid.rate / first.factor
    on = "" if channels == stream.channels else f" on {axes_text(channels)}"
    return Finding(
        code="interpolated",
        severity="warning",
        channel=channels[0] if len(stream.channels) == 1 else None,
        message=(
            f"{100 * first.share:.3g} % of the samples{on} lie on the line through their neighbours:"
            f" interpolated from {rate:.4g} to {stream.grid.rate:.6g} Hz"
        ),
        size=first.factor,
        effect=(
            f"σ at one sample is {first.shortest:.2g} × that of the sensor's white noise, and right only from some"
            f" {math.ceil(8 * first.factor)} samples ({8 / rate:.2g} s) on; a random walk read below that is too small"
        ),
        changes=(("random_walk", first.shortest),),
        remedy="log the sensor's own samples with their own stamps (a driver's interpolation can be switched off)",
    )


def _of_lost(stream: Stream, gaps: dict[str, Filled]) -> Finding:
    tau0 = stream.grid.tau0
    channels = tuple(gaps)
    worst = max(
        channels, key=lambda c: (float(gaps[c].lengths.max()) if len(gaps[c].stretches) else 0, gaps[c].singles)
    )
    one = gaps[worst]
    longest = int(np.argmax(one.lengths))
    start, size = int(one.first[longest]), int(one.lengths[longest])
    texts, effects = [], []
    changes: dict[str, float] = {}
    if (stretches := one.stretches).size:
        many = f"{len(stretches)} stretches, the longest of " if len(stretches) > 1 else ""
        texts.append(
            f"{many}{length(size, stream)} from {when(start, stream)} on, are a straight line between two samples"
        )
        for channel in channels:
            effect, factors = _of_stretches(stream, channel, gaps[channel])
            larger = dict(factors).get("rate_random_walk", 0.0)
            if channel == worst or larger > changes.get("rate_random_walk", 0.0):
                effects = [f"{channel}: {effect}" if len(channels) > 1 else effect]
                changes |= dict(factors)
    singles = one.singles
    if singles:
        texts.append(
            f"{100 * singles:.2g} % of the samples, here and there, lie on the line through their neighbours: lost samples"
            " that were filled in"
        )
        changes["random_walk"] = one.random_walk
        effects.append(
            f"{affected(one.random_walk)} at all averaging times of more than some samples, for those beside a loss count"
            f" for it too; σ at one sample is {one.short:.2f} × the sensor's own"
        )
    end = f" to {(start + size) * tau0:.6g} s" if stretches.size else ""
    return Finding(
        code="interpolated",
        severity="warning" if stretches.size or max(one.random_walk, 1 / one.short) > _MATTERS else "info",
        channel=channels[0] if len(channels) == 1 else None,
        message=f"{axes_text(channels)}: {'; '.join(texts)}",
        where=place(start, stream) + end,
        size=size * tau0 if stretches.size else singles,
        unit="s" if stretches.size else "",
        effect="; ".join(effects),
        changes=tuple(changes.items()),
        remedy="leave lost samples empty in the log, or their rows out: what is missing is never filled in here",
    )


def _of_stretches(stream: Stream, channel: str, gaps: Filled) -> tuple[str, tuple[tuple[str, float], ...]]:
    first, lengths = gaps.first[gaps.stretches], gaps.lengths[gaps.stretches]
    x, tau0 = stream.column(channel), stream.grid.tau0
    added = added_by_stretches(x, tau0, first, lengths)
    own, rules = own_walk(x, tau0, parts_without(len(x), first.tolist(), (first + lengths).tolist()))
    return walk_effect(stream, added, own, rules=rules)
