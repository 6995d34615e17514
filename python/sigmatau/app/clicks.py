"""Points that were clicked on the page: their table, the options of `read_figure`, and the command that does the same."""

from __future__ import annotations

import math
import re
import shlex
from collections.abc import Mapping
from typing import Any

from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.io.read.figure.labels import MILLI, TIME, parse_label
from sigmatau.typed.forms import spelled

TABLE = "clicks.csv"
"""Name of the table that the page saves and the command reads."""

MODEL = "figure.toml"
"""Name of the model that the command writes."""

_NAME = re.compile(r"[A-Za-z]\w{0,39}", re.ASCII)
_RESERVED = ("x", "y", "tau")  # names of coordinates in the table
_WAYS = {"x": "x_axis", "y": "y_axis"}
_DIGITS = 2  # decimals of a coordinate in the table: a hundredth of a pixel
_MAX_POINTS = 5000  # of all curves together
_SHOWN = 40  # largest number of letters of a wrong value in a message

Point = tuple[float, float]


@frozen(eq=False)
class Clicks:
    """Clicked points of curves and axes.

    Attributes
    ----------
    curves : mapping of str to tuple of (float, float)
        Coordinates of the points by channel; the name of a single curve may be empty. [pixels]
    x_axis, y_axis : mapping of float to float
        Values by coordinate.
    options : mapping of str to object
        Further options of `sigmatau.read_figure`.
    """

    curves: Mapping[str, tuple[Point, ...]]
    x_axis: Mapping[float, float]
    y_axis: Mapping[float, float]
    options: Mapping[str, Any]

    @property
    def table(self) -> str:
        """The points as CSV. A row belongs to a single curve."""
        names = [name or "y" for name in self.curves]
        rows = [
            (x, ",".join([_coordinate(x), *("" if column != k else _coordinate(y) for column in range(len(names)))]))
            for k, points in enumerate(self.curves.values())
            for x, y in points
        ]
        return "\n".join([",".join(["x", *names]), *(text for _, text in sorted(rows, key=lambda row: row[0]))]) + "\n"

    @property
    def columns(self) -> dict[str, str] | None:
        """The columns of the table by channel; None for a single curve without a name."""
        if [*self.curves] == [""]:
            return None
        return {"x": "1"} | {name: str(k) for k, name in enumerate(self.curves, 2)}

    def command(self, *, has_model: bool) -> str:
        """The command that reads the table and fits the curves."""
        options: dict[str, Any] = {
            "columns": self.columns,
            "x_axis": {_coordinate(place): value for place, value in self.x_axis.items()},
            "y_axis": {_coordinate(place): value for place, value in self.y_axis.items()},
            **self.options,
        }
        words = ["sigmatau", "curve", TABLE]
        for name, value in options.items():
            if value is not None and (name, value) != ("content", "deviation"):
                text = (
                    ",".join(f"{k}={_text(v)}" for k, v in value.items()) if isinstance(value, dict) else _text(value)
                )
                option = f"--{spelled(name).replace('_', '-')}"
                words += [f"{option}={text}"] if text.startswith("-") else [option, text]
        return shlex.join([*words, *(["-o", MODEL] if has_model else [])])


def _coordinate(value: float) -> str:
    return f"{value:.{_DIGITS}f}"


def _text(value: object) -> str:
    return f"{value:.12g}" if isinstance(value, float) else str(value)


def clicks_in(body: Mapping[str, Any]) -> Clicks:
    """The points and options that the page sends. Raises `OptionError` for what is missing or wrong."""
    options: dict[str, Any] = {name: _word(body, name) for name in ("unit", "content", "linear")}
    if not options["unit"]:
        raise OptionError("{option} of the y axis is missing. Give it, e.g. deg/h", option="unit")
    for name, words in (("content", ("deviation", "variance")), ("linear", ("x", "y", "xy"))):
        if options[name] not in (None, *words):
            raise OptionError(f"{{option}} must be one of {', '.join(words)}", option=name)
    for name in ("point_error", "rate", "hours"):
        value = body.get(name)
        if value is not None and not (_is_number(value) and value > 0):
            raise OptionError("{option} must be a positive number. Correct it", option=name)
        options[name] = None if value is None else float(value)
    return Clicks(curves=_curves(body.get("curves")), x_axis=_axis(body, "x"), y_axis=_axis(body, "y"), options=options)


def _curves(stated: object) -> dict[str, tuple[Point, ...]]:
    if not isinstance(stated, list) or not stated:
        raise OptionError("there are no clicked points. Click along the curve", option="columns")
    curves: dict[str, tuple[Point, ...]] = {}
    for curve in stated:
        name, points = (curve.get(key) for key in ("name", "points")) if isinstance(curve, dict) else (None, None)
        name = name or ""
        if not isinstance(name, str) or (name and not _NAME.fullmatch(name)) or name in _RESERVED:
            raise OptionError(
                f"the name {str(name)[:_SHOWN]!r} of a curve is not possible. Give letters, digits and _, e.g. gyro_x",
                option="columns",
            )
        if name in curves:
            raise OptionError(
                f"two curves are called {name!r}. Give each a name, e.g. gyro_x and gyro_y", option="columns"
            )
        if not isinstance(points, list) or not all(map(_is_point, points)):
            raise OptionError("the points of a curve must be pairs of numbers. Click them again", option="columns")
        curves[name] = tuple((round(float(x), _DIGITS), round(float(y), _DIGITS)) for x, y in points)
    if len(curves) > 1 and "" in curves:
        raise OptionError("each of several curves needs a name. Give it, e.g. gyro_x", option="columns")
    if sum(map(len, curves.values())) > _MAX_POINTS:
        raise OptionError(f"there are more than {_MAX_POINTS} points. Click fewer", option="columns")
    return curves


def _axis(body: Mapping[str, Any], way: str) -> dict[float, float]:
    """Values of an axis by coordinate."""
    option, ticks = _WAYS[way], body.get(_WAYS[way])
    if not isinstance(ticks, list) or len(ticks) < 2:
        raise OptionError(
            f"the {way} axis needs two ticks. Click two at its ends, and give their values", option=option
        )
    axis: dict[float, float] = {}
    for tick in ticks:
        if not (isinstance(tick, list) and len(tick) == 2 and _is_number(tick[0])):
            raise OptionError(
                f"a tick of the {way} axis must be a coordinate and a value. Click it again", option=option
            )
        place = round(float(tick[0]), _DIGITS)
        if any(abs(place - coordinate) < 1 for coordinate in axis):
            raise OptionError(f"two ticks of the {way} axis are at the same place. Move one of them", option=option)
        axis[place] = _value(tick[1], way, option)
    return axis


def _value(stated: object, way: str, option: str) -> float:
    """The value of a tick, a number or a text such as ``10⁻²``."""
    text = str(stated).strip()
    number = (float(text), False, "") if _is_number(stated) else parse_label(text)
    if number is None or not math.isfinite(number[0]):
        shown = repr(text[:_SHOWN]) if text else "empty"
        raise OptionError(
            f"the value of a tick of the {way} axis is {shown}. Write a number, e.g. 0.01 or 1e-2", option=option
        )
    value, _, suffix = number
    if suffix == MILLI or (suffix == TIME and way == "y"):
        raise OptionError(f"{text!r} is not clear on the {way} axis. Write a number without a unit", option=option)
    return value


def _word(body: Mapping[str, Any], name: str) -> str | None:
    value = body.get(name)
    if value is not None and not isinstance(value, str):
        raise OptionError(f"{Hint(name)} must be a text. Correct it", option=name)
    return value.strip() or None if value is not None else None


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e15


def _is_point(value: object) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(map(_is_number, value))
