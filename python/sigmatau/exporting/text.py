"""Text for files of other programs: numbers with significant digits, and names that cannot break out of their quotes."""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Iterable

import numpy as np

from sigmatau.errors import DataError, OptionError
from sigmatau.hints import MARK_BEGIN, worded
from sigmatau.results import ASCII

# significant digits of a coefficient, whose interval is rarely narrower than 1 %; None: all digits
DIGITS: int | None = 4
LARGEST = 1e9  # Largest value of a constant other than the noise, in any unit
_LONGEST = 2000  # longest comment [characters]; the YAML reader of OpenCV had a buffer of 4096 per line
# pattern of numbers, because float() also accepts 9_8 and digits of other alphabets
_NUMBER = r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?"


def digits(value: float, significant: int | None = None) -> str:
    """Format a number for YAML 1.1: so that it reads back to the same bits, or with a number of significant digits.
    Raises `DataError` for a value that is not finite, or too small for full precision.
    """
    double = _written(float(value), value, "double")
    text = repr(double if significant is None else float(f"{double:.{significant}g}"))
    if "e" in text:
        mantissa, exponent = text.split("e")
        mantissa = mantissa if "." in mantissa else f"{mantissa}.0"
        sign = exponent[0] if exponent[0] in "+-" else "+"
        return f"{mantissa}e{sign}{exponent.lstrip('+-')}"
    return text


def measured(value: float) -> str:
    """Format a coefficient with its significant digits."""
    return digits(value, DIGITS)


def comment(words: str) -> str:
    """Convert text for a comment: printable ASCII without line ends, with options in words."""
    words = worded(words) if MARK_BEGIN in words else words
    for character, plain in ASCII.items():
        words = words.replace(character, plain)
    text = "".join(c if " " <= c <= "~" else "?" for c in words)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 4]} ..."


def remark(words: str) -> str:
    """A comment line."""
    return f"# {comment(words)}"


def with_head(content: str, ending: str, sentences: Iterable[str]) -> str:
    """Add sentences as comments at the head of a file; unchanged if the format has no comments."""
    if ending == ".json":
        return content
    marks = {".m": ("% ", ""), ".sdf": ("<!-- ", " -->"), ".txt": ("", "")}
    before, after = marks.get(ending, ("# ", ""))
    lines = (comment(sentence) for sentence in sentences)
    if ending == ".sdf":  # an XML comment must not contain two hyphens
        lines = (re.sub("--+", "-", line) for line in lines)
    head = "".join(f"{before}{line}{after}\n" for line in lines) + ("\n" if ending == ".txt" else "")
    first = re.match(r"%YAML.*\n|<\?xml.*\n", content)  # a line that must be the first line of a file
    cut = first.end() if first else 0
    return content[:cut] + head + content[cut:]


def number_with_comment(value: float, words: str) -> str:
    """Format a YAML number with its unit and origin in a comment."""
    return f"{measured(value)}  # {comment(words)}"


def joined(words: Iterable[str]) -> str:
    """Join the comments on several numbers; identical texts appear once."""
    return comment(" | ".join(dict.fromkeys(words)))


def quoted(text: str) -> str:
    """Quote a string in ASCII so that JSON, YAML and the jsondecode of MATLAB read it."""
    return json.dumps(text, ensure_ascii=True)


def plain_name(text: str, key: str) -> str:
    """Check a name that is written without quotes. Raises `OptionError` unless it has only letters, digits and ``_ . / ~
    -``.
    """
    if not re.fullmatch(r"[A-Za-z0-9_./~-]{1,255}", text, flags=re.ASCII):
        raise OptionError(
            f"{{option}} {key}={text[:80]!r}: only letters, digits, _ . / ~ and - are allowed", option="name"
        )
    return text


def topic(text: str) -> str:
    """Quote a ROS topic. Raises `OptionError` for an invalid name, because YAML readers support different escapes."""
    if not re.fullmatch(r"[A-Za-z0-9_~/]{1,255}", text):
        raise OptionError(
            f"{{option}} topic={text[:80]!r}: a topic has only letters, digits, _ and /, e.g. topic=/imu0",
            option="name",
        )
    return f'"{text}"'


def number(text: str, key: str, *, low: float = 0.0, high: float = LARGEST) -> float:
    """Read a number that the user gave as a name. Raises `OptionError` unless it is from `low` to `high`."""
    value = float(text) if re.fullmatch(_NUMBER, text, flags=re.ASCII) else math.nan
    if not low <= value <= high:
        raise OptionError(
            f"{{option}} {key}={text!r}: want a {'positive ' * (low > 0)}number from {low:g} to {high:g}",
            option="name",
        )
    return value


def single(value: float, name: str) -> str:
    """Format a number in single precision without an exponent, as autopilots store a parameter.

    Raises a `DataError` with the name of the parameter for a value that is out of range of single precision.
    """
    with np.errstate(over="ignore", under="ignore"):
        rounded = np.float32(value if DIGITS is None else f"{value:.{DIGITS}g}")
    _written(float(rounded), value, "single", f"{name}: ", float(np.finfo(np.float32).tiny))
    return np.format_float_positional(rounded, unique=True, trim="0")


def _written(
    stored: float, value: float, precision: str, name: str = "", smallest: float = sys.float_info.min
) -> float:
    """Value that a file stores. Raises `DataError` if it is infinite, or too small for full precision."""
    if not math.isfinite(stored) or (value and abs(stored) < smallest):
        raise DataError(
            f"{name}{value:.3g} cannot be written in {precision} precision, where it is {stored:.3g}: check the units of the"
            " model, the factors and the rate"
        )
    return stored


def vector(values: Iterable[float]) -> str:
    """``[1.0, 2.0, 3.0]``, as YAML, Python and MATLAB read it."""
    return f"[{', '.join(map(measured, values))}]"
