"""The paths of a drawing that can be curves: lines of dense points that advance along x, and rows of equal markers."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import Floats
from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.io.read.figure.drawing import TOO_COMPLEX, Box, FigurePage, Path, bounding_box

MIN_POINTS = 8
"""Smallest number of points of a curve: that of a fit, see `sigmatau.fitting.components.MIN_TIMES`."""

_MIN_EXTENT = (
    0.08  # smallest width of a curve over that of the page. Judgement: a page has up to three figures side by side
)
_MAX_LINES = 1000  # largest number of lines that are compared with each other. Measured: 5 s
_CLIP_EDGE = 0.5  # largest distance of a visible point outside of its clip [units of the page]
_JOINT = 0.02  # largest distance of the ends of two parts of a line [units of the page]
_SAME_PLACE = 0.3  # largest distance of the points of a line drawn twice, or of a marker from its point
_MAX_MARKER = 0.03  # largest size of a marker over the width of the page


@frozen(eq=False)
class Candidate:
    """A path that can be a curve: points with increasing x, and whether each is the end of a segment."""

    points: Floats
    is_end: NDArray[np.bool_]
    color: str
    width: float
    quantum: float

    @property
    def box(self) -> Box:
        """The rectangle around the points."""
        return bounding_box(self.points)


def find_candidates(drawing: FigurePage) -> list[Candidate]:
    """All candidates in the order in which they are drawn; of lines drawn twice the last one."""
    lines = [path for path in drawing.paths if path.width > 0 and not path.is_closed]
    min_width = _MIN_EXTENT * drawing.width
    wide = [each for each in map(_candidate, _joined(lines)) if each is not None and _is_wide(each, min_width)]
    if len(wide) > _MAX_LINES:
        raise DataError(TOO_COMPLEX)
    curves = [each for k, each in enumerate(wide) if not any(_is_same(each, later) for later in wide[k + 1 :])]
    markers = [each for each in _markers(drawing) if _is_wide(each, min_width)]
    return curves + [each for each in markers if not any(_is_same(each, line) for line in curves)]


def _is_wide(candidate: Candidate, min_width: float) -> bool:
    box = candidate.box
    return box.x_max - box.x_min >= min_width and box.y_max > box.y_min


def _joined(paths: Sequence[Path]) -> list[Path]:
    """Join consecutive parts of a line, which some programs write separately."""
    result: list[Path] = []
    parts: list[Path] = []

    def flush() -> None:
        if parts:
            first = parts[0]
            points = np.concatenate([first.points, *(part.points[1:] for part in parts[1:])])
            is_end = np.concatenate([first.is_end, *(part.is_end[1:] for part in parts[1:])])
            result.append(
                Path(
                    points=points,
                    is_end=is_end,
                    color=first.color,
                    width=first.width,
                    is_closed=False,
                    quantum=first.quantum,
                    clip=first.clip,
                )
            )
            parts.clear()

    for path in paths:
        if parts:
            last = parts[-1]
            is_next = np.abs(last.points[-1] - path.points[0]).max() <= max(_JOINT, 2 * last.quantum)
            if not (is_next and path.color == last.color and path.width == last.width):
                flush()
        parts.append(path)
    flush()
    return result


def _candidate(path: Path) -> Candidate | None:
    """The visible part of a path, if it advances along x and has enough points."""
    if len(path.points) < MIN_POINTS:
        return None
    points, is_end = path.points, path.is_end
    edge = min(path.width, _CLIP_EDGE)
    inside = (
        (points[:, 0] >= path.clip.x_min - edge)
        & (points[:, 0] <= path.clip.x_max + edge)
        & (points[:, 1] >= path.clip.y_min - edge)
        & (points[:, 1] <= path.clip.y_max + edge)
    )
    points, is_end = points[inside], is_end[inside]
    if len(points) and points[0, 0] > points[-1, 0]:
        points, is_end = points[::-1], is_end[::-1]
    # Equal places are points of a dense curve that the resolution of the file does not separate.
    step = np.diff(points[:, 0])
    if len(points) < MIN_POINTS or np.any(step < -path.quantum):
        return None
    rising = np.concatenate([[True], points[1:, 0] > np.maximum.accumulate(points[:-1, 0])])
    if rising.sum() < MIN_POINTS or rising.sum() < 0.5 * len(points):
        return None
    return Candidate(
        points=points[rising], is_end=is_end[rising], color=path.color, width=path.width, quantum=path.quantum
    )


def _markers(drawing: FigurePage) -> list[Candidate]:
    """Rows of equal small closed shapes, as curves through their middles."""
    groups: dict[tuple[str, float, float, int], list[tuple[float, float]]] = defaultdict(list)
    quanta: dict[tuple[str, float, float, int], float] = {}
    for path in drawing.paths:
        box = bounding_box(path.points)
        size = (box.x_max - box.x_min, box.y_max - box.y_min)
        if path.is_closed and 0 < max(size) <= _MAX_MARKER * drawing.width:
            key = (path.color, round(size[0], 1), round(size[1], 1), len(path.points))
            groups[key].append((0.5 * (box.x_min + box.x_max), 0.5 * (box.y_min + box.y_max)))
            quanta[key] = path.quantum
    result = []
    for key, places in groups.items():
        points = np.unique(np.array(places), axis=0)
        if len(points) >= MIN_POINTS and np.all(np.diff(points[:, 0]) > 0):
            result.append(
                Candidate(
                    points=points,
                    is_end=np.ones(len(points), dtype=np.bool_),
                    color=key[0],
                    width=0.0,
                    quantum=quanta[key],
                )
            )
    return result


def _is_same(first: Candidate, second: Candidate) -> bool:
    """Whether two candidates are one curve: a line drawn twice, or markers on the points of a line."""
    sparse, dense = sorted((first.points, second.points), key=len)
    if len(sparse) < 0.5 * len(dense):
        return False
    nearest = np.clip(np.searchsorted(dense[:, 0], sparse[:, 0]), 1, len(dense) - 1)
    distance = np.minimum(np.abs(dense[nearest] - sparse).max(axis=1), np.abs(dense[nearest - 1] - sparse).max(axis=1))
    return bool(distance.max() <= _SAME_PLACE)
