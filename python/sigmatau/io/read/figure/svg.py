"""Read the visible paths and texts of an SVG file."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.io.read.figure import svg_path
from sigmatau.io.read.figure.drawing import (
    EVERYWHERE,
    MAX_DEPTH,
    MAX_OBJECTS,
    MAX_VERTICES,
    TOO_COMPLEX,
    Box,
    FigurePage,
    Path,
    TextPiece,
    bounding_box,
)
from sigmatau.io.read.figure.geometry import IDENTITY, Matrix, Pen, combined
from sigmatau.io.read.figure.svg_style import Sheet, Style, collect_sheet, computed, declared, length
from sigmatau.io.read.figure.svg_text import is_upright, outlined_text, place_texts, rotated_text
from sigmatau.io.read.figure.svg_tree import COMMENT, Node, parse

_CONTAINERS = ("svg", "g", "a", "switch", "use", "symbol")
_SHAPES = ("path", "polyline", "polygon", "line", "rect", "circle", "ellipse")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_TRANSFORM = re.compile(r"(matrix|translate|scale|rotate|skewX|skewY)\s*\(([^)]*)\)")
_URL = re.compile(r"url\(\s*['\"]?#([^'\")]+)['\"]?\s*\)")


def read(data: bytes) -> FigurePage:
    """The drawing of an SVG file."""
    root = parse(data)
    reader = _Reader(root)
    reader.walk(root, _Inherited(), depth=0)
    box = numbers(root.attributes.get("viewBox", ""))
    width, height = (length(root.attributes.get(name, ""), 0.0) for name in ("width", "height"))
    if len(box) == 4:
        width, height = box[2:]
    return FigurePage(
        width=width,
        height=height,
        paths=tuple(reader.paths),
        texts=tuple(reader.texts),
        titles=tuple(reader.titles),
        has_image=reader.has_image,
    )


def numbers(text: str) -> list[float]:
    """All numbers of an attribute."""
    return [float(value) for value in _NUMBER.findall(text)]


@frozen(eq=False)
class _Inherited:
    """What an element takes over from its parents."""

    matrix: Matrix = IDENTITY
    style: Style = Style()
    clip: Box = EVERYWHERE


class _Reader:
    def __init__(self, root: Node) -> None:
        self.paths: list[Path] = []
        self.texts: list[TextPiece] = []
        self.titles: list[str] = []
        self.has_image = False
        self._sheet: Sheet = collect_sheet(root)
        self._ids: dict[str, Node] = {}
        self._objects = self._vertices = 0
        stack = [root]
        while stack:
            node = stack.pop()
            stack += node.elements
            if (name := node.attributes.get("id")) is not None:
                self._ids.setdefault(name, node)

    def walk(self, node: Node, parent: _Inherited, *, depth: int) -> None:
        """Collect the paths and texts of an element and its children."""
        self._objects += 1
        if self._objects > MAX_OBJECTS or self._vertices > MAX_VERTICES or depth > MAX_DEPTH:
            raise DataError(TOO_COMPLEX)
        values = declared(node, self._sheet)
        if values.get("display") == "none":
            return
        matrix = combined(parent.matrix, transform(node.attributes.get("transform", "")))
        style = computed(parent.style, values)
        if style.opacity <= 0:
            return
        clip = self._clip(values.get("clip-path", ""), matrix, parent.clip, depth)
        state = _Inherited(matrix=matrix, style=style, clip=clip)
        if node.tag in _SHAPES:
            self.paths += self._shape(node, state)
        elif node.tag == "text":
            texts = place_texts(node, matrix, style, self._sheet)
            self.texts += texts
            if not texts and style.is_filled:
                self.titles.append(rotated_text(node, style, self._sheet))
        elif node.tag == "image":
            self.has_image = True
        elif node.tag in _CONTAINERS:
            self._children(node, state, depth)

    def _children(self, node: Node, state: _Inherited, depth: int) -> None:
        x, y = (length(node.attributes.get(name, ""), 0.0) for name in ("x", "y"))
        if node.tag == "use":
            reference = self._ids.get(node.attributes.get("href", "").removeprefix("#"))
            if reference is not None:
                moved = replace(state, matrix=combined(state.matrix, (1.0, 0.0, 0.0, 1.0, x, y)))
                self.walk(reference, moved, depth=depth + 1)
            return
        if node.tag == "svg" and depth > 0:
            state = replace(state, matrix=combined(state.matrix, _view(node, x, y)))
        outline = ""
        for child in node.elements:
            if child.tag == COMMENT:
                outline = child.text
                continue
            first = len(self.paths)
            self.walk(child, state, depth=depth + 1)
            # Matplotlib writes a text as a comment, followed by the group of the outlines of its letters.
            if outline and child.tag == "g" and (text := outlined_text(outline, self.paths[first:])) is not None:
                if is_upright(text):
                    self.texts.append(text)
                else:
                    self.titles.append(text.text)
                del self.paths[first:]
            outline = ""

    def _shape(self, node: Node, state: _Inherited) -> list[Path]:
        style = state.style
        if not (style.is_stroked or style.is_filled):
            return []
        pen = Pen()
        _draw(node, pen)
        pen.finish()
        self._vertices += pen.vertices
        color, width = (style.stroke, style.stroke_width) if style.is_stroked else (style.fill, 0.0)
        return pen.paths(state.matrix, color=color, width=width, clip=state.clip)

    def _clip(self, value: str, matrix: Matrix, clip: Box, depth: int) -> Box:
        """The visible region: the rectangle around the shapes of a clip path."""
        match = _URL.search(value)
        region = self._ids.get(match[1]) if match else None
        if region is None or depth > MAX_DEPTH:
            return clip
        inner = combined(matrix, transform(region.attributes.get("transform", "")))
        paths: list[Path] = []
        for child in region.elements:
            if child.tag in _SHAPES:
                local = combined(inner, transform(child.attributes.get("transform", "")))
                paths += self._shape(child, _Inherited(matrix=local))
        if not paths:
            return clip
        return clip.cut(bounding_box(np.concatenate([path.points for path in paths])))


def _draw(node: Node, pen: Pen) -> None:
    """Draw a shape."""
    attributes = node.attributes

    def size(name: str) -> float:
        return length(attributes.get(name, ""), 0.0)

    if node.tag == "path":
        svg_path.draw(attributes.get("d", ""), pen)
    elif node.tag in ("polyline", "polygon"):
        values = numbers(attributes.get("points", ""))
        _polyline(list(zip(values[::2], values[1::2], strict=False)), pen, closed=node.tag == "polygon")
    elif node.tag == "line":
        _polyline([(size("x1"), size("y1")), (size("x2"), size("y2"))], pen, closed=False)
    elif node.tag == "rect":
        x, y, width, height = (size(name) for name in ("x", "y", "width", "height"))
        _polyline([(x, y), (x + width, y), (x + width, y + height), (x, y + height)], pen, closed=True)
    else:
        rx, ry = (size("r") or size(name) for name in ("rx", "ry"))
        turns = [k * math.pi / 4 for k in range(8)]
        center = (size("cx"), size("cy"))
        _polyline([(center[0] + rx * math.cos(t), center[1] + ry * math.sin(t)) for t in turns], pen, closed=True)


def _polyline(points: Sequence[tuple[float, float]], pen: Pen, *, closed: bool) -> None:
    for k, point in enumerate(points):
        (pen.line if k else pen.move)(*point)
    if closed:
        pen.close()


def _view(node: Node, x: float, y: float) -> Matrix:
    """The transform of a nested drawing: its place, and the scale of its viewBox."""
    box = numbers(node.attributes.get("viewBox", ""))
    width, height = (length(node.attributes.get(name, ""), 0.0) for name in ("width", "height"))
    if len(box) != 4 or not (box[2] > 0 and box[3] > 0 and width > 0 and height > 0):
        return (1.0, 0.0, 0.0, 1.0, x, y)
    a, d = width / box[2], height / box[3]
    if node.attributes.get("preserveAspectRatio", "").strip() != "none":
        a = d = min(a, d)
    x += 0.5 * (width - a * box[2]) - a * box[0]
    y += 0.5 * (height - d * box[3]) - d * box[1]
    return (a, 0.0, 0.0, d, x, y)


def transform(text: str) -> Matrix:
    """The transform of an attribute ``transform``."""
    result = IDENTITY
    for name, arguments in _TRANSFORM.findall(text):
        values = numbers(arguments)
        result = combined(result, _matrix(name, values)) if values else result
    return result


def _matrix(name: str, values: list[float]) -> Matrix:
    first, second = values[0], values[1] if len(values) > 1 else None
    if name == "matrix":
        return (*values,) if len(values) == 6 else IDENTITY  # type: ignore[return-value]
    if name == "translate":
        return (1.0, 0.0, 0.0, 1.0, first, second or 0.0)
    if name == "scale":
        return (first, 0.0, 0.0, first if second is None else second, 0.0, 0.0)
    angle = math.radians(first)
    if name == "skewX":
        return (1.0, 0.0, math.tan(angle), 1.0, 0.0, 0.0)
    if name == "skewY":
        return (1.0, math.tan(angle), 0.0, 1.0, 0.0, 0.0)
    turn = (math.cos(angle), math.sin(angle), -math.sin(angle), math.cos(angle), 0.0, 0.0)
    if len(values) < 3:
        return turn
    x, y = values[1:3]
    return combined(combined((1.0, 0.0, 0.0, 1.0, x, y), turn), (1.0, 0.0, 0.0, 1.0, -x, -y))
