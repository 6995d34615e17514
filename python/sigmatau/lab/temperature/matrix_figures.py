"""Figures of a matrix unit × temperature: a line for each unit, and the median."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sigmatau.lab.temperature.matrix import MatrixTable, TemperatureMatrix
from sigmatau.plot.curves import COLOURS
from sigmatau.plot.svg import Drawing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sigmatau.plot.style import Panels

_FAINT = "#9aa3ad"
_LEFT_MARGIN, _RIGHT, _TOP, _BOTTOM = 13.0, 1.0, 1.0, 7.5  # margins of axes [mm]


def draw_matrix(matrix: TemperatureMatrix, *, ax: Panels = None) -> Figure:
    """Draw a panel for each table with matplotlib."""
    from sigmatau.plot.style import label_axes, legend, make_panels, parent_figure

    tables = list(matrix.tables())
    panels = make_panels(ax, len(tables), columns=3, width=4, height=3)
    t = np.array(matrix.temperatures)
    for panel, table in zip(panels, tables, strict=True):
        for row in table.values:
            shown = np.isfinite(row)
            panel.plot(t[shown], row[shown], color=_FAINT, linewidth=0.6, marker="o", markersize=2)
        shown, median = _median(table)
        panel.plot(t[shown], median, color=COLOURS[0], linewidth=1.6, marker="o", markersize=4, label="median")
        panel.set_title(table.title)
        label_axes(panel, "temperature [°C]", f"[{table.unit}]")
        legend(panel)
    return parent_figure(panels[0])


def table_svg(matrix: TemperatureMatrix, table: MatrixTable, *, width: float, height: float) -> str:
    """The panel of a table as SVG; width and height in millimetres."""
    drawing = Drawing(width, height, font="system-ui, sans-serif")
    ax = drawing.axes(_LEFT_MARGIN, _TOP, width - _LEFT_MARGIN - _RIGHT, height - _TOP - _BOTTOM)
    t, y = np.array(matrix.temperatures), table.values[np.isfinite(table.values)]
    x_margin = 0.05 * float(np.ptp(t)) or 1.0
    y_margin = max(0.06 * float(np.ptp(y)), 1e-3 * float(y.max()), 1e-300)
    ax.linear_x(float(t.min()) - x_margin, float(t.max()) + x_margin)
    ax.linear_y(float(y.min()) - y_margin, float(y.max()) + y_margin, count=5)
    for row in table.values:
        shown = np.isfinite(row)
        ax.line(t[shown], row[shown], _FAINT, 0.4)
        ax.markers(t[shown], row[shown], "o", _FAINT)
    shown, median = _median(table)
    ax.line(t[shown], median, COLOURS[0], 1.0)
    ax.markers(t[shown], median, "o", COLOURS[0])
    ax.frame("temperature [°C]")
    return drawing.svg()


def _median(table: MatrixTable) -> tuple[np.ndarray, np.ndarray]:
    """Temperatures with a value, and the median of the units at each."""
    shown = np.isfinite(table.values).any(axis=0)
    return shown, np.nanmedian(table.values[:, shown], axis=0)
