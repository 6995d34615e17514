"""Figures of noise models: over a record's curve, and the navigation errors predicted from them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.noise.shown import error_unit
from sigmatau.plot.curves import CurveLike, curve_unit, draw_curve
from sigmatau.plot.style import check_panels, legend, new_figure, parent_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from sigmatau.plot.style import Panels


_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
_TITLES = {"rad": "angle", "m/s": "velocity", "m": "position"}


class ErrorLike(Protocol):
    """Attributes of `sigmatau.navigation.prediction.PredictedError` that are drawn."""

    @property
    def unit(self) -> str: ...
    @property
    def after(self) -> Floats: ...
    @property
    def rms(self) -> Floats: ...
    @property
    def low(self) -> Floats | None: ...
    @property
    def high(self) -> Floats | None: ...
    @property
    def at_most(self) -> Floats | None: ...


def draw_prediction(errors: Mapping[str, ErrorLike], *, marked: Floats, ax: Panels = None) -> Figure:
    """Draw errors against time, log-log, one panel per unit, with dots at the times nearest to the marked times."""
    units = [unit for unit in _TITLES if any(error.unit == unit for error in errors.values())]
    panels = check_panels(ax, len(units)) or list(
        new_figure(4.6 * len(units), 4.2).subplots(1, len(units), squeeze=False)[0]
    )
    for ax, unit in zip(panels, units, strict=True):
        text, factor = error_unit(unit)
        limited = False
        shown = [(name, error) for name, error in errors.items() if error.unit == unit]
        for k, (name, error) in enumerate(shown):
            colour = _COLOURS[k % len(_COLOURS)]
            if error.low is not None and error.high is not None:
                ax.fill_between(
                    error.after, error.low / factor, error.high / factor, color=colour, alpha=0.2, linewidth=0
                )
            dots = sorted({int(np.argmin(np.abs(np.log(error.after / time)))) for time in marked.tolist()})
            ax.loglog(
                error.after, error.rms / factor, color=colour, marker="o", markersize=4, markevery=dots, label=name
            )
            if error.at_most is not None:
                ax.loglog(error.after, error.at_most / factor, "--", color=colour, linewidth=1)
                limited = True
        if limited:
            ax.plot([], [], "--", color="0.4", linewidth=1, label="at most, with terms that were not seen")
        _whole_decades(ax)
        ax.set_xlabel("time since the start [s]")
        ax.set_ylabel(f"error of the {_TITLES[unit]}, rms [{text}]")
        ax.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
        legend(ax)
    return parent_figure(panels[0])


def _whole_decades(ax: Axes) -> None:
    """Limits of at least a decade, with labels at powers of ten only, so that labels do not overlap."""
    from matplotlib.ticker import LogLocator, NullFormatter

    for axis, limits, put in ((ax.xaxis, ax.get_xlim(), ax.set_xlim), (ax.yaxis, ax.get_ylim(), ax.set_ylim)):
        low, high = sorted(limits)
        if high < 10 * low:
            put(10 ** math.floor(math.log10(low)), 10 ** math.ceil(math.log10(high)))
        axis.set_major_locator(LogLocator(numticks=7))
        axis.set_minor_formatter(NullFormatter())


def draw_verification(
    curve: CurveLike, avar: Floats, label: str, *, ax: Axes | None = None, unit: str | None = None
) -> Axes:
    """Draw a record's curve with its band, and the curve of a model at the same averaging times."""
    ax = draw_curve(curve, ax=ax, unit=unit)
    factor, _ = curve_unit(curve, unit)
    ax.plot(curve.tau, np.sqrt(avar) / factor, color=_COLOURS[1], linewidth=1.3, zorder=3, label=label)
    ax.fill_between([], [], [], color=_COLOURS[0], alpha=0.18, linewidth=0, label="band by χ² if the model is true")
    legend(ax)
    return ax


def draw_verifications(verified: Mapping[str, tuple[CurveLike, Floats, str]], *, ax: Panels = None) -> Figure:
    """Draw one panel per channel."""
    columns = min(len(verified), 3)
    rows = math.ceil(len(verified) / columns)
    panels = check_panels(ax, len(verified))
    if panels is None:
        panels = list(new_figure(5.2 * columns, 4.2 * rows).subplots(rows, columns, squeeze=False).flat)
    for panel, (curve, avar, label) in zip(panels, verified.values(), strict=False):
        draw_verification(curve, avar, label, ax=panel)
    for panel in panels[len(verified) :]:
        panel.set_visible(False)
    return parent_figure(panels[0])
