"""Parts of a fit: values with their intervals, terms, processes, lines and drifts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import Any

from sigmatau.decoding import key
from sigmatau.frozen import frozen
from sigmatau.results import Plain, plain
from sigmatau.units import find

MIN_P_VALUE = 1e-6
"""P-value of the goodness of fit below which only the random walk keeps an interval, widened for the misfit."""


@frozen
class Interval(Plain):
    """A value and its interval.

    Attributes
    ----------
    value : float
        [unit]
    low, high : float or None
        Its interval; None if the model is not adequate. [unit]
    unit : str
        SI.
    """

    value: float
    low: float | None
    high: float | None
    unit: str


@frozen
class FittedTerm:
    """One of the five terms in a fit.

    Attributes
    ----------
    term : str
        Key of `sigmatau.noise.terms.TERMS`.
    unit : str
        SI.
    observed : bool or None
        Whether the term is significant; None if the verdict is ``"descriptive"``.
    level : float
        Confidence level of the interval or of the limit.
    value : float or None
        The coefficient if it was observed, or if it describes the curve; a ramp has a sign. [unit]
    low, high : float or None
        Its interval; None if the model is not adequate. [unit]
    upper_limit : float or None
        Upper limit if it was not observed; for a ramp, that of its magnitude. [unit]
    p_value : float or None
        P-value of the term with all other terms free; None if it was not tested.
    """

    term: str
    unit: str
    observed: bool | None
    level: float
    value: float | None = None
    low: float | None = None
    high: float | None = None
    upper_limit: float | None = None
    p_value: float | None = None

    def to(self, unit: str) -> float:
        """The value in another unit: ``fit["random_walk"].to("deg/sqrt(h)")``.

        Parameters
        ----------
        unit : str
            A unit of the same quantity, such as ``"deg/sqrt(h)"``.

        Returns
        -------
        float
            [unit]

        Raises
        ------
        ValueError
            If the term was not observed.
        OptionError
            For a unit that does not fit.
        """
        if self.value is None:
            raise ValueError(f"{self.term} was not observed; it has an upper limit, not a value")
        return self.value / find(unit, si=self.unit).factor

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI; unknown values are omitted."""
        values = plain(self, "value low high upper_limit p_value")
        stated = {key: value for key, value in values.items() if value is not None}
        return {"observed": self.observed, **stated, "level": self.level, "unit": self.unit}


@frozen
class FittedGaussMarkov(Plain):
    """A first-order Gauss-Markov process, as fitted.

    Attributes
    ----------
    sigma : Interval
        Standard deviation. [unit of the rate]
    time : Interval
        Correlation time. [s]
    """

    sigma: Interval
    time: Interval = field(metadata={"unit": "s"})


@frozen
class FittedSinusoid(Plain):
    """A line in the spectrum, as fitted.

    Attributes
    ----------
    amplitude : Interval
        [unit of the rate]
    frequency : Interval
        [Hz]
    """

    amplitude: Interval
    frequency: Interval = field(metadata={"unit": "Hz"})


@frozen
class FittedResonance(Plain):
    """Noise in a band, as fitted.

    Attributes
    ----------
    sigma : Interval
        Standard deviation. [unit of the rate]
    frequency : Interval
        Centre. [Hz]
    width : Interval
        Half width. [Hz]
    """

    sigma: Interval
    frequency: Interval = field(metadata={"unit": "Hz"})
    width: Interval = field(metadata={"unit": "Hz"})


@frozen
class FittedWarmUp:
    """A drift of the mean that decays exponentially from the first sample on.

    Attributes
    ----------
    amplitude : Interval
        Drift at the first sample, of either sign. [unit of the rate]
    time : float
        Time constant: the best one of a grid. [s]
    """

    amplitude: Interval
    time: float

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return plain(self, "amplitude time_s=time")


@frozen
class SecondModel:
    """Another model, with the same lines and resonances, that explains a record as well as the fit does.

    Attributes
    ----------
    terms : mapping of str to float
        Coefficients by term; those that it does not need are omitted. [SI]
    gauss_markov : tuple of (float, float)
        Standard deviation and correlation time of each of its Gauss-Markov processes. [unit of the rate, s]
    warm_up : float or None
        Time constant of a warm-up in it. [s]
    exponent : float or None
        Exponent α of its bias instability: the densities of its processes, a geometric series, add up to f^−α. [1]
    filter : float or None
        Corner of a first-order filter through which all of the random walk passes. [Hz]
    """

    terms: Mapping[str, float]
    gauss_markov: tuple[tuple[float, float], ...] = key("σ and correlation time in s of each process", default=())
    warm_up: float | None = key("time constant of a warm-up in s", default=None)
    exponent: float | None = key("exponent α of its bias instability, whose density is f^−α", default=None)
    filter: float | None = key("corner in Hz of a filter of first order in front of the random walk", default=None)

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        content: dict[str, Any] = {
            "terms": dict(self.terms),
            "gauss_markov": [list(process) for process in self.gauss_markov],
        }
        details = {"warm_up": self.warm_up, "exponent": self.exponent, "filter": self.filter}
        return {**content, **{name: value for name, value in details.items() if value is not None}}
