"""A vector drawing: its visible paths and texts in the coordinates of the page, with y downwards."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import Floats
from sigmatau.frozen import frozen

MAX_BYTES = 64_000_000
"""Largest file that is read [bytes]. Judgement: datasheets have up to 20 MB, of which most are pictures."""

MAX_VERTICES = 2_000_000
"""Largest number of vertices of a drawing. Measured: 10 s."""

MAX_OBJECTS = 100_000
"""Largest number of paths and texts of a drawing, after the expansion of references. Measured: 10 s."""

MAX_DEPTH = 100
"""Largest depth of groups within groups."""

TOO_COMPLEX = "has too many paths. Export the figure alone, without other parts of the page"


@frozen(eq=False)
class Box:
    """A rectangle."""

    x_min: float
    y_min: float
    x_max: float
    y_max: float

    def cut(self, box: Box) -> Box:
        """The common part; empty if x_max is less than x_min."""
        return Box(
            x_min=max(self.x_min, box.x_min),
            y_min=max(self.y_min, box.y_min),
            x_max=min(self.x_max, box.x_max),
            y_max=min(self.y_max, box.y_max),
        )


EVERYWHERE = Box(x_min=-1e30, y_min=-1e30, x_max=1e30, y_max=1e30)


def bounding_box(points: Floats) -> Box:
    """The smallest rectangle around points."""
    (x_min, y_min), (x_max, y_max) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    return Box(x_min=x_min, y_min=y_min, x_max=x_max, y_max=y_max)


@frozen(eq=False)
class Path:
    """A visible path without interruption.

    Attributes
    ----------
    points : ndarray, shape (n, 2)
        Vertices, and points within Bézier segments.
    is_end : ndarray of bool, shape (n,)
        Whether a point is the end of a segment.
    color : str
        ``"#1f77b4"``; that of the stroke, of a path without a stroke that of the filling.
    width : float
        Width of the line; 0 without a stroke.
    is_closed : bool
    quantum : float
        Resolution of the coordinates in the file.
    clip : Box
        Region in which the path is visible.
    """

    points: Floats
    is_end: NDArray[np.bool_]
    color: str
    width: float
    is_closed: bool
    quantum: float
    clip: Box


@frozen(eq=False)
class TextPiece:
    """A piece of horizontal text: its ends, its baseline and the size of the font."""

    text: str
    start: float
    end: float
    baseline: float
    size: float


@frozen(eq=False)
class FigurePage:
    """What is visible on a page; `titles` are the texts that are not horizontal."""

    width: float
    height: float
    paths: tuple[Path, ...]
    texts: tuple[TextPiece, ...]
    titles: tuple[str, ...]
    has_image: bool
