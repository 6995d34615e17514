"""Kinds of findings about spectra: lines, low-pass filters, resampling, common noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sigmatau.findings.finding import Details

__all__ = ["Aliasing", "AxisPair", "CorrelatedAxes", "Line", "LowPassFilter", "Mains", "Resampled", "SpectralLines"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Mains:
    """The multiple of the mains frequency that a line may be.

    Attributes
    ----------
    frequency : float
        Of the mains: 50 or 60. [Hz]
    multiple : int
    folded : bool
        Whether that multiple is beyond half the sampling rate.
    """

    frequency: float
    multiple: int
    folded: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """A line in the spectrum of a channel.

    Attributes
    ----------
    frequency : float
        [Hz]
    amplitude : float
        Of the sinusoid; of an unsteady line, of a steady one with the same power. [unit of the finding]
    width : float
        Of the band that holds 80 % of its power; 0 if the line is steady, as narrow as the resolution. [Hz]
    ratio : float
        Density over that of the noise beside it, at the width that shows the line best.
    low, high : float
        The band that was taken as the line. [Hz]
    harmonics : tuple of Line
        Lines at multiples of its frequency, folded at half the sampling rate.
    mains : Mains or None
    """

    frequency: float
    amplitude: float
    width: float
    ratio: float
    low: float
    high: float
    harmonics: tuple[Line, ...] = ()
    mains: Mains | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class SpectralLines(Details):
    """Lines of a channel.

    Attributes
    ----------
    lines : tuple of Line
        Strongest first, each with its harmonics.
    factor : float
        By which all lines together make σ(τ) larger at most; 1 if that is not known.
    tau : float or None
        Averaging time of that factor; None if it is not known. [s]
    clear_from : float or None
        Averaging time from which the lines change σ(τ) by 1 % at most; None if no fit can begin there. [s]
    tau_min : float
        The largest `clear_from` of the channels of the stream; 0 if all averaging times can be used. [s]
    stretches : int
        Stretches of the record that were searched: 1 is the whole record.
    between_motion : bool
        Whether the times of motion were left out of the search.
    """

    code: ClassVar[str] = "spectral_line"

    lines: tuple[Line, ...]
    factor: float
    tau: float | None
    clear_from: float | None
    tau_min: float = 0.0
    stretches: int = 1
    between_motion: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class LowPassFilter(Details):
    """A low-pass filter in front of the sampler.

    Attributes
    ----------
    shape : str
        The most likely of `sigmatau.quality.spectrum.filter_models.SHAPES`.
    order : int or None
        Of a Butterworth filter.
    corner, error : float
        Frequency of -3 dB and its standard error, which includes half the distance to the corner of any other possible
        shape. [Hz]
    alike : tuple of str
        Other shapes that the spectrum does not exclude.
    alike_corners : tuple of float
        Their corners. [Hz]
    misfit : float
        Deviance of the fit over the number of its points: 1 by chance.
    tau0 : float
        Sample interval. [s]
    sigma_one_sample : float
        σ at one sample over what the random walk makes there; above 1, quantization after the filter adds more than the
        filter removes.
    right_from : float
        Averaging time from which σ is within 1 % of what the random walk makes, but for quantization. [s]
    tau_min : float
        The largest `right_from` of the channels of the stream. [s]
    """

    code: ClassVar[str] = "low_pass_filter"

    shape: str
    order: int | None
    corner: float
    error: float
    alike: tuple[str, ...]
    alike_corners: tuple[float, ...]
    misfit: float
    tau0: float
    sigma_one_sample: float
    right_from: float
    tau_min: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Aliasing(Details):
    """Noise that sampling without an anti-alias filter folds into the random walk; the size is the factor on it.

    Attributes
    ----------
    rate : float
        Sampling rate. [Hz]
    bandwidth : float
        Of the sensor. [Hz]
    order : int or None
        Of its filter; None if it was not stated: then the size is that of the first order.
    stated : bool
        Whether the bandwidth was stated by the user; else it was found in the spectrum, and the filter must be analog.
    error : float or None
        Standard error of a bandwidth that was found in the spectrum. [Hz]
    second_order : float or None
        Factor behind a second-order filter, if the order was not stated.
    rate_needed : float
        Sampling rate at which the factor is 1.02. [Hz]
    """

    code: ClassVar[str] = "aliasing"

    rate: float
    bandwidth: float
    order: int | None
    stated: bool
    error: float | None = None
    second_order: float | None = None
    rate_needed: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Resampled(Details):
    """A channel that was interpolated from samples at a lower rate, as its spectrum shows.

    Attributes
    ----------
    kind : {"held", "linear", "smooth", "empty"}
        Values repeated; lines between samples; another interpolation; spectrum empty above half the true rate.
    rate : float
        Probable rate of the true samples. [Hz]
    log_rate : float
        Sampling rate of the record. [Hz]
    sigma_one_sample : float
        σ at one sample over what the random walk makes there.
    right_from : float
        Averaging time from which σ is within 1 % of what the random walk makes. [s]
    depth : float
        Amplitude of the squared differences at the true rate over their mean; of an empty band, its density over that
        beside it.
    """

    code: ClassVar[str] = "interpolated"

    kind: str
    rate: float
    log_rate: float
    sigma_one_sample: float
    right_from: float
    depth: float


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisPair:
    """Correlation of two axes.

    Attributes
    ----------
    first, second : str
    coefficient : float
    mean_length : float
        Length of the means whose differences are correlated; 0 for differences of neighbouring samples. [s]
    """

    first: str
    second: str
    coefficient: float
    mean_length: float


@dataclass(frozen=True, slots=True, kw_only=True)
class CorrelatedAxes(Details):
    """Axes that share noise; the size is the largest correlation.

    Attributes
    ----------
    pairs : tuple of AxisPair
        Strongest first.
    only_slow : bool
        Whether no pair is correlated between neighbouring samples.
    stretches : int
        Stretches of the record that neighbouring samples were taken from: 1 is the whole record.
    """

    code: ClassVar[str] = "correlated_axes"

    pairs: tuple[AxisPair, ...]
    only_slow: bool
    stretches: int = 1
