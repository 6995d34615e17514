"""Allan variance of a two-sided density by numerical integration, an oracle for closed forms.

Continuous, eq. (11) of the paper, with x = πfT::

    σ²(T) = 4 ∫ S(f)·sin⁴(πfT)/(πfT)² df,   0 … ∞

Of samples, T = n·τ₀::

    σ²(n) = 4 ∫ S(f)·sin⁴(πfT)/(n²·sin²(πfτ₀)) df,   0 … 1/(2τ₀)

The first eight maxima are integrated directly. Beyond, sin⁴ = 3/8 − cos(2x)/2 + cos(4x)/8: the first part by the same
adaptive rule on a logarithmic axis, the others by QUADPACK's rule for oscillating functions.
"""

import math
import warnings

import numpy as np
from scipy.integrate import IntegrationWarning, quad

_DIRECT_UP_TO = 8 * math.pi  # x = πfT up to which the kernel is integrated directly: its first eight maxima
_SMALLEST_X = 1e-30  # lower end of x; below it only a density steeper than f^−3 contributes
_LARGEST_X = 1e17
_SLOPE_AT = (1e-14, 1e-12)  # values of x between which the slope towards f = 0 is measured
_STEEPEST_SLOPE = -3.0
_MOST_HALVINGS = 60  # halvings
_MOST_INTERVALS = 200_000  # intervals

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


def avar_from_psd(psd, tau, *, tau0=None, f_max=math.inf, rtol=1e-11):
    """Allan variances at the averaging times; of samples with `tau0`; `f_max` is the end of the density."""
    if tau0 is not None:
        f_max = min(f_max, 0.5 / tau0)
    return np.array(
        [
            _Kernel(psd, time, None if tau0 is None else round(time / tau0), rtol).integral(math.pi * f_max * time)
            for time in np.atleast_1d(tau).tolist()
        ]
    )


class _Kernel:
    """The integral over x = πfT for one averaging time."""

    def __init__(self, psd, time, n, rtol):
        self.psd, self.time, self.n, self.rtol = psd, time, n, rtol

    def density(self, x):
        return self.psd(x / (math.pi * self.time)) * np.ones_like(x)

    def envelope(self, x):
        """The integrand without its sin⁴: S over x², or over n²·sin²(x/n)."""
        return self.density(x) / (x if self.n is None else self.n * np.sin(x / self.n)) ** 2

    def integral(self, end):
        slope = self._slope(end)
        assert slope > _STEEPEST_SLOPE + 1e-3, f"the integral diverges at f = 0: the density rises as f^{slope:.3g}"
        split = min(_DIRECT_UP_TO, end)
        total = self._smooth(lambda x: self.envelope(x) * np.sin(x) ** 4, _SMALLEST_X, split)
        # What is left of the lowest frequency: sin⁴x = x⁴.
        low = np.array([_SMALLEST_X])
        total += float((self.envelope(low) * low**5)[0]) / (3 + slope)
        if end > split:
            total += self._tail(split, end, total)
        return 4 / (math.pi * self.time) * total

    def _slope(self, end):
        x = np.array(_SLOPE_AT) * min(1.0, end)
        s = self.density(x)
        return float(np.log(s[0] / s[1]) / np.log(x[0] / x[1])) if (s > 0).all() else 0.0

    def _smooth(self, function, start, stop, so_far=0.0):
        """Integral by bisection: on a logarithmic axis, and on a linear axis above x = 1."""
        logarithmic = math.log(min(stop, 1.0)) if start < 1 else math.log(stop)
        edges = np.linspace(math.log(start), logarithmic, max(2, math.ceil(2 * (logarithmic - math.log(start)))))
        total = _adaptive(lambda u: function(np.exp(u)) * np.exp(u), edges, self.rtol, so_far)
        if start < 1 < stop:
            humps = np.linspace(1.0, stop, max(2, math.ceil(stop)))
            total += _adaptive(function, humps, self.rtol, so_far + total)
        return total

    def _tail(self, start, end, so_far):
        if math.isinf(end):
            end = self._far(start, so_far)
        steady = 0.375 * self._smooth(self.envelope, start, end, so_far)
        waves = 0.0
        a = start
        while a < end:
            b = min(8 * a, end)
            value, left = self._waves(a, b)
            waves += value
            # What oscillates beyond b is at most the envelope there, over its pace, and twice that.
            if left < 0.1 * self.rtol * (so_far + steady) and self.n is None:
                break
            a = b
        return steady + waves

    def _far(self, start, so_far):
        """Frequency beyond which the rest of an unbounded density is negligible."""
        x = start * 10.0 ** np.arange(0, 2 * math.log10(_LARGEST_X) + 1, 0.5)
        share = self.envelope(x) * x
        done = np.flatnonzero(share <= 1e-3 * self.rtol * max(so_far, share[0]))
        assert len(done), "the integral diverges at f = ∞"
        return float(x[done[0]])

    def _waves(self, a, b):
        """∫ envelope·(cos(4x)/8 − cos(2x)/2), and a bound of the rest."""
        # In units of a and of the envelope there: where the parts cancel, QUADPACK's tolerance is absolute.

        def envelope(u):
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


def _adaptive(function, edges, rtol, so_far):
    """Integral over the intervals between the edges, by repeated halving of all inaccurate intervals at once."""
    left, right = edges[:-1], edges[1:]
    done = 0.0
    nodes = np.concatenate((-_NODES, _NODES[-2::-1]))
    kronrod = np.concatenate((_KRONROD, _KRONROD[-2::-1]))
    gauss = np.concatenate((_GAUSS, _GAUSS[-2::-1]))
    for _ in range(_MOST_HALVINGS):
        half = (right - left) / 2
        x = (left + right)[:, None] / 2 + half[:, None] * nodes
        values = function(x.ravel()).reshape(x.shape)
        parts, coarse = values @ kronrod * half, values @ gauss * half
        allowed = rtol * (abs(so_far) + abs(done + float(parts.sum())))
        # Shared among all: a thousand intervals with a thousandth each.
        wrong = np.abs(parts - coarse) > np.maximum(0.1 * allowed / len(edges), 1e-15 * np.abs(parts))
        done += float(parts[~wrong].sum())
        if not wrong.any():
            return done
        middle = (left[wrong] + right[wrong]) / 2
        left, right = np.concatenate((left[wrong], middle)), np.concatenate((middle, right[wrong]))
        if len(left) > _MOST_INTERVALS:
            break
    else:
        if float(np.abs(parts[wrong]).sum()) < allowed:  # a step: halved until nothing was left of it
            return done + float(parts[wrong].sum())
    raise AssertionError("the density is too rough")
