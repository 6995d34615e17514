"""Generalised least squares on Allan variances, with the weights of the model that is being fitted.

The variances at different averaging times are correlated, up to 0.99 for neighbours, and their errors depend on the noise
that is sought. Each step therefore takes the exact covariance for the last step's coefficients, and solves for
non-negative squared coefficients; weights from the measured variances would bias the long times low, because a variance
that happens to be small would count more.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sigmatau.components import Components

__all__ = ["Gls", "Score", "Weights"]

Floats = NDArray[np.float64]

_STEPS = 40
_DAMPED_FROM = 8
_TOLERANCE = 1e-6
_RIDGES = (0.0, 1e-12, 1e-10, 1e-8, 1e-6)


class Weights(NamedTuple):
    """A covariance as sd·(L Lᵀ)·sd, with the Cholesky factor L of the correlation."""

    factor: Floats
    sd: Floats

    def whiten(self, columns: Floats) -> Floats:
        """Columns with independent errors of variance 1."""
        from scipy.linalg import lapack

        return np.asarray(lapack.dtrtrs(self.factor, columns / self.sd[:, None], lower=1)[0])

    def unwhiten(self, row: Floats) -> Floats:
        """Weights on the data of an estimate that is given by weights on the whitened data."""
        from scipy.linalg import lapack

        return np.asarray(lapack.dtrtrs(self.factor, row, lower=1, trans=1)[0]) / self.sd


@dataclass(frozen=True, slots=True, eq=False)
class Score:
    """The estimate of one squared coefficient against a trial value, all others fitted for that value.

    Attributes
    ----------
    z : float
        (estimate − trial) / sigma; the estimate is free, also to be negative.
    sigma, skewness : float
        Of the estimate, if the trial value is the true one.
    theta : ndarray
        The trial value and the others, fitted.
    weights : ndarray
        Of the Allan variances in the estimate.
    """

    z: float
    sigma: float
    skewness: float
    theta: Floats
    weights: Floats


class Gls:
    """Allan variances of a record and the components that may make them; squared coefficients θ in samples.

    Parameters
    ----------
    parts : Components
    avar : ndarray, shape (n_tau,)
    """

    __slots__ = ("_first", "_flat", "_second", "avar", "parts")

    def __init__(self, parts: Components, avar: Floats) -> None:
        self.parts = parts
        self.avar = avar
        terms = len(parts.names)
        first, second = zip(*((p, q) for p in range(terms) for q in range(p, terms)), strict=True)
        self._first, self._second = np.array(first), np.array(second)
        self._flat = parts.noise.reshape(len(first), -1)

    @property
    def terms(self) -> range:
        """Indices of the terms."""
        return range(len(self.parts.names))

    def covariance(self, theta: Floats) -> Floats:
        """Of the Allan variances, if θ is true."""
        j = len(self.avar)
        return np.asarray(((theta[self._first] * theta[self._second]) @ self._flat).reshape(j, j))

    def weights(self, theta: Floats) -> Weights:
        """Raises FloatingPointError if θ gives no covariance."""
        from scipy.linalg import lapack

        covariance = self.covariance(theta)
        variances = covariance.diagonal()
        if not (np.isfinite(variances).all() and variances.min() > 0):
            raise FloatingPointError("these coefficients give no variance")
        sd = np.sqrt(variances)
        correlation = covariance / (sd[:, None] * sd)
        for ridge in _RIDGES:
            correlation.flat[:: len(sd) + 1] += ridge
            factor, failed = lapack.dpotrf(correlation, lower=1)
            if not failed:
                return Weights(factor, sd)
        raise FloatingPointError("the covariance of the Allan variances is not positive")

    def fit(
        self,
        active: Sequence[int] | range | None = None,
        *,
        fixed: tuple[int, float] | None = None,
        start: Floats | None = None,
    ) -> Floats:
        """Non-negative θ of the active terms; the others are 0, but the fixed one has its value.

        Raises FloatingPointError where there is nothing to fit.
        """
        design = self.parts.design
        terms = [p for p in (self.terms if active is None else active) if fixed is None or p != fixed[0]]
        target = self.avar if fixed is None else self.avar - fixed[1] * design[:, fixed[0]]
        theta = np.zeros(len(self.parts.names))
        if start is None:
            # Relative errors: every averaging time counts the same.
            theta[terms] = _non_negative(design[:, terms] / self.avar[:, None], target / self.avar)
        else:
            theta[terms] = start[terms]
        if fixed is not None:
            theta[fixed[0]] = fixed[1]
        columns = np.column_stack([target, design[:, terms]])
        expected = design @ theta
        for step in range(_STEPS):
            whitened = self.weights(theta).whiten(columns)
            new = theta.copy()
            new[terms] = _non_negative(whitened[:, 1:], whitened[:, 0])
            if step >= _DAMPED_FROM:
                new = 0.5 * (new + theta)
            before, expected = expected, design @ new
            theta = new
            if np.all(np.abs(expected - before) <= _TOLERANCE * before):
                break
        return theta

    def chi2(self, theta: Floats) -> float:
        """Misfit rᵀV⁻¹r."""
        r = self.weights(theta).whiten((self.avar - self.parts.design @ theta)[:, None])
        return float(np.sum(r * r))

    def p_value(self, theta: Floats) -> float:
        """Probability of a larger misfit, if the model is right."""
        from scipy.special import gammaincc

        freedom = max(len(self.avar) - int((theta > 0).sum()), 1)
        return float(gammaincc(freedom / 2, self.chi2(theta) / 2))

    def covariance_of_theta(self, theta: Floats, active: Sequence[int]) -> Floats:
        """Of unbounded estimates of the active terms, if θ is true."""
        terms = list(active)
        whitened = self.weights(theta).whiten(self.parts.design[:, terms])
        scale = np.linalg.norm(whitened, axis=0)
        inverse = np.linalg.pinv(whitened / scale)
        return np.asarray(inverse @ inverse.T / np.outer(scale, scale))

    def score(self, term: int, trial: float, *, start: Floats | None = None) -> Score:
        """Compare the estimate of one term with a trial value; see `Score`."""
        theta = self.fit(fixed=(term, trial), start=start)
        weights = self.weights(theta)
        others = [p for p in self.terms if p != term]
        design = self.parts.design
        whitened = weights.whiten(np.column_stack([self.avar, design[:, others], design[:, term]]))
        columns = whitened[:, 1:]
        q, r = np.linalg.qr(columns / np.linalg.norm(columns, axis=0))
        # The last row of the pseudo-inverse: what of the term's column the others cannot make.
        row = q[:, -1] / (r[-1, -1] * np.linalg.norm(columns[:, -1]))
        sigma = float(np.linalg.norm(row))
        on_data = weights.unwhiten(row)
        skewness, variance = self.parts.skewness(on_data, theta)
        # Independent modes overstate the degrees of freedom where the ends of the record matter.
        correction = min(max(sigma / variance**0.5, 0.7), 1.5)
        return Score(
            z=(float(row @ whitened[:, 0]) - trial) / sigma,
            sigma=sigma,
            skewness=correction * skewness,
            theta=theta,
            weights=on_data,
        )


def _non_negative(columns: Floats, target: Floats) -> Floats:
    """Non-negative least squares on columns of one length."""
    scale = np.linalg.norm(columns, axis=0)
    scaled = columns / scale
    # Unbounded first: most fits need no bound.
    free = np.linalg.lstsq(scaled, target, rcond=None)[0]
    if free.size == 0 or free.min() > 0:
        return np.asarray(free / scale)
    from scipy.optimize import nnls

    return np.asarray(nnls(scaled, target)[0] / scale)
