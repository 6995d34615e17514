"""Noise models as ARIMA processes: the difference equation with the same spectrum.

The moving average is the spectral factor of the sum of all terms, see `sigmatau.statespace.spectral_factor`. The spectrum of
the result is compared with that of the model before it is returned.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau.arrays import Floats, freeze
from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import check_sample_interval
from sigmatau.noise.terms import refuse_without_system
from sigmatau.results import Printed, plain
from sigmatau.statespace.spectral_factor import RationalSpectrum
from sigmatau.statespace.state_space import check_channel_model, find_flicker_poles

Complexes = NDArray[np.complex128]

# Largest relative change of the gain at zero frequency that rounded coefficients may cause, without the roots at 1
_MAX_GAIN_CHANGE = 1e-6

# longest period at which the spectrum is compared with that of the model: the longest band of flicker noise [samples]
_LONGEST_PERIOD = 1e12
_PER_DECADE = 8  # number of frequencies per decade at which the spectrum is compared

_MAX_SPECTRUM_ERROR = 1e-4
"""Largest relative error of a spectrum, above which the process is refused. Rounding a root to double precision changes
1 − φ by 1e-16, a relative change of 1e-4 at a correlation time of 10¹² samples; other errors are below 1e-12.
"""


@frozen(eq=False)
class Arma(Printed):
    """An ARIMA(p, d, q) process: (1 − L)ᵈ·ar(L)·y = drift + ma(L)·e.

    L is the lag by one sample, and var e = `variance`. Use `sections` for filtering: flicker noise and long correlation
    times have roots close to 1, for which polynomial coefficients in double precision are not accurate enough, and a filter
    with `ar` and `ma` would be unstable.

    Attributes
    ----------
    d : int
        Differences: 1 with a rate random walk or a ramp, else 0.
    variance : float
        Variance of the innovation e, the error of the best one-step forecast. [(unit of the rate)²]
    drift : float
        Mean of the differenced process before `ar`: a ramp. [unit of the rate]
    ar_roots : ndarray of complex, shape (p,)
        Factors φ of ar = Π(1 − φL), without the differences; inside the unit circle. [1]
    ma_roots : ndarray of complex, shape (q,)
        Factors ϑ of ma = Π(1 − ϑL); invertible. [1]
    dt : float
        Sample interval. [s]
    unit : str
        Quantity and unit of the rate; SI.
    flicker_error : float
        Largest relative error of the Allan deviation of the flicker noise up to `tau_max`; 0 without flicker noise.
    tau_max : float or None
        Longest averaging time for which the flicker noise is accurate. [s]
    error : float
        Largest relative error of the spectrum with these rounded roots, up to half the rate and for periods up to 10¹²
        samples. It does not include the error of the poles of flicker noise, see `flicker_error`.

    See Also
    --------
    sigmatau.arma : makes it.
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
    error: float = 0.0

    def __post_init__(self) -> None:
        freeze(self, "ar_roots", "ma_roots", copy=True)

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
        """Coefficients 1, −φ₁ … of y, without the differences; shape (p + 1,). [1]

        Raises
        ------
        DataError
            If coefficients in double precision lose the roots; use `sections`.
        """
        return _coefficients("ar", self.ar_roots)

    @property
    def ma(self) -> Floats:
        """Coefficients 1, θ₁ … of e; shape (q + 1,). [1]

        Raises
        ------
        DataError
            As for `ar`.
        """
        return _coefficients("ma", self.ma_roots)

    @property
    def sections(self) -> Floats:
        """The whole filter from e to y, differences included and drift excluded, as factors of first and second order.

        Returns
        -------
        ndarray, shape (n_sections, 6)
            b₀, b₁, b₂, 1, a₁, a₂ of each section, as `scipy.signal.sosfilt` needs them. Each real root has a separate
            section, so that it is exactly as in `ar_roots`. [1]

        Raises
        ------
        DataError
            For complex roots so close to 1 that the rounded coefficients of a pair no longer determine them: a filter whose
            corner is below 5e-6 of the rate.
        """
        if not self._has_sections():
            raise DataError(
                f"`sections`: complex roots so close to 1 ({self._closest():.3g}) have no coefficients in doubles;"
                " take the state space, or a longer sample interval"
            )
        return _sections(np.append(self.ar_roots, np.ones(self.d)), self.ma_roots)

    def _closest(self) -> float:
        """Smallest distance of a complex root from 1."""
        roots = np.append(self.ar_roots, self.ma_roots)
        return float(np.abs(1 - roots[roots.imag != 0]).min(initial=2.0))

    def _has_sections(self) -> bool:
        """Whether each pair of roots survives rounding. 1 + c₁ + c₂ = |1 − φ|² is a small difference of rounded numbers up
        to 2.
        """
        return 4 * float(np.finfo(float).eps) <= _MAX_GAIN_CHANGE * self._closest() ** 2

    def psd(self, f: ArrayLike) -> Floats:
        """Two-sided density of the process, without its drift.

        Parameters
        ----------
        f : array_like, shape (n_f,)
            Frequencies, positive. [Hz]

        Returns
        -------
        ndarray, shape (n_f,)
            [(unit of the rate)²/Hz, two-sided]
        """
        w = 4 * np.sin(math.pi * np.asarray(f, dtype=np.float64) * self.dt) ** 2
        return np.asarray(
            self.dt * self.variance * _gain(self.ma_roots, w) / (_gain(self.ar_roots, w) * w**self.d), dtype=np.float64
        )

    def to_dict(self) -> dict[str, Any]:
        """Orders and coefficients as plain numbers."""
        fields = "p d q variance drift dt_s=dt unit flicker_error tau_max_s=tau_max error"
        pairs = {name: getattr(self, name).tolist() for name in ("ar_roots", "ma_roots")}
        roots = {name: [[root.real, root.imag] for root in values] for name, values in pairs.items()}
        ar = self.ar if _has_coefficients(self.ar_roots) else None
        ma = self.ma if _has_coefficients(self.ma_roots) else None
        return plain(self, fields, ar=ar, ma=ma, sections=self.sections if self._has_sections() else None, **roots)

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
            way = "filter with `sections` (sosfilt)" if self._has_sections() else "take the state space"
            lines.append(f"  multiplied out, double precision would lose these roots: {way}")
        if self.drift:
            lines.append(f"  drift = {self.drift:.9g} {self.unit}")
        return "\n".join(lines)


def arma(model: ChannelModel, *, dt: float, tau_max: float | None = None, flicker_error: float = 0.01) -> Arma:
    """The ARIMA process with the spectrum of a channel's noise, sampled every `dt`.

    Parameters
    ----------
    model : ChannelModel
        Noise of one channel.
    dt : float
        Sample interval. [s]
    tau_max, flicker_error : float
        As in `sigmatau.state_space`.

    Returns
    -------
    Arma
        For m Gauss-Markov processes, including those of flicker noise (a resonance counts as two): ARMA(m, m) with a
        random walk, ARMA(m, m − 1) without. A rate random walk or a ramp adds one difference. Each of these, and
        quantization, adds one order of the moving average.

    Raises
    ------
    OptionError
        As `sigmatau.state_space`.
    DataError
        For a sinusoid, which is not an ARIMA process, or a ramp without noise; if the spectrum of the result differs
        from the model's by more than 1e-4.

    See Also
    --------
    state_space : the same noise as a linear system.

    Notes
    -----
    Random walk and rate random walk: ϑ + 1/ϑ = 2 + K²dt²/N², which is the steady state of the Kalman filter, gain 1 − ϑ.

    References
    ----------
    A. C. Harvey, "Forecasting, Structural Time Series Models and the Kalman Filter," 1989, section 2.4, for the reduced form
    of sums of processes; O. Aberth, Math. Comp. 27, 1973, :doi:`10.1090/S0025-5718-1973-0329236-7`, for the roots.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.ChannelModel(terms={"random_walk": 1e-4, "rate_random_walk": 1e-6})
    >>> found = st.arma(model, dt=0.01)
    >>> (found.p, found.d, found.q)
    (0, 1, 1)
    """
    check_channel_model(model, function="arma")
    refuse_without_system(model.terms)
    model = model.expand_matern(rate=1 / check_sample_interval("dt", dt))
    if model.sinusoid:
        raise DataError("a sinusoid is not an ARMA process: leave it out of the model, or take its state space")
    terms = model.terms
    ramp = terms.get("rate_ramp", 0.0)
    if not (model.gauss_markov or model.resonance) and not any(
        value for term, value in terms.items() if term != "rate_ramp"
    ):
        raise DataError("a ramp alone is not an ARMA process: it has no noise")
    processes = [(process.sigma, process.time) for process in model.gauss_markov]
    level = terms.get("bias_instability", 0.0)
    poles = find_flicker_poles(model, dt=dt, tau_max=tau_max, error=flicker_error)
    if poles is not None:
        processes += [(level * math.sqrt(v), t) for t, v in zip(poles.times, poles.variances, strict=True)]
    n = terms.get("random_walk", 0.0)
    walk = terms.get("rate_random_walk", 0.0)
    spectrum = RationalSpectrum.from_noise(
        dt=dt,
        white=0.0 if model.bandwidth else n,
        quantization=terms.get("quantization", 0.0),
        walk=walk,
        processes=processes,
        filtered=(model.bandwidth.before_sampling(n), model.bandwidth) if n and model.bandwidth else None,
        resonances=model.resonance,
    )
    ma_roots, variance = spectrum.factor()
    ar_roots, d = spectrum.roots, 1 if walk or ramp else 0
    if d and not walk:
        ma_roots = np.append(1.0, ma_roots)  # the noise is differenced too
    arma = Arma(
        d=d,
        variance=variance,
        drift=ramp * dt * float(np.prod(1 - ar_roots).real),
        ar_roots=ar_roots,
        ma_roots=ma_roots,
        dt=dt,
        unit=model.unit,
        flicker_error=poles.error if poles else 0.0,
        tau_max=poles.tau_max if poles else None,
    )
    f = np.geomspace(1 / (_LONGEST_PERIOD * dt), 0.5 / dt, math.ceil(_PER_DECADE * math.log10(_LONGEST_PERIOD / 2)))
    expected = dt * spectrum.density(4 * np.sin(math.pi * f * dt) ** 2)
    error = float(np.abs(arma.psd(f) / expected - 1).max())
    if not error <= _MAX_SPECTRUM_ERROR:
        raise DataError(
            f"the roots of this model's ARMA process, rounded to double precision, have a spectrum that is off by"
            f" {error:.2g} of it (at most {_MAX_SPECTRUM_ERROR:g} is returned); take its state space"
        )
    return replace(arma, error=error)


def _gain(roots: Complexes, w: Floats) -> Floats:
    """|Π(1 − ϑ/z)|² at w = 4 sin²(πf·dt)."""
    # With the conjugate of each complex root, the product is real and equals the squared magnitude.
    factors = (1 - roots) ** 2 + roots * w[..., None]
    return np.asarray(np.prod(factors, axis=-1).real)


def _expanded(roots: Complexes) -> Floats:
    """Coefficients of Π(1 − ϑL), from lag 0."""
    return np.atleast_1d(np.poly(roots)).real if len(roots) else np.ones(1)


def _has_coefficients(roots: Complexes) -> bool:
    """Whether the product, multiplied out in double precision, still has the roots."""
    rest = 1 - roots[roots != 1]
    size = float(np.abs(_expanded(roots)).sum())
    return size * float(np.finfo(float).eps) <= _MAX_GAIN_CHANGE * float(np.abs(np.prod(rest)))


def _coefficients(name: str, roots: Complexes) -> Floats:
    if not _has_coefficients(roots):
        raise DataError(
            f"`{name}` has no coefficients in double precision: multiplied out, the roots (the closest 1 −"
            f" {float(np.abs(1 - roots).min()):.3g}) are lost and the filter is unstable; filter with `sections`,"
            f" scipy.signal.sosfilt, or take `{name}_roots`"
        )
    return _expanded(roots)


def _factors(roots: Complexes) -> list[tuple[complex, Floats]]:
    """Factors of a polynomial: a root and its coefficients 1, c₁, c₂; a complex root includes its conjugate."""
    sections = []
    for root in roots.tolist():
        if root.imag == 0:
            sections.append((root, np.array([1.0, -root.real, 0.0])))
        elif root.imag > 0:
            sections.append((root, np.array([1.0, -2 * root.real, abs(root) ** 2])))
    return sections


def _sections(poles: Complexes, zeros: Complexes) -> Floats:
    """Second-order sections: each pole, the closest to the unit circle first, is paired with the nearest zero of its
    order.
    """
    unity = np.array([1.0, 0.0, 0.0])
    remaining = _factors(zeros)
    rows = []
    for pole, below in sorted(_factors(poles), key=lambda factor: -abs(factor[0])):
        alike = [k for k, (zero, _) in enumerate(remaining) if (zero.imag == 0) == (pole.imag == 0)]
        above = remaining.pop(min(alike, key=lambda k: abs(remaining[k][0] - pole)))[1] if alike else unity
        rows.append(np.concatenate((above, below)))
    rows += [np.concatenate((above, unity)) for _, above in remaining]
    return np.array(rows or [np.concatenate((unity, unity))])


def _root(root: complex) -> str:
    if root.imag:
        return f"{root.real:.9g} {'+' if root.imag > 0 else '−'} {abs(root.imag):.9g}i"
    # Roots close to 1 are printed as 1 − x, because only the distance from 1 matters.
    return f"1 − {1 - root.real:.9g}" if 0 < 1 - root.real < 0.01 else f"{root.real:.9g}"


def _polynomial(coefficients: Floats) -> str:
    return "1" + "".join(f" {'-' if c < 0 else '+'} {abs(c):.9g}·L{_power(k)}" for k, c in enumerate(coefficients) if k)


def _power(k: int) -> str:
    return "" if k == 1 else str(k).translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))
