"""A filter that was fitted to the spectrum: its response, its name, and the corresponding part of a model."""

from __future__ import annotations

import math
from typing import Any, Literal

from sigmatau._native.likelihood import FilterEstimate
from sigmatau.frozen import frozen
from sigmatau.model.processes import LowPass
from sigmatau.results import plain

Shape = Literal["butterworth", "smoothing", "running_mean", "two_poles", "running_means", "low_pass", "uneven"]


@frozen
class FittedFilter:
    """A filter on all noise except quantization: of a known shape, or ln |H|² = Σ aₖ (cos 2πk f Δ − 1).

    Attributes
    ----------
    coefficients : tuple of float
        a₁, a₂ …; none for a filter of known shape. [1]
    tau0 : float
        Sample interval. [s]
    interval : float
        Δ: the sample interval, or a multiple where the top of the band was left out. [s]
    shape : str
        The most similar shape, such as ``"butterworth"``; ``"uneven"`` if it does not fall to half the power.
    order : int or None
        Order of a Butterworth filter, samples of a running mean, or number of running means in series.
    corner : float or None
        Frequency of half the power. [Hz]
    low, high : float or None
        Interval of the corner. [Hz]
    low_pass : LowPass or None
        The filter as part of a noise model.
    known_to : float or None
        Frequency up to which the coefficients describe the filter, 0 for a filter of known shape; above, its shape
        does, or it removes nearly all noise. None: the coefficients describe it at all frequencies. [Hz]
    damping : float or None
        Damping ratio of two poles; 0.71 is a Butterworth filter.
    analog : bool
        Whether a Butterworth filter is before the sampler, with the corner there, rather than after it.
    of_white : bool
        Whether the filter acts on the random walk alone, and slower noise is added after it.
    """

    coefficients: tuple[float, ...]
    tau0: float
    interval: float
    shape: Shape
    order: int | None
    corner: float | None
    low: float | None
    high: float | None
    low_pass: LowPass | None = None
    known_to: float | None = None
    damping: float | None = None
    analog: bool = False
    of_white: bool = False

    def native(self) -> FilterEstimate:
        """Convert the filter for the compiled core."""
        return FilterEstimate(
            list(self.coefficients),
            self.tau0,
            self.interval,
            self.shape,
            self.order,
            self.corner,
            self.low,
            self.high,
            None if self.low_pass is None else (self.low_pass.order, self.low_pass.corner),
            self.known_to,
            self.damping,
            self.analog,
            self.of_white,
        )

    def power_of_series(self, frequency: float) -> float:
        """Power of the series; 1 for a filter of known shape, which has no series.

        Parameters
        ----------
        frequency : float
            Frequency. [Hz]

        Returns
        -------
        float
            |H|². [1]
        """
        angle = 2 * math.pi * frequency * self.interval
        return math.exp(sum(a * (math.cos(k * angle) - 1) for k, a in enumerate(self.coefficients, 1)))

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        like = None if self.low_pass is None else plain(self.low_pass, "order corner_hz=corner")
        fields = plain(self, "shape order corner_hz=corner low_hz=low high_hz=high coefficients interval_s=interval")
        extra = plain(self, "known_to_hz=known_to damping analog of_white")
        return {**fields, "low_pass": like, **{k: v for k, v in extra.items() if v is not None and v is not False}}
