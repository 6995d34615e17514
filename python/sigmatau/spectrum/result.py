"""Spectra and their comparison with models."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.distributions import chi2_quantile_above
from sigmatau.arrays import Floats, freeze, runs
from sigmatau.digits import round_to_error
from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.noise.terms import asked_density
from sigmatau.results import ByChannel, Printed, plain
from sigmatau.spectrum.comparison import ModelComparison
from sigmatau.spectrum.tapers import bin_starts, levelled, line_density, variance_increase
from sigmatau.units import density_text, figure_unit, find, symbols

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from sigmatau.plot.style import Panels

Method = Literal["welch", "multitaper"]

_LINE_SHARE = 1e-3  # share of the model's density above which a line excludes a frequency from the comparison


class HasDensity(Protocol):
    """Attributes of `sigmatau.model.channel.ChannelModel` that a comparison with a density needs."""

    @property
    def unit(self) -> str: ...
    def psd(self, f: Floats, *, tau0: float | None = None) -> Floats: ...


class HasChannels(Protocol):
    """Attributes of `sigmatau.model.noise_model.NoiseModel`: channels by name."""

    @property
    def channels(self) -> Mapping[str, HasDensity]: ...


@frozen(eq=False)
class Spectrum(Printed):
    """Two-sided power spectral density of one channel.

    Attributes
    ----------
    channel : str
    quantity, unit : str
        Quantity and unit of the rate; SI.
    frequency : ndarray, shape (n_f,)
        Positive, up to half the sampling rate. [Hz]
    density : ndarray, shape (n_f,)
        Two-sided: white noise of random walk N has N² at every frequency. [unit²/Hz]
    dof : ndarray, shape (n_f,)
        Degrees of freedom of each density: dof·density/truth is χ² distributed.
    resolution : float
        Frequency resolution. [Hz]
    segments : int
        Segments averaged, or tapers.
    n, tau0 : int, float
        Samples in the record, and their interval. [s]
    method : {"welch", "multitaper"}

    See Also
    --------
    sigmatau.psd : makes it.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> spectrum = st.psd(st.simulate(model, duration=600, rate=100, rng=1))["gyro_x"]
    >>> low, high = spectrum.binned(per_octave=1).interval()
    >>> bool((low < 1e-8).mean() > 0.8)
    True
    """

    channel: str
    quantity: str
    unit: str
    frequency: Floats
    density: Floats
    dof: Floats
    resolution: float
    segments: int
    n: int
    tau0: float
    method: Method = "welch"

    def __post_init__(self) -> None:
        freeze(self, "frequency", "density", "dof", dtype=np.float64)

    @property
    def trusted(self) -> float:
        """Frequency from which the bias of a density as steep as f⁻² is negligible: 3 resolutions, 4 for tapers. [Hz]"""
        return (3.0 if self.method == "welch" else 4.0) * self.resolution

    @property
    def density_unit(self) -> str:
        """Unit of the density, two-sided."""
        return f"({self.unit})^2/Hz" if "/" in self.unit else f"{self.unit}^2/Hz"

    def interval(self, *, level: float = 0.95) -> tuple[Floats, Floats]:
        """Confidence interval of the density, by χ².

        Parameters
        ----------
        level : float
            Probability, between 0 and 1.

        Returns
        -------
        low, high : ndarray, shape (n_f,)
            [unit²/Hz]

        Raises
        ------
        OptionError
            For a level that is not between 0 and 1.

        Notes
        -----
        The intervals hold for a density that changes little within the `resolution`. For a density as steep as f⁻² the bias
        of the lowest frequencies, by leakage and by the removed slope, is larger than the interval. The intervals hold
        above `trusted`.
        """
        if not 0 < level < 1:
            raise OptionError(f"{{option}} must be between 0 and 1, not {level!r}", option="level")
        low, high = chi2_quantile_above(self.dof, (1 - level) / 2), chi2_quantile_above(self.dof, (1 + level) / 2)
        return self.density * self.dof / low, self.density * self.dof / high

    def binned(self, *, per_octave: int = 8) -> Spectrum:
        """The spectrum with neighbouring frequencies averaged.

        The frequency of a bin is the mean of its frequencies. Each density is moved to this frequency along the
        slope between the neighbouring bins before the mean is taken. Without this step an octave of a density as
        steep as f⁻² would be an eighth too high.

        Parameters
        ----------
        per_octave : int
            Bins per octave.

        Returns
        -------
        Spectrum
        """
        return self._binned(bin_starts(self.frequency, per_octave))

    def _binned(self, starts: NDArray[np.intp]) -> Spectrum:
        frequency, density, _ = levelled(self.density, self.frequency, starts)
        count = np.diff(np.append(starts, len(self.frequency)))
        dof = np.add.reduceat(self.dof, starts) / (
            1 + variance_increase(count, method=self.method, tapers=self.segments)
        )
        return replace(self, frequency=frequency, density=density, dof=dof)

    def to_dict(self) -> dict[str, Any]:
        """Plain columns, for JSON or any data-frame library."""
        low, high = self.interval()
        fields = "channel frequency_hz=frequency density dof method segments resolution_hz=resolution unit=density_unit"
        return plain(self, fields, low=low, high=high, sided="two")

    def expected(self, model: HasDensity | HasChannels) -> Floats:
        """Density of a noise model at the frequencies of this spectrum, aliasing included.

        Parameters
        ----------
        model : ChannelModel or NoiseModel
            The model; for a NoiseModel, its channel of the same name is used. Sinusoids and a ramp have no density.

        Returns
        -------
        ndarray, shape (n_f,)
            [unit²/Hz]

        Raises
        ------
        DataError
            If the model does not have the channel, has it in another unit, or has no noise with a density.
        """
        channels = getattr(model, "channels", None)
        if channels is not None and self.channel not in channels:
            raise DataError(f"the model has no channel {self.channel!r}; channels: {', '.join(channels)}")
        noise = cast("HasDensity", model) if channels is None else channels[self.channel]
        if noise.unit != self.unit:
            raise DataError(f"{self.channel}: the model is in {noise.unit}, the spectrum in {self.unit}")
        density = noise.psd(self.frequency, tau0=self.tau0)
        if not np.isfinite(density).all():
            raise DataError(
                f"{self.channel}: the model's density is not a finite number; its coefficients are out of range"
            )
        if not (density > 0).any():
            raise DataError(f"{self.channel}: the model has no noise with a density, only lines or a ramp")
        return density

    def over(self, model: HasDensity | HasChannels, *, per_octave: int = 3) -> ModelComparison:
        """Ratio of this density to that of a noise model in bands, from `trusted` on; see `expected` and `ModelComparison`.

        Parameters
        ----------
        model : ChannelModel or NoiseModel
            As in `Spectrum.expected`.
        per_octave : int
            Bands per octave, as in `binned`. Bands that begin below `trusted` are omitted.

        Returns
        -------
        ModelComparison

        Raises
        ------
        DataError
            See `expected`; or if no band is left.

        Notes
        -----
        The comparison omits and names bands to which a sinusoid of the model adds more than a thousandth of the model's
        density. It also omits frequencies that the fit of the model left out.
        """
        expected = self.expected(model)
        near_lines = (expected > 0) & (self._line_density(model) > _LINE_SHARE * expected)
        starts = bin_starts(self.frequency, per_octave)
        good = (self.frequency >= self.trusted) & (expected > 0) & ~near_lines
        channel = getattr(model, "channels", {self.channel: model})[self.channel]
        highest = getattr(channel, "highest", None)
        good &= self.frequency <= (highest or np.inf)
        shown = np.logical_and.reduceat(good, starts)
        if not shown.any():
            up_to = "on" if highest is None else f"to {highest:.3g} Hz, where the model was fitted,"
            reason = "is clear of the model's lines" if near_lines.any() else "is left to compare"
            raise DataError(
                f"{self.channel}: no band from {self.trusted:.3g} Hz {up_to} {reason}; longer segments help"
            )
        count = np.diff(np.append(starts, len(self.frequency)))
        is_shown = np.repeat(shown, count)
        with np.errstate(over="ignore"):
            ratios = self.density[is_shown] / expected[is_shown]
        if not np.isfinite(ratios).all():
            raise DataError(
                f"{self.channel}: the ratio to the model's density is not a finite number; is the model in SI?"
            )
        ratio = replace(self, frequency=self.frequency[is_shown], density=ratios, dof=self.dof[is_shown])
        bands = ratio._binned(np.append(0, np.cumsum(count[shown])[:-1]))
        return ModelComparison(
            channel=self.channel,
            frequency=bands.frequency,
            ratio=bands.density,
            dof=bands.dof,
            method=self.method,
            left_out=self.left_out(model),
            highest=highest if highest and highest < self.frequency[-1] else None,
            beside_lines=tuple((float(self.frequency[a]), float(self.frequency[b - 1])) for a, b in runs(near_lines)),
        )

    def left_out(self, model: HasDensity | HasChannels) -> tuple[str, ...]:
        """Parts of a model without a density, which `expected` omits: ``("sinusoid at 0.55 Hz", "rate ramp")``.

        Parameters
        ----------
        model : ChannelModel or NoiseModel
            As in `Spectrum.expected`.

        Returns
        -------
        tuple of str
        """
        channels = getattr(model, "channels", None)
        noise = model if channels is None else channels[self.channel]
        lines = [f"sinusoid at {line.frequency:.4g} Hz" for line in getattr(noise, "sinusoid", ())]
        return (*lines, *(["rate ramp"] if "rate_ramp" in getattr(noise, "terms", ()) else []))

    def _line_density(self, model: HasDensity | HasChannels) -> Floats:
        """Upper bound of the density of the model's sinusoids in this spectrum; shape (n_f,)."""
        noise = getattr(model, "channels", {self.channel: model})[self.channel]
        tapers = self.segments if self.method == "multitaper" else None
        total = np.zeros(self.frequency.shape)
        for line in getattr(noise, "sinusoid", ()):
            total += line_density(
                self.frequency,
                line.frequency,
                line.amplitude,
                tau0=self.tau0,
                resolution=self.resolution,
                tapers=tapers,
            )
        return total

    def plot(
        self, ax: Axes | None = None, *, model: HasDensity | HasChannels | None = None, unit: str | None = None
    ) -> Figure:
        """Draw the two-sided density with its 95 % band, and optionally the density of a model.

        Parameters
        ----------
        ax : matplotlib axes, optional
            Default: a new figure.
        model : ChannelModel or NoiseModel, optional
            See `expected`.
        unit : str, optional
            Unit of the rate, ``"deg/s"``; the density has the square of this unit per hertz. Default:
            deg/h and µg, as in figures of the Allan deviation.

        Returns
        -------
        matplotlib figure
        """
        from sigmatau.plot.curves import COLOURS
        from sigmatau.plot.style import make_panels, parent_figure

        (panel,) = make_panels(ax, 1, columns=1, width=7, height=4.6)
        self._draw(panel, model, unit, COLOURS[0])
        return parent_figure(panel)

    def _draw(self, ax: Axes, model: HasDensity | HasChannels | None, unit: str | None, colour: str) -> None:
        """Draw the density in bins of an eighth of an octave with its 95 % band; dotted below `trusted`."""
        from sigmatau.plot.style import label_axes

        factor, label = self._density_axis(unit)
        binned = self.binned()
        low, high = (edge / factor**2 for edge in binned.interval())
        ax.fill_between(binned.frequency, low, high, color=colour, alpha=0.25, linewidth=0)
        sure, density = binned.frequency > self.trusted, binned.density / factor**2
        ax.loglog(binned.frequency, density, linewidth=1, linestyle=":", color=colour)
        ax.loglog(binned.frequency[sure], density[sure], linewidth=1.3, color=colour, label=self.channel)
        if model is not None:
            expected, without = self.expected(model), self.left_out(model)
            look: dict[str, Any] = {"color": colour, "linestyle": "--", "linewidth": 1.1}
            positive = expected > 0
            ax.loglog(self.frequency[positive], expected[positive] / factor**2, **look, zorder=3)
            if without:
                further = f" and {len(without) - 1} more" if len(without) > 1 else ""
                ax.plot([], [], **look, label=f"{self.channel}: model without {without[0]}{further}")
        label_axes(ax, "frequency [Hz]", label)

    def _density_axis(self, unit: str | None) -> tuple[float, str]:
        """Size of the root of the unit of densities, and the label of the axis; the unit is `unit`, or that of
        `show_in`.
        """
        asked = None if unit else asked_density(self.quantity, self.unit)
        if asked is not None and not asked.sided:  # per √h
            return asked.factor, f"two-sided density [({asked.bare})²]"
        if asked is not None:
            text, factor = asked.bare.removesuffix("/√Hz"), asked.factor
        elif wanted := unit or figure_unit(self.quantity, self.unit):
            text, factor = find(wanted, si=self.unit).text, find(wanted).factor
        else:
            text, factor = find(self.unit).text if self.unit in symbols() else self.unit, 1.0
        return factor, f"{asked.sided if asked else 'two'}-sided density [{density_text(text)}]"

    def __repr__(self) -> str:
        kind = "sine tapers" if self.method == "multitaper" else "segments"
        head = (
            f"{self.channel}: two-sided power spectral density, {self.segments} {kind}, resolution "
            f"{self.resolution:.3g} Hz [{self.density_unit}]"
        )
        octaves = self.binned(per_octave=1)
        low, high = octaves.interval()
        rows = zip(octaves.frequency, octaves.density, low, high, strict=True)
        return "\n".join([head, *(f"  {f:10.4g} Hz  {'  '.join(round_to_error(*value).cells)}" for f, *value in rows)])


class Spectra(ByChannel[Spectrum]):
    """Spectra by channel: an immutable mapping in the record's order."""

    __slots__ = ()

    def to_dict(self) -> dict[str, Any]:
        """Each spectrum as plain columns, by channel."""
        return {channel: spectrum.to_dict() for channel, spectrum in self.items()}

    def plot(self, ax: Panels = None, *, model: HasChannels | None = None) -> Figure:
        """Draw all channels, one panel per quantity and unit, with the densities of the model's channels of the same
        names.

        Parameters
        ----------
        ax : matplotlib axes, or sequence of them, optional
            One per panel. Default: a new figure.
        model : ChannelModel or NoiseModel, optional
            Drawn over the spectra; see `Spectrum.expected`.

        Returns
        -------
        matplotlib figure
        """
        from sigmatau.plot.curves import COLOURS, TITLES
        from sigmatau.plot.style import legend, make_panels, parent_figure

        models = {} if model is None else model.channels
        kinds: dict[tuple[str, str], list[str]] = {}
        for channel, spectrum in self.items():
            kinds.setdefault((spectrum.quantity, spectrum.unit), []).append(channel)
        panels = make_panels(ax, len(kinds), columns=len(kinds), width=7, height=4.8)
        biased = "biased if the density is as steep as 1/f²"
        for panel, ((quantity, _), channels) in zip(panels, kinds.items(), strict=True):
            for k, channel in enumerate(channels):
                self[channel]._draw(panel, models.get(channel), None, COLOURS[k % len(COLOURS)])
            panel.set_title(TITLES.get(quantity, quantity))
            panel.fill_between([], [], [], color="0.6", alpha=0.35, linewidth=0, label="95 % confidence")
            panel.plot([], [], color="0.35", linestyle=":", linewidth=1, label=biased)
            if models.keys() & channels:
                panel.plot([], [], color="0.35", linestyle="--", linewidth=1.1, label="model")
            legend(panel)
        return parent_figure(panels[0])
