"""Times in the text of an option: ``600s``, ``10min``, ``0``."""

from __future__ import annotations

import re

from sigmatau.errors import OptionError

__all__ = ["time_of"]

_UNITS = {"ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
_NUMBER = r"((?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)"
_TIME = re.compile(rf"\s*{_NUMBER}\s*(ms|s|min|h|d)\s*")
_ZERO = re.compile(r"\s*0+(?:\.0*)?\s*")


def time_of(text: str, whole: str, *, option: str, forms: str) -> float:
    """A time with its unit, in seconds; 0 needs no unit.

    Parameters
    ----------
    text : str
        ``"600s"``, ``"2 h"``, ``"0"``.
    whole : str
        The text of the option, for the error.
    option : str
        Its name.
    forms : str
        Allowed forms, for the error.

    Raises
    ------
    OptionError
        For anything else.
    """
    if _ZERO.fullmatch(text):
        return 0.0
    match = _TIME.fullmatch(text)
    if match is None:
        raise OptionError(f"{{option}} {whole!r}: {text.strip()!r} is not a time with a unit; {forms}", option=option)
    return float(match[1]) * _UNITS[match[2]]
