"""Kinds of findings about sample values: held, repeated, lost, saturated, interpolated, coarse, in a wrong unit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from sigmatau.findings.finding import Details

__all__ = [
    "AddedWalk",
    "CoarseResolution",
    "Dropout",
    "EarthRate",
    "FilledOutages",
    "FilledSamples",
    "Gravity",
    "HeldRuns",
    "ImplausibleUnit",
    "Interpolated",
    "QuantizationMismatch",
    "RepeatedSamples",
    "Saturation",
    "StuckSamples",
    "Upsampled",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class AddedWalk:
    """Rate random walk that levels other than the sensor's own add.

    Attributes
    ----------
    channel, quantity, unit : str
        The channel, what it measures, and its unit.
    coefficient : float
        K that the levels add at averaging times up to their length. [unit/√s]
    factor : float or None
        K with these levels over the sensor's own; None if the sensor's own is 0.
    resolved : bool
        Whether the record shows the sensor's own K; if not, `factor` is a lower limit.
    """

    channel: str
    quantity: str
    unit: str
    coefficient: float
    factor: float | None
    resolved: bool

    @property
    def factors(self) -> tuple[tuple[str, float], ...]:
        """The factor as those of a finding: none if it is only a limit."""
        return (("rate_random_walk", self.factor),) if self.resolved and self.factor is not None else ()


@dataclass(frozen=True, slots=True, kw_only=True)
class HeldRuns(Details):
    """Runs of samples that are not the sensor's: base of `Dropout` and `StuckSamples`.

    Attributes
    ----------
    strongest : str
        The channel with the largest effect, which all numbers are of.
    samples : int
        Samples concerned.
    share : float
        Part of all samples.
    runs : int
        Number of runs.
    start, longest : float
        Beginning and length of the longest run. [s]
    tau : float
        Averaging time at which the factor of the random walk holds. [s]
    walk : AddedWalk or None
        What the levels held add to the rate random walk; None for short runs.
    """

    strongest: str
    samples: int
    share: float
    runs: int
    start: float
    longest: float
    tau: float
    walk: AddedWalk | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Dropout(HeldRuns):
    """The log holds the number 0 where samples were lost."""

    code: ClassVar[str] = "dropout"


@dataclass(frozen=True, slots=True, kw_only=True)
class StuckSamples(HeldRuns):
    """Runs of equal samples longer than the noise can explain."""

    code: ClassVar[str] = "stuck_samples"


@dataclass(frozen=True, slots=True, kw_only=True)
class Saturation(Details):
    """Samples at an end of the measuring range.

    Attributes
    ----------
    strongest : str
        The channel with the largest effect, which all numbers are of.
    samples : int
        Samples at an end of the range.
    share : float
        Part of all samples.
    low, high : float or None
        The ends that are reached. [unit]
    unit : str
    start : float
        Time of the first of these samples. [s]
    longest : float
        Longest run of one value; 0 if no run is longer than the noise can explain. [s]
    spread : bool
        Whether these samples are spread over the whole record, so that the effect on white noise is known.
    """

    code: ClassVar[str] = "saturation"
    strongest: str
    samples: int
    share: float
    low: float | None
    high: float | None
    unit: str
    start: float
    longest: float
    spread: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class RepeatedSamples(Details):
    """Samples that equal the one before, more often than chance makes them.

    Attributes
    ----------
    pattern : {"held", "irregular", "rows"}
        A sensor at a lower rate than its log; copies at irregular places; single rows that are in the log twice.
    copies : int
        Samples that equal the one before.
    share : float
        Part of all samples.
    times : float
        How often a sample occurs on average.
    shortest, longest : int
        How often a sample occurs, without the rarest 2.5 % at either end.
    log_rate : float
        Rate of the rows. [Hz]
    sensor_rate : float
        Rate of distinct samples. [Hz]
    rate_given : bool
        Whether the rate was given by the user, so that it may be the sensor's and not that of the rows.
    sigma_one_sample : float
        σ at one sample over that of white noise with the same σ at long averaging times.
    right_from : int
        Number of samples from which on σ is right.
    walk_at_log_rate, walk_at_sensor_rate : float
        Random walk over the sensor's own, if the sensor runs at the rate of the log or at that of distinct samples.
    """

    code: ClassVar[str] = "repeated_samples"
    pattern: Literal["held", "irregular", "rows"]
    copies: int
    share: float
    times: float
    shortest: int
    longest: int
    log_rate: float
    sensor_rate: float
    rate_given: bool
    sigma_one_sample: float
    right_from: int
    walk_at_log_rate: float
    walk_at_sensor_rate: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Upsampled:
    """How all samples were interpolated from a lower rate.

    Attributes
    ----------
    sensor_rate, log_rate : float
        Rate of the samples before, and of the log. [Hz]
    aligned : bool
        Whether the sensor's samples are among those of the log.
    sigma_one_sample : float
        σ at one sample over that of the sensor's white noise.
    right_from : float
        Averaging time from which on σ is right. [s]
    """

    sensor_rate: float
    log_rate: float
    aligned: bool
    sigma_one_sample: float
    right_from: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FilledOutages:
    """Long stretches that were filled in with straight lines.

    Attributes
    ----------
    count : int
    start, longest : float
        Beginning and length of the longest. [s]
    walk : AddedWalk
        Of the channel on which the walk grows most.
    """

    count: int
    start: float
    longest: float
    walk: AddedWalk


@dataclass(frozen=True, slots=True, kw_only=True)
class FilledSamples:
    """Single lost samples that were filled in with straight lines.

    Attributes
    ----------
    random_walk : float
        Random walk over the sensor's own, at all averaging times of more than some samples.
    sigma_one_sample : float
        σ at one sample over the sensor's own.
    """

    random_walk: float
    sigma_one_sample: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Interpolated(Details):
    """Samples on the straight line through their neighbours: all made from a lower rate, or lost ones filled in.

    Attributes
    ----------
    strongest : str
        The channel which all numbers are of.
    share : float
        Part of the samples that were made up: single ones if there are `singles`, else all.
    upsampled : Upsampled or None
    outages : FilledOutages or None
    singles : FilledSamples or None
        Those of the three that were found.
    """

    code: ClassVar[str] = "interpolated"
    strongest: str
    share: float
    upsampled: Upsampled | None = None
    outages: FilledOutages | None = None
    singles: FilledSamples | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class CoarseResolution(Details):
    """A step of the numbers that is coarse against the noise.

    Attributes
    ----------
    step, noise : float
        Step of the numbers and standard deviation of the white part of a sample. [unit]
    unit : str
    rounding : {"quantization", "white", "unknown"}
        What rounding adds: quantization noise to increments, white noise to rates; neither below half a step of noise.
    added : float or None
        Coefficient of the noise added: Q [unit·s], at most, or N [unit·√s]; None if unknown.
    """

    code: ClassVar[str] = "coarse_resolution"
    step: float
    noise: float
    unit: str
    rounding: Literal["quantization", "white", "unknown"]
    added: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class QuantizationMismatch(Details):
    """A fitted quantization noise larger than the step of the log can make.

    Attributes
    ----------
    quantization : float
        Fitted Q. [unit·s]
    step : float
        Step S of the log. [unit·s]
    limit : float
        S/√12. [unit·s]
    unit : str
        Unit of the stream.
    """

    code: ClassVar[str] = "quantization_mismatch"
    quantization: float
    step: float
    limit: float
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ImplausibleUnit(Details):
    """Samples that are probably in another unit than stated.

    Attributes
    ----------
    evidence : {"gravity", "step", "noise", "bias", "axes"}
        Mean of an accelerometer triad; a step known from datasheets; noise beyond that of all sensors; a bias too large for
        gyros with so little noise; one axis whose noise differs from that of the others.
    quantity : str
        What the stream measures.
    stated, likely : str
        The unit that was stated, and the one that the samples look like; empty if no unit explains them.
    option : str
        Option of the command line that corrects it; empty if only a scale for raw counts can.
    counts : bool
        Whether the samples may be raw counts.
    mean : float or None
        Length of the mean vector. [SI unit of the stream]
    noise : float or None
        White noise. [SI unit of the stream, per √Hz]
    step : float or None
        Step of the numbers. [SI unit of the stream]
    sensitivity : float or None
        The known sensitivity that the step agrees with. [LSB per deg/s]
    times : float or None
        White noise over that of the noisiest sensors, of the quietest, or of the other axes.
    others : tuple of str
        The other axes.
    """

    code: ClassVar[str] = "implausible_unit"
    evidence: Literal["gravity", "step", "noise", "bias", "axes"]
    quantity: str
    stated: str = ""
    likely: str = ""
    option: str = ""
    counts: bool = False
    mean: float | None = None
    noise: float | None = None
    step: float | None = None
    sensitivity: float | None = None
    times: float | None = None
    others: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Gravity(Details):
    """A mean acceleration that is not gravity.

    Attributes
    ----------
    mean : float
        Length of the mean vector. [m/s^2]
    deviation : float
        How far it is from standard gravity, as a part of it; negative if less.
    low, high : float
        Gravity on the ground. [m/s^2]
    cause : {"bias_or_scale", "removed", "unknown"}
    """

    code: ClassVar[str] = "gravity"
    mean: float
    deviation: float
    low: float
    high: float
    cause: Literal["bias_or_scale", "removed", "unknown"]


@dataclass(frozen=True, slots=True, kw_only=True)
class EarthRate(Details):
    """The mean rate of a gyro triad against the Earth's.

    Attributes
    ----------
    mean, earth_rate : float
        Length of the mean vector, and rotation of the Earth. [rad/s]
    tolerance : float
        Difference that noise and the stated bias allow. [rad/s]
    bias : float or None
        The stated bias of a gyro. [rad/s]
    agrees : bool
        Whether the difference is within the tolerance. If not and no bias is stated, the mean is too small.
    """

    code: ClassVar[str] = "earth_rate"
    mean: float
    earth_rate: float
    tolerance: float
    bias: float | None
    agrees: bool
