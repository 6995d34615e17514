"""Log-log figures of Allan deviations, from plain arrays and any object with a curve's attributes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from sigmatau._version import __version__
from sigmatau.errors import DataError
from sigmatau.noise.terms import TERMS, asked_rate_unit, avar
from sigmatau.plot.style import legend, make_panels, new_figure, parent_figure, small
from sigmatau.units import figure_unit, find, find_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    from sigmatau.plot.style import Panels

# Okabe & Ito's palette: distinct for any colour vision, and by lightness in print.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
TITLES = {"angular_rate": "Gyroscopes", "acceleration": "Accelerometers"}

_SHOWN = ("random_walk", "bias_instability", "rate_random_walk")  # terms in a legend

# Drawing one line for each of very many averaging times would be slow and make a large file, with the same appearance.
_DRAWN_PER_OCTAVE = 256
MARKERS = "os^DvPX*"  # one per channel
_MAX_MARKERS = 300


class ChannelLike(Protocol):
    """Result of one channel."""

    @property
    def channel(self) -> str: ...
    @property
    def quantity(self) -> str: ...
    @property
    def unit(self) -> str: ...


class CurveLike(ChannelLike, Protocol):
    """Attributes of `sigmatau.estimators.allan.DeviationCurve` that are drawn."""

    @property
    def tau(self) -> NDArray[np.float64]: ...
    @property
    def adev(self) -> NDArray[np.float64]: ...
    @property
    def m(self) -> NDArray[np.int64]: ...
    @property
    def interval_text(self) -> str: ...
    def interval(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...


class DeviationLike(ChannelLike, Protocol):
    """Attributes of `sigmatau.estimators.deviation.Deviation` that are drawn."""

    @property
    def label(self) -> str: ...
    @property
    def tau(self) -> NDArray[np.float64]: ...
    @property
    def deviation(self) -> NDArray[np.float64]: ...


class FitLike(Protocol):
    """Attributes of `sigmatau.fitting.noise_fit.NoiseFit` that are drawn."""

    @property
    def model(self) -> Mapping[str, float]: ...
    @property
    def tau_min(self) -> float | None: ...
    @property
    def quantified(self) -> bool: ...
    @property
    def observed(self) -> Mapping[str, float]: ...
    @property
    def line_ranges(self) -> Mapping[str, tuple[float, float] | None]: ...
    def texts(self, term: str) -> list[tuple[str, str, str]]: ...
    def avar(self, *, m: NDArray[np.int64]) -> NDArray[np.float64]: ...


class CoefficientLike(Protocol):
    """Attributes of `sigmatau.fitting.read_off.ReadOffCoefficient` that are drawn."""

    @property
    def value(self) -> float: ...
    @property
    def tau_min(self) -> float: ...
    @property
    def tau_max(self) -> float: ...


def draw_curve(
    curve: CurveLike, *, ax: Axes | None = None, unit: str | None = None, colour: str = COLOURS[0], marker: str = "o"
) -> Axes:
    """Draw one curve with its band, see `DeviationCurve.interval`.

    Parameters
    ----------
    curve : DeviationCurve
    ax : matplotlib axes, optional
    unit : str, optional
        Default: deg/h for gyros, µg for accelerometers, the unit of any other signal.
    colour, marker : str
    """
    require_points(curve)
    factor, text = curve_unit(curve, unit)
    ax = new_figure(7, 5).subplots() if ax is None else ax
    edges = tuple(edge / factor for edge in curve.interval())
    draw_line(ax, curve.channel, curve.tau, curve.adev / factor, colour, marker, edges)
    ax.set_ylabel(f"Allan deviation σ(τ) [{text}]")
    return ax


def require_points(curve: CurveLike) -> None:
    """Raise `DataError` for a curve without points: a store may keep results without them."""
    if not len(curve.tau):
        raise DataError(
            f"the Allan deviation of {curve.channel} was not kept in the store. Analyse the log again to draw it"
        )


def draw_deviation(
    curve: DeviationLike,
    *,
    ax: Axes | None = None,
    unit: str | None = None,
    band: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None,
    colour: str = COLOURS[0],
    marker: str = "o",
) -> Axes:
    """Draw one deviation of `sigmatau.deviation`, with its band if any; units as in `draw_curve`."""
    factor, text = curve_unit(curve, unit)
    ax = new_figure(7, 5).subplots() if ax is None else ax
    edges = None if band is None else tuple(edge / factor for edge in band)
    draw_line(ax, curve.channel, curve.tau, curve.deviation / factor, colour, marker, edges)
    ax.set_ylabel(f"{curve.label} [{text}]")
    return ax


def draw_deviations(
    curves: Mapping[str, DeviationLike],
    bands: Mapping[str, tuple[NDArray[np.float64], NDArray[np.float64]]],
    *,
    ax: Panels = None,
) -> Figure:
    """Draw the deviations of all channels, one panel per quantity and unit."""
    figure, panels = _panels({channel: (curve.quantity, curve.unit) for channel, curve in curves.items()}, ax)
    for ax, key, channels in panels:
        for channel, (colour, marker) in zip(channels, _cycle(len(channels)), strict=True):
            draw_deviation(curves[channel], ax=ax, band=bands.get(channel), colour=colour, marker=marker)
        ax.set_title(_title(key, channels))
        if any(channel in bands for channel in channels):
            ax.fill_between([], [], [], color="0.6", alpha=0.35, linewidth=0, label="95 % confidence")
        legend(ax)
    return figure


def draw_line(
    ax: Axes,
    name: str,
    tau: NDArray[np.float64],
    deviation: NDArray[np.float64],
    colour: str,
    marker: str,
    band: tuple[NDArray[np.float64], ...] | None = None,
) -> None:
    """Draw one line with its name in the legend, its band if any, and the grid of a log-log figure."""
    shown = _visibly_different(tau)
    shown = shown[deviation[shown] > 0]
    marker = marker if len(shown) <= _MAX_MARKERS else ""
    tau, deviation = tau[shown], deviation[shown]
    if band is not None:
        low, high = (edge[shown] for edge in band)
        # Beyond δ = 1, eq. (26) has no lower edge, and χ² with one degree of freedom has an upper edge far outside the
        # axes.
        low, high = np.maximum(low, 0.1 * deviation), np.minimum(high, 10 * deviation)
        ax.fill_between(tau, low, high, color=colour, alpha=0.18, linewidth=0)
    ax.loglog(tau, deviation, color=colour, linewidth=small() / 5, marker=marker, markersize=small() / 3.2, label=name)
    ax.set_xlabel("averaging time τ [s]")
    from matplotlib.ticker import FuncFormatter, LogLocator

    # 20, 50, 100 in place of 2 × 10¹ …: the height of a plateau is read off this axis.
    ax.yaxis.set_minor_locator(LogLocator(base=10, subs=(2, 5)))
    for formatter in (ax.yaxis.set_major_formatter, ax.yaxis.set_minor_formatter):
        formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.tick_params(axis="y", which="minor", labelsize=small())
    ax.grid(visible=True, which="major", linewidth=0.6, alpha=0.5)
    ax.grid(visible=True, which="minor", linewidth=0.3, alpha=0.3)


def draw_analysis(
    curves: Mapping[str, CurveLike],
    read_off: Mapping[str, Mapping[str, CoefficientLike]],
    fits: Mapping[str, FitLike] | None = None,
    *,
    ax: Panels = None,
) -> Figure:
    """Draw all channels, one panel per quantity and unit, with their fitted models or the read-off lines.

    The legend has the coefficients of each channel; in a panel with one channel, its terms have lines, thicker where a term
    is most of the variance.
    """
    figure, panels = _panels({channel: (curve.quantity, curve.unit) for channel, curve in curves.items()}, ax)
    for ax, key, channels in panels:
        named: list[tuple[float, float]] = []
        lines: dict[str, Line2D] = {}
        for channel, (colour, marker) in zip(channels, _cycle(len(channels)), strict=True):
            curve = curves[channel]
            draw_curve(curve, ax=ax, colour=colour, marker=marker)
            if fits:
                lines[channel] = ax.lines[-1]
                _draw_model(ax, curve, fits[channel], colour)
                if len(channels) == 1:
                    _draw_terms(ax, curve, fits[channel], colour)
                continue
            for name, coefficient in read_off.get(channel, {}).items():
                _draw_line(ax, curve, name, coefficient, colour, named)
        ax.set_title(_title(key, channels))
        what = "fitted model, dotted where it was not fitted" if fits else "line read off, ● where it is read"
        if fits or read_off:
            ax.plot([], [], color="0.35", linestyle="--", linewidth=1.1, label=what)
        for text in dict.fromkeys(curves[channel].interval_text for channel in channels):
            ax.fill_between([], [], [], color="0.6", alpha=0.35, linewidth=0, label=text)
        for text, line in zip(_values_texts(fits or {}, list(lines)), lines.values(), strict=True):
            line.set_label(text)
        legend(ax)
    return figure


def _values_texts(fits: Mapping[str, FitLike], channels: Sequence[str]) -> list[str]:
    """Name of each channel with its observed random walk, bias instability and rate random walk, for a legend."""
    texts = []
    for channel in channels:
        values = [_value_text(fits[channel], term) for term in _SHOWN if term in fits[channel].observed]
        texts.append(f"{channel}: {', '.join(values)}" if values else channel)
    return texts


def _value_text(fitted: FitLike, name: str) -> str:
    """``"N = 2.43 deg/√h"``."""
    value, _, unit = fitted.texts(name)[-1]
    return f"{TERMS[name].symbols[0]} = {value} {unit.replace('^{3/2}', '$^{3/2}$')}"


def _draw_terms(ax: Axes, curve: CurveLike, fitted: FitLike, colour: str) -> None:
    """Draw a line of each term of the model, thicker where the term is most of the variance, with its symbol beside it."""
    factor, _ = curve_unit(curve, None)
    total, limits, ranges = fitted.avar(m=curve.m), ax.get_ylim(), fitted.line_ranges
    for name, value in fitted.observed.items():
        part = np.sqrt(avar(name, value, m=curve.m, tau0=float(curve.tau[0] / curve.m[0]))) / factor
        ax.plot(curve.tau, part, color="0.45", linewidth=0.8, zorder=1.5)
        first, last = ranges.get(name) or (math.inf, 0.0)
        inside_range = (curve.tau >= first * (1 - 1e-9)) & (curve.tau <= last * (1 + 1e-9))
        ax.plot(curve.tau[inside_range], part[inside_range], color="0.45", linewidth=2.0, zorder=1.5)
        inside = (part > (1.3 if TERMS[name].slope else 1.1) * limits[0]) & (part < limits[1])
        if not inside.any():
            continue
        place = int(np.argmin(np.where(inside, part**2 / total, np.inf)))
        side = round(math.copysign(1, TERMS[name].slope)) if TERMS[name].slope else 0  # the side away from the curve
        ax.annotate(
            TERMS[name].symbols[0],
            (float(curve.tau[place]), float(part[place])),
            xytext=(4 * side, 0 if side else 2),
            textcoords="offset points",
            fontsize=small(),
            color="0.25",
            ha=("center", "left", "right")[side],
            va="center" if side else "bottom",
            zorder=5,
        )
    ax.set_ylim(limits)


def _panels(kinds: Mapping[str, tuple[str, str]], chosen: Panels) -> tuple[Figure, list[tuple[Axes, str, list[str]]]]:
    """A figure and its axes, new or given, one for each quantity and unit: each axes with its kind and its channels."""
    panels: dict[tuple[str, str], list[str]] = {}
    for channel, (quantity, unit) in kinds.items():
        panels.setdefault((quantity if quantity != "signal" else channel, unit), []).append(channel)
    axes = make_panels(chosen, len(panels), columns=2, width=7.2, height=5.6)
    named = zip(axes, panels.items(), strict=True)
    return parent_figure(axes[0]), [(ax, key, channels) for ax, ((key, _), channels) in named]


def _draw_model(ax: Axes, curve: CurveLike, fitted: FitLike, colour: str) -> None:
    """Draw the deviation of a model; dotted if the model has no intervals."""
    if not fitted.model or fitted.tau_min is None:
        return
    factor, _ = curve_unit(curve, None)
    shown = _visibly_different(curve.tau)
    tau, adev = curve.tau[shown], np.sqrt(fitted.avar(m=curve.m[shown])) / factor
    used = tau >= fitted.tau_min * (1 - 1e-9)
    if not fitted.quantified:
        used = np.zeros_like(used)
    # The two pieces share a point.
    before = ~used | (np.cumsum(used) == 1)
    ax.plot(tau[used], adev[used], color=colour, linestyle="--", linewidth=1.1, zorder=3)
    if before.sum() > 1:
        ax.plot(tau[before], adev[before], color=colour, linestyle=":", linewidth=1.1, zorder=3)


def _draw_line(
    ax: Axes, curve: CurveLike, name: str, coefficient: CoefficientLike, colour: str, named: list[tuple[float, float]]
) -> None:
    term = TERMS[name]
    factor, _ = curve_unit(curve, None)
    read_tau = term.read_at if term.read_at is not None else math.sqrt(coefficient.tau_min * coefficient.tau_max)
    level = coefficient.value * term.level / factor

    def height(tau: float) -> float:
        return float(level * (tau / read_tau) ** term.slope)

    first, last = curve.tau[0], curve.tau[-1]
    # The line covers its region and half a decade on either side, and extends to its reading point if that is near.
    start, stop = coefficient.tau_min / 3, coefficient.tau_max * 3
    reaches = first <= read_tau <= last
    if reaches:
        start, stop = min(start, read_tau), max(stop, read_tau)
    start, stop = max(start, first), min(stop, last)
    ax.plot([start, stop], [height(start), height(stop)], color=colour, linestyle="--", linewidth=1.1, zorder=1.5)
    if reaches and term.read_at is not None:
        ax.plot(
            [read_tau], [height(read_tau)], marker="o", markersize=5, color=colour, markeredgecolor="white", zorder=4
        )
    place = _free_place(math.log10(coefficient.tau_min), math.log10(coefficient.tau_max), named, height)
    if place is not None:
        beyond = place > first * (last / first) ** 0.7  # a label on the right would leave the axes
        ax.annotate(
            term.label(curve.quantity),
            (place, height(place)),
            xytext=(-4 if beyond else 4, 7),
            textcoords="offset points",
            ha="right" if beyond else "left",
            fontsize=7.5,
            color=colour,
            zorder=5,
            bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.75},
        )


def _free_place(
    low: float, high: float, named: list[tuple[float, float]], height: Callable[[float], float]
) -> float | None:
    """An averaging time in a region where a label covers no earlier label; None if there is none."""
    for share in (0.5, 0.35, 0.65):
        x = low + share * (high - low)
        y = math.log10(height(10**x))
        if all(abs(x - u) > 0.9 or abs(y - v) > 0.12 for u, v in named):
            named.append((x, y))
            return float(10**x)
    return None


def save(figure: Figure, path: str) -> None:
    """Write a figure; the ending names the format: .png, .svg or .pdf."""
    made_by = f"sigmatau {__version__}"
    kind = {".svg": {"Creator": made_by, "Date": None}, ".pdf": {"Creator": made_by}, ".png": {"Software": made_by}}
    figure.savefig(path, metadata=kind.get(path[-4:]))


def _visibly_different(tau: NDArray[np.float64]) -> NDArray[np.intp]:
    """Indices of averaging times that are visibly different in a figure."""
    bins = np.floor(np.log2(tau / tau[0]) * _DRAWN_PER_OCTAVE)
    return np.flatnonzero(np.diff(bins, prepend=-1) > 0)


def curve_unit(curve: CurveLike | DeviationLike, unit: str | None) -> tuple[float, str]:
    """Factor from the drawn unit of a curve to its stored unit, and the text of the drawn unit."""
    asked = None if unit else asked_rate_unit(curve.quantity, curve.unit)
    if asked is not None:
        return asked[1], asked[0]
    wanted = unit or figure_unit(curve.quantity, curve.unit)
    if wanted in (None, curve.unit):
        return 1.0, curve.unit
    known_unit = find_unit(curve.unit)  # the unit of an array is spelled as the user gave it
    drawn = find(wanted, si=known_unit.si if known_unit else curve.unit)
    return drawn.factor / (known_unit.factor if known_unit else 1.0), drawn.text


def _cycle(n: int) -> list[tuple[str, str]]:
    """Colours and markers, which also differ in grey."""
    return [(COLOURS[k % len(COLOURS)], MARKERS[k % len(MARKERS)]) for k in range(n)]


def _title(key: str, channels: Sequence[str]) -> str:
    """``"Gyroscopes"``, or ``"Gyroscope"`` of one."""
    title = TITLES.get(key, key)
    return title.removesuffix("s") if key in TITLES and len(channels) == 1 else title
