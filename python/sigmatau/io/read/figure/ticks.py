"""Axes calibrated by tick labels beside ticks or grid lines."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from operator import attrgetter

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.frozen import frozen
from sigmatau.io.read.figure.axis import Axis, calibrated
from sigmatau.io.read.figure.drawing import Box, FigurePage
from sigmatau.io.read.figure.labels import MILLI, TIME, TickLabel, Word, labels_among
from sigmatau.io.read.figure.titles import factor_text

_REACH = 3.0  # largest distance of a label from its tick over the size of its font
_OFFSET = 0.6  # largest offset of the middle of a label from its tick over the size of its font
_UNEVEN = 0.2  # largest difference of the offsets of the labels of a row over the size of their font
_SAME_DIGIT = 0.01  # largest distance of a tick from a number with one digit [decades]; 9 and 10 are 0.046 apart
_SAME_ROW = 0.3  # largest difference of the places of the labels of a row over the size of the font
_MAX_RESIDUAL = 0.004  # of tick places, relative to the length of the axis. Judgement: a misread label causes more
_CONTRARY = 0.03  # largest difference of a label from the value of the axis, relative to it or to a linear axis
_MINOR = 8  # smallest number of ticks that show a logarithmic axis
_MAX_MINOR = 200  # largest number of ticks that are compared with those of a logarithmic axis
_MINOR_SHARE = 0.95  # share of them with one significant digit
_MAX_TICKS = 2000  # largest number of ticks of an axis, and of labels of a row
_THIN = 2.0  # largest width of a filled rectangle that stands for a line
_MAX_DISTANCE = 0.15  # largest distance of an axis from the end of the other one, relative to the length of that

_WAYS = {"x": 0, "y": 1}
DIRECTIONS = {"x": "to the right", "y": "upwards"}
_COORDINATES = ("x", "y")


@frozen(eq=False)
class Row:
    """A calibrated row or column of tick labels: its axis, its labels, and where it is.

    Attributes
    ----------
    axis : Axis
    labels : tuple of TickLabel
    first, last : float
        Smallest and largest coordinate of its labelled ticks.
    contrary : tuple of (float, str)
        Places and texts of labels of the row that contradict the axis.
    across : float
        Coordinate of the ends of its ticks beside the labels, across the axis.
    factor : str
        Factor of its values that is written at its end; empty without.
    """

    axis: Axis
    labels: tuple[TickLabel, ...]
    first: float
    last: float
    contrary: tuple[tuple[float, str], ...]
    across: float
    factor: str = ""

    @property
    def text(self) -> str:
        """The labels in words."""
        return ", ".join(label.text for label in self.labels)


@frozen(eq=False)
class _TickFamily:
    """Parallel lines of one style: their places, and their ends, which they have in common."""

    places: Floats
    low: float
    high: float
    width: float


class AxisError(Exception):
    """The axis cannot be calibrated: which one, and why, in words."""

    def __init__(self, way: str, why: str) -> None:
        super().__init__(way, why)
        self.way: str = way
        self.why: str = why


def calibrate_rows(drawing: FigurePage, words: Sequence[Word]) -> dict[str, list[Row]]:
    """All rows and columns of labels that calibrate an axis, by ``"x"`` and ``"y"``; `words`: the texts of the drawing."""
    labels = labels_among(words)
    result: dict[str, list[Row]] = {}
    for way, k in _WAYS.items():
        lines = list(_families(drawing, k))
        rows = (_calibrate(row, whole, lines, k) for row, whole in _aligned(labels, k) if len(row) <= _MAX_TICKS)
        result[way] = [_with_factor(row, words, way) for row in rows if row is not None]
    return result


def _with_factor(row: Row, words: Sequence[Word], way: str) -> Row:
    names = (label.text for label in row.labels)
    factor = factor_text(words, way, row.first, row.last, row.across, names)
    return replace(row, factor=factor) if factor else row


def _families(drawing: FigurePage, k: int) -> Iterator[_TickFamily]:
    """Lines across an axis, grouped by ends and style."""
    groups: dict[tuple[float, float, str, float], list[float]] = defaultdict(list)
    for path in drawing.paths:
        if len(path.points) > 5:
            continue
        low, high = path.points.min(axis=0), path.points.max(axis=0)
        extent = high - low
        thickness = 0.01 if path.width > 0 and len(path.points) == 2 else _THIN if path.width == 0 else 0.0
        if extent[k] <= thickness and extent[1 - k] > max(1.0, 2 * extent[k]):
            ends = (round(float(low[1 - k]), 1), round(float(high[1 - k]), 1))
            groups[(*ends, path.color, round(path.width or float(extent[k]), 2))].append(float(low[k] + high[k]) / 2)
    for (low_end, high_end, _, width), places in groups.items():
        # A place appears twice if a tick is drawn at both ends of the figure, or a line is drawn again.
        unique = np.unique(np.round(places, 3))
        if len(unique) <= _MAX_TICKS:
            yield _TickFamily(places=unique, low=low_end, high=high_end, width=width)


def _aligned(labels: Sequence[TickLabel], k: int) -> Iterator[tuple[list[TickLabel], list[TickLabel]]]:
    """Rows of labels whose values rise or fall, each with all labels aligned with it: those with one baseline, or in a
    column with one left end, middle or right end.
    """
    for name in ("baseline",) if k == 0 else ("end", "x", "start"):
        end = attrgetter(name)
        row: list[TickLabel] = []
        for label in sorted(labels, key=end):
            if row and end(label) - end(row[-1]) > _SAME_ROW * label.size:
                yield from ((part, row) for part in _monotonic(row, k))
                row = []
            row.append(label)
        yield from ((part, row) for part in _monotonic(row, k))


def _monotonic(row: Sequence[TickLabel], k: int) -> Iterator[list[TickLabel]]:
    """Divide a row where the values turn: there the labels of the next figure begin."""
    part: list[TickLabel] = []
    for label in sorted(row, key=attrgetter(_COORDINATES[k])):
        if len(part) > 1 and (label.value > part[-1].value) != (part[-1].value > part[-2].value):
            yield part
            part = []
        part.append(label)
    if len(part) > 1:
        yield part


def _calibrate(
    row: Sequence[TickLabel], whole: Sequence[TickLabel], families: Sequence[_TickFamily], k: int
) -> Row | None:
    """The axis by the lines that fit a row best; None if no lines fit."""
    size = max(label.size for label in row)
    ends = [(lines, end) for lines in families if (end := _adjacent_end(lines, row, k)) is not None]
    if not ends:
        return None
    ticks = np.unique(np.concatenate([lines.places for lines, _ in ends]))
    middles = np.array([(label.x, label.y)[k] for label in row])
    best: tuple[tuple[float, ...], Row] | None = None
    for lines, across in ends:
        # The offset of the labels from their ticks is the same for all of them, and small.
        for offset in {round(float(shift), 3) for shift in (lines.places[:, None] - middles).ravel()}:
            if abs(offset) > _OFFSET * size:
                continue
            nearest = np.abs(lines.places[:, None] - middles - offset).argmin(axis=0)
            places = lines.places[nearest]
            close = np.abs(places - middles - offset) <= _UNEVEN * size
            matched = {
                label: float(place) for label, place, is_close in zip(row, places, close, strict=True) if is_close
            }
            axis = _fitted(matched, lines, ticks)
            if axis is not None:
                score = (len(matched), round(_explained(axis, ticks), 1), -abs(offset))
                if best is None or score > best[0]:
                    calibrated_row = Row(
                        axis=axis,
                        labels=tuple(sorted(matched, key=matched.__getitem__)),
                        first=min(matched.values()),
                        last=max(matched.values()),
                        contrary=tuple(_contrary(axis, whole, lines, offset, k)),
                        across=across,
                    )
                    best = (score, calibrated_row)
    return best[1] if best else None


def _contrary(
    axis: Axis, labels: Sequence[TickLabel], lines: _TickFamily, offset: float, k: int
) -> Iterator[tuple[float, str]]:
    """Labels beside ticks whose value is not that of the axis there."""
    extent = max(axis.values) - min(axis.values)
    for label in labels:
        middle = (label.x, label.y)[k] + offset
        place = float(lines.places[np.abs(lines.places - middle).argmin()])
        value = float(axis.read(np.array([place]))[0])
        if abs(place - middle) <= _UNEVEN * label.size and abs(value - label.value) > _CONTRARY * (
            abs(value) if axis.is_log else extent
        ):
            yield place, label.text


def _adjacent_end(lines: _TickFamily, row: Sequence[TickLabel], k: int) -> float | None:
    """The ends of lines that are beside a row of labels; None if they are far away."""
    for label in row:
        across = (label.y, label.x)[k]
        reach = _REACH * label.size + (0.5 * (label.end - label.start) if k else 0.0)
        end = min((lines.low, lines.high), key=lambda place: abs(place - across))
        if abs(end - across) <= reach:
            return end
    return None


def _explained(axis: Axis, ticks: Floats) -> float:
    """Share of the ticks whose values have one significant digit, as on a logarithmic axis. It is low if labels are matched
    with the ticks beside theirs.
    """
    if not axis.is_log:
        return 1.0
    value = axis.offset + axis.slope * (ticks - axis.center)
    digits = np.log10(np.arange(1, 11))
    distance = np.abs((value % 1.0)[:, None] - digits).min(axis=1)
    return float(np.mean(distance <= _SAME_DIGIT))


def _fitted(matched: Mapping[TickLabel, float], lines: _TickFamily, ticks: Floats) -> Axis | None:
    """The axis of labels with the places of their ticks; None if they are too few or contradict each other."""
    places, values = list(matched.values()), [label.value for label in matched]
    count = len({*places})
    if count < 2 or len({*values}) < 2:
        return None
    kinds = [True, False] if min(values) > 0 else [False]
    axes = [calibrated(places, values, is_log=is_log, error=0.25 * lines.width) for is_log in kinds]
    axis = min(axes, key=lambda each: each.residual) if count > 2 else axes[0]
    if axis.residual > _MAX_RESIDUAL * (max(places) - min(places)):
        return None
    if not axis.is_log and (_are_flat_powers(matched) or _has_log_ticks(axis, ticks)):
        return None
    if count == 2:
        # Two plain numbers do not show whether an axis is logarithmic, but the ticks between them do.
        has_minor = len(ticks) >= _MINOR and _explained(axis, ticks) > _MINOR_SHARE
        if not (axis.is_log and (has_minor or all(label.is_power for label in matched))):
            return None
    return axis


def _are_flat_powers(labels: Iterable[TickLabel]) -> bool:
    """Whether all labels can be powers of ten whose exponents are not raised: 100, 101, 102."""
    return all(len(label.text) == 3 and label.text.isdigit() and label.text.startswith("10") for label in labels)


def _has_log_ticks(axis: Axis, ticks: Floats) -> bool:
    """Whether the ticks beside a linear axis are those of a logarithmic one. Its labels are then exponents."""
    exponents = axis.offset + axis.slope * (ticks - axis.center)
    between = exponents[np.abs(exponents - np.round(exponents)) > _SAME_DIGIT]
    if not _MINOR <= len(between) <= _MAX_MINOR:
        return False
    # A label may have been matched with the tick beside its tick.
    shifts = (
        replace(axis, is_log=True, offset=axis.offset - shift) for shift in np.unique(np.round(exponents % 1.0, 3))
    )
    return any(_explained(shifted, ticks) > _MINOR_SHARE for shifted in shifts)


def path_axes(box: Box, rows: dict[str, list[Row]], stated: dict[str, Axis | None]) -> dict[str, Axis]:
    """The two axes of a path with the extent `box`: the stated ones, or those of the nearest labels beside it.

    Raises `AxisError` without labels, and if the labels at two sides disagree.
    """
    x_row = (
        None if stated["x"] is not None else _nearest("x", rows["x"], (box.x_min, box.x_max), (box.y_min, box.y_max))
    )
    span = (box.x_min, box.x_max) if x_row is None else (min(box.x_min, x_row.first), max(box.x_max, x_row.last))
    y_rows = rows["y"]
    if x_row is not None:
        margin = _MAX_DISTANCE * (span[1] - span[0])
        y_rows = [row for row in y_rows if span[0] - margin <= row.across <= span[1] + margin]
    y_row = None if stated["y"] is not None else _nearest("y", y_rows, (box.y_min, box.y_max), span)
    axes = {way: row.axis if row is not None else stated[way] for way, row in (("x", x_row), ("y", y_row))}
    return {way: axis for way, axis in axes.items() if axis is not None}


def _nearest(way: str, rows: Sequence[Row], extent: tuple[float, float], across: tuple[float, float]) -> Row:
    """The row beside a path, which has the extent along and across the axis."""
    low, high = extent
    covering = [row for row in rows if _covers(row, low, high)]
    before = [row for row in covering if row.across <= across[0] + 1]
    after = [row for row in covering if row.across >= across[1] - 1]
    sides = [
        min(row, key=lambda each: abs(each.across - edge))
        for row, edge in ((before, across[0]), (after, across[1]))
        if row
    ]
    if not sides:
        raise AxisError(way, f"the labels of its {way} axis do not reach the curve: {rows[0].text}" if rows else "")
    if way == "x":
        sides = sides[-1:]  # labels above belong to another figure, or repeat those below
    first, last = sides[0], sides[-1]
    for row in sides:
        if (row.axis.slope > 0) != (way == "x"):
            raise AxisError(way, f"the values of its {way} axis fall {DIRECTIONS[way]}: {row.text}")
        if row.factor:
            raise AxisError(way, f"the values of its {way} axis have a factor, {row.factor}")
        _check_suffixes(way, row)
        for place, text in row.contrary:
            if low - 1 <= place <= high + 1:
                raise AxisError(way, f"the label {text} of its {way} axis contradicts {row.text}")
    ends = np.array([low, high])
    if first.axis.is_log != last.axis.is_log or not np.allclose(first.axis.read(ends), last.axis.read(ends), rtol=0.02):
        raise AxisError(way, f"it has two {way} axes, with {first.text} and {last.text}")
    return max(sides, key=lambda row: len(row.labels))


def _check_suffixes(way: str, row: Row) -> None:
    """Raise `AxisError` if units or prefixes of labels do not determine the values of an axis."""
    suffixes = {label.suffix for label in row.labels}
    if way == "y" and TIME in suffixes:
        raise AxisError(way, f"the labels of its y axis are times: {row.text}")
    if TIME in suffixes and len(suffixes) > 1:
        raise AxisError(way, f"not all labels of its {way} axis have a unit: {row.text}")
    if suffixes == {MILLI}:
        raise AxisError(way, f"m can be milli or minutes in the labels of its {way} axis: {row.text}")


def _covers(row: Row, low: float, high: float) -> bool:
    """Whether the labels of a row reach the ends of a path to within their mean distance, or a decade."""
    margin = (row.last - row.first) / (len(row.labels) - 1)
    if row.axis.is_log:
        margin = max(margin, abs(1 / row.axis.slope))
    return row.first - margin <= low and high <= row.last + margin
