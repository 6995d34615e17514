r"""Regular expressions for the unit in the path of a log, ``(SN\d+)``, which cannot run for hours.

An expression with a repetition of a repetition, ``(a+)+``, takes a time that doubles with each character of a path. Such an
expression is refused, and so is a path that is longer than any file system needs.
"""

from __future__ import annotations

import re
from pathlib import PurePath

from sigmatau.errors import DataError, OptionError

FOLDER, LOG_FOLDER = "folder", "log-folder"
"""Words in place of an expression: the folder of the result, or of its log."""

_LONGEST_PATH = 1000  # characters of a path in which a unit is searched
_SHOWN = 60  # characters of such a path that are shown
_MOST_REPEATS = 4  # largest number of variable repetitions: the time is at most this power of the length, and one more
_VARIABLE = re.compile(r"[*+?]|\{\d*,\d*\}")  # a repetition whose number is not fixed
_REPETITION = re.compile(r"[*+?]|\{\d+(?:,\d*)?\}|\{,\d+\}")
_CLASS = re.compile(r"\[\^?\]?(?:\\.|[^\]\\])*\]", re.DOTALL)


def check_unit_pattern(text: str | None, words: tuple[str, ...] = (FOLDER, LOG_FOLDER)) -> None:
    """Raise `OptionError` for an expression that is not valid, has no group, or repeats a repetition.

    Examples
    --------
    >>> check_unit_pattern("(SN[0-9]+)")
    >>> check_unit_pattern("(a+)+$")
    Traceback (most recent call last):
    ...
    sigmatau.errors.OptionError: `unit_from` '(a+)+$' repeats a repetition, which may take hours; write (a+) once
    """
    if text is None or text in words:
        return
    listed = ", ".join(words)
    try:
        groups = re.compile(text).groups
    except (re.error, RecursionError, OverflowError) as error:
        raise OptionError(
            f"{{option}} {text!r:.60} must be {listed} or a regular expression: {error}", option="unit_from"
        ) from None
    if groups < 1:
        raise OptionError(
            f"{{option}} {text!r:.60} must be {listed}, or a regular expression with a group, e.g. '(SN[0-9]+)'",
            option="unit_from",
        )
    repeated = _repeated_repetition(text)
    if repeated is not None:
        raise OptionError(
            f"{{option}} {text!r:.60} repeats a repetition, which may take hours; write {repeated:.30} once",
            option="unit_from",
        )
    if len(_VARIABLE.findall(_CLASS.sub("x", re.sub(r"\\.", "x", text)))) > _MOST_REPEATS:
        raise OptionError(
            f"{{option}} {text!r:.60} has more than {_MOST_REPEATS} repetitions; shorten it, e.g. '(SN[0-9]+)'",
            option="unit_from",
        )


def unit_in_path(pattern: str, path: str) -> str:
    """The first group of an expression in a path; empty if it does not occur. Raises `DataError` for a long path."""
    if len(path) > _LONGEST_PATH:
        name = PurePath(path).name[:_SHOWN]
        raise DataError(f"its path has more than {_LONGEST_PATH} characters; move it to a shorter path").about(name)
    match = re.search(pattern, path)
    return (match[1] or "") if match else ""


def _repeated_repetition(text: str) -> str | None:
    """A group of an expression that is repeated and has a repetition or alternatives inside; None without one."""
    starts: list[int] = []  # opening parentheses of the groups around a place
    variable: list[bool] = [False]  # whether the length of each of these groups, and of the whole, is variable
    k = 0
    while k < len(text):
        if text[k] == "\\":
            k += 2
            continue
        if text[k] == "[" and (bracket := _CLASS.match(text, k)):
            k = bracket.end()
            continue
        if text[k] == "(":
            starts.append(k)
            variable.append(False)
            k += 3 if text[k + 1 : k + 2] == "?" else 1  # the question mark of (?:…) is no repetition
            continue
        if text[k] == ")" and starts:
            start, inside = starts.pop(), variable.pop()
            repeat = _REPETITION.match(text, k + 1)
            if inside and repeat is not None and repeat[0] not in ("?", "{0}", "{1}"):
                return text[start : k + 1]
            variable[-1] |= inside
        elif text[k] == "|" or _VARIABLE.match(text, k):
            variable[-1] = True
        k += 1
    return None
