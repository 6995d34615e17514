"""Compiled distributions, of numbers and arrays alike: normal, gamma (χ²) and Student's t, with relative errors below 1e-12.

Outside of its domain a function is NaN.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau import _core

_Floats = NDArray[np.float64]  # arrays of the shape of the arguments; without dimensions for numbers


def normal_below(z: ArrayLike) -> _Floats:
    """Probability that a standard normal deviate is at most `z`."""
    return _evaluated("normal_below", z)


def normal_quantile(probability: ArrayLike) -> _Floats:
    """The value that a standard normal deviate does not exceed with a probability."""
    return _evaluated("normal_quantile", probability)


def gamma_below(shape: ArrayLike, x: ArrayLike) -> _Floats:
    """Probability that a gamma variate with scale 1 is at most `x`."""
    return _evaluated_together("gamma_below", shape, x)


def gamma_above(shape: ArrayLike, x: ArrayLike) -> _Floats:
    """Probability that a gamma variate with scale 1 exceeds `x`."""
    return _evaluated_together("gamma_above", shape, x)


def gamma_quantile(shape: ArrayLike, probability: ArrayLike) -> _Floats:
    """The value that a gamma variate with scale 1 does not exceed with a probability."""
    return _evaluated_together("gamma_quantile", shape, probability)


def gamma_quantile_above(shape: ArrayLike, probability: ArrayLike) -> _Floats:
    """The value that a gamma variate with scale 1 exceeds with a probability."""
    return _evaluated_together("gamma_quantile_above", shape, probability)


def chi2_below(freedom: ArrayLike, x: ArrayLike) -> _Floats:
    """Probability that χ² is at most `x`."""
    return gamma_below(np.divide(freedom, 2), np.divide(x, 2))


def chi2_above(freedom: ArrayLike, x: ArrayLike) -> _Floats:
    """Probability that χ² exceeds `x`."""
    return gamma_above(np.divide(freedom, 2), np.divide(x, 2))


def chi2_quantile_above(freedom: ArrayLike, probability: ArrayLike) -> _Floats:
    """The value that χ² exceeds with a probability."""
    return np.multiply(2, gamma_quantile_above(np.divide(freedom, 2), probability))


def student_below(freedom: ArrayLike, t: ArrayLike) -> _Floats:
    """Probability that Student's t is at most `t`."""
    return _evaluated_together("student_below", freedom, t)


def student_quantile(freedom: ArrayLike, probability: ArrayLike) -> _Floats:
    """The value that Student's t does not exceed with a probability."""
    return _evaluated_together("student_quantile", freedom, probability)


def digamma(x: ArrayLike) -> _Floats:
    """Derivative of ln Γ at a positive `x`."""
    return _evaluated("digamma", x)


def log_gamma(x: ArrayLike) -> _Floats:
    """Logarithm of Γ at a positive `x`."""
    return _evaluated("log_gamma", x)


def _evaluated(name: str, x: ArrayLike) -> _Floats:
    array = np.asarray(x, dtype=np.float64)
    return _core.distribution(name, array.ravel()).reshape(array.shape)


def _evaluated_together(name: str, shape: ArrayLike, x: ArrayLike) -> _Floats:
    shapes, values = np.broadcast_arrays(np.asarray(shape, dtype=np.float64), np.asarray(x, dtype=np.float64))
    return _core.distribution_of_shape(name, shapes.ravel(), values.ravel()).reshape(shapes.shape)
