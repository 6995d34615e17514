"""Transforms of points, segments of paths, and the resolution of coordinates."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import Floats
from sigmatau.io.read.figure.drawing import Box, Path

Matrix = tuple[float, float, float, float, float, float]
"""a, b, c, d, e, f: x' = a·x + c·y + e, y' = b·x + d·y + f."""

IDENTITY: Matrix = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)

_INNER = np.arange(1, 9) / 9.0  # parameters of the points within a Bézier segment

_MAX_DECIMALS = 4  # of coordinates; a finer resolution has no effect


def combined(outer: Matrix, inner: Matrix) -> Matrix:
    """The transform that applies `inner`, then `outer`."""
    a, b, c, d, e, f = outer
    g, h, i, j, k, m = inner
    return (a * g + c * h, b * g + d * h, a * i + c * j, b * i + d * j, a * k + c * m + e, b * k + d * m + f)


def applied(matrix: Matrix, points: Floats) -> Floats:
    """Transform points of shape (n, 2)."""
    a, b, c, d, e, f = matrix
    result: Floats = points @ np.array([[a, b], [c, d]]) + np.array([e, f])
    return result


def magnification(matrix: Matrix) -> float:
    """Mean magnification."""
    a, b, c, d, _, _ = matrix
    return math.sqrt(abs(a * d - b * c))


def resolution(points: Floats) -> float:
    """The power of ten of which all coordinates are multiples."""
    for decimals in range(_MAX_DECIMALS):
        scaled = points * 10.0**decimals
        # Coordinates of PDF files are numbers of 32 bits.
        if np.all(np.abs(scaled - np.round(scaled)) <= 1e-6 * np.abs(scaled) + 1e-9):
            return float(10.0**-decimals)
    return float(10.0**-_MAX_DECIMALS)


class Pen:
    """Collects the subpaths of a path: vertices, and points within Bézier segments."""

    def __init__(self) -> None:
        self.subpaths: list[tuple[Floats, NDArray[np.bool_], bool]] = []
        self.vertices: int = 0
        self._points: list[tuple[float, float]] = []
        self._ends: list[bool] = []

    @property
    def place(self) -> tuple[float, float]:
        """The current point."""
        return self._points[-1] if self._points else (0.0, 0.0)

    def move(self, x: float, y: float) -> None:
        """Begin a subpath."""
        self._flush(closed=False)
        self._points, self._ends = [(x, y)], [True]

    def line(self, x: float, y: float) -> None:
        """Add a straight segment."""
        self._points.append((x, y))
        self._ends.append(True)
        self.vertices += 1

    def curve(self, controls: tuple[tuple[float, float], tuple[float, float]], end: tuple[float, float]) -> None:
        """Add a cubic Bézier segment."""
        t = _INNER[:, None]
        start, (first, second) = np.array(self.place), np.array(controls)
        inner = (1 - t) ** 3 * start + 3 * (1 - t) ** 2 * t * first + 3 * (1 - t) * t**2 * second + t**3 * np.array(end)
        self._points += [(x, y) for x, y in inner.tolist()]
        self._ends += [False] * len(t)
        self.line(*end)

    def close(self) -> None:
        """Close the subpath."""
        if self._points:
            start = self._points[0]
            self._flush(closed=True)
            self._points, self._ends = [start], [True]

    def finish(self) -> None:
        """End the path."""
        self._flush(closed=False)
        self._points, self._ends = [], []

    def _flush(self, *, closed: bool) -> None:
        if len(self._points) > 1:
            points = np.array(self._points, dtype=np.float64)
            self.subpaths.append((points, np.array(self._ends), closed))

    def paths(self, matrix: Matrix, *, color: str, width: float, clip: Box) -> list[Path]:
        """The subpaths in the coordinates of the page. Those with numbers that are not finite are left out."""
        self.finish()
        if not self.subpaths:
            return []
        scale = magnification(matrix)
        ends = [points[is_end] for points, is_end, _ in self.subpaths]
        if not all(np.isfinite(points).all() for points in ends):
            return []
        quantum = scale * resolution(np.concatenate(ends))
        return [
            Path(
                points=applied(matrix, points),
                is_end=is_end,
                color=color,
                width=width * scale,
                is_closed=closed,
                quantum=quantum,
                clip=clip,
            )
            for points, is_end, closed in self.subpaths
        ]
