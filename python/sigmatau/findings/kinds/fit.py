"""Kinds of findings about curves and fits, and why a fit is not adequate or leaves out averaging times."""

from __future__ import annotations

from dataclasses import field

from sigmatau.findings.finding import Details
from sigmatau.frozen import frozen

MOST_LINES = 100
"""Lines of a fit that are kept, the strongest: a record that repeats itself has thousands."""


@frozen
class TooFewTimes:
    """Not fitted: too few averaging times up to a third of the record.

    Attributes
    ----------
    times, needed : int
        Averaging times that there are, and that a fit needs.
    samples : int
        Length of the record.
    """

    kind: str = field(default="too_few_times", init=False)
    times: int
    needed: int
    samples: int


@frozen
class ZeroVariance:
    """Not fitted: an Allan variance is 0."""

    kind: str = field(default="zero_variance", init=False)


@frozen
class Misfit:
    """Not adequate: neither the five terms nor a Gauss-Markov process beside them fit the curve.

    Attributes
    ----------
    p_value : float or None
        Largest p-value of the goodness of fit of all models tried; None if no model could be fitted.
    tau_min : float
        Shortest averaging time of that fit. [s]
    tau : float
        Averaging time with the largest misfit. [s]
    ratio : float
        Measured Allan deviation over that of the model at `tau`. [1]
    """

    kind: str = field(default="misfit", init=False)
    p_value: float | None
    tau_min: float
    tau: float
    ratio: float


@frozen
class VibrationPower:
    """Disturbed: lines and narrow resonances have most of the power of the record.

    Attributes
    ----------
    lines, resonances : int
        Number of each in the model.
    share : float
        Their share of the power, beside random walk and quantization noise.
    start, stop : float
        The part of the record in which the random walk has the smallest upper limit. [s]
    quietest : float or None
        That limit, if it is smaller than that of the whole record. [SI]
    """

    kind: str = field(default="vibration_power", init=False)
    lines: int
    resonances: int
    share: float
    start: float
    stop: float
    quietest: float | None


@frozen
class NoCovariance:
    """Not adequate: the model fits, but the covariance of nearby values cannot be computed."""

    kind: str = field(default="no_covariance", init=False)


@frozen
class ShortTimesDeviate:
    """The shortest averaging times do not follow the model and are left out.

    Attributes
    ----------
    cluster_size : int
        Averaging time with the largest deviation. [samples]
    ratio : float
        Measured Allan deviation over that of the model there; below 1 as behind a low-pass filter. [1]
    """

    kind: str = field(default="short_times_deviate", init=False)
    cluster_size: int
    ratio: float


@frozen
class IncompleteRecord:
    """Not fitted: samples are missing, and least squares needs all.

    Attributes
    ----------
    missing : int
        Samples that are missing.
    samples : int
        Samples in the record.
    suits_likelihood : bool
        Whether the other samples are enough for the likelihood, which allows for missing ones.
    """

    kind: str = field(default="incomplete_record", init=False)
    missing: int
    samples: int
    suits_likelihood: bool = True


@frozen
class CoarseValues:
    """Widened: the resolution of the values is too coarse for the noise, so that the rounding error is unknown."""

    kind: str = field(default="coarse_values", init=False)


@frozen
class CoarseCounts:
    """The rounding of the angle is not white from increment to increment, so that the fit is that of sums of increments.

    Attributes
    ----------
    summed : int or None
        Increments in a sum; None if no sum in the record has white rounding.
    hidden : bool
        Whether the record has too few such sums: all terms are upper limits.
    """

    kind: str = field(default="coarse_counts", init=False)
    summed: int | None
    hidden: bool


@frozen
class BandLeftOut:
    """The spectrum from a frequency on has a shape that no model describes, and is left out.

    Attributes
    ----------
    highest : float
        [Hz]
    """

    kind: str = field(default="band_left_out", init=False)
    highest: float


@frozen
class CrowdedLines:
    """Widened: spectral lines take so much of the band that they may be noise.

    Attributes
    ----------
    lines : int
        Lines of the model.
    share : float
        Share of the band that they take. [1]
    highest : float
        Upper end of the interval of the random walk if they are noise. [SI]
    """

    kind: str = field(default="crowded_lines", init=False)
    lines: int
    share: float
    highest: float


@frozen
class BandsOff:
    """Widened: the best model is off the spectrum in some bands.

    Attributes
    ----------
    frequency : float
        Where it is worst. [Hz]
    ratio : float
        Measured density over that of the model there. [1]
    """

    kind: str = field(default="bands_off", init=False)
    frequency: float
    ratio: float


@frozen
class StatedReason:
    """A reason in words, of a result of another version of sigmatau.

    Attributes
    ----------
    text : str
    """

    kind: str = field(default="stated", init=False)
    text: str


Reason = (
    TooFewTimes
    | ZeroVariance
    | Misfit
    | NoCovariance
    | ShortTimesDeviate
    | IncompleteRecord
    | CoarseValues
    | CoarseCounts
    | CrowdedLines
    | BandLeftOut
    | BandsOff
    | VibrationPower
    | StatedReason
)
"""Why there is no fit, why a fit is not adequate, or why its shortest averaging times are left out."""


@frozen
class TooShort(Details, code="too_short"):
    """The channel is not fitted.

    Attributes
    ----------
    reasons : tuple of Reason
        Why; see the kinds of reasons in this module.
    missing : float
        Share of the samples that is missing.
    """

    reasons: tuple[Reason, ...]
    missing: float = 0.0


@frozen
class NoAdequateModel(Details, code="no_adequate_model", alters_all=True):
    """The coefficients describe the curve and have no intervals.

    Attributes
    ----------
    reasons : tuple of Reason
        Why; see the kinds of reasons in this module.
    """

    reasons: tuple[Reason, ...]


@frozen
class Widened(Details, code="widened"):
    """The best model does not fit the spectrum exactly, and the intervals allow for it; the size is that of the
    random walk, relative.

    Attributes
    ----------
    frequency : float
        Frequency of the largest misfit. [Hz]
    ratio : float
        Measured density over that of the model there. [1]
    allowed : float
        Largest standard deviation of the logarithm of the density that the intervals allow for.
    lines : int
        Spectral lines of the model.
    crowded : float
        Share of the band that the lines take, if it is so much that they may be noise; otherwise 0. [1]
    """

    frequency: float
    ratio: float
    allowed: float
    lines: int = 0
    crowded: float = 0.0

    def possible_factors(self, size: float | None) -> dict[str, float]:
        """The upper end of the interval of the random walk over its value."""
        return {} if size is None else {"random_walk": 1 + size}


@frozen
class Disturbed(Details, code="disturbed"):
    """Vibration has most of the power of the record, so that the coefficients are upper limits.

    Attributes
    ----------
    quantity, rate_unit : str
        Of the channel.
    lines, resonances : int
        Number of each in the model.
    share : float
        Their share of the power, beside random walk and quantization noise.
    start, stop : float
        The quietest part of the record; both 0 for several runs. [s]
    quietest : float or None
        Upper limit of the random walk in that part, if it is smaller than that of the whole record. [SI]
    """

    quantity: str
    rate_unit: str
    lines: int
    resonances: int
    share: float
    start: float
    stop: float
    quietest: float | None


@frozen
class BeyondClass(Details, code="beyond_class"):
    """More noise than the noisiest sensors for sale, or a steeper ramp; the size is the density, or the ramp.

    Attributes
    ----------
    quantity : str
        Of the channel.
    times : float
        Size over that of the noisiest sensor. [1]
    frequency : float or None
        Frequency of the density with the largest ratio; None for a ramp. [Hz]
    """

    quantity: str
    times: float
    frequency: float | None


@frozen
class FewDegreesOfFreedom(Details, code="few_degrees_of_freedom"):
    """The random walk of the fit has few degrees of freedom; the size is their number.

    Attributes
    ----------
    freedom : float
        Of its square, from its standard error. [1]
    duration : float
        Of the record. [s]
    """

    freedom: float
    duration: float


@frozen
class ShortTimesLeftOut(Details, code="short_times_left_out"):
    """The fit begins beyond the shortest averaging time; the reasons are empty if this was requested.

    Attributes
    ----------
    tau_min : float
        [s]
    reasons : tuple of Reason
        Why; see the kinds of reasons in this module.
    """

    tau_min: float
    reasons: tuple[Reason, ...] = ()


@frozen
class OutOfRange(Details, code="out_of_range"):
    """The squares of the Allan deviations cannot be squared again in double precision: the channel is not analysed.

    Attributes
    ----------
    largest : float
        Largest Allan deviation. [rate_unit]
    rate_unit : str
        SI unit of the channel.
    """

    largest: float
    rate_unit: str


@frozen
class ConstantChannel(Details, code="constant_channel"):
    """The samples differ by no more than rounding: the channel is not analysed.

    Attributes
    ----------
    samples : int
        Samples in the record.
    value : float or None
        The first sample; None if only the curve is known. [rate_unit]
    rate_unit : str
        SI unit of the channel.
    """

    samples: int
    value: float | None = None
    rate_unit: str = ""


@frozen
class TooFewSamples(Details, code="too_few_samples"):
    """Too many samples are missing for an Allan variance: the channel is not analysed.

    Attributes
    ----------
    missing : int
        Samples that are missing.
    samples : int
        Samples in the record.
    """

    missing: int
    samples: int


@frozen
class Strided(Details, code="strided"):
    """Long clusters do not begin at every sample.

    Attributes
    ----------
    tau : float
        Shortest averaging time of such clusters. [s]
    samples : int
        Length of the record.
    out_of_memory : bool
        Whether the record does not fit in memory; otherwise an option was given.
    """

    tau: float
    samples: int
    out_of_memory: bool = False


@frozen
class NoMap(Details, code="no_map"):
    """The record is too short for the dynamic Allan deviation.

    Attributes
    ----------
    samples : int
        Samples in the record.
    needed : int
        Samples that a map needs.
    """

    samples: int
    needed: int


@frozen
class CheckedInPart(Details, code="checked_in_part"):
    """Only the beginning of a long record is checked for faults.

    Attributes
    ----------
    checked, samples : int
        Samples that are checked, and all.
    duration : float
        Of the samples that are checked. [s]
    """

    checked: int
    samples: int
    duration: float


@frozen
class CheckedWithoutFit(Details, code="checked_without_fit"):
    """The record is too long for a quick fit; the checks that need a fit are omitted.

    Attributes
    ----------
    samples : int
        Of all channels together.
    """

    samples: int
