"""Eq. (11) of the paper for any density: sampled or a function, of one channel or the matrix of several."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from sigmatau.arrays import Floats, freeze
from sigmatau.digits import significant
from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.model.density_pieces import Between, Pieces
from sigmatau.model.density_sources import FunctionDensity, SampledDensity, channel_densities
from sigmatau.model.processes import real
from sigmatau.model.transform import Density
from sigmatau.results import Printed, plain

Sided = Literal["one", "two"]

_PEAK = 1.1655611852072113 / math.pi
"""Product f·T at which sin⁴(πfT)/(πfT)² is largest: tan x = 2x."""

_PER_OCTAVE = 2  # default number of averaging times per octave
# number of doublings of the frequency above the band, after which sin⁴ is replaced by its mean 3/8
_DOUBLINGS = 50
_SMALL = 1e-6  # x = πfT below which sin⁴x = x⁴ to 10⁻¹²


@frozen(eq=False)
class AvarFromPsd(Printed):
    """Allan variances from a density within its band, and bounds on the contribution from outside the band.

    Attributes
    ----------
    tau : ndarray, shape (n_tau,)
        Averaging times. [s]
    avar : ndarray, shape (n_tau,) or (n_tau, n, n)
        Allan variances of the band; for n channels, the Allan covariances. [unit²]
    below, above : ndarray, shape of `avar`
        Largest contribution of the frequencies below and above the band, for a density that does not exceed the laws of
        `slope_below` and `slope_above`. For n channels, the largest change of an element. [unit²]
    f_min, f_max : float
        The band. [Hz]
    slope_below, slope_above : float
        Outside the band the density is at most S(f_min)·(f/f_min)^slope_below and S(f_max)·(f/f_max)^slope_above. [1]
    tau0 : float or None
        Sample interval, if the density is that of samples. [s]

    See Also
    --------
    avar_from_psd : makes it.

    Examples
    --------
    >>> import sigmatau as st
    >>> st.avar_from_psd([0.01, 50.0], [1e-8, 1e-8], [1.0, 10.0], sided="two")
    Allan deviation of a density from 0.01 to 50 Hz
           τ [s]              σ   at most, with noise outside the band
               1      9.985e-05       0.0001000
              10      3.142e-05       3.203e-05
      outside: below 0.01 Hz no steeper than f^-2, above 50 Hz no steeper than f^0
    """

    tau: Floats
    avar: Floats
    below: Floats
    above: Floats
    f_min: float
    f_max: float
    slope_below: float
    slope_above: float
    tau0: float | None = None

    def __post_init__(self) -> None:
        freeze(self, "tau", "avar", "below", "above", dtype=np.float64)

    @property
    def adev(self) -> Floats:
        """Allan deviations of the band, shape (n_tau,); for n channels (n_tau, n). [unit]"""
        return np.asarray(np.sqrt(channel_densities(self.avar)))

    @property
    def adev_at_most(self) -> Floats:
        """Allan deviations with the largest possible contribution of the rest of the density; shape of `adev`. [unit]"""
        return np.asarray(np.sqrt(channel_densities(self.avar + self.below + self.above)))

    @property
    def correlation(self) -> Floats:
        """Correlations of the channels at each averaging time, shape (n_tau, n, n); 1 for one channel. [1]"""
        if self.avar.ndim == 1:
            return np.ones((len(self.tau), 1, 1))
        scale = self.adev[:, :, None] * self.adev[:, None, :]
        return np.divide(self.avar, scale, out=np.zeros_like(self.avar), where=scale > 0)

    def to_dict(self) -> dict[str, Any]:
        """Plain columns, for JSON or any data-frame library."""
        band = plain(self, "f_min_hz=f_min f_max_hz=f_max slope_below slope_above")
        return plain(self, "tau_s=tau avar below above adev adev_at_most tau0_s=tau0") | band

    def __repr__(self) -> str:
        several = self.avar.ndim > 1
        head = f"Allan deviation of a density from {self.f_min:.6g} to {self.f_max:.6g} Hz"
        lines = [head, f"  {'τ [s]':>10}  {'σ':>13}   at most, with noise outside the band"]
        if several:
            lines = [
                f"{head}, {self.avar.shape[1]} channels",
                f"  {'τ [s]':>10}  σ of each channel; their correlations",
            ]
        for k, tau in enumerate(self.tau.tolist()):
            if several:
                rows, columns = np.triu_indices(self.avar.shape[1], 1)
                deviations = "  ".join(f"{value:.4g}" for value in self.adev[k])
                pairs = "  ".join(f"{value:+.3f}" for value in self.correlation[k][rows, columns])
                lines.append(f"  {tau:10.4g}  {deviations};  {pairs}")
            else:
                value, limit = (significant(float(x[k]), 4, zeros=True) for x in (self.adev, self.adev_at_most))
                lines.append(f"  {tau:10.4g}  {value:>13}  {limit:>14}")
        return "\n".join([*lines, f"  outside: {self.outside}"])

    @property
    def outside(self) -> str:
        """The assumption about the density outside the band."""
        parts = []
        if self.f_min > 0:
            parts.append(f"below {self.f_min:.6g} Hz no steeper than f^{self.slope_below:g}")
        if math.isfinite(self.f_max) and (self.tau0 is None or self.f_max < 0.5 / self.tau0 * (1 - 1e-9)):
            parts.append(f"above {self.f_max:.6g} Hz no steeper than f^{self.slope_above:g}")
        return ", ".join(parts) or "nothing"


def avar_from_psd(
    frequency: ArrayLike,
    density: ArrayLike | Density,
    tau: ArrayLike | None = None,
    *,
    sided: Sided,
    tau0: float | None = None,
    between: Between | None = None,
    slope_below: float = -2.0,
    slope_above: float = 0.0,
) -> AvarFromPsd:
    """Allan variance of noise with any density, by eq. (11), with bounds on the error from the limited band.

    Parameters
    ----------
    frequency : array_like, shape (n_f,)
        Rising frequencies, above 0, of a sampled density; the two ends of the band of a function, 0 and infinity included.
        [Hz]
    density : array_like, shape (n_f,) or (n_f, n, n), or callable
        Power spectral density of the rate at these frequencies, or a function that takes frequencies of shape (n_f,) and
        returns it. For n channels, the Hermitian matrix of their densities and cross-densities, S in eq. (2). [unit²/Hz]
    tau : array_like, shape (n_tau,), optional
        Averaging times; with `tau0`, whole multiples of it. Default: two per octave, over the whole band. [s]
    sided : {"one", "two"}
        ``"one"``: positive frequencies have the power of both signs, as in datasheets and, by default, in SciPy's
        `welch`. ``"two"``: the density of the paper, from −∞ to ∞.
    tau0 : float, optional
        Sample interval: the density is that of samples, up to 1/(2·tau0), and the sum over clusters is exact.
        Default: continuous time. [s]
    between : {"power law", "linear"}, optional
        Law of a sampled density between neighbouring points. In matrices, the densities follow this law and the
        coherences change linearly with log f. Default: power law.
    slope_below, slope_above : float
        Assumption about the density outside the band, for the bounds: S(f_min)·(f/f_min)^slope_below and
        S(f_max)·(f/f_max)^slope_above are not exceeded. -2 is a rate random walk, -1 flicker noise, 0 white noise. If the
        density of a channel is equal to these laws, the sum of its `avar`, `below` and `above` is exact. [1]

    Returns
    -------
    AvarFromPsd

    Raises
    ------
    DataError
        For a density that is negative, not finite, or not a Hermitian positive matrix; for frequencies that do not rise; if
        the integral of a function diverges.
    OptionError
        For averaging times that are not positive or are outside the band, a `slope_below` of -3 or less, a `slope_above` of
        1 or more in continuous time, frequencies above 1/(2·tau0).

    See Also
    --------
    psd : density of a record.
    fit_psd : noise terms of a measured density.
    ChannelModel.avar : closed forms for the noise of a model.

    Notes
    -----
    With the two-sided density S, eq. (11) of [1]_ and its form for samples, T = n·τ₀, are ::

        σ²(T) = 4 ∫ S(f)·sin⁴(πfT)/(πfT)² df
        σ²(n) = 4 ∫ S(f)·sin⁴(πfT)/(n²·sin²(πfτ₀)) df

    Between points the integral is exact to rounding. The kernel is even, so that the imaginary parts of cross-densities
    have no effect. The integral of a function is computed to 10⁻¹¹, or to
    10⁻⁶ if it has corners.

    An averaging time T is in the band if f = 0.371/T, where the kernel is largest, is in the band.

    References
    ----------
    .. [1] N. El-Sheimy, H. Hou, X. Niu, "Analysis and modeling of inertial sensors using Allan variance,"
       IEEE Trans. Instrum. Meas., vol. 57, no. 1, 2008, :doi:`10.1109/TIM.2007.908635`.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> f = np.geomspace(1e-4, 100.0, 200)
    >>> measured = 2 * (1e-8 + 1e-11 / f)  # white and flicker noise, one-sided
    >>> curve = st.avar_from_psd(f, measured, [1.0, 100.0], sided="one")
    >>> curve.adev, curve.adev_at_most
    (array([1.00062674e-04, 1.13009455e-05]), array([1.00138589e-04, 1.13029335e-05]))
    >>> st.avar_from_psd((0, np.inf), lambda f: 0 * f + 1e-8, [1.0, 100.0], sided="two").avar  # N²/τ
    array([1.e-08, 1.e-10])
    """
    if sided not in ("one", "two"):
        raise OptionError(f"{{option}} must be 'one' or 'two', not {sided!r}", option="sided")
    if between not in (None, "power law", "linear"):
        raise OptionError(f"{{option}} must be 'power law' or 'linear', not {between!r}", option="between")
    check_interval(tau0)
    factor = 0.5 if sided == "one" else 1.0
    if callable(density):
        if between is not None:
            raise OptionError("{option} is for a sampled density; a function has values everywhere", option="between")
        source: SampledDensity | FunctionDensity = FunctionDensity(frequency, density, factor)
    else:
        source = SampledDensity(frequency, density, factor, between or "power law")
    _check_slopes(slope_below, slope_above, tau0)
    if not callable(density):
        check_nyquist(source.f_max, tau0)
    f_max = source.f_max if tau0 is None else min(source.f_max, 0.5 / tau0)
    times = _times(tau, source.f_min, f_max, tau0)
    avar = source.avar(times, f_max, tau0)
    below, above = (np.zeros((len(times), len(source.edge(0)))) for _ in range(2))
    for k, time in enumerate(times.tolist()):
        if source.f_min > 0:
            below[k] = source.edge(0) * _below(source.f_min, slope_below, time, tau0)
        if math.isfinite(f_max) and (tau0 is None or f_max < 0.5 / tau0 * (1 - 1e-9)):
            above[k] = source.edge(1) * _above(f_max, slope_above, time, tau0)
    return AvarFromPsd(
        tau=times,
        avar=avar,
        below=_elements(below, avar.ndim),
        above=_elements(above, avar.ndim),
        f_min=source.f_min,
        f_max=f_max,
        slope_below=slope_below,
        slope_above=slope_above,
        tau0=tau0,
    )


def _elements(bounds: Floats, dimensions: int) -> Floats:
    """Bounds of the elements of matrices from those of the channels, by the Cauchy-Schwarz inequality."""
    root = np.sqrt(bounds)
    return bounds[:, 0] if dimensions == 1 else root[:, :, None] * root[:, None, :]


def _check_slopes(slope_below: float, slope_above: float, tau0: float | None) -> None:
    if not (math.isfinite(real(slope_below)) and slope_below > -3):
        raise OptionError(
            f"{{option}} must be above -3, not {slope_below!r}: the Allan variance of a steeper density is infinite",
            option="slope_below",
        )
    if not math.isfinite(real(slope_above)) or (slope_above >= 1 and tau0 is None):
        raise OptionError(
            f"{{option}} must be below 1, not {slope_above!r}: eq. (11) is infinite; give `tau0` for samples",
            option="slope_above",
        )


def check_interval(tau0: float | None) -> None:
    """Raise `OptionError` for a sample interval that is not a positive number of seconds."""
    if tau0 is not None and not (isinstance(tau0, int | float) and math.isfinite(tau0) and tau0 > 0):
        raise OptionError(f"{{option}} must be a positive number of seconds, not {tau0!r}", option="tau0")


def check_nyquist(f_max: float, tau0: float | None) -> None:
    """Raise `OptionError` for frequencies above half the sampling rate."""
    if tau0 is not None and f_max > 0.5 / tau0 * (1 + 1e-6):
        raise OptionError(
            f"{{option}}: at {1 / tau0:g} Hz samples have densities up to {0.5 / tau0:g} Hz, but `frequency` goes to"
            f" {f_max:g} Hz",
            option="tau0",
        )


def _times(tau: ArrayLike | None, f_min: float, f_max: float, tau0: float | None) -> Floats:
    """Averaging times, checked against the band; by default the whole band."""
    shortest, longest = _PEAK / f_max, _PEAK / f_min if f_min > 0 else math.inf
    if tau0 is not None:
        shortest = max(shortest, tau0)
    if tau is None:
        if not shortest > 0 or math.isinf(longest):
            raise OptionError("{option} is required: the band of the function is infinite", option="tau")
        count = max(math.floor(_PER_OCTAVE * math.log2(longest / shortest) + 1e-9), 0) + 1
        times = shortest * 2 ** (np.arange(count) / _PER_OCTAVE)
        return times if tau0 is None else np.unique(np.round(times / tau0)) * tau0
    times = np.atleast_1d(np.asarray(tau))
    if times.dtype.kind not in "fiu":
        raise OptionError(f"{{option}} must be positive numbers of seconds, not {tau!r}", option="tau")
    times = times.astype(np.float64)
    if times.ndim != 1 or not len(times) or not (np.isfinite(times) & (times > 0)).all():
        raise OptionError("{option} must be positive numbers of seconds", option="tau")
    if tau0 is not None and (np.abs(np.round(times / tau0) * tau0 - times) > 1e-6 * tau0).any():
        raise OptionError(f"{{option}} must be whole multiples of `tau0`, {tau0:g} s", option="tau")
    outside = times[(times < shortest * (1 - 1e-9)) | (times > longest * (1 + 1e-9))]
    if len(outside):
        raise OptionError(
            f"{{option}} of {outside[0]:g} s is outside the band of the density, which has {shortest:.4g} to"
            f" {longest:.4g} s; take times of the band",
            option="tau",
        )
    return times


def _below(f_min: float, slope: float, time: float, tau0: float | None) -> float:
    """Allan variance of (f/f_min)^slope below f_min."""
    count = max(math.ceil(math.log2(math.pi * f_min * time / _SMALL)), 1)
    f = np.asarray(f_min * 2.0 ** np.arange(-count, 1), dtype=np.float64)
    lowest = float(f[0])
    rest: float = 4 * (lowest / f_min) ** slope * (math.pi * time) ** 2 * lowest**3 / (3 + slope)
    return float(Pieces(f, (f / f_min) ** slope, "power law").integral(time, tau0)) + rest


def _above(f_max: float, slope: float, time: float, tau0: float | None) -> float:
    """Allan variance of (f/f_max)^slope above f_max."""
    end = f_max * 2.0**_DOUBLINGS if tau0 is None else 0.5 / tau0
    count = math.ceil(math.log2(end / f_max)) + 1
    f = np.asarray(np.geomspace(f_max, end, max(count, 2)), dtype=np.float64)
    f[0] = f_max
    rest: float = (
        0.0 if tau0 is not None else 1.5 * (end / f_max) ** slope / (end * (1 - slope) * (math.pi * time) ** 2)
    )
    return float(Pieces(f, (f / f_max) ** slope, "power law").integral(time, tau0)) + rest
