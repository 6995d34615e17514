"""Figures of a temperature calibration: mean against temperature with its polynomial, and the effect of compensation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.errors import OptionError
from sigmatau.lab.temperature.text import mean_unit
from sigmatau.plot.curves import COLOURS
from sigmatau.plot.svg import Drawing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sigmatau.lab.temperature.result import ChannelCalibration, TemperatureCalibration
    from sigmatau.plot.style import Panels

_POINTS = 200
_MARKS = {"rising": "^", "falling": "v", "": "o"}
_LEFT_MARGIN, _RIGHT, _TOP, _BOTTOM = 13.0, 1.0, 1.0, 7.5  # margins of axes [mm]


def draw_calibration(result: TemperatureCalibration, channels: Sequence[str], *, ax: Panels = None) -> Figure:
    """Draw a panel of the mean and a panel of the Allan deviations for each channel with matplotlib."""
    from sigmatau.plot.style import label_axes, legend, make_panels, parent_figure

    unknown = [name for name in channels if name not in result]
    if unknown:
        raise OptionError(f"no channel {unknown[0]!r}; channels: {', '.join(result)}", option="channels")
    chosen = [result[name] for name in channels or result]
    pairs = all(channel.raw is not None for channel in chosen)
    panels = make_panels(ax, len(chosen) * (1 + pairs), columns=2 if pairs else 3, width=5.0, height=3.2)
    for k, channel in enumerate(chosen):
        panel = panels[k * (1 + pairs)]
        unit, size = mean_unit(channel)
        curve = _curve(channel)
        panel.fill_between(curve[0], curve[2], curve[3], color=COLOURS[0], alpha=0.2, linewidth=0)
        panel.plot(curve[0], curve[1], color=COLOURS[0], linewidth=1.2, label=f"polynomial, {100 * result.level:g} %")
        for branch in ("rising", "falling", ""):
            t, mean, low, high = _points(channel, branch)
            if len(t):
                bars = np.nan_to_num(np.array([mean - low, high - mean]))
                colour = COLOURS[1] if branch != "falling" else COLOURS[2]
                panel.errorbar(
                    t, mean, yerr=bars, fmt=_MARKS[branch], color=colour, markersize=4, linewidth=1,
                    label=branch or "runs",
                )  # fmt: skip
        panel.set_title(channel.channel)
        label_axes(panel, "temperature [°C]", f"mean [{unit}]")
        legend(panel)
        if pairs and channel.raw is not None and channel.compensated is not None:
            panel = panels[2 * k + 1]
            for name, deviation, colour in (
                ("as recorded", channel.raw, COLOURS[1]),
                ("compensated", channel.compensated, COLOURS[0]),
            ):
                low, high = deviation.interval()
                panel.fill_between(deviation.tau, low / size, high / size, color=colour, alpha=0.2, linewidth=0)
                panel.loglog(deviation.tau, deviation.adev / size, color=colour, linewidth=1.2, label=name)
            panel.set_title(channel.channel)
            label_axes(panel, "averaging time τ [s]", f"σ(τ) [{unit}]")
            legend(panel)
    return parent_figure(panels[0])


def bias_svg(channel: ChannelCalibration, *, width: float, height: float) -> str:
    """The mean against temperature with its polynomial as SVG; width and height in millimetres."""
    drawing, ax = _axes(width, height)
    t, value, low, high = _curve(channel)
    points = [_points(channel, branch) for branch in ("rising", "falling", "")]
    y = np.concatenate([low, high, *(np.concatenate(part[1:]) for part in points)])
    y = y[np.isfinite(y)]
    y_margin = max(0.06 * float(np.ptp(y)), 1e-9 * float(np.abs(y).max()), 1e-300)
    x_margin = 0.03 * float(np.ptp(t))
    ax.linear_x(float(t[0]) - x_margin, float(t[-1]) + x_margin)
    ax.linear_y(float(y.min()) - y_margin, float(y.max()) + y_margin, count=5)
    ax.area(t, low, high, COLOURS[0])
    ax.line(t, value, COLOURS[0], 0.9)
    for (across, mean, lower, upper), branch, colour in zip(
        points, ("rising", "falling", ""), (COLOURS[1], COLOURS[2], COLOURS[1]), strict=True
    ):
        for x, a, b in zip(across, lower, upper, strict=True):
            ax.line(np.array([x, x]), np.array([a, b]), colour, 0.6)
        ax.markers(across, mean, _MARKS[branch], colour)
    ax.frame("temperature [°C]")
    return drawing.svg()


def deviations_svg(channel: ChannelCalibration, *, width: float, height: float) -> str:
    """The Allan deviations before and after the compensation as SVG; empty without them. Width and height in millimetres."""
    if channel.raw is None or channel.compensated is None:
        return ""
    drawing, ax = _axes(width, height)
    _, size = mean_unit(channel)
    curves = ((channel.raw, COLOURS[1]), (channel.compensated, COLOURS[0]))
    x = np.log10(np.concatenate([curve.tau for curve, _ in curves]))
    y = np.log10(np.concatenate([curve.adev for curve, _ in curves]) / size)
    ax.log_x(float(x.min()) - 0.05, float(x.max()) + 0.05)
    ax.log_y(float(y.min()) - 0.15, float(y.max()) + 0.15)
    for curve, colour in curves:
        tau = np.log10(curve.tau)
        low, high = curve.interval()
        ax.area(tau, np.log10(low / size), np.log10(high / size), colour)
        ax.line(tau, np.log10(curve.adev / size), colour, 0.9)
    ax.frame("averaging time τ [s]")
    return drawing.svg()


def _curve(channel: ChannelCalibration) -> tuple[Floats, Floats, Floats, Floats]:
    """Temperatures, and polynomial with its interval in the usual unit."""
    polynomial, (_, size) = channel.polynomial, mean_unit(channel)
    curve = polynomial.values(np.linspace(polynomial.low, polynomial.high, _POINTS))
    return curve.temperature, curve.value / size, curve.low / size, curve.high / size


def _points(channel: ChannelCalibration, branch: str) -> tuple[Floats, Floats, Floats, Floats]:
    """Temperatures, and means with their intervals in the usual unit, on one branch."""
    _, size = mean_unit(channel)
    windows = [window for window in channel.windows if window.branch == branch]

    def numbers(name: str) -> Floats:
        values = [getattr(window, name) for window in windows]
        return np.array([np.nan if value is None else value for value in values], dtype=np.float64)

    return numbers("temperature"), numbers("mean") / size, numbers("low") / size, numbers("high") / size


def _axes(width: float, height: float) -> tuple[Drawing, Any]:
    drawing = Drawing(width, height, font="system-ui, sans-serif")
    return drawing, drawing.axes(_LEFT_MARGIN, _TOP, width - _LEFT_MARGIN - _RIGHT, height - _TOP - _BOTTOM)
