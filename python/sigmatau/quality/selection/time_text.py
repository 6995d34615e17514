"""Times in the text of an option: ``600s``, ``10min``, ``0``; for some options also plain seconds."""

from __future__ import annotations

import re

from sigmatau.errors import OptionError

_UNITS = {"ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
_NUMBER = r"((?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)"
_TIME = re.compile(rf"\s*{_NUMBER}\s*(ms|s|min|h|d)\s*")
_ZERO = re.compile(r"\s*0+(?:\.0*)?\s*")


def parse_time(text: str, whole: str, *, option: str, forms: str) -> float:
    """Convert a time with its unit, ``"600s"`` or ``"2 h"``, to seconds; 0 needs no unit. Raises OptionError for other
    texts.

    The error states `whole`, `option` and `forms`: the text and the name of the option, and the forms that it allows.
    """
    if _ZERO.fullmatch(text):
        return 0.0
    match = _TIME.fullmatch(text)
    if match is None:
        raise OptionError(f"{{option}} {whole!r}: {text.strip()!r} is not a time with a unit; {forms}", option=option)
    return float(match[1]) * _UNITS[match[2]]


def parse_seconds(text: str, *, option: str) -> float:
    """Convert a time without a unit, ``"0.5"``, or with one, ``"10min"``, to seconds. Raises OptionError for other texts."""
    try:
        return float(text)
    except ValueError:
        forms = "give seconds, or a time with its unit, e.g. 500ms or 10min (ms, s, min, h, d)"
        return parse_time(text, text, option=option, forms=forms)
