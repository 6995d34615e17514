"""Places of the texts of SVG files. Fonts are not read: the widths of letters are those of a usual font."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from sigmatau.io.read.figure.drawing import Path, TextPiece, bounding_box
from sigmatau.io.read.figure.geometry import Matrix, applied
from sigmatau.io.read.figure.svg_style import Sheet, Style, computed, declared, length
from sigmatau.io.read.figure.svg_tree import Node

_WIDTH = 0.58  # of a digit over the size of the font: 0.556 in Helvetica, 0.636 in DejaVu Sans
_NARROW = {".": 0.3, ",": 0.3, " ": 0.3, "-": 0.36, "i": 0.25, "l": 0.25}
_SUPERSCRIPT = 0.35  # rise over the size of the font
_MIDDLE = 0.36  # distance of the baseline from the middle of the digits over the size of the font
_DIGIT_HEIGHT = 0.73  # over the size of the font
_UPRIGHT_LETTERS = 3  # smallest number of letters of a text whose outlines show its direction


class _Writer:
    """Sets the pieces of one text element; pieces of a line are shifted by its anchor when it is complete."""

    def __init__(self, sheet: Sheet, anchor: str) -> None:
        self.pieces: list[tuple[str, float, float, float, float]] = []  # text, start, end, baseline, size
        self._sheet = sheet
        self._line: list[tuple[str, float, float, float, float]] = []
        self._x = self._y = self._start = 0.0
        self._anchor = anchor

    def write(self, node: Node, style: Style, rise: float) -> None:
        """Set the texts of an element, then those of its children, in their order."""
        xs, ys = (_numbers(node.attributes.get(name, ""), style) for name in ("x", "y"))
        if xs or ys:
            self.end_line()
            self._x, self._y = (xs or [self._x])[0], (ys or [self._y])[0]
            self._start, self._anchor = self._x, style.anchor
            if node.attributes.get("dominant-baseline", "") in ("middle", "central"):
                self._y += _MIDDLE * style.font_size
        self._x += sum(_numbers(node.attributes.get("dx", ""), style)[:1])
        self._y += sum(_numbers(node.attributes.get("dy", ""), style)[:1])
        for child in node.children:
            if isinstance(child, Node):
                if child.tag in ("tspan", "a", "textPath"):
                    values = declared(child, self._sheet)
                    inner = computed(style, values)
                    if values.get("display") != "none":
                        self.write(child, inner, rise + _rise(values.get("baseline-shift", ""), style))
                continue
            text = " ".join(child.split())
            if len(xs) > 1 and len(xs) >= len(text):
                for letter, x in zip(text, xs, strict=False):
                    self.end_line()
                    self._x = self._start = x
                    self._add(letter, style, rise)
            elif text:
                self._add(text, style, rise)

    def _add(self, text: str, style: Style, rise: float) -> None:
        width = style.font_size * sum(_NARROW.get(letter, _WIDTH) for letter in text)
        if style.is_filled:
            self._line.append((text, self._x, self._x + width, self._y - rise, style.font_size))
        self._x += width

    def end_line(self) -> None:
        """Shift the pieces since the last stated place by the anchor."""
        share = {"middle": 0.5, "end": 1.0}.get(self._anchor, 0.0)
        shift = share * (self._x - self._start)
        self.pieces += [
            (text, start - shift, end - shift, baseline, size) for text, start, end, baseline, size in self._line
        ]
        self._line = []


def place_texts(node: Node, matrix: Matrix, style: Style, sheet: Sheet) -> list[TextPiece]:
    """The pieces of a text element in the coordinates of the page; none if it is not upright."""
    a, b, c, d, _, _ = matrix
    if not (a > 0 and d > 0 and abs(b) < 1e-3 * a and abs(c) < 1e-3 * d):
        return []
    writer = _Writer(sheet, style.anchor)
    writer.write(node, style, 0.0)
    writer.end_line()
    result = []
    for text, start, end, baseline, size in writer.pieces:
        (x0, y), (x1, _) = applied(matrix, np.array([[start, baseline], [end, baseline]])).tolist()
        result.append(TextPiece(text=text, start=x0, end=x1, baseline=y, size=size * d))
    return result


def _numbers(text: str, style: Style) -> list[float]:
    return [length(part, 0.0, percent=style.font_size) for part in re.split(r"[\s,]+", text.strip()) if part]


def _rise(shift: str, style: Style) -> float:
    """Rise of a shifted baseline."""
    if shift in ("super", "sub"):
        return style.font_size * (_SUPERSCRIPT if shift == "super" else -_SUPERSCRIPT)
    return length(shift, 0.0, percent=style.font_size)


def outlined_text(comment: str, outlines: Sequence[Path]) -> TextPiece | None:
    """The text of a comment, at the place of the outlines of its letters; None if these are not outlines."""
    if not outlines or not all(path.is_closed and path.width == 0 for path in outlines):
        return None
    box = bounding_box(np.concatenate([path.points for path in outlines]))
    text = re.sub(r"\\math[a-z]+|[{}$\s]", "", comment)
    size = (box.y_max - box.y_min) / (_DIGIT_HEIGHT * (1.4 if "^" in text else 1.0))
    return TextPiece(text=text, start=box.x_min, end=box.x_max, baseline=box.y_max, size=size)


def is_upright(text: TextPiece) -> bool:
    """Whether outlined letters are beside each other, not above."""
    return len(text.text) < _UPRIGHT_LETTERS or text.end - text.start > _DIGIT_HEIGHT * text.size


def rotated_text(node: Node, style: Style, sheet: Sheet) -> str:
    """All letters of a text in the order of their places, whatever its direction."""
    writer = _Writer(sheet, style.anchor)
    writer.write(node, style, 0.0)
    writer.end_line()
    pieces = sorted(writer.pieces, key=lambda piece: piece[1])
    return "".join(text for text, *_ in pieces)
