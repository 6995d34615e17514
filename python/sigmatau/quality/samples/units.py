"""Units: mean acceleration against gravity, noise and mean of gyros against those of existing ones, known steps."""

from __future__ import annotations

import math
from typing import Literal

from sigmatau.estimators.octaves import octaves
from sigmatau.findings.finding import Finding, Severity
from sigmatau.findings.kinds.values import Gravity, ImplausibleUnit
from sigmatau.noise.terms import TERMS
from sigmatau.quality.means import mean_of
from sigmatau.quality.samples.common import sample_of, white_level
from sigmatau.quality.samples.resolution import hides_noise, step_of
from sigmatau.record.streams import PLAUSIBLE_RATES, Stream

DEGREE = math.pi / 180

GRAVITY = 9.80665  # standard gravity [m/s^2]

GRAVITY_TOLERANCE = 0.12
"""What bias (100 mg) and scale errors (some percent) of consumer accelerometers change of gravity, as a part of it."""

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

# Gyros by the stated unit: the likely one, and the factor of all coefficients.
_MISTAKES = {"rad/s": ("deg/s", 1 / DEGREE), "deg/s": ("rad/s", DEGREE)}
_FACTORS = {"rad/s": 1.0, "deg/s": DEGREE}
_SAME_FACTOR = 1e-6

# The noisiest gyros of datasheets have 0.1 (deg/s)/√Hz (first MEMS; consumer ones since have 0.004 to 0.03). [rad/s/√Hz]
_NOISIEST_GYRO = 0.1 * DEGREE
_TIMES_NOISIEST = 2.0

# White noise that only optical gyros are below, whose bias is some deg/h at most: 0.01 deg/√h. [rad/s/√Hz]
_OPTICAL_NOISE = 0.01 * DEGREE / 60

# Least mean rate that is not a bias of gyros so quiet: three times the Earth's. MEMS have 100 to 10^5 deg/h. [rad/s]
_MIN_MEMS_BIAS = 45 * DEGREE / 3600

_LOOKED_AT = 1 << 17

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

    An accelerometer triad at rest measures gravity: if |mean| is near 1, the unit is g. Gyros are in deg/s, or are raw
    counts, if they are noisier than any gyro; in rad/s, if they have a bias that gyros with so little noise do not have. A
    step of the numbers that is known from datasheets in the other unit distinguishes the two as well.
    """
    implausible_rate = not PLAUSIBLE_RATES[0] <= stream.grid.rate <= PLAUSIBLE_RATES[1]
    if implausible_rate and stream.samples.transforms[0].kind != "rate":
        return []  # samples over an interval that is wrong are wrong by as much
    if stream.quantity == "acceleration" and len(stream.channels) == 3:
        return _by_gravity(stream)
    if stream.quantity != "angular_rate":
        return []
    if found := _by_step(stream):
        return found
    if implausible_rate or hides_noise(stream) or stream.grid.source == "simulated":
        return []  # a noise density is as wrong as the rate that it was computed with; rounding says nothing of noise
    return _by_noise(stream)


def gravity(stream: Stream, *, tolerance: float = GRAVITY_TOLERANCE) -> list[Finding]:
    """The mean of an orthogonal accelerometer triad at rest, where it is not 9.75 to 9.85 m/s²; at most one finding.

    An info for biases and scale errors within `tolerance`, and where gravity has been removed; a warning for other values
    that no mistaken unit explains.
    """
    if stream.quantity != "acceleration" or len(stream.channels) != 3 or stream.grid.source == "simulated":
        return []
    if stream.samples.transforms[0].kind != "rate" and not PLAUSIBLE_RATES[0] <= stream.grid.rate <= PLAUSIBLE_RATES[1]:
        return []
    level = _mean_vector(stream)
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
    factors = tuple((term, 1 + deviation) for term in TERMS) if cause == "unknown" else ()
    channels, unit = stream.channels, stream.unit
    return [Finding(details=details, severity=severity, channels=channels, size=level, unit=unit, factors=factors)]


def _by_gravity(stream: Stream) -> list[Finding]:
    level = _mean_vector(stream)
    value, stated, likely, option = min(_MISTAKEN, key=lambda one: abs(level / one[0] - 1))
    if not abs(level / value - 1) < GRAVITY_TOLERANCE:
        return []
    details = ImplausibleUnit(
        evidence="gravity", quantity=stream.quantity, stated=stated, likely=likely, option=option, mean=level
    )
    return _finding(stream, details, factor=value / GRAVITY, size=level)


def _by_step(stream: Stream) -> list[Finding]:
    steps = [step for channel in stream.channels if (step := step_of(stream, channel))]
    if not steps:
        return []
    for stated, (likely, factor) in _MISTAKES.items():
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
            return _finding(stream, details, factor=factor, size=steps[0])
    return []


def _by_noise(stream: Stream) -> list[Finding]:
    """Whether the noise of gyros is larger than that of any gyro, or their mean too large for gyros with so little noise."""
    # White noise is no more than the least of τσ²(τ), and no less than the largest where a slow term hides it.
    bounds = [_levels(stream, channel) for channel in stream.channels]
    bounds = [one for one in bounds if not math.isnan(one[0])]
    least = sorted(low for low, _ in bounds)
    if not (least and least[0] > 0):
        return []
    stated, middle, mean = _stated(stream), least[len(least) // 2], _mean_vector(stream)
    evidence: Literal["noise", "bias"] = "noise"
    if least[0] <= _TIMES_NOISIEST * _NOISIEST_GYRO:
        evidence = "bias"
        most = max(high for _, high in bounds)
        if stated != "deg/s" or not mean > _MIN_MEMS_BIAS or not most < _OPTICAL_NOISE:
            return []
    elif stated != "rad/s":
        stated = ""
    likely, factor = _MISTAKES.get(stated, ("", 1.0))
    details = ImplausibleUnit(
        evidence=evidence,
        quantity=stream.quantity,
        stated=stated,
        likely=likely,
        option=f"--unit {stream.name}={likely}" if likely else "",
        noise=middle,
        mean=mean,
        times=middle / _NOISIEST_GYRO if evidence == "noise" else None,
    )
    return _finding(stream, details, factor=factor, size=middle)


def _finding(stream: Stream, details: ImplausibleUnit, *, factor: float, size: float) -> list[Finding]:
    """All coefficients of a stream are wrong by a factor."""
    factors = tuple((term, factor) for term in TERMS)
    channels, unit = stream.channels, stream.unit
    return [Finding(details=details, severity="warning", channels=channels, size=size, unit=unit, factors=factors)]


def _stated(stream: Stream) -> str:
    """The unit that all channels of a gyro were read in; empty for another, or several."""
    factors = [transform.factor for transform in stream.samples.transforms]
    alike = (unit for unit, of in _FACTORS.items() if all(abs(f / of - 1) < _SAME_FACTOR for f in factors))
    return next(alike, "")


def _mean_vector(stream: Stream) -> float:
    """Length of the mean of all channels. [unit of the stream]"""
    return math.hypot(*(mean_of(stream, channel) for channel in stream.channels))


def _levels(stream: Stream, channel: str, *, least_pairs: int = 200) -> tuple[float, float]:
    """A lower and an upper bound of the white noise: the least and the largest of √τ·σ(τ); NaN if no two samples follow
    each other. [unit of the stream/√Hz]
    """
    x, tau0 = sample_of(stream, channel, most=_LOOKED_AT), stream.grid.tau0
    level, _ = white_level(x, tau0)
    levels = [m * tau0 * avar for m, avar, pairs in octaves(x) if m < 64 or pairs > least_pairs]
    return math.sqrt(max(level, 0.0)), math.sqrt(max(levels, default=0.0))
