"""Log-log curves in characters, for a terminal."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from sigmatau.plot.curves import COLOURS, CurveLike, curve_unit

__all__ = ["MARKS", "sparkline", "text_plot"]

MARKS = "xyzabcdefgh"
"""Characters of the curves of a panel, in their order."""

_MARGIN = 10
_SPARK_DECADE = 16  # [px]


def sparkline(tau: NDArray[np.float64], adev: NDArray[np.float64]) -> str:
    """A curve as a small picture for a table of a notebook (SVG), log-log, a decade as high as it is wide."""
    there = adev > 0
    if there.sum() < 2:
        return ""
    x, y = np.log10(tau[there]), np.log10(adev[there])
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
        Of one quantity and unit. Where curves meet, the mark of the last one is seen.
    width, height : int
        Of the whole, with the axes.

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
    left, right = (math.log10(end(float(end(t)) for t in taus)) for end in (min, max))
    bottom = math.floor(min(float(level.min()) for level in levels) * 2) / 2
    top = max(math.ceil(max(float(level.max()) for level in levels) * 2) / 2, bottom + 0.5)
    canvas = [[" "] * columns for _ in range(rows)]
    grid = np.linspace(left, right, columns)
    for mark, tau, level in zip(MARKS * len(drawn), taus, levels, strict=False):
        reach = grid <= np.log10(tau[-1]) + 1e-9
        heights = np.interp(grid, np.log10(tau), level)
        for column in np.flatnonzero(reach & (grid >= np.log10(tau[0]) - 1e-9)):
            row = round((top - heights[column]) / (top - bottom) * (rows - 1))
            canvas[row][column] = mark
    label = {0: f"{10**top:.3g}", rows - 1: f"{10**bottom:.3g}"}
    legend = "  ".join(f"{mark} {channel}" for mark, channel in zip(MARKS, drawn, strict=False))
    lines = [f"{'':{_MARGIN}} σ(τ) [{unit}]   {legend}"[:width]]
    lines += [f"{label.get(k, ''):>{_MARGIN}}│{''.join(row)}" for k, row in enumerate(canvas)]
    ends = f"{10**left:.3g}", f"{10**right:.3g} s"
    lines.append(f"{'':{_MARGIN}}└{'─' * columns}")
    lines.append(f"{'':{_MARGIN}} {ends[0]}{' τ':^{max(columns - len(ends[0]) - len(ends[1]), 2)}}{ends[1]}"[:width])
    return lines
