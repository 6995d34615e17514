"""From a density to its Allan variance, by numbers: eq. (11) of the paper, and its form for samples.

A check of every pair of closed forms, and the way to the Allan variance of a density that has none.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from sigmatau.arrays import Floats
from sigmatau.errors import DataError, OptionError

Density = Callable[[Floats], ArrayLike]

_DIRECT = 8 * math.pi  # x = πfT up to which the kernel is integrated as it is: eight of its humps
_LOWEST = 1e-30  # of x; below it a density steeper than f^−3 is all that could matter
_HIGHEST = 1e17
_SLOPE_POINTS = (1e-14, 1e-12)  # of x: where the slope towards f = 0 is taken
_STEEPEST = -3.0
_FINEST = 60  # halvings
_MAX_INTERVALS = 200_000  # intervals

# Gauss and Kronrod's rule of 7 and 15 points (QUADPACK).
_NODES = np.array(
    [
        0.991455371120812639206854697526329,
        0.949107912342758524526189684047851,
        0.864864423359769072789712788640926,
        0.741531185599394439863864773280788,
        0.586087235467691130294144045369,
        0.405845151377397166906606412076961,
        0.207784955007898467600689403773245,
        0.0,
    ]
)
_KRONROD = np.array(
    [
        0.022935322010529224963732008058970,
        0.063092092629978553290700663189204,
        0.104790010322250183839876322541518,
        0.140653259715525918745189590510238,
        0.169004726639267902826583426598550,
        0.190350578064785409913256402421014,
        0.204432940075298892414161999234649,
        0.209482141084727828012999174891714,
    ]
)
_GAUSS = np.array(
    [
        0.0,
        0.129484966168869693270611432679082,
        0.0,
        0.279705391489276667901467771423780,
        0.0,
        0.381830050505118944950369775488975,
        0.0,
        0.417959183673469387755102040816327,
    ]
)


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
        [unit²/Hz]. It may have steps and peaks; the integration finds them if they are not too narrow for it.
    tau : array_like, shape (n_tau,)
        Averaging times; with `tau0` whole multiples of it. [s]
    tau0 : float, optional
        Sample interval: the density is that of samples, folded to 1/(2·tau0), and the sum over clusters is exact.
        Default: continuous time, where each cluster is an integral. [s]
    f_min : float
        Frequency at which the integral begins. [Hz]
    f_max : float, optional
        Where the density ends. Default: nowhere, or 1/(2·tau0). [Hz]
    rtol : float
        Relative error to be met, 1e-12 at least.

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
        For times that are not positive, or no multiples of `tau0`.

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

    The first eight humps are integrated as they are. Beyond, sin⁴ = 3/8 − cos(2x)/2 + cos(4x)/8: the first part by the same
    adaptive rule on a logarithmic axis, the others by QUADPACK's rule for oscillating functions.

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
        """The integrand without its sin⁴: S over x², or over n²·sin²(x/n)."""
        return self.density(x) / (x if self.n is None else self.n * np.sin(x / self.n)) ** 2

    def integral(self, start: float, end: float) -> float:
        if start > 0:
            split = min(max(_DIRECT, start), end)
            total = self._smooth(lambda x: self.envelope(x) * np.sin(x) ** 4, start, split) if start < split else 0.0
            return 4 / (math.pi * self.time) * (total + (self._tail(split, end, total) if end > split else 0.0))
        slope = self._slope(end)
        # The integrand goes as x^(2 + slope): of a steep density much is at frequencies that no number of decades covers.
        if slope <= _STEEPEST + 1e-3:
            raise DataError(
                f"the integral of eq. (11) diverges at f = 0: the density rises as f^{slope:.3g}, and an Allan variance"
                " is finite only where it rises less than f^-3 (a ramp has no density: its Allan variance is that of eq. 23)"
            )
        split = min(_DIRECT, end)
        total = self._smooth(lambda x: self.envelope(x) * np.sin(x) ** 4, _LOWEST, split)
        # What is left of the lowest frequency: sin⁴x = x⁴.
        low = np.array([_LOWEST])
        total += float((self.envelope(low) * low**5)[0]) / (3 + slope)
        if end > split:
            total += self._tail(split, end, total)
        return 4 / (math.pi * self.time) * total

    def _slope(self, end: float) -> float:
        x = np.array(_SLOPE_POINTS) * min(1.0, end)
        s = self.density(x)
        return float(np.log(s[0] / s[1]) / np.log(x[0] / x[1])) if (s > 0).all() else 0.0

    def _smooth(self, function: Callable[[Floats], Floats], start: float, stop: float, partial: float = 0.0) -> float:
        """By bisection on a logarithmic axis, and on a linear one beyond x = 1 where humps are."""
        logarithmic = math.log(min(stop, 1.0)) if start < 1 else math.log(stop)
        edges = np.linspace(math.log(start), logarithmic, max(2, math.ceil(2 * (logarithmic - math.log(start)))))
        total = _adaptive(lambda u: function(np.exp(u)) * np.exp(u), edges, self.rtol, partial)
        if start < 1 < stop:
            humps = np.linspace(1.0, stop, max(2, math.ceil(stop)))
            total += _adaptive(function, humps, self.rtol, partial + total)
        return total

    def _tail(self, start: float, end: float, partial: float) -> float:
        if math.isinf(end):
            end = self._distant(start, partial)
        steady = 0.375 * self._smooth(self.envelope, start, end, partial)
        waves = 0.0
        a = start
        while a < end:
            b = min(8 * a, end)
            value, remainder = self._waves(a, b)
            waves += value
            # What oscillates beyond b is at most the envelope there, over its pace, and twice that.
            if remainder < 0.1 * self.rtol * (partial + steady) and self.n is None:
                break
            a = b
        return steady + waves

    def _distant(self, start: float, partial: float) -> float:
        """Where a density without an end has no more to give; it must fall, or stay."""
        x = start * 10.0 ** np.arange(0, 2 * math.log10(_HIGHEST) + 1, 0.5)
        share = self.envelope(x) * x
        done = np.flatnonzero(share <= 1e-3 * self.rtol * max(partial, share[0]))
        if not len(done):
            raise DataError("the integral of eq. (11) diverges at f = ∞, or nearly: the density rises; give `f_max`")
        return float(x[done[0]])

    def _waves(self, a: float, b: float) -> tuple[float, float]:
        """∫ envelope·(cos(4x)/8 − cos(2x)/2), and what may be left beyond."""
        import warnings

        from scipy.integrate import IntegrationWarning, quad

        # In units of a and of the envelope there: where the parts cancel, QUADPACK's tolerance is absolute.

        def envelope(u: float) -> float:
            return float(self.envelope(np.array([a * u]))[0])

        height = envelope(1.0) or 1.0
        total = 0.0
        for turn, weight in ((2.0, -0.5), (4.0, 0.125)):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", IntegrationWarning)  # rounding, at a tolerance of 1e-13
                value, _ = quad(
                    lambda u: envelope(u) / height,
                    1.0,
                    b / a,
                    weight="cos",
                    wvar=turn * a,
                    epsabs=1e-13,
                    epsrel=1e-12,
                    limit=400,
                )
            total += weight * a * height * value
        return total, envelope(b / a)


def _adaptive(function: Callable[[Floats], Floats], edges: Floats, rtol: float, partial: float) -> float:
    """Integral over the intervals between the edges; those that are not yet right are halved, all at once."""
    lower, upper = edges[:-1], edges[1:]
    done = 0.0
    nodes = np.concatenate((-_NODES, _NODES[-2::-1]))
    kronrod = np.concatenate((_KRONROD, _KRONROD[-2::-1]))
    gauss = np.concatenate((_GAUSS, _GAUSS[-2::-1]))
    for _ in range(_FINEST):
        half = (upper - lower) / 2
        x = (lower + upper)[:, None] / 2 + half[:, None] * nodes
        values = function(x.ravel()).reshape(x.shape)
        parts, coarse = values @ kronrod * half, values @ gauss * half
        allowed = rtol * (abs(partial) + abs(done + float(parts.sum())))
        # Shared among all: a thousand intervals with a thousandth each.
        wrong = np.abs(parts - coarse) > np.maximum(0.1 * allowed / len(edges), 1e-15 * np.abs(parts))
        done += float(parts[~wrong].sum())
        if not wrong.any():
            return done
        middle = (lower[wrong] + upper[wrong]) / 2
        lower, upper = np.concatenate((lower[wrong], middle)), np.concatenate((middle, upper[wrong]))
        if len(lower) > _MAX_INTERVALS:
            break
    else:
        if float(np.abs(parts[wrong]).sum()) < allowed:  # a step: halved until nothing was left of it
            return done + float(parts[wrong].sum())
    raise DataError(f"`psd` is too rough to be integrated to {rtol:g}; allow a larger `rtol`, or end it at an `f_max`")
