"""Autocovariances of the sampled noise terms: of stationary rates, and of the integral of any rate.

If a rate is not stationary, only its differences have a covariance. They suffice for an Allan variance, which is [6s(0)
− 8s(n) + 2s(2n)]/(2T²) for any function s(l) with the same fourth differences as the covariance of the phase (angle,
velocity). For a stationary rate s(l) = −Var(x_l − x_0)/2.

All lags are whole numbers of samples, 0 or more.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau._native.distributions import digamma
from sigmatau.arrays import Floats
from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.model.processes import GaussMarkov, LowPass, Resonance

_Complex = NDArray[np.complex128]

_MEMORY = 40.0  # memory in time constants; the remainder e⁻⁴⁰ is below rounding
_SERIES_BELOW = 0.5
_SERIES = 18  # number of terms of a series; the last is 0.5^18/20! of the first


def whole_lags(lags: ArrayLike) -> Floats:
    """Absolute values of whole lags: the covariance of a real process is symmetric."""
    requested = np.asarray(lags).ravel()
    size = requested.astype(np.float64) if requested.dtype.kind in "iuf" else np.array([math.nan])
    if not np.isfinite(size).all() or (size != np.round(size)).any():
        raise OptionError("{option} must be whole numbers of samples", option="lags")
    return np.asarray(np.abs(size))


def rate_autocovariance(term: str, value: float, lags: Floats, tau0: float) -> Floats:
    """Autocovariance of the rate of quantization noise or the random walk, the only stationary terms."""
    if term == "quantization":  # differences of white noise
        return np.asarray(value**2 / tau0**2 * (2.0 * (lags == 0) - 1.0 * (lags == 1)))
    if term == "random_walk":
        return np.asarray(value**2 / tau0 * (lags == 0))
    raise DataError(f"{term} has no autocovariance")


def phase_autocovariance_of_term(term: str, value: float, lags: Floats, tau0: float) -> Floats:
    """Generalised autocovariance of the phase, s(l)."""
    if term == "quantization":
        return np.asarray(value**2 * (lags == 0))
    if term == "random_walk":
        return -(value**2) * tau0 / 2 * lags
    if term == "bias_instability":
        return value**2 * flicker_phase(lags, tau0)
    if term == "rate_random_walk":
        return value**2 * tau0**3 / 12 * (lags**3 - lags)
    if term == "rate_ramp":
        return value**2 * tau0**4 / 24 * lags**4  # random slope with this mean square
    raise DataError(f"{term} has no generalised autocovariance")


def flicker_phase(lags: Floats, tau0: float) -> Floats:
    """s(l) of discrete flicker noise with B = 1: −τ₀²/(2π)·J(l)."""
    inside = np.maximum(lags, 2.0)
    # Σ 1/(2j − 1), j = 1 … l − 1
    odd = (digamma(inside - 0.5) + np.euler_gamma + 2 * math.log(2)) / 2
    j = -(4 * inside**2 - 1) / 2 * odd + 2 * inside * (inside - 1) - (inside - 1) ** 2 / 2
    return np.where(lags < 2, 0.0, -(tau0**2) / (2 * math.pi) * j)


@frozen(eq=False, kw_only=False)
class Damped:
    """A stationary rate whose samples have the autocovariance Re Σ weight·exp(−decay·l) at the lag l."""

    weights: _Complex
    decays: _Complex  # per sample; real parts are positive

    @property
    def slowest(self) -> float:
        """Smallest real part of a decay: the inverse of the memory in samples."""
        return float(self.decays.real.min())

    @property
    def fastest(self) -> float:
        """Largest magnitude of a decay."""
        return float(np.abs(self.decays).max())

    def autocovariance(self, lags: Floats) -> Floats:
        return np.asarray((self.weights[:, None] * np.exp(-self.decays[:, None] * lags)).sum(axis=0).real)

    def phase(self, lags: Floats, tau0: float) -> Floats:
        """s(l) of the integral."""
        ends = np.array([float(math.ceil(_MEMORY / self.slowest))])
        # Beyond the memory of the process the variance is linear in the lag.
        short = lags < ends[0]
        variance = np.empty(lags.shape)
        variance[short] = self._sum_variance(lags[short])
        if not short.all():
            slope = float((self.weights / np.tanh(self.decays / 2)).sum().real)
            variance[~short] = self._sum_variance(ends)[0] + slope * (lags[~short] - ends[0])
        return np.asarray(-(tau0**2) / 2 * variance)

    def psd(self, frequency: Floats, tau0: float) -> Floats:
        """Two-sided density of the samples, with aliasing."""
        a = self.decays[:, None]
        below = np.expm1(-a) ** 2 + 4 * np.exp(-a) * np.sin(np.pi * frequency * tau0) ** 2
        parts = -self.weights[:, None] * np.expm1(-2 * a) / below
        return np.asarray(np.maximum(tau0 * parts.sum(axis=0).real, 0.0))

    def _sum_variance(self, lags: Floats) -> Floats:
        return np.asarray((self.weights[:, None] * exponential_sum_variance(self.decays, lags)).sum(axis=0).real)


def gauss_markov(process: GaussMarkov, tau0: float) -> Damped:
    """A sampled Gauss-Markov process, σ²·exp(−lτ₀/T)."""
    return Damped(np.array([process.sigma**2 + 0j]), np.array([tau0 / process.time + 0j]))


def resonance(process: Resonance, tau0: float) -> Damped:
    """A sampled resonance, σ²·Re[(1 + iγ/ω)·exp((iω − γ)lτ₀)]."""
    weight = process.sigma**2 * (1 + 1j * process.damping / process.turning)
    return Damped(np.array([weight]), np.array([(process.damping - 1j * process.turning) * tau0]))


def band_limited(n: float, bandwidth: LowPass, tau0: float) -> Damped:
    """Sampled white noise after a Butterworth filter, from its poles in the left half-plane."""
    order, corner = bandwidth.order, bandwidth.corner
    angles = math.pi * (2 * np.arange(order) + order + 1) / (2 * order)
    poles = np.exp(1j * angles)
    return Damped(-poles * (n * n * math.pi * corner / order), -poles * 2 * math.pi * corner * tau0)


def phase_of_sinusoid(amplitude: float, frequency: float, lags: Floats, tau0: float) -> Floats:
    """s(l) of a sampled sinusoid of random phase: −A²τ₀²·sin²(πflτ₀)/(4·sin²(πfτ₀))."""
    turn = math.pi * math.fmod(frequency * tau0, 1.0)
    if math.sin(turn) == 0.0:  # sampled once a turn: a constant
        return np.asarray(-((amplitude * tau0 * lags) ** 2) / 4)
    # Only the fraction of a turn is used: it does not lose digits.
    phase = math.pi * np.fmod(lags * math.fmod(frequency * tau0, 1.0), 1.0)
    return np.asarray(-((amplitude * tau0 * np.sin(phase) / math.sin(turn)) ** 2) / 4)


def exponential_sum_variance(decay: _Complex, lags: Floats) -> _Complex:
    """Variance of the sum of l samples with the autocovariance e^(−a·k), for real or complex decays.

    Notes
    -----
    [l·sinh a − 1 + e^(−al)]/(cosh a − 1), which is [l(1 − p²) − 2p(1 − pˡ)]/(1 − p)² with p = e^(−a). For slow decay it
    is written as [l(sinh a − a) + (al − 1 + e^(−al))]/(2 sinh²(a/2)). The two parts of this sum are positive for a real
    decay, so that nothing cancels.

    `decay` is a, per sample; its real part is positive.
    """
    variances = np.empty((len(decay), len(lags)), dtype=np.complex128)
    for row, a in zip(variances, decay, strict=True):
        whole = a * lags
        with np.errstate(under="ignore", over="ignore"):
            if abs(a) < 1:
                # Both differences lose digits for small arguments, where series replace them.
                row[:] = (lags * _sinh_remainder(a) + exponential_remainder(whole)) / (2 * np.sinh(a / 2) ** 2)
            else:
                p = np.exp(-a)
                row[:] = lags * (1 + p) / (1 - p) - 2 * p * (1 - np.exp(-whole)) / (1 - p) ** 2
    return variances


def _sinh_remainder(a: complex) -> complex:
    """The difference sinh a − a."""
    term = total = a**3 / 6
    for k in range(2, 10):
        term = term * a * a / ((2 * k) * (2 * k + 1))
        total = total + term
    return total


def exponential_remainder(x: _Complex) -> _Complex:
    """The difference e^(−x) − 1 + x."""
    x = np.asarray(x)
    value = np.asarray(np.exp(-x) - 1 + x)
    is_small = np.abs(x) < _SERIES_BELOW
    small = x[is_small]
    term = total = small**2 / 2
    for k in range(3, _SERIES):
        term = -term * small / k
        total = total + term
    value[is_small] = total
    return value
