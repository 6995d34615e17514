"""A filter that was fitted to the spectrum: its response, its name, and what it takes off the Allan variance."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau.fitting.roots import root
from sigmatau.frozen import frozen
from sigmatau.model.covariance import band_limited
from sigmatau.model.processes import LowPass
from sigmatau.results import plain

Floats = NDArray[np.float64]
Shape = Literal["butterworth", "smoothing", "running_mean", "low_pass", "uneven"]

_GRID = 4096  # frequencies up to half the rate of the cosines
_FINEST = 16  # times as many up to half the rate of the samples, at most
_HALF_POWER = -math.log(2)
UNUSED_POWER = 0.08  # |H|² below which the fit uses no frequencies
_LEAST_POWER = 0.1  # |H|² from which a shape is compared
_ALIKE = 0.2  # largest difference of ln |H|² of a shape with a name: 0.9 dB
_MOST_ORDER, _LONGEST_MEAN = 4, 1000
_FASTEST_SMOOTHING = 0.4  # corner of exponential smoothing, times tau0: it never falls to half the power beyond
_SAME_CORNER = 1e-9  # relative error of a corner that is converted
_MOST_WARPED = 3.0  # corner of a filter over that of its samples
_HALF_RATE = 0.5  # times tau0
_AVERAGED = 1024  # cluster size from which sin⁴ is replaced by its mean of 3/8
_FARTHEST_CORNER, _CORNERS = 0.3, 61  # logarithm of a corner that is tried over that of the series, and their number
_EVERY = 16  # frequencies of the grid that are compared for them


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

    def power(self, f: Floats) -> Floats:
        """|H|² at frequencies; beyond those that the fit used, that of the shape that it is like, or falling.

        Parameters
        ----------
        f : ndarray, shape (n_f,)
            Frequencies. [Hz]

        Returns
        -------
        ndarray, shape (n_f,)
            Ratios of densities.
        """
        f = np.asarray(f, dtype=np.float64)
        found = np.exp(_logarithm(self.coefficients, f * self.interval))
        if self.known_to is not None:
            beyond = f > self.known_to
            found[beyond] = self._beyond(f[beyond])
        return np.asarray(found)

    def _beyond(self, f: Floats) -> Floats:
        corner = (self.corner or math.nan) * self.tau0
        if self.shape == "butterworth" and self.order is not None:
            return np.exp(_digital(f * self.tau0, corner, 2 * self.order))
        if self.shape == "smoothing":
            return np.exp(_smoothing(f * self.tau0, corner))
        if self.shape == "running_mean" and self.order is not None:
            return np.exp(_running_mean(f * self.tau0, self.order))
        known_to = self.known_to or math.nan
        return UNUSED_POWER * (known_to / f) ** 2

    def taken_off(
        self, density: Callable[[Floats], Floats], m: NDArray[np.int64], *, highest: float | None = None
    ) -> Floats:
        """What the filter takes off the Allan variances of noise with a density.

        From `highest` on nothing is taken off, unless the filter took the rest there: it is not known.

        Parameters
        ----------
        density : callable
            Two-sided density in front of the filter, from frequencies in Hz. [(rate unit)²/Hz]
        m : ndarray of int, shape (n_tau,)
            Cluster sizes in samples.
        highest : float, optional
            Frequency from which the band was left out. [Hz]

        Returns
        -------
        ndarray, shape (n_tau,)
            [(rate unit)²]
        """
        grid = _GRID * min(round(self.interval / self.tau0), _FINEST)
        f: Floats = (np.arange(grid, dtype=np.float64) + 0.5) / (2 * grid * self.tau0)
        lost = density(f) * (1 - self.power(f)) / np.sin(np.pi * f * self.tau0) ** 2
        if highest is not None and self.known_to is None:
            lost[f >= highest] = 0.0
        step = f[1] - f[0]
        short = m[m < _AVERAGED]
        fourth = np.sin(np.pi * np.outer(short, f * self.tau0)) ** 4
        sums = np.full(len(m), 0.375 * lost.sum())
        sums[m < _AVERAGED] = fourth @ lost
        return np.asarray(4 * step * sums / m.astype(np.float64) ** 2)

    def like(self) -> LowPass | None:
        """The Butterworth filter in front of the sampler whose samples have half their power at the corner.

        None for other shapes, and if there is none.
        """
        order = 1 if self.shape == "smoothing" else self.order
        if self.corner is None or order is None or self.shape not in ("butterworth", "smoothing"):
            return None
        at = np.array([0.0, self.corner])

        def off(corner: float) -> float:
            density = band_limited(1.0, LowPass(order=order, corner=corner), self.tau0).psd(at, self.tau0)
            return float(density[1] / density[0]) - 0.5

        low, high = self.corner / _MOST_WARPED, self.corner * _MOST_WARPED
        at_low, at_high = off(low), off(high)
        if at_low * at_high > 0:
            return None
        corner = root(off, (low, at_low), (high, at_high), absolute=_SAME_CORNER * self.corner)
        return LowPass(order=order, corner=corner, rate=1 / self.tau0)

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        like = None if self.low_pass is None else plain(self.low_pass, "order corner_hz=corner")
        known = plain(self, "shape order corner_hz=corner low_hz=low high_hz=high coefficients interval_s=interval")
        known_to = {} if self.known_to is None else {"known_to_hz": self.known_to}
        return {**known, "low_pass": like, **known_to}


def named(
    coefficients: tuple[float, ...], covariance: Floats, *, tau0: float, interval: float, quantile: float
) -> FittedFilter:
    """The filter with a name and the interval of its corner.

    Parameters
    ----------
    coefficients : tuple of float
    covariance : ndarray, shape (n, n)
        Of the coefficients.
    tau0, interval : float
        Of the samples, and of the cosines. [s]
    quantile : float
        Of the standard normal distribution, for the interval.
    """
    times = round(interval / tau0)
    x: Floats = (np.arange(_GRID, dtype=np.float64) + 0.5) / (2 * _GRID * times)  # frequency times tau0
    log_power = _logarithm(coefficients, x * times)
    below = np.flatnonzero(log_power < _HALF_POWER)
    shared: dict[str, Any] = {"coefficients": coefficients, "tau0": tau0, "interval": interval}
    if not len(below) or below[0] == 0:
        return FittedFilter(shape="uneven", order=None, corner=None, low=None, high=None, **shared)
    k = int(below[0])
    share = (_HALF_POWER - log_power[k - 1]) / (log_power[k] - log_power[k - 1])
    corner = x[k - 1] + share * (x[k] - x[k - 1])
    slope = (log_power[k] - log_power[k - 1]) / (x[k] - x[k - 1])
    cosines = np.cos(2 * np.pi * corner * times * np.arange(1, len(coefficients) + 1)) - 1
    error = math.sqrt(max(float(cosines @ covariance @ cosines), 0.0)) / abs(slope)
    kept = log_power > math.log(_LEAST_POWER)
    kept[k:] &= np.cumprod(kept[k:]).astype(bool)
    misfits = [(float(np.abs(f(x[kept]) - log_power[kept]).max()), s, n, f) for s, n, f in _shapes(float(corner))]
    misfit, shape, order, nearest = min(misfits, key=lambda one: one[0])
    if misfit > _ALIKE:
        shape, order = "low_pass", None
    # The series ends early and ripples: the interval holds the corner of the shape too, which has no ripple.
    other = _corner_of(nearest, x[kept][::_EVERY], log_power[kept][::_EVERY], float(corner))
    low, high = min(corner, other) - quantile * error, max(corner, other) + quantile * error
    return FittedFilter(
        shape=shape, order=order, corner=corner / tau0, low=max(low, 0.0) / tau0, high=high / tau0, **shared
    )


def _corner_of(like: Callable[[Floats], Floats], x: Floats, log_power: Floats, corner: float) -> float:
    """The corner of a shape whose ln |H|² is nearest, but for a constant, to that of the series at frequencies x; that of
    the series if the shape has a length instead of a corner. (Times tau0.)
    """
    if not isinstance(like, partial) or "corner" not in like.keywords:
        return corner
    tried = corner * np.exp(np.linspace(-_FARTHEST_CORNER, _FARTHEST_CORNER, _CORNERS))
    tried = tried[tried < _HALF_RATE]
    return float(min(tried, key=lambda one: float(np.var(like(x, corner=one) - log_power)), default=corner))


def _logarithm(coefficients: tuple[float, ...], x: Floats) -> Floats:
    """Ln |H|² at frequencies times tau0."""
    result = np.zeros_like(x)
    for k, a in enumerate(coefficients, 1):
        result += a * (np.cos(2 * np.pi * k * x) - 1)
    return result


def _shapes(corner: float) -> Iterator[tuple[Shape, int | None, Callable[[Floats], Floats]]]:
    """Filters with a name that have this corner (times tau0): ln |H|²."""
    for order in range(1, _MOST_ORDER + 1):
        yield "butterworth", order, partial(_digital, corner=corner, power=2 * order)
        yield "butterworth", order, partial(_folded, corner=corner, power=2 * order)
    if corner < _FASTEST_SMOOTHING:
        yield "smoothing", None, partial(_smoothing, corner=corner)
    length = round(0.443 / corner)
    if 2 <= length <= _LONGEST_MEAN:
        yield "running_mean", length, partial(_running_mean, length=length)


def _digital(x: Floats, corner: float, power: int) -> Floats:
    """A Butterworth filter by the bilinear transform."""
    return np.asarray(-np.log1p((np.tan(np.pi * x) / math.tan(math.pi * corner)) ** power))


def _smoothing(x: Floats, corner: float) -> Floats:
    """Exponential smoothing, y += (1 − p)(x − y): |H|² = (1 − p)² / (1 − 2p cos + p²)."""
    c = math.cos(2 * math.pi * corner)
    p = (2 - c) - math.sqrt((2 - c) ** 2 - 1)
    return np.asarray(np.log((1 - p) ** 2 / (1 - 2 * p * np.cos(2 * np.pi * x) + p * p)))


def _running_mean(x: Floats, length: int) -> Floats:
    power = (np.sin(np.pi * length * x) / (length * np.sin(np.pi * x))) ** 2
    return np.asarray(np.log(np.maximum(power, 1e-12)))


def _folded(x: Floats, corner: float, power: int) -> Floats:
    """White noise behind an analog filter, folded by sampling, over its density at the frequency 0."""
    images = [np.zeros_like(x), np.zeros_like(x)]
    for k in range(-8, 9):
        images[0] += 1 / (1 + (np.abs(x + k) / corner) ** power)
        images[1] += 1 / (1 + (abs(k) / corner) ** power)
    return np.asarray(np.log(images[0] / images[1]))
