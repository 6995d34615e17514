"""Low-pass filters before a sampler: what is left of white and flicker noise, frequency by frequency and τ by τ.

A filtered sensor that is sampled has the folded spectrum S_y(f) = Σ_k S(f + k·fs), or in time the filter's autocovariance at
whole sample intervals. Both are here in closed form for each shape, for white noise of unit density in front of the filter.

Butterworth filters of order n: with the poles p_j of the left half-plane the residues of H(s)·H(−s) are −p_j/(2n), so that
r(t) = −Σ_j p_j/(2n)·exp(p_j|t|), of which the folded spectrum is a sum of geometric series. Order 1 is the RC filter.
Running means over a time L have a triangle as autocovariance, two such means in a row (Bartlett's window) its convolution
with itself, the cubic B-spline.

Digital Butterworth filters, made by the bilinear transform, work on samples: nothing is folded, tan(πf/fs) takes the place
of f (A. V. Oppenheim, R. W. Schafer, Discrete-Time Signal Processing, section 7.2), and half the sampling rate is a zero.
"""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau.arrays import Floats, Ints

__all__ = [
    "SHAPES",
    "autocovariance",
    "digital",
    "folded_flicker",
    "folded_white",
    "mean_corner",
    "order_of",
    "relative_avar",
    "response",
    "right_from",
]

_DIGITAL = {"digital1": 1, "digital2": 2, "digital4": 4}
_ORDERS = {"first_order": 1, "butterworth2": 2, "butterworth3": 3, "butterworth4": 4, **_DIGITAL}
SHAPES = ("first_order", "butterworth2", "butterworth3", "butterworth4", "mean", "bartlett", *_DIGITAL)
"""Filters that are told apart."""

# Length of a running mean with −3 dB at 1 Hz: sinc²(L) = 1/2; of one of two in a row: sinc⁴(L) = 1/2.
_MEAN_LENGTH = 0.4429464707
_BARTLETT_LENGTH = 0.3189166987
_IMAGES = 8  # flicker noise at the eighth image is (1/16)^3 of that at half the sampling rate


def digital(shape: str) -> bool:
    """Whether a filter works on the samples, so that its corner is below half the sampling rate and nothing is folded."""
    return shape in _DIGITAL


def autocovariance(shape: str, corner: float, lag: ArrayLike) -> Floats:
    """Autocovariance of white noise of unit two-sided density behind an analog filter, by lags in seconds. [1/s]"""
    t: Floats = np.abs(np.atleast_1d(np.asarray(lag, dtype=float)))
    if shape == "mean":
        length = _MEAN_LENGTH / corner
        return np.asarray(np.maximum(1 - t / length, 0) / length)
    if shape == "bartlett":
        length = _BARTLETT_LENGTH / corner
        u = t / length
        inner = 2 / 3 - u * u + u**3 / 2
        return np.where(u < 1, inner, np.maximum(2 - u, 0) ** 3 / 6) / length
    poles = _poles(_ORDERS[shape]) * (2 * math.pi * corner)
    return np.asarray((-poles / (2 * len(poles)) * np.exp(np.outer(t, poles))).real.sum(axis=1))


def folded_white(shape: str, corner: float, frequency: ArrayLike, tau0: float) -> Floats:
    """Two-sided density of sampled white noise of unit density behind a filter, images folded in; shape (n_f,)."""
    f: Floats = np.atleast_1d(np.asarray(frequency, dtype=float))
    if digital(shape):
        return response(shape, corner, f, tau0=tau0)
    cosine = np.cos(2 * np.pi * f * tau0)
    if shape in ("mean", "bartlett"):
        length = _MEAN_LENGTH if shape == "mean" else 2 * _BARTLETT_LENGTH
        lags = np.arange(1, math.ceil(length / (corner * tau0)) + 1)
        r = autocovariance(shape, corner, lags * tau0)
        zero = float(autocovariance(shape, corner, 0.0)[0])
        return np.asarray(tau0 * (zero + 2 * np.cos(2 * np.pi * tau0 * np.outer(f, lags)) @ r))
    poles = _poles(_ORDERS[shape]) * (2 * math.pi * corner)
    z = np.exp(poles * tau0)
    weights = -poles * tau0 / (2 * len(poles)) * (1 - z * z)
    return np.asarray((weights / (1 - 2 * np.outer(cosine, z) + z * z)).real.sum(axis=1))


def folded_flicker(shape: str, corner: float, frequency: ArrayLike, tau0: float) -> Floats:
    """The same of flicker noise 1/(2π|f|), eq. (18) with B = 1; before a digital filter it is sampled, 1/sin."""
    f: Floats = np.atleast_1d(np.asarray(frequency, dtype=float))
    if digital(shape):
        return np.asarray(response(shape, corner, f, tau0=tau0) * tau0 / (2 * np.sin(np.pi * f * tau0)))
    images = np.abs(f[:, None] + np.arange(-_IMAGES, _IMAGES + 1) / tau0)
    return np.asarray((response(shape, corner, images) / (2 * np.pi * images)).sum(axis=1))


def response(shape: str, corner: float, frequency: ArrayLike, *, tau0: float = 1.0) -> Floats:
    """|H(f)|², not folded; `tau0` is for digital filters."""
    f = np.asarray(frequency, dtype=float)
    if digital(shape):
        # By sine and cosine: the tangent has no value at half the sampling rate.
        power = 2 * _DIGITAL[shape]
        passed = (np.cos(np.pi * f * tau0) * math.tan(math.pi * corner * tau0)) ** power
        return np.asarray(passed / (passed + np.sin(np.pi * f * tau0) ** power))
    if shape == "mean":
        return np.asarray(np.sinc(f * (_MEAN_LENGTH / corner)) ** 2)
    if shape == "bartlett":
        return np.asarray(np.sinc(f * (_BARTLETT_LENGTH / corner)) ** 4)
    return np.asarray(1 / (1 + (f / corner) ** (2 * _ORDERS[shape])))


def relative_avar(shape: str, corner: float, m: ArrayLike, tau0: float) -> Floats:
    """Allan variance of sampled, filtered white noise over that of the white noise which it is at long times.

    AVAR(m)·τ/N², with N the random walk of the sampled record, folding included; tends to 1. For small cluster sizes: all
    lags up to twice the largest are summed.
    """
    sizes = np.atleast_1d(np.asarray(m, dtype=np.int64))
    lags = 2 * int(sizes.max())
    r = (
        _sampled(shape, corner * tau0, lags) / tau0
        if digital(shape)
        else autocovariance(shape, corner, np.arange(lags) * tau0)
    )
    # Variance of the sum of l samples: l·r(0) + 2·Σ_{k<l} (l − k) r(k).
    sums = np.concatenate(([0.0], np.cumsum(r)))
    totals = np.concatenate(([0.0], np.cumsum(r * np.arange(len(r)))))

    def variance(count: Ints) -> Floats:
        return np.asarray(2 * (count * sums[count] - totals[count]) - count * r[0])

    avar = (4 * variance(sizes) - variance(2 * sizes)) / (2 * sizes.astype(float) ** 2)
    plateau = float(folded_white(shape, corner, 0.0, tau0)[0])
    return np.asarray(avar * sizes * tau0 / plateau)


def right_from(shape: str, corner: float, tau0: float, *, share: float = 0.02) -> float:
    """Averaging time from which the Allan variance is within `share` of that of unfiltered noise. [s]

    The deficit falls as 1/τ once the autocovariance is over: of a first-order filter with time constant τ_f it is
    1.5·τ_f/τ.
    """
    m = max(math.ceil(4 / (corner * tau0)), 2)
    deficit = abs(1 - float(relative_avar(shape, corner, m, tau0)[0]))
    return max(deficit * m * tau0 / share, tau0)


def mean_corner(shape: str, length: float) -> float:
    """Corner of running means over `length` seconds. [Hz]"""
    return (_MEAN_LENGTH if shape == "mean" else _BARTLETT_LENGTH) / length


def _sampled(shape: str, corner: float, lags: int) -> Floats:
    """Autocovariance of white noise behind a digital filter at whole sample intervals, from its density on a fine grid."""
    # The slowest pole of the fourth order, 0.38 of the corner, is over by 1e-16 in 16 periods of the corner.
    length = 1 << math.ceil(math.log2(max(2 * lags, 16 / corner, 64)))
    density = response(shape, corner, np.arange(length // 2 + 1) / length, tau0=1.0)
    return np.asarray(np.fft.irfft(density, length)[:lags])


@functools.lru_cache(maxsize=16)
def _poles(order: int) -> NDArray[np.complex128]:
    """Of the Butterworth filter with corner at 1 rad/s."""
    return np.asarray(np.exp(1j * np.pi * (2 * np.arange(order) + order + 1) / (2 * order)))


def order_of(shape: str) -> int | None:
    """Order of a Butterworth filter; None for running means."""
    return _ORDERS.get(shape)
