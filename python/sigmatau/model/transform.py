"""Numerical integration of a density to its Allan variance: eq. (11) of the paper, and its form for samples.

It verifies the closed forms, and computes the Allan variance of a density without a closed form.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from sigmatau.arrays import Floats
from sigmatau.errors import DataError, OptionError
from sigmatau.model.density_pieces import gauss_nodes, integrals_under_sine

Density = Callable[[Floats], ArrayLike]

_DIRECT = 8 * math.pi  # x = πfT after eight humps of the kernel
_LOWEST = 1e-30  # smallest x; only a density steeper than f^−3 could matter below
_HIGHEST = 1e17
_SLOPE_POINTS = (1e-14, 1e-12)  # values of x between which the slope towards f = 0 is measured
_STEEPEST = -3.0
_FINEST = 60  # largest number of halvings
_MAX_PIECES = 20_000


def integrate_density(
    psd: Density,
    tau: ArrayLike,
    *,
    tau0: float | None = None,
    f_min: float = 0.0,
    f_max: float | None = None,
    rtol: float = 1e-11,
) -> Floats:
    """Allan variance of a noise with the given two-sided density, by integration.

    Parameters
    ----------
    psd : callable
        Takes frequencies, an array of shape (n,) [Hz], all above 0, and returns the two-sided density there
        [unit²/Hz]. It may have steps and peaks; the integration resolves them unless they are extremely narrow.
    tau : array_like, shape (n_tau,)
        Averaging times; with `tau0`, whole multiples of it. [s]
    tau0 : float, optional
        Sample interval: the density is that of samples, folded to 1/(2·tau0), and the sum over clusters is exact.
        Default: continuous time, where each cluster is an integral. [s]
    f_min : float
        Frequency at which the integral begins. [Hz]
    f_max : float, optional
        Frequency at which the density ends. Default: infinity, or 1/(2·tau0). [Hz]
    rtol : float
        Largest relative error, at least 1e-12.

    Returns
    -------
    ndarray, shape (n_tau,)
        [unit²]

    Raises
    ------
    DataError
        If the integral diverges at 0 (a density that rises as 1/f³ or faster, such as eq. 24 for the ramp) or at infinity,
        the density is negative or not finite, or so rough that `rtol` is not met.
    OptionError
        For times that are not positive, or not multiples of `tau0`.

    See Also
    --------
    sigmatau.avar_from_psd : also for sampled densities and for matrices, with the error of truncation.
    ChannelModel.avar : closed forms for the noise of a model.

    Notes
    -----
    Continuous, eq. (11) of [1]_, with x = πfT::

        σ²(T) = 4 ∫ S(f)·sin⁴(πfT)/(πfT)² df,   0 … ∞

    Of samples, T = n·τ₀::

        σ²(n) = 4 ∫ S(f)·sin⁴(πfT)/(n²·sin²(πfτ₀)) df,   0 … 1/(2τ₀)

    Each octave is integrated like a sampled density, which is exact for any number of turns of sin⁴, see
    `sigmatau.model.density_pieces`. Octaves in which the density is not smooth are halved repeatedly.

    References
    ----------
    .. [1] :doi:`10.1109/TIM.2007.908635`

    Examples
    --------
    >>> from sigmatau.model.transform import integrate_density
    >>> integrate_density(lambda f: 0 * f + 1e-8, [1.0, 100.0])  # white noise of N = 1e-4: N²/τ
    array([1.e-08, 1.e-10])
    """
    times = np.atleast_1d(np.asarray(tau, dtype=np.float64))
    if not (np.isfinite(times).all() and (times > 0).all()):
        raise OptionError("{option} must be positive numbers of seconds", option="tau")
    for name, value in (("tau0", tau0), ("f_max", f_max)):
        if value is not None and not (math.isfinite(value) and value > 0):
            raise OptionError(f"{{option}} must be a positive number, not {value!r}", option=name)
    if not 1e-12 <= rtol < 1:
        raise OptionError(f"{{option}} must be from 1e-12 to 1, not {rtol!r}", option="rtol")
    sizes = None
    if tau0 is not None:
        sizes = np.round(times / tau0)
        if (sizes < 1).any() or (np.abs(sizes * tau0 - times) > 1e-6 * tau0).any():
            raise OptionError(f"{{option}} must be whole multiples of `tau0`, {tau0!r} s", option="tau")
        f_max = min(f_max or math.inf, 0.5 / tau0)
    if not 0 <= f_min < (math.inf if f_max is None else f_max):
        raise OptionError(f"{{option}} must be from 0 Hz to below the highest frequency, not {f_min!r}", option="f_min")
    results = []
    for k, time in enumerate(times.tolist()):
        n = None if sizes is None else float(sizes[k])
        end = math.inf if f_max is None else math.pi * f_max * time
        results.append(_Kernel(psd, time, n, rtol).integral(math.pi * f_min * time, end))
    return np.array(results)


class _Kernel:
    """The integral over x = πfT for one averaging time."""

    def __init__(self, psd: Density, time: float, n: float | None, rtol: float) -> None:
        self.psd, self.time, self.n, self.rtol = psd, time, n, rtol

    def density(self, x: Floats) -> Floats:
        f = x / (math.pi * self.time)
        values = np.asarray(self.psd(f), dtype=np.float64)
        if values.ndim == 0:
            values = np.full(f.shape, values)
        if values.shape != f.shape:
            raise DataError(f"`psd` gave an array of shape {values.shape} for {f.shape}; it must give a value each")
        wrong = ~(np.isfinite(values) & (values >= 0))
        if wrong.any():
            k = int(np.argmax(wrong))
            raise DataError(f"`psd` is {values[k]} at {f[k]:.6g} Hz; a density is finite and not negative")
        return values

    def envelope(self, x: Floats) -> Floats:
        """The integrand without sin⁴: S over x², or over n²·sin²(x/n)."""
        return self.density(x) / (x if self.n is None else self.n * np.sin(x / self.n)) ** 2

    def integral(self, start: float, end: float) -> float:
        below = 0.0
        if start == 0:
            slope = self._slope(end)
            # The integrand is proportional to x^(2 + slope): for a steep density, much of the integral is at very low
            # x.
            if slope <= _STEEPEST + 1e-3:
                raise DataError(
                    f"the integral of eq. (11) diverges at f = 0: the density rises as f^{slope:.3g}, and an Allan variance"
                    " is finite only where it rises less than f^-3 (a ramp has no density: its Allan variance is that of"
                    " eq. 23)"
                )
            # Below the lowest frequency, sin⁴x = x⁴.
            low = np.array([_LOWEST])
            start, below = _LOWEST, float((self.envelope(low) * low**5)[0]) / (3 + slope)
        split = min(max(_DIRECT, start), end)
        total = below + (self._adaptive(start, split, below) if start < split else 0.0)
        if end > split:
            total += self._adaptive(split, self._negligible_from(split, total) if math.isinf(end) else end, total)
        return 4 / (math.pi * self.time) * total

    def _slope(self, end: float) -> float:
        x = np.array(_SLOPE_POINTS) * min(1.0, end)
        s = self.density(x)
        return float(np.log(s[0] / s[1]) / np.log(x[0] / x[1])) if (s > 0).all() else 0.0

    def _negligible_from(self, start: float, partial: float) -> float:
        """Frequency above which a density that extends to infinity contributes nothing."""
        x = start * 10.0 ** np.arange(0, 2 * math.log10(_HIGHEST) + 1, 0.5)
        share = self.envelope(x) * x
        done = np.flatnonzero(share <= 1e-3 * self.rtol * max(partial, share[0]))
        if not len(done):
            raise DataError("the integral of eq. (11) diverges at f = ∞, or nearly: the density rises; give `f_max`")
        return float(x[done[0]])

    def _adaptive(self, start: float, stop: float, partial: float) -> float:
        """The integral over octaves; all pieces that are not yet accurate are halved at once."""
        edges = np.geomspace(start, stop, max(math.ceil(math.log2(stop / start)), 1) + 1)
        lower, upper = edges[:-1], edges[1:]
        values, done = self._pieces(lower, upper), 0.0
        for _ in range(_FINEST):
            middle = np.sqrt(lower) * np.sqrt(upper)
            halves = np.stack((self._pieces(lower, middle), self._pieces(middle, upper)))
            refined = halves.sum(axis=0)
            allowed = self.rtol * abs(partial + done + float(refined.sum()))
            # The allowed error is shared among all pieces.
            wrong = np.abs(refined - values) > np.maximum(0.1 * allowed / len(edges), 1e-14 * np.abs(refined))
            done += float(refined[~wrong].sum())
            if not wrong.any():
                return done
            lower, upper = np.append(lower[wrong], middle[wrong]), np.append(middle[wrong], upper[wrong])
            values = halves[:, wrong].ravel()
            if len(lower) > _MAX_PIECES:
                break
        else:
            if float(np.abs(values).sum()) < allowed:  # a step of the density, halved to a negligible width
                return done + float(values.sum())
        raise DataError(
            f"`psd` is too rough to be integrated to {self.rtol:g}; allow a larger `rtol`, or end it at an `f_max`"
        )

    def _pieces(self, lower: Floats, upper: Floats) -> Floats:
        half = (upper - lower) / 2
        nodes = gauss_nodes(lower, half)
        envelope = self.envelope(nodes.ravel()).reshape(nodes.shape)
        return integrals_under_sine(envelope, lower, half, 1 / math.pi)
