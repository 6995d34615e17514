"""Kinds of findings about sample values: held, repeated, lost, saturated, interpolated, coarse, in a wrong unit."""

from __future__ import annotations

from typing import Literal

from sigmatau.findings.finding import Details
from sigmatau.frozen import frozen


@frozen
class HeldRuns(Details):
    """Runs of samples that are not the sensor's: base of `Dropout` and `StuckSamples`. Of the channel with the most."""

    samples: int  # samples concerned
    share: float  # part of all samples
    runs: int  # number of runs
    start: float  # beginning of the longest run, from the beginning of the record, and its length [s]
    longest: float


@frozen
class Dropout(HeldRuns, code="dropout"):
    """The log holds the number 0 where samples were lost."""


@frozen
class StuckSamples(HeldRuns, code="stuck_samples"):
    """Runs of equal samples longer than the noise can explain."""


@frozen
class Saturation(Details, code="saturation"):
    """Samples at an end of the measuring range."""

    strongest: str  # the channel with the largest effect, which all numbers are of
    samples: int  # samples at an end of the range
    share: float  # part of all samples
    low: float | None  # the ends that are reached [unit]
    high: float | None
    unit: str
    start: float  # time of the first of these samples, from the beginning of the record [s]
    longest: float  # longest run of one value; 0 if no run is longer than the noise can explain [s]
    spread: bool  # whether these samples are spread over the whole record, so that the effect on white noise is known


@frozen
class RepeatedSamples(Details, code="repeated_samples"):
    """Samples that equal the one before, more often than chance makes them."""

    # a sensor at a lower rate than its log; copies at irregular places; single rows that are in the log twice
    pattern: Literal["held", "irregular", "rows"]
    copies: int  # samples that equal the one before
    share: float  # part of all samples
    times: float  # how often a sample occurs on average
    shortest: int  # how often a sample occurs, without the rarest 2.5 % at either end
    longest: int
    log_rate: float  # rate of the rows [Hz]
    sensor_rate: float  # rate of distinct samples [Hz]
    rate_given: bool  # whether the rate was given by the user, so that it may be the sensor's and not that of the rows
    sigma_one_sample: float  # σ at one sample over that of white noise with the same σ at long averaging times
    right_from: int  # number of samples from which on σ is right
    # random walk over the sensor's own, if the sensor runs at the rate of the log or at that of distinct samples
    walk_at_log_rate: float
    walk_at_sensor_rate: float


@frozen
class Upsampled:
    """How all samples were interpolated from a lower rate."""

    sensor_rate: float  # rate of the samples before, and of the log [Hz]
    log_rate: float
    aligned: bool  # whether the sensor's samples are among those of the log
    sigma_one_sample: float  # σ at one sample over that of the sensor's white noise
    right_from: float  # averaging time from which on σ is right [s]


@frozen
class FilledOutages:
    """Long stretches that were filled in with straight lines."""

    count: int
    start: float  # beginning of the longest, from the beginning of the record, and its length [s]
    longest: float


@frozen
class FilledSamples:
    """Single lost samples that were filled in with straight lines."""

    random_walk: float  # random walk over the sensor's own, at all averaging times of more than some samples
    sigma_one_sample: float  # σ at one sample over the sensor's own


@frozen
class Interpolated(Details, code="interpolated"):
    """Samples on the straight line through their neighbours: all made from a lower rate, or lost ones filled in."""

    strongest: str  # the channel which all numbers are of
    share: float  # part of the samples that were made up: single ones if there are `singles`, else all
    upsampled: Upsampled | None = None
    outages: FilledOutages | None = None
    singles: FilledSamples | None = None  # those of the three that were found


@frozen
class CoarseResolution(Details, code="coarse_resolution"):
    """A step of the numbers that is coarse against the noise."""

    step: float  # step of the numbers and standard deviation of the white part of a sample [unit]
    noise: float
    unit: str
    # what rounding adds: quantization noise to increments, white noise to rates; neither below half a step of noise
    rounding: Literal["quantization", "white", "unknown"]
    added: float | None  # coefficient of the noise added: Q [unit·s], at most, or N [unit·√s]; None if unknown


@frozen
class ImplausibleUnit(Details, code="implausible_unit"):
    """Samples that are probably in another unit than stated."""

    # mean of an accelerometer triad; a step known from datasheets; noise beyond that of all gyros; a bias too large for
    # gyros with so little noise
    evidence: Literal["gravity", "step", "noise", "bias"]
    quantity: str  # what the stream measures
    stated: str = ""  # the unit that was stated, and the one that the samples look like; empty if no unit explains them
    likely: str = ""
    option: str = ""  # option of the command line that corrects it; empty if only a scale for raw counts can
    mean: float | None = None  # length of the mean vector [SI unit of the stream]
    noise: float | None = None  # white noise [SI unit of the stream, per √Hz]
    step: float | None = None  # step of the numbers [SI unit of the stream]
    sensitivity: float | None = None  # the known sensitivity that the step agrees with [LSB per deg/s]
    times: float | None = None  # white noise over that of the noisiest gyros


@frozen
class Gravity(Details, code="gravity"):
    """A mean acceleration that is not gravity."""

    mean: float  # length of the mean vector [m/s^2]
    deviation: float  # how far it is from standard gravity, as a part of it; negative if less
    low: float  # gravity on the ground [m/s^2]
    high: float
    cause: Literal["bias_or_scale", "removed", "unknown"]
