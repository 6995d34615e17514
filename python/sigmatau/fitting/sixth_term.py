"""A sixth term if the five do not fit: a Gauss-Markov process or a sinusoid.

The correlation time or frequency is found by a search on a logarithmic grid with an approximate covariance, and then refined
with the exact covariance. Each point of the grid is a linear fit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import kernels
from sigmatau._native.kernels import Factor
from sigmatau.estimators.gaps import Gaps
from sigmatau.fitting.gls import Gls, non_negative, relative_fit
from sigmatau.fitting.masked_components import components_with_gaps

Floats = NDArray[np.float64]

GAIN_IN_REACH = 8.0  # A sixth term is used if the fit with it begins at an averaging time shorter by this factor
_TIMES_PER_DECADE = 8
_FREQUENCIES_PER_DECADE = 60
_MAX_MISFIT = 30.0  # χ² for each averaging time with the approximate covariance; a larger one is not refined
_LEAST_GAIN = 20.0  # in χ²: the best of hundreds of frequencies improves a good fit by 10 to 15


@dataclass(frozen=True, slots=True)
class Extension:
    """A sixth term with the parameter of its shape."""

    kind: Literal["gauss_markov", "sinusoid"]
    shape: float  # Correlation time in samples, or frequency in cycles per sample

    def arguments(self) -> dict[str, float]:
        """Keyword arguments of `sigmatau.fitting.masked_components.components_with_gaps`."""
        return {"correlation_time" if self.kind == "gauss_markov" else "frequency": self.shape}

    def column(self, m: NDArray[np.int64], gaps: Gaps | None = None) -> Floats:
        """Expected Allan variance for a variance, or a squared amplitude, of 1; that of a sinusoid ignores gaps."""
        if self.kind == "gauss_markov":
            ratio = 1.0 if gaps is None else gaps.gauss_markov_ratio(self.shape, m)
            return np.asarray(ratio * kernels.gauss_markov_avar(1.0, self.shape, m, 1.0))
        return kernels.sinusoid_avar(1.0, self.shape, m, 1.0)

    def tangent(self, m: NDArray[np.int64], gaps: Gaps | None = None) -> Floats:
        """Derivative of `column` by the logarithm of the shape."""
        step = 1e-4
        up, down = (Extension(self.kind, self.shape * math.exp(s)).column(m, gaps) for s in (step, -step))
        return np.asarray((up - down) / (2 * step))


def candidates(five: Gls) -> Iterator[Extension]:
    """The best Gauss-Markov process and the best sinusoid beside the five terms, if they improve the fit enough."""
    m = five.parts.m
    terms = list(five.candidates)
    theta = np.zeros(len(five.parts.names))
    theta[terms] = relative_fit(five.parts.design[:, terms], five.avar, np.full(len(m), 0.1))
    # The five terms do not fit the curve: their correlations and relative errors are used nevertheless.
    ratio = five.avar / (five.parts.design @ theta)
    weights = Factor(five.covariance(theta) * np.outer(ratio, ratio))
    shortest, longest = float(m[0]), five.parts.n
    times = _log_grid(2 * shortest, longest / 10, _TIMES_PER_DECADE)
    frequencies = _log_grid(2 / longest * 5, 0.5 / shortest if shortest > 1 else 0.499, _FREQUENCIES_PER_DECADE)
    kinds: tuple[tuple[Literal["gauss_markov", "sinusoid"], Floats], ...] = (
        ("gauss_markov", times),
        ("sinusoid", frequencies),
    )
    for kind, grid in kinds:
        if len(grid) < 3:
            continue
        fixed = _misfit(five, weights, None)
        misfits = _misfits(five, weights, [Extension(kind, float(shape)) for shape in grid])
        k = int(np.argmin(misfits))
        if fixed - misfits[k] < _LEAST_GAIN or misfits[k] > _MAX_MISFIT * len(m):
            continue
        shape = float(grid[k])
        step = math.log(grid[1] / grid[0])
        # Twice, because the covariance depends on the shape.
        for _ in range(2):
            problem = _problem(five, Extension(kind, shape))
            try:
                exact = problem.weights(problem.fit())
            except (FloatingPointError, np.linalg.LinAlgError):
                break
            low, high = math.log(shape) - step, math.log(shape) + step
            if kind == "sinusoid":
                high = min(high, math.log(0.4999))
            shape = math.exp(_minimum(lambda x: _misfit(five, exact, Extension(kind, math.exp(x))), low, high))  # noqa: B023
        yield Extension(kind, shape)


def intervals(
    gls: Gls, theta: Floats, extension: Extension, *, level: float
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Value, low and high of the size (standard deviation or amplitude) and of the shape, symmetric in the logarithm.
    The covariance has the shape as a free parameter: its column is the derivative of the variances by the logarithm of
    the shape.
    """
    from scipy.special import ndtri

    size = float(theta[-1])
    columns = [gls.parts.design[:, list(gls.candidates)], size * extension.tangent(gls.parts.m, gls.parts.gaps)]
    whitened = gls.weights(theta).whiten(np.column_stack(columns))
    scale = np.linalg.norm(whitened, axis=0)
    inverse = np.linalg.pinv(whitened / scale)
    sd = np.sqrt(np.sum(inverse**2, axis=1)) / scale
    k = float(ndtri(0.5 + level / 2))
    of_size = k * sd[-2] / (2 * size) if size > 0 else math.inf
    of_shape = k * sd[-1]
    root = math.sqrt(size)
    return (
        (root, root * math.exp(-min(of_size, 50)), root * math.exp(min(of_size, 50))),
        (
            extension.shape,
            extension.shape * math.exp(-min(of_shape, 50)),
            extension.shape * math.exp(min(of_shape, 50)),
        ),
    )


def _problem(five: Gls, extension: Extension) -> Gls:
    sizes = tuple(int(m) for m in five.parts.m)
    parts = components_with_gaps(five.parts.n, sizes, five.parts.gaps, **extension.arguments())
    return Gls(parts, five.avar, (*five.candidates, len(parts.names) - 1))


def _misfit(five: Gls, weights: Factor, extension: Extension | None) -> float:
    """χ² of the best non-negative combination for a given covariance."""
    columns = [five.avar[:, None], five.parts.design[:, list(five.candidates)]]
    if extension is not None:
        columns.append(extension.column(five.parts.m, five.parts.gaps)[:, None])
    whitened = weights.whiten(np.hstack(columns))
    left = whitened[:, 0] - whitened[:, 1:] @ non_negative(whitened[:, 1:], whitened[:, 0])
    return float(left @ left)


def _misfits(five: Gls, weights: Factor, extensions: Sequence[Extension]) -> list[float]:
    """`_misfit` of each of several extensions, whitened together."""
    shapes = [extension.column(five.parts.m, five.parts.gaps) for extension in extensions]
    fixed = 1 + len(five.candidates)
    whitened = weights.whiten(np.column_stack([five.avar, five.parts.design[:, list(five.candidates)], *shapes]))
    target, misfits = whitened[:, 0], []
    columns = np.empty((len(target), fixed))
    columns[:, :-1] = whitened[:, 1:fixed]
    for k in range(len(extensions)):
        columns[:, -1] = whitened[:, fixed + k]
        left = target - columns @ non_negative(columns, target)
        misfits.append(float(left @ left))
    return misfits


def _minimum(f: Callable[[float], float], low: float, high: float) -> float:
    from scipy.optimize import minimize_scalar

    return float(minimize_scalar(f, bounds=(low, high), method="bounded", options={"xatol": 1e-6}).x)


def _log_grid(low: float, high: float, per_decade: int) -> Floats:
    if high <= low:
        return np.empty(0)
    return np.geomspace(low, high, max(int(math.log10(high / low) * per_decade), 3))
