"""Kinds of findings about curves and fits, and why a fit is not adequate or leaves out averaging times."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from sigmatau.findings.finding import Details

__all__ = [
    "AngleNoiseUndetermined",
    "CheckedInPart",
    "CheckedWithoutFit",
    "CoarseValues",
    "ConstantChannel",
    "FilterTakenForProcess",
    "FlickerAngleNoise",
    "IsolatedSamples",
    "Misfit",
    "NoAdequateModel",
    "NoCovariance",
    "NoMap",
    "OutOfRange",
    "Reason",
    "ShortTimesDeviate",
    "ShortTimesLeftOut",
    "SinusoidFitted",
    "Strided",
    "TooFewSamples",
    "TooFewTimes",
    "TooShort",
    "WhiteAngleNoise",
    "ZeroVariance",
]


@dataclass(frozen=True, slots=True, kw_only=True)
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


@dataclass(frozen=True, slots=True, kw_only=True)
class ZeroVariance:
    """Not fitted: an Allan variance is 0."""

    kind: str = field(default="zero_variance", init=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Misfit:
    """Not adequate: neither the five terms nor a sixth fit the curve.

    Attributes
    ----------
    p_value : float or None
        Largest p-value of the goodness of fit of all models tried; None if no model could be fitted.
    tau_min : float
        Shortest averaging time of that fit. [s]
    tau : float
        Averaging time with the largest misfit. [s]
    ratio : float
        Measured Allan deviation over that of the model at `tau`.
    """

    kind: str = field(default="misfit", init=False)
    p_value: float | None
    tau_min: float
    tau: float
    ratio: float


@dataclass(frozen=True, slots=True, kw_only=True)
class NoCovariance:
    """Not adequate: the model fits, but the covariance of nearby values cannot be computed."""

    kind: str = field(default="no_covariance", init=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class ShortTimesDeviate:
    """The shortest averaging times do not follow the model and are left out.

    Attributes
    ----------
    cluster_size : int
        Averaging time with the largest deviation. [samples]
    ratio : float
        Measured Allan deviation over that of the model there; below 1 as behind a low-pass filter.
    """

    kind: str = field(default="short_times_deviate", init=False)
    cluster_size: int
    ratio: float


@dataclass(frozen=True, slots=True, kw_only=True)
class IsolatedSamples:
    """Missing samples leave no two consecutive ones: quantization noise looks like a random walk and is part of it."""

    kind: str = field(default="isolated_samples", init=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class CoarseValues:
    """Not adequate: the resolution of the values is too coarse for the noise, so that the rounding error is unknown."""

    kind: str = field(default="coarse_values", init=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class FilterTakenForProcess:
    """A fit from shorter times on takes a low-pass filter for a Gauss-Markov process and shows no random walk.

    Attributes
    ----------
    corner : float
        Corner frequency of the filter. [Hz]
    correlation_time : float
        Of the process. [s]
    tau_min : float
        Shortest averaging time of that fit. [s]
    """

    kind: str = field(default="filter_taken_for_process", init=False)
    corner: float
    correlation_time: float
    tau_min: float


Reason = (
    TooFewTimes
    | ZeroVariance
    | Misfit
    | NoCovariance
    | ShortTimesDeviate
    | IsolatedSamples
    | CoarseValues
    | FilterTakenForProcess
)
"""Why there is no fit, why a fit is not adequate, or why its shortest averaging times are left out."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TooShort(Details):
    """The channel is not fitted.

    Attributes
    ----------
    reasons : tuple of Reason
    missing : float
        Share of the samples that is missing.
    """

    code: ClassVar[str] = "too_short"

    reasons: tuple[Reason, ...]
    missing: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class NoAdequateModel(Details):
    """The coefficients describe the curve and have no intervals."""

    code: ClassVar[str] = "no_adequate_model"

    reasons: tuple[Reason, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ShortTimesLeftOut(Details):
    """The fit begins beyond the shortest averaging time; the reasons are empty where that was asked for.

    Attributes
    ----------
    tau_min : float
        [s]
    reasons : tuple of Reason
    """

    code: ClassVar[str] = "short_times_left_out"

    tau_min: float
    reasons: tuple[Reason, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class SinusoidFitted(Details):
    """A sinusoid was fitted beside the five terms; the size of the finding is its amplitude.

    Attributes
    ----------
    frequency : float
        [Hz]
    """

    code: ClassVar[str] = "sinusoid_fitted"

    frequency: float


@dataclass(frozen=True, slots=True, kw_only=True)
class OutOfRange(Details):
    """The squares of the Allan deviations cannot be squared again in double precision: the channel is not analysed.

    Attributes
    ----------
    largest : float
        Largest Allan deviation. [rate_unit]
    rate_unit : str
    """

    code: ClassVar[str] = "out_of_range"

    largest: float
    rate_unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ConstantChannel(Details):
    """The samples differ by no more than rounding: the channel is not analysed.

    Attributes
    ----------
    samples : int
    value : float or None
        The first sample; None if only the curve is known. [rate_unit]
    rate_unit : str
    """

    code: ClassVar[str] = "constant_channel"

    samples: int
    value: float | None = None
    rate_unit: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class TooFewSamples(Details):
    """So many samples are missing that there is no Allan variance: the channel is not analysed."""

    code: ClassVar[str] = "too_few_samples"

    missing: int
    samples: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Strided(Details):
    """Long clusters do not begin at every sample.

    Attributes
    ----------
    tau : float
        Shortest averaging time of such clusters. [s]
    samples : int
        Length of the record.
    out_of_memory : bool
        Whether the reason is that the record does not fit in memory, and not an option.
    """

    code: ClassVar[str] = "strided"

    tau: float
    samples: int
    out_of_memory: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class NoMap(Details):
    """The record is too short for the dynamic Allan deviation.

    Attributes
    ----------
    samples, needed : int
    """

    code: ClassVar[str] = "no_map"

    samples: int
    needed: int


@dataclass(frozen=True, slots=True, kw_only=True)
class WhiteAngleNoise(Details):
    """Short averaging times show white noise of the angle, as quantization makes; not flicker noise of the angle.

    Attributes
    ----------
    quantity : str
    share : float
        Of the Allan variance at `tau`.
    tau : float
        [s]
    """

    code: ClassVar[str] = "white_angle_noise"

    quantity: str
    share: float
    tau: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FlickerAngleNoise(Details):
    """Short averaging times show flicker noise of the angle, which is not a term of the model.

    Attributes
    ----------
    quantity : str
    share : float
        Of the Allan variance at `tau`.
    tau : float
        [s]
    quantization_fitted : bool
        Whether the fit describes it by a quantization coefficient.
    """

    code: ClassVar[str] = "flicker_angle_noise"

    quantity: str
    share: float
    tau: float
    quantization_fitted: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class AngleNoiseUndetermined(Details):
    """Short averaging times show quantization or flicker noise of the angle; the Allan deviation cannot tell which."""

    code: ClassVar[str] = "angle_noise_untold"

    quantity: str


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckedInPart(Details):
    """Only the beginning of a long record is checked for faults.

    Attributes
    ----------
    checked, samples : int
        Samples that are checked, and all.
    duration : float
        Of the samples that are checked. [s]
    """

    code: ClassVar[str] = "checked_in_part"

    checked: int
    samples: int
    duration: float


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckedWithoutFit(Details):
    """The record is too long for a quick fit, so that the checks that need a fit are left out.

    Attributes
    ----------
    samples : int
        Of all channels together.
    """

    code: ClassVar[str] = "checked_without_fit"

    samples: int
