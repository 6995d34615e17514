"""Kinds of findings about spectra: lines, low-pass filters, resampling, common noise."""

from __future__ import annotations

from sigmatau.findings.finding import Details
from sigmatau.frozen import frozen


@frozen
class Mains:
    """The multiple of the mains frequency that a line may be."""

    frequency: float  # of the mains: 50 or 60 [Hz]
    multiple: int
    folded: bool  # whether that multiple is beyond half the sampling rate


@frozen
class Line:
    """A line in the spectrum of a channel, which the fit leaves out."""

    frequency: float  # [Hz]
    amplitude: float  # of a sinusoid with the same power [unit of the finding]
    low: float  # the band that was left out [Hz]
    high: float
    harmonics: tuple[Line, ...] = ()  # lines at multiples of its frequency, folded at half the sampling rate
    mains: Mains | None = None


@frozen
class SpectralLines(Details, code="spectral_line"):
    """Lines of a channel; the size of the finding is the amplitude of the strongest."""

    lines: tuple[Line, ...]  # strongest first, each with its harmonics


@frozen
class LowPassFilter(Details, code="low_pass_filter"):
    """A filter in front of the sampler, which is part of the fit; the size of the finding is its corner."""

    shape: str  # "butterworth", "smoothing", "running_mean", "low_pass", or "uneven" if it has no corner
    order: int | None  # of a Butterworth filter; samples of a running mean
    corner: float | None  # frequency of half the power, with its interval [Hz]
    low: float | None
    high: float | None


@frozen
class BandLeftOut(Details, code="band_left_out"):
    """The top of the spectrum has a shape that no model describes, and is left out of the fit."""

    highest: float  # frequency from which on [Hz]


@frozen
class GaussMarkovProcess(Details, code="gauss_markov_process"):
    """A first-order Gauss-Markov process is part of the fit; the size of the finding is its standard deviation."""

    quantity: str
    time: float  # correlation time with its interval [s]
    low: float | None
    high: float | None


@frozen
class Resonance(Details, code="resonance"):
    """Noise of a band is part of the fit; the size of the finding is its standard deviation."""

    quantity: str
    frequency: float  # centre [Hz]
    width: float  # half width [Hz]


@frozen
class Aliasing(Details, code="aliasing"):
    """Noise that sampling without an anti-alias filter folds into the random walk; the size is the factor on it."""

    rate: float  # sampling rate [Hz]
    bandwidth: float  # of the sensor [Hz]
    order: int | None  # of its filter; None if it was not stated: then the size is that of the first order
    second_order: float | None = None  # factor behind a second-order filter, if the order was not stated
    rate_needed: float  # sampling rate at which the factor is 1.02 [Hz]


@frozen
class AxisPair:
    """Correlation of two axes."""

    first: str
    second: str
    coefficient: float
    # length of the means whose differences are correlated; 0 for differences of neighbouring samples [s]
    mean_length: float


@frozen
class CorrelatedAxes(Details, code="correlated_axes"):
    """Axes that share noise; the size is the largest correlation."""

    pairs: tuple[AxisPair, ...]  # strongest first
    only_slow: bool  # whether no pair is correlated between neighbouring samples
    stretches: int = 1  # stretches of the record that neighbouring samples were taken from: 1 is the whole record
