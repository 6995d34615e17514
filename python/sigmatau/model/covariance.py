"""Autocovariances of the noise terms, in samples: of stationary rates, and of the integral of every rate.

Of a rate that is not stationary only differences have a covariance, and an Allan variance asks for no more: it is
[6s(0) − 8s(n) + 2s(2n)]/(2T²) of any function s(l) whose fourth differences are those of the covariance of the phase
(angle, velocity). For a stationary rate s(l) = −Var(x_l − x_0)/2.

All lags are whole samples, and not negative.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau.errors import OptionError

Floats = NDArray[np.float64]
_Complex = NDArray[np.complex128]

_MEMORY = 40.0  # time constants; what is left is e⁻⁴⁰, below rounding
_SERIES_BELOW = 0.5
_SERIES = 18  # terms, of which the last is 0.5^18/20! of the first


def whole_lags(lags: ArrayLike) -> Floats:
    """Lags as non-negative numbers: the covariance of a real process is symmetric."""
    given = np.asarray(lags).ravel()
    size = given.astype(np.float64) if given.dtype.kind in "iuf" else np.array([math.nan])
    if not np.isfinite(size).all() or (size != np.round(size)).any():
        raise OptionError("{option} must be whole numbers of samples", option="lags")
    return np.asarray(np.abs(size))


def rate_of_term(term: str, value: float, lags: Floats, tau0: float) -> Floats:
    """Autocovariance of the rate of quantization noise or the random walk, the only stationary terms."""
    if term == "quantization":  # differences of white noise
        return np.asarray(value**2 / tau0**2 * (2.0 * (lags == 0) - 1.0 * (lags == 1)))
    return np.asarray(value**2 / tau0 * (lags == 0))


def phase_of_term(term: str, value: float, lags: Floats, tau0: float) -> Floats:
    """Generalised autocovariance of the phase, s(l)."""
    if term == "quantization":
        return np.asarray(value**2 * (lags == 0))
    if term == "random_walk":
        return -(value**2) * tau0 / 2 * lags
    if term == "bias_instability":
        return value**2 * flicker_phase(lags, tau0)
    if term == "rate_random_walk":
        return value**2 * tau0**3 / 12 * (lags**3 - lags)
    return value**2 * tau0**4 / 24 * lags**4  # a ramp, of a slope with this mean square


def flicker_phase(lags: Floats, tau0: float) -> Floats:
    """s(l) of discrete flicker noise with B = 1: −τ₀²/(2π)·J(l)."""
    from scipy.special import digamma

    inside = np.maximum(lags, 2.0)
    # Σ 1/(2j − 1), j = 1 … l − 1
    odd = (digamma(inside - 0.5) + np.euler_gamma + 2 * math.log(2)) / 2
    j = -(4 * inside**2 - 1) / 2 * odd + 2 * inside * (inside - 1) - (inside - 1) ** 2 / 2
    return np.where(lags < 2, 0.0, -(tau0**2) / (2 * math.pi) * j)


def gauss_markov(sigma: float, time: float, lags: Floats, tau0: float) -> Floats:
    """Autocovariance σ²·exp(−lτ₀/T)."""
    return np.asarray(sigma**2 * np.exp(-lags * tau0 / time))


def phase_of_gauss_markov(sigma: float, time: float, lags: Floats, tau0: float) -> Floats:
    """s(l) of a sampled Gauss-Markov process."""
    decay = np.array([tau0 / time], dtype=np.complex128)
    return np.asarray(-((sigma * tau0) ** 2) / 2 * exponential_sum_variance(decay, lags)[0].real)


def phase_of_sinusoid(amplitude: float, frequency: float, lags: Floats, tau0: float) -> Floats:
    """s(l) of a sampled sinusoid of random phase: −A²τ₀²·sin²(πflτ₀)/(4·sin²(πfτ₀))."""
    turn = math.pi * math.fmod(frequency * tau0, 1.0)
    if math.sin(turn) == 0.0:  # sampled once a turn: a constant
        return np.asarray(-((amplitude * tau0 * lags) ** 2) / 4)
    # Of the turns only the part beyond whole ones counts, and it alone keeps its digits.
    phase = math.pi * np.fmod(lags * math.fmod(frequency * tau0, 1.0), 1.0)
    return np.asarray(-((amplitude * tau0 * np.sin(phase) / math.sin(turn)) ** 2) / 4)


def band_limited(n: float, order: int, corner: float, lags: Floats, tau0: float) -> Floats:
    """Autocovariance of white noise behind a Butterworth filter, sampled."""
    poles, weights = _butterworth(n, order, corner)
    turn = 2 * math.pi * corner * tau0
    return np.asarray((weights[:, None] * np.exp(poles[:, None] * turn * lags)).sum(axis=0).real)


def phase_of_band_limited(n: float, order: int, corner: float, lags: Floats, tau0: float) -> Floats:
    """s(l) of white noise behind a Butterworth filter, sampled."""
    poles, weights = _butterworth(n, order, corner)
    decays = -poles * 2 * math.pi * corner * tau0
    ends = np.array([float(math.ceil(_MEMORY / float(decays.real.min())))])
    # From where the filter has forgotten, the variance is a straight line.
    near = lags < ends[0]
    variance = np.empty(lags.shape)
    variance[near] = (weights[:, None] * exponential_sum_variance(decays, lags[near])).sum(axis=0).real
    if not near.all():
        slope = float((weights / np.tanh(decays / 2)).sum().real)
        begin = float((weights[:, None] * exponential_sum_variance(decays, ends)).sum().real)
        variance[~near] = begin + slope * (lags[~near] - ends[0])
    return np.asarray(-(tau0**2) / 2 * variance)


def _butterworth(n: float, order: int, corner: float) -> tuple[_Complex, _Complex]:
    """Poles in the left half-plane in units of the corner, and their weights in r(t) = Re Σ w·e^(p·ωc·|t|)."""
    angles = math.pi * (2 * np.arange(order) + order + 1) / (2 * order)
    poles = np.exp(1j * angles)
    return poles, -poles * (n * n * math.pi * corner / order)


def exponential_sum_variance(decay: _Complex, lags: Floats) -> _Complex:
    """Variance of the sum of l samples of autocovariance e^(−a·k), for decays that may be complex.

    Notes
    -----
    [l·sinh a − 1 + e^(−al)]/(cosh a − 1), which is [l(1 − p²) − 2p(1 − pˡ)]/(1 − p)² with p = e^(−a). Written as
    [l(sinh a − a) + (al − 1 + e^(−al))]/(2 sinh²(a/2)), a sum of two parts that are positive for a real decay, nothing
    cancels for slow decay.

    `decay`: a, per sample; its real part is positive.
    """
    a, size = decay[:, None], lags[None, :]
    whole = a * size
    slow = np.abs(a) < 1
    gentle = np.where(slow, a, 1.0)
    # Two series, since both differences lose their digits where their argument is small.
    numerator = size * _sinh_less(gentle) + _exponential_less(whole)
    with np.errstate(under="ignore", over="ignore"):
        careful = numerator / (2 * np.sinh(gentle / 2) ** 2)
        p = np.exp(-a)
        plain = size * (1 + p) / (1 - p) - 2 * p * (1 - np.exp(-whole)) / (1 - p) ** 2
    return np.asarray(np.where(slow, careful, plain))


def _sinh_less(a: _Complex) -> _Complex:
    """The difference sinh a − a."""
    term = total = a**3 / 6
    for k in range(2, 10):
        term = term * a * a / ((2 * k) * (2 * k + 1))
        total = total + term
    return total


def _exponential_less(x: _Complex) -> _Complex:
    """The difference e^(−x) − 1 + x."""
    small = np.where(np.abs(x) < _SERIES_BELOW, x, 0.0)
    term = total = small**2 / 2
    for k in range(3, _SERIES):
        term = -term * small / k
        total = total + term
    with np.errstate(under="ignore"):
        return np.where(np.abs(x) < _SERIES_BELOW, total, np.exp(-x) - 1 + x)
