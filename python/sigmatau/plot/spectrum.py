"""Log-log figures of power spectral densities, two-sided, from plain arrays and any object with a spectrum's attributes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.noise.terms import asked_density
from sigmatau.plot.curves import COLOURS, TITLES, ChannelLike
from sigmatau.plot.style import check_panels, legend, new_figure, parent_figure
from sigmatau.units import find, symbols

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from sigmatau.plot.style import Panels


class Estimate(Protocol):
    """Densities with intervals."""

    @property
    def frequency(self) -> Floats: ...
    @property
    def density(self) -> Floats: ...
    def interval(self, *, level: float = 0.95) -> tuple[Floats, Floats]: ...


class SpectrumLike(ChannelLike, Estimate, Protocol):
    """Attributes of `sigmatau.spectrum.result.Spectrum` that are drawn."""

    @property
    def trusted(self) -> float: ...
    def binned(self, *, per_octave: int = 8) -> Estimate: ...


class ComparisonLike(Protocol):
    """Attributes of `sigmatau.spectrum.comparison.ModelComparison` that are drawn."""

    @property
    def channel(self) -> str: ...
    @property
    def frequency(self) -> Floats: ...
    @property
    def ratio(self) -> Floats: ...
    def interval(self, *, level: float = 0.95) -> tuple[Floats, Floats]: ...


class CrossLike(Protocol):
    """Attributes of `sigmatau.spectrum.cross.CrossSpectrum` that are drawn."""

    @property
    def a(self) -> str: ...
    @property
    def b(self) -> str: ...
    @property
    def frequency(self) -> Floats: ...
    @property
    def coherence(self) -> Floats: ...
    @property
    def phase(self) -> Floats: ...
    def significance(self, *, level: float = 0.95) -> Floats: ...
    def coherence_interval(self, *, level: float = 0.95) -> tuple[Floats, Floats]: ...
    def phase_interval(self, *, level: float = 0.95) -> tuple[Floats, Floats]: ...


class FilterLike(Protocol):
    """Attributes of `sigmatau.spectrum.transfer.MinimumPhase` that are drawn."""

    @property
    def channel(self) -> str: ...
    @property
    def frequency(self) -> Floats: ...
    @property
    def magnitude(self) -> Floats: ...
    @property
    def low(self) -> Floats: ...
    @property
    def high(self) -> Floats: ...
    @property
    def phase(self) -> Floats: ...


def draw_spectrum(
    spectrum: SpectrumLike,
    *,
    ax: Axes | None = None,
    expected: Floats | None = None,
    unit: str | None = None,
    colour: str = COLOURS[0],
    without: Sequence[str] = (),
) -> Axes:
    """Draw a density in bins of an eighth of an octave with its 95 % band; dotted below `Spectrum.trusted`.

    Parameters
    ----------
    spectrum : Spectrum
    ax : matplotlib axes, optional
    expected : ndarray, shape (n_f,), optional
        A model's density at its frequencies, in SI; dashed.
    unit : str, optional
        Of the rate. Default: SI.
    colour : str
    without : sequence of str
        What of the model has no density, for a note.
    """
    ax = new_figure(7, 4.6).subplots() if ax is None else ax
    factor, label = _axis(spectrum, unit)
    binned = spectrum.binned()
    low, high = (edge / factor**2 for edge in binned.interval())
    ax.fill_between(binned.frequency, low, high, color=colour, alpha=0.25, linewidth=0)
    doubtful = binned.frequency <= spectrum.trusted
    density = binned.density / factor**2
    ax.loglog(binned.frequency, density, linewidth=1, linestyle=":", color=colour)
    ax.loglog(binned.frequency[~doubtful], density[~doubtful], linewidth=1.3, color=colour, label=spectrum.channel)
    if expected is not None:
        positive = expected > 0
        ax.loglog(
            spectrum.frequency[positive],
            expected[positive] / factor**2,
            color=colour,
            linestyle="--",
            linewidth=1.1,
            zorder=3,
        )
    if without:
        others_words = f" and {len(without) - 1} more" if len(without) > 1 else ""
        remark = f"{spectrum.channel}: model without {without[0]}{others_words}"
        ax.plot([], [], color=colour, linestyle="--", linewidth=1.1, label=remark)
    ax.set_xlabel("frequency [Hz]")
    ax.set_ylabel(label)
    ax.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
    return ax


def _axis(spectrum: SpectrumLike, unit: str | None) -> tuple[float, str]:
    """Size of the root of the unit of densities, and their name with this unit: the given one, or that of `show_in`."""
    asked = None if unit else asked_density(spectrum.quantity, spectrum.unit)
    if asked is not None and not asked.sided:  # per √h
        return asked.factor, f"two-sided density [({asked.bare})²]"
    if asked is not None:
        text, factor = asked.bare.removesuffix("/√Hz"), asked.factor
    elif unit:
        text, factor = find(unit, si=spectrum.unit).text, find(unit).factor
    else:
        text, factor = find(spectrum.unit).text if spectrum.unit in symbols() else spectrum.unit, 1.0
    squared = f"({text})²" if "/" in text else f"{text}²"
    return factor, f"{asked.sided if asked else 'two'}-sided density [{squared}/Hz]"


def draw_spectra(
    spectra: Mapping[str, SpectrumLike],
    expected: Mapping[str, Floats],
    *,
    without: Mapping[str, Sequence[str]] | None = None,
    ax: Panels = None,
) -> Figure:
    """Draw the densities of all channels, one panel per quantity and unit, with the densities of a model where it has the
    channel.

    `without` says by channel what of the model has no density.
    """
    kinds: dict[tuple[str, str], list[str]] = {}
    for channel, spectrum in spectra.items():
        kinds.setdefault((spectrum.quantity, spectrum.unit), []).append(channel)
    panels = check_panels(ax, len(kinds)) or list(
        new_figure(7 * len(kinds), 4.8).subplots(1, len(kinds), squeeze=False)[0]
    )
    for ax, ((quantity, _), channels) in zip(panels, kinds.items(), strict=True):
        for k, channel in enumerate(channels):
            colour = COLOURS[k % len(COLOURS)]
            left_out = (without or {}).get(channel, ())
            draw_spectrum(spectra[channel], ax=ax, expected=expected.get(channel), colour=colour, without=left_out)
        ax.set_title(TITLES.get(quantity, quantity))
        ax.fill_between([], [], [], color="0.6", alpha=0.35, linewidth=0, label="95 % confidence")
        ax.plot(
            [],
            [],
            color="0.35",
            linestyle=":",
            linewidth=1,
            label="too low in frequency for a density as steep as 1/f²",
        )
        if any(channel in expected for channel in channels):
            ax.plot([], [], color="0.35", linestyle="--", linewidth=1.1, label="model")
        legend(ax)
    return parent_figure(panels[0])


def draw_comparison(comparison: ComparisonLike, *, ax: Axes | None = None, colour: str = COLOURS[0]) -> Axes:
    """Draw ratios of a measured density to a model's, with their 95 % intervals."""
    ax = new_figure(7, 3.2).subplots() if ax is None else ax
    low, high = comparison.interval()
    ratio = comparison.ratio
    errors = np.array([ratio - low, high - ratio])
    ax.errorbar(comparison.frequency, ratio, errors, fmt="o", markersize=3, linewidth=1, color=colour)
    ax.axhline(1.0, color="0.4", linewidth=0.8)
    ax.set_xscale("log")
    ax.set_xlabel("frequency [Hz]")
    ax.set_ylabel(f"density of {comparison.channel} over the model's")
    ax.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
    return ax


def draw_cross(cross: CrossLike, *, ax: Panels = None, colour: str = COLOURS[0]) -> Figure:
    """Draw the coherence with its 95 % significance level, and the phase where the coherence is above it."""
    upper, lower = check_panels(ax, 2) or new_figure(7, 5).subplots(2, 1, sharex=True, height_ratios=(1.4, 1))
    low, high = cross.coherence_interval()
    upper.fill_between(cross.frequency, low, high, color=colour, alpha=0.25, linewidth=0)
    upper.semilogx(cross.frequency, cross.coherence, color=colour, linewidth=1.2)
    level = cross.significance()
    upper.semilogx(cross.frequency, level, color="0.4", linewidth=0.9, linestyle="--", label="95 % of chance are below")
    upper.set_ylim(0, 1)
    upper.set_ylabel(f"coherence γ² of {cross.a} and {cross.b}")
    legend(upper)
    significant = cross.coherence > level
    begin, end = (np.degrees(edge) for edge in cross.phase_interval())
    phase = np.degrees(cross.phase)
    errors = np.array([phase - begin, end - phase])[:, significant]
    lower.errorbar(
        cross.frequency[significant], phase[significant], errors, fmt="o", markersize=2.5, linewidth=0.8, color=colour
    )
    lower.set_ylim(-190, 190)
    lower.set_yticks([-180, -90, 0, 90, 180])
    lower.set_xlabel("frequency [Hz]")
    lower.set_ylabel(f"phase of {cross.b} [deg]")
    for panel in (upper, lower):
        panel.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
    return parent_figure(upper)


def draw_filter(fitted: FilterLike, *, ax: Panels = None, colour: str = COLOURS[0]) -> Figure:
    """Draw the magnitude of a filter with its 95 % interval, and its phase."""
    upper, lower = check_panels(ax, 2) or new_figure(7, 5).subplots(2, 1, sharex=True, height_ratios=(1.4, 1))
    f = fitted.frequency[1:]
    upper.fill_between(f, fitted.low[1:], fitted.high[1:], color=colour, alpha=0.25, linewidth=0)
    upper.loglog(f, fitted.magnitude[1:], color=colour, linewidth=1.1)
    upper.set_ylabel(f"|H(f)| of {fitted.channel}")
    lower.semilogx(f, np.degrees(fitted.phase[1:]), color=colour, linewidth=1.1)
    lower.set_ylabel("phase [deg],\nminimum phase assumed")
    lower.set_xlabel("frequency [Hz]")
    for panel in (upper, lower):
        panel.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
    return parent_figure(upper)
