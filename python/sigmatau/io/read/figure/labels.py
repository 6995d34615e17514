"""Numbers of tick labels: letters joined to words, and words read as numbers."""

from __future__ import annotations

import re
from collections.abc import Sequence

from sigmatau.frozen import frozen
from sigmatau.io.read.figure.drawing import Box, TextPiece

_GAP = 0.5  # largest distance of the letters of a word over the size of the font
_OVERLAP = 0.25  # largest overlap of adjacent letters over the size of the font
_SAME_LINE = 0.2  # largest difference of the baselines of a word over the size of the font
_RISE = (0.2, 0.9)  # rise of a superscript over the size of the font
_TITLE = 6.0  # largest distance of the title of the x axis from the axis over the size of the font
_SMALLER = 0.9  # size of a superscript over that of its base, at most

_MINUS = str.maketrans(dict.fromkeys("−–‒‐‑﹣－", "-") | {"⋅": "·", "×": "·", "*": "·", " ": ""})
_RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")
_PLAIN = re.compile(r"[-+]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d+)?")
_THOUSANDS = re.compile(r"\d{1,3}(?:,\d{3})+(?:\.\d*)?")
_OTHER_TIME = re.compile(r"[\[(](h|hrs?|hours?|min|minutes?|days?|ms|[µμ]s|samples?)[\])]")
_POWER = re.compile(r"(?:([\d.]+)[·x])?10(?:\^|\*\*)?([-+]?\d{1,2})")


@frozen(eq=False)
class TickLabel:
    """A number beside an axis: its text, its value, and its place."""

    text: str
    value: float
    is_power: bool
    start: float
    end: float
    baseline: float
    size: float

    @property
    def x(self) -> float:
        """Middle of the text."""
        return 0.5 * (self.start + self.end)

    @property
    def y(self) -> float:
        """Middle of the digits."""
        return self.baseline - 0.36 * self.size


def find_labels(texts: Sequence[TextPiece]) -> list[TickLabel]:
    """All numbers among the texts of a drawing."""
    labels = []
    for word in _words(texts):
        number = parse_number(word.text)
        if number is not None:
            value, is_power = number
            labels.append(
                TickLabel(
                    text=word.text,
                    value=value,
                    is_power=is_power,
                    start=word.first.start,
                    end=word.end,
                    baseline=word.first.baseline,
                    size=word.first.size,
                )
            )
    return labels


def unit_of_time(texts: Sequence[TextPiece], box: Box) -> str:
    """The unit of time of a title such as ``τ [h]`` below a line, other than seconds; empty if there is none."""
    reach = box.y_max - box.y_min
    for word in _words(texts):
        is_below = 0 < word.first.baseline - box.y_max < reach + _TITLE * word.first.size
        is_within = word.end > box.x_min and word.first.start < box.x_max
        if is_below and is_within and (match := _OTHER_TIME.search(word.text)):
            return match[1]
    return ""


class _Word:
    """Adjacent pieces of text."""

    def __init__(self, text: TextPiece) -> None:
        self.first = text
        self.text, self.end = text.text, text.end
        self.is_raised = False  # whether its last piece is a superscript

    def distance(self, text: TextPiece) -> float | None:
        """Distance of the next piece; None if the piece does not continue the word."""
        gap, size = text.start - self.end, self.first.size
        rise = (self.first.baseline - text.baseline) / size
        is_raised = _RISE[0] <= rise <= _RISE[1] and text.size <= _SMALLER * size
        is_next = -_OVERLAP * size <= gap <= _GAP * size
        return abs(gap) if is_next and (is_raised or abs(rise) <= _SAME_LINE) else None

    def add(self, text: TextPiece) -> None:
        """Append a piece; a superscript follows ``^``."""
        is_raised = self.first.baseline - text.baseline >= _RISE[0] * self.first.size
        self.text += f"^{text.text}" if is_raised and not self.is_raised else text.text
        self.end, self.is_raised = max(self.end, text.end), is_raised


def _words(texts: Sequence[TextPiece]) -> list[_Word]:
    """Join adjacent pieces of text from left to right. Files have them in any order."""
    complete: list[_Word] = []
    words: list[_Word] = []
    for text in sorted(texts, key=lambda each: each.start):
        complete += [word for word in words if word.end + _GAP * word.first.size < text.start]
        words = [word for word in words if word.end + _GAP * word.first.size >= text.start]
        following = [(distance, k) for k, word in enumerate(words) if (distance := word.distance(text)) is not None]
        if following:
            words[min(following)[1]].add(text)
        else:
            words.append(_Word(text))
    return complete + words


def parse_number(text: str) -> tuple[float, bool] | None:
    """The number of a label, and whether it is written as a power of ten; None for another text."""
    text = text.strip().replace(r"\times", "·").replace(r"\cdot", "·").translate(_MINUS)
    if re.search(r"[⁰¹²³⁴-⁹⁻]", text):
        text = re.sub(r"([⁰¹²³⁴-⁹⁻⁺]+)", lambda match: "^" + match[1].translate(_RAISED), text)
    if (match := _POWER.fullmatch(text)) and ("^" in text or "**" in text or match[2][0] in "-+"):
        factor = float(match[1]) if match[1] and match[1].count(".") < 2 and match[1] != "." else 1.0
        return factor * 10.0 ** int(match[2]), True
    if _THOUSANDS.fullmatch(text):
        return float(text.replace(",", "")), False
    if _PLAIN.fullmatch(text):
        return float(text.replace(",", ".")), False
    return None
