"""Noise and mean against those of existing sensors: one axis of a triad in another unit, or all of them."""

from __future__ import annotations

import math
from itertools import combinations
from typing import Literal, NamedTuple

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.values import ImplausibleUnit
from sigmatau.noise.terms import TERMS
from sigmatau.quality.samples.common import octaves, pieces, present, sample_of, white_level
from sigmatau.record.streams import Stream

__all__ = [
    "DEGREE",
    "GRAVITY",
    "GRAVITY_TOLERANCE",
    "OPTICAL_NOISE",
    "grade",
    "largest_noise",
    "mean_vector",
    "mixed_units",
    "unit_finding",
    "white_noise",
]

DEGREE = math.pi / 180

GRAVITY = 9.80665  # standard gravity [m/s^2]

GRAVITY_TOLERANCE = 0.12
"""What bias (100 mg) and scale errors (some percent) of consumer accelerometers change of gravity, as a part of it."""


class _Mistake(NamedTuple):
    """A unit that was stated, the one that the samples may be in, and the factor that corrects them."""

    stated: str
    likely: str
    correction: float


# By the factor of the stated unit to SI.
_MISTAKES = {
    "angular_rate": {1.0: _Mistake("rad/s", "deg/s", DEGREE), DEGREE: _Mistake("deg/s", "rad/s", 1 / DEGREE)},
    "acceleration": {1.0: _Mistake("m/s^2", "g", GRAVITY), GRAVITY: _Mistake("g", "m/s^2", 1 / GRAVITY)},
}
_SAME_FACTOR = 1e-6

# Axes of one triad differ in noise by up to 1.5 (z of consumer accelerometers, gyros with a filter of their own): in the
# right units their ratio must be at most 1.6, and in the stated ones at least 6, of the 9.8 of g.
_MAX_RATIO_RIGHT, _MIN_RATIO_WRONG = 1.6, 6.0

# The noisiest gyros of datasheets have 0.1 (deg/s)/√Hz (first MEMS; consumer ones since have 0.004 to 0.03). [rad/s/√Hz]
_NOISIEST_GYRO = 0.1 * DEGREE
_TIMES_NOISIEST = 2.0

OPTICAL_NOISE = 0.01 * DEGREE / 60
"""White noise that only optical gyros are below, whose bias is some deg/h at most: 0.01 deg/√h. [rad/s/√Hz]"""

# Least mean rate that is not a bias of gyros so quiet: three times the Earth's. MEMS have 100 to 10^5 deg/h. [rad/s]
_MIN_MEMS_BIAS = 45 * DEGREE / 3600

_LOOKED_AT = 1 << 17


def mean_vector(stream: Stream) -> float:
    """Length of the mean of all channels. [unit of the stream]"""
    return math.hypot(*(_mean_of(stream, channel) for channel in stream.channels))


def _mean_of(stream: Stream, channel: str) -> float:
    """Mean of the samples that are not missing; NaN if there are none."""
    total, count = 0.0, 0
    for _, x in pieces(stream, channel):
        part = float(x.sum())
        there = x if math.isfinite(part) else present(x)
        total, count = total + float(there.sum()), count + len(there)
    return total / count if count else math.nan


def white_noise(stream: Stream, channel: str) -> float:
    """The least of √τ·σ(τ): the white noise, or a bound on it. [unit of the stream, per √Hz]"""
    level, _ = white_level(sample_of(stream, channel, most=_LOOKED_AT), stream.grid.tau0)
    return math.sqrt(level) if level > 0 else 0.0


def largest_noise(stream: Stream, channel: str, *, least_pairs: int = 0) -> float:
    """The largest of √τ·σ(τ), an upper limit of white noise that faster or slower noise hides; long τ by so many pairs."""
    x, tau0 = sample_of(stream, channel, most=_LOOKED_AT), stream.grid.tau0
    levels = [m * tau0 * avar for m, avar, pairs in octaves(x) if m < 64 or pairs > least_pairs]
    return math.sqrt(max(levels))


def mixed_units(stream: Stream) -> list[Finding]:
    """Axes of a triad that are in another unit than the others, although the same was stated; at most one finding.

    Their white noise differs by about 57.3 (deg/s and rad/s) or 9.80665 (g and m/s²) from that of the others, and in the
    other unit no more than that of axes of one triad does. For accelerometers gravity must then be right.
    """
    if stream.quantity not in _MISTAKES or len(stream.channels) != 3 or stream.grid.source == "simulated":
        return []
    noise = [white_noise(stream, channel) for channel in stream.channels]
    if not all(0 < value < math.inf for value in noise) or max(noise) < _MIN_RATIO_WRONG * min(noise):
        return []
    mistakes = [_mistake(stream, k) for k in range(3)]
    means = [_mean_of(stream, channel) for channel in stream.channels]
    for size in (1, 2):
        for some in combinations(range(3), size):
            corrections = [m.correction if k in some and m is not None else 1.0 for k, m in enumerate(mistakes)]
            right = [value * factor for value, factor in zip(noise, corrections, strict=True)]
            mistake = mistakes[some[0]]
            if mistake is None or any(mistakes[k] is None for k in some) or max(right) > _MAX_RATIO_RIGHT * min(right):
                continue
            level = math.hypot(*(mean * factor for mean, factor in zip(means, corrections, strict=True)))
            if stream.quantity == "acceleration" and not abs(level / GRAVITY - 1) < GRAVITY_TOLERANCE:
                continue
            return _of_axes(stream, some, mistake, noise)
    return []


def _of_axes(stream: Stream, some: tuple[int, ...], mistake: _Mistake, noise: list[float]) -> list[Finding]:
    others = [k for k in range(3) if k not in some]
    ratio = noise[some[0]] / math.prod(noise[k] ** (1 / len(others)) for k in others)
    named = tuple(stream.channels[k] for k in some)
    details = ImplausibleUnit(
        evidence="axes",
        quantity=stream.quantity,
        stated=mistake.stated,
        likely=mistake.likely,
        option=" ".join(f"--unit {channel}={mistake.likely}" for channel in named),
        noise=noise[some[0]],
        times=ratio,
        others=tuple(stream.channels[k] for k in others),
    )
    factors = tuple((term, 1 / mistake.correction) for term in TERMS)
    return [Finding(details=details, severity="warning", channels=named, size=ratio, factors=factors)]


def grade(stream: Stream) -> list[Finding]:
    """Whether the noise of gyros is larger than that of any gyro, or their mean too large for gyros with so little noise."""
    if stream.quantity != "angular_rate" or stream.grid.source == "simulated":
        return []
    noise = sorted(white_noise(stream, channel) for channel in stream.channels)
    if not noise[0] > 0:
        return []
    middle, mean = noise[len(noise) // 2], mean_vector(stream)
    evidence: Literal["noise", "bias"] = "noise"
    if noise[0] > _TIMES_NOISIEST * _NOISIEST_GYRO:
        mistake = _first_mistake(stream, "deg/s")
    else:
        evidence, mistake = "bias", _first_mistake(stream, "rad/s")
        largest = max(largest_noise(stream, channel, least_pairs=200) for channel in stream.channels)
        if mistake is None or not mean > _MIN_MEMS_BIAS or not largest < OPTICAL_NOISE:
            return []
    details = ImplausibleUnit(
        evidence=evidence,
        quantity=stream.quantity,
        stated=mistake.stated if mistake else "",
        likely=mistake.likely if mistake else "",
        option=f"--unit {stream.name}={mistake.likely}" if mistake else "",
        counts=mistake is None,
        noise=middle,
        mean=mean,
        times=middle / _NOISIEST_GYRO if evidence == "noise" else None,
    )
    return unit_finding(stream, details, factor=1 / mistake.correction if mistake else 1.0, size=middle)


def unit_finding(stream: Stream, details: ImplausibleUnit, *, factor: float, size: float) -> list[Finding]:
    """The finding that all coefficients of a stream are wrong by a factor."""
    factors = tuple((term, factor) for term in TERMS)
    channels, unit = stream.channels, stream.unit
    return [Finding(details=details, severity="warning", channels=channels, size=size, unit=unit, factors=factors)]


def _mistake(stream: Stream, k: int) -> _Mistake | None:
    factor = stream.samples.transforms[k].factor
    found = (mistake for of, mistake in _MISTAKES[stream.quantity].items() if abs(factor / of - 1) < _SAME_FACTOR)
    return next(found, None)


def _first_mistake(stream: Stream, likely: str) -> _Mistake | None:
    """The first channel's that may be in a unit."""
    mistakes = (_mistake(stream, k) for k in range(len(stream.channels)))
    return next((mistake for mistake in mistakes if mistake is not None and mistake.likely == likely), None)
