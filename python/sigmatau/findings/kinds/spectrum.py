"""Kinds of findings about spectra: lines, low-pass filters, resampling, common noise."""

from __future__ import annotations

from sigmatau.findings.finding import Details
from sigmatau.frozen import frozen


@frozen
class Mains:
    """The multiple of the mains frequency that a line may be.

    Attributes
    ----------
    frequency : float
        Of the mains: 50 or 60. [Hz]
    multiple : int
        Which multiple.
    folded : bool
        Whether that multiple is beyond half the sampling rate.
    """

    frequency: float
    multiple: int
    folded: bool


@frozen
class Line:
    """A line in the spectrum of a channel, which the fit leaves out.

    Attributes
    ----------
    frequency : float
        [Hz]
    amplitude : float
        Of a sinusoid with the same power. [unit of the finding]
    low, high : float
        The band that was left out. [Hz]
    harmonics : tuple of Line
        Lines at multiples of its frequency, folded at half the sampling rate.
    mains : Mains or None
        None if it is not near a multiple of the mains frequency.
    """

    frequency: float
    amplitude: float
    low: float
    high: float
    harmonics: tuple[Line, ...] = ()
    mains: Mains | None = None


@frozen
class SpectralLines(Details, code="spectral_line"):
    """Lines of a channel; the size of the finding is the amplitude of the strongest.

    Attributes
    ----------
    lines : tuple of Line
        Strongest first, each with its harmonics.
    """

    lines: tuple[Line, ...]


@frozen
class LowPassFilter(Details, code="low_pass_filter"):
    """A filter in front of the sampler, which is part of the fit; the size of the finding is its corner.

    Attributes
    ----------
    shape : str
        "butterworth", "smoothing", "running_mean", "low_pass", or "uneven" if it has no corner.
    order : int or None
        Of a Butterworth filter; samples of a running mean.
    corner, low, high : float or None
        Frequency of half the power, with its interval. [Hz]
    """

    shape: str
    order: int | None
    corner: float | None
    low: float | None
    high: float | None


@frozen
class BandLeftOut(Details, code="band_left_out"):
    """The top of the spectrum has a shape that no model describes, and is left out of the fit.

    Attributes
    ----------
    highest : float
        Frequency from which the spectrum is left out. [Hz]
    """

    highest: float


@frozen
class GaussMarkovProcess(Details, code="gauss_markov_process"):
    """A first-order Gauss-Markov process is part of the fit; the size of the finding is its standard deviation.

    Attributes
    ----------
    quantity : str
        ``"angular_rate"``, ``"acceleration"`` or ``"signal"``.
    time : float
        Correlation time with its interval. [s]
    low, high : float or None
        Interval of the correlation time; None if it has none. [s]
    """

    quantity: str
    time: float
    low: float | None
    high: float | None


@frozen
class Resonance(Details, code="resonance"):
    """Noise of a band is part of the fit; the size of the finding is its standard deviation.

    Attributes
    ----------
    quantity : str
        ``"angular_rate"``, ``"acceleration"`` or ``"signal"``.
    frequency : float
        Centre. [Hz]
    width : float
        Half width. [Hz]
    """

    quantity: str
    frequency: float
    width: float


@frozen
class Aliasing(Details, code="aliasing"):
    """Noise that sampling without an anti-alias filter folds into the random walk; the size is the factor on it.

    Attributes
    ----------
    rate : float
        Sampling rate. [Hz]
    bandwidth : float
        Of the sensor. [Hz]
    order : int or None
        Of its filter; None if it was not stated: then the size is that of the first order.
    second_order : float or None
        Factor behind a second-order filter, if the order was not stated.
    rate_needed : float
        Sampling rate at which the factor is 1.02. [Hz]
    """

    rate: float
    bandwidth: float
    order: int | None
    second_order: float | None = None
    rate_needed: float

    @property
    def biases_walk(self) -> bool:
        """Folded noise is in the random walk of each fit."""
        return True


@frozen
class AxisPair:
    """Correlation of two axes.

    Attributes
    ----------
    first : str
        One channel.
    second : str
        The other channel.
    coefficient : float
        Correlation, −1 to 1.
    mean_length : float
        Length of the means whose differences are correlated; 0 for differences of neighbouring samples. [s]
    """

    first: str
    second: str
    coefficient: float
    mean_length: float


@frozen
class IdenticalAxes(Details, code="identical_axes"):
    """Axes whose samples are all equal: one column was read or written twice.

    Attributes
    ----------
    samples : int
        Number of samples.
    """

    samples: int


@frozen
class CorrelatedAxes(Details, code="correlated_axes"):
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

    pairs: tuple[AxisPair, ...]
    only_slow: bool
    stretches: int = 1
