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

    left: float
    top: float
    right: float
    bottom: float

    def cut(self, box: Box) -> Box:
        """The common part; empty if right is less than left."""
        return Box(
            left=max(self.left, box.left),
            top=max(self.top, box.top),
            right=min(self.right, box.right),
            bottom=min(self.bottom, box.bottom),
        )


EVERYWHERE = Box(left=-1e30, top=-1e30, right=1e30, bottom=1e30)


def box_around(points: Floats) -> Box:
    """The smallest rectangle around points."""
    (left, top), (right, bottom) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    return Box(left=left, top=top, right=right, bottom=bottom)


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
class Text:
    """A piece of horizontal text: its ends, its baseline and the size of the font."""

    text: str
    left: float
    right: float
    baseline: float
    size: float


@frozen(eq=False)
class Drawing:
    """What is visible on a page."""

    width: float
    height: float
    paths: tuple[Path, ...]
    texts: tuple[Text, ...]
    has_image: bool
