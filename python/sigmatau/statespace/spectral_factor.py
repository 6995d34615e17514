"""Spectral factor of a sum of sampled processes, in arithmetic of sufficient precision.

With w = 2 − z − 1/z = 4·sin²(πf·dt) the spectrum is c + q·w + k/w + Σ aⱼ(w)/dⱼ(w), real polynomials of degree 2 at most.
With a sharp filter whose corner is far below the rate, the terms cancel to 1e-30 of their size, which double precision
cannot represent. Sum, roots and innovation variance are therefore computed by mpmath, and rounded once at the end. A root w
of the numerator gives the ϑ inside the unit circle with (1 − ϑ)²/ϑ = −w.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from mpmath import mp, mpc, mpf
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.model.processes import LowPass, Resonance

Floats = NDArray[np.float64]
Number = Any  # of mpmath, which has no types

_DIGITS = 60  # Digits left after the expected cancellation
_LEAST_DIGITS = 25  # Correct digits that a spectrum must have; otherwise `DataError`
_NEGLIGIBLE = 1e-14  # Correlation of neighbouring samples below which a process counts as white
_ITERATIONS = 300
_REAL = 1e-10  # largest imaginary part of a real root, over its size


@dataclass(frozen=True, slots=True)
class Roots:
    """Roots of a real polynomial in the lag, inside the unit circle: the real ones, and one of each complex pair."""

    real: tuple[float, ...] = ()
    pairs: tuple[complex, ...] = ()

    def array(self) -> NDArray[np.complex128]:
        """All roots, real ones first in descending order; pairs are conjugates to the bit."""
        real = sorted(self.real, reverse=True)
        return np.array([*real, *(root for pair in self.pairs for root in (pair, pair.conjugate()))], dtype=complex)


@dataclass(frozen=True, slots=True)
class _Part:
    """The ratio above/below of two polynomials in w, coefficients from the constant on."""

    above: list[Number]
    below: list[Number]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Spectrum:
    """The spectrum white + quantization·w + walk/w + the parts."""

    white: Number
    quantization: Number
    walk: Number
    parts: tuple[_Part, ...]
    poles: Roots  # Of the parts
    digits: int  # Of the arithmetic

    @classmethod
    def of(
        cls,
        *,
        dt: float,
        white: float,
        quantization: float,
        walk: float,
        processes: Sequence[tuple[float, float]],
        filtered: tuple[float, LowPass] | None = None,
        resonances: Sequence[Resonance] = (),
    ) -> Self:
        """The spectrum, over dt, of samples. `dt`: [s]; `white, quantization, walk`: N [unit·√s], Q [unit·s] and K
        [unit/√s]; `processes`: standard deviation and correlation time [s] of each Gauss-Markov process; `filtered`: N
        of white noise behind a filter.
        """
        digits = _DIGITS + max([math.ceil(abs(math.log10(t) - math.log10(dt))) for _, t in processes], default=0)
        if filtered:
            pace = math.log10(2 * math.pi * filtered[1].corner) + math.log10(dt)
            # The spectrum of order n falls by the power 2n between the corner and half the rate.
            digits += 2 * filtered[1].order * math.ceil(max(1.0, -pace))
        for one in resonances:  # between the least of its damping and half the rate, as a filter of second order
            digits += 4 * math.ceil(max(1.0, -math.log10(one.damping) - math.log10(dt)))
        with mp.workdps(digits):
            step = mpf(dt)
            spread = mpf(white) ** 2 / step
            parts: list[_Part] = []
            real: list[float] = []
            by_time: dict[float, Number] = {}
            for sigma, time in processes:
                by_time[time] = by_time.get(time, mpf(0)) + mpf(sigma) ** 2
            for time, power in by_time.items():
                phi = mp.exp(-step / mpf(time))
                if phi < _NEGLIGIBLE:
                    spread += power
                else:
                    parts.append(_single(power, phi))
                    real.append(float(phi))
            pairs: list[complex] = []
            for rho, phi in [
                *(_filter(*filtered, step) if filtered else ()),
                *(_resonance(r, step) for r in resonances),
            ]:
                twice = 1 if isinstance(phi, mpf) else 2
                if abs(phi) < _NEGLIGIBLE:
                    spread += twice * rho.real
                elif twice == 1:
                    parts.append(_single(rho, phi))
                    real.append(float(phi))
                else:
                    parts.append(_pair(rho, phi))
                    root = complex(float(phi.real), abs(float(phi.imag)))
                    if root.imag:
                        pairs.append(root)
                    else:
                        real += [root.real, root.real]
            return cls(
                white=spread,
                quantization=(mpf(quantization) / step) ** 2,
                walk=mpf(walk) ** 2 * step,
                parts=tuple(parts),
                poles=Roots(tuple(real), tuple(pairs)),
                digits=digits,
            )

    def at(self, w: Floats) -> Floats:
        """The spectrum at w from 0 to 4; w = 0 is excluded with a walk."""
        result = []
        with mp.workdps(self.digits):
            for x in map(mpf, w.tolist()):
                terms = [self.white, self.quantization * x, self.walk / x if self.walk else mpf(0)]
                terms += [
                    mp.polyval(part.above, x, asc=True) / mp.polyval(part.below, x, asc=True) for part in self.parts
                ]
                total = mp.fsum(terms)
                if total <= max(map(abs, terms)) * mpf(10) ** (_LEAST_DIGITS - self.digits):
                    raise DataError("the spectrum of this model falls too far below its peak to have a moving average")
                result.append(float(total))
        return np.array(result)

    def factor(self) -> tuple[Roots, float]:
        """Roots of the moving average, and the variance of its innovations; a walk is one difference."""
        with mp.workdps(self.digits):
            above, below = [self.white, self.quantization], [mpf(1)]
            if self.walk:
                above, below = [self.walk, *above], [mpf(0), mpf(1)]
            for part in self.parts:
                above = _sum(_product(above, part.below), _product(part.above, below))
                below = _product(below, part.below)
            while len(above) > 1 and above[-1] == 0:
                above.pop()
            real, pairs = _roots(above)
            ma = Roots(tuple(_inside(x).real for x in real), tuple(map(_inside, pairs)))
            return ma, self._variance(ma)

    def _variance(self, ma: Roots) -> float:
        """Variance of the innovations, from w = 2: there the gain |1 + ϑ²| of a rounded root is accurate to rounding."""
        top = float(self.at(np.array([2.0]))[0]) * (2.0 if self.walk else 1.0)
        gains = [float(np.prod(1 + roots.array() ** 2).real) for roots in (self.poles, ma)]
        return top * gains[0] / gains[1]


def _product(a: Sequence[Number], b: Sequence[Number]) -> list[Number]:
    result = [mpf(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            result[i + j] += x * y
    return result


def _sum(a: Sequence[Number], b: Sequence[Number]) -> list[Number]:
    return [x + y for x, y in itertools.zip_longest(a, b, fillvalue=mpf(0))]


def _filter(n: float, bandwidth: LowPass, step: Number) -> list[tuple[Number, Number]]:
    """Sampled Butterworth noise: variance and decay of each part; of a complex pair, those of one.

    r(t) = −N²ω/(2n)·Σ p·exp(p·ω·t), the poles p on the unit circle's left half.
    """
    order = bandwidth.order
    omega = 2 * mp.pi * mpf(bandwidth.corner)
    size = mpf(n) ** 2 * omega / (2 * order)
    poles = [mp.expjpi(mpf(2 * k + order + 1) / (2 * order)) for k in range(order // 2)]
    poles += [mpf(-1)] if order % 2 else []
    return [(-p * size, mp.exp(p * omega * step)) for p in poles]


def _resonance(one: Resonance, step: Number) -> tuple[Number, Number]:
    """A sampled resonance: variance and decay of one of its pair. r(t) = σ²·Re[(1 + iγ/ω)·exp((iω − γ)t)]."""
    turn = 2 * mp.pi * step
    loss = turn * mpf(one.width)
    swing = mp.sqrt((turn * mpf(one.frequency)) ** 2 - loss**2)
    half = mpf(one.sigma) ** 2 / 2
    return mpc(half, half * loss / swing), mp.exp(mpc(-loss, swing))


def _single(rho: Number, phi: Number) -> _Part:
    """The part with the autocovariance ρ·φˡ."""
    return _Part([rho * (1 - phi * phi)], [(1 - phi) ** 2, phi])


def _pair(rho: Number, phi: Number) -> _Part:
    """The same and its conjugate over one denominator: ρ(1 − φ²)/((1 − φ)² + φ·w)."""
    beside, height = (1 - phi) ** 2, rho * (1 - phi**2)

    def product(a: Number, b: Number) -> Number:
        return 2 * (a * b.conjugate()).real

    below = [product(beside, beside) / 2, product(beside, phi), product(phi, phi) / 2]
    return _Part([product(height, beside), product(height, phi)], below)


def _roots(coefficients: list[Number]) -> tuple[list[Number], list[Number]]:
    """Roots of a real polynomial, real ones and one of each pair, from the Newton polygon's radii."""
    zeros = 0
    while len(coefficients) > 1 and coefficients[0] == 0:  # a root at 0 is one, to the last digit
        coefficients, zeros = coefficients[1:], zeros + 1
    degree = len(coefficients) - 1
    if degree == 0:
        return [mpf(0)] * zeros, []
    options = {"maxsteps": _ITERATIONS, "cleanup": False, "extraprec": 2 * mp.prec, "roots_init": _starts(coefficients)}
    try:
        found = mp.polyroots(coefficients, asc=True, **options)
    except mp.NoConvergence:
        raise DataError(
            "the moving average of this model was not found: two of its roots are too close to each other"
        ) from None
    real = [x.real for x in found if abs(x.imag) <= _REAL * abs(x)]
    pairs = [x for x in found if x.imag > _REAL * abs(x)]
    if 2 * len(pairs) != degree - len(real):
        raise DataError("the moving average of this model was not found: its complex roots are no pairs")
    return [mpf(0)] * zeros + real, pairs


def _starts(coefficients: list[Number]) -> list[Number]:
    """Start values of the roots: on circles whose radii and numbers of roots follow from the Newton polygon."""
    logs = [float(mp.log10(abs(c))) if c else -math.inf for c in coefficients]
    hull: list[int] = []
    for k, height in enumerate(logs):
        if height == -math.inf:
            continue
        while len(hull) >= 2:
            i, j = hull[-2:]
            if (logs[j] - logs[i]) * (k - i) > (height - logs[i]) * (j - i):
                break
            hull.pop()
        hull.append(k)
    starts = []
    for i, j in itertools.pairwise(hull):
        radius = mpf(10) ** mpf((logs[i] - logs[j]) / (j - i))
        # Off the real line, none the conjugate of another.
        angles = (math.pi + 2 * math.pi * (k + 0.3) / (j - i) + 0.1 * len(hull) + 0.05 * i for k in range(j - i))
        starts += [radius * mp.expj(angle) for angle in angles]
    return starts


def _inside(w: Number) -> complex:
    """The ϑ inside the unit circle with (1 − ϑ)²/ϑ = −w; its imaginary part is not negative."""
    half = mp.sqrt(mpc(-w) * (1 - w / 4))
    outside = max((1 - w / 2 + half, 1 - w / 2 - half), key=abs)
    found = 1 / outside
    return complex(float(found.real), abs(float(found.imag)))
