"""Numbers of tick labels: letters joined to words, and words read as numbers."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.io.read.figure.drawing import TOO_COMPLEX, TextPiece

_GAP = 0.5  # largest distance of the letters of a word over the size of the font
_OVERLAP = 0.25  # largest overlap of adjacent letters over the size of the font
_SAME_LINE = 0.2  # largest difference of the baselines of a word over the size of the font
_RISE = (0.2, 0.9)  # rise of a superscript over the size of the font
_SMALLER = 0.9  # size of a superscript over that of its base, at most
_MAX_LETTERS = 24  # of a number
_MAX_COMPARED = 2_000_000  # pairs of pieces of text, of a page with 20 000 letters in 100 lines. Measured: 1 s
_BASE_GAP = 1.0  # largest distance of a superscript from the base 10 over the size of the font

_MINUS = str.maketrans(dict.fromkeys("−–‒‐‑﹣－", "-") | {"⋅": "·", "×": "·", "*": "·", " ": ""})
_RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")
_PLAIN = re.compile(r"[-+]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d+)?")
_THOUSANDS = re.compile(r"[1-9]\d{0,2}(?:,\d{3})+(?:\.\d*)?")
_DECIMAL_COMMA = re.compile(r"0,\d+|\d+,\d{1,2}|\d{1,3}(?:\.\d{3}){2,}")  # texts that no decimal point explains
_THOUSAND_POINTS = re.compile(r"[1-9]\d{0,2}(?:\.\d{3})+")
_POWER = re.compile(r"(?:([\d.]+)[·x])?10(?:\^|\*\*)?([-+]?\d{1,2})")
_ENDING = re.compile(r"(.*[\d.⁰¹²³⁴-⁹])\s*([a-zA-Zµμ]+)")
_PREFIXES = {"n": 1e-9, "u": 1e-6, "µ": 1e-6, "μ": 1e-6, "m": 1e-3, "k": 1e3, "K": 1e3, "M": 1e6, "G": 1e9}
_TIMES = {
    **{f"{prefix}s": size for prefix, size in _PREFIXES.items() if prefix in "nuµμmk"},
    **dict.fromkeys(("s", "sec", "second", "seconds"), 1.0),
    **dict.fromkeys(("min", "mins", "minute", "minutes"), 60.0),
    **dict.fromkeys(("h", "hr", "hrs", "hour", "hours"), 3600.0),
    **dict.fromkeys(("d", "day", "days"), 86400.0),
}
TIME, MILLI = "s", "m"
"""Values of `TickLabel.suffix` with a meaning for the axis."""


@frozen(eq=False)
class TickLabel:
    """A number beside an axis: its text, its value, and its place.

    `suffix`: `TIME` for a number with a unit of time, whose value is in s; `MILLI` for ``10m``, which may be minutes.
    """

    text: str
    value: float
    is_power: bool
    suffix: str
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


def labels_among(words: Sequence[Word]) -> list[TickLabel]:
    """All numbers among words. A comma is a decimal one everywhere if no other reading explains one of them."""
    labels = []
    words = [word for word in words if len(word.text) <= _MAX_LETTERS]
    has_comma = any(_DECIMAL_COMMA.fullmatch(word.text.strip()) for word in words)
    for word in words:
        number = parse_label(word.text, decimal_comma=has_comma)
        if number is not None and math.isfinite(number[0]):
            value, is_power, suffix = number
            labels.append(
                TickLabel(
                    text=word.text,
                    value=value,
                    is_power=is_power,
                    suffix=suffix,
                    start=word.first.start,
                    end=word.end,
                    baseline=word.first.baseline,
                    size=word.first.size,
                )
            )
    return labels


class Word:
    """Adjacent pieces of text."""

    def __init__(self, text: TextPiece) -> None:
        self.first = text
        self.text: str = text.text
        self.end: float = text.end
        self.is_raised = False  # whether its last piece is a superscript

    def distance(self, text: TextPiece) -> float | None:
        """Distance of the next piece; None if the piece does not continue the word."""
        gap, size = text.start - self.end, self.first.size
        rise = (self.first.baseline - text.baseline) / size
        is_raised = self._is_raised(rise, text.size) and -_OVERLAP * size <= gap <= self.reach
        is_next = -_OVERLAP * size <= gap <= _GAP * size and abs(rise) <= _SAME_LINE
        return abs(gap) if is_next or is_raised else None

    @property
    def reach(self) -> float:
        """Largest distance of the next piece."""
        return (_BASE_GAP if self._is_base else _GAP) * self.first.size

    @property
    def _is_base(self) -> bool:
        return self.text.endswith("10") and not self.is_raised

    def _is_raised(self, rise: float, size: float) -> bool:
        """Whether a piece that rises by a share of the size of the font is a superscript. That of a base 10 may have
        the same size, or rise little.
        """
        is_smaller = size <= _SMALLER * self.first.size
        if self._is_base and (is_smaller or rise >= _RISE[0]):
            return (0.0 if is_smaller else _RISE[0]) < rise <= _RISE[1]
        return is_smaller and _RISE[0] <= rise <= _RISE[1]

    def add(self, text: TextPiece) -> None:
        """Append a piece; a superscript follows ``^``."""
        rise = (self.first.baseline - text.baseline) / self.first.size
        is_raised = self._is_raised(rise, text.size) or (self.is_raised and rise > 0)
        self.text += f"^{text.text}" if is_raised and not self.is_raised else text.text
        self.end, self.is_raised = max(self.end, text.end), is_raised


def joined_words(texts: Sequence[TextPiece]) -> list[Word]:
    """Join adjacent pieces of text from left to right. Files have them in any order."""
    complete: list[Word] = []
    words: list[Word] = []
    compared = 0
    for text in sorted(filter(_is_placed, texts), key=lambda each: each.start):
        compared += len(words)
        if compared > _MAX_COMPARED:
            raise DataError(TOO_COMPLEX)
        complete += [word for word in words if word.end + word.reach < text.start]
        words = [word for word in words if word.end + word.reach >= text.start]
        following = [(distance, k) for k, word in enumerate(words) if (distance := word.distance(text)) is not None]
        if following:
            words[min(following)[1]].add(text)
        else:
            words.append(Word(text))
    return complete + words


def _is_placed(text: TextPiece) -> bool:
    """Whether a text has a place and a size."""
    return text.size > 0 and math.isfinite(text.size + text.start + text.end + text.baseline)


def parse_label(text: str, *, decimal_comma: bool = False) -> tuple[float, bool, str] | None:
    """As `parse_number`, also of a number with an SI prefix, ``1k``, or a unit of time, ``10 ms``; with its suffix."""
    text = text.strip()
    ending = _ENDING.fullmatch(text)
    word = ending[2] if ending else ""
    size = _TIMES.get(word) or _PREFIXES.get(word)
    number = parse_number(ending[1] if ending and size else text, decimal_comma=decimal_comma)
    if number is None:
        return None
    suffix = TIME if word in _TIMES else MILLI if word == "m" else ""
    return number[0] * (size or 1.0), number[1], suffix


def parse_number(text: str, *, decimal_comma: bool = False) -> tuple[float, bool] | None:
    """The number of a label, and whether it is written as a power of ten; None for another text."""
    text = text.strip().replace(r"\times", "·").replace(r"\cdot", "·").translate(_MINUS)
    if re.search(r"[⁰¹²³⁴-⁹⁻]", text):
        text = re.sub(r"([⁰¹²³⁴-⁹⁻⁺]+)", lambda match: "^" + match[1].translate(_RAISED), text)
    if (match := _POWER.fullmatch(text)) and ("^" in text or "**" in text or match[2][0] in "-+"):
        factor = float(match[1]) if match[1] and match[1].count(".") < 2 and match[1] != "." else 1.0
        return factor * 10.0 ** int(match[2]), True
    if decimal_comma and _THOUSAND_POINTS.fullmatch(text):
        return float(text.replace(".", "")), False
    if not decimal_comma and _THOUSANDS.fullmatch(text):
        return float(text.replace(",", "")), False
    if _PLAIN.fullmatch(text):
        return float(text.replace(",", ".")), False
    return None
