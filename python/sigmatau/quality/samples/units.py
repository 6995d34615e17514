"""Check of units: compares the mean with gravity, and noise, mean and steps with those of existing sensors."""

from __future__ import annotations

import math
from typing import Any, Literal

from sigmatau.estimators.octaves import octaves
from sigmatau.findings.finding import Finding, Severity
from sigmatau.findings.units import Gravity, ImplausibleUnit, MeanRate
from sigmatau.noise.terms import TERMS
from sigmatau.quality.means import mean_value
from sigmatau.quality.samples.common import take_samples, white_level
from sigmatau.quality.samples.resolution import find_step, hides_noise
from sigmatau.quality.sensor_class import SENSOR_CLASSES
from sigmatau.record.streams import PLAUSIBLE_RATES, Stream
from sigmatau.units import STANDARD_GRAVITY, find, to_si

DEGREE = math.pi / 180

Evidence = Literal["gravity", "step", "noise", "bias", "quiet", "earth"]

AXES = 3  # channels of a triad, which shows gravity or the Earth's rotation

# Mistaken units of an accelerometer: |mean| in the stated unit [m/s²], the stated unit, and the likely unit.
_MISTAKEN: tuple[tuple[float, str, str], ...] = (
    (1.0, "m/s^2", "g"),
    (STANDARD_GRAVITY**2, "g", "m/s^2"),
    (1000.0, "m/s^2", "mg"),
    (100 * STANDARD_GRAVITY, "m/s^2", "cm/s^2"),
    (1000 * STANDARD_GRAVITY, "g", "mg"),
    (STANDARD_GRAVITY / 0.3048, "m/s^2", "ft/s^2"),
    (STANDARD_GRAVITY**2 * 1e-3, "mg", "m/s^2"),
    (STANDARD_GRAVITY * 1e-3, "mg", "g"),
    (STANDARD_GRAVITY**2 * 1e-6, "ug", "m/s^2"),
    (STANDARD_GRAVITY * 1e-6, "ug", "g"),
)
_SMALL_UNITS = ("mg", "ug")  # stated units of `_MISTAKEN` with small means: tested only if the unit was stated

# For each stated unit, larger units that it may be confused with, the likeliest first.
_MISTAKES: dict[str, tuple[str, ...]] = {
    "rad/s": ("deg/s",),
    "deg/s": ("rad/s",),
    "deg/h": ("deg/s", "rad/s"),
    "mdeg/s": ("deg/s", "rad/s"),
    "mrad/s": ("deg/s", "rad/s"),
    "urad/s": ("deg/s", "rad/s"),
    "g": (),
    "m/s^2": ("g",),
    "mg": ("m/s^2", "g"),
    "ug": ("m/s^2", "g", "mg"),
    "mm/s^2": ("m/s^2", "g"),
    "um/s^2": ("m/s^2", "g", "mg"),
    "mGal": ("m/s^2", "g", "mg"),
}

_NOISIEST_GYRO = SENSOR_CLASSES["angular_rate"].noisiest["random_walk"]
_EARTH_RATE = 7.292115e-5  # IERS [rad/s]


# Relative difference from gravity that bias and scale errors explain. [1] Datasheets: consumer accelerometers have a
# bias of 100 mg and scale errors of a few per cent.
GRAVITY_TOLERANCE = 0.12
# Gravity on the ground. [m/s^2] Literature: 9.764 (Huascarán) to 9.834 m/s² (Arctic Ocean); J. Hirt et al., GRL 40
# (2013).
_ON_GROUND = (9.75, 9.85)
# Mean below which gravity has been removed. [m/s^2] Judgement: below the single-axis bias of any sensor for which an
# Allan variance is useful.
_WITHOUT_GRAVITY = 0.5
# Steps of known gyros. [deg/s] Datasheets: InvenSense MPU and ICM (131 to 16.4 LSB per deg/s), Bosch BMI (262.144 to
# 16.384), ST LSM and L3G (4.375 to 70 mdps). Steps that may also come from rounded decimals are left out.
_KNOWN_STEPS = (
    *(1 / 131 * k for k in (1, 131 / 65.5, 131 / 32.8, 131 / 16.4)),
    *(2.0**k / 262.144 for k in range(5)),
    4.375e-3,
    8.75e-3,
    17.5e-3,
)
# Largest relative difference of a step from a known step. [1] Judgement: about the error of the step of a log.
_SAME_STEP = 1e-4
# Relative difference of the factor of a channel from that of a unit. [1] Judgement: typed factors have seven digits.
_SAME_FACTOR = 1e-6
# Largest zero-rate offset of usual MEMS gyros; a gyro with a larger mean may turn. [rad/s] Datasheets: 1 to 10 deg/s
# for LSM6, BMI and ICM parts. Older parts have up to 20 deg/s (MPU-6050), 40 deg/s (ITG-3200) and 75 deg/s (L3GD20 at
# full range).
USUAL_OFFSET = 10 * DEGREE
# White noise over that of the noisiest gyro, above which the unit is wrong. [1] Judgement: allows for a sensor that
# is worse than its datasheet.
_TIMES_NOISIEST = 2.0
# White noise below which a gyro measures the Earth's rotation: 5·10⁻⁴ deg/√h. [rad/s/√Hz] Literature: strategic
# gyros, whose bias is below 0.01 deg/h (H. C. Lefèvre, C. R. Physique 15, 2014, doi:10.1016/j.crhy.2014.10.007).
_EARTH_NOISE = 5e-4 * DEGREE / 60
# Relative difference of the mean from the Earth's rate. [1] Judgement: axes that are not orthogonal.
_EARTH_TOLERANCE = 0.3
# White noise below which a gyro is optical and has a bias of at most a few deg/h: 0.01 deg/√h. [rad/s/√Hz] Judgement:
# MEMS gyros have more.
_OPTICAL_NOISE = 0.01 * DEGREE / 60
# Mean rate that is too large for the bias of an optical gyro. [rad/s] Derived: three times the Earth's rate; MEMS
# gyros have 100 to 10⁵ deg/h.
_MIN_MEMS_BIAS = 45 * DEGREE / 3600
# Number of samples used to estimate the noise. [samples] Judgement: it is compared with factors of two or more.
_EXAMINED = 1 << 17
# Averaging time below which Allan variances of few pairs are used too. [samples] Judgement: a short record has few
# pairs at longer times.
_SHORT = 64
# Smallest number of pairs of clusters at longer times. [1] Derived: a relative error of √(3/200), 12 %.
_MIN_PAIRS = 200


def implausible_unit(stream: Stream) -> list[Finding]:
    """Check whether the samples are in a unit other than the stated one: at most one finding, with one factor for all terms.

    An accelerometer triad at rest measures gravity: if |mean| is near 1, the unit is g. Gyros noisier than any existing
    gyro are in deg/s or are raw counts. Gyros whose bias is too large for their low noise are in rad/s. A step that
    datasheets state for the other unit also distinguishes the two. Sensors quieter than the quietest are in a larger unit
    than stated; so are gyros that are quiet enough to measure the Earth's rotation but have another mean.
    """
    if not has_plausible_values(stream):
        return []
    is_triad = stream.quantity == "acceleration" and len(stream.channels) == AXES
    if is_triad and ((by_gravity := unit_by_gravity(stream)) or not mean_vector(stream) < _WITHOUT_GRAVITY):
        return by_gravity
    if stream.quantity not in SENSOR_CLASSES:
        return []
    if by_step := unit_by_step(stream):
        return by_step
    if not _has_plausible_rate(stream) or hides_noise(stream) or stream.grid.source.kind == "simulated":
        return []  # a wrong rate makes the noise density wrong, and rounding hides the noise
    return _by_noise(stream)


def gravity(stream: Stream) -> list[Finding]:
    """Report the mean of an orthogonal accelerometer triad at rest if it is not 9.75 to 9.85 m/s²; at most one finding.

    It is an info for biases, scale errors and removed gravity; a warning for other values that no mistaken unit explains.
    """
    if stream.quantity != "acceleration" or len(stream.channels) != AXES or not _is_measured(stream):
        return []
    level = mean_vector(stream)
    low, high = _ON_GROUND
    if low <= level <= high or not math.isfinite(level):
        return []
    if unit_by_gravity(stream):
        return []  # `implausible_unit` reports it
    deviation = level / STANDARD_GRAVITY - 1
    is_close = is_gravity(level)
    cause: Literal["bias_or_scale", "removed", "unknown"]
    cause = "bias_or_scale" if is_close else "removed" if level < _WITHOUT_GRAVITY else "unknown"
    details = Gravity(mean=level, deviation=deviation, low=low, high=high, cause=cause)
    severity: Severity = "warning" if cause == "unknown" else "info"
    factors = tuple((term, 1 + deviation) for term in TERMS) if cause == "unknown" else ()
    channels, unit = stream.channels, stream.unit
    return [Finding(details=details, severity=severity, channels=channels, size=level, unit=unit, factors=factors)]


def is_gravity(acceleration: float) -> bool:
    """Whether an acceleration differs from gravity by no more than biases and scale errors explain. [m/s^2]"""
    return abs(acceleration / STANDARD_GRAVITY - 1) < GRAVITY_TOLERANCE


def mean_rate(stream: Stream) -> list[Finding]:
    """Report a mean of gyros above the zero-rate offset of usual gyros (offset or steady rotation): at most one warning."""
    if stream.quantity != "angular_rate" or not _is_measured(stream):
        return []
    mean = mean_vector(stream)
    if not mean > USUAL_OFFSET:
        return []
    details = MeanRate(mean=mean, usual=USUAL_OFFSET)
    return [Finding(details=details, severity="warning", channels=stream.channels, size=mean, unit=stream.unit)]


def has_plausible_values(stream: Stream) -> bool:
    """Whether increments have a plausible interval: a wrong interval makes the rates wrong by the same factor."""
    return stream.samples.transforms[0].kind == "rate" or _has_plausible_rate(stream)


def _has_plausible_rate(stream: Stream) -> bool:
    return PLAUSIBLE_RATES[0] <= stream.grid.rate <= PLAUSIBLE_RATES[1]


def _is_measured(stream: Stream) -> bool:
    return has_plausible_values(stream) and stream.grid.source.kind != "simulated"


def unit_by_gravity(stream: Stream) -> list[Finding]:
    """Report another unit of an accelerometer triad in which its mean is gravity: at most one warning."""
    level = mean_vector(stream)
    stated_unit = _stated(stream)
    possible = [row for row in _MISTAKEN if row[1] not in _SMALL_UNITS or row[1] == stated_unit]
    value, stated, likely = min(possible, key=lambda row: abs(level / row[0] - 1))
    if not abs(level / value - 1) < GRAVITY_TOLERANCE:
        return []
    return _finding(stream, "gravity", stated, likely, factor=value / STANDARD_GRAVITY, size=level, mean=level)


def unit_by_step(stream: Stream) -> list[Finding]:
    """Report another unit of gyros in which their resolution is that of known sensors: at most one warning."""
    steps = [step for channel in stream.channels if (step := find_step(stream, channel))]
    stated = _stated(stream)
    if not steps or stream.quantity != "angular_rate":
        return []
    for likely in _MISTAKES.get(stated, ()):
        factor = to_si(1.0, stated) / to_si(1.0, likely)
        alike = [s for s in _KNOWN_STEPS if all(abs(step / (s * DEGREE * factor) - 1) < _SAME_STEP for step in steps)]
        if alike:
            return _finding(stream, "step", stated, likely, size=steps[0], step=steps[0], sensitivity=1 / alike[0])
    return []


def _by_noise(stream: Stream) -> list[Finding]:
    """Compare the noise with that of the noisiest and the quietest sensors, and with that of gyros with another mean."""
    # White noise is at most the smallest τσ²(τ), and at least the largest unless a slow term hides it.
    bounds = [_levels(stream, channel) for channel in stream.channels]
    bounds = [pair for pair in bounds if not math.isnan(pair[0])]
    lowest = sorted(low for low, _ in bounds)
    if not (lowest and lowest[0] > 0):
        return []
    middle, highest = lowest[len(lowest) // 2], max(high for _, high in bounds)
    if stream.quantity == "angular_rate" and lowest[0] > _TIMES_NOISIEST * _NOISIEST_GYRO:
        stated = _stated(stream)
        likely = "deg/s" if stated == "rad/s" else ""
        return _by_density(stream, "noise", likely, middle, times=middle / _NOISIEST_GYRO)
    is_in_degrees = stream.quantity == "angular_rate" and _stated(stream) == "deg/s"
    if is_in_degrees and highest < _OPTICAL_NOISE and mean_vector(stream) > _MIN_MEMS_BIAS:
        return _by_density(stream, "bias", "rad/s", middle)
    evidence = _quiet_evidence(stream, highest)
    return _by_density(stream, evidence, _louder_unit(stream, middle), middle) if evidence else []


def _quiet_evidence(stream: Stream, highest: float) -> Evidence | None:
    """Reason why the white noise is too low for the sensor; None if it is plausible."""
    is_gyro_triad = stream.quantity == "angular_rate" and len(stream.channels) == AXES
    if is_gyro_triad and abs(mean_vector(stream) / _EARTH_RATE - 1) < _EARTH_TOLERANCE:
        return None
    if highest < SENSOR_CLASSES[stream.quantity].quietest:
        return "quiet"
    return "earth" if is_gyro_triad and highest < _EARTH_NOISE else None


def _louder_unit(stream: Stream, noise: float) -> str:
    """Most likely larger unit in which the noise is that of an existing sensor; empty if there is none."""
    limits = SENSOR_CLASSES[stream.quantity]
    stated = _stated(stream)
    for likely in _MISTAKES.get(stated, ()):
        density = noise * to_si(1.0, likely) / to_si(1.0, stated)
        if limits.quietest < density <= limits.noisiest["random_walk"] and likely != stated:
            return likely
    return ""


def _by_density(
    stream: Stream, evidence: Evidence, likely: str, noise: float, *, times: float | None = None
) -> list[Finding]:
    stated = _stated(stream) if likely else ""
    mean = mean_vector(stream)
    return _finding(stream, evidence, stated, likely, size=noise, noise=noise, mean=mean, times=times)


def _finding(
    stream: Stream,
    evidence: Evidence,
    stated: str,
    likely: str,
    *,
    size: float,
    factor: float | None = None,
    **measured: Any,  # noqa: ANN401
) -> list[Finding]:
    """Report that all coefficients of a stream are wrong by one factor, by default that of the likely unit."""
    details = ImplausibleUnit(evidence=evidence, quantity=stream.quantity, stated=stated, likely=likely, **measured)
    if factor is None:
        factor = to_si(1.0, stated) / to_si(1.0, likely) if likely else 1.0
    factors = tuple((term, factor) for term in TERMS)
    channels, unit = stream.channels, stream.unit
    return [Finding(details=details, severity="warning", channels=channels, size=size, unit=unit, factors=factors)]


def _stated(stream: Stream) -> str:
    """Unit of `_MISTAKES` in which all channels were read; empty for another unit or several units."""
    factors = [transform.factor for transform in stream.samples.transforms]
    units = (unit for unit in _MISTAKES if find(unit).si == stream.unit)
    alike = (unit for unit in units if all(abs(f / to_si(1.0, unit) - 1) < _SAME_FACTOR for f in factors))
    return next(alike, "")


def mean_vector(stream: Stream) -> float:
    """Length of the mean of all channels. [unit of the stream]"""
    return math.hypot(*(mean_value(stream, channel) for channel in stream.channels))


def _levels(stream: Stream, channel: str) -> tuple[float, float]:
    """Lower and upper bound of the white noise: the smallest and the largest √τ·σ(τ). [unit of the stream/√Hz]

    NaN if no two samples are consecutive.
    """
    x, tau0 = take_samples(stream, channel, count=_EXAMINED), stream.grid.tau0
    level, _ = white_level(x, tau0)
    levels = [m * tau0 * avar for m, avar, pairs in octaves(x) if m < _SHORT or pairs > _MIN_PAIRS]
    return math.sqrt(max(level, 0.0)), math.sqrt(max(levels, default=0.0))
