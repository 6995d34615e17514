r"""Regular expressions for the unit in the path of a log, ``(SN\d+)``, which cannot run for hours.

The time of an expression that repeats a repetition, ``(a+)+``, doubles with each character of a path. Such expressions are
refused, and so are paths that are longer than those of file systems.
"""

from __future__ import annotations

import re
from pathlib import PurePath

from sigmatau.errors import DataError, OptionError

FOLDER, LOG_FOLDER = "folder", "log-folder"
"""Words in place of an expression: the folder of the result, or of its log."""

_LONGEST_PATH = 1000  # largest number of characters of a path in which a unit is searched
_SHOWN = 60  # number of characters of a file name in the message about a longer path
_MOST_REPEATS = 4  # largest number r of variable repetitions: the time grows at most with the power r + 1 of the length
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
    """Find a repeated group with a repetition or alternatives inside; None if there is none."""
    starts: list[int] = []  # opening parentheses of the groups that are open
    variable: list[bool] = [False]  # whether the length of the whole expression, and of each open group, is variable
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
            k += 3 if text[k + 1 : k + 2] == "?" else 1  # the question mark of (?:…) is not a repetition
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
