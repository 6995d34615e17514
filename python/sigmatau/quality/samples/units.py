"""Units: mean acceleration against gravity, noise against that of existing sensors, steps known from datasheets."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from sigmatau.findings.finding import Finding, Severity
from sigmatau.findings.kinds.values import EarthRate, Gravity, ImplausibleUnit
from sigmatau.quality.samples.common import octaves, present
from sigmatau.quality.samples.resolution import hides_noise, step_of
from sigmatau.quality.samples.sensor_grades import (
    DEGREE,
    GRAVITY,
    GRAVITY_TOLERANCE,
    OPTICAL_NOISE,
    grade,
    largest_noise,
    mean_vector,
    mixed_units,
    unit_finding,
    white_noise,
)
from sigmatau.record.streams import PLAUSIBLE_RATES, Stream

__all__ = ["earth_rate", "gravity", "implausible_unit"]

EARTH_RATE = 7.292115e-5  # sidereal rotation of the Earth [rad/s]

# Part of the Earth's rate below which the mean of gyros of an unknown bias has been removed: on three axes at once biases
# would have to be what the Earth makes there with the other sign. Gaussian ones do so in 1.2 % at most, where their standard
# deviation is 8.7 deg/h.
_REMOVED = 1 / 3

_MAX_SPREAD = 1 / 5  # part of the Earth's rate that noise and bias may allow for anything to be reported

# Gravity on the ground: 9.764 (Huascarán) to 9.834 m/s² (Arctic Ocean); J. Hirt et al., GRL 40 (2013). [m/s^2]
_ON_GROUND = (9.75, 9.85)

# Mean below which gravity has been removed: less than any single-axis bias of a sensor worth an Allan variance. [m/s^2]
_WITHOUT_GRAVITY = 0.5

# What |mean| is if the numbers are in one unit and another was stated: value where gravity would be 9.80665, the stated
# unit, the likely one, and the option.
_MISTAKEN: tuple[tuple[float, str, str, str], ...] = (
    (1.0, "m/s^2", "g", "--unit accel=g"),
    (GRAVITY**2, "g", "m/s^2", "--unit accel=m/s^2"),
    (1000.0, "m/s^2", "mg", "--unit accel=mg"),
    (100 * GRAVITY, "m/s^2", "cm/s^2", "--scale accel=0.01"),
    (1000 * GRAVITY, "g", "mg", "--unit accel=mg"),
    (GRAVITY / 0.3048, "m/s^2", "ft/s^2", "--unit accel=ft/s^2"),
)

# White noise of existing sensors, best and worst, and the factor beyond them that is implausible. Gyros: 1e-5 deg/√h
# (hemispherical resonators) to 1 (deg/s)/√Hz; accelerometers: 1 ng/√Hz (seismic) to 10 mg/√Hz. [SI unit per √Hz]
_NOISE = {"angular_rate": (1e-5 * DEGREE / 60, 1 * DEGREE), "acceleration": (1e-9 * GRAVITY, 0.01 * GRAVITY)}
_BEYOND = 10.0

# What noise beyond the worst and below the best sensors may be due to: stated unit, likely unit, factor of all coefficients.
_NOISE_MISTAKES = {
    "angular_rate": (("rad/s", "deg/s", 1 / DEGREE), ("deg/s", "rad/s", DEGREE)),
    "acceleration": (("m/s^2", "mg", 1000 / GRAVITY), ("m/s^2", "g", 1 / GRAVITY)),
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


def implausible_unit(stream: Stream) -> list[Finding]:
    """Signs that the samples are in another unit than stated: at most one finding, whose factor is that of all terms.

    An accelerometer triad at rest measures gravity: if |mean| is near 1, the unit is g. One axis may have 57.3 or 9.8 times
    the noise of the other two, see `mixed_units`; gyros may be noisier than any gyro, or have a bias that gyros with so
    little noise do not have, see `grade`. White noise more than ten times beyond that of the best and the worst sensors, or
    a step of the numbers that is known from datasheets in the other unit, distinguishes deg/s from rad/s.
    """
    coarse = hides_noise(stream)
    if not coarse and (mixed := mixed_units(stream)):
        return mixed
    implausible_rate = not PLAUSIBLE_RATES[0] <= stream.grid.rate <= PLAUSIBLE_RATES[1]
    if implausible_rate and stream.samples.transforms[0].kind != "rate":
        return []  # samples over an interval that is wrong are wrong by as much
    if stream.quantity == "acceleration" and len(stream.channels) == 3:
        level = mean_vector(stream)
        value, stated, likely, option = min(_MISTAKEN, key=lambda one: abs(level / one[0] - 1))
        if abs(level / value - 1) < GRAVITY_TOLERANCE:
            details = ImplausibleUnit(
                evidence="gravity", quantity=stream.quantity, stated=stated, likely=likely, option=option, mean=level
            )
            return unit_finding(stream, details, factor=value / GRAVITY, size=level)
    if stream.quantity not in _NOISE:
        return []
    if stream.quantity == "angular_rate" and (found := _by_step(stream)):
        return found
    if implausible_rate or coarse:
        return []  # a noise density is as wrong as the rate that it was computed with; rounding says nothing of noise
    return grade(stream) or _by_noise(stream)


def gravity(stream: Stream, *, tolerance: float = GRAVITY_TOLERANCE) -> list[Finding]:
    """The mean of an orthogonal accelerometer triad at rest, where it is not 9.75 to 9.85 m/s²; at most one finding.

    An info for biases and scale errors within `tolerance`, and where gravity has been removed; a warning for other values
    that no mistaken unit explains.
    """
    if stream.quantity != "acceleration" or len(stream.channels) != 3 or stream.grid.source == "simulated":
        return []
    if stream.samples.transforms[0].kind != "rate" and not PLAUSIBLE_RATES[0] <= stream.grid.rate <= PLAUSIBLE_RATES[1]:
        return []
    level = mean_vector(stream)
    low, high = _ON_GROUND
    if low <= level <= high or not math.isfinite(level):
        return []
    if any(abs(level / value - 1) < tolerance for value, _, _, _ in _MISTAKEN):
        return []  # `implausible_unit` reports it
    deviation = level / GRAVITY - 1
    near = abs(deviation) < tolerance
    cause: Literal["bias_or_scale", "removed", "unknown"]
    cause = "bias_or_scale" if near else "removed" if level < _WITHOUT_GRAVITY else "unknown"
    details = Gravity(mean=level, deviation=deviation, low=low, high=high, cause=cause)
    severity: Severity = "warning" if cause == "unknown" else "info"
    return [Finding(details=details, severity=severity, channels=stream.channels, size=level, unit=stream.unit)]


def earth_rate(stream: Stream, *, bias: float | None = None) -> list[Finding]:
    """Whether the mean of a triad of orthogonal gyros can be the rotation of the Earth; at most one finding.

    Empty if bias and noise together are larger than a fifth of the Earth's rate, so that nothing can be concluded.

    Parameters
    ----------
    stream : Stream
    bias : float, optional
        Largest constant bias of each gyro, by its datasheet. Default: unknown. Then only gyros with white noise below
        0.01 deg/√h, as only optical ones have, are judged, and only as information: whether their mean is the Earth's rate,
        or so small that something has been removed. [rad/s]
    """
    if stream.quantity != "angular_rate" or len(stream.channels) != 3:
        return []
    optical = (0 < white_noise(stream, channel) < OPTICAL_NOISE for channel in stream.channels)
    if bias is None and (stream.grid.source == "simulated" or not all(optical)):
        return []
    means, variance = [], 0.0
    for channel in stream.channels:
        x = stream.column(channel)
        means.append(float(np.mean(present(x))) if np.isfinite(x).any() else math.nan)
        levels = [avar for _, avar, _ in octaves(x)]
        # σ²(τ) at the longest τ is no less than the variance of the mean, for white noise; for slower noise it is near.
        variance += levels[-1] if levels else math.inf
    spread = 2 * math.sqrt(variance) + math.sqrt(3) * (bias or 0.0)
    mean = math.hypot(*means)
    if not spread < _MAX_SPREAD * EARTH_RATE:
        return []
    agrees = abs(mean - EARTH_RATE) <= spread
    if bias is None and not agrees and mean > _REMOVED * EARTH_RATE:
        return []  # a bias, or a part of the Earth's rate against one
    details = EarthRate(mean=mean, earth_rate=EARTH_RATE, tolerance=spread, bias=bias, agrees=agrees)
    severity: Severity = "info" if agrees or bias is None else "warning"
    return [Finding(details=details, severity=severity, channels=stream.channels, size=mean, unit=stream.unit)]


def _by_step(stream: Stream) -> list[Finding]:
    steps = [step for channel in stream.channels if (step := step_of(stream, channel))]
    if not steps:
        return []
    for stated, likely, factor in _NOISE_MISTAKES["angular_rate"]:
        known = [s for s in _STEPS_DPS if all(abs(step / (s * DEGREE * factor) - 1) < _SAME_STEP for step in steps)]
        if known:
            details = ImplausibleUnit(
                evidence="step",
                quantity=stream.quantity,
                stated=stated,
                likely=likely,
                option=f"--unit gyro={likely}",
                step=steps[0],
                sensitivity=1 / known[0],
            )
            return unit_finding(stream, details, factor=factor, size=steps[0])
    return []


def _by_noise(stream: Stream) -> list[Finding]:
    best, worst = _NOISE[stream.quantity]
    # White noise is no more than the least of τσ²(τ), and no less than the largest where a slow term hides it.
    bounds = {channel: bound for channel in stream.channels if (bound := white_noise(stream, channel)) > 0}
    if not bounds:
        return []
    least = float(np.median(list(bounds.values())))
    most = float(np.median([largest_noise(stream, channel) for channel in bounds]))
    if not (least > _BEYOND * worst or most < best / _BEYOND):
        return []
    noise, times = (least, least / worst) if least > _BEYOND * worst else (most, most / best)
    stated, likely, factor = _NOISE_MISTAKES[stream.quantity][times < 1]
    details = ImplausibleUnit(
        evidence="noise",
        quantity=stream.quantity,
        stated=stated,
        likely=likely,
        option=f"--unit {stream.name}={likely}",
        counts=True,
        noise=noise,
        times=times,
    )
    return unit_finding(stream, details, factor=factor, size=noise)
