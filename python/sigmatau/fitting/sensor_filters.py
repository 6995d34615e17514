"""Filters between the white noise of a sensor and its sampler: |H|², and its sum over the images that sampling folds.

For a filter with the autocovariance R(t) = ∫ |H|² exp(2πi f t) df the folded density is Σ_k |H(f + k·rate)|² = τ₀ Σ_m
R(m·τ₀) cos(2π f m τ₀). For poles it is a sum of geometric series, for one running mean two Fejér kernels; both are exact at
any rate. The first parameter of every filter is ln of its frequency of −3 dB.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import Floats
from sigmatau.frozen import frozen

_BISECTIONS = 60  # number of bisections that determine a frequency to all digits
_SPACING = 1e-6  # smallest relative distance of two poles, so that their residues stay finite
_LONGEST_SUM = 400  # largest number of lags of a sum of cosines; a longer filter has few images
_IMAGES = 2  # number of images on either side for a longer filter
# limits of the damping of two poles: below, it is a resonance; above, the faster pole is not visible
_DAMPING = (0.3, 3.0)
_SHARPNESS = (
    0.25,
    12.0,
)  # limits of duration × cutoff of a FIR filter: from its taper alone to a transition of 1/8 of the band
_TAPS = 256  # taps of the impulse response of a FIR filter in its table
_PADDED = 16384  # samples of the transform of a table: 64 frequency steps in one inverse duration
_PASS_EDGE = 3.0  # distance above the cutoff where a FIR filter stops everything [inverse durations]
_HIGHEST_DIGITAL = 0.49  # largest corner of a digital filter, over its clock
_LOWEST = 1e-12  # smallest |H|², instead of 0


@frozen
class SensorFilter:
    """A family of filters with one or two parameters.

    Attributes
    ----------
    name : str
        ``"one pole"``, ``"Butterworth"``, ``"two poles"``, ``"running mean"``, ``"FIR"``.
    order : int
        Number of poles or of running means in series; 0 for a FIR filter.
    power : callable
        |H|² at frequencies [Hz], as a function of the parameters.
    folded : callable
        Sum of |H|² over all images, at frequencies and for a sampling rate [Hz], as a function of the parameters.
    equivalent : callable
        Noise-equivalent bandwidth, one-sided, as a function of the parameters. [Hz]
    start : tuple of float
        Names of the parameters after the first.
    limits : tuple of (float, float)
        Limits of these parameters.
    """

    name: str
    order: int
    power: Callable[[Floats, Floats], Floats]
    folded: Callable[[Floats, float, Floats], Floats]
    equivalent: Callable[[Floats], float]
    start: tuple[float, ...] = ()
    limits: tuple[tuple[float, float], ...] = ()

    @property
    def count(self) -> int:
        """Number of parameters that are fitted."""
        return 1 + len(self.start)

    @property
    def text(self) -> str:
        """The family with its order."""
        if self.name.endswith("Butterworth"):
            return f"{self.name}, {self.order} pole{'s' if self.order > 1 else ''}"
        return f"{self.order} running means in series" if self.name == "running mean" and self.order > 1 else self.name

    def aliasing(self, rate: float, numbers: Floats) -> float:
        """Factor by which sampling at a rate increases N. [1]"""
        return math.sqrt(float(self.folded(np.zeros(1), rate, numbers)[0]))


@functools.cache
def all_filters(clock: float | None = None) -> tuple[SensorFilter, ...]:
    """List the families that are compared, those with fewer parameters first. Digital filters are included if their clock
    is given. [Hz]
    """
    butterworth = [_pole_filter("one pole" if n == 1 else "Butterworth", n) for n in (1, 2, 3, 4, 6)]
    means = [_mean_filter(stages) for stages in (1, 2, 3)]
    digital = [] if clock is None else [_digital(order, clock) for order in (1, 2, 3, 4)]
    return (*butterworth, *means, *digital, _two_poles(), *(_taper_filter(name) for name in _TAPERS))


def _pole_filter(name: str, order: int) -> SensorFilter:
    angles = np.pi * (2 * np.arange(order) + order + 1) / (2 * order)
    unit = np.exp(1j * angles)
    residues = -unit / (2 * order)

    def power(f: Floats, numbers: Floats) -> Floats:
        return np.asarray(1 / (1 + (f / math.exp(numbers[0])) ** (2 * order)))

    def folded(f: Floats, rate: float, numbers: Floats) -> Floats:
        w = 2 * math.pi * math.exp(numbers[0])
        return _geometric(f, rate, unit * w, residues * w)

    def equivalent(numbers: Floats) -> float:
        return math.exp(numbers[0]) * (math.pi / (2 * order)) / math.sin(math.pi / (2 * order))

    return SensorFilter(name=name, order=order, power=power, folded=folded, equivalent=equivalent)


def _digital(order: int, clock: float) -> SensorFilter:
    """Butterworth filter by the bilinear transform, for samples at a rate."""

    def power(f: Floats, numbers: Floats) -> Floats:
        corner = min(math.exp(numbers[0]), _HIGHEST_DIGITAL * clock)
        ratio = np.tan(np.pi * np.minimum(f / clock, 0.5)) / math.tan(math.pi * corner / clock)
        return np.asarray(np.where(f < clock / 2, np.maximum(1 / (1 + ratio ** (2 * order)), _LOWEST), 0.0))

    def folded(f: Floats, rate: float, numbers: Floats) -> Floats:
        return _images(f, rate, lambda shifted: power(shifted, numbers), math.ceil(0.5 * clock / rate))

    def equivalent(numbers: Floats) -> float:
        f = (np.arange(_TAPS * 16) + 0.5) / (_TAPS * 32) * clock
        return float(power(f, numbers).mean()) * clock / 2

    return SensorFilter(name="digital Butterworth", order=order, power=power, folded=folded, equivalent=equivalent)


def _two_poles() -> SensorFilter:
    def undamped(numbers: Floats) -> tuple[float, float]:
        """Frequency without damping [Hz], and the damping."""
        damping = math.exp(numbers[1])
        b = 1 - 2 * damping * damping
        return math.exp(numbers[0]) / math.sqrt(b + math.hypot(b, 1.0)), damping

    def power(f: Floats, numbers: Floats) -> Floats:
        corner, damping = undamped(numbers)
        squared = (f / corner) ** 2
        return np.asarray(1 / ((1 - squared) ** 2 + 4 * damping * damping * squared))

    def poles(numbers: Floats) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        corner, damping = undamped(numbers)
        w = 2 * math.pi * corner
        if abs(damping - 1) < _SPACING:
            damping = 1 + _SPACING
        root = np.sqrt(complex(damping * damping - 1))
        p = np.asarray(w * np.array([-damping + root, -damping - root]), dtype=np.complex128)
        # lim (s − p) H(s) H(−s), with H = w²/((s − p)(s − q)).
        residues = np.asarray(w**4 / ((p - p[::-1]) * (-2 * p) * (-p - p[::-1])))
        return p, residues

    def folded(f: Floats, rate: float, numbers: Floats) -> Floats:
        return _geometric(f, rate, *poles(numbers))

    def equivalent(numbers: Floats) -> float:
        corner, damping = undamped(numbers)
        return math.pi * corner / (4 * damping)

    low, high = (math.log(limit) for limit in _DAMPING)
    return SensorFilter(
        name="two poles", order=2, power=power, folded=folded, equivalent=equivalent,
        start=(math.log(0.9),), limits=((low, high),),
    )  # fmt: skip


def _geometric(f: Floats, rate: float, poles: NDArray[np.complex128], residues: NDArray[np.complex128]) -> Floats:
    """τ₀ Σ_m R(m·τ₀) cos(ω m τ₀) of R(t) = Σ c exp(p |t|)."""
    z = np.exp(poles / rate)
    # 1 − z² without cancellation of poles far below the rate.
    rest = -np.expm1(2 * poles.real / rate + 2j * poles.imag / rate)
    cosine = np.cos(2 * np.pi * f / rate)[:, None]
    terms = residues * rest / (1 - 2 * z * cosine + z * z)
    return np.asarray(np.maximum(terms.real.sum(axis=1) / rate, _LOWEST))


def _mean_filter(stages: int) -> SensorFilter:
    half = _find_root(lambda x: np.sinc(x) ** (2 * stages) - 0.5, 0.0, 1.0)

    def duration(numbers: Floats) -> float:
        return half / math.exp(numbers[0])

    def power(f: Floats, numbers: Floats) -> Floats:
        return np.asarray(np.sinc(f * duration(numbers)) ** (2 * stages))

    def folded(f: Floats, rate: float, numbers: Floats) -> Floats:
        length = duration(numbers) * rate
        if stages == 1:
            return _fejer(f / rate, length)
        if length * stages > _LONGEST_SUM:
            return _images(f, rate, lambda shifted: power(shifted, numbers), _IMAGES)
        lags = np.arange(1, math.ceil(length * stages) + 1)
        r = _spline(lags / length, stages) / length
        cosines = np.cos(2 * np.pi / rate * np.outer(f, lags))
        return np.asarray(np.maximum(_spline(np.zeros(1), stages)[0] / length + 2 * cosines @ r, _LOWEST))

    def equivalent(numbers: Floats) -> float:
        return float(_spline(np.zeros(1), stages)[0]) / duration(numbers) / 2

    return SensorFilter(name="running mean", order=stages, power=power, folded=folded, equivalent=equivalent)


def _fejer(x: Floats, length: float) -> Floats:
    """Folded density of the mean over a time that is not an integer number of samples; x is relative to the rate.

    The triangle of the lags is a mixture of the triangles for the two nearest integers.
    """
    whole = math.floor(length)
    part = length - whole
    sine = np.sin(np.pi * x) ** 2
    limits = part * (whole + 1) ** 2 + (1 - part) * whole**2
    mixture = part * np.sin(np.pi * (whole + 1) * x) ** 2 + (1 - part) * np.sin(np.pi * whole * x) ** 2
    return np.maximum(np.where(sine > _LOWEST, mixture / np.maximum(sine, _LOWEST), limits) / length**2, _LOWEST)


def _spline(x: Floats, stages: int) -> Floats:
    """Autocovariance of means of unit length in series: the B-spline of twice the order, (2s − 1)-times differentiable."""
    n = 2 * stages
    terms = [(-1) ** i * math.comb(n, i) * np.maximum(x + stages - i, 0.0) ** (n - 1) for i in range(n + 1)]
    return np.where(np.abs(x) < stages, np.sum(terms, axis=0) / math.factorial(n - 1), 0.0)


def _images(f: Floats, rate: float, power: Callable[[Floats], Floats], count: int) -> Floats:
    shifted = np.abs(f[:, None] + rate * np.arange(-count, count + 1))
    return np.asarray(np.maximum(power(shifted.ravel()).reshape(shifted.shape).sum(axis=1), _LOWEST))


_TAPERS = {"Hamming": (0.54, 0.46, 0.0), "Blackman": (0.42, 0.5, 0.08)}
"""Coefficients of a taper: a₀ + a₁ cos 2πt + a₂ cos 4πt, |t| ≤ ½."""


@functools.lru_cache(maxsize=256)
def _table(taper: str, sharpness: float) -> tuple[Floats, float, float]:
    """|H|² of a tapered sinc of unit duration at steps of `_TAPS / _PADDED`, its −3 dB, and its equivalent bandwidth."""
    t = (np.arange(_TAPS) + 0.5) / _TAPS - 0.5
    a0, a1, a2 = _TAPERS[taper]
    window = a0 + a1 * np.cos(2 * np.pi * t) + a2 * np.cos(4 * np.pi * t)
    h = window * np.sinc(2 * sharpness * t)
    response = np.abs(np.fft.rfft(h, _PADDED) / h.sum()) ** 2
    step = _TAPS / _PADDED
    table = response[: math.ceil((sharpness + _PASS_EDGE) / step) + 1]
    k = int(np.argmax(table < 0.5))
    half = (k - (0.5 - table[k]) / (table[k - 1] - table[k])) * step
    return table, half, float(table.sum() - 0.5 * (table[0] + table[-1])) * step


def _taper_filter(taper: str) -> SensorFilter:
    step = _TAPS / _PADDED

    def power(f: Floats, numbers: Floats) -> Floats:
        table, half, _ = _table(taper, math.exp(numbers[1]))
        position = f * (half / math.exp(numbers[0]) / step)
        return np.interp(position, np.arange(len(table)), table, right=_LOWEST)

    def folded(f: Floats, rate: float, numbers: Floats) -> Floats:
        table, half, _ = _table(taper, math.exp(numbers[1]))
        duration = half / math.exp(numbers[0])
        if duration * rate < 1:  # means at different samples do not overlap: R(τ₀) = 0
            return np.full(len(f), 2 * equivalent(numbers) / rate)
        count = math.ceil(len(table) * step / (duration * rate)) + 1
        return _images(f, rate, lambda shifted: power(shifted, numbers), count)

    def equivalent(numbers: Floats) -> float:
        _, half, area = _table(taper, math.exp(numbers[1]))
        return area * math.exp(numbers[0]) / half

    low, high = (math.log(limit) for limit in _SHARPNESS)
    return SensorFilter(
        name=f"FIR, {taper} taper", order=0, power=power, folded=folded, equivalent=equivalent,
        start=(math.log(2.0),), limits=((low, high),),
    )  # fmt: skip


def _find_root(function: Callable[[float], float], low: float, high: float) -> float:
    """Find the zero of a falling function."""
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if function(middle) > 0 else (low, middle)
    return low
