"""Units: gravity where it should be, noise that a sensor can have, steps that a sensor is known for."""

from __future__ import annotations

import math

import numpy as np

from sigmatau.findings.finding import Finding
from sigmatau.noise.terms import TERMS
from sigmatau.quality.samples.common import axes_text, octaves, present, sample_of, white_level
from sigmatau.quality.samples.resolution import resolution
from sigmatau.quality.samples.sensor_grades import QUIET, grade, mean_of, mixed_units
from sigmatau.record.streams import PLAUSIBLE_RATES, Stream

__all__ = ["EARTH_RATE", "earth_rate", "gravity", "implausible_unit"]

EARTH_RATE = 7.292115e-5
"""Sidereal rotation of the Earth. [rad/s]"""

# Gyros of an unknown bias whose mean is less than this part of the Earth's rate: on three axes at once the biases would have
# to be what the Earth makes there with the other sign. Gaussian ones do so in 1.2 % at the most, where their standard
# deviation is 8.7 deg/h.
_TAKEN_OFF = 1 / 3

_G = 9.80665

# Gravity on the ground: 9.764 (Huascarán) to 9.834 m/s² (Arctic Ocean); J. Hirt et al., GRL 40 (2013).
_ON_GROUND = (9.75, 9.85)

# What bias (100 mg) and scale errors (some percent) of consumer accelerometers leave of it.
_NEAR = 0.12

# What |mean| is if the numbers are in one unit and another was stated: value where gravity would be 9.80665, the words, and
# the factor by which every coefficient is then larger than the sensor's own.
_MISTAKEN: tuple[tuple[float, str, str], ...] = (
    (1.0, "g where m/s^2 was stated", "--unit accel=g"),
    (_G**2, "m/s^2 where g was stated", "--unit accel=m/s^2"),
    (1000.0, "mg where m/s^2 was stated", "--unit accel=mg"),
    (100 * _G, "cm/s^2 (Gal) where m/s^2 was stated", "--scale accel=0.01"),
    (1000 * _G, "mg where g was stated", "--unit accel=mg"),
    (_G / 0.3048, "ft/s^2 where m/s^2 was stated", "--unit accel=ft/s^2"),
)

# Without gravity: less than any single-axis bias of a sensor that is worth an Allan variance.
_NONE = 0.5

# White noise of sensors there are, best to worst, and a factor of ten on either side. Gyros: 1e-5 deg/√h (hemispherical
# resonators) to 1 (deg/s)/√Hz; accelerometers: 1 ng/√Hz (seismic) to 10 mg/√Hz.
_DEG = math.pi / 180
_GRADES = {
    "angular_rate": (1e-6 * _DEG / 60, 10 * _DEG),
    "acceleration": (1e-10 * _G, 0.1 * _G),
}

# Steps that sensors are known for, in deg/s, from datasheets: InvenSense MPU and ICM (131 to 16.4 LSB per deg/s), Bosch BMI
# (262.144 to 16.384), ST LSM and L3G (4.375 to 70 mdps). Steps that a rounded decimal could be too are left out.
_STEPS_DPS = (
    *(1 / 131 * k for k in (1, 131 / 65.5, 131 / 32.8, 131 / 16.4)),
    *(2.0**k / 262.144 for k in range(5)),
    4.375e-3,
    8.75e-3,
    17.5e-3,
)
_SAME_STEP = 1e-4

_LOOKED_AT = 1 << 17


def implausible_unit(stream: Stream) -> list[Finding]:
    """Signs that the samples are in another unit than stated.

    An accelerometer triad at rest measures gravity: |mean| near 1 is in g. One axis with 57.3 or 9.8 times the noise of the
    other two, see `mixed_units`; gyros noisier than any, or with a bias that gyros so quiet have not, see `grade`; white
    noise more than ten times beyond the best and the worst sensors there are, or a step of the numbers that is known from
    datasheets in the other unit, tells deg/s from rad/s.

    Parameters
    ----------
    stream : Stream
        Angular rates or accelerations; of other signals nothing is said.

    Returns
    -------
    list of Finding
        At most one; ``changes`` names all terms with the factor of the unit.
    """
    if mixed := mixed_units(stream):
        return mixed
    of_rate = not PLAUSIBLE_RATES[0] <= stream.grid.rate <= PLAUSIBLE_RATES[1]
    if of_rate and stream.samples.transforms[0].kind != "rate":
        return []  # samples over an interval that is wrong are wrong by as much
    if stream.quantity == "acceleration" and len(stream.channels) == 3:
        level = _mean_length(stream)
        near = [(abs(level / value - 1), value, words, option) for value, words, option in _MISTAKEN]
        off, value, words, option = min(near)
        if off < _NEAR:
            message = f"|mean acceleration| is {level:.4g} m/s^2: the samples look like {words}"
            return [_unit(stream, message, value / _G, f"give {option}", level)]
    if stream.quantity not in _GRADES:
        return []
    if stream.quantity == "angular_rate" and (said := _by_step(stream)):
        return [said]
    if of_rate:
        return []  # a density of noise is as wrong as the rate that it was computed with, whatever the unit
    if (found := grade(stream)) is not None:
        message, noise, factor, option = found
        return [_unit(stream, message, factor, f"give {option}", noise)]
    said = _by_noise(stream)
    return [said] if said else []


def gravity(stream: Stream) -> list[Finding]:
    """What an accelerometer triad at rest shows of gravity, where that is not 9.75 to 9.85 m/s².

    Parameters
    ----------
    stream : Stream
        Three orthogonal accelerometers; of others nothing is said.

    Returns
    -------
    list of Finding
        At most one: info for bias or scale within 12 %, and where gravity has been taken out; a warning for other values
        that no mistaken unit explains.
    """
    if stream.quantity != "acceleration" or len(stream.channels) != 3 or stream.grid.source == "simulated":
        return []
    if stream.samples.transforms[0].kind != "rate" and not PLAUSIBLE_RATES[0] <= stream.grid.rate <= PLAUSIBLE_RATES[1]:
        return []
    level = _mean_length(stream)
    if _ON_GROUND[0] <= level <= _ON_GROUND[1] or not math.isfinite(level):
        return []
    if any(abs(level / value - 1) < _NEAR for value, _, _ in _MISTAKEN):
        return []  # `implausible_unit` says it
    message = f"|mean acceleration| is {level:.4g} m/s^2; gravity is 9.75 to 9.85"
    if abs(level / _G - 1) < _NEAR:
        return [
            Finding(
                code="gravity",
                severity="info",
                message=f"{message}: biases and scale errors of {abs(level / _G - 1):.2g} of it together",
                size=level,
                unit=stream.unit,
                effect="a scale error is in every coefficient alike; a bias in none",
                remedy="calibrate in six positions if the scale matters",
            )
        ]
    if level < _NONE:
        return [
            Finding(
                code="gravity",
                severity="info",
                message=f"{message}: it has been taken out of the samples, which may have gone through a filter",
                size=level,
                unit=stream.unit,
                effect="noise of the attitude that it was taken out with may be in these samples",
                remedy="record the sensor's own output if it can be had",
            )
        ]
    return [
        Finding(
            code="gravity",
            severity="warning",
            message=f"{message}: unit, scale or axes are wrong",
            size=level,
            unit=stream.unit,
            effect=f"every coefficient may be {level / _G:.3g} × the sensor's own",
            remedy="check --unit, --scale and --channels",
        )
    ]


def earth_rate(stream: Stream, *, bias: float | None = None) -> list[Finding]:
    """Whether the mean of a gyro triad can be the rotation of the Earth.

    Parameters
    ----------
    stream : Stream
        Three orthogonal gyros.
    bias : float, optional
        What the constant bias of each gyro may be at most, by its datasheet. Default: unknown, so that little can be said,
        and as information alone: of gyros with white noise below 0.01 deg/√h, as only optical ones have, that their mean is
        the Earth's rate, or that it is so small that something has been taken off. [rad/s]

    Returns
    -------
    list of Finding
        Empty if the stream is no triad of gyros, or if bias and noise are together larger than a fifth of the Earth's
        rate, so that nothing could be said.
    """
    if stream.quantity != "angular_rate" or len(stream.channels) != 3:
        return []
    if bias is None and (stream.grid.source == "simulated" or not _quiet(stream)):
        return []
    means, variance = [], 0.0
    for channel in stream.channels:
        x = stream.column(channel)
        means.append(float(np.mean(present(x))) if np.isfinite(x).any() else math.nan)
        levels = [avar for _, avar, _ in octaves(x)]
        # σ²(τ) at the longest τ is no less than the variance of the mean, for white noise; for slower noise it is near.
        variance += levels[-1] if levels else math.inf
    spread = 2 * math.sqrt(variance) + math.sqrt(3) * (bias or 0.0)
    rate = math.sqrt(math.fsum(m * m for m in means))
    if not spread < EARTH_RATE / 5:
        return []
    agrees = abs(rate - EARTH_RATE) <= spread
    said = f"the mean rate is {math.degrees(rate) * 3600:.4g} deg/h, that of the Earth 15.04 deg/h"
    allowed = f"± {math.degrees(spread) * 3600:.2g} deg/h"
    if bias is None:
        return _of_unknown_bias(stream, rate, f"{said}; noise alone allows {allowed}", agrees=agrees)
    return [
        Finding(
            code="earth_rate",
            severity="info" if agrees else "warning",
            message=f"{said}; noise and a bias of {math.degrees(bias) * 3600:.3g} deg/h allow {allowed}",
            size=rate,
            unit=stream.unit,
            effect=(
                "" if agrees else "unit or scale is wrong, the bias is larger than stated, or the sensor does not rest"
            ),
            remedy="" if agrees else "check --unit and --scale",
        )
    ]


def _of_unknown_bias(stream: Stream, rate: float, message: str, *, agrees: bool) -> list[Finding]:
    if not agrees and rate > _TAKEN_OFF * EARTH_RATE:
        return []  # a bias of its own, or a part of the Earth's rate against one
    return [
        Finding(
            code="earth_rate",
            severity="info",
            message=message if agrees else f"{message}: a mean, or the Earth's rate itself, has been taken off",
            size=rate,
            unit=stream.unit,
            effect=(
                "unit and scale agree with it"
                if agrees
                else "a constant changes no coefficient; the mean does not tell whether unit and scale are right"
            ),
            remedy="" if agrees else "find out what took it off: a high-pass filter takes slow noise with it",
        )
    ]


def _quiet(stream: Stream) -> bool:
    """Whether white noise is that of gyros whose bias can be less than the Earth's rate."""
    for channel in stream.channels:
        level, _ = white_level(sample_of(stream, channel, most=_LOOKED_AT), stream.grid.tau0)
        if not 0 < level < QUIET**2:
            return False
    return True


def _mean_length(stream: Stream) -> float:
    return math.sqrt(math.fsum(mean_of(stream, channel) ** 2 for channel in stream.channels))


def _unit(stream: Stream, message: str, factor: float, remedy: str, size: float) -> Finding:
    return Finding(
        code="implausible_unit",
        severity="warning",
        message=message,
        size=size,
        unit=stream.unit,
        effect=f"if so, every coefficient is {factor:.4g} × the sensor's own",
        changes=tuple((term, factor) for term in TERMS),
        remedy=remedy,
    )


def _by_step(stream: Stream) -> Finding | None:
    steps = [found.step for channel in stream.channels if (found := resolution(stream, channel)) is not None]
    if not steps:
        return None
    for factor, words, option in (
        (1 / _DEG, "deg/s where rad/s was stated", "gyro=deg/s"),
        (_DEG, "rad/s where deg/s was stated", "gyro=rad/s"),
    ):
        known = [s for s in _STEPS_DPS if all(abs(step / (s * _DEG * factor) - 1) < _SAME_STEP for step in steps)]
        if known:
            message = (
                f"the numbers go in steps of {steps[0]:.6g} rad/s, and {1 / known[0]:.6g} LSB per deg/s is a known"
                f" sensitivity: the samples look like {words}"
            )
            return _unit(stream, message, factor, f"give --unit {option}", steps[0])
    return None


def _by_noise(stream: Stream) -> Finding | None:
    best, worst = _GRADES[stream.quantity]
    least, most = [], []
    for channel in stream.channels:
        x = sample_of(stream, channel, most=_LOOKED_AT)
        # White noise is no more than the least of τσ²(τ); and is lost to see where the largest is that of a slow term.
        level, _ = white_level(x, stream.grid.tau0)
        if level > 0:
            least.append(math.sqrt(level))
            most.append(math.sqrt(max(m * stream.grid.tau0 * avar for m, avar, _ in octaves(x))))
    if not least:
        return None
    if float(np.median(least)) > worst:
        levels = least
    elif float(np.median(most)) < best:
        levels = most
    else:
        return None
    noise = float(np.median(levels))
    axes = axes_text(stream.channels)
    if stream.quantity == "angular_rate":
        said = f"{noise / _DEG:.3g} (deg/s)/√Hz"
        factor, words, option = (
            (1 / _DEG, "deg/s where rad/s was stated", "deg/s")
            if noise > worst
            else (_DEG, "rad/s where deg/s was stated", "rad/s")
        )
    else:
        said = f"{noise / _G * 1e6:.3g} µg/√Hz"
        factor, words, option = (
            (1000 / _G, "mg where m/s^2 was stated", "mg")
            if noise > worst
            else (1 / _G, "g where m/s^2 was stated", "g")
        )
    beyond = (
        f"{noise / worst * 10:.3g} times the worst"
        if noise > worst
        else f"{best / noise * 10:.3g} times below the best"
    )
    message = f"white noise of {axes} is {said}, {beyond} sensors there are: the samples may be counts, or {words}"
    return _unit(stream, message, factor, f"give --scale for counts, or --unit {stream.name}={option}", noise)
