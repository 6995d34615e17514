"""Noise models as ARIMA processes: the difference equation with the same spectrum.

With w = 2 − z − 1/z = 4·sin²(πf·dt), the spectrum of every term is a simple function of w: white noise a constant,
quantization w, a rate random walk 1/w, and a process of autocovariance ρ·φˡ is ρ(1 − φ²)/((1 − φ)² + φ·w). The roots of
their sum's numerator are found from these partial fractions as they stand, never from the coefficients of a polynomial, so
that nothing is lost but what the rounding of φ itself takes: 1e-10 of a spectrum at correlation times of 10⁶ samples.
Of a root w, ϑ inside the unit circle has (1 − ϑ)²/ϑ = −w.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau.errors import DataError
from sigmatau.model.channel import ChannelModel
from sigmatau.model.elsewhere import one_channel
from sigmatau.model.state_space import StateSpace, state_space
from sigmatau.results import Printed

__all__ = ["Arma", "arma"]

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

_WHITE = 1e-14
"""What is left of a process after one sample, below which it is white."""

_ITERATIONS = 500
_LOST = 1e-6
"""What rounded coefficients may change the gain at zero frequency by, relative, roots at 1 left out."""

_TINY = 1e-300


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Arma(Printed):
    """An ARIMA(p, d, q) process: (1 − L)ᵈ·ar(L)·y = drift + ma(L)·e, L the lag by one sample, var e = `variance`.

    To filter with it, take `sections`: of roots close to 1, which flicker noise and long correlation times have, double
    precision has no coefficients of a polynomial, and a filter made of such coefficients is unstable.

    Attributes
    ----------
    d : int
        Differences: 1 with a rate random walk or a ramp, else 0.
    variance : float
        Of the innovation e, the error of the best forecast by one sample. [(unit of the rate)²]
    drift : float
        Mean of the differenced process before `ar`: a ramp. [unit of the rate]
    ar_roots : ndarray, shape (p,)
        Factors φ of ar = Π(1 − φL), the differences taken out; inside the unit circle.
    ma_roots : ndarray, shape (q,)
        Factors ϑ of ma = Π(1 − ϑL); invertible.
    dt : float
        [s]
    unit : str
        Of the rate, SI.
    flicker_error : float
        Largest relative error of the Allan deviation of the flicker noise up to `tau_max`; 0 without.
    tau_max : float or None
        The longest averaging time for which the flicker noise is right. [s]
    """

    d: int
    variance: float
    drift: float
    ar_roots: Complexes
    ma_roots: Complexes
    dt: float
    unit: str
    flicker_error: float = 0.0
    tau_max: float | None = None

    def __post_init__(self) -> None:
        for name in ("ar_roots", "ma_roots"):
            array = np.array(getattr(self, name))
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def p(self) -> int:
        """Order of the autoregressive part."""
        return len(self.ar_roots)

    @property
    def q(self) -> int:
        """Order of the moving average."""
        return len(self.ma_roots)

    @property
    def ar(self) -> Floats:
        """1, −φ₁ … as it stands in front of y, the differences taken out; shape (p + 1,).

        Raises `DataError` where coefficients in double precision do not have the roots; take `sections`.
        """
        return _coefficients("ar", self.ar_roots)

    @property
    def ma(self) -> Floats:
        """1, θ₁ …, shape (q + 1,); raises `DataError` as `ar` does."""
        return _coefficients("ma", self.ma_roots)

    @property
    def sections(self) -> Floats:
        """The whole filter from e to y, differences too but for the drift, in factors of first and second order.

        Returns
        -------
        ndarray, shape (n_sections, 6)
            b₀, b₁, b₂, 1, a₁, a₂ of each: what `scipy.signal.sosfilt` takes. Real roots stand alone, so that each is as it
            is in `ar_roots`.
        """
        return _sections(np.append(self.ar_roots, np.ones(self.d)), self.ma_roots)

    def psd(self, f: ArrayLike) -> Floats:
        """Two-sided density of the process, without its drift; frequencies in Hz, positive. [(unit of the rate)²/Hz]"""
        w = 4 * np.sin(math.pi * np.asarray(f, dtype=np.float64) * self.dt) ** 2
        return np.asarray(
            self.dt * self.variance * _gain(self.ma_roots, w) / (_gain(self.ar_roots, w) * w**self.d), dtype=np.float64
        )

    def to_dict(self) -> dict[str, Any]:
        """Orders and coefficients as plain numbers."""
        return {
            "p": self.p,
            "d": self.d,
            "q": self.q,
            "ar": self.ar.tolist() if _has_coefficients(self.ar_roots) else None,
            "ma": self.ma.tolist() if _has_coefficients(self.ma_roots) else None,
            "ar_roots": [[root.real, root.imag] for root in self.ar_roots.tolist()],
            "ma_roots": [[root.real, root.imag] for root in self.ma_roots.tolist()],
            "sections": self.sections.tolist(),
            "variance": self.variance,
            "drift": self.drift,
            "dt_s": self.dt,
            "unit": self.unit,
            "flicker_error": self.flicker_error,
            "tau_max_s": self.tau_max,
        }

    def __repr__(self) -> str:
        head = f"ARIMA({self.p}, {self.d}, {self.q})" if self.d else f"ARMA({self.p}, {self.q})"
        lines = [f"{head} every {self.dt:g} s, innovation variance {self.variance:.9g} ({self.unit})²"]
        if self.tau_max is not None:
            lines.append(
                f"flicker noise: Allan deviation within {100 * self.flicker_error:.2g} % up to {self.tau_max:.4g} s"
            )
        lost = False
        for name, symbol, roots in (("ar", "φ", self.ar_roots), ("ma", "ϑ", self.ma_roots)):
            if _has_coefficients(roots):
                lines.append(f"  {name} = {_polynomial(_expanded(roots))}")
            lost |= not _has_coefficients(roots)
            if len(roots):
                lines.append(f"  {name} = Π(1 − {symbol}L), {symbol} = {', '.join(_root(r) for r in roots.tolist())}")
        if lost:
            lines.append("  multiplied out, double precision would lose these roots: filter with `sections` (sosfilt)")
        if self.drift:
            lines.append(f"  drift = {self.drift:.9g} {self.unit}")
        return "\n".join(lines)


def arma(model: ChannelModel, *, dt: float, tau_max: float | None = None, flicker_error: float = 0.01) -> Arma:
    """The ARIMA process with the spectrum of a channel's noise, sampled every `dt`.

    Parameters
    ----------
    model : ChannelModel
    dt : float
        Sample interval. [s]
    tau_max, flicker_error : float
        As in `sigmatau.model.state_space`.

    Returns
    -------
    Arma
        Of m Gauss-Markov processes, those of flicker noise among them: ARMA(m, m) with a random walk, ARMA(m, m − 1)
        without; a difference more with a rate random walk or a ramp, an order of the moving average more with each
        of these and with quantization.

    Raises
    ------
    OptionError
        As `sigmatau.model.state_space`.
    DataError
        For a sinusoid, which is no such process, or a ramp with no noise.

    Notes
    -----
    Random walk and rate random walk: ϑ + 1/ϑ = 2 + K²dt²/N², which is the steady state of the Kalman filter, gain 1 − ϑ.

    References
    ----------
    A. C. Harvey, "Forecasting, Structural Time Series Models and the Kalman Filter," 1989, section 2.4, for the reduced form
    of sums of processes; O. Aberth, Math. Comp. 27, 1973, :doi:`10.1090/S0025-5718-1973-0329236-7`, for the roots.
    """
    one_channel(model, kind=ChannelModel, function="arma")
    if model.sinusoid:
        raise DataError("a sinusoid is no ARMA process: leave it out of the model, or take its state space")
    system = state_space(model, dt=dt, tau_max=tau_max, flicker_error=flicker_error)
    ramp = model.terms.get("rate_ramp", 0.0)
    spectrum = _Spectrum.of(model, system)
    if not (spectrum.white or spectrum.walk or spectrum.quantization or len(spectrum.phi)):
        raise DataError("a ramp alone is no ARMA process: it has no noise")
    roots = spectrum.zeros()
    d = 1 if spectrum.walk or ramp else 0
    if d and not spectrum.walk:
        roots = np.append(roots, 0.0)  # the difference is in the noise too
    ma_roots = _inside(roots)
    at = 2.0
    power = spectrum.at(at) * at**d * float(_gain(spectrum.phi, np.array([at]))[0])
    return Arma(
        d=d,
        variance=power / float(_gain(ma_roots, np.array([at]))[0]),
        drift=ramp * dt * float(np.prod(1 - spectrum.phi).real),
        ar_roots=_conjugate(spectrum.phi),
        ma_roots=_conjugate(ma_roots),
        dt=dt,
        unit=model.unit,
        flicker_error=system.flicker_error,
        tau_max=system.tau_max,
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Spectrum:
    """A spectrum in partial fractions of w: white + quantization·w + walk/w + Σ ρ(1 − φ²)/((1 − φ)² + φ·w)."""

    white: float
    quantization: float
    walk: float
    phi: Complexes
    rho: Complexes

    @classmethod
    def of(cls, model: ChannelModel, system: StateSpace) -> _Spectrum:
        """The stationary states' modes; the terms that are not stationary, and white noise, from their coefficients."""
        dt, terms = system.dt, model.terms
        kept = [k for k, s in enumerate(system.states) if s.startswith(("flicker_", "gauss_markov_", "filter_"))]
        values, vectors = np.linalg.eig(system.F[np.ix_(kept, kept)])
        p0, h = system.P0[np.ix_(kept, kept)], system.H[0, kept]
        weights = (h @ vectors) * np.linalg.solve(vectors, p0 @ h) if kept else np.empty(0)
        white = float(system.R[0, 0])
        merged: dict[complex, complex] = {}
        for phi, rho in zip(values.astype(complex).tolist(), weights.astype(complex).tolist(), strict=True):
            if abs(phi) < _WHITE:
                white += rho.real
            else:
                merged[phi] = merged.get(phi, 0) + rho
        return cls(
            white=white,
            quantization=(terms.get("quantization", 0.0) / dt) ** 2,
            walk=terms.get("rate_random_walk", 0.0) ** 2 * dt,
            phi=np.array(list(merged), dtype=complex),
            rho=np.array(list(merged.values()), dtype=complex),
        )

    def at(self, w: float) -> float:
        """The spectrum; w from 0 to 4."""
        total = self.white + self.quantization * w + (self.walk / w if self.walk else 0.0)
        parts = self.rho * (1 - self.phi**2) / ((1 - self.phi) ** 2 + self.phi * w)
        return total + float(parts.sum().real)

    def zeros(self) -> Complexes:
        """Roots x = −w of the numerator, by Aberth's method, all at once; relative to the rounding of a double."""
        poles = (1 - self.phi) ** 2 / self.phi
        heights = self.rho * (1 - self.phi**2) / self.phi
        if self.walk:
            poles, heights = np.append(poles, 0.0), np.append(heights, self.walk)
        degree = len(poles) + (1 if self.quantization else 0 if self.white else -1)
        if degree <= 0:
            return np.empty(0, dtype=complex)
        x = _starts(np.abs(poles), degree, self.white / self.quantization if self.quantization else None)
        for _ in range(_ITERATIONS):
            fractions = heights / (poles - x[:, None])
            value = self.white - self.quantization * x + fractions.sum(axis=1)
            slope = -self.quantization + (fractions / (poles - x[:, None])).sum(axis=1)
            # N = f·Π(a − x): N′/N without N, whose coefficients would have to be multiplied out.
            ratio = slope - value * (1 / (poles - x[:, None])).sum(axis=1)
            apart = x[:, None] - x
            np.fill_diagonal(apart, 1.0)
            others = 1 / apart
            np.fill_diagonal(others, 0.0)
            step = value / (ratio - value * others.sum(axis=1))
            x = x - step
            if (np.abs(step) <= 1e-15 * np.abs(x)).all():
                break
        if not (np.abs(step) <= 1e-6 * np.abs(x) + _TINY).all():
            raise FloatingPointError("the moving average of this model was not found")
        # Roots come alone on the real line, or in pairs.
        return np.where(np.abs(x.imag) < 1e-10 * np.abs(x), x.real, x)


def _starts(poles: Floats, degree: int, last: float | None) -> Complexes:
    """Points between the poles and beyond them, a little off the real line and all different."""
    sizes = np.sort(poles[poles > 0])
    least = sizes[0] if len(sizes) else 1.0
    beyond = max(sizes[-1] if len(sizes) else 1.0, last or 0.0, 1.0)
    around = np.concatenate(([least / 30], np.sqrt(sizes[1:] * sizes[:-1]), [beyond * 2, beyond * 20]))
    while len(around) < degree:
        around = np.append(around, around[-1] * 3)
    angles = 0.3 + 0.5 * np.arange(degree) % 1.0
    return np.asarray(around[len(around) - degree :] * np.exp(1j * angles * (-1.0) ** np.arange(degree)))


def _inside(x: Complexes) -> Complexes:
    """ϑ inside the unit circle with (1 − ϑ)²/ϑ = x."""
    half = np.sqrt(x * (1 + x / 4))
    outside = np.array([1 + x / 2 + half, 1 + x / 2 - half])
    larger = np.where(np.abs(outside[0]) >= np.abs(outside[1]), outside[0], outside[1])
    return np.asarray(1 / larger)


def _gain(roots: Complexes, w: Floats) -> Floats:
    """|Π(1 − ϑ/z)|² at w."""
    # A complex root comes with its conjugate, so that the product is real and the square of the magnitude.
    factors = (1 - roots) ** 2 + roots * w[..., None]
    return np.asarray(np.prod(factors, axis=-1).real)


def _expanded(roots: Complexes) -> Floats:
    """Coefficients of Π(1 − ϑL), from the lag 0 on."""
    return np.atleast_1d(np.poly(roots)).real if len(roots) else np.ones(1)


def _conjugate(roots: Complexes) -> Complexes:
    """Roots whose pairs are each other's conjugates to the bit, the real ones first, from the one closest to 1 on."""
    real = roots[roots.imag == 0]
    upper = roots[roots.imag > 0]
    return np.concatenate(
        (real[np.argsort(-real.real, kind="stable")], np.ravel(np.column_stack((upper, upper.conj()))))
    )


def _has_coefficients(roots: Complexes) -> bool:
    """Whether the product, multiplied out in double precision, still has the roots."""
    beside = 1 - roots[roots != 1]
    size = float(np.abs(_expanded(roots)).sum())
    return size * float(np.finfo(float).eps) <= _LOST * float(np.abs(np.prod(beside)))


def _coefficients(name: str, roots: Complexes) -> Floats:
    if not _has_coefficients(roots):
        raise DataError(
            f"`{name}` has no coefficients in double precision: multiplied out, the roots (the closest 1 −"
            f" {float(np.abs(1 - roots).min()):.3g}) are lost and the filter is unstable; filter with `sections`,"
            f" scipy.signal.sosfilt, or take `{name}_roots`"
        )
    return _expanded(roots)


def _factors(roots: Complexes) -> list[tuple[complex, Floats]]:
    """Real roots alone, complex ones with their conjugates: one of the roots, and 1, c₁, c₂."""
    found = []
    for root in roots.tolist():
        if root.imag == 0:
            found.append((root, np.array([1.0, -root.real, 0.0])))
        elif root.imag > 0:
            found.append((root, np.array([1.0, -2 * root.real, abs(root) ** 2])))
    return found


def _sections(poles: Complexes, zeros: Complexes) -> Floats:
    """Each pole, the closest to the unit circle first, over the zero nearest to it of its own order."""
    one = np.array([1.0, 0.0, 0.0])
    left = _factors(zeros)
    rows = []
    for pole, below in sorted(_factors(poles), key=lambda factor: -abs(factor[0])):
        alike = [k for k, (zero, _) in enumerate(left) if (zero.imag == 0) == (pole.imag == 0)]
        above = left.pop(min(alike, key=lambda k: abs(left[k][0] - pole)))[1] if alike else one
        rows.append(np.concatenate((above, below)))
    rows += [np.concatenate((above, one)) for _, above in left]
    return np.array(rows or [np.concatenate((one, one))])


def _root(root: complex) -> str:
    if root.imag:
        return f"{root.real:.9g} {'+' if root.imag > 0 else '−'} {abs(root.imag):.9g}i"
    # Nine digits of what is missing to 1, which is what matters, where they would be lost behind nines.
    return f"1 − {1 - root.real:.9g}" if 0 < 1 - root.real < 0.01 else f"{root.real:.9g}"


def _polynomial(coefficients: Floats) -> str:
    return "1" + "".join(f" {'-' if c < 0 else '+'} {abs(c):.9g}·L{_power(k)}" for k, c in enumerate(coefficients) if k)


def _power(k: int) -> str:
    return "" if k == 1 else str(k).translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))
