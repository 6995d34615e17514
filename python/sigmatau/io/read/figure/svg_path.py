"""The grammar of the attribute ``d`` of SVG paths."""

from __future__ import annotations

import re

from sigmatau.errors import DataError
from sigmatau.io.read.figure.drawing import MAX_VERTICES, TOO_COMPLEX
from sigmatau.io.read.figure.geometry import Pen

_TOKEN = re.compile(r"[MmLlHhVvCcSsQqTtAaZz]|[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_COUNTS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}

_Point = tuple[float, float]


def draw(data: str, pen: Pen) -> None:
    """Draw a path. An arc is replaced by the line between its ends; what follows a mistake is left out, as browsers do."""
    tokens = _TOKEN.findall(data)
    if len(tokens) > 3 * MAX_VERTICES:
        raise DataError(TOO_COMPLEX)
    command, place = "", 0
    control: _Point | None = None  # second control point of the segment before, for smooth segments
    before = ""
    while place < len(tokens):
        if tokens[place].isalpha():
            command = tokens[place]
            place += 1
        elif command in ("", "Z", "z"):
            return
        kind, count = command.upper(), _COUNTS[command.upper()]
        values = tokens[place : place + count]
        if len(values) < count or any(value.isalpha() for value in values):
            return
        place += count
        numbers = [float(value) for value in values]
        x, y = pen.place if command.islower() else (0.0, 0.0)
        last = control if control is not None and before in _SAME[kind] else pen.place
        control = None
        if kind == "M":
            pen.move(x + numbers[0], y + numbers[1])
            command = "l" if command == "m" else "L"
        elif kind in "LA":
            pen.line(x + numbers[-2], y + numbers[-1])
        elif kind == "H":
            pen.line(x + numbers[0], pen.place[1])
        elif kind == "V":
            pen.line(pen.place[0], y + numbers[0])
        elif kind == "Z":
            pen.close()
        else:
            control = _bezier(
                kind, [(x + a, y + b) for a, b in zip(numbers[::2], numbers[1::2], strict=True)], last, pen
            )
        before = kind


_SAME = {kind: kind for kind in _COUNTS} | {"S": "CS", "T": "QT"}  # kinds whose control point a smooth segment mirrors


def _bezier(kind: str, points: list[_Point], last: _Point, pen: Pen) -> _Point:
    """Draw a segment C, S, Q or T, with the control point `last` of the segment before. Returns its last control point."""
    start, end = pen.place, points[-1]
    mirrored = (2 * start[0] - last[0], 2 * start[1] - last[1])
    if kind in "CS":
        controls = (points[0], points[1]) if kind == "C" else (mirrored, points[0])
        pen.curve(controls, end)
        return controls[1]
    control = points[0] if kind == "Q" else mirrored
    first = (start[0] + 2 / 3 * (control[0] - start[0]), start[1] + 2 / 3 * (control[1] - start[1]))
    second = (end[0] + 2 / 3 * (control[0] - end[0]), end[1] + 2 / 3 * (control[1] - end[1]))
    pen.curve((first, second), end)
    return control
