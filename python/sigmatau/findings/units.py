"""Findings about values that the stated unit, gravity or the Earth do not explain."""

from __future__ import annotations

import math
from dataclasses import field
from typing import Literal

from sigmatau.digits import significant, two_digits
from sigmatau.findings.finding import Details, Finding, Words
from sigmatau.findings.phrases import percent
from sigmatau.frozen import frozen
from sigmatau.hints import Hint, as_options
from sigmatau.units import STANDARD_GRAVITY


@frozen
class ImplausibleUnit(Details, code="implausible_unit"):
    """Samples that are probably in another unit than stated.

    Attributes
    ----------
    evidence : {"gravity", "step", "noise", "bias", "quiet", "earth"}
        What shows it. gravity: mean of an accelerometer triad. step: a resolution of datasheets, but in another unit.
        noise: more noise than any gyro. bias: bias too large for gyros with such low noise. quiet: less noise than any
        sensor. earth: noise as low as that of gyros that measure the Earth's rotation, but a mean that differs from it.
    quantity : str
        Quantity that the stream measures.
    stated, likely : str
        The stated unit, and the unit that fits the samples; empty if no unit fits.
    mean : float or None
        Length of the mean vector. [SI unit of the stream]
    noise : float or None
        White noise. [SI unit of the stream, per √Hz]
    step : float or None
        Step of the numbers. [SI unit of the stream]
    sensitivity : float or None
        Sensitivity of known sensors with this step. [LSB per deg/s]
    times : float or None
        White noise, as a multiple of that of the noisiest gyros. [1]
    by_file : bool
        Whether the file states the unit. The unit of a gyro is then not doubted, and `likely` is empty.
    """

    evidence: Literal["gravity", "step", "noise", "bias", "quiet", "earth"]
    quantity: str
    stated: str = ""
    likely: str = ""
    option: str = field(default="", init=False)  # the `correction` as it is typed, for readers of the JSON
    mean: float | None = None
    noise: float | None = None
    step: float | None = None
    sensitivity: float | None = None
    times: float | None = None
    by_file: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "option", "" if self.correction is None else as_options([self.correction]))

    @property
    def correction(self) -> Hint | None:
        """The option that states the likely unit; None if there is none."""
        sensor = "gyro" if self.quantity == "angular_rate" else "accel"
        return Hint("unit", sensor, self.likely) if self.likely else None

    def words(self, finding: Finding) -> Words:
        noise = f"{significant(math.degrees(self.noise or 0))} (deg/s)/√Hz"
        if self.evidence == "gravity":
            fact = f"mean acceleration of {self.mean:.3g} m/s^2"
        elif self.evidence == "step":
            fact = (
                f"the resolution is {self.step:.3g} rad/s (1 LSB of sensors with {self.sensitivity:.6g} LSB per deg/s)"
            )
        elif self.evidence == "bias":
            fact = f"the noise is that of an optical gyro, but the mean is {_degrees_per_hour(self.mean or 0)} deg/h"
        elif self.evidence == "quiet":
            fact = f"white noise of {_small_noise(self)}, less than that of the quietest sensors"
        elif self.evidence == "earth":
            mean = f"{_degrees_per_hour(self.mean or 0)} deg/h"
            fact = f"white noise of {_small_noise(self)}, but a mean of {mean} and not the Earth's rotation of 15 deg/h"
        else:
            fact = f"white noise of {noise}, {two_digits(self.times or 1.0)} times that of the noisiest gyros"
        if self.by_file:
            stated = f" {self.stated}" if self.stated else " the unit"
            return Words(
                f"{fact}; the file states{stated}", "Check that the sensor was at rest, and the unit in the file"
            )
        if not self.likely and self.evidence in ("quiet", "earth"):
            return Words(fact, "Check the unit and the scale")
        looks = f"the unit is probably {self.likely}" if self.likely else "the values may be raw counts"
        if not self.likely:
            return Words(f"{fact}; {looks}", f"Run with {Hint('scale')} for raw counts")
        factor = finding.factors[0][1] if finding.factors else 1.0
        wrong = f"{significant(factor)} times too large" if factor > 1 else f"{significant(1 / factor)} times too small"
        return Words(f"{fact}; {looks}", f"Run with {self.correction}; all coefficients are now {wrong}")


@frozen
class Gravity(Details, code="gravity"):
    """A mean acceleration that is not gravity.

    Attributes
    ----------
    mean : float
        Length of the mean vector. [m/s^2]
    deviation : float
        Relative difference from standard gravity; negative if smaller. [1]
    low, high : float
        Lowest and highest gravity on the ground. [m/s^2]
    cause : {"bias_or_scale", "removed", "unknown"}
        Possible cause.
    """

    mean: float
    deviation: float
    low: float
    high: float
    cause: Literal["bias_or_scale", "removed", "unknown"]

    def words(self, finding: Finding) -> Words:
        mean = f"mean acceleration of {self.mean:.3g} m/s^2"
        if self.cause == "bias_or_scale":
            off = f"{percent(abs(self.deviation))} {'more' if self.deviation > 0 else 'less'} than gravity"
            return Words(
                f"{mean} is {off}: bias or scale error; a scale error changes all coefficients",
                "Calibrate in six positions if the scale matters",
            )
        if self.cause == "removed":
            return Words(
                f"{mean}: gravity was subtracted, which may add the noise of an estimated attitude",
                "Record the raw output of the sensor if possible",
            )
        times = f"{1 + self.deviation:.3g} times the true values"
        fact = f"{mean}, gravity is {self.low:g} to {self.high:g}; all coefficients may be {times}"
        return Words(fact, f"Check {Hint('unit')}, {Hint('scale')} and {Hint('channels')}")


@frozen
class MeanRate(Details, code="mean_rate"):
    """A mean angular rate beyond the zero-rate offset of most gyros: the sensor may turn steadily.

    Attributes
    ----------
    mean : float
        Length of the mean vector. [rad/s]
    usual : float
        Largest offset of usual gyros. [rad/s]
    """

    mean: float
    usual: float

    def words(self, finding: Finding) -> Words:
        mean, usual = (significant(math.degrees(rate)) for rate in (self.mean, self.usual))
        return Words(
            f"mean rate of {mean} deg/s: the sensor turns, or has an offset beyond the {usual} deg/s of usual gyros",
            "Record it at rest, or check its offset in the datasheet",
        )


def _degrees_per_hour(rate: float) -> str:
    return significant(math.degrees(rate) * 3600)


def _small_noise(details: ImplausibleUnit) -> str:
    noise = details.noise or 0.0
    if details.quantity == "angular_rate":
        return f"{significant(60 * math.degrees(noise))} deg/√h"
    return f"{significant(noise / (1e-9 * STANDARD_GRAVITY))} ng/√Hz"
