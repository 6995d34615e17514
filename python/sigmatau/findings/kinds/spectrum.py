"""Kinds of findings about spectra: lines, low-pass filters, resampling, common noise."""

from __future__ import annotations

from dataclasses import dataclass

from sigmatau.findings.finding import Details


@dataclass(frozen=True, slots=True, kw_only=True)
class Mains:
    """The multiple of the mains frequency that a line may be."""

    frequency: float  # of the mains: 50 or 60 [Hz]
    multiple: int
    folded: bool  # whether that multiple is beyond half the sampling rate


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """A line in the spectrum of a channel."""

    frequency: float  # [Hz]
    amplitude: float  # of the sinusoid; of an unsteady line, of a steady one with the same power [unit of the finding]
    width: float  # of the band that holds 80 % of its power; 0 if the line is steady, as narrow as the resolution [Hz]
    ratio: float  # density over that of the noise beside it, at the width that shows the line best
    low: float  # the band that was taken as the line [Hz]
    high: float
    harmonics: tuple[Line, ...] = ()  # lines at multiples of its frequency, folded at half the sampling rate
    mains: Mains | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class SpectralLines(Details, code="spectral_line"):
    """Lines of a channel."""

    lines: tuple[Line, ...]  # strongest first, each with its harmonics
    factor: float  # by which all lines together make σ(τ) larger at most; 1 if that is not known
    tau: float | None  # averaging time of that factor; None if it is not known [s]
    # averaging time from which the lines change σ(τ) by 1 % at most; None if no fit can begin there [s]
    clear_from: float | None
    # the largest `clear_from` of the channels of the stream; 0 if all averaging times can be used [s]
    tau_min: float = 0.0
    stretches: int = 1  # stretches of the record that were searched: 1 is the whole record
    between_motion: bool = False  # whether the times of motion were left out of the search


@dataclass(frozen=True, slots=True, kw_only=True)
class LowPassFilter(Details, code="low_pass_filter"):
    """A low-pass filter in front of the sampler."""

    shape: str  # the most likely of `sigmatau.quality.spectrum.filter_models.SHAPES`
    order: int | None  # of a Butterworth filter
    # frequency of -3 dB and its standard error, which includes half the distance to the corner of any other possible
    # shape [Hz]
    corner: float
    error: float
    alike: tuple[str, ...]  # other shapes that the spectrum does not exclude
    alike_corners: tuple[float, ...]  # their corners [Hz]
    misfit: float  # deviance of the fit over the number of its points: 1 by chance
    tau0: float  # sample interval [s]
    # σ at one sample over what the random walk makes there; above 1, quantization after the filter adds more than the
    # filter removes
    sigma_one_sample: float
    # averaging time from which σ is within 1 % of what the random walk makes, but for quantization [s]
    right_from: float
    tau_min: float = 0.0  # the largest `right_from` of the channels of the stream [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class Aliasing(Details, code="aliasing"):
    """Noise that sampling without an anti-alias filter folds into the random walk; the size is the factor on it."""

    rate: float  # sampling rate [Hz]
    bandwidth: float  # of the sensor [Hz]
    order: int | None  # of its filter; None if it was not stated: then the size is that of the first order
    # whether the bandwidth was stated by the user; else it was found in the spectrum, and the filter must be analog
    stated: bool
    error: float | None = None  # standard error of a bandwidth that was found in the spectrum [Hz]
    second_order: float | None = None  # factor behind a second-order filter, if the order was not stated
    rate_needed: float  # sampling rate at which the factor is 1.02 [Hz]


@dataclass(frozen=True, slots=True, kw_only=True)
class Resampled(Details, code="interpolated"):
    """A channel that was interpolated from samples at a lower rate, as its spectrum shows."""

    # "held": values repeated; "linear": lines between samples; "smooth": another interpolation; "empty": spectrum empty
    # above half the true rate
    kind: str
    rate: float  # probable rate of the true samples [Hz]
    log_rate: float  # sampling rate of the record [Hz]
    sigma_one_sample: float  # σ at one sample over what the random walk makes there
    right_from: float  # averaging time from which σ is within 1 % of what the random walk makes [s]
    # amplitude of the squared differences at the true rate over their mean; of an empty band, its density over that
    # beside it
    depth: float


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisPair:
    """Correlation of two axes."""

    first: str
    second: str
    coefficient: float
    # length of the means whose differences are correlated; 0 for differences of neighbouring samples [s]
    mean_length: float


@dataclass(frozen=True, slots=True, kw_only=True)
class CorrelatedAxes(Details, code="correlated_axes"):
    """Axes that share noise; the size is the largest correlation."""

    pairs: tuple[AxisPair, ...]  # strongest first
    only_slow: bool  # whether no pair is correlated between neighbouring samples
    stretches: int = 1  # stretches of the record that neighbouring samples were taken from: 1 is the whole record
