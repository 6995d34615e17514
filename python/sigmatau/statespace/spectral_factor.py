"""Spectral factor of a sum of sampled processes: the moving average with the same spectrum.

With w = 2 − z − 1/z = 4·sin²(πf·dt) the spectrum over dt is constant + slope·w + Σ weight/(w − pole), one pole for each
autocovariance ρ·φˡ: pole −(1 − φ)²/φ, weight ρ·(1 − φ²)/φ. Its zeros in w are the eigenvalues of a matrix, refined by
Aberth's iteration; each zero gives the ϑ inside the unit circle with (1 − ϑ)²/ϑ = −w. All is computed in double
precision. Where the terms of the spectrum cancel, as after a sharp filter whose corner is far below the rate, the
factor is refused.

References
----------
O. Aberth, "Iteration methods for finding all zeros of a polynomial simultaneously," Math. Comp. 27 (1973),
:doi:`10.1090/S0025-5718-1973-0329236-7`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import Floats
from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.model.processes import LowPass, Resonance

Complexes = NDArray[np.complex128]

_NEGLIGIBLE = 1e-14  # correlation of neighbouring samples below which a process counts as white [1]
_STEPS = 60  # largest number of steps of Aberth's iteration, where each step doubles the digits
_CONVERGED = 1e-15  # relative change of a zero at which the iteration ends [1]
_REAL = 1e-6  # largest imaginary part of a real root, over its size [1]
_MIN_SHARE = 1e-9
"""Smallest ratio of the sum of a spectrum's terms to the largest term; below it, rounding exceeds 1e-7 of the sum."""


@frozen(eq=False)
class RationalSpectrum:
    """The spectrum of samples, over their interval: constant + slope·w + Σ weights/(w − poles).

    Attributes
    ----------
    constant, slope : float
        White noise, and quantization noise over w. [unit²]
    poles, weights : ndarray of complex, shape (n_poles,)
        Poles and weights of partial fractions in w; a random walk has the pole 0.
    roots : ndarray of complex, shape (n_roots,)
        φ of the autocovariances ρ·φˡ, without the walk: real ones first in descending order, then exactly conjugate
        pairs.
    """

    constant: float
    slope: float
    poles: Complexes
    weights: Complexes
    roots: Complexes

    @classmethod
    def from_noise(
        cls,
        *,
        dt: float,
        white: float,
        quantization: float,
        walk: float,
        processes: Sequence[tuple[float, float]],
        filtered: tuple[float, LowPass] | None = None,
        resonances: Sequence[Resonance] = (),
    ) -> RationalSpectrum:
        """The spectrum of terms and processes. `dt` is in s; `white`, `quantization` and `walk` are N [unit·√s], Q
        [unit·s] and K [unit/√s]; `processes` are the standard deviation and correlation time [s] of each Gauss-Markov
        process; `filtered` has N of white noise and its filter.
        """
        by_time: dict[float, float] = {}
        for sigma, time in processes:
            by_time[time] = by_time.get(time, 0.0) + sigma**2
        # Variance and logarithm of φ of each autocovariance; a complex pair is represented by one of the two.
        parts = [(complex(variance), complex(-dt / time)) for time, variance in by_time.items()]
        parts += [*(_filter_parts(*filtered, dt) if filtered else ()), *(_resonance_part(r, dt) for r in resonances)]
        constant, roots = white**2 / dt, list[complex]()
        poles: list[complex] = [0j] if walk else []
        weights: list[complex] = [complex(walk**2 * dt)] if walk else []
        for variance, exponent in parts:
            root = complex(np.exp(exponent))
            twins = 2 if exponent.imag else 1
            if abs(root) < _NEGLIGIBLE:
                constant += twins * variance.real
                continue
            lost = -complex(np.expm1(exponent))
            pole, weight = -(lost**2) / root, variance * -complex(np.expm1(2 * exponent)) / root
            for values, value in ((poles, pole), (weights, weight), (roots, root)):
                values += [value, value.conjugate()][:twins]
        return cls(
            constant=constant,
            slope=(quantization / dt) ** 2,
            poles=np.array(poles, dtype=complex),
            weights=np.array(weights, dtype=complex),
            roots=_ordered(np.array(roots, dtype=complex)),
        )

    def density(self, w: Floats) -> Floats:
        """The spectrum at w from 0 to 4, w = 0 excluded with a walk; `DataError` where its terms cancel."""
        terms = np.column_stack(
            [np.full(w.shape, self.constant), self.slope * w, (self.weights / (w[:, None] - self.poles)).real]
        )
        total = terms.sum(axis=1)
        if (total <= _MIN_SHARE * np.abs(terms).max(axis=1)).any():
            raise DataError(
                "the spectrum of this model falls too far below its peak for a moving average in double precision; take its"
                " state space, or a longer sample interval"
            )
        return np.asarray(total)

    def zeros(self) -> Complexes:
        """The zeros in w, shape (n_zeros,)."""
        constant, poles, weights = self.constant, self.poles, self.weights
        if not (constant or self.slope):
            # Multiplied by w − pole: the spectrum then lacks that pole and has a constant.
            first = int(np.argmax(np.abs(poles)))
            constant, rest = float(weights.sum().real), np.arange(len(poles)) != first
            weights, poles = weights[rest] * (poles[rest] - poles[first]), poles[rest]
        if self.slope:
            matrix = np.diag(np.append(poles, -constant / self.slope))
            matrix[:-1, -1], matrix[-1, :-1] = 1.0, -weights / self.slope
        else:
            matrix = np.diag(poles) - weights / constant
        if not matrix.size:
            return poles[:0]
        first_guess = np.linalg.eigvals(matrix).astype(np.complex128)
        return _refined(first_guess, constant, self.slope, poles, weights)

    def factor(self) -> tuple[Complexes, float]:
        """Roots ϑ of the moving average, and the variance of its innovations; a walk adds one difference."""
        w = self.zeros()
        half = np.sqrt(-w * (1 - w / 4))
        outside = np.where(np.abs(1 - w / 2 + half) >= np.abs(1 - w / 2 - half), 1 - w / 2 + half, 1 - w / 2 - half)
        roots = _ordered(np.asarray(1 / outside, dtype=complex))
        # At w = 2 the gain |1 + ϑ²| of a rounded root is accurate to rounding.
        walk = 2.0 if (self.poles == 0).any() else 1.0
        gains = [float(np.prod(1 + each**2).real) for each in (self.roots, roots)]
        return roots, float(self.density(np.array([2.0]))[0]) * walk * gains[0] / gains[1]


def _refined(zeros: Complexes, constant: float, slope: float, poles: Complexes, weights: Complexes) -> Complexes:
    """Zeros of constant + slope·w + Σ weights/(w − poles) by Aberth's iteration from approximate zeros."""
    z = np.asarray(zeros, dtype=complex)
    diagonal = np.eye(len(z), dtype=bool)
    with np.errstate(divide="ignore", invalid="ignore"):
        for _ in range(_STEPS):
            inverse = 1 / (z[:, None] - poles)
            value = constant + slope * z + inverse @ weights
            change = slope - inverse**2 @ weights
            # The logarithmic derivative of the numerator, minus the contribution of the other zeros.
            rise = change / value + inverse.sum(axis=1) - np.where(diagonal, 0, 1 / (z[:, None] - z)).sum(axis=1)
            step = np.where(np.isfinite(1 / rise), 1 / rise, 0.0)
            z = z - step
            if (np.abs(step) <= _CONVERGED * np.abs(z)).all():
                break
    return z


def _ordered(roots: Complexes) -> Complexes:
    """Real roots in descending order, then pairs whose second is the conjugate of the first."""
    is_real = np.abs(roots.imag) <= _REAL * np.abs(roots)
    real, upper = np.sort(roots[is_real].real)[::-1], roots[~is_real & (roots.imag > 0)]
    if len(real) + 2 * len(upper) != len(roots):
        raise DataError("the moving average of this model cannot be computed in double precision; take its state space")
    return np.concatenate([real, np.column_stack([upper, upper.conj()]).ravel()])


def _filter_parts(n: float, bandwidth: LowPass, dt: float) -> list[tuple[complex, complex]]:
    """Sampled Butterworth noise: variance and logarithm of φ of each part; a complex pair is represented by one of the
    two.

    r(t) = −N²ω/(2n)·Σ p·exp(p·ω·t), where the poles p are on the left half of the unit circle.
    """
    order, omega = bandwidth.order, 2 * math.pi * bandwidth.corner
    angles = [math.pi * (2 * k + order + 1) / (2 * order) for k in range(order // 2)]
    poles = [complex(math.cos(angle), math.sin(angle)) for angle in angles] + [complex(-1.0)] * (order % 2)
    return [(-p * n**2 * omega / (2 * order), p * omega * dt) for p in poles]


def _resonance_part(resonance: Resonance, dt: float) -> tuple[complex, complex]:
    """A sampled resonance: variance and logarithm of φ of one of its two poles. r(t) = σ²·Re[(1 + iγ/ω)·exp((iω −
    γ)t)].
    """
    loss = 2 * math.pi * dt * resonance.width
    swing = math.sqrt((2 * math.pi * dt * resonance.frequency) ** 2 - loss**2)
    half = resonance.sigma**2 / 2
    return complex(half, half * loss / swing), complex(-loss, swing)
