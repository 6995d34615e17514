"""Text that goes into other programs' files: numbers to the last digit, names that cannot break out of their quotes."""

from __future__ import annotations

import json
import re

from sigmatau.errors import OptionError

__all__ = ["comment", "digits", "plain_name", "quoted"]


def digits(value: float) -> str:
    """A number that reads back to the same bits, with a point or an exponent that YAML 1.1 takes for a number too."""
    text = repr(float(value))
    if "e" in text:
        mantissa, exponent = text.split("e")
        mantissa = mantissa if "." in mantissa else f"{mantissa}.0"
        sign = exponent[0] if exponent[0] in "+-" else "+"
        return f"{mantissa}e{sign}{exponent.lstrip('+-')}"
    return text


def comment(words: str) -> str:
    """Words for the rest of a comment line: no line ends, nothing that does not print."""
    return "".join(c if c.isprintable() else " " for c in words)


def quoted(text: str) -> str:
    """A string in double quotes as JSON, YAML and MATLAB's jsondecode read it; ASCII alone, so that nothing breaks out."""
    return json.dumps(text, ensure_ascii=True)


def plain_name(text: str, option: str) -> str:
    """A name for a place where nothing can be quoted; raises `OptionError` unless it is letters, digits and ``_ . / -``."""
    if not re.fullmatch(r"[A-Za-z0-9_./~-]+", text):
        raise OptionError(f"`{option}` {text!r}: letters, digits, _ . / and - are allowed there", option=option)
    return text
