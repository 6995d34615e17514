"""Noise and mean against those of sensors there are: one axis of a triad in another unit, or all of them."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np

from sigmatau.findings.finding import Finding
from sigmatau.noise.terms import TERMS
from sigmatau.quality.samples.common import axes_text, octaves, pieces, present, sample_of, white_level
from sigmatau.record.streams import Stream

__all__ = ["QUIET", "grade", "mean_of", "mixed_units"]

_DEG = math.pi / 180
_G = 9.80665

# Of a unit that is stated, the one that it is taken for: its factor to SI, by which the samples have to be multiplied, words
# and the option's value.
_INSTEAD = {
    "angular_rate": (
        (1.0, _DEG, "deg/s where rad/s was stated", "deg/s"),
        (_DEG, 1 / _DEG, "rad/s where deg/s was stated", "rad/s"),
    ),
    "acceleration": (
        (1.0, _G, "g where m/s^2 was stated", "g"),
        (_G, 1 / _G, "m/s^2 where g was stated", "m/s^2"),
    ),
}

# Axes of one triad differ in noise by up to 1.5 (z of consumer accelerometers, gyros with a filter of their own): in the
# right units they must be that near each other, to 1.6, and in the stated ones further apart than any, 6 of the 9.8 of g.
_ALIKE, _APART = 1.6, 6.0

# What bias and scale leave of gravity.
_NEAR = 0.12

# The noisiest gyros of datasheets have 0.1 (deg/s)/√Hz (first MEMS; consumer ones since have 0.004 to 0.03): none has twice
# that.
_NOISIEST = 0.2 * _DEG

# Below 0.01 deg/√h there are optical gyros alone, whose bias is some deg/h at the most; MEMS have biases of 100 to 10^5
# deg/h. So a mean of 45 deg/h, three times the Earth's rate, is none of a gyro so quiet.
QUIET, _BIASED = 0.01 * _DEG / 60, 45 * _DEG / 3600

_LOOKED_AT = 1 << 17
_SAME = 1e-6


def mean_of(stream: Stream, channel: str) -> float:
    """Mean of the samples that are there; NaN of none."""
    total, count = 0.0, 0
    for _, x in pieces(stream, channel):
        part = float(x.sum())
        there = x if math.isfinite(part) else present(x)
        total, count = total + float(there.sum()), count + len(there)
    return total / count if count else math.nan


def mixed_units(stream: Stream) -> list[Finding]:
    """Axes of a triad that are in another unit than the others, though the same was stated.

    Their white noise is off by 57.3 (deg/s and rad/s) or 9.80665 (g and m/s²) from that of the others, as near as axes of
    one triad are alike, and in the other unit it is not; of accelerometers gravity must then be right.

    Parameters
    ----------
    stream : Stream
        Three gyros or accelerometers, of a log; of simulated ones, whose axes are as they were wished, nothing is said.

    Returns
    -------
    list of Finding
        At most one ``"implausible_unit"``; ``changes`` are those of the axes that it names.
    """
    if stream.quantity not in _INSTEAD or len(stream.channels) != 3 or stream.grid.source == "simulated":
        return []
    noise = [_noise(stream, channel) for channel in stream.channels]
    if not all(0 < value < math.inf for value in noise) or max(noise) < _APART * min(noise):
        return []
    instead = [_instead(stream, k) for k in range(3)]
    means = [mean_of(stream, channel) for channel in stream.channels]
    for size in (1, 2):
        for some in combinations(range(3), size):
            if any(instead[k] is None for k in some):
                continue
            factors = [one[1] if (one := instead[k]) is not None and k in some else 1.0 for k in range(3)]
            right = [value * factor for value, factor in zip(noise, factors, strict=True)]
            if max(right) > _ALIKE * min(right):
                continue
            level = math.sqrt(math.fsum((mean * factor) ** 2 for mean, factor in zip(means, factors, strict=True)))
            if stream.quantity == "acceleration" and not abs(level / _G - 1) < _NEAR:
                continue
            return [_of_axes(stream, some, noise, factors)]
    return []


def _of_axes(stream: Stream, some: tuple[int, ...], noise: list[float], factors: list[float]) -> Finding:
    found = _instead(stream, some[0])
    _, factor, words, unit = found if found is not None else (1.0, 1.0, "", "")
    others = [k for k in range(3) if k not in some]
    ratio = noise[some[0]] / math.sqrt(math.prod(noise[k] ** (2 / len(others)) for k in others))
    named = [stream.channels[k] for k in some]
    option = " ".join(f"--unit {channel}={unit}" for channel in named)
    times = f"{ratio:.3g} times that" if ratio > 1 else f"1/{1 / ratio:.3g} of that"
    return Finding(
        code="implausible_unit",
        severity="warning",
        channel=named[0] if len(named) == 1 else None,
        message=(
            f"the white noise of {axes_text(named)} is {times} of {axes_text([stream.channels[k] for k in others])}:"
            f" {'the samples look' if len(named) == 1 else 'these look'} like {words}"
        ),
        size=ratio,
        effect=f"if so, every coefficient of {axes_text(named)} is {1 / factor:.4g} × the sensor's own",
        changes=tuple((term, 1 / factor) for term in TERMS),
        remedy=f"give {option}",
    )


def grade(stream: Stream) -> tuple[str, float, float, str] | None:
    """Whether the noise of a gyro triad is none of a gyro, or its mean none of a gyro so quiet.

    Parameters
    ----------
    stream : Stream
        Angular rates.

    Returns
    -------
    tuple of (str, float, float, str), or None
        What was found, in words; the noise [rad/s/√Hz]; by which factor coefficients are too large; and the option to give.
        None for plausible ones.
    """
    if stream.quantity != "angular_rate" or stream.grid.source == "simulated":
        return None
    noise = sorted(value for channel in stream.channels if (value := _noise(stream, channel)) > 0)
    if len(noise) < len(stream.channels):
        return None
    instead = [_instead(stream, k) for k in range(len(stream.channels))]
    axes, middle = axes_text(stream.channels), noise[len(noise) // 2]
    said = f"{middle / _DEG:.3g} (deg/s)/√Hz"
    if noise[0] > _NOISIEST:
        unit = next((one for one in instead if one is not None and one[1] < 1), None)
        message = (
            f"white noise of {axes} is {said}, {middle / _NOISIEST * 2:.2g} times that of the noisiest gyros there are"
        )
        if unit is None:
            return f"{message}: the samples may be counts", middle, 1.0, "--scale for counts"
        return f"{message}: the samples look like {unit[2]}", middle, 1 / unit[1], f"--unit {stream.name}={unit[3]}"
    level = math.sqrt(math.fsum(mean_of(stream, channel) ** 2 for channel in stream.channels))
    unit = next((one for one in instead if one is not None and one[1] > 1), None)
    most = max(_largest(stream, channel) for channel in stream.channels)
    if most < QUIET and level > _BIASED and unit is not None:
        message = (
            f"white noise of {axes} is {said}, as of optical gyros, and their mean {math.degrees(level) * 3600:.3g} deg/h,"
            f" which is the bias of none of them: the samples look like {unit[2]}"
        )
        return message, middle, 1 / unit[1], f"--unit {stream.name}={unit[3]}"
    return None


def _instead(stream: Stream, k: int) -> tuple[float, float, str, str] | None:
    factor = stream.samples.transforms[k].factor
    return next((one for one in _INSTEAD[stream.quantity] if abs(factor / one[0] - 1) < _SAME), None)


def _noise(stream: Stream, channel: str) -> float:
    """The least of √τ·σ(τ), no less than the white noise there is. [unit of the stream, per √Hz]"""
    level, _ = white_level(sample_of(stream, channel, most=_LOOKED_AT), stream.grid.tau0)
    return math.sqrt(level) if level > 0 else 0.0


def _largest(stream: Stream, channel: str) -> float:
    """The largest of √τ·σ(τ), which white noise is no more than where something faster or slower hides it."""
    x, tau0 = sample_of(stream, channel, most=_LOOKED_AT), stream.grid.tau0
    return math.sqrt(float(np.max([m * tau0 * avar for m, avar, pairs in octaves(x) if m < 64 or pairs > 200])))
