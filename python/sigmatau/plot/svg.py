"""A small SVG writer: lines, areas and marks in axes with ticks inside a thin frame, as in printed journals."""

from __future__ import annotations

import math
from collections.abc import Iterable
from html import escape

import numpy as np

from sigmatau.arrays import Floats, runs

_POINTS = 72 / 25.4  # in a millimetre
_SIZE, _LABEL = 6.5, 7.0  # size of tick numbers and of labels [points]
_FRAME, _GRID = 0.4, 0.3  # strokes [points]
_MAJOR, _MINOR = 2.5, 1.3  # lengths of ticks [points]
_MARK = 0.95  # half the size of a marker [points]
_STEPS, _CLOSE = (1, 2, 5), (1, 2, 3, 4, 5)  # leading digits of ticks; the second for short axes
_PLAIN = (-3, 4)  # powers of ten that are written as numbers
_MARKS = {
    "s": [(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)],
    "^": [(0, -1.2), (1.2, 1), (-1.2, 1)],
    "v": [(0, 1.2), (1.2, -1), (-1.2, -1)],
    "D": [(0, -1.3), (1.3, 0), (0, 1.3), (-1.3, 0)],
    "+": [
        *((-0.4, -1.3), (0.4, -1.3), (0.4, -0.4), (1.3, -0.4), (1.3, 0.4), (0.4, 0.4)),
        *((0.4, 1.3), (-0.4, 1.3), (-0.4, 0.4), (-1.3, 0.4), (-1.3, -0.4), (-0.4, -0.4)),
    ],
}  # outlines of markers, in halves of their size


class Drawing:
    """A picture with its size in millimetres."""

    def __init__(self, width: float, height: float, *, font: str = "Libertinus Serif") -> None:
        self._size = width * _POINTS, height * _POINTS
        self._font = font
        self._parts: list[str] = []
        self._clips = 0

    def axes(self, x: float, y: float, width: float, height: float) -> Axes:
        """Axes at a place in millimetres from the upper left corner."""
        self._clips += 1
        return Axes(self._parts, f"c{self._clips}", *(length * _POINTS for length in (x, y, width, height)))

    def svg(self) -> str:
        """The picture, lengths in points."""
        width, height = (f"{length:.1f}" for length in self._size)
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}pt" height="{height}pt"'
            f' viewBox="0 0 {width} {height}" font-family="{escape(self._font)}" stroke-linejoin="round">'
            f"{''.join(self._parts)}</svg>"
        )


class Axes:
    """A frame that maps numbers to positions; numbers of a logarithmic axis are given as logarithms."""

    def __init__(self, parts: list[str], clip: str, x: float, y: float, width: float, height: float) -> None:
        self._parts, self._clip = parts, clip
        self._x0, self._y0, self._width, self._height = x, y, width, height
        self.x: tuple[float, float] = (0.0, 1.0)
        self.y: tuple[float, float] = (0.0, 1.0)
        self._ticks: dict[str, tuple[list[tuple[float, str]], list[float]]] = {"x": ([], []), "y": ([], [])}
        parts.append(
            f'<clipPath id="{clip}"><rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}"/>'
            "</clipPath>"
        )

    def log_x(self, low: float, high: float, *, count: int = 7) -> None:
        """Limits, and ticks up to a largest number."""
        self.x, self._ticks["x"] = (low, high), log_ticks(low, high, count)

    def log_y(self, low: float, high: float, *, count: int = 7) -> None:
        """Limits, and ticks up to a largest number."""
        self.y, self._ticks["y"] = (low, high), log_ticks(low, high, count)

    def linear_x(self, low: float, high: float, *, count: int = 7) -> None:
        """Limits, and ticks up to a largest number."""
        self.x, self._ticks["x"] = (low, high), (_named_ticks(even_ticks(low, high, count)), [])

    def linear_y(self, low: float, high: float, *, count: int = 3) -> None:
        """Limits, and ticks up to a largest number."""
        self.y, self._ticks["y"] = (low, high), (_named_ticks(even_ticks(low, high, count, _CLOSE)), [])

    def line(self, x: Floats, y: Floats, colour: str, width: float, dash: tuple[float, ...] = ()) -> None:
        """A line, interrupted where a number is missing."""
        path = "".join(
            _path(self._to_x(x[a:b]), self._to_y(y[a:b])) for a, b in runs(np.isfinite(x) & np.isfinite(y)) if b - a > 1
        )
        dashes = f' stroke-dasharray="{" ".join(map(str, dash))}"' if dash else ""
        if path:
            self._drawn(path, f'fill="none" stroke="{colour}" stroke-width="{width}"{dashes}')

    def area(self, x: Floats, low: Floats, high: Floats, colour: str) -> None:
        """A transparent band."""
        path = "".join(
            _path(self._to_x(np.append(x[a:b], x[a:b][::-1])), self._to_y(np.append(low[a:b], high[a:b][::-1]))) + "z"
            for a, b in runs(np.isfinite(low) & np.isfinite(high))
        )
        if path:
            self._drawn(path, f'fill="{colour}" fill-opacity="0.16"')

    def steps(self, edges: Floats, low: Floats, high: Floats, colour: str) -> None:
        """An area whose edges are constant between `edges`, with a stroke, so that a constant signal is a line."""
        path = ""
        for a, b in runs(np.isfinite(low) & np.isfinite(high)):
            x, lower, upper = (
                self._to_x(edges[a : b + 1]).tolist(),
                self._to_y(low[a:b]).tolist(),
                self._to_y(high[a:b]),
            )
            upper_path = "".join(f"V{v:.1f}H{u:.1f}" for u, v in zip(x[1:], upper.tolist(), strict=True))
            back = "".join(f"V{v:.1f}H{u:.1f}" for u, v in zip(x[-2::-1], lower[::-1], strict=True))
            path += f"M{x[0]:.1f} {lower[0]:.1f}{upper_path}{back}z"
        if path:
            self._drawn(path, f'fill="{colour}" stroke="{colour}" stroke-width="0.3"')

    def markers(self, x: Floats, y: Floats, kind: str, colour: str) -> None:
        """A small mark at each point: ``o s ^ v D +``."""
        path = ""
        for a, b in zip(self._to_x(x).tolist(), self._to_y(y).tolist(), strict=True):
            if not (math.isfinite(a) and math.isfinite(b)):
                continue
            if kind == "o":
                path += f"M{a - _MARK:.1f} {b:.1f}a{_MARK} {_MARK} 0 1 0 {2 * _MARK} 0a{_MARK} {_MARK} 0 1 0 {-2 * _MARK} 0z"
            else:
                path += "M" + "L".join(f"{a + _MARK * u:.1f} {b + _MARK * v:.1f}" for u, v in _MARKS[kind]) + "z"
        if path:
            self._drawn(path, f'fill="{colour}"')

    def rectangle(
        self, start: float, stop: float, low: float, high: float, colour: str, *, smallest: float = 0.0
    ) -> None:
        """A filled rectangle with a smallest width in points."""
        (a, b), (c, d) = self._to_x(np.array([start, stop])).tolist(), self._to_y(np.array([high, low])).tolist()
        wide = max(b - a, smallest)
        # Drawn a little larger, so that adjacent rectangles leave no gap.
        self._parts.append(
            f'<rect x="{a:.2f}" y="{c:.2f}" width="{wide + 0.15:.2f}" height="{d - c + 0.15:.2f}" fill="{colour}"'
            f' clip-path="url(#{self._clip})"/>'
        )

    def text(self, x: float, y: float, text: str, *, end: bool) -> None:
        """A label below a point, at which it begins or ends."""
        a, b = float(self._to_x(np.array(x))), float(self._to_y(np.array(y)))
        self._written(a + (-2 if end else 2), b + _LABEL, text, "end" if end else "start", _LABEL)

    def frame(self, label: str | None, *, grid: bool = True) -> None:
        """The frame, its ticks with numbers, and the label of the horizontal axis; without a label, that axis has no
        numbers.
        """
        x0, y0, x1, y1 = self._x0, self._y0, self._x0 + self._width, self._y0 + self._height
        lines, ticks = "", ""
        for axis in ("x", "y"):
            major, minor = self._ticks[axis]
            places = [value for value, _ in major]
            for values, length in ((places, _MAJOR), (minor, _MINOR)):
                for tick in (self._to_x if axis == "x" else self._to_y)(np.array(values, dtype=np.float64)).tolist():
                    if axis == "x":
                        ticks += f"M{tick:.1f} {y1:.1f}v{-length}M{tick:.1f} {y0:.1f}v{length}"
                        lines += f"M{tick:.1f} {y0:.1f}V{y1:.1f}" if length == _MAJOR else ""
                    else:
                        ticks += f"M{x0:.1f} {tick:.1f}h{length}M{x1:.1f} {tick:.1f}h{-length}"
                        lines += f"M{x0:.1f} {tick:.1f}H{x1:.1f}" if length == _MAJOR else ""
        if grid:
            # Drawn below everything else in these axes.
            under = next(k for k, part in enumerate(self._parts) if part.startswith(f'<clipPath id="{self._clip}"'))
            self._parts.insert(under + 1, f'<path d="{lines}" stroke="#dcdfe3" stroke-width="{_GRID}"/>')
        box = f"M{x0:.1f} {y0:.1f}H{x1:.1f}V{y1:.1f}H{x0:.1f}z"
        self._parts.append(f'<path d="{box}{ticks}" fill="none" stroke="#000" stroke-width="{_FRAME}"/>')
        for value, text in self._ticks["y"][0]:
            self._written(x0 - 2.5, float(self._to_y(np.array(value))) + 0.33 * _SIZE, text, "end", _SIZE)
        if label is not None:
            for value, text in self._ticks["x"][0]:
                half = (
                    0.26 * _SIZE * len(text)
                )  # of the number's width; it ends where the axes do, if it would be cut off
                place = min(float(self._to_x(np.array(value))), x1 + 1 - half)
                self._written(place, y1 + 2.5 + 0.72 * _SIZE, text, "middle", _SIZE)
            self._written((x0 + x1) / 2, y1 + 3.5 + _SIZE + _LABEL, label, "middle", _LABEL)

    def _written(self, x: float, y: float, text: str, anchor: str, size: float) -> None:
        self._parts.append(
            f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" text-anchor="{anchor}">{escape(text)}</text>'
        )

    def _drawn(self, path: str, style: str) -> None:
        self._parts.append(f'<path d="{path}" {style} clip-path="url(#{self._clip})"/>')

    def _to_x(self, x: Floats) -> Floats:
        return np.asarray(self._x0 + (x - self.x[0]) / (self.x[1] - self.x[0]) * self._width)

    def _to_y(self, y: Floats) -> Floats:
        return np.asarray(self._y0 + (self.y[1] - y) / (self.y[1] - self.y[0]) * self._height)


def log_ticks(low: float, high: float, count: int) -> tuple[list[tuple[float, str]], list[float]]:
    """Ticks with numbers and ticks without, for a logarithmic axis between two logarithms."""
    first, last = math.ceil(low - 1e-9), math.floor(high + 1e-9)
    step = max(1, math.ceil((last - first + 1) / count))
    decades = [k for k in range(first, last + 1) if k % step == 0]
    tenths = [k + math.log10(j) for k in range(first - 1, last + 1) for j in range(2, 10)]
    minor = [value for value in (tenths if step == 1 else map(float, range(first, last + 1))) if low <= value <= high]
    if len(decades) > 1:
        plain = decades[0] >= _PLAIN[0] and decades[-1] <= _PLAIN[1]
        return [(float(k), f"{10.0**k:g}" if plain else power(k)) for k in decades], minor
    values = [10.0**k * j for k in range(first - 1, last + 1) for j in (1, 2, 5) if low <= k + math.log10(j) <= high]
    if len(values) < 3:
        values, minor = even_ticks(10**low, 10**high, count), []
    return [(math.log10(value), text) for value, text in _named_ticks(values)], minor


def even_ticks(low: float, high: float, count: int, steps: tuple[int, ...] = _STEPS) -> list[float]:
    """At most `count` round numbers at equal distances between two numbers."""
    span = high - low
    if not span > 0:
        return []
    exponent = math.floor(math.log10(span / count)) - 1
    for step in (j * 10.0**k for k in range(exponent, exponent + 4) for j in steps):
        first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
        if last - first + 1 <= count:
            return [k * step for k in range(first, last + 1)]
    return []


def _named_ticks(values: Iterable[float]) -> list[tuple[float, str]]:
    return [(value, number(value)) for value in values]


def number(value: float) -> str:
    """A number at a tick: ``"0.01"``, ``"−5"``, ``"2·10⁻⁸"``."""
    digits, _, exponent = f"{value:.6g}".partition("e")
    if not exponent:
        return digits.replace("-", "−")
    return power(int(exponent)) if digits == "1" else f"{digits.replace('-', '−')}·{power(int(exponent))}"


def power(exponent: int) -> str:
    """``"10⁻⁸"``."""
    return "10" + str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def _path(x: Floats, y: Floats) -> str:
    points = np.clip(np.stack([x, y], axis=1), -9999, 9999)
    return "M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in points.tolist())
