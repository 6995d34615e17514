"""Fig. 12 of the paper: Allan deviations of one sensor at several sampling rates, and N against the sampling rate."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.digits import two_digits
from sigmatau.noise.terms import display_units
from sigmatau.plot.curves import COLOURS, MARKERS, CurveLike, curve_unit, draw_line
from sigmatau.plot.style import check_panels, legend, new_figure, parent_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from sigmatau.plot.style import Panels


class IntervalLike(Protocol):
    """Attributes of `sigmatau.fitting.fitted_values.Interval` that are drawn."""

    @property
    def value(self) -> float: ...
    @property
    def low(self) -> float | None: ...
    @property
    def high(self) -> float | None: ...


class LogLike(Protocol):
    """Attributes of `sigmatau.fitting.sensor_bandwidth.LoggedRate` that are drawn."""

    @property
    def name(self) -> str: ...
    @property
    def rate(self) -> float: ...
    @property
    def curve(self) -> CurveLike: ...
    @property
    def random_walk(self) -> IntervalLike: ...


class AliasingLike(Protocol):
    """Attributes of `sigmatau.fitting.sensor_bandwidth.AliasingCurve` that are drawn."""

    @property
    def rate(self) -> Floats: ...
    @property
    def factor(self) -> Floats: ...
    @property
    def low(self) -> Floats: ...
    @property
    def high(self) -> Floats: ...


class BandwidthLike(Protocol):
    """Attributes of `sigmatau.fitting.sensor_bandwidth.SensorBandwidth` that are drawn."""

    @property
    def channel(self) -> str: ...
    @property
    def quantity(self) -> str: ...
    @property
    def unit(self) -> str: ...
    @property
    def shape(self) -> str: ...
    @property
    def logs(self) -> Sequence[LogLike]: ...
    @property
    def bandwidth(self) -> IntervalLike: ...
    @property
    def random_walk(self) -> IntervalLike: ...
    @property
    def rate_needed(self) -> IntervalLike: ...
    @property
    def aliasing(self) -> AliasingLike: ...
    @property
    def tolerance(self) -> float: ...
    @property
    def paper_rates(self) -> tuple[float, float]: ...


def draw_bandwidth(result: BandwidthLike, *, ax: Panels = None, unit: str | None = None) -> Figure:
    """Draw the curves of all logs, and beside them N of each log with the fitted aliasing and the recommended rates."""
    curves, rates = check_panels(ax, 2) or new_figure(10.5, 4.6).subplots(1, 2, width_ratios=(1.15, 1))
    for k, log in enumerate(result.logs):
        factor, text = curve_unit(log.curve, unit)
        name = f"{log.rate:.6g} Hz"
        draw_line(
            curves, name, log.curve.tau, log.curve.adev / factor, COLOURS[k % len(COLOURS)], MARKERS[k % len(MARKERS)]
        )
        curves.set_ylabel(f"Allan deviation σ(τ) [{text}]")
    curves.set_title(result.channel)
    legend(curves)
    _draw_rates(result, rates)
    return parent_figure(curves)


def _draw_rates(result: BandwidthLike, ax: Axes) -> None:
    n = result.random_walk
    walks = [n.value, *(log.random_walk.value for log in result.logs)]
    text, factor = display_units("random_walk", result.quantity, result.unit, walks)[0]
    if n.low is not None and n.high is not None:
        aliasing = result.aliasing
        ax.fill_between(
            aliasing.rate,
            n.value * aliasing.low / factor,
            n.value * aliasing.high / factor,
            color=COLOURS[0],
            alpha=0.25,
            linewidth=0,
        )
        ax.plot(
            aliasing.rate,
            n.value * aliasing.factor / factor,
            color=COLOURS[0],
            linewidth=1.3,
            label=f"N with aliasing, {result.shape}",
        )
        ax.axhspan(
            n.low / factor, n.high / factor, color=COLOURS[2], alpha=0.3, linewidth=0, label="N without aliasing, 95 %"
        )
        low, high = result.paper_rates
        ax.axvspan(low, high, color="0.5", alpha=0.15, linewidth=0, label="the paper: 3 to 5 times the bandwidth")
        label = f"aliasing adds {100 * result.tolerance:.3g} %: {two_digits(result.rate_needed.value)} Hz"
        ax.axvline(result.rate_needed.value, color=COLOURS[1], linestyle="--", linewidth=1.1, label=label)
    for k, log in enumerate(result.logs):
        value, begin, end = log.random_walk.value, log.random_walk.low, log.random_walk.high
        error = None if begin is None or end is None else np.array([[value - begin], [end - value]]) / factor
        ax.errorbar(
            [log.rate], [value / factor], error, fmt=MARKERS[k % len(MARKERS)], color=COLOURS[k % len(COLOURS)],
            markersize=5, linewidth=1.2,
        )  # fmt: skip
    ax.set_xscale("log")
    ax.set_ylim(bottom=0)
    ax.set_xlabel("sampling rate [Hz]")
    ax.set_ylabel(f"random walk N in the log [{text}]")
    ax.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
    if n.low is not None:
        legend(ax)
