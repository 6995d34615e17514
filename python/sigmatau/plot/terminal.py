"""Log-log curves in Braille dots for a terminal, and as small pictures for a notebook."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from sigmatau.digits import significant
from sigmatau.findings.phrases import short_axes
from sigmatau.plot.curves import COLOURS, CurveLike, curve_unit
from sigmatau.results import seconds

_BRAILLE = 0x2800  # the empty cell; a dot is a bit
_BITS = np.array([0x01, 0x08, 0x02, 0x10, 0x04, 0x20, 0x40, 0x80])  # of the dots row by row
_MARGIN = 8
_SPARK_DECADE = 16  # [px]


def sparkline(tau: NDArray[np.float64], adev: NDArray[np.float64]) -> str:
    """A curve as a small picture for a table of a notebook (SVG), log-log, a decade as high as it is wide."""
    positive = adev > 0
    if positive.sum() < 2:
        return ""
    x, y = np.log10(tau[positive]), np.log10(adev[positive])
    size = _SPARK_DECADE * (x - x[0]), _SPARK_DECADE * (y.max() - y)
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(size[0] + 1, size[1] + 1, strict=True))
    width, height = size[0].max() + 2, size[1].max() + 2
    return (
        f'<svg width="{width:.0f}" height="{height:.0f}"><polyline points="{points}" fill="none" stroke="{COLOURS[0]}"'
        ' stroke-width="1.5"/></svg>'
    )


def text_plot(curves: Mapping[str, CurveLike], *, width: int, height: int) -> list[str]:
    """Allan deviations against averaging time, in lines of at most `width` characters.

    Parameters
    ----------
    curves : mapping of str to DeviationCurve
        Curves with the same quantity and unit.
    width, height : int
        Size of the whole picture, with the axes.

    Returns
    -------
    list of str
        Empty if there is nothing to draw.
    """
    columns, rows = width - _MARGIN - 1, height - 3
    drawn = {c: curve for c, curve in curves.items() if (curve.adev > 0).sum() > 1}
    if not drawn or columns < 10 or rows < 3:
        return []
    factor, unit = curve_unit(next(iter(drawn.values())), None)
    taus = [curve.tau[curve.adev > 0] for curve in drawn.values()]
    levels = [np.log10(curve.adev[curve.adev > 0] / factor) for curve in drawn.values()]
    first, last = (math.log10(end(float(end(t)) for t in taus)) for end in (min, max))
    bottom = math.floor(min(float(level.min()) for level in levels) * 2) / 2
    top = max(math.ceil(max(float(level.max()) for level in levels) * 2) / 2, bottom + 0.5)
    dots = np.zeros((4 * rows, 2 * columns), dtype=np.bool_)
    grid = np.linspace(first, last, 2 * columns)
    for tau, level in zip(taus, levels, strict=True):
        reach = grid <= np.log10(tau[-1]) + 1e-9
        heights = np.interp(grid, np.log10(tau), level)
        for column in np.flatnonzero(reach & (grid >= np.log10(tau[0]) - 1e-9)):
            dots[round((top - heights[column]) / (top - bottom) * (4 * rows - 1)), column] = True
    cells = dots.reshape(rows, 4, columns, 2).transpose(0, 2, 1, 3).reshape(rows, columns, 8) @ _BITS
    canvas = [[chr(_BRAILLE + bits) for bits in row] for row in cells.tolist()]
    label = {0: significant(10**top), rows - 1: significant(10**bottom)}
    lines = [f"{'':{_MARGIN}} σ(τ) [{unit}]   {short_axes(tuple(drawn))}"[:width]]
    lines += [f"{label.get(k, ''):>{_MARGIN}}│{''.join(row)}" for k, row in enumerate(canvas)]
    ends = significant(10**first), f"{seconds(10**last)} s"
    lines.append(f"{'':{_MARGIN}}└{'─' * columns}")
    lines.append(f"{'':{_MARGIN}} {ends[0]}{' τ':^{max(columns - len(ends[0]) - len(ends[1]), 2)}}{ends[1]}"[:width])
    return lines
