"""Cross-spectrum, coherence, phase and transfer of two channels."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.distributions import student_quantile
from sigmatau.arrays import Floats, freeze
from sigmatau.digits import round_to_error
from sigmatau.errors import DataError, OptionError, RecordTooShortError
from sigmatau.frozen import frozen
from sigmatau.record.record import Record, need_record
from sigmatau.record.streams import Stream
from sigmatau.results import Printed, plain
from sigmatau.spectrum import coherence as law
from sigmatau.spectrum.estimate import (
    batches,
    longest_run,
    segment_size,
    segment_starts,
    slope,
    tapered,
    tapered_bins,
    tapered_grid,
    transforms,
    used_samples,
    welch_grid,
)
from sigmatau.spectrum.estimate import default_size as default_segment
from sigmatau.spectrum.result import Method
from sigmatau.spectrum.tapers import bin_starts, hann, levelled, variance_increase

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sigmatau.plot.style import Panels

Complexes = NDArray[np.complex128]


@frozen(eq=False)
class CrossSpectrum(Printed):
    """Cross-spectrum of two channels; two-sided densities.

    Attributes
    ----------
    a, b : str
        Channels; a is the input of the transfer.
    unit_a, unit_b : str
        Quantities of both channels.
    frequency : ndarray, shape (n_f,)
        Positive, up to half the sampling rate. [Hz]
    density_a, density_b : ndarray, shape (n_f,)
        Two-sided density of each channel. [unit²/Hz]
    cross : ndarray of complex, shape (n_f,)
        Two-sided cross density E[A*·B]; its phase is that of b relative to a. [unit_a·unit_b/Hz]
    dof : ndarray, shape (n_f,)
        Degrees of freedom of each density, twice the number of independent pairs that were averaged.
    resolution : float
        [Hz]
    segments : int
        Segments averaged, or tapers.
    n, tau0 : int, float
        Samples in the record, and their interval. [s]
    method : {"welch", "multitaper"}

    See Also
    --------
    cross_spectrum : makes it.

    Examples
    --------
    >>> import sigmatau as st
    >>> channels = {"gyro_x": {"random_walk": 1e-4}, "gyro_y": {"random_walk": 1e-4}}
    >>> model = st.NoiseModel(channels=channels, correlation={"random_walk": {("gyro_x", "gyro_y"): 0.9}})
    >>> cross = st.cross_spectrum(st.simulate(model, duration=600, rate=100, rng=1), "gyro_x", "gyro_y")
    >>> float(cross.coherence.mean().round(1))  # the square of the correlation
    0.8
    """

    a: str
    b: str
    unit_a: str
    unit_b: str
    frequency: Floats
    density_a: Floats
    density_b: Floats
    cross: Complexes
    dof: Floats
    resolution: float
    segments: int
    n: int
    tau0: float
    method: Method = "welch"

    def __post_init__(self) -> None:
        freeze(self, "frequency", "density_a", "density_b", "cross", "dof")

    @property
    def coherence(self) -> Floats:
        """γ² = |S_ab|²/(S_a·S_b), from 0 to 1: the share of b's power that a linear filter of a explains; shape (n_f,).

        This is the measured value: its mean for independent channels is 2/dof, not 0.
        """
        power = self.density_a * self.density_b
        return np.asarray(np.where(power > 0, np.abs(self.cross) ** 2 / np.where(power > 0, power, 1.0), 0.0))

    @property
    def phase(self) -> Floats:
        """Phase of b relative to a, −π … π; negative where b lags; shape (n_f,). [rad]"""
        return np.asarray(np.angle(self.cross))

    @property
    def transfer(self) -> Complexes:
        """Linear least-squares filter from a to b, S_ab/S_a; complex, shape (n_f,). [unit_b/unit_a]

        Measurement noise of a reduces it, by the share of that noise in S_a.
        """
        power = np.where(self.density_a > 0, self.density_a, np.inf)
        return np.asarray(self.cross / power)

    def significance(self, *, level: float = 0.95) -> Floats:
        """Coherence that independent channels exceed with probability 1 − `level`.

        It follows from the distribution for independent pairs. Neighbouring frequencies of tapers are correlated, and
        are approximated by dof/2 independent pairs; the error of the level is below half a percent.

        Parameters
        ----------
        level : float
            Probability, between 0 and 1.

        Returns
        -------
        ndarray, shape (n_f,)
            Coherence, from 0 to 1.

        Raises
        ------
        OptionError
            For a level that is not between 0 and 1.
        """
        _check(level)
        return law.significance(self.dof / 2, level=level)

    def coherence_interval(self, *, level: float = 0.95) -> tuple[Floats, Floats]:
        """Confidence interval of the true coherence, by its exact distribution.

        The lower end is 0 if the coherence is not significant.

        Parameters
        ----------
        level : float
            Probability, between 0 and 1.

        Returns
        -------
        low, high : ndarray, shape (n_f,)
            Coherence, from 0 to 1.

        Raises
        ------
        OptionError
            For a level that is not between 0 and 1.
        """
        _check(level)
        return law.interval(self.coherence, self.dof / 2, level=level)

    def _spread(self, level: float) -> Floats:
        """Half width of the interval of the real and imaginary parts of the transfer, relative to its magnitude, by
        Student's t.
        """
        _check(level)
        free = np.maximum(self.dof - 2, 0.0)
        gamma2 = np.clip(self.coherence, 1e-300, 1.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            wide = student_quantile(np.maximum(free, 1e-3), (1 + level) / 2) * np.sqrt((1 - gamma2) / gamma2 / free)
        return np.asarray(np.where(free > 0, wide, np.inf))

    def gain_interval(self, *, level: float = 0.95) -> tuple[Floats, Floats]:
        """Confidence interval of the magnitude of the transfer.

        Parameters
        ----------
        level : float
            Probability, between 0 and 1.

        Returns
        -------
        low, high : ndarray, shape (n_f,)
            [unit_b/unit_a]

        Raises
        ------
        OptionError
            For a level that is not between 0 and 1.
        """
        gain, spread = np.abs(self.transfer), self._spread(level)
        return np.asarray(gain * np.maximum(1 - spread, 0.0)), np.asarray(gain * (1 + spread))

    def phase_interval(self, *, level: float = 0.95) -> tuple[Floats, Floats]:
        """Confidence interval of the phase, ±π if the phase is unknown.

        Parameters
        ----------
        level : float
            Probability, between 0 and 1.

        Returns
        -------
        low, high : ndarray, shape (n_f,)
            [rad]

        Raises
        ------
        OptionError
            For a level that is not between 0 and 1.
        """
        spread = self._spread(level)
        wide = np.where(spread < 1, np.arcsin(np.minimum(spread, 1.0)), np.pi)
        return self.phase - wide, self.phase + wide

    def binned(self, *, per_octave: int = 8) -> CrossSpectrum:
        """The cross-spectrum with neighbouring frequencies averaged.

        A phase that changes within a bin, for example by a delay, reduces the coherence.

        Parameters
        ----------
        per_octave : int
            Bins per octave.

        Returns
        -------
        CrossSpectrum
        """
        starts = bin_starts(self.frequency, per_octave)
        count = np.diff(np.append(starts, len(self.frequency)))
        frequency, density_a, by_a = levelled(self.density_a, self.frequency, starts)
        _, density_b, by_b = levelled(self.density_b, self.frequency, starts)
        dof = np.add.reduceat(self.dof, starts) / (
            1 + variance_increase(count, method=self.method, tapers=self.segments)
        )
        level = np.sqrt(by_a * by_b)
        real, imaginary = (np.add.reduceat(part * level, starts) / count for part in (self.cross.real, self.cross.imag))
        return replace(
            self, frequency=frequency, density_a=density_a, density_b=density_b, cross=real + 1j * imaginary, dof=dof
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain columns, for JSON or any data-frame library."""
        low, high = self.coherence_interval()
        gain_low, gain_high = self.gain_interval()
        begin, end = self.phase_interval()
        fields = (
            "a b frequency_hz=frequency density_a density_b coherence phase_rad=phase dof method segments unit_a unit_b"
        )
        intervals = {"coherence_low": low, "coherence_high": high, "phase_low_rad": begin, "phase_high_rad": end}
        gain = {
            "gain": np.abs(self.transfer),
            "gain_low": gain_low,
            "gain_high": [g if np.isfinite(g) else None for g in gain_high.tolist()],
        }
        cross = {"cross_real": self.cross.real, "cross_imaginary": self.cross.imag, "significance": self.significance()}
        return plain(self, fields, "resolution_hz=resolution", **cross, **gain, **intervals, sided="two", level=0.95)

    def plot(self, ax: Panels = None, *, per_octave: int = 8) -> Figure:
        """Draw the coherence with its significance level, and the phase where the coherence is significant.

        Parameters
        ----------
        ax : matplotlib axes, or sequence of two, optional
            For the coherence and the phase. Default: a new figure.
        per_octave : int
            Bins per octave.

        Returns
        -------
        matplotlib figure
        """
        from sigmatau.plot.curves import COLOURS
        from sigmatau.plot.style import label_axes, legend, parent_figure, two_panels

        upper, lower = two_panels(ax)
        bands = self.binned(per_octave=per_octave)
        f, level = bands.frequency, bands.significance()
        upper.fill_between(f, *bands.coherence_interval(), color=COLOURS[0], alpha=0.25, linewidth=0)
        upper.semilogx(f, bands.coherence, color=COLOURS[0], linewidth=1.2)
        upper.semilogx(f, level, color="0.4", linewidth=0.9, linestyle="--", label="95 % limit of chance")
        upper.set_ylim(0, 1)
        label_axes(upper, "", f"coherence γ² of {self.a} and {self.b}")
        legend(upper)
        significant = bands.coherence > level
        begin, end = (np.degrees(edge) for edge in bands.phase_interval())
        phase = np.degrees(bands.phase)
        errors = np.array([phase - begin, end - phase])[:, significant]
        look: dict[str, Any] = {"fmt": "o", "markersize": 2.5, "linewidth": 0.8, "color": COLOURS[0]}
        lower.errorbar(f[significant], phase[significant], errors, **look)
        lower.set_ylim(-190, 190)
        lower.set_yticks([-180, -90, 0, 90, 180])
        label_axes(lower, "frequency [Hz]", f"phase of {self.b} [deg]")
        return parent_figure(upper)

    def __repr__(self) -> str:
        kind = "sine tapers" if self.method == "multitaper" else "segments"
        head = (
            f"{self.a} and {self.b}: coherence γ², gain and phase of {self.b} relative to {self.a}, {self.segments} {kind},"
            f" resolution {self.resolution:.3g} Hz; 95 % intervals, * significant at 5 %"
        )
        bands = self.binned(per_octave=1)
        low, high = bands.coherence_interval()
        level, spread = bands.significance(), bands._spread(0.95)
        lines = [head]
        for k, f in enumerate(bands.frequency):
            mark = "*" if bands.coherence[k] > level[k] else " "
            line = f"  {f:10.4g} Hz  γ² {bands.coherence[k]:.4f} [{low[k]:.4f}, {high[k]:.4f}]{mark}"
            if spread[k] < 1:
                wide = np.degrees(np.arcsin(spread[k]))
                gain = abs(bands.transfer[k])
                line += f"  gain {round_to_error(gain, error=gain * spread[k]).text}"
                line += f"  phase {round_to_error(np.degrees(bands.phase[k]), error=wide, sign='+').text} deg"
            lines.append(line)
        return "\n".join(lines)


def cross_spectrum(
    record: Record | Stream,
    a: str,
    b: str,
    *,
    method: Method = "welch",
    segment: float | None = None,
    tapers: int = 8,
    f_max: float | None = None,
) -> CrossSpectrum:
    """Cross-spectrum, coherence and transfer of two channels of a record.

    Parameters
    ----------
    record : Record or Stream
        Static data. Welch's segments with a missing sample of either channel are omitted; the multitaper estimate uses the
        longest run without a missing sample.
    a, b : str
        Channels, sampled together: of one stream, or of two with the same number of samples and interval.
    method, segment, tapers, f_max
        See `sigmatau.psd`.

    Returns
    -------
    CrossSpectrum

    Raises
    ------
    OptionError
        As `sigmatau.psd`; for a channel with itself.
    DataError
        If the channels are not sampled together, or a stream does not have them.
    KeyError
        If a record does not have the channels.
    RecordTooShortError
        If too few segments have all samples of both channels.

    See Also
    --------
    psd : spectra of single channels.

    References
    ----------
    J. S. Bendat, A. G. Piersol, "Random Data," 4th ed., Wiley 2010, chapters 5 and 9.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}, "gyro_y": {"random_walk": 1e-4}})
    >>> cross = st.cross_spectrum(st.simulate(model, duration=60, rate=100, rng=1), "gyro_x", "gyro_y")
    >>> bool((cross.coherence > 0.5).any())
    False
    """
    need_record(record, stream=True)
    if method not in ("welch", "multitaper"):
        raise OptionError(f"{{option}} must be welch or multitaper, not {method!r}", option="method")
    if a == b:
        raise OptionError(f"`a` and {{option}} are both {a!r}; a cross-spectrum is that of two channels", option="b")
    first, second = _stream(record, a), _stream(record, b)
    grid = first.grid
    if (grid.n, grid.tau0) != (second.grid.n, second.grid.tau0):
        raise DataError(
            f"{a} and {b} are not sampled together: {grid.n} samples every {grid.tau0:g} s, and {second.grid.n} every"
            f" {second.grid.tau0:g} s; a cross-spectrum needs samples of the same times"
        )
    x, y = np.ascontiguousarray(first.column(a)), np.ascontiguousarray(second.column(b))
    gaps = first.mask is not None or second.mask is not None
    if method == "welch":
        parts = _welch(x, y, grid.tau0, size=segment_size(segment, first), gaps=gaps, what=f"{a} and {b}")
    else:
        parts = _tapered(x, y, grid.tau0, tapers=tapers, f_max=f_max, what=f"{a} and {b}")
    frequency, density_a, density_b, cross, dof, resolution, segments = parts
    if float(dof.max()) <= 2.5:
        raise RecordTooShortError(
            f"{a} and {b}: a single segment always has the coherence 1; take shorter ones, or more tapers",
            need=2,
            got=1,
        )
    return CrossSpectrum(
        a=a,
        b=b,
        unit_a=first.unit,
        unit_b=second.unit,
        frequency=frequency,
        density_a=density_a,
        density_b=density_b,
        cross=cross,
        dof=dof,
        resolution=resolution,
        segments=segments,
        n=grid.n,
        tau0=grid.tau0,
        method=method,
    )


_Parts = tuple[Floats, Floats, Floats, Complexes, Floats, float, int]


def _welch(x: Floats, y: Floats, tau0: float, *, size: int | None, gaps: bool, what: str) -> _Parts:
    length = size or default_segment(len(x))
    both = x + y  # missing if either is missing
    starts = segment_starts(both, length, gaps=gaps)
    while size is None and len(starts) < 15 and length >= 128:
        length //= 2
        starts = segment_starts(both, length, gaps=gaps)
    if not len(starts):
        raise RecordTooShortError(f"{what} have no {length} consecutive samples in common", need=length, got=len(x))
    taper = hann(length)
    ramps = [slope(z, gaps=gaps) * (np.arange(length) - (length - 1) / 2) * taper for z in (x, y)]
    size_f = length // 2 + 1
    sums_a, sums_b, crossed = np.zeros(size_f), np.zeros(size_f), np.zeros(size_f, dtype=np.complex128)
    for some in batches(starts, length):
        transforms_x, transforms_y = transforms(x, some, taper, ramps[0]), transforms(y, some, taper, ramps[1])
        sums_a += (np.abs(transforms_x) ** 2).sum(axis=0)
        sums_b += (np.abs(transforms_y) ** 2).sum(axis=0)
        crossed += (transforms_x.conj() * transforms_y).sum(axis=0)
    scale = tau0 / (float(taper @ taper) * len(starts))
    frequency, dof = welch_grid(starts, length, tau0)
    return (
        frequency,
        scale * sums_a[2:],
        scale * sums_b[2:],
        scale * crossed[2:],
        dof,
        1.5 / (length * tau0),
        len(starts),
    )


def _tapered(x: Floats, y: Floats, tau0: float, *, tapers: int, f_max: float | None, what: str) -> _Parts:
    run = longest_run(x + y)
    x, y = x[run], y[run]
    used = used_samples(len(x), tapers, what)
    bins = tapered_bins(used, tau0, f_max)
    density_a, density_b, cross = np.zeros(bins), np.zeros(bins), np.zeros(bins, dtype=np.complex128)
    for tapered_x, tapered_y in zip(tapered(x[:used], bins, tapers), tapered(y[:used], bins, tapers), strict=True):
        density_a += np.abs(tapered_x) ** 2
        density_b += np.abs(tapered_y) ** 2
        cross += tapered_x.conj() * tapered_y
    scale = tau0 / tapers
    frequency, dof, resolution = tapered_grid(used, bins, tapers, tau0)
    return frequency, scale * density_a, scale * density_b, scale * cross, dof, resolution, tapers


def _stream(record: Record | Stream, channel: str) -> Stream:
    if isinstance(record, Record):
        return record.stream_of(channel)
    if channel not in record.channels:
        raise DataError(f"no channel {channel!r}; channels: {', '.join(record.channels)}")
    return record


def _check(level: float) -> None:
    if not 0 < level < 1:
        raise OptionError(f"{{option}} must be between 0 and 1, not {level!r}", option="level")
