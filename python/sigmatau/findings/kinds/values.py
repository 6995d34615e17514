"""Kinds of findings about sample values: held, repeated, lost, saturated, interpolated, coarse, in a wrong unit."""

from __future__ import annotations

from typing import Literal

from sigmatau.findings.finding import Details
from sigmatau.frozen import frozen


@frozen
class HeldRuns(Details):
    """Runs of samples that are not the sensor's: base of `Dropout` and `StuckSamples`. Of the channel with the most.

    Attributes
    ----------
    samples : int
        Samples concerned.
    share : float
        Part of all samples. [1]
    runs : int
        Number of runs.
    start, longest : float
        Beginning of the longest run, from the beginning of the record, and its length. [s]
    """

    samples: int
    share: float
    runs: int
    start: float
    longest: float


@frozen
class Dropout(HeldRuns, code="dropout"):
    """The log contains the number 0 in place of lost samples."""


@frozen
class StuckSamples(HeldRuns, code="stuck_samples"):
    """Runs of equal samples longer than the noise can explain."""


@frozen
class Saturation(Details, code="saturation"):
    """Samples at an end of the measuring range.

    Attributes
    ----------
    strongest : str
        The channel with the largest effect, to which all numbers refer.
    samples : int
        Samples at an end of the range.
    share : float
        Part of all samples. [1]
    low, high : float or None
        The ends that are reached. [unit]
    unit : str
        Of the stream; SI.
    start : float
        Time of the first of these samples, from the beginning of the record. [s]
    longest : float
        Longest run of one value; 0 if no run is longer than the noise can explain. [s]
    spread : bool
        Whether these samples are spread over the whole record, so that the effect on white noise is known.
    """

    strongest: str
    samples: int
    share: float
    low: float | None
    high: float | None
    unit: str
    start: float
    longest: float
    spread: bool

    @property
    def biases_walk(self) -> bool:
        """A saturated sample is nearer to the mean in each fit."""
        return self.spread


@frozen
class CopiedStretch(Details, code="copied_stretch"):
    """A stretch of rows that equals another one of the record on all axes; the size is its length.

    Attributes
    ----------
    start, copy : float
        First rows of the stretch and of its copy. [s]
    duration : float
        [s]
    rows : int
        Number of equal rows.
    """

    start: float
    copy: float
    duration: float
    rows: int


@frozen
class RepeatedSamples(Details, code="repeated_samples"):
    """Samples that equal the previous sample more often than by chance.

    Attributes
    ----------
    pattern : {"held", "irregular", "rows"}
        A sensor at a lower rate than its log; copies at irregular places; single rows that are in the log twice.
    copies : int
        Samples that equal the one before.
    share : float
        Part of all samples. [1]
    times : float
        How often a sample occurs on average. [1]
    shortest, longest : int
        How often a sample occurs, without the rarest 2.5 % at either end.
    log_rate : float
        Rate of the rows. [Hz]
    sensor_rate : float
        Rate of distinct samples. [Hz]
    rate_given : bool
        Whether the rate was given by the user, so that it may be the sensor's and not that of the rows.
    sigma_one_sample : float
        σ at one sample over that of white noise with the same σ at long averaging times. [1]
    right_from : int
        Number of samples from which on σ is right.
    walk_at_log_rate, walk_at_sensor_rate : float
        Random walk over the sensor's own, if the sensor runs at the rate of the log or at that of distinct samples. [1]
    """

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

    @property
    def biases_walk(self) -> bool:
        """A sample that counts more often does so at all averaging times."""
        return True


@frozen
class Upsampled:
    """How all samples were interpolated from a lower rate.

    Attributes
    ----------
    sensor_rate, log_rate : float
        Rate of the samples before, and of the log. [Hz]
    aligned : bool
        Whether the sensor's samples are among those of the log.
    sigma_one_sample : float
        σ at one sample over that of the sensor's white noise. [1]
    right_from : float
        Averaging time from which on σ is right. [s]
    """

    sensor_rate: float
    log_rate: float
    aligned: bool
    sigma_one_sample: float
    right_from: float


@frozen
class FilledOutages:
    """Long stretches that were filled in with straight lines.

    Attributes
    ----------
    count : int
        How many.
    start, longest : float
        Beginning of the longest, from the beginning of the record, and its length. [s]
    """

    count: int
    start: float
    longest: float


@frozen
class FilledSamples:
    """Single lost samples that were filled in with straight lines.

    Attributes
    ----------
    random_walk : float
        Random walk over the sensor's own, at all averaging times of more than some samples. [1]
    sigma_one_sample : float
        σ at one sample over the sensor's own. [1]
    """

    random_walk: float
    sigma_one_sample: float


@frozen
class Interpolated(Details, code="interpolated"):
    """Samples on the straight line through their neighbours: resampled from a lower rate, or lost samples filled in.

    Attributes
    ----------
    strongest : str
        The channel to which all numbers refer.
    share : float
        Share of filled-in samples: of single samples if there are `singles`, otherwise of all. [1]
    upsampled : Upsampled or None
        If all samples were made from a lower rate.
    outages : FilledOutages or None
        If long stretches were filled in.
    singles : FilledSamples or None
        If single samples were filled in.
    """

    strongest: str
    share: float
    upsampled: Upsampled | None = None
    outages: FilledOutages | None = None
    singles: FilledSamples | None = None

    @property
    def biases_walk(self) -> bool:
        """Filled samples change the random walk; a lower rate changes σ at short averaging times alone."""
        return self.singles is not None


@frozen
class CoarseResolution(Details, code="coarse_resolution"):
    """A resolution that is coarse relative to the noise.

    Attributes
    ----------
    step, noise : float
        Step of the numbers and standard deviation of the white part of a sample. [unit]
    unit : str
        Of the stream; SI.
    rounding : {"quantization", "white", "unknown"}
        What rounding adds: quantization noise to increments, white noise to rates; neither below half a step of noise.
    added : float or None
        Coefficient of the noise added: Q [unit·s], at most, or N [unit·√s]; None if unknown.
    summed : int or None
        Increments that must be summed for white rounding of the angle; None if no sum in the record is long enough.
    needed : float or None
        Shortest record that shows the random walk in such sums, if this one does not. [s]
    """

    step: float
    noise: float
    unit: str
    rounding: Literal["quantization", "white", "unknown"]
    added: float | None
    summed: int | None = 1
    needed: float | None = None

    @property
    def biases_walk(self) -> bool:
        """White rounding is in the random walk of each fit."""
        return self.rounding == "white"


@frozen
class ImplausibleUnit(Details, code="implausible_unit"):
    """Samples that are probably in another unit than stated.

    Attributes
    ----------
    evidence : {"gravity", "step", "noise", "bias", "quiet", "earth"}
        Mean of an accelerometer triad; a step known from datasheets; noise beyond that of all gyros; a bias too large
        for gyros with so little noise; noise below that of all sensors; gyros with so little noise that do not measure the
        Earth's rotation.
    quantity : str
        Quantity that the stream measures.
    stated, likely : str
        The unit that was stated, and the one that the samples look like; empty if no unit explains them.
    option : str
        Option of the command line that corrects it; empty if only a scale for raw counts can.
    mean : float or None
        Length of the mean vector. [SI unit of the stream]
    noise : float or None
        White noise. [SI unit of the stream, per √Hz]
    step : float or None
        Step of the numbers. [SI unit of the stream]
    sensitivity : float or None
        The known sensitivity that the step agrees with. [LSB per deg/s]
    times : float or None
        White noise over that of the noisiest gyros. [1]
    by_file : bool
        Whether the file states the unit. A gyro's is not doubted then, and `likely` is empty.
    """

    evidence: Literal["gravity", "step", "noise", "bias", "quiet", "earth"]
    quantity: str
    stated: str = ""
    likely: str = ""
    option: str = ""
    mean: float | None = None
    noise: float | None = None
    step: float | None = None
    sensitivity: float | None = None
    times: float | None = None
    by_file: bool = False


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
        Gravity on the ground. [m/s^2]
    cause : {"bias_or_scale", "removed", "unknown"}
        Possible cause.
    """

    mean: float
    deviation: float
    low: float
    high: float
    cause: Literal["bias_or_scale", "removed", "unknown"]


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
