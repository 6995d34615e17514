"""Generalised least squares on Allan variances, with the weights of the model that is being fitted.

The variances at different averaging times are correlated, up to 0.99 for neighbours, and their errors depend on the noise
that is estimated. Each step therefore uses the exact covariance for the coefficients of the last step and solves for
non-negative squared coefficients. Weights from the measured variances would bias the long times low, because a variance that
is small by chance would have a large weight.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.kernels import Factor
from sigmatau.fitting.components import Components
from sigmatau.fitting.non_negative import non_negative
from sigmatau.frozen import frozen

Floats = NDArray[np.float64]

_STEPS = 40  # of the iteration, at most
_DAMPED_FROM = 8  # steps; later ones are averaged with the step before
_TOLERANCE = 1e-5  # relative change of the expected variances at which the iteration ends
_MOST_NEGATIVE = 0.03  # largest negative eigenvalue that is corrected, as a share of the largest positive one
_LEAST_EIGENVALUE = 1e-9  # of correlations


@frozen(eq=False, kw_only=False)
class Score:
    """Comparison of the estimate of one squared coefficient with a trial value, all others fitted for that value."""

    z: float  # (estimate − trial) / sigma; the estimate is unconstrained and may be negative
    sigma: float  # Of the estimate, if the trial value is true
    skewness: float
    theta: Floats  # The trial value, and the other coefficients fitted
    weights: Floats  # Of the Allan variances in the estimate


class Gls:
    """Generalised least squares problem: Allan variances and their components; squared coefficients θ in samples.
    `candidates`: indices of the terms that are fitted. Default: all; `tangent`: derivative of the variances by the
    shape of a term that was found by a search. Errors of the shape are then not evidence of any term.
    """

    __slots__ = ("avar", "candidates", "parts", "tangent")

    def __init__(
        self, parts: Components, avar: Floats, candidates: Sequence[int] | None = None, tangent: Floats | None = None
    ) -> None:
        self.parts = parts
        self.avar = avar
        self.tangent = np.empty((len(avar), 0)) if tangent is None else tangent[:, None]
        self.candidates = tuple(range(len(parts.names)) if candidates is None else candidates)

    def covariance(self, theta: Floats) -> Floats:
        """Of the Allan variances, if θ is true."""
        return self.parts.covariance(theta)

    def weights(self, theta: Floats) -> Factor:
        """Factor of the inverse covariance. Raises FloatingPointError if θ has no positive definite covariance."""
        return self._factor(self.covariance(theta))

    def _factor(self, covariance: Floats) -> Factor:
        try:
            return Factor(covariance)
        except FloatingPointError:
            if self.parts.ramp_weights is None:
                raise
            return Factor(_positive_definite(covariance))

    def fit(
        self,
        active: Sequence[int] | None = None,
        *,
        fixed: tuple[int, float] | None = None,
        start: Floats | None = None,
    ) -> Floats:
        """Non-negative θ of the active terms (default: all candidates); the others are 0, the fixed one keeps its
        value. Raises FloatingPointError if the covariance is not positive definite.
        """
        design = self.parts.design
        terms = [p for p in (self.candidates if active is None else active) if fixed is None or p != fixed[0]]
        target = self.avar if fixed is None else self.avar - fixed[1] * design[:, fixed[0]]
        theta = np.zeros(len(self.parts.names))
        if start is None:
            # Equal relative errors at all averaging times.
            theta[terms] = non_negative(design[:, terms] / self.avar[:, None], target / self.avar)
        else:
            theta[terms] = start[terms]
        if fixed is not None:
            theta[fixed[0]] = fixed[1]
        columns = np.column_stack([target, design[:, terms]])
        expected = design @ theta
        for step in range(_STEPS):
            whitened = self.weights(theta).whiten(columns)
            new = theta.copy()
            new[terms] = non_negative(whitened[:, 1:], whitened[:, 0])
            if step >= _DAMPED_FROM:
                new = 0.5 * (new + theta)
            before, expected = expected, design @ new
            theta = new
            if np.all(np.abs(expected - before) <= _TOLERANCE * before):
                break
        return theta

    def covariance_of_theta(self, theta: Floats, active: Sequence[int]) -> Floats:
        """Covariance of unconstrained estimates of the active terms, if θ is true."""
        terms = list(active)
        whitened = self.weights(theta).whiten(np.column_stack([self.parts.design[:, terms], self.tangent]))
        scale = np.linalg.norm(whitened, axis=0)
        inverse = np.linalg.pinv(whitened / scale)
        covariance = inverse @ inverse.T / np.outer(scale, scale)
        return np.asarray(covariance[: len(terms), : len(terms)])

    def score(self, term: int, trial: float, *, start: Floats | None = None) -> Score:
        """Compare the estimate of one term with a trial value; see `Score`."""
        theta = self.fit(fixed=(term, trial), start=start)
        weights = self.weights(theta)
        others = [p for p in self.candidates if p != term]
        design = self.parts.design
        whitened = weights.whiten(np.column_stack([self.avar, self.tangent, design[:, others], design[:, term]]))
        columns = whitened[:, 1:]
        q, r = np.linalg.qr(columns / np.linalg.norm(columns, axis=0))
        # The last row of the pseudo-inverse: the part of the term's column that is orthogonal to the others.
        row = q[:, -1] / (r[-1, -1] * np.linalg.norm(columns[:, -1]))
        sigma = float(np.linalg.norm(row))
        on_data = weights.unwhiten(row)
        skewness, variance = self.parts.skewness(on_data, theta)
        # Independent modes overestimate the degrees of freedom where the ends of the record matter.
        correction = min(max(sigma / variance**0.5, 0.7), 1.5)
        return Score(
            z=(float(row @ whitened[:, 0]) - trial) / sigma,
            sigma=sigma,
            skewness=correction * skewness,
            theta=theta,
            weights=on_data,
        )


def relative_fit(columns: Floats, avar: Floats, errors: Floats) -> Floats:
    """Non-negative θ fitted to a curve with independent relative errors."""
    weights = 1 / (errors * avar)
    return non_negative(columns * weights[:, None], avar * weights)


def _positive_definite(covariance: Floats) -> Floats:
    """A covariance with the signs of slightly negative eigenvalues changed. The covariance without the ramp is
    approximate: in the direction of the ramp it may be slightly negative if quantization noise leaves the other
    directions hardly any variance. The size of the negative eigenvalue is the error of the approximation and is taken
    as the variance. Raises FloatingPointError if the covariance is worse than that.
    """
    sd = np.sqrt(np.maximum(covariance.diagonal(), 0))
    if not sd.all():
        raise FloatingPointError("a variance is not positive")
    values, vectors = np.linalg.eigh(covariance / np.outer(sd, sd))
    if values[0] < -_MOST_NEGATIVE * values[-1]:
        raise FloatingPointError("the covariance is not positive definite")
    values = np.maximum(np.abs(values), _LEAST_EIGENVALUE)
    return np.asarray((vectors * values) @ vectors.T * np.outer(sd, sd))
