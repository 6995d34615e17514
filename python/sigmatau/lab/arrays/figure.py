"""Figure of an array: deviations of the sensors and of the virtual sensor, and correlations of the pairs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from sigmatau.noise.terms import display_units
from sigmatau.plot.curves import COLOURS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sigmatau.lab.arrays.result import ArrayAnalysis

_MOST_PAIRS = 6  # largest number of pairs that have a colour and a line in the legend
_LEAST_FREEDOM = 4.0  # degrees of freedom above which a correlation is drawn; below, its interval is nearly −1 to 1
_GREY = "#9aa3ad"


def draw_array(array: ArrayAnalysis, *, ax: Any = None) -> Figure:  # noqa: ANN401  see `make_panels`
    """Draw two panels: Allan deviations, and correlations of all pairs against averaging time."""
    from sigmatau.plot.style import label_axes, legend, make_panels, parent_figure

    curves, pairs = make_panels(ax, 2, columns=2, width=6, height=4.5)
    _draw_deviations(array, curves)
    _draw_correlations(array, pairs)
    unit = display_units("bias_instability", array.quantity, array.unit)[0][0]
    label_axes(curves, "averaging time τ [s]", f"Allan deviation σ(τ) [{unit}]")
    label_axes(pairs, "averaging time τ [s]", "correlation of Allan differences")
    for panel in (curves, pairs):
        legend(panel)
    return parent_figure(curves)


def _draw_deviations(array: ArrayAnalysis, ax: Any) -> None:  # noqa: ANN401
    factor = display_units("bias_instability", array.quantity, array.unit)[0][1]
    if array.hat:
        _draw_hat(array, ax, factor)
        return
    virtual = array.virtual
    if virtual is None:
        return
    tau = virtual.curve.tau
    for k, (name, values) in enumerate(zip(array.names, virtual.sensors, strict=True)):
        ax.loglog(tau, values / factor, color=_GREY, linewidth=0.9, label="single sensors" if k == 0 else None)
        del name
    ax.loglog(tau, virtual.equal / factor, color=COLOURS[1], linestyle="--", label="equal weights, predicted")
    curve = virtual.curve
    ax.fill_between(tau, curve.low / factor, curve.high / factor, color=COLOURS[0], alpha=0.2, linewidth=0)
    ax.loglog(tau, curve.adev / factor, color=COLOURS[0], label="virtual sensor, predicted, 95 % band")
    ax.loglog(tau, curve.measured / factor, color="black", marker="o", markersize=3, linestyle="", label="fused log")
    ax.set_title(f"{virtual.channel} of {len(array.names)} sensors")


def _draw_hat(array: ArrayAnalysis, ax: Any, factor: float) -> None:  # noqa: ANN401
    """Draw the deviations by the hat; triangles are upper limits of deviations that are not significant."""
    values = [value for curve in array.hat for value in (*curve.adev, *curve.upper_limit) if np.isfinite(value)]
    low, high = 0.5 * min(values) / factor, 2 * max(values) / factor
    for curve, colour in zip(array.hat, _colours(len(array.hat)), strict=True):
        ax.loglog(curve.tau, curve.adev / factor, color=colour, marker="o", markersize=3, label=curve.channel)
        edges = (np.clip(edge / factor, low, high) for edge in (curve.low, curve.high))
        ax.fill_between(curve.tau, *edges, color=colour, alpha=0.12, linewidth=0)
        limits = np.isfinite(curve.upper_limit)
        ax.loglog(curve.tau[limits], curve.upper_limit[limits] / factor, color=colour, marker="v", linestyle="")
    ax.set_ylim(low, high)
    ax.set_title("N-cornered hat; triangles: upper limits")


def _draw_correlations(array: ArrayAnalysis, ax: Any) -> None:  # noqa: ANN401
    ordered = sorted(array.covariances, key=lambda curve: -float(np.max(np.abs(curve.correlation) * (curve.edf > 10))))
    coloured = ordered[:_MOST_PAIRS]
    for curve in ordered[_MOST_PAIRS:]:
        shown = curve.edf > _LEAST_FREEDOM
        ax.semilogx(curve.tau[shown], curve.correlation[shown], color=_GREY, linewidth=0.7)
    for curve, colour in zip(coloured, _colours(len(coloured)), strict=True):
        shown = curve.edf > _LEAST_FREEDOM
        tau, edges = curve.tau[shown], (curve.correlation_low[shown], curve.correlation_high[shown])
        ax.semilogx(tau, curve.correlation[shown], color=colour, linewidth=1.2, label=f"{curve.first}, {curve.second}")
        ax.fill_between(tau, *edges, color=colour, alpha=0.1, linewidth=0)
    ax.axhline(0, color="black", linewidth=0.6)
    ax.set_ylim(-1.02, 1.02)
    ax.set_title("pairs, 95 % intervals")


def _colours(count: int) -> list[str]:
    return [COLOURS[k % len(COLOURS)] for k in range(count)]
