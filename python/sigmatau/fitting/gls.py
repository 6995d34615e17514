"""Generalised least squares on Allan variances, with the weights of the model that is being fitted.

The variances at different averaging times are correlated, up to 0.99 for neighbours, and their errors depend on the noise
that is sought. Each step therefore takes the exact covariance for the last step's coefficients, and solves for
non-negative squared coefficients; weights from the measured variances would bias the long times low, because a variance
that happens to be small would count more.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.kernels import Factor
from sigmatau.fitting.components import Components

__all__ = ["Gls", "Score", "non_negative", "relative_fit"]

Floats = NDArray[np.float64]

_STEPS = 40
_DAMPED_FROM = 8
_TOLERANCE = 1e-5
_MOST_MENDED = 0.03
_LEAST_EIGENVALUE = 1e-9


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
    candidates : sequence of int, optional
        Indices of the terms that may be there. Default: all.
    tangent : ndarray, shape (n_tau,), optional
        How the variances change with the shape of a term that was found by a search: what errors of the shape may add to
        the variances does not count as evidence of any term.
    """

    __slots__ = ("avar", "candidates", "parts", "tangent")

    def __init__(
        self,
        parts: Components,
        avar: Floats,
        candidates: Sequence[int] | None = None,
        tangent: Floats | None = None,
    ) -> None:
        self.parts = parts
        self.avar = avar
        self.tangent = np.empty((len(avar), 0)) if tangent is None else tangent[:, None]
        self.candidates = tuple(range(len(parts.names)) if candidates is None else candidates)

    def covariance(self, theta: Floats) -> Floats:
        """Of the Allan variances, if θ is true."""
        return self.parts.covariance(theta)

    def weights(self, theta: Floats) -> Factor:
        """Raises FloatingPointError if θ gives no covariance."""
        return self._factor(self.covariance(theta))

    def _factor(self, covariance: Floats) -> Factor:
        try:
            return Factor(covariance)
        except FloatingPointError:
            if self.parts.ramp_weights is None:
                raise
            return Factor(_mended(covariance))

    def _squares(self, covariance: Floats, errors: Floats) -> float:
        """Misfit rᵀV⁻¹r."""
        whitened = self._factor(covariance).whiten(errors)
        return float(whitened @ whitened)

    def fit(
        self,
        active: Sequence[int] | None = None,
        *,
        fixed: tuple[int, float] | None = None,
        start: Floats | None = None,
    ) -> Floats:
        """Non-negative θ of the active terms (default: all candidates); the others are 0, the fixed one has its value.

        Raises FloatingPointError where there is nothing to fit.
        """
        design = self.parts.design
        terms = [p for p in (self.candidates if active is None else active) if fixed is None or p != fixed[0]]
        target = self.avar if fixed is None else self.avar - fixed[1] * design[:, fixed[0]]
        theta = np.zeros(len(self.parts.names))
        if start is None:
            # Relative errors: every averaging time counts the same.
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

    def p_value(self, theta: Floats) -> float:
        """Probability of a larger misfit, if the model is right: the larger one for the variances and for their logarithms.

        A variance of a few degrees of freedom is so skewed that the χ² of the differences is far too large now and then,
        where the noise of the longest times happened to be strong; that of the logarithms, where it happened to be weak. A
        model that is wrong shows in both.
        """
        from scipy.special import gammaincc, polygamma, psi

        expected = self.parts.design @ theta
        covariance = self.covariance(theta)
        half = expected**2 / covariance.diagonal()  # of the degrees of freedom
        # Of the logarithm of a χ² over its degrees of freedom; correlated as the variances are.
        mean, sd = psi(half) - np.log(half), np.sqrt(polygamma(1, half))
        of_logarithms = covariance * np.outer(sd / expected * np.sqrt(half), sd / expected * np.sqrt(half))
        ratio = np.log(self.avar / expected) - mean
        misfit = min(self._squares(covariance, self.avar - expected), self._squares(of_logarithms, ratio))
        freedom = max(len(self.avar) - int((theta > 0).sum()), 1)
        return float(gammaincc(freedom / 2, misfit / 2))

    def covariance_of_theta(self, theta: Floats, active: Sequence[int]) -> Floats:
        """Of unbounded estimates of the active terms, if θ is true."""
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


def relative_fit(columns: Floats, avar: Floats, errors: Floats) -> Floats:
    """Non-negative θ that follow the curve, for independent relative errors."""
    weights = 1 / (errors * avar)
    return non_negative(columns * weights[:, None], avar * weights)


def _mended(covariance: Floats) -> Floats:
    """A covariance from which a ramp was removed, which is not exact, with what it makes negative turned over.

    One direction, that of the ramp, may come out slightly negative where quantization noise leaves the others hardly any
    variance. How far it is off is how well it is known, and that is what it counts for then. Raises FloatingPointError for
    anything worse.
    """
    sd = np.sqrt(np.maximum(covariance.diagonal(), 0))
    if not sd.all():
        raise FloatingPointError("a variance is not positive")
    values, vectors = np.linalg.eigh(covariance / np.outer(sd, sd))
    if values[0] < -_MOST_MENDED * values[-1]:
        raise FloatingPointError("no covariance")
    values = np.maximum(np.abs(values), _LEAST_EIGENVALUE)
    return np.asarray((vectors * values) @ vectors.T * np.outer(sd, sd))


def non_negative(columns: Floats, target: Floats) -> Floats:
    """Non-negative least squares, the columns brought to one length."""
    from scipy.linalg import lapack

    if columns.shape[1] == 0:
        return np.empty(0)
    scale = np.sqrt(np.einsum("ij,ij->j", columns, columns))
    scaled = columns / scale
    # Unbounded first: most fits need no bound.
    _, free, failed = lapack.dgels(scaled, target)
    if not failed and free[: len(scale)].min() > 0:
        return np.asarray(free[: len(scale)] / scale)
    from scipy.optimize import nnls

    return np.asarray(nnls(scaled, target)[0] / scale)
