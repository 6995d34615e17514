"""A filter that was fitted to the spectrum: its response, its name, and its place in a model."""

from __future__ import annotations

from typing import Any, Literal

from sigmatau._native.likelihood import FilterEstimate
from sigmatau.frozen import frozen
from sigmatau.model.processes import LowPass
from sigmatau.results import plain

Shape = Literal["butterworth", "smoothing", "running_mean", "low_pass", "uneven"]


@frozen
class FittedFilter:
    """A filter on all noise but quantization: ln |H|² = Σ aₖ (cos 2πk f Δ − 1).

    Attributes
    ----------
    coefficients : tuple of float
        a₁, a₂ … [1]
    tau0 : float
        Sample interval. [s]
    interval : float
        Δ: the sample interval, or a multiple where the top of the band was left out. [s]
    shape : str
        The shape that it is like, such as ``"butterworth"``; ``"uneven"`` if it does not fall to half the power.
    order : int or None
        Of a Butterworth filter; samples of a running mean.
    corner : float or None
        Frequency of half the power. [Hz]
    low, high : float or None
        Interval of the corner. [Hz]
    low_pass : LowPass or None
        The filter in its place in a noise model.
    known_to : float or None
        Highest frequency that the fit used, because the filter takes the rest. [Hz]
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

    def native(self) -> FilterEstimate:
        """The filter as the compiled core takes it."""
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
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        like = None if self.low_pass is None else plain(self.low_pass, "order corner_hz=corner")
        known = plain(self, "shape order corner_hz=corner low_hz=low high_hz=high coefficients interval_s=interval")
        known_to = {} if self.known_to is None else {"known_to_hz": self.known_to}
        return {**known, "low_pass": like, **known_to}
