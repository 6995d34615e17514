"""Weights of a virtual sensor: the linear combination of sensors, with sum 1, whose noise of some kind is smallest.

References
----------
.. [1] D. S. Bayard, S. R. Ploen, "High accuracy inertial sensors from inexpensive components," US patent 6 882 964, 2005.
.. [2] R. J. Vaccaro, A. S. Zaki, "Reduced-drift virtual gyro from an array of low-cost gyros," Sensors, vol. 17, no. 2,
   352, 2017, :doi:`10.3390/s17020352`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sigmatau._native.distributions import normal_quantile, student_quantile
from sigmatau.arrays import Floats
from sigmatau.frozen import frozen
from sigmatau.lab.arrays.covariance_fit import CovarianceFit
from sigmatau.lab.arrays.intervals import Estimate, satterthwaite

# Degrees of freedom, beyond the number of sensors, that weights need. [1] Derived: with fewer, their error more than doubles
# the variance of the virtual sensor.
_LEAST_SPARE = 3.0
# P-value below which weights are better than equal ones. [1] Judgement: the usual level.
_SIGNIFICANT = 0.05
_STEPS = 200  # number of terms of the sum for the F distribution


@frozen(eq=False)
class Weights:
    """Weights of a virtual sensor.

    Attributes
    ----------
    values : tuple of Estimate
        One per channel; their sum is 1.
    freedom : float
        Degrees of freedom of the variance that they minimise.
    factors : ndarray, shape (n_components,)
        Factors that correct the variances w'·C_t·w of the components for the error of the weights: without them they are
        too small, because the weights are fitted to the errors of the C_t.
    gain : Estimate
        Deviation of the best sensor, divided by that of the virtual sensor.
    best : int
        Index of the best sensor.
    gain_over_equal : Estimate
        Deviation of the equal-weight mean, divided by that of the virtual sensor.
    p_equal : float
        P-value of the hypothesis that equal weights are optimal.
    """

    values: tuple[Estimate, ...]
    freedom: float
    factors: Floats
    gain: Estimate
    best: int
    gain_over_equal: Estimate
    p_equal: float

    @property
    def vector(self) -> Floats:
        """The weights; shape (n,). [1]"""
        return np.array([estimate.value for estimate in self.values])

    @property
    def differ(self) -> bool:
        """Whether the weights are significantly better than equal ones."""
        return self.p_equal < _SIGNIFICANT

    def to_dict(self) -> dict[str, object]:
        """Plain values."""
        return {
            "values": [estimate.to_dict() for estimate in self.values],
            "edf": self.freedom if math.isfinite(self.freedom) else None,
            "gain": self.gain.to_dict(),
            "gain_over_equal": self.gain_over_equal.to_dict(),
            "p_equal": self.p_equal,
        }


def optimal_vector(matrix: Floats) -> Floats:
    """Weights with sum 1 that minimise w'·C·w."""
    solved = np.linalg.solve(matrix, np.ones(len(matrix)))
    return np.asarray(solved / solved.sum())


def estimate_weights(
    fit: CovarianceFit, amounts: Sequence[float] | Floats, *, level: float, widening: float
) -> Weights | None:
    """Weights that minimise Σ_t amounts_t·w'·C_t·w, with intervals; None if the record determines it too weakly.

    Weights are like coefficients of a regression: the error of C enlarges their variance by ν/(ν − n + 1), and they follow
    Student's distribution.
    """
    elements = fit.structure.elements
    matrix = np.einsum("t,tp,pij->ij", np.asarray(amounts, dtype=float), fit.theta, _matrices(fit))
    n = len(matrix)
    gradient_of_theta = np.kron(np.asarray(amounts, dtype=float), np.eye(len(elements)))
    covariance = widening**2 * gradient_of_theta @ fit.covariance @ gradient_of_theta.T
    basis = _matrices(fit)
    w = optimal_vector(matrix)
    minimum = float(w @ matrix @ w)
    inverse = np.linalg.inv(matrix)
    projector = inverse - np.outer(inverse.sum(axis=1), inverse.sum(axis=1)) / inverse.sum()
    slope = np.einsum("i,pij,j->p", w, basis, w)
    nu = satterthwaite(minimum, math.sqrt(float(slope @ covariance @ slope)))
    if nu < n + _LEAST_SPARE:
        return None
    jacobian = -np.einsum("ia,pab,b->ip", projector, basis, w)
    freedom = nu - n + 1
    error = np.sqrt(np.maximum(np.einsum("ip,pq,iq->i", jacobian, covariance, jacobian), 0.0) * nu / freedom)
    quantile = float(student_quantile(freedom, 0.5 + level / 2))
    values = tuple(
        Estimate(value=float(x), low=float(x - quantile * e), high=float(x + quantile * e))
        for x, e in zip(w, error, strict=True)
    )
    # factor on the minimum: the estimate is too small, and the true variance with estimated weights is larger
    loss = nu / freedom * (nu - 1) / (nu - n)
    factors = _factors(fit, basis, widening, np.asarray(amounts, dtype=float), w, projector, loss)
    best = int(np.argmin(np.diag(matrix)))
    equal = np.full(n, 1 / n)
    single = np.eye(n)[best]
    ratio = float(equal @ matrix @ equal) / minimum - 1
    return Weights(
        values=values,
        freedom=nu,
        factors=factors,
        gain=_gain(single, w, matrix, basis, covariance, loss, level),
        best=best,
        gain_over_equal=_gain(equal, w, matrix, basis, covariance, loss, level),
        p_equal=_f_above(ratio * freedom / (n - 1), n - 1, freedom),
    )


def _factors(
    fit: CovarianceFit, basis: Floats, widening: float, amounts: Floats, w: Floats, projector: Floats, loss: float
) -> Floats:
    """Distribute the factor `loss` on the sum over the variances of the components.

    The errors dC of the matrices change the weights by −P·dC·w, so that the expectation of w'·dC_t·w is lowered by
    2·E[w'·dC_t·P·dC·w].
    """
    parts = np.einsum("i,pij,jk,qkl,l->pq", w, basis, projector, basis, w)
    size, count = fit.theta.shape[1], len(amounts)
    covariance = widening**2 * fit.covariance.reshape(count, size, count, size)
    bias = np.einsum("u,tpuq,pq->t", amounts, covariance, parts)
    variances = np.einsum("tp,i,pij,j->t", fit.theta, w, basis, w)
    relative = float(amounts @ bias) / float(amounts @ variances)
    shares = np.divide(bias, variances, out=np.zeros(count), where=variances > 0)
    return np.asarray(1 + np.maximum((loss - 1) * shares / max(relative, 1e-300), 0.0))


def _matrices(fit: CovarianceFit) -> Floats:
    """Matrices E_p for the channels, also if the fit is one of contrasts; shape (n_parameters, n, n)."""
    if fit.structure.semidefinite:
        return fit.structure.elements
    n = len(fit.structure.elements)
    return np.asarray(np.eye(n)[:, :, None] * np.eye(n)[:, None, :])


def _gain(
    reference: Floats, w: Floats, matrix: Floats, basis: Floats, covariance: Floats, loss: float, level: float
) -> Estimate:
    """Deviation of another combination, divided by that of the virtual sensor, with an interval by logarithms."""
    sizes = [float(each @ matrix @ each) for each in (reference, w)]
    slopes = [
        np.einsum("i,pij,j->p", each, basis, each) / size for each, size in zip((reference, w), sizes, strict=True)
    ]
    difference = slopes[0] - slopes[1]
    error = 0.5 * math.sqrt(max(float(difference @ covariance @ difference), 0.0))
    value = math.sqrt(sizes[0] / (sizes[1] * loss))
    factor = math.exp(float(normal_quantile(0.5 + level / 2)) * error)
    return Estimate(value=value, low=value / factor, high=value * factor)


def _f_above(value: float, first: float, second: float) -> float:
    """Probability that F with these degrees of freedom exceeds a value, as a mean over the χ² of the denominator."""
    from sigmatau._native.distributions import chi2_above, gamma_quantile

    if not math.isfinite(second) or second > 1e6:
        return float(chi2_above(first, max(value, 0.0) * first))
    shares = (np.arange(_STEPS) + 0.5) / _STEPS
    denominators = 2 * gamma_quantile(np.full(_STEPS, second / 2), shares) / second
    return float(np.mean(chi2_above(np.full(_STEPS, first), max(value, 0.0) * first * denominators)))
