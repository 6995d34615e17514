"""Curves that ``sigmatau curve`` reads from figures and clicked points, and the list of the lines of a figure."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Literal, NamedTuple

from sigmatau.cli.options import say
from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.allan import Curves
from sigmatau.estimators.figure import read_figure
from sigmatau.io.read.figure.labels import labels_among
from sigmatau.io.read.figure.lines import standard_error
from sigmatau.io.read.figure.select import Figure, Linear, describe, file_kind, open_figure
from sigmatau.io.read.figure.ticks import AxisError, path_axes
from sigmatau.results import duration_text
from sigmatau.typed.pairs import key_numbers, key_values

_LABELS = 60  # largest number of labels in a list
_WITHOUT = "coordinates"  # of a line whose axes are not calibrated


class FigureOptions(NamedTuple):
    """The options of a figure as they were typed."""

    line: str | None
    page: int | None
    x_axis: list[str] | None
    y_axis: list[str] | None
    linear: Linear | None
    point_error: float | None

    @property
    def typed(self) -> list[str]:
        """Names of the options that were typed."""
        return [name for name, value in self._asdict().items() if value is not None]


def has_figure(path: Path, options: FigureOptions) -> bool:
    """Whether a file is a figure or has points of one."""
    try:
        return bool(options.typed) or file_kind(path) != "table"
    except OSError as error:
        raise DataError(f"cannot be read: {error.strerror}. Check the path").about(str(path)) from None


def curves_of_figure(
    path: Path,
    options: FigureOptions,
    *,
    rate: float | None,
    hours: float | None,
    columns: Mapping[str, str] | None,
    unit: str | None,
    content: Literal["deviation", "variance"] | None,
    quiet: bool,
) -> Curves:
    """Read the selected curves, and say what is assumed."""
    if unit is None:
        raise OptionError(
            "a figure needs the unit of its rate. Give --unit deg/h, or the unit of the y axis", option="unit"
        )
    curves = read_figure(
        path,
        unit=unit,
        line=_line(options.line),
        page=options.page,
        x_axis=_points(options.x_axis, "x-axis"),
        y_axis=_points(options.y_axis, "y-axis"),
        linear=options.linear,
        point_error=options.point_error,
        columns=columns,
        content=content or "deviation",
        rate=rate,
        duration=None if hours is None else 3600 * hours,
    )
    if hours is None:
        longest = max(curve.n * curve.tau0 for curve in curves.values())
        say(
            "info: the length of the record is not known. The errors are those of the shortest possible one,"
            f" {duration_text(longest)}; --hours states another",
            quiet=quiet,
        )
    return curves


def _line(text: str | None) -> str | dict[str, str] | None:
    return dict(key_values([text], "line", "gyro_x=1")) if text is not None and "=" in text else text


def _points(texts: list[str] | None, option: str) -> dict[float, float] | None:
    if texts is None:
        return None
    example = "80=0.01,480=100"
    points = {}
    for place, value in key_numbers(texts, option, example).items():
        try:
            points[float(place)] = value
        except ValueError:
            raise OptionError(
                f"--{option} {place}={value:g}: {place!r} is not a coordinate. Write --{option} {example}",
                option=option,
            ) from None
    return points


def listed_lines(path: Path, page: int | None) -> str:
    """The lines of a figure that can be curves, each with the range of its values if its axes have labels."""
    try:
        figure = open_figure(path, page)
    except (DataError, OptionError) as error:
        raise error.about(str(path)) from None
    rows: list[tuple[str, ...]] = [("line", "colour", "points", "width", "x from", "to", "y from", "to", "axes")]
    for k, candidate in enumerate(figure.candidates, 1):
        color, _, count = describe(candidate).partition(" ")
        rows.append((str(k), color, count.strip("()"), f"{candidate.width:.3g}", *_ranges(figure, k - 1)))
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    labels = labels_among(figure.words)[:_LABELS]
    if labels and any(row[-1].startswith(_WITHOUT) for row in rows):
        places = (f"{label.text} ({label.x:.4g}, {label.y:.4g})" for label in labels)
        lines.append("numbers and their coordinates: " + ", ".join(places))
    return "\n".join(lines)


def _ranges(figure: Figure, k: int) -> tuple[str, ...]:
    """Ends of a line in values, or in coordinates of the page if an axis has no labels, and the labels of the axes."""
    candidate = figure.candidates[k]
    points = candidate.points
    try:
        axes = path_axes(candidate.box, figure.rows, {"x": None, "y": None})
    except AxisError as question:
        ends = (*points[[0, -1], 0].tolist(), points[:, 1].max(), points[:, 1].min())
        return (*(f"{end:.4g}" for end in ends), f"{_WITHOUT}: {question.why or f'no {question.way} labels'}")
    x, y = axes["x"].read(points[[0, -1], 0]), axes["y"].read(points[:, 1])
    error = standard_error(candidate)
    relative = float(abs(axes["y"].sensitivity(points[:, 1])).max()) * error
    kinds = "log" if axes["x"].is_log and axes["y"].is_log else "linear"
    return (
        *(f"{end:.4g}" for end in (*x.tolist(), float(y.min()), float(y.max()))),
        f"{kinds}, a point is read to {100 * relative:.2g} %",
    )
