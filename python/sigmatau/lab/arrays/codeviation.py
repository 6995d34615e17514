"""Allan covariance of two sensors, and the N-cornered hat, by averaging time.

References
----------
.. [1] É. Lantz et al., "KLTS: a rigorous method to compute the confidence intervals for the three-cornered hat and for
   Groslambert covariance," IEEE Trans. Ultrason. Ferroelectr. Freq. Control, vol. 66, no. 12, 2019,
   :doi:`10.1109/TUFFC.2019.2931911`.
.. [2] R. J. Vaccaro, A. S. Zaki, "Reduced-drift virtual gyro from an array of low-cost gyros," Sensors, vol. 17, no. 2,
   352, 2017, :doi:`10.3390/s17020352`.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from sigmatau import Record, allan
from sigmatau.arrays import Floats, freeze
from sigmatau.frozen import frozen
from sigmatau.lab.arrays.intervals import correlation_interval, difference_interval, variance_interval
from sigmatau.results import plain

_LEAST_FREEDOM = 1e-3  # smallest degrees of freedom of a part of a hat; its interval is then unbounded


@frozen(eq=False)
class AllanCovariance:
    """Allan covariance of two channels, ½E[Δȳ₁Δȳ₂], against averaging time.

    Attributes
    ----------
    first, second : str
        Channels.
    tau : ndarray, shape (n_tau,)
        [s]
    covariance, low, high : ndarray, shape (n_tau,)
        Covariance with its interval. [unit²]
    correlation, correlation_low, correlation_high : ndarray, shape (n_tau,)
        Covariance divided by the product of both deviations, with its interval. [1]
    edf : ndarray, shape (n_tau,)
        Degrees of freedom.
    """

    first: str
    second: str
    tau: Floats
    covariance: Floats
    low: Floats
    high: Floats
    correlation: Floats
    correlation_low: Floats
    correlation_high: Floats
    edf: Floats

    def __post_init__(self) -> None:
        freeze(self, "tau", "covariance", "low", "high", "correlation", "correlation_low", "correlation_high", "edf")

    @property
    def codeviation(self) -> Floats:
        """Root of the covariance with its sign (Groslambert codeviation); shape (n_tau,). [unit]"""
        return np.asarray(np.sign(self.covariance) * np.sqrt(np.abs(self.covariance)))

    def to_dict(self) -> dict[str, object]:
        """Plain columns in SI."""
        return plain(
            self, "first second tau_s=tau covariance low high correlation correlation_low correlation_high edf"
        )


@frozen(eq=False)
class HatCurve:
    """Allan deviation of one sensor by the N-cornered hat, against averaging time.

    Attributes
    ----------
    channel : str
    tau : ndarray, shape (n_tau,)
        [s]
    variance : ndarray, shape (n_tau,)
        Estimate, which may be negative. [unit²]
    low, high : ndarray, shape (n_tau,)
        Interval of the Allan deviation; low is 0 where the variance is not significant. [unit]
    upper_limit : ndarray, shape (n_tau,)
        Upper limit of the deviation where the variance is not significant, NaN elsewhere. [unit]
    """

    channel: str
    tau: Floats
    variance: Floats
    low: Floats
    high: Floats
    upper_limit: Floats

    def __post_init__(self) -> None:
        freeze(self, "tau", "variance", "low", "high", "upper_limit")

    @property
    def adev(self) -> Floats:
        """Allan deviation; NaN where only the limit is known; shape (n_tau,). [unit]"""
        return np.sqrt(np.where(np.isnan(self.upper_limit), np.maximum(self.variance, 0.0), np.nan))

    def to_dict(self) -> dict[str, object]:
        """Plain columns in SI; null where a value is not known."""
        columns = {
            name: [float(x) if np.isfinite(x) else None for x in values]
            for name, values in (("adev", self.adev), ("upper_limit", self.upper_limit))
        }
        return plain(self, "channel tau_s=tau low high") | columns


def allan_variances(samples: Floats, tau0: float, tau: Floats) -> Floats:
    """Allan variances of series, shape (n, N), at averaging times; shape (n, n_tau). [unit²]"""
    names = [f"signal_{k}" for k in range(len(samples))]
    curves = allan(Record.from_arrays(rate=1 / tau0, **dict(zip(names, samples, strict=True))), taus=tau)
    return np.stack([curves[name].avar for name in names])


def allan_covariances(
    names: tuple[str, ...], samples: Floats, tau0: float, tau: Floats, edf: Floats, *, level: float
) -> tuple[AllanCovariance, ...]:
    """Allan covariance of each pair of channels.

    By polarisation, ¼(AVAR(u + v) − AVAR(u − v)), with u and v scaled to equal size: sum and difference are then
    independent. `edf`: degrees of freedom by channel, shape (n, n_tau).
    """
    variances = allan_variances(samples, tau0, tau)
    sizes = np.sqrt(variances[:, :1])
    results = []
    for i, j in combinations(range(len(names)), 2):
        u, v = samples[i] / sizes[i], samples[j] / sizes[j]
        plus, minus = allan_variances(np.stack([u + v, u - v]), tau0, tau)
        covariance = 0.25 * (plus - minus) * sizes[i] * sizes[j]
        product = np.sqrt(variances[i] * variances[j])
        correlation = np.clip(covariance / product, -1.0, 1.0)
        freedom = np.sqrt(edf[i] * edf[j])
        low, high = correlation_interval(correlation, freedom, level)
        halves = [0.5 * (1 + sign * correlation) for sign in (1, -1)]
        below, above = difference_interval(
            halves[0],
            variance_interval(halves[0], freedom, level),
            halves[1],
            variance_interval(halves[1], freedom, level),
        )
        results.append(
            AllanCovariance(
                first=names[i],
                second=names[j],
                tau=tau,
                covariance=covariance,
                low=below * product,
                high=above * product,
                correlation=correlation,
                correlation_low=low,
                correlation_high=high,
                edf=freedom,
            )
        )
    return tuple(results)


def hat_curves(
    names: tuple[str, ...], samples: Floats, tau0: float, tau: Floats, edf: Floats, *, level: float
) -> tuple[HatCurve, ...]:
    """N-cornered hat of independent sensors with a common disturbance, by least squares on all pairs.

    For three sensors this is the Groslambert covariance of two differences, which equals the three-cornered hat. `edf`:
    degrees of freedom of a difference, shape (n_tau,).
    """
    n = len(names)
    pairs = list(combinations(range(n), 2))
    differences = allan_variances(np.stack([samples[i] - samples[j] for i, j in pairs]), tau0, tau)
    square = np.zeros((len(tau), n, n))
    for (i, j), values in zip(pairs, differences, strict=True):
        square[:, i, j] = square[:, j, i] = values
    # Covariance of the contrasts x₀ − x_j, from the variances of all differences
    contrasts = 0.5 * (square[:, :1, 1:].transpose(0, 2, 1) + square[:, :1, 1:] - square[:, 1:, 1:])
    root = _roots(contrasts)
    results = []
    for channel in range(n):
        values = np.linalg.eigvalsh(root @ _hat_weights(n, channel) @ root)
        parts = [np.maximum(sign * values, 0.0) for sign in (1, -1)]
        sums = [part.sum(axis=1) for part in parts]
        freedoms = [
            np.maximum(edf * total**2 / np.maximum((part**2).sum(axis=1), 1e-300), _LEAST_FREEDOM)
            for total, part in zip(sums, parts, strict=True)
        ]
        low, high = _difference(sums, freedoms, level)
        limit = _difference(sums, freedoms, 2 * level - 1)[1]
        is_limit = low <= 0
        results.append(
            HatCurve(
                channel=names[channel],
                tau=tau,
                variance=sums[0] - sums[1],
                low=np.sqrt(np.maximum(low, 0.0)),
                high=np.sqrt(np.maximum(high, 0.0)),
                upper_limit=np.where(is_limit, np.sqrt(np.maximum(limit, sums[0])), np.nan),
            )
        )
    return tuple(results)


def _difference(sums: list[Floats], freedoms: list[Floats], level: float) -> tuple[Floats, Floats]:
    intervals = [variance_interval(total, freedom, level) for total, freedom in zip(sums, freedoms, strict=True)]
    return difference_interval(sums[0], intervals[0], sums[1], intervals[1])


def _roots(matrices: Floats) -> Floats:
    """Symmetric roots of positive semidefinite matrices."""
    values, vectors = np.linalg.eigh(matrices)
    return np.asarray(np.einsum("bik,bk,bjk->bij", vectors, np.sqrt(np.maximum(values, 0.0)), vectors))


def _hat_weights(n: int, channel: int) -> Floats:
    """Matrix A for which tr(A·R) estimates the variance of a channel; R is the covariance of the contrasts x₀ − x_j.

    Least squares on all pairs: d_i = [Σ_j a_ij − Σ_{j<k} a_jk/(n − 1)]/(n − 2), where a_jk is the variance of x_j − x_k.
    """
    matrix = np.zeros((n - 1, n - 1))
    for j, k in combinations(range(n), 2):
        contrast = np.zeros(n)
        contrast[j], contrast[k] = -1.0, 1.0  # in terms of x₀ − x_j
        weight = ((channel in (j, k)) - 1 / (n - 1)) / (n - 2)
        matrix += weight * np.outer(contrast[1:], contrast[1:])
    return matrix
