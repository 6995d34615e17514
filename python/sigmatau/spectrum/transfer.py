"""Filter that shaped white noise into a spectrum, eq. (2) of the paper.

The output of a linear filter H driven by white noise of density N² has the density |H|²·N². It determines the magnitude
of H, but not its phase. Among all filters with this magnitude the minimum-phase filter has the least delay and a stable
causal inverse. Its phase follows from the magnitude at all frequencies (Kolmogorov, Bode) by the cepstrum: the causal
part of the inverse transform of ln|H|.

References
----------
.. [1] A. V. Oppenheim, R. W. Schafer, "Discrete-Time Signal Processing," 3rd ed., 2010, chapters 12 and 13.
.. [2] A. Papoulis, S. U. Pillai, "Probability, Random Variables and Stochastic Processes," 4th ed., 2002, section 11-1.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.distributions import digamma
from sigmatau.arrays import Floats, freeze
from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.results import Printed, plain
from sigmatau.spectrum.result import Spectrum

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sigmatau.plot.style import Panels


_DENSITY_FLOOR = 1e-12
"""Smallest density relative to the largest; lower ones are raised to it, because 0 has no logarithm."""


@frozen(eq=False)
class MinimumPhase(Printed):
    """A filter with the magnitude of a spectrum and the phase of the minimum-phase filter.

    The phase is an assumption: a spectrum cannot distinguish this filter from one with the same magnitude and more
    delay. The anti-alias filter of a sensor, made of analogue poles or averages, is nearly always minimum-phase
    except for a delay.

    Attributes
    ----------
    channel : str
    frequency : ndarray, shape (n_f,)
        Frequencies from 0 to half the sampling rate. [Hz]
    magnitude : ndarray, shape (n_f,)
        |H|. [1, or unit of the output over that of the input]
    low, high : ndarray, shape (n_f,)
        95 % interval of |H| (after any smoothing), by χ²; NaN below `measured_from`. [as `magnitude`]
    phase : ndarray, shape (n_f,)
        Phase of the minimum-phase filter, unwrapped, 0 at 0. [rad]
    impulse : ndarray, shape (n_taps,)
        Impulse response in samples: the output is its convolution with the input. [as `magnitude`]
    input_density : float
        Two-sided density N² of the white input. [`input_unit`]
    input_unit : str
        Unit of the output squared, per hertz.
    measured_from : float
        Lowest frequency of the spectrum; the magnitude is constant below it. [Hz]
    tau0 : float
        Sample interval. [s]

    See Also
    --------
    sigmatau.transfer : makes it.
    """

    channel: str
    frequency: Floats
    magnitude: Floats
    low: Floats
    high: Floats
    phase: Floats
    impulse: Floats
    input_density: float
    input_unit: str
    measured_from: float
    tau0: float

    def __post_init__(self) -> None:
        freeze(self, "frequency", "magnitude", "low", "high", "phase", "impulse", dtype=np.float64)

    @property
    def corner(self) -> float | None:
        """Lowest frequency at which |H|² is half of its value at the lowest frequency. [Hz]"""
        below = np.flatnonzero(self.magnitude**2 < 0.5 * self.magnitude[0] ** 2)
        return float(self.frequency[below[0]]) if len(below) else None

    def to_dict(self) -> dict[str, Any]:
        """Plain columns, for JSON or any data-frame library."""
        low, high = ([None if math.isnan(x) else x for x in end.tolist()] for end in (self.low, self.high))
        fields = "channel frequency_hz=frequency magnitude phase_rad=phase impulse input_density input_unit"
        assumed = {"level": 0.95, "phase": "minimum phase, by assumption", "sided": "two"}
        return plain(self, fields, "measured_from_hz=measured_from tau0_s=tau0", low=low, high=high, **assumed)

    def plot(self, ax: Panels = None) -> Figure:
        """Draw the magnitude with its 95 % interval, and the phase of the minimum-phase filter.

        Parameters
        ----------
        ax : matplotlib axes, or sequence of two, optional
            For the magnitude and the phase. Default: a new figure.

        Returns
        -------
        matplotlib figure
        """
        from sigmatau.plot.curves import COLOURS
        from sigmatau.plot.style import label_axes, parent_figure, two_panels

        upper, lower = two_panels(ax)
        f = self.frequency[1:]
        upper.fill_between(f, self.low[1:], self.high[1:], color=COLOURS[0], alpha=0.25, linewidth=0)
        upper.loglog(f, self.magnitude[1:], color=COLOURS[0], linewidth=1.1)
        label_axes(upper, "", f"|H(f)| of {self.channel}")
        lower.semilogx(f, np.degrees(self.phase[1:]), color=COLOURS[0], linewidth=1.1)
        label_axes(lower, "frequency [Hz]", "phase [deg],\nminimum phase assumed")
        return parent_figure(upper)

    def __repr__(self) -> str:
        corner = "" if self.corner is None else f", half power at {self.corner:.4g} Hz"
        head = f"{self.channel}: |H(f)| for a white input of {self.input_density:.4g} {self.input_unit} (two-sided){corner}"
        head += "; phase of the minimum-phase filter, by assumption"
        shown = np.unique(np.round(np.geomspace(1, len(self.frequency) - 1, 10)).astype(int))
        rows = []
        for k in shown:
            interval = (
                f"[{self.low[k]:.4f}, {self.high[k]:.4f}]" if not np.isnan(self.low[k]) else "not measured, assumed"
            )
            phase = f"phase {np.degrees(self.phase[k]):+8.1f} deg"
            rows.append(f"  {self.frequency[k]:10.4g} Hz  |H| {self.magnitude[k]:.4f} {interval:22}  {phase}")
        taps = ", ".join(f"{h:.4g}" for h in self.impulse[:8])
        return "\n".join([head, *rows, f"  impulse response {taps}, … ({len(self.impulse)} samples)"])


def transfer(
    spectrum: Spectrum, *, random_walk: float | None = None, per_octave: int | None = None, taps: int | None = None
) -> MinimumPhase:
    """|H(f)| of the filter that shaped white noise into a spectrum, eq. (2), and the minimum-phase filter with this
    magnitude.

    Parameters
    ----------
    spectrum : Spectrum
        Welch's spectrum of the output, at even steps up to half the sampling rate.
    random_walk : float, optional
        N of the white input, whose two-sided density is N². Default: that of the output in the lowest hundredth of the band,
        so that H(0) = 1. [unit·√s]
    per_octave : int, optional
        Bins per octave by which the magnitude is smoothed before the phase is computed. Default: no smoothing; errors of
        single frequencies then spread over all taps of the impulse response.
    taps : int, optional
        Length of the impulse response. Default: half that of the spectrum's segments.

    Returns
    -------
    MinimumPhase

    Raises
    ------
    OptionError
        For a multitaper spectrum, which lacks frequencies, or an impossible random walk or length.
    DataError
        If the density is 0 everywhere.

    See Also
    --------
    psd : the spectrum of a record.

    Notes
    -----
    The mean logarithm of a χ² density is too small by ln(ν/2) − ψ(ν/2), which is corrected. The density is
    constant below the first frequency. The result describes the sampled sequence: aliased noise is part of the magnitude.
    Welch's taper reduces the depth of zeros, for example of a digital Butterworth filter at half the sampling rate.

    References
    ----------
    Eq. (2) of :doi:`10.1109/TIM.2007.908635`: S_out = H·S_in·H*; for a single channel |H|²·S_in.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": st.ChannelModel(
    ...     terms={"random_walk": 1e-4}, bandwidth=st.LowPass(order=2, corner=20.0))})
    >>> spectrum = st.psd(st.simulate(model, duration=600, rate=100, rng=1))["gyro_x"]
    >>> bool(st.transfer(spectrum, per_octave=4).magnitude[-1] < 0.3)
    True
    """
    if spectrum.method != "welch":
        raise OptionError("{option} must be Welch's, at even steps up to half the sampling rate", option="spectrum")
    step = float(spectrum.frequency[1] - spectrum.frequency[0])
    length = round(1 / (step * spectrum.tau0))
    first = round(float(spectrum.frequency[0]) / step)
    if length % 2 or len(spectrum.frequency) != length // 2 + 1 - first:
        raise OptionError("{option} must have all frequencies of an even number of samples", option="spectrum")
    if taps is None:
        taps = length // 2
    if not 1 <= taps <= length // 2:
        raise OptionError(f"{{option}} must be 1 to {length // 2}, not {taps!r}", option="taps")
    if not (spectrum.density > 0).any():
        raise DataError(f"{spectrum.channel}: the density is 0, and has no filter")
    if random_walk is None:
        count = max(4, len(spectrum.density) // 100)
        white = float(spectrum.density[:count].mean())
    elif np.isfinite(random_walk) and random_walk > 0:
        white = float(random_walk) ** 2
    else:
        raise OptionError(f"{{option}} must be a positive number, not {random_walk!r}", option="random_walk")
    smooth, low, high = _smoothed(spectrum, per_octave)
    frequency = np.arange(length // 2 + 1) / (length * spectrum.tau0)
    power = np.concatenate((np.full(first, smooth[0]), smooth)) / white
    # Frequencies that were not measured have no interval.
    below, above = (np.concatenate((np.full(first, np.nan), edge)) / white for edge in (low, high))
    magnitude = np.sqrt(power)
    floor = np.maximum(power, _DENSITY_FLOOR * power.max())
    minimum = _minimum_phase(0.5 * np.log(floor))
    impulse = np.fft.irfft(minimum, length)[:taps]
    return MinimumPhase(
        channel=spectrum.channel,
        frequency=frequency,
        magnitude=magnitude,
        low=np.sqrt(below),
        high=np.sqrt(above),
        phase=np.unwrap(np.angle(minimum)),
        impulse=impulse,
        input_density=white,
        input_unit=spectrum.density_unit,
        measured_from=float(spectrum.frequency[0]),
        tau0=spectrum.tau0,
    )


def _smoothed(spectrum: Spectrum, per_octave: int | None) -> tuple[Floats, Floats, Floats]:
    """The density, corrected for the bias of its logarithm, and its interval."""
    shown = spectrum if per_octave is None else spectrum.binned(per_octave=per_octave)
    half = np.maximum(shown.dof, 1.0) / 2
    floor = _DENSITY_FLOOR * shown.density.max()
    logarithms = [np.log(np.maximum(shown.density, floor)) + np.log(half) - digamma(half)]
    logarithms += [np.log(np.maximum(edge, floor)) for edge in shown.interval()]
    if per_octave is not None:
        # Between two bins their mean scatters less than either: the interval is conservative.
        log_frequency, bins = np.log(spectrum.frequency), np.log(shown.frequency)
        logarithms = [np.interp(log_frequency, bins, column) for column in logarithms]
    middle, low, high = (np.exp(column) for column in logarithms)
    return middle, low, high


def _minimum_phase(logarithm: Floats) -> NDArray[np.complex128]:
    """Minimum-phase H from ln|H| at even steps up to half the sampling rate: twice the causal part of the cepstrum."""
    length = 2 * (len(logarithm) - 1)
    cepstrum = np.fft.irfft(logarithm, length)
    cepstrum[1 : length // 2] *= 2
    cepstrum[length // 2 + 1 :] = 0
    return np.exp(np.fft.rfft(cepstrum))
