"""Processes of a noise model besides the five terms, and the bandwidth."""

from __future__ import annotations

import math
from collections.abc import Mapping
from numbers import Real
from typing import Any

from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.noise.synonyms import unknown_term
from sigmatau.noise.terms import TERMS, aliasing_inflation
from sigmatau.record.streams import RATES

HIGHEST_ORDER = 9  # Highest order of a Butterworth filter
# range of any parameter of a model, in SI; squares and products of values outside overflow a double
SMALLEST, LARGEST = 1e-100, 1e100
_CORNERS = (1e-9, 1e12)  # Range of bandwidths: a thousandth of the lowest rate to a thousand times the highest. [Hz]


@frozen
class GaussMarkov:
    """A first-order Gauss-Markov process, autocovariance σ²·exp(−t/T) at the lag t.

    Attributes
    ----------
    sigma : float
        Standard deviation. [unit of the rate]
    time : float
        Correlation time. [s]

    Raises
    ------
    DataError
        For a number that is not positive.

    See Also
    --------
    ChannelModel : the noise of one channel.

    References
    ----------
    IEEE Std 952, annex C.

    Examples
    --------
    >>> from sigmatau import ChannelModel, GaussMarkov
    >>> ChannelModel(gauss_markov=(GaussMarkov(sigma=1e-5, time=100.0),)).autocovariance([0, 100], tau0=1.0).round(13)
    array([1.00e-10, 3.68e-11])
    """

    sigma: float
    time: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "sigma", positive("the standard deviation of a Gauss-Markov process", self.sigma))
        object.__setattr__(self, "time", positive("the correlation time of a Gauss-Markov process", self.time))


@frozen
class Resonance:
    """Narrow-band noise: the velocity of a damped oscillator driven by white noise.

    With γ = 2π·width and ω² = (2π·frequency)² − γ² its autocovariance is σ²·exp(−γt)·(cos ωt − γ/ω·sin ωt) at the lag t.

    Attributes
    ----------
    sigma : float
        Standard deviation. [unit of the rate]
    frequency : float
        Centre. [Hz]
    width : float
        Half width, less than the centre. [Hz]

    Raises
    ------
    DataError
        For a number that is not positive, or a half width that is not less than the centre.

    See Also
    --------
    ChannelModel : the noise of one channel.

    References
    ----------
    docs/theory/likelihood.md has its density.

    Examples
    --------
    >>> from sigmatau import ChannelModel, Resonance
    >>> ChannelModel(resonance=(Resonance(sigma=1e-3, frequency=0.5, width=0.01),)).avar(m=[1, 2], tau0=1.0).round(8)
    array([1.94e-06, 3.00e-08])
    """

    sigma: float
    frequency: float
    width: float

    def __post_init__(self) -> None:
        for name in ("sigma", "frequency", "width"):
            what = "standard deviation" if name == "sigma" else name
            object.__setattr__(self, name, positive(f"the {what} of a resonance", getattr(self, name)))
        if not self.width < self.frequency:
            raise DataError(f"the half width of a resonance must be less than its frequency, not {self.width!r} Hz")

    @property
    def damping(self) -> float:
        """γ = 2π·width. [1/s]"""
        return 2 * math.pi * self.width

    @property
    def turning(self) -> float:
        """ω = 2π·√(frequency² − width²). [rad/s]"""
        return 2 * math.pi * math.sqrt((self.frequency - self.width) * (self.frequency + self.width))


@frozen
class Sinusoid:
    """A sinusoid A·sin(2πft + φ) with a random phase.

    Attributes
    ----------
    amplitude : float
        [unit of the rate]
    frequency : float
        [Hz]

    Raises
    ------
    DataError
        For a number that is not positive.

    See Also
    --------
    ChannelModel : the noise of one channel.

    References
    ----------
    IEEE Std 952, annex C.

    Examples
    --------
    >>> from sigmatau import ChannelModel, Sinusoid
    >>> ChannelModel(sinusoid=(Sinusoid(amplitude=0.01, frequency=0.5),)).avar(m=[1, 2], tau0=1.0).round(6)
    array([0.0001, 0.    ])
    """

    amplitude: float
    frequency: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "amplitude", positive("the amplitude of a sinusoid", self.amplitude))
        object.__setattr__(self, "frequency", positive("the frequency of a sinusoid", self.frequency))


@frozen
class LowPass:
    """Bandwidth of the sensor: a Butterworth filter of the white noise in front of the sampler.

    Noise above half the sampling rate is aliased. The filter acts on the random walk only.

    Attributes
    ----------
    order : int
        1 (an RC filter) … 9.
    corner : float
        Frequency of −3 dB; 1e-9 to 1e12. The higher it is above the rate, the more noise is aliased. If the noise is
        white up to half the sampling rate, leave the bandwidth out of the model. [Hz]
    rate : float or None
        Sampling rate at which the random walk was measured. The random walk is then the density of these samples at low
        frequencies, including aliasing. None: the random walk is the density before the sampler. [Hz]

    Raises
    ------
    DataError
        For an order that is not 1 to 9, or a corner outside its range.

    See Also
    --------
    ChannelModel : the noise of one channel.

    References
    ----------
    docs/theory/simulation.md: the sampled states of the filter.

    Examples
    --------
    >>> from sigmatau import ChannelModel, LowPass
    >>> filtered = ChannelModel(terms={"random_walk": 1e-4}, bandwidth=LowPass(order=2, corner=20.0))
    >>> filtered.adev(m=[1, 100], tau0=0.01).round(6)
    array([0.000433, 0.0001  ])
    """

    order: int
    corner: float
    rate: float | None = None

    def __post_init__(self) -> None:
        if isinstance(self.order, bool) or self.order not in range(1, HIGHEST_ORDER + 1):
            raise DataError(f"the order of a bandwidth must be 1 to {HIGHEST_ORDER}, not {self.order!r}")
        object.__setattr__(self, "order", int(self.order))
        object.__setattr__(self, "corner", positive("the corner of a bandwidth", self.corner))
        if not _CORNERS[0] <= self.corner <= _CORNERS[1]:
            raise DataError(
                f"the corner of a bandwidth must be from {_CORNERS[0]:g} to {_CORNERS[1]:g} Hz, not {self.corner:g}; without"
                " a filter, leave the bandwidth out"
            )
        if self.rate is not None:
            object.__setattr__(self, "rate", positive("the rate of a bandwidth", self.rate))

    def before_sampling(self, random_walk: float) -> float:
        """The random walk in front of the sampler.

        Parameters
        ----------
        random_walk : float
            Random walk of the samples if the filter has a `rate`; otherwise the random walk in front of the sampler.
            [SI]

        Returns
        -------
        float
            [SI]
        """
        if self.rate is None:
            return random_walk
        return random_walk / aliasing_inflation(rate=self.rate, bandwidth=self.corner, order=self.order)


def real(value: object) -> float:
    """A Python or NumPy number as a float; NaN for anything else: text, True, an array."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return math.nan
    try:
        return float(value)
    except OverflowError:  # an integer too large for a float
        return math.inf


def check_sample_interval(name: str, value: float) -> float:
    """Check a sample interval: `OptionError` unless it is positive and its rate is in `RATES`."""
    if not (math.isfinite(real(value)) and value > 0):
        raise OptionError(f"{{option}} must be a positive number of seconds, not {value!r}", option=name)
    shortest, longest = 1 / RATES[1], 1 / RATES[0]
    if not shortest <= value <= longest:
        raise OptionError(f"{{option}} must be from {shortest:g} to {longest:g} s, not {value!r}", option=name)
    return float(value)


def check_sampling_rate(value: float) -> float:
    """Check a sampling rate: `OptionError` unless it is positive and in `RATES`."""
    if not (math.isfinite(real(value)) and value > 0):
        raise OptionError(f"{{option}} must be a positive number of hertz, not {value!r}", option="rate")
    if not RATES[0] <= value <= RATES[1]:
        raise OptionError(f"{{option}} must be from {RATES[0]:g} to {RATES[1]:g} Hz, not {value!r}", option="rate")
    return float(value)


def check_coefficients(what: str, values: object) -> dict[str, float]:
    """Coefficients by term; `DataError` for a negative one, except for a ramp."""
    if not isinstance(values, Mapping):
        raise DataError(f"`{what}` must be a mapping from term to number, {{'random_walk': 1e-4}}, not {values!r}")
    coefficients = {}
    for name, value in values.items():
        if name not in TERMS:
            raise DataError(unknown_term(name))
        coefficients[name] = real(value)
        if not math.isfinite(coefficients[name]) or (coefficients[name] < 0 and name != "rate_ramp"):
            hint = "; NoiseModel.from_dict takes values with units" if isinstance(value, str) else ""
            raise DataError(f"{name} must be a positive number, not {value!r}{hint}")
    return coefficients


def as_processes(what: str, kind: type, values: object) -> tuple[Any, ...]:
    """A tuple of processes of one kind; `DataError` for anything else."""
    many = tuple(values) if isinstance(values, list | tuple) else (values,)
    if not isinstance(values, list | tuple) or not all(isinstance(process, kind) for process in many):
        raise DataError(f"`{what}` must be a tuple of {kind.__name__}, ({kind.__name__}(…),), not {values!r}")
    return many


def positive(what: str, value: object) -> float:
    """A number in the range of any parameter of a model; `DataError` for anything else."""
    number = real(value)
    if not (math.isfinite(number) and number > 0):
        raise DataError(f"{what} must be a positive number, not {value!r}")
    if not SMALLEST <= number <= LARGEST:
        raise DataError(f"{what} must be from {SMALLEST:g} to {LARGEST:g} in SI, not {value!r}")
    return number
