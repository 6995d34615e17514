"""Forest plots: the value of each run with its interval, their mean, and the prediction interval of one more run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.distributions import normal_quantile
from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.lab.lots.comparison_text import COMPARED, display_unit, in_order, term_name
from sigmatau.lab.lots.runs import MEAN, SIGNED
from sigmatau.noise.terms import TERMS
from sigmatau.plot.style import check_panels, new_figure, parent_figure, small
from sigmatau.record import stream_name

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from sigmatau.lab.lots.comparison import RunComparison
    from sigmatau.plot.style import Panels

_MOST_PANELS = 24
_MOST_NAMES = 40  # runs whose names are written
_ROW = 0.17  # height of the row of a run [in]
_MOST_HEIGHT = 5.0  # largest height of a panel [in]
_COLUMNS = 3
_PLAIN = (-4, 8)  # powers of ten without an exponent at the corner of the axis: 9.8 m/s² is 1e6 µg


@frozen(eq=False)
class ForestPanel:
    """Content of the panel of one channel and term, in the unit of the axis."""

    title: str
    unit: str
    names: Sequence[str]  # names of the runs
    value: NDArray[np.float64]
    low: NDArray[np.float64]  # ends of the intervals, NaN if not known
    high: NDArray[np.float64]
    odd: int | None  # index of the outlier
    mean: float
    mean_low: float | None
    mean_high: float | None
    next_low: float | None
    next_high: float | None
    level: float  # confidence level of the intervals
    compared: str  # "run", "unit" or "result"
    row: str = ""  # panels of the same row are drawn side by side


def draw_forests(panels: Sequence[ForestPanel], *, ax: Panels = None) -> Figure:
    """Draw panels side by side, or in the given axes."""
    panels = panels[:_MOST_PANELS]
    if (chosen := check_panels(ax, len(panels))) is not None:
        for axes, panel in zip(chosen, panels, strict=True):
            draw_forest(panel, axes, named=True)
        return parent_figure(chosen[0])
    places = _places(panels)
    columns = 1 + max(column for _, column in places)
    down = 1 + max(row for row, _ in places)
    rows = max(len(panel.names) for panel in panels)
    height = min(0.9 + _ROW * rows, _MOST_HEIGHT)
    figure = new_figure(1.0 + 3.6 * columns, 0.6 + height * down)
    all_axes = figure.subplots(down, columns, squeeze=False)
    for k, (place, panel) in enumerate(zip(places, panels, strict=True)):
        same = place[1] and list(panel.names) == list(panels[k - 1].names)
        draw_forest(panel, all_axes[place], named=not same)
    for row in range(down):
        for column in range(columns):
            if (row, column) not in places:
                all_axes[row, column].set_axis_off()
    handles, labels = all_axes[places[0]].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, fontsize=small(), frameon=False)
    return figure


def _places(panels: Sequence[ForestPanel]) -> list[tuple[int, int]]:
    """Row and column of each panel."""
    places: list[tuple[int, int]] = []
    for k, panel in enumerate(panels):
        if k and panel.row == panels[k - 1].row and places[-1][1] + 1 < _COLUMNS:
            places.append((places[-1][0], places[-1][1] + 1))
        else:
            places.append((places[-1][0] + 1 if places else 0, 0))
    return places


def draw_forest(panel: ForestPanel, ax: Axes, *, named: bool) -> None:
    """Draw one panel. `named`: whether the names of the runs are written."""
    count = len(panel.names)
    rows = np.arange(count)[::-1]
    level = f"{100 * panel.level:g} %"
    if panel.next_low is not None and panel.next_high is not None:
        ax.axvspan(
            panel.next_low,
            panel.next_high,
            color="0.93",
            lw=0,
            label=f"{level} prediction interval of one more {panel.compared}",
        )
    if panel.mean_low is not None and panel.mean_high is not None:
        ax.axvspan(panel.mean_low, panel.mean_high, color="0.82", lw=0, label=f"{level} interval of the mean")
    ax.axvline(panel.mean, color="0.35", lw=0.8)
    size = 4.0 if count <= _MOST_NAMES else 1.5
    for chosen, colour in ((np.arange(count) != panel.odd, "C0"), (np.arange(count) == panel.odd, "C3")):
        ends = np.abs(np.array([panel.value - panel.low, panel.high - panel.value]))[:, chosen]
        if chosen.any():
            ax.errorbar(
                panel.value[chosen], rows[chosen], xerr=np.nan_to_num(ends), fmt="o", ms=size, lw=1.0, color=colour
            )
    ax.set_title(panel.title, fontsize=small() + 1)
    ax.set_xlabel(panel.unit.replace("^{3/2}", "$^{3/2}$"), fontsize=small())
    ax.tick_params(labelsize=small())
    ax.set_ylim(-0.7, count - 0.3)
    if named and count <= _MOST_NAMES:
        ax.set_yticks(rows, [_shortened(name) for name in panel.names], fontsize=small())
    else:
        ax.set_yticks(rows if count <= _MOST_NAMES else [], [])
    ax.xaxis.set_major_locator(_few_ticks())
    ax.ticklabel_format(axis="x", useOffset=False, scilimits=_PLAIN)
    values = np.concatenate([panel.low, panel.high, panel.value])
    ends_ = [x for x in (panel.next_low, panel.next_high) if x is not None]
    spread = float(np.nanmax(values) - np.nanmin(values))
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    # with two or three runs the prediction interval is far wider than the values
    if ends_ and max(ends_) - min(ends_) < 4 * spread:
        low, high = min(low, *ends_), max(high, *ends_)
    margin = 0.06 * (high - low) or 0.05 * abs(high) or 1.0
    ax.set_xlim(low - margin, high + margin)


def _few_ticks() -> Any:  # noqa: ANN401  a locator
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(4)


def _shortened(name: str) -> str:
    return name if len(name) <= 18 else f"…{name[-17:]}"


def forest_panels(comparison: RunComparison, channels: Sequence[str]) -> list[ForestPanel]:
    """Build a panel for each channel and term that at least two runs of the first group show; terms of a channel side by
    side.
    """
    known_channels = dict.fromkeys(label.channel for label in comparison.table.labels)
    if unknown := [name for name in channels if name not in known_channels]:
        raise OptionError(f"no channel {unknown[0]!r}; channels: {', '.join(known_channels)}", option="channels")
    in_first_group = comparison.cells.group == 0
    rows = in_order(comparison, np.flatnonzero(in_first_group & (comparison.cells.valued > 1)).tolist())
    if channels:
        rows = [row for row in rows if comparison.key(row)[1].channel in channels]
    if not rows:
        what = {"unit": "two runs of a unit", "run": "two units in one run", "axis": "two results of an axis"}
        raise DataError(f"nothing to draw: no term is observed in {what[comparison.by]}")
    # Panels of one row are the axes of a sensor.
    rows.sort(key=lambda row: _place(comparison, row))
    return [_panel(comparison, row) for row in rows]


def _place(comparison: RunComparison, row: int) -> tuple[bool, str, int]:
    label = comparison.key(row)[1]
    sensor = stream_name(label.channel)
    return sensor != "gyro", sensor, [*TERMS, MEAN].index(label.term)


def _panel(comparison: RunComparison, row: int) -> ForestPanel:
    _, label = comparison.key(row)
    effects = comparison.row(row)
    unit, size = display_unit(label, [effects.mean])
    listed = comparison.values(row)
    value = np.array([number for _, number, _ in listed])
    error = np.array([number for *_, number in listed])
    half = float(normal_quantile((1 + comparison.level) / 2)) * error
    signed = label.term in SIGNED
    low, high = (value - half, value + half) if signed else (value * np.exp(-half), value * np.exp(half))
    outlier = comparison.outliers().get(row)
    names = [run.serial if comparison.by == "run" and run.serial else run.name for run, _, _ in listed]

    def scaled(x: float | None) -> float | None:
        return None if x is None else x / size

    return ForestPanel(
        title=f"{label.channel} {term_name(label)}",
        unit=unit,
        names=names,
        value=value / size,
        low=low / size,
        high=high / size,
        odd=None if outlier is None else next(k for k, (run, _, _) in enumerate(listed) if run is outlier),
        mean=effects.mean / size,
        mean_low=scaled(effects.low),
        mean_high=scaled(effects.high),
        next_low=scaled(effects.next_low),
        next_high=scaled(effects.next_high),
        level=comparison.level,
        compared=COMPARED[comparison.by],
        row=f"{stream_name(label.channel)} {label.term}",
    )
