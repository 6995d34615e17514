"""Titles of axes: their units, logarithms and factors, which change the values of the labels."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from sigmatau.errors import OptionError
from sigmatau.hints import Hint
from sigmatau.io.read.curve_table import rate_unit
from sigmatau.io.read.figure.drawing import Box
from sigmatau.io.read.figure.labels import Word

_TITLE = 6.0  # largest distance of the title of the x axis from the axis over the size of the font
_TIMES = (
    r"(h|hrs?|hours?|mins?|minutes?|d|days?|ks|m(?:illi)?s(?:ec(?:onds?)?)?"
    r"|(?:[uµμ]|micro)s(?:ec(?:onds?)?)?|samples?|k?Hz)"
)
_OTHER_X = (
    re.compile(rf"[\[(]\s*{_TIMES}\s*[\])]", re.IGNORECASE),
    re.compile(rf"(?:times?|τ|tau|lag|frequency)\s*[,/]?\s*(?:in\s*)?{_TIMES}\s*$", re.IGNORECASE),
    re.compile(r"\b(?:number|no\.?|#)\s*of\s*(samples)\b|\b(samples)\s*(?:per|in\s*a)\s*cluster", re.IGNORECASE),
)
_BRACKETS = re.compile(r"[\[(]([^\[\]()]+)[\])]")
_SQUARED = re.compile(r"[\])]\s*\^?\s*\{?[²2]|[\[(][^\[\]()]*[a-z°]\s*\^?[²2]\s*/\s*(?:h|hr|s)\s*\^?[²2]")
_LOGARITHM = re.compile(r"\blog\s*(?:_?\{?10\}?|₁₀)?\s*[\[({]?\s*(?:τ|tau|σ|sigma|a?dev|allan|time|t\b)", re.IGNORECASE)
_FACTOR = re.compile(r"(?:\\times|[×x·*])10(?:\^\{?)?[-−+]?[\d⁻⁰¹²³⁴-⁹]{1,3}\}?|1e[-−+]?\d{1,2}", re.IGNORECASE)
_MAX_FACTOR = 24  # letters
_MAX_TITLE = 200  # letters
_FACTOR_RISE = (0.1, 4.0)  # of a factor above the highest tick over the size of the font
_ABOVE = 2.0  # largest distance of the beginning of a text above a y axis to the right of it over the size of the font
_FACTOR_REACH = 8.0  # largest distance of a factor from the end of its axis over the size of the font


def titles_above(words: Sequence[Word], first: float, across: float) -> Iterator[str]:
    """Texts above the upper end of a y axis, at its side, such as its unit.

    `first`: coordinate of its highest labelled tick; `across`: that of the ends of its ticks.
    """
    for word in words:
        size = word.first.size
        is_above = _FACTOR_RISE[0] * size <= first - word.first.baseline <= _TITLE * size
        if is_above and -_FACTOR_REACH * size <= word.first.start - across <= _ABOVE * size:
            yield word.text


def has_unit(titles: Iterable[str]) -> bool:
    """Whether a title has the unit of a rate."""
    return any(True for text in titles if len(text) <= _MAX_TITLE for _ in _units(_plain(text)))


def other_unit(words: Sequence[Word], box: Box) -> str:
    """The unit of a title such as ``τ [h]`` below a line, other than seconds; empty if there is none."""
    reach = box.y_max - box.y_min
    for word in words:
        if len(word.text) > _MAX_TITLE:
            continue
        is_below = 0 < word.first.baseline - box.y_max < reach + _TITLE * word.first.size
        is_within = word.end > box.x_min and word.first.start < box.x_max
        if is_below and is_within:
            match = next((match for each in _OTHER_X if (match := each.search(word.text))), None)
            if match:
                return str(next(text for text in match.groups() if text))
    return ""


def has_logarithm(words: Sequence[Word], titles: Iterable[str]) -> bool:
    """Whether a title is that of a logarithm, such as ``log10(τ)``."""
    texts = [word.text for word in words]
    return any(_LOGARITHM.search(text) for text in [*texts, *titles] if len(text) <= _MAX_TITLE)


def check_unit(titles: Iterable[str], unit: str, *, is_variance: bool) -> None:
    """Compare the unit of the y axis with the titles beside y axes. Raises `OptionError` if one of their units differs."""
    si, factor = rate_unit(unit)
    texts = [_plain(text) for text in titles if len(text) <= _MAX_TITLE]
    units = [each for text in texts for each in _units(text)]
    different = [each for each in units if each[1] != si or abs(each[2] / factor - 1) >= 1e-3]
    if different and len(different) == len(units):
        raise OptionError(
            f"has a y axis in {units[0][0]}, not {unit}. Give {Hint('unit', value=units[0][0])}", option="unit"
        )
    if different:
        hint = Hint("y_axis", value={"COORDINATE": "VALUE"})
        raise OptionError(
            f"has y axes in {unit} and {different[0][0]}. State two points of that of the line, {hint}", option="y_axis"
        )
    if not is_variance and texts and all(_SQUARED.search(text) for text in texts):
        raise OptionError(f"has variances, {texts[0]}. Give {Hint('content', value='variance')}", option="content")


def _units(title: str) -> Iterator[tuple[str, str, float]]:
    """Units of a rate in a title, in brackets or at its end: text, SI unit and size."""
    ends = [re.split(r"[\s,]+", title)[-1]] if not _BRACKETS.search(title) else []
    for text in [*_BRACKETS.findall(title), *ends]:
        try:
            si, factor = rate_unit(text.strip())
        except OptionError:  # the unit of another quantity
            continue
        if si != text.strip() or si in ("rad/s", "m/s^2"):
            yield text.strip(), si, factor


def _plain(text: str) -> str:
    """A title without the commands of TeX."""
    text = re.sub(r"\\(?:mathrm|mathdefault|text|rm)\b", "", text.replace(r"\circ", "°").replace(r"\mu", "µ"))
    return re.sub(r"[{}$]|\^(?=\{?°)", "", text.replace("∘", "°"))


def factor_text(
    words: Sequence[Word], way: str, first: float, last: float, across: float, labels: Iterable[str]
) -> str:
    """The factor of all values of an axis, such as ``×10⁻³`` above the y axis; empty if there is none."""
    in_row = {*labels}
    for word in words:
        size = word.first.size
        text = word.text.replace(" ", "")
        if len(text) > _MAX_FACTOR or word.text in in_row or not _FACTOR.fullmatch(text):
            continue
        if way == "y":
            is_beyond = _FACTOR_RISE[0] * size <= first - word.first.baseline <= _FACTOR_REACH * size
            is_aligned = -_FACTOR_REACH * size <= word.first.start - across <= _FACTOR_RISE[1] * size
        else:
            is_beyond = abs(word.end - last) <= _FACTOR_REACH * size
            is_aligned = _FACTOR_RISE[0] * size <= word.first.baseline - across <= _FACTOR_RISE[1] * size
        if is_beyond and is_aligned:
            return text
    return ""
