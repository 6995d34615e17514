"""What a noise model holds beside the five terms: Gauss-Markov processes, sinusoids, and the sensor's bandwidth."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sigmatau.errors import DataError

__all__ = ["HIGHEST_ORDER", "GaussMarkov", "LowPass", "Sinusoid"]

HIGHEST_ORDER = 9
"""Of a Butterworth filter."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GaussMarkov:
    """A first-order Gauss-Markov process, autocovariance σ²·exp(−t/T) at the lag t.

    Attributes
    ----------
    sigma : float
        Standard deviation. [unit of the rate]
    time : float
        Correlation time. [s]
    """

    sigma: float
    time: float

    def __post_init__(self) -> None:
        _positive("the standard deviation of a Gauss-Markov process", self.sigma)
        _positive("the correlation time of a Gauss-Markov process", self.time)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sinusoid:
    """A line: A·sin(2πft + φ) with a random phase.

    Attributes
    ----------
    amplitude : float
        [unit of the rate]
    frequency : float
        [Hz]
    """

    amplitude: float
    frequency: float

    def __post_init__(self) -> None:
        _positive("the amplitude of a sinusoid", self.amplitude)
        _positive("the frequency of a sinusoid", self.frequency)


@dataclass(frozen=True, slots=True, kw_only=True)
class LowPass:
    """The bandwidth of the sensor, a Butterworth filter that its white noise has passed before it was sampled.

    Without an anti-alias filter what lies above half the sampling rate folds back. Slower noise passes as it is.

    Attributes
    ----------
    order : int
        1 (an RC filter) … 9.
    corner : float
        Frequency of −3 dB. [Hz]
    """

    order: int
    corner: float

    def __post_init__(self) -> None:
        if isinstance(self.order, bool) or self.order not in range(1, HIGHEST_ORDER + 1):
            raise DataError(f"the order of a bandwidth must be 1 to {HIGHEST_ORDER}, not {self.order!r}")
        _positive("the corner of a bandwidth", self.corner)


def _positive(what: str, value: float) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not (math.isfinite(value) and value > 0):
        raise DataError(f"{what} must be a positive number, not {value!r}")
