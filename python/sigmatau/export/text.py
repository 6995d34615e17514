"""Text that goes into other programs' files: numbers to the last digit, names that cannot break out of their quotes."""

from __future__ import annotations

import json
import re

from sigmatau.errors import OptionError

__all__ = ["comment", "digits", "plain_name", "quoted", "remark", "setting", "topic"]

_LONGEST = 600  # characters of a comment: some parsers have line buffers
_ASCII = {"√Hz": "sqrt(Hz)", "√h": "sqrt(h)", "√s": "sqrt(s)", "√": "sqrt ", "µ": "u", "²": "^2", "³": "^3", "·": "*"}


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
    """Words for the rest of a comment line, ASCII alone: no line ends, nothing that a parser stumbles over."""
    for character, plain in _ASCII.items():
        words = words.replace(character, plain)
    text = "".join(c if " " <= c <= "~" else "?" for c in words)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 4]} ..."


def remark(words: str) -> str:
    """A line of its own with a comment."""
    return f"# {comment(words)}"


def setting(key: str, value: float, words: str) -> str:
    """A line of YAML: a number, and behind it in a comment its unit and where it comes from."""
    return f"{key}: {digits(value)}  # {comment(words)}"


def quoted(text: str) -> str:
    """A string in double quotes as JSON, YAML and MATLAB's jsondecode read it; ASCII alone, so that nothing breaks out."""
    return json.dumps(text, ensure_ascii=True)


def plain_name(text: str, option: str) -> str:
    """A name for a place where nothing can be quoted; raises `OptionError` unless it is letters, digits and ``_ . / -``."""
    if not re.fullmatch(r"[A-Za-z0-9_./~-]+", text, flags=re.ASCII):
        raise OptionError(f"`{option}` {text!r}: letters, digits, _ . / and - are allowed there", option=option)
    return text


def topic(text: str) -> str:
    """A topic of ROS in quotes; raises `OptionError` for what no topic can be called.

    Quotes alone would not do: readers of YAML differ in the escapes that they know.
    """
    if not re.fullmatch(r"[A-Za-z0-9_~/]{1,255}", text):
        raise OptionError(
            f"`name` topic={text[:80]!r}: a topic has letters, digits, _ and /, e.g. topic=/imu0", option="name"
        )
    return f'"{text}"'
