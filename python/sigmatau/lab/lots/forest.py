"""Forest plots: the value of each run with its interval, their mean, and the prediction interval of another run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from sigmatau._native.distributions import normal_quantile
from sigmatau.errors import DataError, OptionError
from sigmatau.lab.lots.comparison_text import COMPARED, display_unit, in_order, term_name
from sigmatau.lab.lots.runs import MEAN, SIGNED
from sigmatau.lab.lots.short_names import short_names
from sigmatau.noise.terms import TERMS
from sigmatau.plot.style import make_panels, parent_figure, small
from sigmatau.record import stream_name

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from sigmatau.lab.lots.comparison import RunComparison
    from sigmatau.plot.style import Panels

_MOST_PANELS = 24  # largest number of panels
_MOST_NAMES = 40  # largest number of runs whose names are written
_ROW = 0.17  # height of the row of a run [in]
_LARGEST_HEIGHT = 5.0  # largest height of a panel [in]
_PLAIN = (-4, 8)  # range of powers of ten that are printed without an exponent: 9.8 m/s² is 1e6 µg


def draw_forests(comparison: RunComparison, channels: Sequence[str], *, ax: Panels = None) -> Figure:
    """Draw a panel for each channel and term of the first group that two runs show, axes of a sensor side by side."""
    rows = _chosen_rows(comparison, channels)[:_MOST_PANELS]
    most_runs = max(int(comparison.cells.valued[row]) for row in rows)
    panels = make_panels(ax, len(rows), columns=3, width=4.0, height=min(0.9 + _ROW * most_runs, _LARGEST_HEIGHT))
    for panel, row in zip(panels, rows, strict=True):
        _draw(comparison, row, panel)
    figure = parent_figure(panels[0])
    if ax is None:
        figure.legend(
            *panels[0].get_legend_handles_labels(),
            loc="outside lower center", ncols=2, fontsize=small(), frameon=False,
        )  # fmt: skip
    return figure


def _chosen_rows(comparison: RunComparison, channels: Sequence[str]) -> list[int]:
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

    def sort_key(row: int) -> tuple[bool, str, int]:
        label = comparison.key(row)[1]
        sensor = stream_name(label.channel)
        return sensor != "gyro", sensor, [*TERMS, MEAN].index(label.term)

    return sorted(rows, key=sort_key)


def _draw(comparison: RunComparison, row: int, ax: Axes) -> None:
    """Draw a row as a panel, in the usual unit of the term."""
    label, effects = comparison.key(row)[1], comparison.row(row)
    unit, size = display_unit(label, [effects.mean])
    listed = comparison.values(row)
    value, error = (np.array([run[k] for run in listed]) for k in (1, 2))
    half = float(normal_quantile((1 + comparison.level) / 2)) * error
    low, high = (value - half, value + half) if label.term in SIGNED else (value * np.exp(-half), value * np.exp(half))
    value, low, high = value / size, low / size, high / size
    level = f"{100 * comparison.level:g} %"
    prediction = [end / size for end in (effects.next_low, effects.next_high) if end is not None]
    of_mean = [end / size for end in (effects.low, effects.high) if end is not None]
    prediction_label = f"{level} prediction interval of one more {COMPARED[comparison.by]}"
    for ends, grey, text in (
        (prediction, "0.93", prediction_label),
        (of_mean, "0.82", f"{level} interval of the mean"),
    ):
        if len(ends) == 2:
            ax.axvspan(*ends, color=grey, lw=0, label=text)
    ax.axvline(effects.mean / size, color="0.35", lw=0.8)
    count = len(listed)
    places = np.arange(count)[::-1]
    outlier = comparison.outliers().get(row)
    is_odd = np.array([run is outlier for run, _, _ in listed])
    for chosen, colour in ((~is_odd, "C0"), (is_odd, "C3")):
        reach = np.nan_to_num(np.abs([value - low, high - value]))[:, chosen]
        if chosen.any():
            marker_size = 4.0 if count <= _MOST_NAMES else 1.5
            ax.errorbar(
                value[chosen], places[chosen], xerr=reach, fmt="o", ms=marker_size, lw=1.0, color=colour
            )  # fmt: skip
    ax.set_title(f"{label.channel} {term_name(label)}", fontsize=small() + 1)
    ax.set_xlabel(unit.replace("^{3/2}", "$^{3/2}$"), fontsize=small())
    ax.tick_params(labelsize=small())
    ax.set_ylim(-0.7, count - 0.3)
    names = [run.serial if comparison.by == "run" and run.serial else run.name for run, _, _ in listed]
    is_named = count <= _MOST_NAMES
    ax.set_yticks(places if is_named else [], short_names(names) if is_named else [])
    values = np.concatenate([low, high, value])
    ends_of_axis = float(np.nanmin(values)), float(np.nanmax(values))
    if len(prediction) == 2 and prediction[1] - prediction[0] < 4 * (ends_of_axis[1] - ends_of_axis[0]):
        ends_of_axis = (
            min(*ends_of_axis, *prediction),
            max(*ends_of_axis, *prediction),
        )  # the prediction interval of a few runs is much wider, and is then cut
    limit_axis(ax, *ends_of_axis)


def limit_axis(ax: Axes, low: float, high: float) -> None:
    """Set the limits of the axis, with few ticks and no offset, because values may be close together and far from 0."""
    from matplotlib.ticker import MaxNLocator

    ax.xaxis.set_major_locator(MaxNLocator(4))
    ax.ticklabel_format(axis="x", useOffset=False, scilimits=_PLAIN)
    margin = 0.06 * (high - low) or 0.05 * abs(high) or 1.0
    ax.set_xlim(low - margin, high + margin)
