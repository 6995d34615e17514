"""Read the selected lines of a figure: find the file's kind, its lines and its axes. What is uncertain is a question."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Literal

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.io.read.figure import clicks, pdf_process, svg
from sigmatau.io.read.figure.axis import Axis, stated_axis
from sigmatau.io.read.figure.candidates import Candidate, find_candidates
from sigmatau.io.read.figure.drawing import MAX_BYTES, FigurePage
from sigmatau.io.read.figure.labels import Word, joined_words, labels_among
from sigmatau.io.read.figure.lines import FigureLine, check_calibration, line_of_values, standard_error
from sigmatau.io.read.figure.ticks import DIRECTIONS, AxisError, Row, calibrate_rows, path_axes
from sigmatau.io.read.figure.titles import check_unit, has_logarithm, has_unit, other_unit, titles_above

Linear = Literal["x", "y", "xy"]

_HEAD = 1024  # PDF files may begin with other bytes
_PICTURES = (b"\x89PNG", b"\xff\xd8\xff", b"GIF8", b"BM", b"II*\0", b"MM\0*", b"RIFF")
_LISTED = 4  # largest number of lines in a message
_OPTIONS = {"x": "x_axis", "y": "y_axis"}
_NUMBERS = 8  # largest number of labels in a message
_POINT = 1.0  # standard error of a clicked point. Judgement: one pixel


def file_kind(path: Path) -> Literal["svg", "pdf", "picture", "table"]:
    """The kind of a file by its first bytes."""
    with path.open("rb") as file:
        head = file.read(_HEAD)
    if head.startswith(_PICTURES):
        return "picture"
    if b"%PDF-" in head:
        return "pdf"
    return "svg" if head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<") else "table"


@frozen(eq=False)
class Figure:
    """The lines of a vector figure that can be curves, its words, and the rows of labels that calibrate axes."""

    drawing: FigurePage
    candidates: tuple[Candidate, ...]
    words: tuple[Word, ...]
    rows: dict[str, list[Row]]

    @property
    def titles(self) -> tuple[str, ...]:
        """The titles along y axes. If none has a unit, also the texts above these axes."""
        along = self.drawing.titles
        if has_unit(along):
            return along
        above = (text for row in self.rows["y"] for text in titles_above(self.words, row.first, row.across))
        return (*along, *(text for text in dict.fromkeys(above) if has_unit([text])))


def open_figure(path: Path, page: int | None) -> Figure:
    """Read a vector figure. Raises `DataError` if it has no line that can be a curve."""
    kind = file_kind(path)
    if kind == "picture":
        raise DataError(
            f"is a picture of pixels. Click its curve in sigmatau app, or give points as CSV with {Hint('x_axis')}"
        )
    if kind == "table":
        raise DataError("is neither SVG nor PDF. Give a vector figure, or a table of points")
    if path.stat().st_size > MAX_BYTES:
        raise DataError(f"is larger than {MAX_BYTES / 1e6:g} MB. Save the page or the figure alone")
    if kind == "svg" and page not in (None, 1):
        raise OptionError(f"{Hint('page')} is for PDF files. Leave it out", option="page")
    drawing = pdf_process.read(path, page) if kind == "pdf" else svg.read(path.read_bytes())
    candidates = find_candidates(drawing)
    if not candidates:
        if drawing.has_image:
            raise DataError("has a picture of pixels, and no line that can be a curve. Click points in sigmatau app")
        raise DataError(
            "has no line that can be a curve: 8 or more points that advance along x. Click points in sigmatau app"
        )
    words = tuple(joined_words(drawing.texts))
    return Figure(drawing=drawing, candidates=tuple(candidates), words=words, rows=calibrate_rows(drawing, words))


def read_lines(
    path: str | PathLike[str],
    *,
    unit: str,
    is_variance: bool,
    line: str | int | Mapping[str, str | int] | None,
    page: int | None,
    x_axis: Mapping[float, float] | None,
    y_axis: Mapping[float, float] | None,
    linear: Linear | None,
    point_error: float | None,
    columns: Mapping[str, str] | None,
) -> list[FigureLine]:
    """The selected lines; parameters and errors as of `sigmatau.read_figure`."""
    path = Path(path)
    try:
        kind = file_kind(path)
    except OSError as error:
        raise DataError(f"cannot be read: {error.strerror or error}. Check the path") from None
    if kind == "table":
        for option, value in (("line", line), ("page", page)):
            if value is not None:
                raise OptionError(f"{Hint(option)} is for SVG and PDF files. Leave it out", option=option)
        return _clicked(clicks.read(path, columns), x_axis, y_axis, linear, point_error)
    if columns:
        raise OptionError(
            f"{Hint('columns')} is for tables. Select a line with {Hint('line', value=1)}", option="columns"
        )
    figure = open_figure(path, page)
    if y_axis is None:
        check_unit(figure.titles, unit, is_variance=is_variance)
    lines = []
    for name, candidate in _selected(figure.candidates, line).items():
        sd = standard_error(candidate) if point_error is None else point_error
        stated = {"x": _axis(x_axis, "x", linear, sd), "y": _axis(y_axis, "y", linear, sd)}
        axes = _axes(figure, candidate, stated)
        check_directions(axes)
        for k, (way, axis) in enumerate(stated.items()):
            if axis is not None:
                check_calibration(way, axis, candidate.points[:, k], _OPTIONS[way])
        lines.append(
            FigureLine(
                name=name,
                x=axes["x"],
                y=axes["y"],
                points=candidate.points,
                is_end=candidate.is_end,
                error=sd,
            )
        )
    return lines


def _axis(points: Mapping[float, float] | None, way: str, linear: Linear | None, error: float) -> Axis | None:
    if points is None:
        if linear is not None and way in linear:
            raise OptionError(f"{Hint('linear')} is for stated axes. Give {Hint(_OPTIONS[way])}", option="linear")
        return None
    return stated_axis(points, _OPTIONS[way], is_log=linear is None or way not in linear, error=error)


def _axes(figure: Figure, candidate: Candidate, stated: dict[str, Axis | None]) -> dict[str, Axis]:
    unit = other_unit(figure.words, candidate.box) if stated["x"] is None else ""
    if unit:
        hint = Hint("x_axis", value={"COORDINATE": "SECONDS"})
        raise OptionError(f"has an x axis in {unit}. State two points of the x axis in s, {hint}", option="x_axis")
    try:
        axes = path_axes(candidate.box, figure.rows, stated)
        for way, axis in axes.items():
            if stated[way] is None and not axis.is_log and has_logarithm(figure.words, figure.drawing.titles):
                raise AxisError(way, f"its {way} axis is linear, and a title has a logarithm")
        return axes
    except AxisError as question:
        why = question.why or f"its {question.way} axis has no labels beside ticks{_numbers(figure)}"
        box, option = candidate.box, _OPTIONS[question.way]
        ends = (box.x_min, box.x_max) if question.way == "x" else (box.y_min, box.y_max)
        hint = Hint(option, value={f"{ends[0]:.4g}": "VALUE", f"{ends[1]:.4g}": "VALUE"})
        raise OptionError(f"{why}. State two points of the axis, {hint}", option=option) from None


def _numbers(figure: Figure) -> str:
    """The numbers among the texts of the drawing, for a message."""
    numbers = [label.text for label in labels_among(figure.words)]
    ending = ", …" if len(numbers) > _NUMBERS else ""
    return f", numbers in it: {', '.join(numbers[:_NUMBERS])}{ending}" if numbers else ", letters may be outlines"


def check_directions(axes: Mapping[str, Axis]) -> None:
    """Raise `OptionError` unless the values of both axes rise to the right and upwards, with y downwards."""
    for way, axis, is_wrong in (("x", axes["x"], axes["x"].slope < 0), ("y", axes["y"], axes["y"].slope > 0)):
        if is_wrong:
            values = ", ".join(f"{value:g}" for value in axis.values[:2])
            raise OptionError(
                f"the values of the {way} axis, {values}, do not rise {DIRECTIONS[way]}. Correct {Hint(_OPTIONS[way])}",
                option=_OPTIONS[way],
            )


def describe(candidate: Candidate) -> str:
    """A line in words: its colour and the number of its points."""
    kind = "points" if candidate.width else "markers"
    return f"{candidate.color} ({int(candidate.is_end.sum())} {kind})"


def _selected(
    candidates: Sequence[Candidate], line: str | int | Mapping[str, str | int] | None
) -> dict[str, Candidate]:
    """The stated lines by channel; the only one without a statement."""
    listed = ", ".join(f"{k} {describe(each)}" for k, each in enumerate(candidates[:_LISTED], 1))
    listed += ", …" if len(candidates) > _LISTED else ""
    if line is None:
        if len(candidates) == 1:
            return {"": candidates[0]}
        raise OptionError(
            f"has {len(candidates)} lines: {listed}. Select one, e.g. {Hint('line', value=1)}", option="line"
        )
    wanted = dict(line) if isinstance(line, Mapping) else {"": line}
    result = {}
    for name, text in wanted.items():
        number = str(text).strip().lower()
        if number.isdigit() and 1 <= int(number) <= len(candidates):
            result[name] = candidates[int(number) - 1]
            continue
        matching = [each for each in candidates if each.color == number]
        if len(matching) != 1:
            count = f"{len(matching)} lines are" if matching else "no line is"
            raise OptionError(f"{Hint('line')}: {count} {text!r} among {listed}. Give a number", option="line")
        result[name] = matching[0]
    return result


def _clicked(
    curves: Mapping[str, Floats],
    x_axis: Mapping[float, float] | None,
    y_axis: Mapping[float, float] | None,
    linear: Linear | None,
    point_error: float | None,
) -> list[FigureLine]:
    """The lines of clicked points: coordinates with two axes, or values with a relative error."""
    if (x_axis is None) != (y_axis is None):
        option = "x_axis" if x_axis is None else "y_axis"
        raise OptionError(f"coordinates need two axes, values none. Give {Hint(option)} too", option=option)
    lines = []
    for name, points in curves.items():
        if x_axis is None or y_axis is None:
            if point_error is None:
                hint = Hint("point_error", value=0.02)
                raise OptionError(
                    f"has no axes. For points that are values, give their relative error, {hint}", option="point_error"
                )
            if not 0 < point_error < 1:
                raise OptionError("{option} of values is relative, such as 0.02. Correct it", option="point_error")
            if points.min() <= 0:
                raise DataError("has values that are not positive. Correct them, or state the axes")
            lines.append(line_of_values(name, points, point_error))
            continue
        error = _POINT if point_error is None else point_error
        x, y = _axis(x_axis, "x", linear, error), _axis(y_axis, "y", linear, error)
        assert x is not None
        assert y is not None
        for k, (way, axis) in enumerate((("x", x), ("y", y))):
            check_calibration(way, axis, points[:, k], _OPTIONS[way])
        points = points[::-1] if x.slope < 0 else points
        lines.append(
            FigureLine(name=name, x=x, y=y, points=points, is_end=np.ones(len(points), dtype=np.bool_), error=error)
        )
    return lines
