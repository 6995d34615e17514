"""Findings about spectra: lines, low-pass filters, resampling, common noise."""

from __future__ import annotations

from sigmatau.digits import round_to_error, significant, two_digits
from sigmatau.findings.finding import Details, Finding, Words, axes_text
from sigmatau.findings.fit import filter_text
from sigmatau.findings.phrases import factor_text
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.noise.terms import display_units
from sigmatau.results import duration_text

_SLOW = 0.2  # frequency below which a period is stated instead [Hz]

_QUANTITIES = {"rad/s": "angular_rate", "m/s^2": "acceleration"}


@frozen
class Mains:
    """The multiple of the mains frequency that a line may be.

    Attributes
    ----------
    frequency : float
        Frequency of the mains: 50 or 60. [Hz]
    multiple : int
        Number of the multiple.
    folded : bool
        Whether that multiple exceeds half the sampling rate.
    """

    frequency: float
    multiple: int
    folded: bool


@frozen
class SpectralLine:
    """A line in the spectrum of a channel, which the fit leaves out, or follows as a sinusoid if it is slow.

    Attributes
    ----------
    frequency : float
        [Hz]
    amplitude : float
        Amplitude of a sinusoid with the same power. [unit of the finding]
    low, high : float
        The band that was left out, or the interval of the frequency of a slow line. [Hz]
    harmonics : tuple of SpectralLine
        Lines at multiples of its frequency, folded at half the sampling rate.
    mains : Mains or None
        None if the line is not near a multiple of the mains frequency.
    weakest, strongest : float or None
        Interval of the amplitude, if the line has one. [unit of the finding]
    """

    frequency: float
    amplitude: float
    low: float
    high: float
    harmonics: tuple[SpectralLine, ...] = ()
    mains: Mains | None = None
    weakest: float | None = None
    strongest: float | None = None


@frozen
class SpectralLines(Details, code="spectral_line"):
    """Lines of a channel; the size of the finding is the amplitude of the strongest.

    Attributes
    ----------
    lines : tuple of SpectralLine
        Strongest first, each with its harmonics.
    """

    lines: tuple[SpectralLine, ...]

    def words(self, finding: Finding) -> Words:
        strongest = self.lines[0]
        quantity = _QUANTITIES.get(finding.unit, "signal")
        unit, factor = display_units("bias_instability", quantity, finding.unit, [strongest.amplitude])[-1]
        what = f"{len(self.lines)} spectral lines, largest" if len(self.lines) > 1 else "spectral line"
        size = f"{significant(strongest.amplitude / factor)} {unit}"
        place = f"at {strongest.frequency:.4g} Hz{_mains(strongest)}"
        if strongest.frequency < _SLOW and strongest.weakest is not None and strongest.strongest is not None:
            ends = strongest.weakest, strongest.strongest
            size = round_to_error(strongest.amplitude, *ends, size=factor).with_unit(unit)
            place = f"with a period of {duration_text(1 / strongest.frequency)}"
        message = f"{what} of {size} {place}"
        return Words(message, "No action needed: the coefficients are those without the lines")


@frozen
class LowPassFilter(Details, code="low_pass_filter"):
    """A filter in front of the sampler, which is part of the fit; the size of the finding is its corner.

    Attributes
    ----------
    shape : str
        "butterworth", "smoothing", "running_mean", "two_poles", "running_means", "low_pass", or "uneven" if it has no
        corner.
    order : int or None
        Order of a Butterworth filter, samples in a running mean, or number of running means.
    corner, low, high : float or None
        Frequency of half the power, with its interval. [Hz]
    """

    shape: str
    order: int | None
    corner: float | None
    low: float | None
    high: float | None

    def words(self, finding: Finding) -> Words:
        what = filter_text(self.shape, self.order)
        if self.shape == "uneven":
            what = "the spectrum is uneven, but does not fall as after a low-pass filter"
        if self.corner is not None and self.low is not None and self.high is not None:
            what += f" at {round_to_error(self.corner, self.low, self.high).with_unit('Hz')}"
        return Words(what, "No action needed: it is part of the fit")


@frozen
class BandLeftOut(Details, code="band_left_out"):
    """The top of the spectrum has a shape that no model describes, and is left out of the fit.

    Attributes
    ----------
    highest : float
        Frequency from which the spectrum is left out. [Hz]
    """

    highest: float

    def words(self, finding: Finding) -> Words:
        return Words(
            f"the spectrum from {self.highest:.3g} Hz on fits no model and is left out",
            "No action needed, unless the noise at short times matters",
        )


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

    def words(self, finding: Finding) -> Words:
        has_interval = self.low is not None and self.high is not None
        within = f" [{duration_text(self.low or 0.0)}, {duration_text(self.high or 0.0)}]" if has_interval else ""
        return Words(
            f"Gauss-Markov process of {_sized(finding, self.quantity)},"
            f" correlation time {duration_text(self.time)}{within}",
            "No action needed: it is part of the model",
        )


@frozen
class ResonanceProcess(Details, code="resonance"):
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

    def words(self, finding: Finding) -> Words:
        return Words(
            f"resonance of {_sized(finding, self.quantity)} at {self.frequency:.3g} Hz,"
            f" half width {two_digits(self.width)} Hz",
            "No action needed: it is part of the model",
        )


@frozen
class Aliasing(Details, code="aliasing"):
    """Noise that sampling without an anti-alias filter folds into the random walk; the size is the factor on it.

    Attributes
    ----------
    rate : float
        Sampling rate. [Hz]
    bandwidth : float
        Bandwidth of the sensor. [Hz]
    order : int or None
        Order of the sensor's filter. None if it was not stated; the size is then that for the first order.
    second_order : float or None
        Factor after a second-order filter, if the order was not stated.
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
        """True: folded noise is part of the random walk of each fit."""
        return True

    def words(self, finding: Finding) -> Words:
        times = f"sampled at {self.rate:.4g} Hz, {self.rate / self.bandwidth:.2g} times the"
        effect = factor_text(*finding.factors[0])
        order = "" if self.order is None else f" of order {self.order}"
        message = f"{times} stated bandwidth of {self.bandwidth:.4g} Hz{order}; {effect}"
        if self.second_order is not None:
            message += f", or {factor_text('', self.second_order).strip()} for order 2"
        action = f"Sample at {self.rate_needed:.3g} Hz or faster, or filter before sampling"
        return Words(message, action if finding.severity != "info" else "")


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

    def words(self, finding: Finding) -> Words:
        return Words(
            f"identical in all {self.samples} samples: one column was read or logged twice",
            f"Check {Hint('channels')} and the logging program",
        )


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
        Number of stretches from which neighbouring samples were taken; 1 is the whole record.
    """

    pairs: tuple[AxisPair, ...]
    only_slow: bool
    stretches: int = 1

    def words(self, finding: Finding) -> Words:
        strongest = self.pairs[0]
        what = (
            f"means over {duration_text(strongest.mean_length)}"
            if strongest.mean_length
            else "sample-to-sample changes"
        )
        several = f", the largest of {len(self.pairs)} pairs" if len(self.pairs) > 1 else ""
        shared = (
            "a shared supply, temperature or motion" if strongest.mean_length else "a shared vibration or converter"
        )
        pair = (strongest.first, strongest.second)
        which = "" if set(finding.channels) == set(pair) else f"{axes_text(pair)} are "
        return Words(
            f"{which}correlated, r = {strongest.coefficient:.2f} for {what}{several}",
            f"Look for {shared}; a Kalman filter needs the covariance of the axes",
        )


def _mains(line: SpectralLine) -> str:
    if line.mains is None:
        return ""
    multiple = f"{line.mains.multiple} × " if line.mains.multiple > 1 else ""
    return f", possibly {'aliased ' if line.mains.folded else ''}{multiple}{line.mains.frequency:g} Hz mains"


def _sized(finding: Finding, quantity: str) -> str:
    unit, factor = display_units("bias_instability", quantity, finding.unit, [finding.size])[-1]
    return f"{two_digits((finding.size or 0.0) / factor)} {unit}"
