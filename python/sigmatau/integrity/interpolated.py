"""Interpolation: samples that lie on straight lines between others."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sigmatau.integrity.resolution import resolution
from sigmatau.integrity.samples import axes_text, block_rms, sample_of
from sigmatau.results import Finding
from sigmatau.streams import Stream

__all__ = ["Upsampling", "interpolated", "upsampling"]

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
    """Channels whose samples were interpolated linearly from fewer.

    Parameters
    ----------
    stream : Stream

    Returns
    -------
    list of Finding
        One for all channels concerned. ``changes`` holds the random walk read at one sample over the sensor's own; at long
        τ it is right.
    """
    found = {c: u for c in stream.channels if (u := upsampling(stream, c)) is not None}
    if not found:
        return []
    channels = tuple(found)
    first = found[channels[0]]
    rate = stream.grid.rate / first.factor
    on = "" if channels == stream.channels else f" on {axes_text(channels)}"
    return [
        Finding(
            code="interpolated",
            severity="warning",
            channel=channels[0] if len(stream.channels) == 1 else None,
            message=(
                f"{100 * first.share:.3g} % of the samples{on} lie on the line through their neighbours: interpolated from"
                f" {rate:.4g} to {stream.grid.rate:.6g} Hz"
            ),
            size=first.factor,
            effect=(
                f"σ at one sample is {first.shortest:.2g} × that of the sensor's white noise, and right only from some"
                f" {math.ceil(8 * first.factor)} samples ({8 / rate:.2g} s) on; a random walk read below that is too small"
            ),
            changes=(("random_walk", first.shortest),),
            remedy="log the sensor's own samples with their own stamps (a driver's interpolation can be switched off)",
        )
    ]
