"""Reasons why a channel has no fit, why a fit is not adequate, or why it leaves out averaging times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field

from sigmatau.digits import two_digits
from sigmatau.findings.phrases import percent
from sigmatau.frozen import frozen
from sigmatau.results import seconds

_SMALLEST_P = 1e-12  # smaller p-values are rounding errors
MAX_LINES = 100
"""Largest number of lines of a fit that are listed, the strongest ones: a periodic record has thousands."""


@frozen
class TooFewTimes:
    """Not fitted: too few averaging times up to a third of the record.

    Attributes
    ----------
    times, needed : int
        Number of averaging times, and number that a fit needs.
    samples : int
        Length of the record.
    """

    kind: str = field(default="too_few_times", init=False)
    times: int
    needed: int
    samples: int

    @property
    def text(self) -> str:
        return (
            f"only {self.times} averaging time{'' if self.times == 1 else 's'} up to a third of {self.samples} samples;"
            f" a fit needs {self.needed}"
        )


@frozen
class ZeroVariance:
    """Not fitted: an Allan variance is 0."""

    kind: str = field(default="zero_variance", init=False)

    @property
    def text(self) -> str:
        return "an Allan variance is 0, which noise cannot cause"


@frozen
class Misfit:
    """Not adequate: the five terms do not fit the curve, even with a Gauss-Markov process.

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

    @property
    def text(self) -> str:
        return f"σ({seconds(self.tau)} s) is {off_text(self.ratio)} the best fit{_p_text(self)}"


@frozen
class VibrationPower:
    """Disturbed: lines and narrow resonances have most of the power of the record, or there is intermittent motion.

    Attributes
    ----------
    lines, resonances : int
        Number of each in the model.
    share : float
        Share of the power of all lines and resonances; random walk and quantization noise have the rest. Otherwise the
        share of the motion at the loudest times.
    start, stop : float
        The part of the record in which the random walk has the smallest upper limit. [s]
    quietest : float or None
        This limit, if it is smaller than the limit of the whole record. [SI]
    """

    kind: str = field(default="vibration_power", init=False)
    lines: int
    resonances: int
    share: float
    start: float
    stop: float
    quietest: float | None

    @property
    def text(self) -> str:
        return f"vibration has {percent(self.share)} of the power"


@frozen
class NoCovariance:
    """Not adequate: the model fits, but the covariance of nearby values cannot be computed."""

    kind: str = field(default="no_covariance", init=False)

    @property
    def text(self) -> str:
        return "too few averaging times to compute the covariance of the coefficients"


@frozen
class ShortTimesDeviate:
    """The shortest averaging times do not follow the model and are left out.

    Attributes
    ----------
    cluster_size : int
        Averaging time with the largest deviation. [samples]
    ratio : float
        Measured Allan deviation over that of the model at this time. Below 1 after a low-pass filter. [1]
    """

    kind: str = field(default="short_times_deviate", init=False)
    cluster_size: int
    ratio: float

    @property
    def text(self) -> str:
        return (
            f"σ at {self.cluster_size} sample{'s' if self.cluster_size > 1 else ''} is {off_text(self.ratio)} the model,"
            f" {'as after a low-pass filter' if self.ratio < 1 else 'because of other noise or a disturbance'}"
        )


@frozen
class IncompleteRecord:
    """Not fitted: samples are missing, and least squares needs all samples.

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

    @property
    def text(self) -> str:
        return f"{self.missing} of {self.samples} samples are missing, and " + (
            "least squares needs all" if self.suits_likelihood else "the others are too few for a fit"
        )


@frozen
class CoarseValues:
    """Widened: the resolution of the values is too coarse for the noise, so that the rounding error is unknown."""

    kind: str = field(default="coarse_values", init=False)

    @property
    def text(self) -> str:
        return "the resolution is too coarse for the noise, so the rounding error is unknown"


@frozen
class CoarseCounts:
    """The rounding of the angle is not white from sample to sample, so sums of samples are fitted.

    Attributes
    ----------
    summed : int or None
        Samples in a sum; None if no sum in the record has white rounding.
    hidden : bool
        Whether the record has too few such sums: all terms are upper limits.
    """

    kind: str = field(default="coarse_counts", init=False)
    summed: int | None
    hidden: bool

    @property
    def text(self) -> str:
        return (
            "the rounding of the angle hides the noise"
            if self.hidden
            else f"the rounding is white only in sums of {self.summed} samples, which are fitted"
        )


@frozen
class UnmodelledBand:
    """The spectrum above a frequency has a shape that no model describes, and is left out.

    Attributes
    ----------
    highest : float
        [Hz]
    """

    kind: str = field(default="band_left_out", init=False)
    highest: float

    @property
    def text(self) -> str:
        return f"the spectrum from {self.highest:.3g} Hz on fits no model and is left out"


@frozen
class CrowdedLines:
    """Widened: spectral lines cover so much of the band that they may be noise.

    Attributes
    ----------
    lines : int
        Lines of the model.
    share : float
        Share of the band that they cover. [1]
    highest : float
        Upper end of the interval of the random walk if they are noise. [SI]
    """

    kind: str = field(default="crowded_lines", init=False)
    lines: int
    share: float
    highest: float

    @property
    def text(self) -> str:
        return f"{count_text(self.lines)} spectral lines cover {percent(self.share)} of the band and may be noise"


@frozen
class BandsOff:
    """Widened: the best model deviates from the spectrum in some bands.

    Attributes
    ----------
    frequency : float
        Frequency of the largest deviation. [Hz]
    ratio : float
        Measured density over that of the model at this frequency. [1]
    """

    kind: str = field(default="bands_off", init=False)
    frequency: float
    ratio: float

    @property
    def text(self) -> str:
        return f"the density near {self.frequency:.2g} Hz is {off_text(self.ratio)} the best model"


@frozen
class ChangingRandomWalk:
    """The white noise differs between eighths of the record, and the interval of the random walk includes this
    variation.

    Attributes
    ----------
    lowest, highest : float
        Random walk in the eighths. [SI]
    next_lowest, next_highest : float
        Interval of the random walk in the next record of this length. [SI]
    p_value : float
        P-value of equal white noise in all eighths. [1]
    """

    kind: str = field(default="level_change", init=False)
    lowest: float
    highest: float
    next_lowest: float
    next_highest: float
    p_value: float

    @property
    def text(self) -> str:
        return f"the random walk differs by a factor of {self.highest / self.lowest:.3g} in eighths of the record"


@frozen
class StatedReason:
    """A reason in words, from a result of another version of sigmatau.

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
    | ChangingRandomWalk
    | UnmodelledBand
    | BandsOff
    | VibrationPower
    | StatedReason
)
"""Why there is no fit, why a fit is not adequate, or why its shortest averaging times are left out."""


def reasons_text(reasons: Sequence[Reason]) -> str:
    """All reasons of a fit in words."""
    return "; ".join(reason.text for reason in reasons)


def count_text(count: int) -> str:
    """A number of lines or processes: ``"5"``, ``"at least 100"`` if no more are listed."""
    return f"at least {count}" if count >= MAX_LINES else str(count)


def off_text(ratio: float) -> str:
    """A ratio in words: ``"12 % above"``, ``"4.1 times"``."""
    if ratio > 3:
        return f"{two_digits(ratio)} times"
    return f"{two_digits(100 * abs(ratio - 1))} % {'below' if ratio < 1 else 'above'}"


def _p_text(misfit: Misfit) -> str:
    p = misfit.p_value
    if p is None:
        return ""
    return f" (p = {p:.1g})" if p > _SMALLEST_P else f" (p < {_SMALLEST_P:g})"
