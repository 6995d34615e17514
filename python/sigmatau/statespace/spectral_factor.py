"""Spectral factor of a sum of sampled processes, in decimal arithmetic of sufficient precision.

With w = 2 − z − 1/z = 4·sin²(πf·dt) the spectrum is c + q·w + k/w + Σ aⱼ(w)/dⱼ(w), real polynomials of degree 2 at most.
With a sharp filter whose corner is far below the rate, the terms cancel to 1e-30 of their size, which double precision
cannot represent. Sum, roots and innovation variance are therefore computed in decimal numbers, and rounded once at the
end. A root w of the numerator gives the ϑ inside the unit circle with (1 − ϑ)²/ϑ = −w.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from typing import Self

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.model.processes import LowPass, Resonance

Floats = NDArray[np.float64]
Exact = NDArray[np.object_]

_DIGITS = 60  # Digits left after the expected cancellation
_LEAST_DIGITS = 25  # Correct digits that a spectrum must have; otherwise `DataError`
_NEGLIGIBLE = Decimal("1e-14")  # Correlation of neighbouring samples below which a process counts as white
_ITERATIONS = 300
# Relative step at which the iteration of a root ends; its square root bounds the imaginary part of a real root
_ROOT_TOLERANCE = Decimal("1e-20")
_ZERO, _ONE, _TWO = Decimal(0), Decimal(1), Decimal(2)


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

    above: tuple[Decimal, ...]
    below: tuple[Decimal, ...]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Spectrum:
    """The spectrum white + quantization·w + walk/w + the parts."""

    white: Decimal
    quantization: Decimal
    walk: Decimal
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
        with localcontext() as context:
            context.prec = digits
            step = Decimal(dt)
            spread = Decimal(white) ** 2 / step
            parts: list[_Part] = []
            real: list[float] = []
            by_time: dict[float, Decimal] = {}
            for sigma, time in processes:
                by_time[time] = by_time.get(time, _ZERO) + Decimal(sigma) ** 2
            for time, power in by_time.items():
                phi = (-step / Decimal(time)).exp()
                if phi < _NEGLIGIBLE:
                    spread += power
                else:
                    parts.append(_Part((power * (1 - phi * phi),), ((1 - phi) ** 2, phi)))
                    real.append(float(phi))
            pairs: list[complex] = []
            if filtered:
                more, left, single, double = _filter(*filtered, step)
                parts += more
                spread += left
                real += single
                pairs += double
            for one in resonances:
                more, left, double = _resonance(one, step)
                parts += more
                spread += left
                pairs += double
            return cls(
                white=spread,
                quantization=(Decimal(quantization) / step) ** 2,
                walk=Decimal(walk) ** 2 * step,
                parts=tuple(parts),
                poles=Roots(tuple(real), tuple(pairs)),
                digits=digits,
            )

    def at(self, w: Floats) -> Floats:
        """The spectrum at w from 0 to 4; w = 0 is excluded with a walk."""
        result = []
        with localcontext() as context:
            context.prec = self.digits
            for x in map(Decimal, w.tolist()):
                terms = [self.white, self.quantization * x, self.walk / x if self.walk else _ZERO]
                terms += [_value(part.above, x) / _value(part.below, x) for part in self.parts]
                total = sum(terms, _ZERO)
                if total <= max(map(abs, terms)).scaleb(_LEAST_DIGITS - self.digits):
                    raise DataError("the spectrum of this model falls too far below its peak to have a moving average")
                result.append(float(total))
        return np.array(result)

    def factor(self) -> tuple[Roots, float]:
        """Roots of the moving average, and the variance of its innovations; a walk is one difference."""
        with localcontext() as context:
            context.prec = self.digits
            above: list[Decimal] = [self.white, self.quantization]
            below = [_ONE]
            if self.walk:
                above, below = [self.walk, *above], [_ZERO, _ONE]
            for part in self.parts:
                above = _sum(_product(above, part.below), _product(part.above, below))
                below = _product(below, part.below)
            while len(above) > 1 and above[-1] == 0:
                above.pop()
            real, pairs = _roots(above)
            ma = Roots(tuple(_inside(x, _ZERO)[0] for x in real), tuple(complex(*_inside(*pair)) for pair in pairs))
            return ma, self._variance(ma)

    def _variance(self, ma: Roots) -> float:
        """Variance of the innovations, from w = 2: there the gain |1 + ϑ²| of a rounded root is accurate to rounding."""
        top = float(self.at(np.array([2.0]))[0]) * (2.0 if self.walk else 1.0)
        gains = [float(np.prod(1 + roots.array() ** 2).real) for roots in (self.poles, ma)]
        return top * gains[0] / gains[1]


def _value(coefficients: Sequence[Decimal], x: Decimal) -> Decimal:
    total = _ZERO
    for c in reversed(coefficients):
        total = total * x + c
    return total


def _product(a: Sequence[Decimal], b: Sequence[Decimal]) -> list[Decimal]:
    result = [_ZERO] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            result[i + j] += x * y
    return result


def _sum(a: Sequence[Decimal], b: Sequence[Decimal]) -> list[Decimal]:
    size = max(len(a), len(b))
    return [(a[k] if k < len(a) else _ZERO) + (b[k] if k < len(b) else _ZERO) for k in range(size)]


def _filter(n: float, bandwidth: LowPass, step: Decimal) -> tuple[list[_Part], Decimal, list[float], list[complex]]:
    """Sampled Butterworth noise: its parts, its white share, and its poles: real ones, and one of each complex pair.
    r(t) = −N²ω/(2n)·Σ p·exp(p·ω·t), the poles p on the unit circle's left half.
    """
    order = bandwidth.order
    pi = _pi()
    omega = _TWO * pi * Decimal(bandwidth.corner)
    size = Decimal(n) ** 2 * omega / (2 * order)
    parts: list[_Part] = []
    white = _ZERO
    real: list[float] = []
    pairs: list[complex] = []
    for k in range((order + 1) // 2):
        turn = pi * (2 * k + order + 1) / (2 * order)
        single = 2 * k + 1 == order  # the pole −1
        p = (-_ONE, _ZERO) if single else _turned(turn)
        kept = (p[0] * omega * step).exp()
        rho = (-p[0] * size, -p[1] * size)
        if kept < _NEGLIGIBLE:
            white += rho[0] if single else 2 * rho[0]
            continue
        if single:
            parts.append(_Part((rho[0] * (1 - kept * kept),), ((1 - kept) ** 2, kept)))
            real.append(float(kept))
            continue
        part, root = _pair(rho, kept, p[1] * omega * step)
        parts.append(part)
        if root.imag:
            pairs.append(root)
        else:
            real += [root.real, root.real]
    return parts, white, real, pairs


def _resonance(one: Resonance, step: Decimal) -> tuple[list[_Part], Decimal, list[complex]]:
    """A sampled resonance: its part, its white share, and its pole. r(t) = σ²·Re[(1 + iγ/ω)·exp((iω − γ)t)]."""
    turn = _TWO * _pi() * step
    loss = turn * Decimal(one.width)
    swing = ((turn * Decimal(one.frequency)) ** 2 - loss**2).sqrt()
    kept = (-loss).exp()
    half = Decimal(one.sigma) ** 2 / 2
    if kept < _NEGLIGIBLE:
        return [], 2 * half, []
    part, root = _pair((half, half * loss / swing), kept, swing)
    return [part], _ZERO, [root]


def _pair(rho: tuple[Decimal, Decimal], kept: Decimal, angle: Decimal) -> tuple[_Part, complex]:
    """The part with the autocovariance ρ·φˡ and its conjugate, φ = kept·exp(i·angle); and φ, above the real line."""
    c, s = _turned(angle)
    phi = (kept * c, kept * s)
    beside = _times((1 - phi[0], -phi[1]), (1 - phi[0], -phi[1]))
    squared = _times(phi, phi)
    height = _times(rho, (1 - squared[0], -squared[1]))
    # ρ(1 − φ²)/((1 − φ)² + φ·w) and its conjugate over one denominator.
    mixed = _times(beside, (phi[0], -phi[1]))[0]
    above = (2 * (height[0] * beside[0] + height[1] * beside[1]), 2 * (height[0] * phi[0] + height[1] * phi[1]))
    part = _Part(above, (beside[0] ** 2 + beside[1] ** 2, 2 * mixed, phi[0] ** 2 + phi[1] ** 2))
    return part, complex(float(phi[0]), abs(float(phi[1])))


def _times(a: tuple[Decimal, Decimal], b: tuple[Decimal, Decimal]) -> tuple[Decimal, Decimal]:
    return a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]


def _pi() -> Decimal:
    """Machin's formula, π/4 = 4·atan(1/5) − atan(1/239)."""

    def atan(n: int) -> Decimal:
        power = total = _ONE / n
        k = 1
        while abs(power) > abs(total) * _least():
            power /= -n * n
            k += 2
            total += power / k
        return total

    return 16 * atan(5) - 4 * atan(239)


def _least() -> Decimal:
    """A number below the last digit of 1."""
    return (_ONE.next_plus() - 1) / 10


def _turned(angle: Decimal) -> tuple[Decimal, Decimal]:
    """Cosine and sine: by the power series of a small part of the angle, squared repeatedly."""
    halvings = max(angle.adjusted() + 4, 4) * 4
    x = angle / 2**halvings
    re, im, term = _ONE, _ZERO, _ONE
    k = 0
    while abs(term) > _least() * abs(x) and term:
        k += 1
        term = term * x / k
        sign = -1 if k % 4 >= 2 else 1
        if k % 2:
            im += sign * term
        else:
            re += sign * term
    for _ in range(halvings):
        re, im = re * re - im * im, 2 * re * im
    return re, im


def _roots(coefficients: list[Decimal]) -> tuple[list[Decimal], list[tuple[Decimal, Decimal]]]:
    """Roots of a real polynomial, real ones and one of each pair, by Aberth's method from the Newton polygon's radii."""
    zeros = 0
    while len(coefficients) > 1 and coefficients[0] == 0:  # a root at 0 is one, to the last digit
        coefficients, zeros = coefficients[1:], zeros + 1
    degree = len(coefficients) - 1
    if degree == 0:
        return [_ZERO] * zeros, []
    re, im = _starts(coefficients)
    for _ in range(_ITERATIONS):
        value, slope = _horner(coefficients, re, im)
        # 1/(N′/N − Σ 1/(x − xⱼ)), written without a division by N, which may be 0.
        apart = re[:, None] - re, im[:, None] - im
        size = apart[0] ** 2 + apart[1] ** 2
        size[np.arange(degree), np.arange(degree)] = _ONE
        others = (apart[0] / size).sum(axis=1), (-apart[1] / size).sum(axis=1)
        below = (
            slope[0] - (value[0] * others[0] - value[1] * others[1]),
            slope[1] - (value[0] * others[1] + value[1] * others[0]),
        )
        size = below[0] ** 2 + below[1] ** 2
        size[size == 0] = _ONE
        step = (value[0] * below[0] + value[1] * below[1]) / size, (value[1] * below[0] - value[0] * below[1]) / size
        re, im = re - step[0], im - step[1]
        if (step[0] ** 2 + step[1] ** 2 <= _ROOT_TOLERANCE**2 * (re**2 + im**2)).all():
            break
    else:
        raise DataError("the moving average of this model was not found: two of its roots are too close to each other")
    real = np.array([abs(y) <= _ROOT_TOLERANCE.sqrt() * abs(x) for x, y in zip(re, im, strict=True)])
    pairs = [(x, y) for x, y in zip(re[~real], im[~real], strict=True) if y > 0]
    if 2 * len(pairs) != degree - int(real.sum()):
        raise DataError("the moving average of this model was not found: its complex roots are no pairs")
    return [_ZERO] * zeros + list(re[real]), pairs


def _starts(coefficients: list[Decimal]) -> tuple[Exact, Exact]:
    """Start values of the roots: on circles whose radii and numbers of roots follow from the Newton polygon."""
    logs = [float(abs(c).log10()) if c else -math.inf for c in coefficients]
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
    re: list[Decimal] = []
    im: list[Decimal] = []
    for i, j in itertools.pairwise(hull):
        radius = Decimal(10) ** Decimal((logs[i] - logs[j]) / (j - i))
        for k in range(j - i):
            # Off the real line, none the conjugate of another.
            angle = math.pi + 2 * math.pi * (k + 0.3) / (j - i) + 0.1 * len(hull) + 0.05 * i
            re.append(radius * Decimal(math.cos(angle)))
            im.append(radius * Decimal(math.sin(angle)))
    return np.array(re, dtype=object), np.array(im, dtype=object)


def _horner(coefficients: list[Decimal], re: Exact, im: Exact) -> tuple[tuple[Exact, Exact], tuple[Exact, Exact]]:
    """Polynomial and derivative at complex points."""
    zero = np.full(re.shape, _ZERO, dtype=object)
    value, slope = (zero + coefficients[-1], zero), (zero, zero)
    for c in reversed(coefficients[:-1]):
        slope = slope[0] * re - slope[1] * im + value[0], slope[0] * im + slope[1] * re + value[1]
        value = value[0] * re - value[1] * im + c, value[0] * im + value[1] * re
    return value, slope


def _inside(re: Decimal, im: Decimal) -> tuple[float, float]:
    """The ϑ inside the unit circle with (1 − ϑ)²/ϑ = −w; its imaginary part is not negative."""
    x = -re, -im
    half = _root(_times(x, (1 + x[0] / 4, x[1] / 4)))
    outside = [(1 + x[0] / 2 + sign * half[0], x[1] / 2 + sign * half[1]) for sign in (1, -1)]
    a, b = max(outside, key=lambda root: root[0] ** 2 + root[1] ** 2)
    size = a * a + b * b
    return float(a / size), abs(float(b / size))


def _root(x: tuple[Decimal, Decimal]) -> tuple[Decimal, Decimal]:
    """Square root of a complex number, without cancellation."""
    size = (x[0] ** 2 + x[1] ** 2).sqrt()
    larger = ((size + abs(x[0])) / 2).sqrt()
    if not larger:
        return _ZERO, _ZERO
    smaller = x[1] / (2 * larger)
    return (larger, smaller) if x[0] >= 0 else (abs(smaller), larger.copy_sign(x[1] or _ONE))
