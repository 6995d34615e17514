"""Kinds of findings about curves and fits, and why a fit is not adequate or leaves out averaging times."""

from __future__ import annotations

from dataclasses import field

from sigmatau.findings.finding import Details
from sigmatau.frozen import frozen


@frozen
class TooFewTimes:
    """Not fitted: too few averaging times up to a third of the record."""

    kind: str = field(default="too_few_times", init=False)
    times: int  # averaging times that there are, and that a fit needs
    needed: int
    samples: int  # length of the record


@frozen
class ZeroVariance:
    """Not fitted: an Allan variance is 0."""

    kind: str = field(default="zero_variance", init=False)


@frozen
class Misfit:
    """Not adequate: neither the five terms nor a Gauss-Markov process beside them fit the curve."""

    kind: str = field(default="misfit", init=False)
    # largest p-value of the goodness of fit of all models tried; None if no model could be fitted
    p_value: float | None
    tau_min: float  # shortest averaging time of that fit [s]
    tau: float  # averaging time with the largest misfit [s]
    ratio: float  # measured Allan deviation over that of the model at `tau`


@frozen
class NoCovariance:
    """Not adequate: the model fits, but the covariance of nearby values cannot be computed."""

    kind: str = field(default="no_covariance", init=False)


@frozen
class ShortTimesDeviate:
    """The shortest averaging times do not follow the model and are left out."""

    kind: str = field(default="short_times_deviate", init=False)
    cluster_size: int  # averaging time with the largest deviation [samples]
    ratio: float  # measured Allan deviation over that of the model there; below 1 as behind a low-pass filter


@frozen
class IncompleteRecord:
    """Not fitted: samples are missing, and least squares needs all."""

    kind: str = field(default="incomplete_record", init=False)
    missing: int
    samples: int


@frozen
class CoarseValues:
    """Widened: the resolution of the values is too coarse for the noise, so that the rounding error is unknown."""

    kind: str = field(default="coarse_values", init=False)


@frozen
class BandLeftOut:
    """The spectrum from a frequency on has a shape that no model describes, and is left out."""

    kind: str = field(default="band_left_out", init=False)
    highest: float  # [Hz]


@frozen
class BandsOff:
    """Widened: the best model is off the spectrum in some bands."""

    kind: str = field(default="bands_off", init=False)
    frequency: float  # where it is worst [Hz]
    ratio: float  # measured density over that of the model there


Reason = (
    TooFewTimes
    | ZeroVariance
    | Misfit
    | NoCovariance
    | ShortTimesDeviate
    | IncompleteRecord
    | CoarseValues
    | BandLeftOut
    | BandsOff
)
"""Why there is no fit, why a fit is not adequate, or why its shortest averaging times are left out."""


@frozen
class TooShort(Details, code="too_short"):
    """The channel is not fitted."""

    reasons: tuple[Reason, ...]
    missing: float = 0.0  # share of the samples that is missing


@frozen
class NoAdequateModel(Details, code="no_adequate_model"):
    """The coefficients describe the curve and have no intervals."""

    reasons: tuple[Reason, ...]


@frozen
class Widened(Details, code="widened"):
    """The best model is off the spectrum, and the intervals allow for it; the size is the random walk's, relative."""

    frequency: float  # where the model is worst [Hz]
    ratio: float  # measured density over that of the model there
    allowed: float  # largest standard deviation of the logarithm of the density that the intervals allow for
    lines: int = 0  # spectral lines of the model


@frozen
class ShortTimesLeftOut(Details, code="short_times_left_out"):
    """The fit begins beyond the shortest averaging time; the reasons are empty where that was asked for."""

    tau_min: float  # [s]
    reasons: tuple[Reason, ...] = ()


@frozen
class OutOfRange(Details, code="out_of_range"):
    """The squares of the Allan deviations cannot be squared again in double precision: the channel is not analysed."""

    largest: float  # largest Allan deviation [rate_unit]
    rate_unit: str


@frozen
class ConstantChannel(Details, code="constant_channel"):
    """The samples differ by no more than rounding: the channel is not analysed."""

    samples: int
    value: float | None = None  # the first sample; None if only the curve is known [rate_unit]
    rate_unit: str = ""


@frozen
class TooFewSamples(Details, code="too_few_samples"):
    """So many samples are missing that there is no Allan variance: the channel is not analysed."""

    missing: int
    samples: int


@frozen
class Strided(Details, code="strided"):
    """Long clusters do not begin at every sample."""

    tau: float  # shortest averaging time of such clusters [s]
    samples: int  # length of the record
    out_of_memory: bool = False  # whether the reason is that the record does not fit in memory, and not an option


@frozen
class NoMap(Details, code="no_map"):
    """The record is too short for the dynamic Allan deviation."""

    samples: int
    needed: int


@frozen
class CheckedInPart(Details, code="checked_in_part"):
    """Only the beginning of a long record is checked for faults."""

    checked: int  # samples that are checked, and all
    samples: int
    duration: float  # of the samples that are checked [s]


@frozen
class CheckedWithoutFit(Details, code="checked_without_fit"):
    """The record is too long for a quick fit, so that the checks that need a fit are left out."""

    samples: int  # of all channels together
