"""Figures of a lot: curves of all units with their median and range, and values in the order of the units."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.frozen import frozen
from sigmatau.plot.curves import COLOURS
from sigmatau.plot.svg import Drawing

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_LEFT_MARGIN, _RIGHT, _TOP, _BOTTOM = 11.0, 0.5, 0.5, 7.0  # margins of axes [mm]
_FAINT, _RED = "#9aa3ad", "#a3211b"
_WIDE = 8.0  # ratio of the largest to the smallest value above which their axis is logarithmic


@frozen(eq=False)
class LotCurves:
    """The curves of one channel, in the unit of the figure.

    Attributes
    ----------
    title : str
        Title of the panel.
    unit : str
        Unit in which the deviations are drawn.
    tau : ndarray, shape (n_tau,)
        Averaging times. [s]
    median, low, high : ndarray, shape (n_tau,)
        50 %, 10 % and 90 % quantile of the units. [unit]
    units : mapping of str to ndarray, shape (n_tau,)
        Deviations by unit. [unit]
    limits : sequence of (str, ndarray of shape (n_tau,))
        Names and lines of the maxima of the specification. [unit]
    """

    title: str
    unit: str
    tau: Floats
    median: Floats
    low: Floats
    high: Floats
    units: Mapping[str, Floats]
    limits: Sequence[tuple[str, Floats]] = ()


def draw_lot(panels: Sequence[LotCurves], marked: Collection[str], *, ax: Any = None) -> Figure:  # noqa: ANN401
    """Draw one panel per channel with matplotlib; curves of the `marked` units have a colour."""
    from sigmatau.plot.style import label_axes, legend, make_panels, parent_figure

    all_axes = make_panels(ax, len(panels), columns=3, width=4, height=3.2)
    for axes, panel in zip(all_axes, panels, strict=True):
        named = [name for name in panel.units if name in marked]
        for name, curve in panel.units.items():
            if name not in marked:
                axes.loglog(panel.tau, curve, color=_FAINT, linewidth=0.4, alpha=0.5)
        axes.fill_between(panel.tau, panel.low, panel.high, color=COLOURS[0], alpha=0.2, linewidth=0)
        axes.loglog(panel.tau, panel.median, color=COLOURS[0], linewidth=1.6, label="median, 10–90 %")
        for _, limit in panel.limits:
            axes.loglog(panel.tau, limit, color=_RED, linewidth=1, linestyle="--")
        for name, colour in zip(named, COLOURS[1:], strict=False):
            axes.loglog(panel.tau, panel.units[name], color=colour, linewidth=1, label=name)
        axes.set_title(panel.title)
        label_axes(axes, "averaging time τ [s]", f"σ(τ) [{panel.unit}]")
        legend(axes)
    return parent_figure(all_axes[0])


def curves_svg(panel: LotCurves, marked: Sequence[str], *, width: float, height: float) -> str:
    """The curves of a channel as SVG; width and height in millimetres. It contains no text of the user."""
    drawing, ax = _axes(width, height)
    deviations = np.concatenate([*panel.units.values(), panel.median])
    values = np.log10(deviations[np.isfinite(deviations) & (deviations > 0)])
    x = np.log10(panel.tau)
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    margin = max(0.05 * (high - low), 0.1)
    ax.log_x(float(x.min()) - 0.03, float(x.max()) + 0.03)
    ax.log_y(low - margin, high + margin)
    for name, curve in panel.units.items():
        if name not in marked:
            ax.line(x, np.log10(curve), _FAINT, 0.2)
    ax.area(x, np.log10(panel.low), np.log10(panel.high), COLOURS[0])
    ax.line(x, np.log10(panel.median), COLOURS[0], 0.8)
    for _, limit in panel.limits:
        ax.line(x, np.log10(limit), _RED, 0.6, (3.0, 1.5))
    for name, colour in zip(marked, COLOURS[1:], strict=False):
        if name in panel.units:
            ax.line(x, np.log10(panel.units[name]), colour, 0.6)
    ax.frame("averaging time τ [s]")
    return drawing.svg()


def values_svg(
    series: Sequence[tuple[Floats, Floats]], limits: Sequence[float], *, last: int, width: float, height: float
) -> str:
    """Values in the order of the units as SVG. `series`: numbers of the units and values, for each channel."""
    drawing, ax = _axes(width, height)
    y = np.concatenate([values for _, values in series])
    shown = [limit for limit in limits if limit < 3 * float(y.max())]
    low, high = min(float(y.min()), *shown, np.inf), max(float(y.max()), *shown, 0.0)
    is_log = high > _WIDE * low
    scale = np.log10 if is_log else np.asarray
    bottom, top = float(scale(low)), float(scale(high))
    margin = max(0.06 * (top - bottom), 1e-3 * max(abs(top), 1e-300))
    ax.linear_x(0.0, last + 1.0)
    (ax.log_y if is_log else ax.linear_y)(bottom - margin, top + margin, count=5)
    for limit in shown:
        ax.line(np.array([0.0, last + 1.0]), scale(np.array([limit, limit])), _RED, 0.6, (3.0, 1.5))
    for (number, values), colour in zip(series, COLOURS, strict=False):
        ax.markers(number, scale(values), "o", colour)
    ax.frame("unit, in order")
    return drawing.svg()


def _axes(width: float, height: float) -> tuple[Drawing, Any]:
    drawing = Drawing(width, height)
    return drawing, drawing.axes(_LEFT_MARGIN, _TOP, width - _LEFT_MARGIN - _RIGHT, height - _TOP - _BOTTOM)
